"""Rates of exceedance: against a lattice, Monte Carlo, integrals of SciPy's, and cases that are alike."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.theory import NotCoveredError
from tests.sizes import validation

DASHPOT = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
"""Of unit variance and a damping ratio of 0.05."""


def test_the_formulas_are_those_of_the_books() -> None:
    """Probabilities within 20 s, whose exact values are 1.65e-2 and 3.09e-5; a lattice's rate at 3.2 is 7.26e-4."""
    found = sp.theory.exceedance(DASHPOT, {"x": [3.2, 4.8], "distance": [3.2]})
    one, both = found["x"], found["distance"]
    assert one.bandwidth == pytest.approx(0.2456, abs=5e-5)
    assert one.crossing_rate == pytest.approx(0.5 / math.pi)
    within = one.probability(20.0)
    np.testing.assert_allclose(within["rice"], [1.97e-2, 3.24e-5], rtol=2e-3)
    np.testing.assert_allclose(within["vanmarcke"], [1.54e-2, 2.90e-5], rtol=2e-3)
    assert one.rate["vanmarcke"][0] == pytest.approx(7.4e-4, rel=2e-3)
    assert one.rate["envelope"][0] == pytest.approx(7.26e-4, rel=0.02)
    np.testing.assert_allclose(one.at_start, [6.871e-4, 7.933e-7], rtol=1e-3)
    # the formulas as they are printed, from b, the rate of crossings and the bandwidth
    b, nu, spread = 3.2, one.crossing_rate, one.bandwidth**1.2
    clumped = (1.0 - math.exp(-math.sqrt(math.pi / 2.0) * spread * b)) / (1.0 - math.exp(-0.5 * b * b))
    assert both.rate["vanmarcke"][0] == pytest.approx(2.0 * nu * math.exp(-0.5 * b * b) * clumped)
    assert both.rate["rice"][0] == 2.0 * one.rate["rice"][0]
    assert both.return_period["rice"][0] == 1.0 / both.rate["rice"][0]
    assert both.at_start[0] == 2.0 * one.at_start[0]
    assert set(one.measured) == {"rice", "vanmarcke", "envelope"}


def test_moments_are_integrals_of_the_spectrum() -> None:
    pot = sp.System(sp.Spring(2.0), sp.Springpot(0.5, 0.6), sp.WhiteNoise(0.3))
    response, found = sp.theory.linear(pot), sp.theory.exceedance(pot, {"x": 1.0})["x"]

    def moment(order: int) -> float:
        values = [
            integrate.quad(lambda w: 2.0 * float(response.spectrum(w)) * w**order, low, high, limit=500)[0]
            for low, high in ((0.0, 1.5), (1.5, 3.0), (3.0, 30.0), (30.0, math.inf))
        ]
        return sum(values)

    m0, m1, m2 = map(moment, range(3))
    assert found.bandwidth == pytest.approx(math.sqrt(1.0 - m1**2 / (m0 * m2)), rel=1e-4)
    assert found.crossing_rate == pytest.approx(math.sqrt(m2 / m0) / (2.0 * math.pi), rel=1e-5)


def test_sides_and_several_masses() -> None:
    """A push moves the mean; on one side only it is the same level from there; uncoupled masses are alone."""
    pushed = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2), sp.Constant(0.5))
    found = sp.theory.exceedance(pushed, {"x": [3.7, -2.7], "distance": 3.2})
    known = sp.theory.exceedance(DASHPOT, {"x": [3.2, 2.7, 3.7]})["x"]
    for name in ("rice", "vanmarcke"):
        assert found["x"].rate[name] == pytest.approx([known.rate[name][0]] * 2)
        assert found["distance"].rate[name] == pytest.approx(known.rate[name][1] + known.rate[name][2])
    pair = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"),
        mount=sp.Spring(1.0, between=("ground", "a")), other=sp.Spring(3.0, between=("ground", "b")),
        damper=sp.Dashpot(0.1, between=("ground", "a")), more=sp.Dashpot(0.3, between=("ground", "b")),
        shake=sp.WhiteNoise(0.2, on="a"), push=sp.WhiteNoise(0.1, on="b"),
    )  # fmt: skip
    several = sp.theory.exceedance(pair, {"a_x": 3.2, "mount_elongation": 3.2, "mount_distance": 3.2})
    alone = sp.theory.exceedance(DASHPOT, {"x": 3.2, "distance": 3.2})
    for name in ("rice", "vanmarcke"):
        assert several["a_x"].rate[name] == pytest.approx(float(alone["x"].rate[name]))
        assert several["mount_elongation"].rate[name] == pytest.approx(float(alone["x"].rate[name]))
        assert several["mount_distance"].rate[name] == pytest.approx(float(alone["distance"].rate[name]))
    assert "envelope" not in several["a_x"].rate


@pytest.mark.parametrize(
    ("order", "c", "one", "both"),
    [
        # per cent that Vanmarcke's rate is above Monte Carlo's at 3 standard deviations, on one side and on both
        validation(1.0, 0.1, 5.4, 0.0), validation(0.5, 0.1, 11.8, 6.8), validation(0.5, 0.3, -2.6, -11.3),
        validation(0.2, 0.1, 38.2, 34.5),
    ],
)  # fmt: skip
def test_the_errors_of_the_formulas_are_those_of_the_table(order: float, c: float, one: float, both: float) -> None:
    noise = sp.WhiteNoise(2.0 * c * math.sin(order * math.pi / 2.0))
    problem = sp.Oscillator(springpot=sp.Springpot(order, c), barrier=None, excitation=noise)
    level = 3.0 * math.sqrt(sp.theory.linear(problem).x_mean_square)
    levels = {"x": level, "distance": level}
    found = sp.theory.exceedance(problem, levels)
    run = sp.simulate(problem, paths=12_000, duration=2000.0, step=0.05, start="rest", seed=8, first_passage=levels)
    for name, off in (("x", one), ("distance", both)):
        rate = run.first_passages[name].rate
        assert rate.error < 0.015 * rate.value
        for formula, per_cent, room in (("vanmarcke", off, 0.0), ("envelope", 0.0, 0.03)):
            gap = found[name].rate[formula] / rate.value - 1.0
            assert abs(gap - 0.01 * per_cent) < 3.5 * rate.error / rate.value + room, (name, formula)


@pytest.mark.parametrize(
    ("levels", "sentence"),
    [
        ([3.0], "levels must be a dict of names and levels"),
        ({}, "levels must be a dict of names and levels"),
        ({"speed": 1.0}, "levels must be of x, distance, not 'speed'"),
        ({"x": []}, "levels of x must not be empty."),
        ({"x": [1.0, math.nan]}, "level of x must be"),
        ({"distance": -1.0}, "level of distance must be"),
        ({"x": 0.0}, "level of x must lie off the mean, 0 m."),
    ],
)
def test_wrong_levels_are_refused_in_one_sentence(levels: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match="level") as caught:
        sp.theory.exceedance(DASHPOT, levels)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_not_gaussian_is_not_covered() -> None:
    for part in (sp.Barrier(0.0), sp.Harmonic(1.0, 2.0), sp.PolynomialSpring((0.0, 0.0, 1.0))):
        with pytest.raises(NotCoveredError):
            sp.theory.exceedance(sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2), part), {"x": 1.0})


@pytest.mark.parametrize(
    ("push", "name"), [(0.0, "x"), (0.5, "distance"), validation(0.0, "distance"), validation(0.5, "x")]
)
def test_the_level_of_a_probability_has_it(push: float, name: str) -> None:
    """By each formula, above the mean and on both sides, also where the mean is not 0."""
    pressed = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2), sp.Constant(push))
    system = pressed if push else DASHPOT
    found = sp.theory.exceedance_level(system, {name: [1e-3, 1e-9]}, 20.0)[name]
    assert {"rice", "vanmarcke"} <= {*found.level}
    for formula, levels in found.level.items():
        back = sp.theory.exceedance(system, {name: levels})[name].probability(20.0)[formula]
        np.testing.assert_allclose(back, [1e-3, 1e-9], rtol=2e-3, err_msg=formula)
    assert (found.level["rice"] >= found.level["vanmarcke"]).all()


@pytest.mark.parametrize(
    ("probability", "sentence"),
    [
        ({}, "probability must be a dict"), (1e-6, "probability must be a dict"),
        ({"x": 0.6}, "probability of x must be in"), ({"y": 0.1}, "probability must be of"),
        ({"x": "rare"}, "probability of x must be a real number"),
    ],
)  # fmt: skip
def test_a_probability_that_is_none_is_said(probability: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        sp.theory.exceedance_level(DASHPOT, probability, 20.0)


def test_where_the_level_would_be_next_to_the_mean_nothing_is_found() -> None:
    with pytest.raises(ValueError, match="probability of x must be at most that of a level next to the mean"):
        sp.theory.exceedance_level(DASHPOT, {"x": 0.5}, 1e-3)
