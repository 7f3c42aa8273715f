"""A simulation made once: the kernel's units, what may be changed later, and its start."""

import numpy as np
import pytest

import springpot as sp
from springpot.problem.catalogue import possible_results
from springpot.simulation.estimate.samples import errors_of_the_start
from springpot.simulation.lowering.compose import compose
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import Adapted, plan_of

PARTS = sp.Spring(9.0), sp.Springpot(0.6, 0.4), sp.WhiteNoise(70.0)
PROBLEM = sp.System(*PARTS, sp.Barrier(-0.2, 0.8))
SHORT = {"paths": 64, "duration": 2.0, "step": 0.02, "seed": 3, "record": 2, "start": "rest"}


@pytest.mark.parametrize(("side", "start"), [("above", 0.7), ("below", -0.9)])
def test_a_state_comes_back_from_the_kernel_as_it_went_in(side: str, start: float) -> None:
    problem = sp.System(*PARTS, sp.Barrier(-0.2, 0.8, free_side=side))  # type: ignore[arg-type]
    simulation = simulation_of(plan_of(problem, **SHORT, initial_position=start, initial_velocity=-1.3))
    parts = simulation.parts
    assert simulation.motion.signals[0].place == -0.2
    assert (parts.start * parts.units.state).tolist() == [[start, -1.3]]
    found = simulation.advance()
    np.testing.assert_array_equal(found.record[:, 0], [[start, -1.3]] * 2)
    sums = parts.sums(found.rows)
    np.testing.assert_array_equal(sums["x_end", "mass"][:2], found.record[:, -1, 0])
    np.testing.assert_array_equal(sums["v_end", "mass"][:2], found.record[:, -1, 1])


def test_fewer_paths_of_the_same_simulation_are_its_first() -> None:
    simulation = simulation_of(plan_of(PROBLEM, **SHORT))
    fewer = simulation.but(paths=5)
    assert fewer.parts is simulation.parts
    np.testing.assert_array_equal(fewer.advance().rows, simulation.advance().rows[:5])


def test_a_stationary_start_must_be_known_before_the_kernel_is_composed() -> None:
    plan = plan_of(PROBLEM, paths=64, start="stationary")
    assert plan.settings.initial_position is None
    with pytest.raises(ValueError, match="initial_position of a stationary start"):
        compose(plan)
    simulation = simulation_of(plan.started_at(Adapted(0.3, None, None, None, 0)))
    assert simulation.settings.initial_position == 0.3
    values = dict.fromkeys(possible_results(PROBLEM), 1.0)
    assert set(errors_of_the_start(simulation.plan, values).values()) == {0.0}
