"""A simulation made once: the kernel's units and side, what may be changed later, and its start."""

from dataclasses import replace

import numpy as np
import pytest
from springpot.simulation.plan.start import Adapted

import springpot as sp
from springpot.simulation.kernel.block import COLUMNS
from springpot.simulation.lowering.compose import compose
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.scales import scales_of
from springpot.simulation.plan.settings import resolve

PROBLEM = sp.Oscillator(
    natural_frequency=3.0,
    springpot=sp.Springpot(0.6, 0.4),
    barrier=sp.Barrier(-0.2, 0.8),
    excitation=sp.WhiteNoise(70.0),
)
SHORT = {"paths": 64, "duration": 2.0, "step": 0.02, "seed": 3, "record": 2, "start": "rest"}


@pytest.mark.parametrize("side", ["above", "below"])
def test_a_state_comes_back_from_the_kernel_as_it_went_in(side: str) -> None:
    problem = replace(PROBLEM, barrier=replace(PROBLEM.barrier, side=side))
    simulation = simulation_of(problem, resolve(problem, **SHORT, initial_velocity=-1.3))
    units = simulation.parts.units
    assert units.sign == problem.direction
    assert simulation.parts.wall_position == units.into(problem.barrier.position, 0.0)[0]
    state = np.array(units.into(0.7, -1.3)) * units.state
    assert state.tolist() == [0.7, -1.3]
    found = simulation.advance()
    np.testing.assert_array_equal(found.record[:, 0, 1], -1.3)
    np.testing.assert_array_equal(found.rows[:2, COLUMNS.index("x_end")], found.record[:, -1, 0])
    np.testing.assert_array_equal(found.rows[:2, COLUMNS.index("v_end")], found.record[:, -1, 1])


def test_fewer_paths_of_the_same_simulation_are_its_first() -> None:
    simulation = simulation_of(PROBLEM, resolve(PROBLEM, **SHORT))
    fewer = simulation.but(paths=5)
    assert fewer.parts is simulation.parts
    np.testing.assert_array_equal(fewer.advance().rows, simulation.advance().rows[:5])


def test_a_stationary_start_must_be_known_before_the_kernel_is_composed() -> None:
    settings = resolve(PROBLEM, paths=64, start="stationary")
    assert settings.initial_position is None
    with pytest.raises(ValueError, match="initial_position of a stationary start"):
        compose(PROBLEM, settings, scales_of(PROBLEM))
    simulation = simulation_of(PROBLEM, settings, Adapted(0.3, None, None, None, 0))
    assert simulation.settings.initial_position == 0.3
    values = dict.fromkeys(sp.simulation.UNITS, 1.0)
    assert set(simulation.errors_of_the_start(values).values()) == {0.0}
