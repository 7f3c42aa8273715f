"""One physical system, stated as one mass and as one of two that do not touch: what a run says of it is the same."""

from functools import cache
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.designing.sensitivities import sensitivity
from springpot.simulation import Run
from springpot.simulation.monte_carlo import simulated
from tests.sizes import validation

RUN: dict[str, Any] = {
    "paths": 4096, "step": 0.01, "duration": 60.0, "window": (20.0, 60.0), "start": "rest", "distributions": True,
    "threads": 1,
}  # fmt: skip


def parts(*walls: tuple[float, Any, str | None], at: str = "") -> list[Any]:
    ends: dict[str, Any] = {"between": ("ground", at)} if at else {}
    on: dict[str, Any] = {"on": at} if at else {}
    own = [sp.Mass(1.0, **({"at": at} if at else {})), sp.Spring(1.0, **ends), sp.Dashpot(0.3, **ends)]
    return [*own, sp.WhiteNoise(1.0, **on), *(sp.Barrier(place, r, side, **ends) for place, r, side in walls)]


def alone(*walls: tuple[float, Any, str | None]) -> sp.System:
    return sp.System(*parts(*walls))


def beside(*walls: tuple[float, Any, str | None]) -> sp.System:
    """The same mass, called box, and another that nothing ties to it."""
    return sp.System(*parts(*walls, at="box"), *parts(at="free"))


@cache
def both(*walls: tuple[float, Any, str | None]) -> tuple[Run, Run]:
    given = RUN | {"step": 0.004} if walls[0][0] == 5.0 else RUN  # which resolves the hops on a wall so pressed
    return simulated(alone(*walls), **given), simulated(beside(*walls), **given)


def kinds(run: Run) -> set[str]:
    """Of its warnings; that of one wall is that of some wall."""
    return {message.name.removesuffix("_of_some_wall") for message in run.warnings}


@pytest.mark.parametrize(
    ("wall", "wanted"),
    [
        ((0.0, 0.5, None), {"slow_impacts", "slow_impact_quantiles"}),
        ((0.5, 0.5, "above"), {"slow_impacts", "slow_impact_quantiles"}),
        validation((5.0, 0.5, "above"), {"slow_impacts", "slow_impact_quantiles", "pressed_wall"}),
        ((-30.0, 0.5, None), {"far_wall"}),
        ((0.0, 1.0, None), set()),
    ],
)
def test_a_run_warns_of_the_same(wall: tuple[float, float, str | None], wanted: set[str]) -> None:
    one, two = both(wall)
    assert kinds(one) == kinds(two) == wanted


def test_a_narrow_gap_rattles_in_both() -> None:
    walls = ((-0.02, 0.9, None), (0.02, 0.9, None))
    given = RUN | {"paths": 64, "step": 0.001, "duration": 8.0, "window": (4.0, 8.0)}
    one, two = (kinds(simulated(make(*walls), **given)) for make in (alone, beside))
    assert "chatter" in one
    assert "chatter" in two


@pytest.mark.parametrize(
    "wall", [(0.0, 0.5, None), (0.5, 0.5, "above"), validation((0.0, sp.PowerRestitution(0.5, 0.1), None))]
)
def test_bounds_on_what_the_step_does_are_the_same(wall: tuple[float, Any, str | None]) -> None:
    """Of quantiles and densities of the impact speed, and of the largest speed; sampling makes them differ a little."""
    one, two = (run.step_biases for run in both(wall))
    names = {
        "impact_speed_quantile": "barrier_impact_speed_quantile",
        "impact_speed_density": "barrier_impact_speed_density",
        "v_largest_quantile": "box_v_largest_quantile",
    }  # fmt: skip
    assert {*one} == {*names}
    assert {*two} == {*names.values(), "free_v_largest_quantile"}
    np.testing.assert_allclose(two["box_v_largest_quantile"], one["v_largest_quantile"])
    np.testing.assert_allclose(
        two["barrier_impact_speed_quantile"][1:5], one["impact_speed_quantile"][1:5], rtol=0.15, atol=0.002
    )
    assert one["impact_speed_quantile"][1] > 0.01


def test_they_hold_for_several_masses() -> None:
    """The lowest quantiles of the speed of impacts on a wall, against those of a step sixteen times shorter."""
    _, run = both((0.0, 0.5, None))
    fine = simulated(beside((0.0, 0.5, None)), **RUN | {"paths": 1024, "step": 0.01 / 16})
    coarse, better = (each.to_dict() for each in (run, fine))
    name = "barrier_impact_speed_quantile"
    (at, exact), (error, own) = (
        [np.array(each[f"{name}{end}"], dtype=float)[:4] for each in (coarse, better)] for end in ("", "_se")
    )
    bias = np.array(coarse[f"{name}_step_bias"], dtype=float)[:4]
    assert (at / exact)[1] > 1.2  # a 1 % quantile that is a fifth too high or more
    assert np.all(np.abs(at - exact) < 4.0 * np.hypot(error, own) + bias)


def test_the_sentence_names_the_wall() -> None:
    _, two = both((0.0, 0.5, None))
    (sentence,) = (each for each in two.warnings if each.name == "slow_impact_quantiles")
    assert "these quantiles of the impact speed of barrier are wrong: " in sentence
    assert "barrier_impact_speed_quantile_step_bias bounds the error" in sentence


def test_unlike_walls_of_one_mass_have_the_bound_of_the_lossier_one() -> None:
    unlike, worse = ((-0.3, 0.8, None), (0.3, 0.5, None)), ((-0.3, 0.5, None), (0.3, 0.5, None))
    given = RUN | {"paths": 1024}
    one, other = (simulated(alone(*walls), **given) for walls in (unlike, worse))
    assert "slow_impact_quantiles" in kinds(one)
    bias, most = (run.step_biases["impact_speed_quantile"][1] for run in (one, other))
    assert 0.2 * most < bias < 1.5 * most


def test_sensitivities_say_it_of_both() -> None:
    for ends in ({}, {"between": ("ground", "box")}):
        free = sp.Dashpot(sp.free("c", 0.01, (0.001, 0.1)), **ends)
        model = sp.System(free, *(beside if ends else alone)((0.0, 0.5, None)).parts)
        found = sensitivity(model, "barrier_impact_rate", method="monte_carlo", paths=64, duration=20.0)
        assert any("slower than the step resolves" in sentence for sentence in found.warnings), ends
