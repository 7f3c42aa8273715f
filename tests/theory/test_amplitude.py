"""Averaging of the amplitude: where it is exact, where it is averaging of an oscillator, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.theory import NotCoveredError, averaging, averaging_amplitude, exact, linear
from springpot.theory.result import MOMENTS

WHITE = sp.WhiteNoise(2.0)


def differ(found, true) -> list[str]:
    return [
        n for n in MOMENTS if getattr(found, n) != pytest.approx(getattr(true, n), rel=1e-9, abs=1e-12, nan_ok=True)
    ]


@pytest.mark.parametrize("walls", [(), (sp.Barrier(0.0),), (sp.Barrier(0.0, free_side="below"),)])
def test_dashpots_are_exact_in_any_hardening_well(walls) -> None:
    springs = sp.Mass(0.5), sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 3.0, 0.0, 0.2))
    system = sp.System(*springs, sp.Dashpot(0.3), *walls, WHITE)
    found, true = averaging_amplitude(system), exact(system)
    assert differ(found, true) == []
    x = np.array([-1.2, -0.3, 0.0, 0.4, 1.5])
    assert found.x_density(x) == pytest.approx(true.x_density(x), rel=1e-9)
    assert found.warnings == ()


@pytest.mark.parametrize(("order", "coefficient"), [(0.2, 1.0), (0.5, 0.3), (1.0, 0.1)])
@pytest.mark.parametrize("walls", [(), (sp.Barrier(0.0, 0.8),), (sp.Barrier(0.0, free_side="below"),)])
def test_a_linear_spring_has_the_averaging_of_an_oscillator(order, coefficient, walls) -> None:
    system = sp.System(sp.Spring(4.0), sp.Springpot(order, coefficient), *walls, WHITE)
    shifted = averaging(system, form="shifted")
    assert differ(averaging_amplitude(system), shifted) == []


def test_light_damping_is_exact_in_the_limit() -> None:
    """The error is of first order in C."""

    def error(c: float) -> float:
        system = sp.System(sp.Spring(1.0), sp.Springpot(0.5, c), WHITE)
        return averaging_amplitude(system).v_mean_square / linear(system).v_mean_square - 1.0

    assert error(0.01) / error(0.001) == pytest.approx(10.0, rel=0.03)
    assert abs(error(0.001)) < 2e-4


@pytest.mark.validation  # every day: springs that harden, in this file
def test_a_springpot_on_a_spring_without_a_linear_part() -> None:
    found = averaging_amplitude(sp.System(sp.PolynomialSpring((0.0, 0.0, 3.0)), sp.Springpot(0.3, 0.4), WHITE))
    whole = integrate.quad(lambda a: found.amplitude_density(a), 0.0, 8.0, points=[1.0, 2.0])[0]
    square = integrate.quad(lambda x: x * x * found.x_density(x), -8.0, 8.0, points=[-2.0, 0.0, 2.0])[0]
    assert whole == pytest.approx(1.0, rel=1e-7)
    assert square == pytest.approx(found.x_mean_square, rel=1e-7)
    assert np.isnan(found.amplitude_mean_square)  # there is no Omega
    w = found.frequency(2.0)
    assert found.damping(2.0) == pytest.approx(0.4 * np.sin(0.15 * np.pi) * w**-0.7, rel=1e-12)
    with pytest.raises(ValueError, match="amplitude must be positive"):
        found.frequency([1.0, 0.0])


@pytest.mark.parametrize(
    ("part", "why"),
    [
        (sp.Barrier(-0.1), "not barrier at -0.1 m"),
        (sp.Constant(0.1), "not constant"),
        (sp.PolynomialSpring((0.0, 0.1, 1.0)), "even powers"),
        (sp.PolynomialSpring((0.0, 0.0, -0.1, 0.0, 1.0)), "soften"),
        (sp.ColoredNoise(1.0, 0.3), "not colored_noise"),
        (sp.PolynomialDashpot((0.0, 0.1)), "the nonlinear polynomial_dashpot"),
    ],
)
def test_what_it_does_not_cover(part, why: str) -> None:
    with pytest.raises(NotCoveredError, match=why):
        averaging_amplitude(sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.1), WHITE, part))


def test_without_a_stationary_state() -> None:
    for parts, why in (((WHITE,), "nothing dissipates"), ((sp.Dashpot(1.0),), "nothing excites")):
        assert why in str(averaging_amplitude(sp.System(sp.Spring(1.0), *parts)).stationary)
    assert "no spring" in str(averaging_amplitude(sp.System(sp.Dashpot(1.0), WHITE)).stationary)
