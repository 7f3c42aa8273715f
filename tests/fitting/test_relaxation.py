"""Relaxation and creep: exact functions, their derivatives, and fits that find known numbers."""

import re
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy import special

import springpot as sp
from springpot.fitting.likelihood import slopes
from springpot.fitting.moduli import SteppedLikelihood, stepped
from tests.sizes import validation

TIME = np.geomspace(1e-5, 1e5, 11)
POT = sp.Springpot(0.3, 2.0)


def found(*parts: Any, creep: bool = False) -> Any:
    return stepped(sp.System(*parts), TIME, (), creep)[0]


def mittag_leffler(order: float, z: float) -> float:
    """Of a small argument, from its series."""
    with mpmath.workdps(40):
        return float(sum(mpmath.mpf(z) ** k / mpmath.gamma(order * k + 1) for k in range(200)))


@pytest.mark.parametrize("order", [0.01, 0.3, 0.5, 0.9, 0.99])
def test_a_springpot_relaxes_and_creeps_by_powers(order: float) -> None:
    pot = sp.Springpot(order, 2.0)
    np.testing.assert_allclose(found(pot), 2.0 * TIME**-order / special.gamma(1.0 - order), rtol=2e-11)
    np.testing.assert_allclose(found(pot, creep=True), TIME**order / 2.0 / special.gamma(1.0 + order), rtol=2e-11)


def test_arms_relax_by_exponentials_and_mittag_leffler_functions() -> None:
    """Of order 1/2 it is exp(z^2) erfc(z); a spring beside it is the fractional Zener model, which creeps by it too."""
    k, arm, c = 1.5, 4.0, 2.0
    zener = sp.Spring(k), sp.FractionalMaxwell(sp.Springpot(0.5, c), sp.Spring(arm))
    np.testing.assert_allclose(found(*zener), k + arm * special.erfcx(arm / c * TIME**0.5), rtol=1e-12)
    rate = k * arm / (c * (k + arm))
    crept = 1.0 / k - arm / (k * (k + arm)) * special.erfcx(rate * TIME**0.5)
    np.testing.assert_allclose(found(*zener, creep=True), crept, rtol=1e-12)
    maxwell = found(sp.Spring(k), sp.Maxwell(arm, c))
    np.testing.assert_allclose(maxwell, k + arm * np.exp(-arm / c * TIME), rtol=1e-12)
    kelvin = found(sp.Spring(k), sp.Dashpot(c), creep=True)
    np.testing.assert_allclose(kelvin, -np.expm1(-k / c * TIME) / k, rtol=1e-9)


@pytest.mark.parametrize("order", [0.4, 0.8])
def test_other_orders_against_the_series(order: float) -> None:
    arm = sp.FractionalMaxwell(sp.Springpot(order, 1.0), sp.Spring(1.0))
    for time in (0.01, 0.3, 2.0):
        own = stepped(sp.System(arm), np.array([time]), (), False)[0][0]
        assert own == pytest.approx(mittag_leffler(order, -(time**order)), rel=1e-11)


@pytest.mark.parametrize("creep", [False, True])
def test_the_derivatives(creep: bool) -> None:
    model = sp.System(
        sp.Spring(sp.free("k", 1.0, (0.1, 10.0))),
        sp.Springpot(sp.free("order", 0.4, (0.1, 0.9)), sp.free("C", 2.0, (0.1, 9.0))),
        sp.Maxwell(sp.free("k1", 3.0, (0.1, 10.0)), sp.free("c1", 0.5, (0.1, 10.0))),
    )  # fmt: skip
    time = np.geomspace(0.01, 10.0, 9)
    data = sp.MeasuredCreep(time, np.ones(9)) if creep else sp.MeasuredRelaxation(time, np.ones(9))
    own = SteppedLikelihood(model, data)
    theta = own.coordinates.outer(own.coordinates.start)
    numbers = slopes(own.expected, theta, own.coordinates.free) / own.expected(theta)[:, None]
    np.testing.assert_allclose(own.sensitivity(theta), numbers, atol=2e-8)


def zener(k: Any, order: Any, c: Any, arm: Any) -> sp.System:
    return sp.System(sp.Spring(k), sp.FractionalMaxwell(sp.Springpot(order, c), sp.Spring(arm)))


FREE = zener(
    sp.free("k", 1e5, (1e3, 1e8)), sp.free("order", 0.5, (0.05, 0.95)), sp.free("C", 1e5, (1e3, 1e8)),
    sp.free("arm", 1e6, (1e4, 1e9)),
)  # fmt: skip
TRUE = {"k": 3e5, "order": 0.35, "C": 4e5, "arm": 2e6}


def measured(creep: bool, seed: int, error: float | None = None) -> Any:
    time = np.geomspace(1e-3, 1e3, 60)
    exact = stepped(zener(*TRUE.values()), time, (), creep)[0]
    values = exact * (1.0 + 0.02 * np.random.default_rng(seed).standard_normal(60))
    return sp.MeasuredCreep(time, values, error) if creep else sp.MeasuredRelaxation(time, values, error)


@pytest.mark.parametrize("creep", [False, validation(True)], ids=["relaxation", "creep"])
def test_the_numbers_are_found(creep: bool) -> None:
    fit = sp.fit(FREE, measured(creep, 1))
    for name, value in TRUE.items():
        assert abs(fit.values[name] - value) < 4.0 * fit.errors[name]
        assert fit.errors[name] < 0.25 * value
    assert fit.extras["relative_error"] == pytest.approx(0.02, rel=0.3)
    assert f"60 {'compliances' if creep else 'relaxation moduli'}" in fit.report()
    assert sp.fit(FREE, measured(creep, 1, 0.02)).check().passed
    axes = sp.figures.plot_fit(fit).axes
    assert axes[0].get_xscale() == "log"
    assert axes[-1].get_xlabel() == "time since the step (s)"
    assert axes[0].get_ylabel() == ("creep compliance" if creep else "relaxation modulus")


@pytest.mark.validation
@pytest.mark.parametrize("creep", [False, True], ids=["relaxation", "creep"])
def test_the_intervals_hold(creep: bool) -> None:
    fits = [sp.fit(FREE, measured(creep, seed)) for seed in range(200)]
    for name, value in TRUE.items():
        held = sum(low <= value <= high for low, high in (fit.interval(name) for fit in fits))
        assert 180 <= held <= 198, (name, held)


def test_relaxation_and_moduli_agree_on_a_material() -> None:
    f = np.geomspace(1e-3, 1e3, 40)
    modulus = sum(part.modulus(2j * np.pi * f) for part in zener(*TRUE.values()).parts)
    both = [sp.fit(FREE, sp.MeasuredModuli(f, modulus.real, modulus.imag)), sp.fit(FREE, measured(False, 2))]
    for name in TRUE:
        assert abs(both[0].values[name] - both[1].values[name]) < 4.0 * both[1].errors[name]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.MeasuredRelaxation([0.0, 1.0, 2.0], [1.0, 1.0, 1.0]), "time[0] must be greater than 0"),
        (lambda: sp.MeasuredRelaxation([1.0, 1.0, 2.0], [1.0, 1.0, 1.0]), "time[1] must be later than the point"),
        (lambda: sp.MeasuredCreep([1.0, 2.0], [1.0, 1.0]), "time must have at least 3 points"),
        (lambda: sp.MeasuredCreep([1.0, 2.0, 3.0], [1.0, -1.0, 1.0]), "compliance[1] must be greater than 0"),
        (lambda: sp.MeasuredCreep([1.0, 2.0, 3.0], [1.0, 1.0, 1.0], 2.0), "relative_error must be"),
        (
            lambda: sp.fit(sp.System(POT, sp.Dashpot(sp.free("c", 1.0, (0.1, 9.0)))), measured(False, 1)),
            "c must not be free: relaxation does not depend on it.",
        ),
        (
            lambda: sp.fit(sp.PolynomialSpring((1.0, 0.0, sp.free("k", 1.0, (0.1, 9.0)))), measured(True, 1)),
            "relaxation and creep cover springs, dashpots, springpots and arms, not polynomial_spring.",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError, sp.theory.NotCoveredError), match=re.escape(sentence)):
        make()
