"""One-dimensional diffusion: what is known exactly of the energy of a linear oscillator, at every time."""

import math

import numpy as np
import pytest
from scipy import integrate

from springpot.theory.numerics.energy_diffusion import FirstPassage, make_energy_diffusion
from tests.sizes import validation


def linear(cells=160):
    """J with stationary density e^-J and D = J: the mean relaxes at rate 1 and the modes have rates 0, 1, 2, ..."""
    edges = np.r_[0.0, np.geomspace(1e-3, 40.0, cells)]
    action = (edges[1:] + edges[:-1]) / 2.0
    mass = np.exp(-edges[:-1]) - np.exp(-edges[1:])
    return make_energy_diffusion(action, mass, np.exp(-action))


def exact_passage(level):
    """Mean time from 0 to the level: int_0^level (e^y - 1) / y dy."""
    return integrate.quad(lambda y: math.expm1(y) / y, 0.0, level)[0]


def test_rates_are_those_of_the_laguerre_modes():
    rates, vectors = linear().modes
    assert rates[:4] == pytest.approx([0.0, 1.0, 2.0, 3.0], rel=0.03, abs=1e-12)
    assert vectors.T @ vectors == pytest.approx(np.eye(rates.size), abs=1e-9)


def test_mean_from_rest_is_the_exact_exponential():
    cells = linear()
    t = np.array([0.1, 0.5, 1.0, 3.0, math.inf])
    mean = cells.from_rest(t) @ cells.action
    assert mean == pytest.approx(-np.expm1(-t), rel=0.01)


def test_probability_is_kept_and_stays_positive():
    probability = linear().from_rest(np.geomspace(1e-6, 1e6, 40))
    assert np.abs(probability.sum(axis=1) - 1.0).max() < 1e-12
    assert probability.min() >= 0.0


def test_stationary_state_is_kept_to_rounding():
    cells = linear()
    assert cells.from_rest(np.array([math.inf]))[0] == pytest.approx(cells.mass, rel=1e-9, abs=1e-14)


def test_at_time_zero_everything_is_in_the_lowest_cell():
    assert linear().from_rest(np.array([0.0]))[0, 0] == pytest.approx(1.0, abs=1e-6)


def test_spectrum_of_the_action_is_its_slowest_mode():
    cells = linear()
    rates, squares = cells.spectrum(cells.action)
    assert squares.sum() == pytest.approx(1.0, rel=0.01)
    assert squares[0] / squares.sum() == pytest.approx(1.0, abs=2e-3)
    assert rates[0] == pytest.approx(1.0, rel=5e-3)


@pytest.mark.parametrize("level", [0.5, 2.0, 6.0, 12.0])
def test_first_passage_against_the_exact_mean_time(level):
    assert linear().first_passage(level).mean_time == pytest.approx(exact_passage(level), rel=0.01)


@pytest.mark.parametrize("level", [validation(0.5), 4.0])
def test_survival_falls_from_one_to_zero_and_its_area_is_the_mean_time(level):
    passage = linear().first_passage(level)
    t = np.linspace(0.0, 40.0 * passage.mean_time, 100_001)
    survival = passage.survival(t)
    assert survival[0] == pytest.approx(1.0, abs=1e-9)
    assert np.all(np.diff(survival) <= 1e-12)
    assert passage.survival(math.inf) == pytest.approx(0.0, abs=1e-12)
    assert integrate.trapezoid(survival, t) == pytest.approx(passage.mean_time, rel=1e-3)


def test_refining_the_cells_gains_accuracy():
    errors = [abs(linear(cells).first_passage(3.0).mean_time / exact_passage(3.0) - 1.0) for cells in (40, 160)]
    assert errors[1] < errors[0] / 4.0


def test_cells_without_weight_are_left_out():
    cells = make_energy_diffusion(np.array([1.0, 2.0, 3.0]), np.array([1.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0]))
    assert cells.action.size == 2


def test_bad_input():
    with pytest.raises(ValueError, match="increasing"):
        make_energy_diffusion(np.array([2.0, 1.0]), np.ones(2), np.ones(2))
    with pytest.raises(ValueError, match="negative"):
        make_energy_diffusion(np.array([1.0, 2.0]), np.array([1.0, -1.0]), np.ones(2))
    with pytest.raises(ValueError, match="level"):
        linear().first_passage(1e9)
    with pytest.raises(ValueError, match="time"):
        FirstPassage(1.0, np.ones(1), np.ones(1)).survival(-1.0)
