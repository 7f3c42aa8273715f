"""Path integration of systems with colored noise: exact laws, limits, Monte Carlo, and what it does not cover."""

from __future__ import annotations

import math

import numpy as np
import pytest

import springpot as sp
from springpot.evidence.reliability import trust, warnings_of
from springpot.theory import NoConvergenceError, NotCoveredError, linear, path_integration, solve_one
from springpot.theory.methods.systems.chain import Chain, grid_over, make_chain
from tests.sizes import validation

SPRING, DASHPOT = sp.Spring(1.0), sp.Dashpot(0.3)
HARD = sp.PolynomialSpring((0.0, 0.0, 1.0))


def noise(tau: float) -> sp.ColoredNoise:
    """With the density of white noise of intensity 1 at the frequency 1."""
    return sp.ColoredNoise((1.0 + tau**2) / (2.0 * tau), tau)


# --- the chain -----------------------------------------------------------------------------------------------------


def test_the_chain_keeps_constants_and_the_noise() -> None:
    grid = grid_over(2.0, 0.0, 5.0, 4.0, (True, False), (7, 12, 13))
    stop = sp.Barrier(0.0, 0.7)
    chain = make_chain(grid, 0.1, 0.5, lambda y, x, v: y - x - 0.2 * v, [stop])
    y, x, v = grid.places
    start = np.zeros(y.size)
    start[(y == grid.y[2]) & (x == grid.x[4]) & (v == grid.v[6])] = 1.0
    after = chain.forward(start)
    assert after.sum() == pytest.approx(1.0)
    assert after @ y == pytest.approx(grid.y[2] * math.exp(-0.1 / 0.5))  # an Ornstein-Uhlenbeck process
    assert after @ y**2 == pytest.approx(4.0 + (grid.y[2] ** 2 - 4.0) * math.exp(-0.2 / 0.5))
    assert (grid.v[6], grid.x[0]) == (0.0, 0.0)  # where a mass rests on the wall


def test_an_impact_in_a_step() -> None:
    """From x = 0.02 at v = -1 the mass is at r (0.1 - 0.02) after a step of 0.1, with the speed r."""
    grid = grid_over(1.0, 0.0, 1.0, 1.5, (True, False), (3, 41, 41))
    stop = sp.Barrier(0.0, 0.5)
    chain = make_chain(grid, 0.1, 1.0, lambda y, x, v: np.zeros_like(x), [stop])
    y, x, v = grid.places
    near = int(np.argmin((y - 0.0) ** 2 + (x - 0.02) ** 2 + (v + 1.0) ** 2))
    start = np.zeros(y.size)
    start[near] = 1.0
    after = chain.moved @ start  # the motion alone
    assert after @ x == pytest.approx(0.5 * (-0.1 * v[near] - x[near]), abs=1e-12)
    assert after @ v == pytest.approx(-0.5 * v[near], abs=1e-12)
    assert chain.hits[0, (0, 3), near] == pytest.approx([1.0, -v[near]])


# --- exact laws and limits -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("damper", "tau", "error"),
    [
        (DASHPOT, 1.0, 0.006),
        validation(sp.Dashpot(1.0), 0.3, 0.006),
        validation(DASHPOT, 5.0, 0.006),
        validation(sp.Springpot(0.5, 0.3), 1.0, 0.02),
        validation(sp.Springpot(0.8, 1.0), 3.0, 0.03),
        validation(sp.Springpot(0.2, 0.3), 0.3, 0.02),
    ],
)
def test_linear_systems_without_walls(damper, tau: float, error: float) -> None:
    system = sp.System(SPRING, damper, noise(tau))
    found, true = path_integration(system), linear(system)
    assert found.x_mean == pytest.approx(0.0, abs=1e-6)
    for name in ("x_mean_square", "v_mean_square"):
        assert getattr(found, name) == pytest.approx(getattr(true, name), rel=error), name


@pytest.mark.validation  # every day: against Monte Carlo, below
def test_very_slow_noise_presses_the_mass_on_the_wall_or_lifts_it() -> None:
    """x follows max(y, 0), and rests on the lossy wall in between; the envelope would have nothing of this."""
    slow = sp.System(SPRING, sp.Dashpot(1.5), sp.ColoredNoise(1.0, 60.0), sp.Barrier(0.0, 0.6))
    found = path_integration(slow)
    assert found.x_mean_square == pytest.approx(0.5, rel=0.04)
    assert found.x_mean == pytest.approx(1.0 / math.sqrt(2.0 * math.pi), rel=0.08)  # eleven y for a kink at 0


# --- Monte Carlo of the validity map -------------------------------------------------------------------------------

NAMES = "x_mean", "x_mean_square", "v_mean_square", "impact_rate"
MEASURED = [  # parts, then <x>, <x^2>, <v^2> and the impact rate with standard errors, and the error of the method
    ((DASHPOT, noise(1.0), sp.Barrier(0.0)),
     ((0.70697, 0.0012), (0.84627, 0.0026), (0.65229, 0.0019), (0.33838, 0.00095)), 0.012),
    ((HARD, DASHPOT, noise(3.0), sp.Barrier(0.0, 0.8)),
     ((0.36847, 0.0011), (0.28425, 0.0011), (0.24643, 0.0009)), 0.02),
    validation((sp.Spring(-2.0), HARD, DASHPOT, sp.ColoredNoise(1.0, 2.0)),  # two wells
               ((0.0, 0.0019), (1.2136, 0.0007), (0.8893, 0.0016)), 0.01),
    validation((sp.Springpot(0.5, 0.3), sp.ColoredNoise(1.0, 2.0), sp.Barrier(-1.0),
                sp.Barrier(0.7, free_side="below")),
               ((-0.1147, 0.0006), (0.2330, 0.0002), (0.6876, 0.0013), (0.3351, 0.0004)), 0.03),
    validation((sp.Springpot(0.2, 0.3), noise(3.0), sp.Barrier(0.0)),
               ((1.4086, 0.0021), (3.0550, 0.0084), (2.9335, 0.0093), (0.31454, 0.0003)), 0.02),
    validation((sp.Springpot(0.5, 1.0), noise(3.0), sp.Barrier(0.0, 0.8)),
               ((0.52427, 0.0012), (0.62306, 0.0023), (0.26065, 0.0006)), 0.03),
]  # fmt: skip


@pytest.mark.parametrize(("parts", "measured", "error"), MEASURED)
def test_against_monte_carlo(parts, measured, error: float) -> None:
    found = path_integration(sp.System(SPRING, *parts))
    for name, (value, standard_error) in zip(NAMES, measured, strict=False):
        assert abs(getattr(found, name) - value) < error * abs(value) + 3.0 * standard_error, name


@pytest.mark.validation  # every day: each half of it against Monte Carlo, above
def test_a_mirror_image_and_other_units() -> None:
    """x -> -L x, t -> T t, and everything times a mass."""
    length, time, mass = 1e-3, 0.02, 0.2
    force = mass * length / time**2
    plain = sp.System(SPRING, HARD, sp.Dashpot(0.5), sp.ColoredNoise(1.0, 1.0), sp.Barrier(-0.3, 0.8))
    same = sp.System(
        sp.Mass(mass), sp.Spring(mass / time**2), sp.PolynomialSpring((0.0, 0.0, force / length**3)),
        sp.Dashpot(0.5 * mass / time), sp.ColoredNoise(force**2, time),
        sp.Barrier(0.3 * length, 0.8, free_side="below"),
    )  # fmt: skip
    one, other = path_integration(plain), path_integration(same)
    assert other.x_mean == pytest.approx(-length * one.x_mean, rel=1e-5)
    assert other.x_mean_square == pytest.approx(length**2 * one.x_mean_square, rel=1e-5)
    assert other.v_mean_square == pytest.approx((length / time) ** 2 * one.v_mean_square, rel=1e-5)


# --- what it does not cover ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((sp.WhiteNoise(1.0),), "not white_noise"),
        ((noise(1.0), sp.WhiteNoise(1.0)), "not white_noise"),
        ((noise(1.0), noise(2.0)), "several"),
        ((noise(1.0), sp.PiezoelectricCircuit(0.1, 2.0, 0.5)), "not piezoelectric_circuit"),
        ((noise(1.0), sp.Contact(0.0, 5.0, dissipation=0.1)), "not the dissipation of contact"),
        ((), "no colored noise"),
        ((noise(1e-4),), "it is white"),
        ((noise(1.0), sp.Contact(0.0, 1e8)), "too stiff"),
    ],
)
def test_what_it_does_not_cover(parts, sentence: str) -> None:
    with pytest.raises(NotCoveredError, match=sentence):
        path_integration(sp.System(SPRING, DASHPOT, *parts))


def test_what_has_no_stationary_state_says_why() -> None:
    assert "nothing dissipates" in str(path_integration(sp.System(SPRING, noise(1.0))).stationary)
    assert "no spring or wall" in str(path_integration(sp.System(DASHPOT, noise(1.0))).stationary)


@pytest.mark.validation
def test_where_hops_are_too_short_there_is_no_rate() -> None:
    """A damper presses the hops of the mass on an elastic wall below any grid; a lossy wall has no rate at all."""
    pressed = path_integration(sp.System(SPRING, sp.Dashpot(1.0), noise(1.0), sp.Barrier(0.0)))
    assert math.isnan(pressed.impact_rate)
    assert any("hops are too short" in sentence for sentence in pressed.warnings)
    lossy = path_integration(sp.System(SPRING, DASHPOT, noise(1.0), sp.Barrier(0.0, 0.8)))
    assert math.isnan(lossy.impact_rate)
    assert any("infinitely often" in sentence for sentence in lossy.warnings)
    found, why = solve_one(sp.System(SPRING, DASHPOT, noise(1.0), sp.Barrier(0.0)), "path_integration")
    assert why == ""
    assert found.impact_rate > 0.0


@pytest.mark.validation  # every day: against Monte Carlo, above
def test_between_two_elastic_walls_the_map_says_the_error() -> None:
    """<v^2> is 3.5 % low here, which the warning has to cover."""
    walls = sp.Barrier(-0.6), sp.Barrier(0.9, free_side="below")
    held = sp.System(SPRING, sp.Springpot(0.35, 0.5), sp.ColoredNoise(0.8, 0.4), *walls)
    found = path_integration(held)
    run = sp.simulate(held, paths=2000, duration=100.0, seed=6)
    gap = 100.0 * abs(found.v_mean_square / run["v_mean_square"].value - 1.0)
    assert gap > 2.0
    assert trust(held, "path_integration").gaps["v_mean_square"] > 0.8 * gap
    assert any("<v^2>" in sentence for sentence in warnings_of(found))


@pytest.mark.validation  # every day: what has no stationary state says why, above
def test_light_damping_is_refused_after_few_tries(monkeypatch: pytest.MonkeyPatch) -> None:
    tries, stationary = [], Chain.stationary
    monkeypatch.setattr(Chain, "stationary", lambda *given: [tries.append(1), stationary(*given)][1])
    walls = sp.Barrier(-0.7), sp.Barrier(1.1, free_side="below")
    with pytest.raises(NoConvergenceError, match="where damping is light"):
        path_integration(sp.System(SPRING, sp.Springpot(0.5, 0.06), noise(1.9), *walls))
    assert len(tries) <= 4
