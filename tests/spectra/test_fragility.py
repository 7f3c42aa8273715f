"""Fragility: intervals that hold, capacities that are known, and rare probabilities."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.special import ndtr

import springpot as sp
from springpot.spectra.fragility import _fit_of_capacities
from springpot.spectra.lognormal import Fit, fit_cloud, fit_counts
from tests.spectra.test_response import several

MEDIAN, DISPERSION = 1.5, 0.4
Rng = np.random.Generator


def of_counts(rng: Rng) -> Fit:
    intensity, tried = np.linspace(0.6, 3.0, 8), np.full(8, 40.0)
    return fit_counts(intensity, rng.binomial(40, ndtr(np.log(intensity / MEDIAN) / DISPERSION)).astype(float), tried)


def of_capacities(rng: Rng) -> Fit:
    intensity = np.linspace(0.6, 3.0, 8)
    return _fit_of_capacities(intensity, MEDIAN * rng.lognormal(0.0, DISPERSION, 44) < intensity[:, None])


def of_cloud(rng: Rng) -> Fit:
    intensity = rng.lognormal(0.0, 0.6, 44)
    demand = 0.1 * (intensity / MEDIAN) ** 1.3 * rng.lognormal(0.0, 1.3 * DISPERSION, 44)
    return fit_cloud(intensity, demand, 0.1)[0]


@pytest.mark.validation
@pytest.mark.parametrize("fitted", [of_counts, of_capacities, of_cloud])
def test_intervals_of_median_and_dispersion_hold_in_90_to_98_of_100(fitted: Callable[[Rng], Fit]) -> None:
    """Of 300 synthetic sets, so that the share is known to 1.3 %."""
    rng, held = np.random.default_rng(7), np.zeros(2)
    for _ in range(300):
        found = fitted(rng)
        held += [
            found.median.low < MEDIAN < found.median.high,
            found.dispersion.low < DISPERSION < found.dispersion.high,
        ]
    assert ((held >= 0.9 * 300) & (held <= 0.98 * 300)).all(), held / 300


@pytest.mark.parametrize("fitted", [of_counts, of_capacities, of_cloud])
def test_a_fit_finds_the_law_within_its_interval(fitted: Callable[[Rng], Fit]) -> None:
    """Of ten sets; the errors by curvature are about a quarter of the intervals."""
    rng, held = np.random.default_rng(1), 0
    for _ in range(10):
        found = fitted(rng)
        held += found.median.low < MEDIAN < found.median.high
        assert (found.median.high - found.median.low) / found.median.error == pytest.approx(4.0, abs=0.7)
        low, high = found.band(np.array([MEDIAN]))
        assert low < found.probability(np.array([MEDIAN])) < high
    assert held >= 8


def linear(record: sp.RecordedExcitation) -> sp.System:
    return sp.System(sp.Mass(1.0), sp.Spring(40.0), sp.Dashpot(0.6), record)


def test_capacities_of_a_linear_system_are_limit_over_demand() -> None:
    record = several(24, 600)
    demand = sp.response_spectrum(
        record, [2.0 * math.pi / math.sqrt(40.0)], damping=0.3 / math.sqrt(40.0), output="displacement"
    )["displacement"].values[0]
    peaks = np.array([max(map(abs, values)) for _, values in record.records])
    capacities = 0.02 * peaks / demand
    stripes = np.geomspace(0.8 * capacities.min(), 1.25 * capacities.max(), 24)
    curve = sp.fragility(linear(record), {"displacement": 0.02}, stripes)["displacement"]
    assert curve.kind == "capacities"
    np.testing.assert_array_equal(curve.exceeded, (capacities < stripes[:, None]).sum(axis=1))
    logs = np.log(capacities)
    assert curve.median.value == pytest.approx(math.exp(logs.mean()), rel=0.01)
    assert curve.dispersion.value == pytest.approx(logs.std(), rel=0.05)
    assert curve.probability([curve.median.value])[0] == pytest.approx(0.5)


@pytest.mark.validation  # every day: capacities are limit over demand, above
def test_a_cloud_and_a_measure_of_ones_own() -> None:
    """With the pseudo-acceleration at its own period a linear system has no dispersion left, nearly."""
    rng = np.random.default_rng(2)
    t, values = several(30, 600).time, several(30, 600).values
    strong = sp.RecordedExcitation(
        t, tuple(tuple(f * np.array(own)) for f, own in zip(rng.lognormal(0.0, 0.5, 30), values, strict=True))
    )  # fmt: skip
    period, ratio = 2.0 * math.pi / math.sqrt(40.0), 0.3 / math.sqrt(40.0)
    by_peak = sp.fragility(linear(strong), {"displacement": 0.03})["displacement"]
    by_response = sp.fragility(linear(strong), {"displacement": 0.03}, measure=(period, ratio))["displacement"]
    assert by_response.dispersion.value < 0.02 < by_peak.dispersion.value
    assert by_response.median.value == pytest.approx(0.03 * 40.0, rel=0.01)
    numbers = 2.0 * by_peak.places[0]
    doubled = sp.fragility(linear(strong), {"displacement": 0.03}, measure=numbers)["displacement"]
    assert doubled.median.value == pytest.approx(2.0 * by_peak.median.value, rel=1e-6)
    assert "30 records" in str(sp.fragility(linear(strong), {"displacement": 0.03}))


def noisy(rms: float) -> sp.System:
    return sp.System(sp.Mass(1.0), sp.Spring(40.0), sp.Dashpot(0.6), sp.WhiteNoise((0.05 * rms) ** 2, on="ground"))


def test_noise_has_stripes_of_its_own_and_several_limits() -> None:
    found = sp.fragility(
        noisy, {"displacement": [0.05, 0.06], "acceleration": 2.5}, [1.5, 2.0, 2.5, 3.0], duration=20.0, paths=256
    )
    assert [*found] == ["displacement > 0.05", "displacement > 0.06", "acceleration"]
    less, more, third = found.curves.values()
    assert less.kind == "counts"
    assert less.median.value < more.median.value
    # the response grows with the intensity: medians are in the ratio of the limits
    assert more.median.value / less.median.value == pytest.approx(1.2, rel=0.06)
    assert third.unit == "m s-2"
    data = found.to_xarray()
    assert data["share"].dims == ("curve", "intensity")
    assert found.to_dict()["curves"]["acceleration"]["limit"] == 2.5
    assert "brackets hold with 95 %" in str(found)


@pytest.mark.validation  # every day: splitting, in simulation/rare
def test_rare_probabilities_come_from_splitting() -> None:
    """Where both know it, they agree; and one law does not fit 1e-5 to 1."""
    levels, intensities = {"displacement": 0.05}, [1.3, 1.6, 1.9]
    rare = sp.fragility(noisy, levels, intensities, duration=20.0, method="splitting", rtol=0.3)["displacement"]
    share, low, high = rare.shares
    assert rare.kind == "splitting"
    assert share[0] < 1e-3 < share[2]
    often = sp.fragility(noisy, levels, [1.9, 2.2], duration=20.0, paths=2048)["displacement"]
    _, least, most = often.shares
    assert least[0] < high[2]
    assert low[2] < most[0]


def test_a_stop_under_records_has_the_speed_of_its_impacts() -> None:
    system = sp.System(*linear(several(12, 400)).parts, stop=sp.Barrier(-0.01, 0.7))
    found = sp.fragility(system, {"impact_speed": 0.05}, [1.0, 2.0, 3.0, 4.0, 6.0, 9.0])
    curve = found["impact_speed"]
    assert curve.unit == "m s-1"
    assert (np.diff(curve.exceeded) >= 0).all()
    with pytest.raises(
        ValueError, match=r"intensities must be given for impact_speed, which is 0 in \d+ of the records"
    ):
        sp.fragility(system, {"impact_speed": 0.05})


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ((noisy, {"displacement": 0.05}), "intensities must be given where system is a function"),
        ((noisy, {"displacement": 0.05}, [1.0]), "duration must be given for noise"),
        ((noisy(1.0), {"displacement": 0.05}, [1.0]), "system must have one recorded excitation"),
        ((linear(several(3, 50)), {}, [1.0]), "limits must be a dict"),
        (
            (linear(several(1, 50)), {"displacement": 0.1}, [1.0]),
            "system must have two or more records: one has a capac",
        ),
        ((linear(several(3, 50)), {"displacement": -1.0}, [1.0]), "limit of displacement must be"),
        ((linear(several(3, 50)), {"displacement": 1.0}), "intensities must be given for 3 records"),
        ((linear(several(3, 50)), {"x_max": 1.0}, [1.0]), "limits must be of displacement"),
        ((linear(several(3, 50)), {"displacement": 1e3}, [1.0]), "reach from below the limit .*no record exceeds"),
        ((linear(several(3, 50)), {"displacement": 1e-9}, [1.0]), "reach from below the limit .*all records exceed"),
    ],
)
def test_wrong_arguments_get_one_sentence(given: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        sp.fragility(*given)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"measure": "pga"}, "measure must be 'peak', a pair"),
        ({"measure": [1.0, 2.0]}, "measure must have a number for each of 3 records, not 2"),
        ({"method": "splitting"}, "method must be 'plain' where nothing is by chance"),
        ({"method": "exact"}, "method must be 'plain' or 'splitting'"),
    ],
)
def test_wrong_options_get_one_sentence(given: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        sp.fragility(linear(several(3, 50)), {"displacement": 0.1}, [1.0], **given)


def test_a_limit_that_is_never_exceeded_is_said_and_the_others_are_fitted() -> None:
    found = sp.fragility(
        noisy, {"displacement": [0.05, 5.0]}, [1.5, 2.0, 2.5, 3.0], duration=20.0, paths=128
    )  # fmt: skip
    assert [*found] == ["displacement > 0.05"]
    (sentence,) = found.warnings
    assert sentence.startswith("displacement > 5 has no curve: intensities must reach from below the limit to beyond")
    assert found.warnings[0] in str(found)


def test_points_that_follow_no_lognormal_law_are_said() -> None:
    """Half of the devices exceed the limit early, the others late."""
    fit = fit_counts(
        np.array([1.0, 2.0, 4.0, 8.0, 16.0]), np.array([2.0, 98.0, 100.0, 102.0, 198.0]), np.full(5, 200.0)
    )
    assert fit.chance < 1e-6
    likely = fit_counts(np.array([1.0, 2.0, 4.0]), np.array([16.0, 100.0, 184.0]), np.full(3, 200.0))
    assert likely.chance > 0.1
