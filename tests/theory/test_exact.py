"""Exact answers, against independent quadrature, closed forms, limits and the identities that every answer obeys."""

import itertools
import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.theory.methods.averaging import averaging
from springpot.theory.methods.exact import Exact, exact
from springpot.theory.numerics.contours import dashpot_mean_squares, mean_squares, relaxation
from springpot.theory.result import MOMENTS, NoStationaryStateError
from tests.sizes import thinned, validation


def oscillator(alpha=1.0, coefficient=0.3, omega=1.0, q=1.0, barrier=None) -> Oscillator:
    return Oscillator(omega, Springpot(alpha, coefficient), barrier, WhiteNoise(q))


ORDERS = [0.001, 0.1, 0.3, 0.5, 0.7, 0.9, 0.999]
COEFFICIENTS = [1e-6, 0.01, 0.3, 1.0, 2.0, 10.0, 1e6]


@pytest.mark.parametrize(
    ("alpha", "c"),
    [
        validation(0.001, 0.3),
        validation(0.001, 1e6),
        (0.5, 1e-6),
        validation(0.4, 2.0),
        validation(0.9, 1e6),
        validation(0.999, 1e-6),
    ],
)
def test_moments_against_the_integral_of_the_spectrum(alpha, c):
    """mpmath along the real axis, split around the resonance; the code's contour is another one."""
    with mpmath.workdps(18):
        a, strength = mpmath.mpf(alpha), mpmath.mpf(c)

        def inverse(w):
            return 1 - w**2 + strength * (1j * w) ** a

        peak = mpmath.findroot(lambda w: inverse(w).real, max(1.0, c ** (1 / (2 - alpha))), verify=False)
        peak = abs(peak.real) if abs(peak) > 1e-3 else mpmath.mpf(1)
        width = abs(inverse(peak).imag) / (2 * peak)
        near = (peak + sign * width * 4**k for sign in (-1, 1) for k in range(-2, 26))
        cuts = sorted(
            {mpmath.mpf(0), *(w for w in near if w > 0), *(mpmath.mpf(10) ** k for k in range(-9, 8)), mpmath.inf}
        )
        x = mpmath.quad(lambda w: 1 / abs(inverse(w)) ** 2, cuts) / mpmath.pi
        v = mpmath.quad(lambda w: w**2 / abs(inverse(w)) ** 2, cuts) / mpmath.pi
    assert mean_squares(alpha, c) == pytest.approx((float(x), float(v)), rel=1e-10)


@pytest.mark.parametrize("c", COEFFICIENTS)
def test_a_dashpot_has_equipartition(c):
    assert mean_squares(1.0, c) == pytest.approx((0.5 / c, 0.5 / c), rel=1e-13)
    assert mean_squares(1.0 - 1e-9, c) == pytest.approx((0.5 / c, 0.5 / c), rel=1e-7)


@pytest.mark.parametrize(("alpha", "c"), thinned(itertools.product(ORDERS, COEFFICIENTS), 3))
def test_pole_and_cut_are_complete(alpha, c):
    """The response starts at 0 with slope 1, and the integrals of h^2, h'^2 and the correlation are the moments."""
    x, v = mean_squares(alpha, c)
    parts = relaxation(alpha, c)
    zero = np.zeros(1)
    assert math.pi / 2 < np.angle(parts.pole) < math.pi
    assert abs(float(parts.impulse_response(zero)[0])) < 1e-12
    assert 2 * (parts.residue * parts.pole).real - float(parts.response @ parts.rate) == pytest.approx(1, rel=1e-11)
    assert float(parts.correlation(zero)[0]) == pytest.approx(x, rel=1e-10)
    ends = parts.mean_squares(np.array([1e300]))
    assert [float(end[0]) for end in ends] == pytest.approx([x, v], rel=1e-10)
    np.testing.assert_allclose(np.ravel(parts.mean_squares(zero)), 0.0, atol=1e-12 * max(x, v))


@pytest.mark.parametrize(("alpha", "c"), [(0.5, 1.0), (0.3, 0.1), (0.8, 5.0)])
def test_impulse_response_against_numerical_laplace_inversion(alpha, c):
    parts = relaxation(alpha, c)
    for t in (0.05, 1.0, 7.0):
        truth = mpmath.invertlaplace(lambda s: 1 / (s**2 + c * s**alpha + 1), t, method="talbot")
        assert float(parts.impulse_response(np.array([t]))[0]) == pytest.approx(float(truth), rel=1e-8, abs=1e-12)


@pytest.mark.parametrize(("alpha", "c"), [(0.5, 1.0), (0.2, 0.02), (0.9, 3.0)])
def test_transient_is_the_integral_of_the_squared_response(alpha, c):
    asked = oscillator(alpha, c, omega=2.0, q=3.0)
    result, paper = exact(asked), Dimensionless.of(asked)
    parts = relaxation(alpha, paper.dimensionless_coefficient)
    for t in (0.3, 2.0, 11.0):
        energy = quad(lambda s: float(parts.impulse_response(np.array([s]))[0]) ** 2, 0, 2.0 * t, limit=200)[0]
        assert float(result.x_mean_square_at(t)) == pytest.approx(energy * paper.length_scale**2, rel=1e-8)
    h = 1e-4  # d<x^2>/dt = 2 <xv>, and d<v^2>/dt -> q at the start
    assert float(result.v_mean_square_at(h)) / (3.0 * h) == pytest.approx(1.0, abs=0.02)


@given(st.sampled_from([0.1, 0.5, 0.9]), st.floats(0.01, 10.0), st.floats(0.1, 20.0))
@settings(max_examples=25)
def test_correlation_is_the_transform_of_the_spectrum(alpha, c, lag):
    result = exact(oscillator(alpha, c))
    width = c / 2
    near = (1 + sign * width * 3**k for sign in (-1, 1) for k in range(5))
    cuts = sorted({0.0, *(w for w in near if 0 < w < 30), 30.0})
    total = sum(
        quad(lambda w: 2 * float(result.spectrum(w)) * math.cos(w * lag), lo, hi, limit=500, epsabs=1e-11)[0]
        for lo, hi in itertools.pairwise(cuts)
    )
    total += quad(lambda w: 2 * float(result.spectrum(w)), 30.0, math.inf, weight="cos", wvar=lag)[0]
    assert float(result.correlation(lag)) == pytest.approx(total, abs=2e-8 * max(1.0, result.x_mean_square))


@pytest.mark.parametrize("c", [0.0, 1e-6, 0.3, 1.9999, 2.0, 2.0001, 50.0])
def test_dashpot_transient_against_the_moment_equations(c):
    def rates(_, m):
        x, xv, v = m
        return [2 * xv, v - x - c * xv, -2 * xv - 2 * c * v + 1]

    times = np.array([0.0, 0.1, 1.0, 7.0])
    truth = solve_ivp(rates, (0, 7), [0, 0, 0], t_eval=times, rtol=1e-11, atol=1e-13, method="LSODA").y
    x, v = dashpot_mean_squares(c, times)
    np.testing.assert_allclose(x, truth[0], atol=1e-9)
    np.testing.assert_allclose(v, truth[2], atol=1e-9)


def test_orders_near_one_tend_to_the_dashpot():
    t = np.array([0.5, 3.0, 10.0, 1000.0])
    for c in (0.2, 2.0, 5.0):
        for near, limit in zip(relaxation(1 - 1e-5, c).mean_squares(t), dashpot_mean_squares(c, t), strict=True):
            np.testing.assert_allclose(near, limit, rtol=3e-5)
        near_correlation = relaxation(1 - 1e-5, c).correlation(t)
        np.testing.assert_allclose(near_correlation, exact(oscillator(1.0, c)).correlation(t), atol=3e-5)


@pytest.mark.parametrize("position", [-3.0, -0.5, 0.0, 0.7, 4.0])
def test_dashpot_and_wall_against_direct_integration(position):
    c, omega, q = 0.4, 1.7, 2.3
    result = exact(oscillator(1.0, c, omega, q, Barrier(position, free_side="above")))

    def weight(x):
        return math.exp(-(c * omega**2 / q) * (x * x - max(position, 0.0) ** 2))

    def integral(power):
        cuts = [position, max(position, 0.0), max(position, 0.0) + 2.0, max(position, 0.0) + 30.0]
        return sum(quad(lambda x: x**power * weight(x), lo, hi)[0] for lo, hi in itertools.pairwise(cuts))

    mass = integral(0)
    assert result.x_mean == pytest.approx(integral(1) / mass, rel=1e-9)
    assert result.x_mean_square == pytest.approx(integral(2) / mass, rel=1e-9)
    assert result.v_mean_square == pytest.approx(q / (2 * c))
    assert result.impact_rate == pytest.approx(weight(position) / mass * math.sqrt(q / (4 * math.pi * c)), rel=1e-9)
    assert float(result.x_density(position)) == pytest.approx(weight(position) / mass, rel=1e-9)


def test_dashpot_at_zero_is_the_folded_linear_oscillator():
    result, free = exact(oscillator(barrier=Barrier())), exact(oscillator())
    assert result.x_mean_square == free.x_mean_square
    assert result.x_mean == pytest.approx(math.sqrt(2 / math.pi * free.x_mean_square))
    assert result.impact_rate == pytest.approx(1 / math.pi)
    assert result.amplitude_mean_square == pytest.approx(averaging(oscillator(barrier=Barrier())).amplitude_mean_square)
    t = np.linspace(0, 30, 7)
    np.testing.assert_array_equal(result.x_mean_square_at(t), free.x_mean_square_at(t))
    np.testing.assert_allclose(result.x_mean_at(t) ** 2, 2 / math.pi * free.x_mean_square_at(t))
    both = result.x_mean_square_at(t) + result.v_mean_square_at(t)
    np.testing.assert_allclose(result.amplitude_mean_square_at(t), both)
    assert result.correlation(0.0) == pytest.approx(result.x_mean_square)
    assert result.correlation(1e4) == pytest.approx(result.x_mean**2)


@pytest.mark.parametrize("k", [5.0, 40.0, 1e4, 1e9])
def test_deep_preload(k):
    """The mass hammers the wall: x - b is exponential with mean s/k, and nothing overflows."""
    spread = math.sqrt(0.5 / 0.3)
    result = exact(oscillator(barrier=Barrier(k * spread, free_side="above")))
    with mpmath.workdps(60):
        z = mpmath.mpf(k)
        hazard = float(mpmath.npdf(z) / mpmath.ncdf(-z)) if k < 1e4 else k + 1 / k
    assert result.x_mean / spread == pytest.approx(hazard, rel=1e-12)
    assert result.impact_rate == pytest.approx(hazard / math.sqrt(2 * math.pi), rel=1e-12)
    gaps = spread / k * np.array([0.5, 3.0])
    np.testing.assert_allclose(
        result.x_density(k * spread + gaps) * spread / k, np.exp([-0.5, -3.0]), rtol=8 / k**2 + k * k * 1e-15
    )


@pytest.mark.parametrize("k", [-8.0, -30.0, -37.0])
def test_deep_gap(k):
    """Impacts become rare in proportion to exp(-k^2/2), not zero."""
    result = exact(oscillator(barrier=Barrier(k * math.sqrt(0.5 / 0.3), free_side="above")))
    assert result.impact_rate == pytest.approx(math.exp(-k * k / 2) / (2 * math.pi), rel=1e-11)
    assert result.x_mean_square == pytest.approx(exact(oscillator()).x_mean_square, rel=1e-12)


def test_a_gap_beyond_reach_is_no_wall():
    result = exact(oscillator(barrier=Barrier(-1e9)))
    assert (result.impact_rate, result.x_mean) == (0.0, 0.0)
    assert math.isnan(result.impact_speed_mean)
    assert float(result.x_density(0.0)) == pytest.approx(float(exact(oscillator()).x_density(0.0)))
    a = np.array([0.1, 1.0, 3.0])
    np.testing.assert_allclose(result.amplitude_density(a), exact(oscillator()).amplitude_density(a), rtol=1e-12)


@pytest.mark.parametrize(
    ("alpha", "c", "wall"),
    [
        (1.0, 0.3, Barrier()),
        (1.0, 0.3, Barrier(-0.8)),
        (1.0, 0.3, Barrier(1.1, free_side="above")),
        (1.0, 0.3, Barrier(0.6, free_side="below")),
        (1.0, 0.3, None),
        (0.4, 0.5, None),
        (0.1, 8.0, None),
    ],
)
def test_densities_have_the_moments(alpha, c, wall):
    result = exact(oscillator(alpha, c, 1.6, 2.0, wall))

    def moment(density, power, low=-40.0, high=40.0):
        cuts = [low, *((wall.position, -wall.position) if wall else (0.0,)), 0.0, high]
        cuts = sorted({cut for cut in cuts if low <= cut <= high})
        return sum(
            quad(lambda u: u**power * float(density(u)), lo, hi, limit=200)[0] for lo, hi in itertools.pairwise(cuts)
        )

    assert moment(result.x_density, 0) == pytest.approx(1)
    assert moment(result.x_density, 1) == pytest.approx(result.x_mean, abs=1e-9)
    assert moment(result.x_density, 2) == pytest.approx(result.x_mean_square)
    assert moment(result.v_density, 2) == pytest.approx(result.v_mean_square)
    assert moment(result.amplitude_density, 0, 0.0) == pytest.approx(1)
    assert moment(result.amplitude_density, 2, 0.0) == pytest.approx(result.amplitude_mean_square)
    energy = result.amplitude_mean_square * 1.6**2 / 2
    cut = 1.6**2 * (wall.position**2 if wall else 1.0) / 2
    assert sum(
        quad(lambda h: h * float(result.energy_density(h)), *ends, limit=200)[0]
        for ends in ((0.0, cut), (cut, 60 * energy))
    ) == pytest.approx(energy, rel=1e-6)
    assert result.joint_density(0.5, [0.2, 0.3]) == pytest.approx(
        result.x_density(0.5) * result.v_density([0.2, 0.3]),
        rel=1e-15,  # rounding, by the units of length and speed
    )
    plain = exact(oscillator(alpha, c, 1.0, 1.0, wall))
    assert (
        plain.joint_density(0.5, [0.2, 0.3]).tolist() == (plain.x_density(0.5) * plain.v_density([0.2, 0.3])).tolist()
    )
    if wall is not None:
        assert moment(result.impact_speed_density, 1, 0.0) == pytest.approx(result.impact_speed_mean)
        assert moment(result.impact_speed_density, 2, 0.0) == pytest.approx(result.impact_speed_mean_square)


def test_units():
    """Scaling lengths and times scales every answer."""
    base, scaled = (exact(oscillator(0.6, 0.5 * w**1.4, w, q)) for w, q in ((1.0, 1.0), (50.0, 7.0)))
    length, speed = scaled.paper.length_scale, scaled.paper.speed_scale
    assert scaled.x_mean_square == pytest.approx(base.x_mean_square * length**2, rel=1e-12)
    assert scaled.v_mean_square == pytest.approx(base.v_mean_square * speed**2, rel=1e-12)
    np.testing.assert_allclose(scaled.correlation(2.0 / 50), base.correlation(2.0) * length**2, rtol=1e-10)
    np.testing.assert_allclose(scaled.spectrum(75.0), base.spectrum(1.5) * length**2 / 50, rtol=1e-10)
    np.testing.assert_allclose(scaled.x_mean_square_at(0.1), base.x_mean_square_at(5.0) * length**2, rtol=1e-10)


def test_mirrored_wall():
    above = exact(oscillator(barrier=Barrier(0.4, free_side="above")))
    below = exact(oscillator(barrier=Barrier(-0.4, free_side="below")))
    assert below.x_mean == -above.x_mean < 0
    assert below.x_mean_square == above.x_mean_square
    x = np.linspace(-3, 3, 13)
    np.testing.assert_array_equal(below.x_density(x), above.x_density(-x))
    folded = exact(oscillator(barrier=Barrier(free_side="below")))
    assert float(folded.x_mean_at(1.0)) == -float(exact(oscillator(barrier=Barrier())).x_mean_at(1.0)) < 0


@pytest.mark.parametrize(("alpha", "c", "cause"), [(0.0, 3.0, "spring of stiffness"), (0.7, 0.0, "C is 0")])
@pytest.mark.parametrize("wall", [None, Barrier(), Barrier(0.3)])
def test_nothing_dissipates(alpha, c, cause, wall):
    result = exact(oscillator(alpha, c, omega=2.0, q=3.0, barrier=wall))
    for name in MOMENTS:
        with pytest.raises(NoStationaryStateError, match=cause):
            getattr(result, name)
    for density in (result.x_density, result.correlation, result.amplitude_density):
        with pytest.raises(NoStationaryStateError):
            density(1.0)
    if wall is not None and wall.position:
        with pytest.raises(NotCoveredError, match="wall at 0"):
            result.x_mean_square_at(1.0)
        return
    t = np.array([0.5, 4.0, 100.0])
    stiffness = 4.0 + c
    energy = result.v_mean_square_at(t) / 2 + stiffness * result.x_mean_square_at(t) / 2
    np.testing.assert_allclose(energy, 3.0 * t / 2, rtol=1e-12)
    with pytest.raises(NoStationaryStateError):
        result.x_mean_square_at(math.inf)


def test_infinite_time_is_the_stationary_state():
    for asked in (oscillator(), oscillator(0.3, 2.0), oscillator(barrier=Barrier()), oscillator(1.0, 7.0)):
        result = exact(asked)
        assert float(result.x_mean_square_at(math.inf)) == pytest.approx(result.x_mean_square, rel=1e-12)
        assert float(result.v_mean_square_at(math.inf)) == pytest.approx(result.v_mean_square, rel=1e-12)
        assert float(result.correlation(math.inf)) == pytest.approx(result.x_mean**2, abs=1e-12)


def test_no_noise_is_rest():
    result = exact(oscillator(q=0.0, barrier=Barrier(0.7, free_side="above")))
    assert (result.x_mean, result.x_mean_square, result.impact_rate) == (0.7, pytest.approx(0.49), 0.0)
    assert exact(oscillator(0.5, q=0.0)).amplitude_mean_square == 0.0
    with pytest.raises(ValueError, match="no density"):
        result.x_density(1.0)


@pytest.mark.parametrize(
    "asked",
    [
        oscillator(0.5, 1.0, barrier=Barrier()),
        oscillator(1.0, barrier=Barrier(0.0, 0.9)),
        oscillator(0.0, 1.0, barrier=Barrier(0.0, 0.9)),
    ],
)
def test_not_covered(asked):
    with pytest.raises(NotCoveredError, match="covers any order without a wall, order 1 with an elastic wall"):
        exact(asked)


def test_refusals():
    result = exact(oscillator())
    with pytest.raises(TypeError, match="system must be a System"):
        exact(3)
    for ask, name in (
        (result.x_density, "displacement"),
        (result.v_density, "velocity"),
        (result.correlation, "lag"),
        (result.energy_density, "energy"),
        (result.spectrum, "frequency"),
        (result.x_mean_square_at, "time"),
    ):
        with pytest.raises(TypeError, match=f"^{name} must be a real number"):
            ask("a")
    with pytest.raises(ValueError, match="at least 0 s"):
        result.x_mean_square_at(-1.0)
    with pytest.raises(ValueError, match="not NaN"):
        result.correlation(math.nan)
    with pytest.raises(NotCoveredError, match="no wall to strike"):
        result.impact_speed_density(1.0)
    walled = exact(oscillator(barrier=Barrier(0.2, free_side="above")))
    for ask in (walled.correlation, walled.x_mean_square_at):
        with pytest.raises(NotCoveredError, match="wall at 0"):
            ask(1.0)
    with pytest.raises(NotCoveredError, match="without a wall only"):
        walled.spectrum(1.0)


def test_far_away_nothing_is_left():
    for result in (exact(oscillator(barrier=Barrier(0.2, free_side="above"))), exact(oscillator(0.5))):
        for density in (result.x_density, result.v_density, result.amplitude_density, result.energy_density):
            np.testing.assert_array_equal(density([1e200, math.inf]), 0.0)
    assert float(exact(oscillator()).spectrum(math.inf)) < 1e-290


@given(st.floats(0.001, 1.0), st.floats(1e-8, 1e8), st.floats(1e-3, 1e3), st.floats(1e-6, 1e6))
@settings(max_examples=60)
def test_always_finite(alpha, coefficient, omega, q):
    result = exact(oscillator(alpha, coefficient, omega, q))
    assert isinstance(result, Exact)
    assert all(math.isfinite(value) and value > 0 for value in (result.x_mean_square, result.v_mean_square))
    # v feels the spring and the springpot, x not less than the spring: Omega^2 <x^2> <= <v^2>
    assert omega**2 * result.x_mean_square <= result.v_mean_square * (1 + 1e-9)


@pytest.mark.parametrize("method", ["exact", "averaging", "envelope"])
def test_an_elastic_wall_bears_the_mean_force_of_the_spring(method: str) -> None:
    """Of the dashpot and the noise the mean force is 0."""
    system = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(0.1), stop=sp.Barrier(0.0), noise=sp.WhiteNoise(1.0))
    found = getattr(sp.theory, method)(system)
    assert found.stop_force_mean == pytest.approx(8.0 * abs(found.x_mean), rel=1e-3)
    lossy = sp.System(*system.parts[:3], stop=sp.Barrier(0.0, 0.9), noise=sp.WhiteNoise(1.0))
    assert math.isnan(sp.theory.envelope(lossy).stop_force_mean)
