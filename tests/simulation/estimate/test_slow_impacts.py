"""What the step misses of slow impacts, and what a run says of it, against the Fokker-Planck equation at order 1."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.simulation import Run, simulate
from springpot.simulation.estimate.slow_impacts import (
    density_step_bias,
    quantile_step_bias,
    slow_impacts,
)
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.struck import StruckWalls, missed_impacts, slow_impact_order
from springpot.simulation.result.results import PROBABILITIES
from springpot.theory.mckean import slow_impact_power
from tests.simulation.problems import oscillator
from tests.sizes import thinned, validation

STEP = 0.01
LOSSY = [(0.5, 0.0), (0.3, 0.0), (0.5, -1.0), (0.5, 0.5)]


@cache
def observed(restitution: float, position: float) -> Run:
    problem = oscillator(1.0, 0.3, position=position, restitution=restitution)
    return simulate(
        problem, paths=4096, step=STEP, duration=75.0, window=(15.0, 75.0), distributions=True, start="rest", threads=1
    )


def walls(restitution: float, position: float) -> StruckWalls:
    return plan_of(oscillator(1.0, 0.3, position=position, restitution=restitution)).motion.struck


@cache
def truth(restitution: float, position: float) -> tuple[np.ndarray, np.ndarray]:
    """Speeds, and the exact share of the impacts that are slower."""
    found = sp.theory.fokker_planck(oscillator(1.0, 0.3, position=position, restitution=restitution))
    speed = np.geomspace(1e-12, 14.0, 6000)
    density = found.impact_speed_density(speed)
    below = integrate.cumulative_trapezoid(density * speed, np.log(speed), initial=0.0)
    below += density[0] * speed[0] / slow_impact_power(restitution)
    return speed, below / below[-1]


@pytest.mark.parametrize(("restitution", "position"), thinned(LOSSY, 2))
def test_quantiles_of_the_impact_speed_say_what_the_step_does_to_them(restitution: float, position: float) -> None:
    """The 1 % quantile is six to fifty standard errors too high; with its step bias each interval holds the truth."""
    found, (speed, below) = observed(restitution, position).to_dict(), truth(restitution, position)
    exact = np.interp(PROBABILITIES, below, speed)
    at, error, bias = (
        np.array(found[f"impact_speed_quantile{part}"], dtype=float) for part in ("", "_se", "_step_bias")
    )
    gap = at - exact
    assert gap[1] > 5.0 * error[1]
    assert np.all(np.abs(gap) < 4.0 * error + bias)
    low = slice(0, 4)
    assert np.all(bias[low] < 1.7 * gap[low] + 3.0 * error[low])  # and says little more


@pytest.mark.parametrize(("restitution", "position"), [(0.5, 2.0), validation(0.3, 1.0)])
def test_behind_a_preload_the_lowest_may_be_too_low(restitution: float, position: float) -> None:
    """A step longer than `extrapolation_step` ends in chattering, whose impacts are slower than those under noise."""
    found, (speed, below) = observed(restitution, position).to_dict(), truth(restitution, position)
    at, error, bias = (
        np.array(found[f"impact_speed_quantile{part}"], dtype=float) for part in ("", "_se", "_step_bias")
    )
    gap = at - np.interp(PROBABILITIES, below, speed)
    assert np.all(np.abs(gap) < 4.0 * error + bias)
    exact = sp.theory.fokker_planck(oscillator(1.0, 0.3, position=position, restitution=restitution))
    for name in ("impact_rate", "impact_speed_mean", "impact_speed_mean_square"):
        off = abs(found[name] - getattr(exact, name))
        assert off < 3.0 * found[f"{name}_se"] + found[f"{name}_step_bias"], name


@pytest.mark.parametrize(("restitution", "position"), LOSSY)
def test_so_does_their_density(restitution: float, position: float) -> None:
    sketch, (speed, below) = observed(restitution, position).distributions["impact_speed"], truth(restitution, position)
    missed = slow_impacts(walls(restitution, position), STEP, sketch)
    assert missed is not None
    edges, density, error = sketch.density()
    bias = density_step_bias(missed, edges, density)
    gap = density - np.diff(np.interp(edges, speed, below)) / np.diff(edges)
    assert np.all((np.abs(gap) < 4.0 * error + bias)[:50])
    assert (np.abs(gap) > 4.0 * error).any()


@pytest.mark.parametrize(("restitution", "position"), LOSSY)
def test_rate_and_mean_speeds_too(restitution: float, position: float) -> None:
    found = observed(restitution, position).to_dict()
    exact = sp.theory.fokker_planck(oscillator(1.0, 0.3, position=position, restitution=restitution))
    for name in ("impact_rate", "impact_speed_mean", "impact_speed_mean_square"):
        gap = abs(found[name] - getattr(exact, name))
        assert gap < 3.0 * found[f"{name}_se"] + found[f"{name}_step_bias"], name
    assert "amplitude_mean_square_step_bias" not in found


@pytest.mark.parametrize(("restitution", "position"), LOSSY)
def test_the_impacts_missed_by_speed_are_those_missed_in_all(restitution: float, position: float) -> None:
    """The run's own slow impacts tell the share as the mean square speed does, within what is said of both."""
    found = observed(restitution, position)
    missed = slow_impacts(walls(restitution, position), STEP, found.distributions["impact_speed"])
    assert missed is not None
    told = missed_impacts(walls(restitution, position), STEP, found["impact_speed_mean_square"].value)
    exact = sp.theory.fokker_planck(found.system).impact_rate / found["impact_rate"].value - 1.0
    assert missed.share == pytest.approx(exact, rel=0.3, abs=3.0 * found["impact_rate"].error / 0.4)
    assert told / (1.0 - told) == pytest.approx(missed.share, rel=0.8)
    assert missed.power == pytest.approx(2.0 * slow_impact_order(restitution))


def test_shorter_steps_leave_less() -> None:
    sketch = observed(0.5, 0.0).distributions["impact_speed"]
    biases = []
    for step in (0.04, 0.01, 0.0025):
        missed = slow_impacts(walls(0.5, 0.0), step, sketch)
        assert missed is not None
        biases.append(quantile_step_bias(missed, sketch, (0.05, 0.5)))
    assert np.all(biases[0] > biases[1])
    assert np.all(biases[1] > biases[2])


def test_a_sentence_names_the_quantiles() -> None:
    (sentence,) = (line for line in observed(0.5, 0.0).warnings if "these quantiles" in line)
    assert sentence.startswith("the step of 0.01 s misses slow impacts, so these quantiles of the impact speed are")
    assert "1 % (by up to 7" in sentence
    assert "99 %" not in sentence
    assert "shorter step" in sentence
    assert not any("these quantiles" in line for line in _elastic().warnings)


def test_an_elastic_wall_misses_none() -> None:
    found = _elastic().to_dict()
    assert found["impact_rate_step_bias"] == found["impact_speed_mean_step_bias"] == 0.0
    np.testing.assert_allclose(found["impact_speed_quantile_step_bias"], 0.0, atol=1e-12)


def test_numbers_without_slow_impacts_have_no_such_bound() -> None:
    given: dict[str, Any] = {"paths": 16, "duration": 5.0, "start": "rest", "memory_tolerance": 1e-9}
    quiet = simulate(oscillator(1.0, 0.3, intensity=0.0), distributions=True, **given).to_dict()
    assert "impact_speed_quantile_step_bias" not in quiet
    collapsed = simulate(
        oscillator(1.0, 0.3, restitution=0.1), paths=16, duration=5.0, start="rest", distributions=True
    ).to_dict()
    assert "impact_speed_quantile_step_bias" not in collapsed
    assert "impact_rate_step_bias" not in collapsed
    free = simulate(
        oscillator(1.0, 0.3, position=None), paths=16, duration=5.0, start="rest", distributions=True
    ).to_dict()
    assert "impact_rate_step_bias" not in free


def test_files_and_tables_have_the_bounds() -> None:
    found = observed(0.5, 0.0)
    data = found.to_xarray()
    assert data["impact_speed_quantile_step_bias"].dims == ("probability",)
    assert data["impact_speed_quantile_step_bias"].units == "m s-1"
    assert data["impact_speed_density_step_bias"].dims == data["impact_speed_density"].dims
    assert float(data["impact_rate_step_bias"]) == found.to_dict()["impact_rate_step_bias"] > 0.0
    assert "x_quantile_step_bias" not in data


@cache
def _elastic() -> Run:
    return simulate(
        oscillator(1.0, 0.3, position=-0.5), paths=2048, step=STEP, duration=60.0, window=(20.0, 60.0), start="rest",
        distributions=True, threads=1,
    )  # fmt: skip


def test_a_path_that_strikes_has_been_at_the_wall() -> None:
    """At the ends of the steps it never is: the least x lay above the wall by what a step covers."""
    found = observed(0.5, 0.0)
    struck = ~np.isnan(found.extremes["impact_speed_largest"])
    assert struck.mean() > 0.99
    np.testing.assert_allclose(found.extremes["x_minimum"][struck], 0.0, atol=1e-12)
    below = simulate(
        sp.Oscillator(barrier=sp.Barrier(position=0.5, restitution=0.9, free_side="below")), paths=32, duration=60.0,
        start="rest", distributions=True,
    )  # fmt: skip
    struck = ~np.isnan(below.extremes["impact_speed_largest"])
    np.testing.assert_allclose(below.extremes["x_maximum"][struck], 0.5, rtol=1e-6)
    assert struck.any()


def test_the_largest_speed_says_what_lies_between_the_steps() -> None:
    problem = oscillator(1.0, 0.3, position=-0.5)
    coarse, fine = (
        simulate(
            problem, paths=6144, step=step, duration=60.0, window=(20.0, 60.0), start="rest", distributions=True,
            threads=1,
        ).to_dict()
        for step in (0.04, 0.0025)
    )  # fmt: skip
    at, error, bias = (np.array(coarse[f"v_largest_quantile{part}"], dtype=float) for part in ("", "_se", "_step_bias"))
    low = np.array(fine["v_largest_quantile"]) - at
    both = np.hypot(error, np.array(fine["v_largest_quantile_se"], dtype=float))
    assert low[4] > 5.0 * both[4]
    assert np.all((low < bias + 4.0 * both)[2:7])


def test_the_largest_speed_is_no_less_than_that_of_an_impact() -> None:
    extremes = observed(0.5, 0.0).extremes
    struck = ~np.isnan(extremes["impact_speed_largest"])
    assert np.all(extremes["v_largest"][struck] >= extremes["impact_speed_largest"][struck])
