"""The Gaussian memory closure: exact limits, convergence, consistency, Monte Carlo, and where it refuses."""

import itertools
import json
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import rgamma

from springpot.evidence.reliability import warnings_of
from springpot.machine.faults import NotCoveredError
from springpot.problem.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.theory.methods.memory_closure import memory, steps
from springpot.theory.methods.memory_closure.memory import folded_spectrum, make_grid, unfolded_correlation
from springpot.theory.methods.memory_closure.method import MemoryClosure, memory_closure
from springpot.theory.methods.memory_closure.quadrature import half_normal_rule, oscillating_weights
from springpot.theory.methods.memory_closure.steps import solve_with_wall
from springpot.theory.numerics.equations import Anderson
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.result import MOMENTS, NoConvergenceError, NoStationaryStateError
from tests.sizes import thinned, validation


def oscillator(alpha=0.5, c=1.0, r=1.0, b=0.0, omega=1.0, q=1.0, free_side="above") -> Oscillator:
    return Oscillator(omega, Springpot(alpha, c), Barrier(b, r, free_side), WhiteNoise(q))


def free(alpha=0.5, c=1.0, omega=1.0, q=1.0) -> Oscillator:
    return Oscillator(omega, Springpot(alpha, c), None, WhiteNoise(q))


def first_step(alpha, c, detail):
    """Step 1 alone: the Gaussian closure of an elastic wall at 0, on a grid of its own resonance."""
    loop = steps._light_loop(alpha, c, 0.0, detail)
    for _ in range(3):
        loop, _ = loop.closed(c, 0.0, 0.0, 1e-10, 100)
        loop = loop.moved(make_grid(alpha, *loop.peak(c, 0.0, 0.0), detail))
    return loop.closed(c, 0.0, 0.0, 1e-10, 100)[0]


def test_filon_against_an_integral_in_closed_form():
    edges = np.linspace(0.0, 25.0, 26)
    x, _ = panel_rule(edges, 8)
    k = np.array([-300.0, -4.0, -1.0, 0.0, 0.5, 3.9, 4.1, 17.0, 3000.0])
    assert oscillating_weights(edges, k, 8) @ np.exp(-x) == pytest.approx(1.0 / (1.0 - 1j * k), abs=3e-9)


def test_half_normal_rule_is_exact_for_polynomials():
    x, w = half_normal_rule(20)
    for power in range(0, 40, 3):
        moment = 2.0 ** (power / 2) * math.gamma((power + 1) / 2) / math.sqrt(math.pi)
        assert w @ x**power == pytest.approx(moment, rel=1e-11)


def test_anderson_is_faster_than_plain_iteration():
    plain = accelerated = np.array([0.3, 0.9, 0.5])
    mix = Anderson(3)
    for _ in range(12):
        plain = np.cos(plain[[1, 2, 0]])
        accelerated = mix.step(accelerated, np.cos(accelerated[[1, 2, 0]]))
    assert np.abs(accelerated - 0.7390851332151607).max() < 1e-9 < np.abs(plain - 0.7390851332151607).max()


@pytest.mark.parametrize("alpha", [0.1, 0.5, 0.9])
def test_element_against_direct_quadrature(alpha):
    """K(iw) from the grid's matrices and from scipy, for the rho of a linear oscillator."""
    damping, wd = 0.3, math.sqrt(1.0 - 0.15**2)

    def theta(s):
        rho = math.exp(-damping * s / 2) * (math.cos(wd * s) + damping / 2 / wd * math.sin(wd * s))
        return math.acos(min(rho, 1.0)) if s > 1e-4 else s

    grid = make_grid(alpha, 1.0, damping / 2)
    spectrum = 1.0 / (2 * math.pi * ((1 - grid.w**2) ** 2 + (damping * grid.w) ** 2))
    y2, v2 = grid.moments(spectrum)
    element = memory._element(grid, grid.to_drop @ spectrum / y2, grid.to_envelope @ spectrum / y2, math.sqrt(v2 / y2))
    edges = np.concatenate([[0.0], np.geomspace(1e-6, 0.5, 12), np.arange(1.0, 120.0) / 2 + 0.5])
    for target in (0.05, 0.6, 1.0, 2.5):
        at = int(np.argmin(np.abs(grid.w - target)))
        w = grid.w[at]

        def integrand(s, part, w=w):
            value = math.sin(theta(s)) - theta(s) * np.exp(-1j * w * s)
            return s ** (-alpha - 1) * (value.real - 1.0 if part == 0 else value.imag)

        def early(s, w=w):
            value = math.sin(theta(s)) - theta(s) * np.exp(-1j * w * s)
            return s ** (-alpha - 1) * value.real

        # beyond the last edge theta is pi/2 and sin(theta) 1; the tail of e^(-iws) is that of the closed form below
        end = edges[-1]
        real = sum(quad(early, lo, hi)[0] for lo, hi in itertools.pairwise(edges))
        imag = sum(quad(integrand, lo, hi, args=(1,))[0] for lo, hi in itertools.pairwise(edges))
        turns = end + np.arange(40) * math.pi / w
        for part, wave in ((0, np.cos), (1, lambda z: -np.sin(z))):
            terms = np.array(
                [
                    quad(lambda s: s ** (-alpha - 1) * wave(w * s), lo, hi)[0]  # noqa: B023
                    for lo, hi in itertools.pairwise(turns)
                ]
            )
            partial = np.cumsum(terms)
            while partial.size > 10:
                partial = (partial[1:] + partial[:-1]) / 2  # Euler's summation of the alternating tail
            if part == 0:
                real += end**-alpha / alpha - math.pi / 2 * partial[-1]
            else:
                imag -= math.pi / 2 * partial[-1]
        rest = 2 * alpha * rgamma(1 - alpha) / math.pi * (real + 1j * imag)
        assert element[at] == pytest.approx((1j * w) ** alpha - rest, abs=1e-5)


@pytest.mark.parametrize("c", [0.01, 0.1, 1.0, 3.0])
def test_dashpot_with_an_elastic_wall_is_exact(c):
    result = memory_closure(oscillator(1.0, c))
    assert result.x_mean_square == pytest.approx(1 / (2 * c), rel=1e-7)
    assert result.v_mean_square == pytest.approx(1 / (2 * c), rel=1e-7)
    assert result.impact_rate == pytest.approx(1 / math.pi, rel=1e-7)
    assert result.x_mean == pytest.approx(1 / math.sqrt(math.pi * c), rel=1e-7)
    assert result.impact_speed_mean_square == pytest.approx(1 / c, rel=1e-7)


@pytest.mark.parametrize("alpha", [1 - 1e-4, 1 - 1e-7, 1 - 1e-10])
def test_the_limit_of_a_dashpot_is_smooth(alpha):
    result = memory_closure(oscillator(alpha))
    assert result.x_mean_square == pytest.approx(0.5, rel=3 * (1 - alpha) + 1e-7)
    assert result.v_mean_square == pytest.approx(0.5, rel=3 * (1 - alpha) + 1e-7)


@pytest.mark.parametrize(("b", "c", "tolerance"), [(0.5, 1, 1e-3), (1.0, 1, 1e-3), (-0.5, 1, 4e-3), (-1.0, 0.1, 1e-3)])
def test_dashpot_with_a_wall_off_equilibrium(b, c, tolerance):
    """The density is a cut normal of variance 1 / 2c: truncating the polynomials is the only error."""
    s = math.sqrt(1 / (2 * c))
    k = b / s
    h = math.exp(-k * k / 2) / math.sqrt(2 * math.pi) / (0.5 * math.erfc(k / math.sqrt(2)))
    result = memory_closure(oscillator(1.0, c, b=b))
    assert result.x_mean == pytest.approx(s * h, rel=tolerance)
    assert result.x_mean_square == pytest.approx(s * s * (1 + k * h), rel=tolerance)
    assert result.v_mean_square == pytest.approx(s * s, rel=tolerance)
    assert result.impact_rate == pytest.approx(h / math.sqrt(2 * math.pi), rel=3 * tolerance)


@pytest.mark.parametrize(
    ("alpha", "c"), thinned(itertools.product([0.1, 0.3, 0.5, 0.7, 0.9, 1.0], [0.01, 0.1, 1.0, 3.0]), 9)
)
def test_first_step_has_converged_in_grid_and_window(alpha, c):
    """More nodes on every panel and twice the window of the near lags."""
    coarse, fine = first_step(alpha, c, 0), first_step(alpha, c, 1)
    assert coarse.y2 == pytest.approx(fine.y2, rel=5e-6)
    assert coarse.v2 == pytest.approx(fine.v2, rel=5e-6)


@pytest.mark.parametrize(("alpha", "c", "r", "b"), thinned([
    (0.1, 0.01, 1, 0), (0.1, 1, 1, 0), (0.5, 0.1, 1, 0), (0.5, 3, 1, 0), (0.9, 1, 1, 0), (0.3, 0.3, 0.9, 0.5),
], 6))  # fmt: skip
def test_both_steps_have_converged_in_grid_and_window(alpha, c, r, b):
    _, coarse, *_ = solve_with_wall(alpha, c, r, b)
    _, fine, *_ = solve_with_wall(alpha, c, r, b, detail=1)
    assert coarse.y_moment(2) == pytest.approx(fine.y_moment(2), rel=1e-4)
    assert coarse.v_mean_square == pytest.approx(fine.v_mean_square, rel=1e-4)
    assert coarse.impact_rate == pytest.approx(fine.impact_rate, rel=1e-4)


@pytest.mark.parametrize(("alpha", "c", "r", "tolerance"), [
    validation(0.1, 1, 1, 5e-4), validation(0.5, 1, 1, 5e-4), validation(0.5, 3, 1, 2e-3), (0.5, 0.1, 0.9, 2e-3),
    validation(0.3, 1, 0.7, 4e-3),
])  # fmt: skip
def test_the_plane_has_converged_in_degree(alpha, c, r, tolerance):
    _, coarse, *_ = solve_with_wall(alpha, c, r, 0.0)
    _, fine, *_ = solve_with_wall(alpha, c, r, 0.0, degree=13)
    assert coarse.y_moment(2) == pytest.approx(fine.y_moment(2), rel=tolerance)
    assert coarse.impact_rate == pytest.approx(fine.impact_rate, rel=tolerance)


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.5, 0.7, 1.0])
def test_light_springpot_is_the_averaged_one(alpha):
    """Corrected averaging with the springpot's stiffness in the frequency."""
    c, w = 0.01, 1.0
    n = 2.0 * np.arange(1, 20000)
    for _ in range(20):
        shares = 16 / math.pi**2 * c * (n * w) ** alpha / (n**2 - 1) ** 2
        w = math.sqrt(1 + math.cos(alpha * math.pi / 2) * shares.sum())
    damping = math.sin(alpha * math.pi / 2) * (shares * n).sum() / w
    result = memory_closure(oscillator(alpha, c))
    assert result.v_mean_square == pytest.approx(1 / (2 * damping), rel=5e-3)
    assert result.x_mean_square == pytest.approx(1 / (2 * damping * w * w), rel=5e-3)
    assert result.impact_rate == pytest.approx(w / math.pi, rel=5e-3)


# alpha, c, r, b: <A^2>, <x>, impact rate and mean square impact speed of adapted Monte Carlo (step 0.05, relative
# standard errors 0.1 to 0.4 %), and the largest relative difference allowed for each.
MONTE_CARLO = [
    ((0.9, 1, 1, 0), (1.1091, 0.58867, 0.31351, 1.116), (0.01, 0.01, 0.01, 0.012)),
    ((0.7, 1, 1, 0), (1.4497, 0.65968, 0.3066, 1.4625), (0.015, 0.01, 0.01, 0.01)),
    ((0.5, 1, 1, 0), (2.1288, 0.7844, 0.30318, 2.1242), (0.025, 0.015, 0.015, 0.01)),
    ((0.3, 1, 1, 0), (3.8748, 1.0446, 0.30086, 3.8739), (0.035, 0.025, 0.015, 0.015)),
    ((0.1, 1, 1, 0), (13.455, 1.9448, 0.29235, 14.367), (0.035, 0.025, 0.018, 0.01)),
    ((0.5, 0.1, 1, 0), (22.598, 2.6629, 0.31944, 22.16), (0.015, 0.01, 0.005, 0.015)),
    ((0.1, 0.01, 1, 0), (1450.4, 21.471, 0.31826, 1449.2), (0.01, 0.01, 0.005, 0.01)),
    ((0.5, 3, 1, 0), (0.71328, 0.42662, 0.26111, 0.84654), (0.015, 0.01, 0.03, 0.06)),
    ((0.5, 1, 0.9, 0), (1.8823, 0.73619, 0.31043, 1.9907), (0.01, 0.01, 0.015, 0.02)),
    ((0.5, 0.1, 0.5, 0), (2.469, 0.84387, 0.38581, 3.0584), (0.015, 0.015, 0.025, 0.015)),
    ((0.3, 1, 0.7, 0), (2.17, 0.77962, 0.3206, 2.6568), (0.04, 0.02, 0.02, 0.055)),
    ((1, 0.3, 0.7, 0), (1.9856, 0.77621, 0.35443, 2.2233), (0.01, 0.01, 0.01, 0.015)),
    ((0.5, 0.3, 1, -0.5), (6.2429, 1.1341, 0.24972, 6.6073), (0.03, 0.02, 0.015, 0.02)),
    ((0.5, 1, 1, -1), (1.4716, 0.19431, 0.080055, 1.8824), (0.05, 0.06, 0.06, 0.12)),
    ((0.3, 1, 0.8, 0.5), (3.0513, 1.1839, 0.44528, 2.8364), (0.025, 0.015, 0.015, 0.035)),
    ((0.5, 1, 1, 1), (4.229, 1.6067, 0.56292, 2.5651), (0.02, 0.01, 0.01, 0.02)),
]


@pytest.mark.parametrize(("case", "measured", "allowed"), thinned(MONTE_CARLO, 3))
def test_against_monte_carlo(case, measured, allowed):
    result = memory_closure(oscillator(*case))
    names = ("amplitude_mean_square", "x_mean", "impact_rate", "impact_speed_mean_square")
    for name, value, tolerance in zip(names, measured, allowed, strict=True):
        assert getattr(result, name) == pytest.approx(value, rel=tolerance), name


@pytest.mark.parametrize(("alpha", "c", "r", "b"), thinned([
    (0.5, 1, 1, 0), (0.1, 0.3, 0.9, 0), (0.7, 0.1, 0.5, 0), (0.3, 1, 0.8, 0.5), (0.6, 0.3, 1, -0.5), (1, 0.2, 0.7, 0.2),
], 3))  # fmt: skip
def test_mean_force_balance(alpha, c, r, b):
    """Omega^2 <x> is the push of the wall, for D^alpha x has mean 0."""
    result = memory_closure(oscillator(alpha, c, r, b))
    assert result.x_mean == pytest.approx((1 + r) * result.impact_rate * result.impact_speed_mean, rel=1e-8)


@pytest.mark.parametrize("r", [1.0, 0.8, 0.5])
def test_energy_balance_of_a_dashpot(r):
    result = memory_closure(oscillator(1.0, 0.3, r))
    impacts = (1 - r * r) / 2 * result.impact_rate * result.impact_speed_mean_square
    assert 0.3 * result.v_mean_square + impacts == pytest.approx(0.5, rel=1e-8)


@pytest.mark.parametrize(("alpha", "c"), [*itertools.product([0.02, 0.3, 0.8, 1.0], [1e-4, 0.1, 10.0])])
def test_no_wall_is_the_exact_spectrum(alpha, c):
    def density(w):
        return 1 / math.pi / abs(1 - w * w + c * (1j * w) ** alpha) ** 2

    result = memory_closure(free(alpha, c))
    peak = free(alpha, c).resonance
    edges = np.unique(np.concatenate([peak * np.geomspace(1e-9, 1e9, 91), peak + peak / 2 * np.r_[
        -np.geomspace(1e-9, 1, 60), 0, np.geomspace(1e-9, 1, 60)]]))  # fmt: skip
    pieces = list(itertools.pairwise(np.concatenate([[0.0], edges])))
    assert result.x_mean_square == pytest.approx(sum(quad(density, *piece)[0] for piece in pieces), rel=2e-5)
    assert result.v_mean_square == pytest.approx(
        sum(quad(lambda w: w * w * density(w), *piece)[0] for piece in pieces), rel=2e-5
    )
    assert result.iterations == 0
    assert result.impact_rate == 0.0
    assert math.isnan(result.impact_speed_mean)


@pytest.mark.parametrize("asked", [
    validation(oscillator(0.5, 1)), validation(oscillator(0.2, 0.05, 0.6, 0.8)), free(0.4, 0.2, omega=0.5),
    validation(oscillator(0.8, 0.5, 0.9, -0.15, omega=3.0, q=2.0)),
    validation(oscillator(0.5, 0.3, 0.7, -0.3, free_side="below")),
])  # fmt: skip
def test_densities_have_mass_one_and_the_moments(asked):
    result = memory_closure(asked)
    omega, wall = asked.natural_frequency, result.paper.barrier
    sign = 1.0 if wall is None or wall.free_side == "above" else -1.0
    position = 0.0 if wall is None else wall.position
    x_far, v_far = 12 * math.sqrt(result.x_mean_square), 12 * math.sqrt(result.v_mean_square)
    start = -x_far if wall is None else position
    x, dx = panel_rule(np.linspace(start, start + x_far * (2 if wall is None else 1), 41), 16)
    if sign < 0:
        x = 2 * position - x
    v, dv = panel_rule(np.linspace(-v_far, v_far, 41), 16)
    assert dx @ result.x_density(x) == pytest.approx(1.0, abs=1e-10)
    assert dx @ (x * result.x_density(x)) == pytest.approx(result.x_mean, rel=1e-10, abs=1e-10)
    assert dx @ (x**2 * result.x_density(x)) == pytest.approx(result.x_mean_square, rel=1e-10)
    assert dv @ result.v_density(v) == pytest.approx(1.0, abs=1e-10)
    assert dv @ (v**2 * result.v_density(v)) == pytest.approx(result.v_mean_square, rel=1e-10)
    joint = result.joint_density(x[:, None], v)
    assert joint @ dv == pytest.approx(result.x_density(x), abs=1e-10 / x_far)
    assert dx @ joint == pytest.approx(result.v_density(v), abs=1e-10 / v_far)
    corner = abs(position)
    # the amplitude's density has a root in it where the circle first meets the wall
    near = np.geomspace(1e-10, corner or 1.0, 60)
    edges = np.concatenate([np.linspace(0.0, x_far + v_far / omega, 61), corner - near, [corner], corner + near])
    a, da = panel_rule(np.unique(edges[edges >= 0.0]), 16)
    assert da @ result.amplitude_density(a) == pytest.approx(1.0, abs=1e-10)
    assert da @ (a**2 * result.amplitude_density(a)) == pytest.approx(result.amplitude_mean_square, rel=1e-10)
    assert result.energy_density(omega**2 * a**2 / 2) * omega**2 * a == pytest.approx(result.amplitude_density(a))
    if wall is not None:
        u, du = panel_rule(np.linspace(0.0, v_far, 41), 16)
        assert du @ result.impact_speed_density(u) == pytest.approx(1.0, abs=1e-10)
        assert du @ (u * result.impact_speed_density(u)) == pytest.approx(result.impact_speed_mean, rel=1e-10)
        # impacts per second are the flux through the wall
        flux = du @ (u * result.joint_density(position, -sign * u))
        assert flux == pytest.approx(result.impact_rate, rel=1e-10)
        outside = position - sign * np.array([1e-6, 1.0, 50.0])
        assert not result.x_density(outside).any()
        assert not result.joint_density(outside, 0.0).any()
        assert not result.impact_speed_density(-1.0)
    assert not result.amplitude_density(-1.0)
    assert not result.energy_density(-1.0)


@pytest.mark.parametrize(
    ("alpha", "c", "r", "b"),
    [
        (0.1, 0.03, 0.7, 0.8),
        (0.5, 1.0, 1.0, 0.0),
        *(validation(*case) for case in itertools.product([0.1, 0.5, 1.0], [0.03, 1.0], [1.0, 0.7], [0.0, 0.8])),
    ],
)
def test_densities_are_hardly_negative(alpha, c, r, b):
    result = memory_closure(oscillator(alpha, c, r, b))
    x = np.linspace(b, b + 8 * math.sqrt(result.x_mean_square), 400)
    density = result.x_density(x)
    assert density.min() > -3e-3 * density.max()


def test_arguments_of_densities():
    result = memory_closure(oscillator())
    assert np.isnan(result.x_density([math.nan])).all()
    assert np.isnan(result.impact_speed_density(math.nan))
    assert np.isnan(result.amplitude_density(math.nan))
    assert result.x_density([[0.0, 1.0]]).shape == (1, 2)
    for far in (1e3, 1e300, math.inf):
        assert result.x_density(far) == result.v_density(-far) == result.energy_density(far) == 0.0
        assert result.joint_density(far, far) == result.amplitude_density(far) == 0.0
        assert result.impact_speed_density(far) == 0.0
    with pytest.raises(TypeError, match="displacement must be a real number"):
        result.x_density("here")
    with pytest.raises(ValueError, match="lag must be finite"):
        result.correlation(math.inf)
    with pytest.raises(ValueError, match="frequency must be finite"):
        result.spectrum([math.nan])


@pytest.mark.parametrize("asked", [
    validation(oscillator(0.5, 1)), validation(oscillator(0.3, 0.05)), oscillator(0.6, 0.4, 0.8, omega=2, q=3),
    free(0.5, 0.3, omega=2.0),
])  # fmt: skip
def test_spectrum_and_correlation_belong_together(asked):
    result = memory_closure(asked)
    omega = asked.natural_frequency
    variance = result.x_mean_square - result.x_mean**2
    scale, element = asked.resonance, asked.of(Springpot)[0]
    width = element.modulus(1j * scale).imag / (2.0 * scale)
    if asked.stops:
        grid = result._law.loop.grid
        scale, width = grid.resonance * omega, grid.decay * omega
    edges = np.unique(np.concatenate([
        [0.0], scale * np.geomspace(1e-4, 300, 90),
        *(np.clip(n * scale + width * np.linspace(-12, 12, 49), 0, None) for n in range(0, 14)),
    ]))  # fmt: skip
    w, dw = panel_rule(edges, 6)
    spectrum = result.spectrum(w)
    assert 2 * dw @ spectrum == pytest.approx(variance, rel=2e-4)
    assert result.correlation(0.0) == pytest.approx(result.x_mean_square, rel=1e-10)
    for lag in (0.7, 3.0, 11.0):
        cosine = 2 * (oscillating_weights(edges, np.array([lag / omega]), 6) @ spectrum).real[0]
        assert result.correlation(-lag / omega) - result.x_mean**2 == pytest.approx(cosine, abs=2e-4 * variance)
    assert result.correlation(1e5 / omega) == pytest.approx(result.x_mean**2, rel=1e-4, abs=1e-4 * variance)
    assert result.spectrum(-w) == pytest.approx(spectrum)


def test_spectrum_without_a_wall_in_closed_form():
    result = memory_closure(free(0.4, 0.3, omega=2.0, q=3.0))
    w = np.array([0.0, 0.5, 2.0, 9.0])
    exact = 3.0 / (2 * math.pi) / np.abs(4.0 - w**2 + 0.3 * (1j * w) ** 0.4) ** 2
    assert result.spectrum(w) == pytest.approx(exact, rel=2e-5)


def test_correlation_of_a_dashpot():
    result = memory_closure(oscillator(1.0, 0.4))
    lag = np.array([0.0, 0.3, 2.0, 7.0, 40.0])
    wd = math.sqrt(1 - 0.04)
    rho = np.exp(-0.2 * lag) * (np.cos(wd * lag) + 0.2 / wd * np.sin(wd * lag))
    folded = 2 / math.pi * (np.sqrt(1 - rho**2) + rho * np.arcsin(np.clip(rho, -1, 1)))
    assert result.correlation(lag) == pytest.approx(1.25 * folded, rel=3e-6)
    loop = result._law.loop
    assert unfolded_correlation(loop, lag) == pytest.approx(rho, abs=2e-6)
    assert folded_spectrum(loop, np.array([0.0]))[0] > 0.0


def test_dimensionless_law_and_mirror():
    unit = memory_closure(oscillator(0.4, 0.3, 0.8, 0.5))
    omega, q = 3.0, 5.0
    length = math.sqrt(q / omega**3)
    scaled = oscillator(0.4, 0.3 * omega ** (2 - 0.4), 0.8, 0.5 * length, omega, q)
    result = memory_closure(scaled)
    assert result.amplitude_mean_square == pytest.approx(unit.amplitude_mean_square * length**2, rel=1e-7)
    assert result.x_mean == pytest.approx(unit.x_mean * length, rel=1e-7)
    assert result.impact_rate == pytest.approx(unit.impact_rate * omega, rel=1e-7)
    assert result.impact_speed_mean == pytest.approx(unit.impact_speed_mean * length * omega, rel=1e-7)
    mirrored = memory_closure(oscillator(0.4, 0.3, 0.8, -0.5, free_side="below"))
    for name in MOMENTS:
        sign = -1 if name == "x_mean" else 1
        assert getattr(mirrored, name) == sign * getattr(unit, name)
    x, v = np.array([0.6, 1.3]), np.array([-0.4, 2.0])
    assert mirrored.x_density(-x) == pytest.approx(unit.x_density(x))
    assert mirrored.v_density(-v) == pytest.approx(unit.v_density(v))
    assert mirrored.joint_density(-x, -v) == pytest.approx(unit.joint_density(x, v))


@pytest.mark.parametrize(("asked", "sentence"), [
    (oscillator(b=1.1), "within 1 sqrt"),
    (oscillator(b=-1.2), "within 1 sqrt"),
    (oscillator(c=3.0, b=-0.8), "gap up to 1.5 / c"),
    (oscillator(r=0.4), "restitution of at least 0.5, not 0.4"),
    (oscillator(c=11.0), "up to 10, not 11"),
    (free(c=11.0), "up to 10, not 11"),
    (oscillator(0.0, 1.0, 0.9), "alpha > 0"),
    (oscillator(0.5, 1e-5), "averaging is accurate there"),
    (oscillator(0.001, 1.0), "averaging is accurate there"),
    (oscillator(b=0.1, q=0.0), "within 1 sqrt"),
])  # fmt: skip
def test_not_covered(asked, sentence):
    with pytest.raises(NotCoveredError, match=sentence):
        memory_closure(asked)


@pytest.mark.parametrize(("asked", "cause"), [
    (oscillator(0.0), "order 0 is a spring"), (oscillator(c=0.0), "C is 0"), (free(0.0), "order 0 is a spring"),
    (oscillator(c=0.0, q=0.0), "stays constant"),
])  # fmt: skip
def test_no_stationary_state(asked, cause):
    result = memory_closure(asked)
    assert cause in result.stationary
    for ask in (lambda: result.x_mean, lambda: result.x_density(0.0), lambda: result.correlation(0.0)):
        with pytest.raises(NoStationaryStateError, match=cause):
            ask()


def test_without_noise_everything_rests():
    result = memory_closure(oscillator(q=0.0))
    assert result.amplitude_mean_square == result.impact_rate == 0.0
    with pytest.raises(ValueError, match="without noise"):
        result.x_density(0.0)


def test_losses_alone_need_no_springpot():
    """Without a springpot only the wall dissipates: its loss is the noise's power, exactly."""
    result = memory_closure(oscillator(c=0.0, r=0.8))
    assert (1 - 0.64) / 2 * result.impact_rate * result.impact_speed_mean_square == pytest.approx(0.5, rel=1e-8)


def test_no_convergence_is_an_arithmetic_error(monkeypatch):
    assert issubclass(NoConvergenceError, ArithmeticError)
    monkeypatch.setattr(steps, "_STEPS", 1)
    with pytest.raises(NoConvergenceError, match=r"after 1 steps .* still change by"):
        memory_closure(oscillator())
    monkeypatch.setattr(steps, "_SWEEPS", 1)
    with pytest.raises(NoConvergenceError, match=r"after 1 sweeps the correlation still changes by"):
        memory_closure(oscillator())


def test_report():
    result = memory_closure(oscillator(0.3, 1.0, 0.8, -0.5))
    assert isinstance(result, MemoryClosure)
    assert 1 < result.iterations < 20
    assert 0.0 < result.residual < 1e-6
    assert any("validity map" in warning for warning in warnings_of(result))
    assert memory_closure(oscillator(0.5, 0.1)).warnings == ()
    answer = json.loads(json.dumps(result.to_dict()))
    assert answer["iterations"] == result.iterations
    assert answer["amplitude_mean_square"] == result.amplitude_mean_square


def test_bad_input():
    with pytest.raises(TypeError, match="system must be a System"):
        memory_closure(1.0)
    with pytest.raises(NotCoveredError, match="no wall to strike"):
        memory_closure(free()).impact_speed_density(1.0)
