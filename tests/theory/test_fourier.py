"""The series of |cos p| and its integrals, against mpmath."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from springpot.theory import fourier

ALPHAS = [0.0, 1e-9, 0.05, 0.3, 0.5, 0.7, 0.95, 0.999999]
PHASES = [*np.geomspace(1e-6, 1e6, 37), 11.999, 12.001]


def reference(phase: float, alpha: float) -> complex:
    """int_0^z e^(iu) u^-alpha du with 30 digits."""
    with mpmath.workdps(30):
        z, a = mpmath.mpf(float(phase)), mpmath.mpf(float(alpha))
        return complex(mpmath.exp(0.5j * mpmath.pi * (1 - a)) * mpmath.gammainc(1 - a, 0, -1j * z))


@pytest.mark.parametrize("m", [1, 2, 3, 10])
def test_coefficients_are_the_fourier_integrals(m):
    a_m = (
        -2
        / math.pi
        * float(mpmath.quad(lambda p: abs(mpmath.cos(p)) * mpmath.cos(2 * m * p), [0, mpmath.pi / 2, mpmath.pi]))
    )
    assert fourier.coefficients(m)[-1] == pytest.approx(a_m, rel=1e-12)


@pytest.mark.parametrize("terms", [0, 1, 2, 10, 500])
def test_bound_is_reached_at_a_quarter_turn_and_nowhere_exceeded(terms):
    bound = fourier.truncation_bound(terms)
    assert float(fourier.truncation_error(math.pi / 2, terms)) == pytest.approx(bound, rel=1e-11)
    assert np.max(np.abs(fourier.truncation_error(np.linspace(0, 7, 2001), terms))) <= bound * (1 + 1e-12)


@given(st.floats(-50, 50), st.integers(0, 60))
def test_series_is_even_periodic_and_within_its_bound(phase, terms):
    value = float(fourier.partial_sum(phase, terms))
    assert value == pytest.approx(float(fourier.partial_sum(-phase, terms)), abs=1e-13)
    assert value == pytest.approx(float(fourier.partial_sum(phase + math.pi, terms)), abs=1e-11)
    assert abs(value - abs(math.cos(phase))) <= fourier.truncation_bound(terms) + 1e-12


def test_series_keeps_the_shape():
    assert fourier.partial_sum(np.zeros((2, 3)), 4).shape == (2, 3)
    assert fourier.partial_sum(0.0, 4).shape == ()


@pytest.mark.parametrize("alpha", ALPHAS)
def test_exact_integrals_against_mpmath(alpha):
    z = np.array(PHASES)
    exact = np.array([reference(phase, alpha) for phase in z])
    for value, truth in (
        (fourier.cosine_integral(1.0, z, alpha), exact.real),
        (fourier.sine_integral(1.0, z, alpha), exact.imag),
    ):
        # both have zeros at large phase, where the size to compare with is that of their oscillation
        size = np.where(z < 1.0, np.abs(truth), np.maximum(np.abs(truth), z**-alpha))
        assert np.max(np.abs(value - truth) / size) < 2e-13


def test_sine_integral_at_order_one_is_si():
    z = np.array(PHASES)
    truth = np.array([float(mpmath.si(phase)) for phase in z])
    np.testing.assert_allclose(fourier.sine_integral(1.0, z, 1.0), truth, rtol=2e-13)
    np.testing.assert_allclose(fourier.sine_integral(3.0, 1e9, 1.0), math.pi / 2, rtol=1e-9)
    assert float(fourier.sine_integral(2.0, 1e9, 1.0, form="asymptotic")) == pytest.approx(math.pi / 2, rel=1e-8)


def test_cosine_integral_diverges_at_order_one():
    with pytest.raises(ValueError, match="diverges at alpha = 1"):
        fourier.cosine_integral(1.0, 1.0, 1.0)


def test_elementary_limits_at_order_zero():
    t = np.array([0.1, 3.0, 40.0])
    np.testing.assert_allclose(fourier.cosine_integral(2.0, t, 0.0), np.sin(2 * t) / 2, atol=1e-14)
    np.testing.assert_allclose(fourier.sine_integral(2.0, t, 0.0), (1 - np.cos(2 * t)) / 2, atol=1e-14)


@given(st.floats(0.01, 100), st.floats(0.01, 100), st.floats(0, 0.99))
def test_units_scale_with_the_wavenumber(k, t, alpha):
    for integral in (fourier.cosine_integral, fourier.sine_integral):
        scaled = k ** (alpha - 1) * float(integral(1.0, k * t, alpha))
        assert float(integral(k, t, alpha)) == pytest.approx(scaled, rel=1e-9, abs=1e-12 * t ** (1 - alpha))


@pytest.mark.parametrize("alpha", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("integral", [fourier.cosine_integral, fourier.sine_integral])
def test_asymptotic_error_falls_as_stated(integral, alpha):
    z = np.array([100.3, 1003.0, 10030.0])
    error = np.abs(integral(1.0, z, alpha, form="asymptotic") - integral(1.0, z, alpha))
    assert np.all(error <= alpha * z ** -(1 + alpha))


@pytest.mark.parametrize("integral", [fourier.cosine_integral, fourier.sine_integral])
@pytest.mark.parametrize(
    ("arguments", "words", "message"),
    [
        ((-1.0, 1.0, 0.5), {}, "positive and finite"),
        ((1.0, [1.0, 0.0], 0.5), {}, "positive and finite"),
        ((1.0, math.inf, 0.5), {}, "positive and finite"),
        ((1.0, 1.0, 1.5), {}, "alpha must be in"),
        ((1.0, 1.0, 0.5), {"form": "series"}, "'exact' or 'asymptotic'"),
    ],
)
def test_integrals_refuse(integral, arguments, words, message):
    with pytest.raises(ValueError, match=message):
        integral(*arguments, **words)


def test_terms_are_counted():
    with pytest.raises(TypeError, match="integer"):
        fourier.partial_sum(0.0, 2.0)
    with pytest.raises(ValueError, match="at least 0"):
        fourier.truncation_bound(-1)
    assert fourier.coefficients(np.int64(3)).shape == (3,)
