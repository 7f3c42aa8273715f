"""Statistical linearization of parts that yield, by moments of Gaussian variables and by Lyapunov's equation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import linalg

import springpot as sp

ROWS = ((0.1, 0.5, 0.2, (0.56336, 0.43882, 0.23257)), (0.04, 0.1, 0.1, (0.40196, 0.21796, 0.15841)))


@pytest.mark.parametrize(("damping", "left", "intensity", "exact"), ROWS)
def test_moments_are_those_of_an_own_solution(
    damping: float, left: float, intensity: float, exact: tuple[float, float, float]
) -> None:
    part = sp.BoucWen(1.0 - left, 1.0 - left)
    found = sp.theory.linearization(sp.System(sp.Spring(left), sp.Dashpot(damping), part, sp.WhiteNoise(intensity)))
    arm = found.arms["bouc_wen"]
    c, d = arm.stiffness / part.stiffness, arm.stiffness / arm.coefficient  # z' = c v - d z
    drift = np.array([[0.0, 1.0, 0.0], [-left, -damping, left - 1.0], [0.0, c, -d]])
    covariance = linalg.solve_continuous_lyapunov(drift, -np.diag([0.0, intensity, 0.0]))
    assert [found.x_mean_square, found.v_mean_square] == pytest.approx(np.diag(covariance)[:2], rel=1e-6)
    assert np.diag(covariance) == pytest.approx(exact, abs=6e-6)
    assert not found.is_exact
    assert "far from Gaussian" in found.warnings[0]


@pytest.mark.parametrize(("exponent", "beta"), [(1.0, 0.5), (1.0, 0.9), (2.0, 0.5), (3.0, 1.4), (2.5, 0.7)])
def test_the_arm_has_the_mean_slopes_of_the_law(exponent: float, beta: float) -> None:
    """By differences of E[z' v] and E[z' z], which have them as coefficients of the covariances of v and z."""
    part, speed, rho = sp.BoucWen(2.0, 3.0, exponent, beta), 0.7, 0.6
    arm, force = part.nearest_arm(speed, rho)
    c, d, size = arm.stiffness / part.stiffness, arm.stiffness / arm.coefficient, force / part.stiffness
    u, v = np.meshgrid(np.linspace(-9.0, 9.0, 601), np.linspace(-9.0, 9.0, 601), indexing="ij")
    weight = np.exp(-0.5 * (u * u + v * v))
    weight /= weight.sum()
    v, z = speed * v, size * (rho * v + np.sqrt(1.0 - rho**2) * u)
    law = v - np.abs(z / part.yield_displacement) ** exponent * (beta * np.sign(v * z) + 1.0 - beta) * v
    covariance = np.array([[speed**2, rho * speed * size], [rho * speed * size, size**2]])
    found = np.linalg.solve(covariance, [(weight * law * v).sum(), (weight * law * z).sum()])
    assert found == pytest.approx([c, -d], rel=2e-4)
    assert c * rho * speed == pytest.approx(d * size)  # z is stationary


@pytest.mark.parametrize("reached", [0.4, 1.0, 4.0])
def test_the_arm_of_a_slider_has_the_mean_slopes_of_the_law(reached: float) -> None:
    """Of z = g cut off at its limits, by sums over a grid of g and of what is left of v."""
    part, speed = sp.Jenkins(2.0, 3.0), 0.7
    arm, force = part.nearest_arm(speed, reached)
    c, d, spread = arm.stiffness / part.stiffness, arm.stiffness / arm.coefficient, force / part.stiffness
    cell = 0.02 / max(reached, 1.0)  # the limit lies between two cells
    edges = np.arange(-int(7.0 / cell), int(7.0 / cell))
    g, u = np.meshgrid(cell * (edges + 0.5), np.linspace(-7.0, 7.0, 301), indexing="ij")
    weight = np.exp(-0.5 * (g * g + u * u))
    weight /= weight.sum()
    both = d * spread**2 / c  # E[v z], as the arm has it
    rho = both / (speed * part.yield_displacement * reached * math.erf(np.sqrt(0.5) / reached))
    v = speed * (rho * g + np.sqrt(1.0 - rho**2) * u)
    z = part.yield_displacement * np.clip(reached * g, -1.0, 1.0)
    law = np.where((np.abs(reached * g) > 1.0) & (v * g > 0.0), 0.0, v)
    found = [(weight * each).sum() for each in (v * z, z * z, v * law)]
    assert found == pytest.approx([both, spread**2, c * speed**2 - d * both], rel=4e-3)
    assert abs((weight * z * law).sum()) < 4e-3 * both  # z is stationary


def test_a_slider_that_hardly_slips_is_a_spring_and_one_that_always_does_is_friction() -> None:
    stuck, force = sp.Jenkins(2.0, 3.0).nearest_arm(0.7, 0.1)
    assert (stuck.stiffness, force) == pytest.approx((2.0, 0.3), rel=1e-9)
    rubbed, force = sp.Jenkins(2.0, 3.0).nearest_arm(0.7, 1e3)
    power = force**2 / rubbed.coefficient
    assert (power, force) == pytest.approx((np.sqrt(2.0 / np.pi) * 3.0 * 0.7, 3.0), rel=2e-3)


@pytest.mark.parametrize(
    ("left", "intensity", "x", "v", "errors"),
    [(0.5, 0.3, 1.152, 0.872, (0.023, 0.087)), (0.2, 0.3, 1.313, 0.660, (-0.202, 0.062)),
     (0.05, 0.1, 1.054, 0.372, (-0.525, -0.022))],
)  # fmt: skip
def test_of_a_bilinear_mass_it_is_as_wrong_as_stated(
    left: float, intensity: float, x: float, v: float, errors: tuple[float, float]
) -> None:
    """Against Monte Carlo with standard errors of 0.5 % (x of the last 1.6 %)."""
    part = sp.Jenkins(1.0 - left, 1.0 - left)
    found = sp.theory.linearization(sp.System(sp.Spring(left), sp.Dashpot(0.04), part, sp.WhiteNoise(intensity)))
    assert (found.x_mean_square / x - 1.0, found.v_mean_square / v - 1.0) == pytest.approx(errors, abs=0.002)
    assert "A Jenkins part makes x far from Gaussian" in found.warnings[0]


def test_where_a_slider_alone_holds_the_mass_its_velocity_is_known() -> None:
    alone = sp.theory.linearization(sp.System(sp.Dashpot(0.1), sp.Jenkins(1.0, 1.0), sp.WhiteNoise(0.2)))
    assert alone.v_mean_square == pytest.approx(0.4245, rel=0.02)  # by Monte Carlo, standard error 0.0022


@pytest.mark.validation
def test_of_masses_that_do_not_meet_each_has_the_moments_of_one() -> None:
    one = sp.System(sp.Spring(0.5), sp.Dashpot(0.1), sp.BoucWen(0.5, 0.5, 2.0), sp.WhiteNoise(0.2))
    pair = sp.System(
        *(sp.Mass(1.0, at=end) for end in "ab"), *(sp.Spring(0.5, between=("ground", end)) for end in "ab"),
        *(sp.Dashpot(0.1, between=("ground", end)) for end in "ab"), *(sp.WhiteNoise(0.2, on=end) for end in "ab"),
        *(sp.BoucWen(0.5, 0.5, 2.0, between=("ground", end)) for end in "ab"),
    )  # fmt: skip
    alone, both = sp.theory.linearization(one), sp.theory.linearization(pair)
    for end in "ab":
        assert both.moments[f"{end}_x_mean_square"] == pytest.approx(alone.x_mean_square, rel=1e-6)


@pytest.mark.validation  # every day: moments of an own solution, above
def test_a_part_that_hardly_yields_is_a_spring_beside_one_that_bends() -> None:
    bent = sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Dashpot(0.1), sp.WhiteNoise(0.2)
    sprung = sp.theory.linearization(sp.System(sp.Spring(1.0), *bent)).x_mean_square
    yielding = sp.theory.linearization(sp.System(sp.Spring(0.5), sp.BoucWen(0.5, 500.0, 2.0), *bent))
    assert yielding.x_mean_square == pytest.approx(sprung, rel=1e-4)


def test_the_best_guess_is_linearization() -> None:
    found = sp.recommended(sp.System(sp.Spring(0.5), sp.Dashpot(0.1), sp.BoucWen(0.5, 0.5), sp.WhiteNoise(0.2)))
    assert (found.method, found.guess) == ("", "linearization")
    assert "compare with Monte Carlo" in found.why_none


@pytest.mark.parametrize(
    "part", [sp.Friction(0.1), sp.Jenkins(1.0, 0.1), sp.RecordedExcitation((0.0, 1.0), (0.0, 0.3)),
             sp.Force(lambda t, x, v: -v)],
)  # fmt: skip
def test_the_envelope_names_what_it_leaves_out(part: sp.System) -> None:
    with pytest.raises(ValueError, match=r"The envelope of systems covers one well, .* not "):
        sp.theory.envelope(sp.System(sp.Spring(1.0), sp.Dashpot(0.1), part, sp.WhiteNoise(1.0)))
