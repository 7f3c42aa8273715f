"""A mount chosen for a limit on the force that it transmits."""

from __future__ import annotations

import pytest

import springpot as sp
from springpot.designing.quantities import sampled_run
from springpot.simulation.plan.plan import plan_of
from springpot.theory import linear


def device(*more: object) -> sp.System:
    mount = sp.Springpot(0.25, sp.free("c", 1.0, (0.2, 8.0)))
    return sp.System(sp.Mass(2.0), sp.Spring(8.0), *more, mount=mount, shaking=sp.WhiteNoise(1.0, on="ground"))


def test_the_softest_mount_that_transmits_little() -> None:
    limit = {"force_on_ground_mean_square": (None, 45.0)}
    found = sp.design(device(), minimize="c", subject_to=limit, rtol=0.05, cost_rtol=0.1, seed=2)
    assert found.method == "linear"
    exact = linear(found.model).mean_square("force_on_ground")
    assert 40.0 < exact < 45.0
    assert found.promises[0].probability > 0.98
    (name,) = limit
    assert abs(found.quantities[name] - exact) < 3.5 * found.errors[name] + 0.01 * exact


def test_short_runs_of_a_design_have_forces() -> None:
    system = device(sp.Barrier(-0.1, 0.8))
    plan = plan_of(system, paths=64, duration=20.0, seed=1, start="rest", step=0.02)
    found = sampled_run(plan, forces=("mount_force",)).samples["mount_force_mean_square"]
    run = sp.simulate(system, paths=64, duration=20.0, seed=1, start="rest", step=0.02, forces=("mount_force",))
    assert found[0] == run["mount_force_mean_square"].value


def test_a_force_that_has_no_value_cannot_be_limited() -> None:
    pushed = sp.System(sp.Mass(2.0), sp.Spring(sp.free("k", 8.0, (4.0, 16.0))), sp.Dashpot(1.0), sp.WhiteNoise(1.0))
    with pytest.raises(ValueError, match=r"subject_to must limit results among .* not acceleration_mean_square"):
        sp.design(pushed, minimize="k", subject_to={"acceleration_mean_square": (None, 1.0)})


@pytest.mark.validation  # every day: a design with a limit on a force, above; rtol of forces, in simulation/watch
def test_a_limit_that_is_far_away_does_not_move_a_design() -> None:
    """The force on a soft stop is uncertain by what the step does to it, which pairs of runs measure."""
    stop = sp.Contact.linear(-sp.free("gap", 1.0, (0.5, 2.0)), 2000.0, dissipation=0.3)
    box = sp.System(sp.Mass(1.0), sp.Spring(4.0), sp.Springpot(0.4, 0.5), stop, sp.WhiteNoise(1.0, on="ground"))
    rare = {"impact_rate": (None, 0.05)}
    given: dict[str, float] = {"rtol": 0.1, "cost_rtol": 0.03}
    alone = sp.design(box, "gap", rare, **given)
    both = sp.design(box, "gap", rare | {"acceleration_mean_square": (None, 60.0)}, **given)
    assert both.values["gap"] == pytest.approx(alone.values["gap"], rel=0.03)
    assert both.errors["acceleration_mean_square"] < 0.1 * both.quantities["acceleration_mean_square"] < 3.0
    assert [promise.probability > 0.99 for promise in both.promises] == [True, True]
