"""Inelastic impacts: against the exact elastic answer, Monte Carlo, scaling laws and power laws."""

import itertools
import json
import math

import numpy as np
import pytest
from scipy.integrate import quad

from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.simulation import simulate
from springpot.theory.mckean import COLLAPSE_BELOW, slow_impact_power
from springpot.theory.methods.exact import exact
from springpot.theory.methods.fokker_planck.equation import COARSE, FINE, Grid, moments, solve
from springpot.theory.methods.fokker_planck.method import fokker_planck
from springpot.theory.methods.fokker_planck.transition import QuadraticForm
from springpot.theory.problem import Problem, problem_and_units
from springpot.theory.result import MOMENTS, NoStationaryStateError
from tests.sizes import validation


def oscillator(c=0.2, r=0.8, position=0.0, omega=1.0, q=1.0, free_side="above") -> Oscillator:
    return Oscillator(omega, Springpot(1.0, c), Barrier(position, r, free_side), WhiteNoise(q))


def problem_of(asked: Oscillator) -> Problem:
    return problem_and_units(Dimensionless.of(asked))[0]


@pytest.mark.parametrize(
    ("c", "position"),
    [
        (0.05, 0.0),
        (0.5, -1.0),
        (2.0, 0.5),
        (10.0, 0.0),
        *(validation(c, b) for c, b in itertools.product((0.05, 10.0), (-1.0, 0.5))),
        *(validation(c, b) for c, b in itertools.product((0.5, 2.0), (-1.0, 0.0, 0.5)) if b != (-1.0, 0.5)[c > 1.0]),
    ],
)
def test_an_elastic_wall_has_the_exact_answer(c, position):
    asked = oscillator(c, 1.0, position)
    result, truth = fokker_planck(asked), exact(asked)
    for name in MOMENTS:
        assert getattr(result, name) == pytest.approx(getattr(truth, name), rel=1e-6, abs=1e-7), name
    u = np.array([0.01, 0.3, 1.0]) / math.sqrt(c)
    np.testing.assert_allclose(result.impact_speed_density(u), truth.impact_speed_density(u), rtol=1e-4)


@pytest.mark.parametrize(("position", "factor"), [(3.5, 1e-5), (-5.5, 1e-7)])
def test_deep_preload_and_wide_gap(position, factor):
    asked = oscillator(0.5, 1.0, position)
    result, truth = fokker_planck(asked), exact(asked)
    assert result.impact_rate == pytest.approx(truth.impact_rate, rel=factor)
    assert result.x_mean_square == pytest.approx(truth.x_mean_square, rel=factor)


@pytest.mark.parametrize(
    ("r", "energy", "error"),
    [
        (0.95, 0.3782, 0.0006),
        (0.8, 0.2108, 0.0003),
        (0.5, 0.1100, 0.0002),
    ],
)
def test_energy_against_recorded_monte_carlo(r, energy, error):
    result = fokker_planck(oscillator(0.1, r, q=0.1))
    assert result.amplitude_mean_square / 2 == pytest.approx(energy, abs=2.5 * error)
    assert result.error_estimate < 1e-5


@pytest.mark.validation
@pytest.mark.parametrize(("c", "r", "position"), [(0.3, 0.8, 0.0), (1.0, 0.8, 0.5), (0.3, 0.6, -1.0)])
def test_against_monte_carlo(c, r, position):
    asked = oscillator(c, r, position)
    found = simulate(asked, paths=4096, duration=120.0, window=(30.0, 120.0), step=0.01, seed=5, start="rest")
    result = fokker_planck(asked)
    for name in ("x_mean", "x_mean_square", "v_mean_square"):
        assert abs(found[name].value - getattr(result, name)) < 4 * found[name].error, name
    assert result.impact_rate == pytest.approx(found["impact_rate"].value, rel=0.02)


@pytest.mark.parametrize(
    ("c", "r", "position"),
    [
        validation(0.1, 0.8, 0.0),
        (1.0, 0.5, -0.5),
        validation(0.05, 0.95, 0.5),
        (2.0, 0.3, 0.0),
    ],
)
def test_the_answer_does_not_depend_on_the_grid(c, r, position):
    """Third grids, finer in every respect, and twice the range of speeds: the estimate bounds the error."""
    asked = oscillator(c, r, position)
    result, problem = fokker_planck(asked), problem_of(asked)
    units = problem_and_units(Dimensionless.of(asked))[1]
    grid = Grid(spacing=0.15, nodes=12, panel=0.35, decay=24.0, reach=8.0)
    finest = units.moments(asked, *moments(problem, solve(problem, grid)))
    for name in MOMENTS:
        gap = abs(getattr(result, name) / getattr(finest, name) - 1)
        assert gap < 1e-6, name
        assert gap <= result.error_estimate
    rate = units.moments(asked, *moments(problem, solve(problem, COARSE))).impact_rate
    assert result.impact_rate_error == pytest.approx(abs(rate / result.impact_rate - 1), rel=1e-6)


@pytest.mark.parametrize("c", [0.1, 1.99, 2.0, 6.0])
@pytest.mark.parametrize("wall", [0.0, 0.7])
def test_transition_density_against_the_moment_equations(c, wall):
    """P_t(b, v | b, v') from the matrix exponential and an integrated covariance."""
    from scipy.linalg import expm

    times = np.array([1e-3, 0.1, 0.6, 3.0, 9.0])
    v, kick = 0.4, -0.9
    drift = np.array([[0.0, 1.0], [-1.0, -c]])
    problem = problem_of(oscillator(c, 1.0, wall))
    form = QuadraticForm.at(problem, times)
    for index, t in enumerate(times):
        nodes, weights = np.polynomial.legendre.leggauss(60)
        columns = [expm(drift * t * (n + 1) / 2)[:, 1] for n in nodes]
        covariance = sum(w * t / 2 * np.outer(col, col) for w, col in zip(weights, columns, strict=True))
        offset = np.array([wall, v]) - expm(drift * t) @ np.array([wall, kick])
        exponent = offset @ np.linalg.solve(covariance, offset) / 2
        z = np.array([v, kick, 1.0])
        assert float(z @ form.form[index] @ z) == pytest.approx(exponent, rel=1e-6)
        assert form.height[index] == pytest.approx(1 / (2 * math.pi * math.sqrt(np.linalg.det(covariance))), rel=1e-6)


@pytest.mark.parametrize("r", [0.3, 0.5, 0.8, 1.0])
def test_slow_impacts_follow_the_power_law(r):
    """Flux of slow impacts like u^g: the solution finds the exponent of the self-similar problem by itself."""
    impacts = solve(problem_of(oscillator(0.3, r)), FINE)
    part = (impacts.speed > 1e-4) & (impacts.speed < 1e-3)
    slope = np.polyfit(np.log(impacts.speed[part]), np.log(impacts.weight[part]), 1)[0]
    assert slope == pytest.approx(slow_impact_power(r), abs=0.01)
    assert slow_impact_power(1.0) == 2.0
    assert slow_impact_power(0.5) == pytest.approx(1.0)


def test_density_of_impact_speeds_has_its_moments():
    result = fokker_planck(oscillator(0.3, 0.7, -0.4, omega=2.0, q=3.0))

    def moment(power):
        cuts = itertools.pairwise([0.0, 1e-3, 0.1, 2.0, 5.0, 15.0])
        return sum(quad(lambda u: u**power * float(result.impact_speed_density(u)), *ends)[0] for ends in cuts)

    moments = [moment(0), moment(1), moment(2)]
    assert moments == pytest.approx([1.0, result.impact_speed_mean, result.impact_speed_mean_square], rel=1e-5)
    np.testing.assert_array_equal(result.impact_speed_density([-1.0, 1e200, math.inf]), 0.0)


@pytest.mark.validation  # every day: densities have the moments, in this file
def test_losses_cool_the_oscillator():
    energies = [fokker_planck(oscillator(0.2, r)).amplitude_mean_square for r in (1.0, 0.9, 0.7, 0.4, 0.2)]
    assert energies == sorted(energies, reverse=True)
    assert energies[0] == pytest.approx(5.0, rel=1e-7)


def test_units_and_mirror():
    base = fokker_planck(oscillator(0.4, 0.7, 0.3))
    asked = oscillator(0.4 * 50, 0.7, -0.3 * math.sqrt(7.0 / 50**3), omega=50.0, q=7.0, free_side="below")
    scaled = fokker_planck(asked)
    length, speed = scaled.paper.length_scale, scaled.paper.speed_scale
    assert scaled.x_mean == pytest.approx(-base.x_mean * length, rel=1e-9)
    assert scaled.amplitude_mean_square == pytest.approx(base.amplitude_mean_square * length**2, rel=1e-9)
    assert scaled.v_mean_square == pytest.approx(base.v_mean_square * speed**2, rel=1e-9)
    assert scaled.impact_rate == pytest.approx(base.impact_rate * 50, rel=1e-9)
    density = scaled.impact_speed_density(0.8 * speed) * speed
    np.testing.assert_allclose(density, base.impact_speed_density(0.8), rtol=1e-9)


def test_no_noise_and_no_dissipation():
    rest = fokker_planck(oscillator(q=0.0, position=0.7))
    assert (rest.x_mean, rest.impact_rate) == (0.7, 0.0)
    with pytest.raises(ValueError, match="no density"):
        rest.impact_speed_density(1.0)
    with pytest.raises(NoStationaryStateError, match="energy grows"):
        _ = fokker_planck(oscillator(0.0, 1.0)).x_mean


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (Oscillator(springpot=Springpot(0.5, 1.0)), "not order 0.5"),
        (Oscillator(springpot=Springpot(1.0, 1.0), barrier=None), "without a wall"),
        (oscillator(r=0.1), "not restitution 0.1"),
        (oscillator(0.0, 0.9), "not 0"),
        (oscillator(1e-5, 0.9), "not 1e-05"),
        (oscillator(0.5, 0.9, 9.0), "not at 9"),
        (oscillator(0.5, 0.9, -9.0), "not at -9"),
    ],
)
def test_not_covered(asked, said):
    with pytest.raises(NotCoveredError, match=f"^The Fokker-Planck solution covers order 1 with a wall .*{said}"):
        fokker_planck(asked)


def test_refusals_and_dictionary():
    with pytest.raises(TypeError, match="system must be a System"):
        fokker_planck(None)
    result = fokker_planck(oscillator())
    with pytest.raises(TypeError, match="speed must be a real number"):
        result.impact_speed_density("a")
    answer = result.to_dict()
    assert list(answer) == [*result.numbers, "error_estimate", "impact_rate_error", "assumptions", "warnings"]
    assert json.loads(json.dumps(answer)) == answer
    assert result.warnings == ()
    assert math.exp(-math.pi / math.sqrt(3)) == COLLAPSE_BELOW
    about_rate, chatter = fokker_planck(oscillator(0.1, 0.18)).warnings
    assert "impact rate" in about_rate
    assert "this is chatter" in chatter


@pytest.mark.parametrize(
    ("c", "position"), [validation(0.06, 0.0), validation(0.3, -1.0), (1.0, 0.5), validation(5.0, 0.0)]
)
def test_densities_at_an_elastic_wall_are_exact(c, position):
    asked = oscillator(c, 1.0, position)
    result, truth, spread = fokker_planck(asked), exact(asked), math.sqrt(0.5 / c)
    x = position + spread * np.array([-0.1, 0.0, 0.003, 0.03, 0.3, 1.0, 3.0, 50.0])
    v = spread * np.linspace(-3, 3, 20)
    peak_x, peak_v = (
        float(density(0.0 if density is truth.v_density else max(position, 0.0)))
        for density in (truth.x_density, truth.v_density)
    )
    np.testing.assert_allclose(result.x_density(x), truth.x_density(x), atol=2e-3 * peak_x)
    np.testing.assert_allclose(result.x_density(x[3:]), truth.x_density(x[3:]), atol=5e-5 * peak_x)
    np.testing.assert_allclose(result.v_density(v), truth.v_density(v), atol=1e-4 * peak_v)
    joint = result.joint_density(x[:, None], v)
    np.testing.assert_allclose(joint, truth.joint_density(x[:, None], v), atol=1e-3 * peak_x * peak_v)


def panels(edges):
    """Gauss nodes and weights on consecutive intervals."""
    x, w = np.polynomial.legendre.leggauss(16)
    low, half = np.array(edges[:-1]), np.diff(edges) / 2
    return (low[:, None] + half[:, None] * (x + 1)).ravel(), (half[:, None] * w).ravel()


@pytest.mark.parametrize(
    ("c", "r", "position"), [validation(0.1, 0.5, 0.0), validation(0.3, 0.8, -1.0), (1.0, 0.7, 0.5)]
)
def test_densities_have_the_moments(c, r, position):
    """An independent check: the moments come from the flux at the wall, the densities from what happens beyond it."""
    result = fokker_planck(oscillator(c, r, position))
    far = 10 * math.sqrt(result.x_mean_square) + abs(position)
    gap, weight = panels(far * np.array([0.0, 1e-3, 0.01, 0.05, 0.2, 0.5, 1.0]))
    density = weight * result.x_density(position + gap)
    assert density.sum() == pytest.approx(1.0, abs=7e-4)  # the maximum at the wall is cut off
    assert density @ (position + gap) == pytest.approx(result.x_mean, rel=1e-3, abs=1e-3)
    assert density @ (position + gap) ** 2 == pytest.approx(result.x_mean_square, rel=3e-4)
    v, weight = np.concatenate([-gap, gap]), np.concatenate([weight, weight])
    density = weight * result.v_density(v)
    assert density.sum() == pytest.approx(1.0, abs=1e-5)
    assert density @ v == pytest.approx(0.0, abs=2e-5)
    assert density @ v**2 == pytest.approx(result.v_mean_square, rel=1e-4)
    slices = result.joint_density(position + 0.4, v)
    assert weight @ slices == pytest.approx(float(result.x_density(position + 0.4)), rel=1e-4)
    assert (weight * v) @ slices == pytest.approx(0.0, abs=1e-5)  # no current through any place


@pytest.mark.validation  # every day: densities have the moments, in this file
def test_joint_density_at_the_wall_carries_the_impacts():
    result = fokker_planck(oscillator(0.3, 0.6))
    u = np.array([0.2, 1.0, 2.5])
    at_wall = result.joint_density(0.0, -u)
    np.testing.assert_allclose(at_wall * u, result.impact_rate * result.impact_speed_density(u), rtol=1e-10)
    np.testing.assert_allclose(result.joint_density(0.0, 0.6 * u), at_wall / 0.6**2, rtol=1e-10)
    # it is continuous there
    np.testing.assert_allclose(result.joint_density(0.06, -u[1:]), at_wall[1:], rtol=0.1)


@pytest.mark.validation  # every day: the speeds in test_units_and_mirror
def test_densities_in_units_and_in_the_mirror():
    base = fokker_planck(oscillator(0.4, 0.7, 0.3))
    asked = oscillator(0.4 * 50, 0.7, -0.3 * math.sqrt(7.0 / 50**3), omega=50.0, q=7.0, free_side="below")
    scaled = fokker_planck(asked)
    length, speed = scaled.paper.length_scale, scaled.paper.speed_scale
    x, v = np.array([0.1, 0.5, 1.2])[:, None], np.array([-0.7, 0.4])
    np.testing.assert_allclose(
        scaled.joint_density(-x * length, -v * speed) * length * speed, base.joint_density(x, v), rtol=1e-8
    )
    np.testing.assert_allclose(scaled.x_density(-x * length) * length, base.x_density(x), rtol=1e-8)
    np.testing.assert_allclose(scaled.v_density(-v * speed) * speed, base.v_density(v), rtol=1e-8)
    for density in (base.x_density, base.v_density):
        assert density(1e200) == 0.0
        with pytest.raises(TypeError, match="must be a real number"):
            density("a")


@pytest.mark.validation
@pytest.mark.parametrize("c", [0.5, 0.1])
def test_impacts_tilt_the_density(c):
    """A wall that takes speed leaves more mass at small speeds on its side, and slow flights away from it."""
    result, elastic = fokker_planck(oscillator(c, 0.5)), fokker_planck(oscillator(c, 1.0))
    assert float(result.v_density(0.5)) != pytest.approx(float(result.v_density(-0.5)), rel=0.05)
    assert float(elastic.v_density(0.5)) == pytest.approx(float(elastic.v_density(-0.5)), rel=1e-3)


@pytest.mark.parametrize(
    ("c", "r", "position"),
    [
        (0.02, 0.6, -10.0),
        (0.02, 0.9, 5.0),
        validation(0.005, 0.7, 0.0),
        validation(0.01, 1.0, 7.0),
    ],
)
def test_light_damping_with_a_wide_gap_or_a_preload(c, r, position):
    result = fokker_planck(oscillator(c, r, position))
    assert result.error_estimate < 3e-4
    assert result.x_mean_square > result.x_mean**2
    assert result.v_mean_square <= 0.5 / c * (1 + 1e-6)


@pytest.mark.validation  # every day: other refusals
def test_an_answer_without_digits_is_refused():
    with pytest.raises(NotCoveredError, match="numerical solution is accurate; here two grids differ"):
        fokker_planck(oscillator(0.02, 0.3, 19.0))
