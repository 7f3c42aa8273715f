"""The rate of first passages and what follows from it: intervals that cover samples, a lattice and long runs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.simulation import PassageTimes, simulate
from springpot.simulation.paths.statistics import binomial_interval, poisson_interval
from springpot.simulation.watch.passage_rates import uniformity
from tests.sizes import validation

Floats = np.ndarray[Any, np.dtype[np.float64]]


def watched(times: Floats, horizon: float, settling: float) -> PassageTimes:
    return PassageTimes("x", 1.0, math.nan, "m", 0.0, horizon, settling, np.where(times > horizon, np.inf, times))


def test_intervals_of_counts_are_exact() -> None:
    """Clopper and Pearson's are those of SciPy; Garwood's leave 2.5 % of Poisson's law on each side."""
    low, high = binomial_interval(np.arange(13), 12)
    for k in range(1, 12):
        known = scipy.stats.binomtest(k, 12).proportion_ci(0.95, "exact")
        assert (low[k], high[k]) == pytest.approx((known.low, known.high))
    assert (low[0], high[12], high[0]) == (0.0, 1.0, 1.0 - low[12])
    assert (1.0 - high[0]) ** 12 == pytest.approx(math.exp(-3.0))
    for count in (1, 7, 200):
        ends = poisson_interval(count)
        assert scipy.stats.poisson.sf(count - 1, ends[0]) == pytest.approx(0.025)
        assert scipy.stats.poisson.cdf(count, ends[1]) == pytest.approx(0.025)


@pytest.mark.parametrize("number", [5, 50])
def test_the_test_refuses_as_often_as_it_says(number: int) -> None:
    """Uniform samples: its p-values are uniform."""
    samples = np.sort(np.random.default_rng(number).random((2000, number)), axis=1)
    found = np.array([uniformity(sample) for sample in samples])
    assert scipy.stats.kstest(found, "uniform").pvalue > 1e-3
    assert 0.002 < np.mean(found < 0.01) < 0.02
    assert found[0] == pytest.approx(scipy.stats.cramervonmises(samples[0], "uniform").pvalue, abs=0.02)
    assert uniformity(0.2 * np.sort(samples.ravel())) < 1e-6


@pytest.mark.parametrize(("paths", "horizon"), [(200, 8.0), (60, 60.0), (200, 0.6)])
def test_intervals_cover_the_rate_of_samples(paths: int, horizon: float) -> None:
    """Passages at a constant rate of 0.05 after a dead time, few and many of them; probabilities beyond too."""
    generator, dead, rate = np.random.default_rng(paths), 0.05 * horizon, 0.05
    found = [watched(dead + generator.exponential(1.0 / rate, paths), horizon, 2.0 * dead) for _ in range(400)]
    assert np.mean([each.rate.since == 2.0 * dead for each in found]) > 0.97
    assert len(found) - np.isfinite([each.rate.value for each in found]).sum() <= 4
    covered = [each.rate.low <= rate <= each.rate.high for each in found]
    assert 0.93 <= np.mean(covered) <= 0.985
    exact = -math.expm1(-rate * (3.0 * horizon - dead))
    beyond = [each.probability(3.0 * horizon) for each in found]
    assert 0.93 <= np.mean([each.low <= exact <= each.high for each in beyond]) <= 0.99
    values, errors = np.array([(each.value, each.error) for each in beyond if math.isfinite(each.value)]).T
    assert values.std() == pytest.approx(errors.mean(), rel=0.25)


def test_a_rate_that_changes_is_not_given() -> None:
    """Passages whose rate grows with time; and one whose first part is faster, which is left out."""
    generator = np.random.default_rng(3)
    growing = watched(20.0 * np.sqrt(generator.exponential(1.0, 4000)), 20.0, 2.0)
    assert math.isnan(growing.rate.value)
    assert growing.rate.statement.startswith("the rate of passages still changes after 8 s (p = ")
    assert math.isnan(growing.return_period.value)
    beyond = growing.probability(100.0)
    assert (beyond.high, math.isnan(beyond.value)) == (1.0, True)
    assert beyond.statement.startswith("80 s of 100 s lie beyond the run, and the rate of passages still changes")
    assert 0.6 < beyond.low < growing.probability(20.0).value == np.mean(growing.times <= 20.0)
    early = generator.random(4000) < 0.2
    times = np.where(early, generator.exponential(1.0, 4000), generator.exponential(50.0, 4000))
    found = watched(times, 30.0, 1.0).rate
    assert found.since in (4.0, 8.0)
    assert abs(found.value - 0.02) < 3.0 * found.error
    assert f"after {found.since:g} s, which are left out" in found.statement


def test_what_was_never_seen_has_a_bound() -> None:
    nothing = watched(np.full(200, np.inf), 50.0, 5.0)
    assert (nothing.rate.value, nothing.rate.low, nothing.rate.high) == (0.0, 0.0, pytest.approx(3.0 / 200.0 / 45.0))
    assert 1.959964 * nothing.rate.error == pytest.approx(nothing.rate.high)
    assert (nothing.return_period.low, nothing.return_period.value) == (pytest.approx(3000.0), math.inf)
    within, beyond = nothing.probability(50.0), nothing.probability(3600.0)
    assert (within.value, within.low) == (0.0, 0.0)
    assert within.high == pytest.approx(1.0 - math.exp(-3.0 / 200.0))
    assert (beyond.value, beyond.low) == (0.0, 0.0)
    assert 0.65 < beyond.high < 0.72  # 1 - exp(-3 x 3600 / (200 x 50)) = 0.66
    assert str(nothing.rate) == "at most 0.00033 s-1 with 95 %"
    assert str(nothing.return_period) == "at least 3e+03 s with 95 %"
    assert str(beyond).startswith("at most 0.")


@pytest.mark.parametrize(
    ("times", "settling", "sentence"),
    [
        (np.full(100, np.inf), 30.0, "constant at the earliest after 30 s: use a run of twice that time."),
        (np.full(100, np.inf), math.inf, "the motion has no stationary state"),
        (np.full(100, 1.0), 10.0, "no path is left after the start whose passages could be counted: use a higher l"),
    ],
)
def test_a_rate_that_is_not_known_says_why(times: Floats, settling: float, sentence: str) -> None:
    found = watched(times, 50.0, settling)
    assert math.isnan(found.rate.value)
    assert sentence in found.rate.statement
    assert str(found.rate).startswith("not known: ")


def test_noise_that_ends_has_no_constant_rate() -> None:
    ending = sp.WhiteNoise(1.0, envelope=sp.JenningsHousnerEnvelope(2.0, 10.0, 0.5))
    shaken = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.3), ending, sp.Barrier(-1e3, 0.8))  # with a kernel of others
    run = simulate(shaken, paths=64, duration=60.0, start="rest", step=0.05, first_passage={"x": [1.5, 9.0]})
    for passage in run.first_passages["x"]:
        assert math.isnan(passage.rate.value)
        assert "has no stationary state" in passage.probability(100.0).statement


@pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, math.inf, "long"])
def test_a_wrong_duration_is_refused_in_one_sentence(wrong: Any) -> None:
    with pytest.raises((TypeError, ValueError), match="duration must be"):
        watched(np.ones(4), 2.0, 1.0).probability(wrong)


DASHPOT = sp.Oscillator(springpot=sp.Springpot(1.0, 0.1), barrier=None, excitation=sp.WhiteNoise(0.2))
"""Of unit variance and a damping ratio of 0.05."""


def test_a_stationary_run_has_the_probabilities_of_a_lattice() -> None:
    """Level 3.2, from the backward equation on a lattice: P within 10, 20 and 40 s, and the rate from them."""
    passage = simulate(
        DASHPOT, paths=20_000, duration=240.0, window=(120.0, 240.0), step=0.05, first_passage={"x": 3.2}
    ).first_passages["x"]
    for duration, known in ((10.0, 0.00935), (20.0, 0.01667), (40.0, 0.03084)):
        found = passage.probability(duration)
        assert abs(found.value - known) < 3.0 * found.error
        assert (found.statement, found.low < known < found.high) == ("", True)
    assert passage.rate.error < 0.04 * 7.26e-4
    assert abs(passage.rate.value - 7.26e-4) < 3.0 * passage.rate.error


PATHS, RUNS = 128, 200


@pytest.mark.parametrize(
    ("wall", "start", "order"), [validation(wall, start, order) for wall in (False, True) for start, order in
                                 (("rest", 0.5), ("stationary", 0.5), ("rest", 1.0))]
)  # fmt: skip
def test_intervals_cover_the_rate_of_a_long_run(wall: bool, start: str, order: float) -> None:
    """Of 200 runs at least 90 %, and at most 98 % where there are 20 events or more; levels of 2, 3 and 4 standard
    deviations.  The paths of one run of 200 times as many are those of 200 runs."""
    problem = sp.Oscillator(
        springpot=sp.Springpot(order, 0.3), barrier=sp.Barrier(-0.3, 0.8) if wall else None,
        excitation=sp.WhiteNoise(0.6),
    )  # fmt: skip
    moments = simulate(problem, paths=4000, duration=400.0, step=0.05)
    mean = moments["x_mean"].value if wall else 0.0
    deviation = math.sqrt(moments["x_mean_square"].value - mean**2)
    given: dict[str, Any] = {"step": 0.05, "start": start}
    given["first_passage"] = {"x": [mean + times * deviation for times in (2, 3, 4)]}
    window = {"duration": 260.0, "window": (60.0, 260.0)} if start == "stationary" else {"duration": 200.0}
    many = simulate(problem, paths=PATHS * RUNS, seed=11, **window, **given).first_passages["x"]
    long = simulate(problem, paths=20_000, duration=2000.0, seed=5, **given).first_passages["x"]
    for one, reference in zip(many, long, strict=True):
        runs = [replace(one, times=times).rate for times in one.times.reshape(RUNS, PATHS)]
        assert reference.rate.error < 0.035 * reference.rate.value
        covered = np.mean([run.low <= reference.rate.value <= run.high for run in runs])
        assert covered >= 0.9, (one.level, covered)
        if np.mean([run.events for run in runs]) >= 20.0:
            assert covered <= 0.98, (one.level, covered)


@pytest.mark.validation
def test_five_minutes_tell_the_probability_in_an_hour() -> None:
    """Runs of 64 paths of five minutes, beside paths of an hour; with a wall, at levels passed in an hour or so."""
    problem = sp.Oscillator(
        springpot=sp.Springpot(0.5, 0.3), barrier=sp.Barrier(-0.3, 0.8), excitation=sp.WhiteNoise(0.6)
    )
    given: dict[str, Any] = {"step": 0.05, "start": "rest", "first_passage": {"x": [3.7, 4.2]}}
    short = simulate(problem, paths=64 * RUNS, duration=300.0, seed=3, **given).first_passages["x"]
    hour = simulate(problem, paths=4000, duration=3600.0, seed=4, **given).first_passages["x"]
    for one, whole in zip(short, hour, strict=True):
        known = whole.probability(3600.0)
        assert 0.1 < known.value < 0.9
        assert known.error < 0.01
        found = [replace(one, times=times).probability(3600.0) for times in one.times.reshape(RUNS, 64)]
        assert 0.9 <= np.mean([each.low <= known.value <= each.high for each in found]) <= 0.995
        assert all(each.statement.startswith("3.3e+03 s of 3.6e+03 s lie beyond the run") for each in found)
