"""Theory for systems of parts against closed forms, against integrals done otherwise, and against the Oscillator's."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest
from scipy import integrate, special

import springpot as sp
from springpot.theory import NoConvergenceError, NotCoveredError, exact, linear, linearization, solve_all
from springpot.theory.methods.exact import Exact
from tests.sizes import thinned, validation
from tests.struck import rates_of, speeds_of

WHITE = sp.WhiteNoise(1.0)
SPRING = sp.Spring(1.0)
DASHPOT = sp.Dashpot(0.5)


def cubic(k3: float, k2: float = 0.0) -> sp.PolynomialSpring:
    return sp.PolynomialSpring((0.0, k2, k3))


# --- the exact law -------------------------------------------------------------------------------------------------


def moments_by_quadrature(exponent, low: float, high: float, top: float, walls: tuple[float, ...]):
    """<x>, <x^2>, <v^2> and impact rates of the density exp(-exponent(x, v)), by nested adaptive quadrature."""

    def mean(of) -> float:
        found, _ = integrate.dblquad(
            lambda v, x: of(x, v) * math.exp(-exponent(x, v)), low, high, -top, top, epsabs=1e-11
        )
        return float(found)

    total = mean(lambda x, v: 1.0)
    rates = [
        integrate.quad(lambda v, b=b: v * math.exp(-exponent(b, v)), 0.0, top, epsabs=1e-13)[0] / total for b in walls
    ]
    return mean(lambda x, v: x) / total, mean(lambda x, v: x * x) / total, mean(lambda x, v: v * v) / total, rates


def test_two_walls_and_a_hardening_spring() -> None:
    parts = SPRING, cubic(1.0, 0.1), sp.Dashpot(0.4), WHITE, sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below")
    found = exact(sp.System(*parts))
    x, xx, vv, rates = moments_by_quadrature(
        lambda x, v: 0.8 * (0.5 * v * v + 0.5 * x * x + 0.1 * x**3 / 3.0 + 0.25 * x**4), -0.5, 1.2, 9.0, (-0.5, 1.2)
    )
    assert (found.x_mean, found.x_mean_square) == pytest.approx((x, xx), rel=1e-9)
    assert found.v_mean_square == pytest.approx(1.25, rel=1e-12)
    assert vv == pytest.approx(1.25, rel=1e-9)
    assert rates_of(found) == pytest.approx(rates, rel=1e-9)
    assert speeds_of(found) == pytest.approx([math.sqrt(math.pi / 1.6)] * 2, rel=1e-12)
    assert found.impact_rate == pytest.approx(sum(rates), rel=1e-9)


@pytest.mark.validation  # every day: van der Pol on a wall, in this file
def test_van_der_pol_with_rayleigh_and_a_wall() -> None:
    parts = SPRING, sp.VanDerPol(0.3), sp.PolynomialDashpot((0.0, 0.0, 0.3)), sp.WhiteNoise(0.5), sp.Barrier(-0.5)
    found = exact(sp.System(*parts))

    def exponent(x: float, v: float) -> float:
        energy = 0.5 * (x * x + v * v)
        return 1.2 * (energy * energy - energy)

    x, xx, vv, (rate,) = moments_by_quadrature(exponent, -0.5, 5.0, 5.0, (-0.5,))
    assert (found.x_mean, found.x_mean_square, found.v_mean_square) == pytest.approx((x, xx, vv), rel=1e-7)
    assert found.impact_rate == pytest.approx(rate, rel=1e-7)
    assert found.impact_speed_mean == pytest.approx(1.08581, abs=2e-5)


@pytest.mark.validation
def test_van_der_pol_of_another_length_and_frequency_is_the_same_in_other_units() -> None:
    """x -> 2 x, t -> t / 3: what the coefficients become."""
    length, time = 2.0, 1.0 / 3.0
    parts = (
        sp.Spring(1.0 / time**2), sp.VanDerPol(0.3 / (length**2 * time), length),
        sp.WhiteNoise(0.5 * length**2 / time**3),
        sp.PolynomialDashpot((0.0, 0.0, 0.3 * time / length**2)), sp.Barrier(-0.5 * length),
    )  # fmt: skip
    here = exact(sp.System(*parts))
    there = exact(
        sp.System(
            SPRING, sp.VanDerPol(0.3), sp.PolynomialDashpot((0.0, 0.0, 0.3)), sp.WhiteNoise(0.5), sp.Barrier(-0.5)
        )
    )
    assert here.x_mean == pytest.approx(length * there.x_mean, rel=1e-9)
    assert here.impact_rate == pytest.approx(there.impact_rate / time, rel=1e-9)
    assert here.impact_speed_mean == pytest.approx(there.impact_speed_mean * length / time, rel=1e-9)


@pytest.mark.parametrize(
    "memory",
    [
        (sp.Springpot(0.3, 0.8), sp.Springpot(0.7, 0.3)),
        (sp.Springpot(0.5, 1.0), sp.Dashpot(0.2)),
        (sp.FractionalMaxwell(sp.Springpot(0.4, 2.0), sp.Spring(3.0)),),
        (sp.Maxwell(1.0, 2.0), sp.PiezoelectricCircuit(0.3, 2.0, 0.5)),
    ],
)
def test_matched_noise_gives_boltzmann_whatever_the_memory(memory) -> None:
    parts = SPRING, cubic(1.0, 0.1), sp.ThermalNoise(0.7), sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below")
    found = exact(sp.System(*parts, *memory))
    assert (found.x_mean, found.x_mean_square) == pytest.approx((0.20221, 0.22249), abs=1e-5)
    assert found.v_mean_square == pytest.approx(0.7, rel=1e-12)
    assert rates_of(found) == pytest.approx((0.21507, 0.04104), abs=1e-5)


def test_a_mass_is_heated_by_energy_not_by_energy_per_mass() -> None:
    found = exact(sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Springpot(0.5, 1.0), sp.ThermalNoise(3.0)))
    assert found.v_mean_square == pytest.approx(3.0 / 2.0, rel=1e-12)
    assert found.x_mean_square == pytest.approx(3.0 / 8.0, rel=1e-10)


def test_a_soft_stop_becomes_rigid_slowly() -> None:
    rigid = math.sqrt(2.0 / math.pi)
    for exponent, gaps in ((1.5, (-15.86, -2.560, -0.4065)), (1.0, (-9.95, -1.000, -0.1000))):
        for stiffness, gap in zip((1e2, 1e4, 1e6), gaps, strict=True):
            stop = sp.Contact(0.0, stiffness, exponent)
            found = exact(sp.System(SPRING, sp.Dashpot(0.5), WHITE, stop)).x_mean
            assert 100.0 * (found / rigid - 1.0) == pytest.approx(gap, rel=2e-3)


def test_impacts_on_a_soft_stop_are_counted_at_first_touch() -> None:
    soft = exact(sp.System(SPRING, sp.Dashpot(0.5), WHITE, sp.Contact(-0.2, 50.0)))
    x = np.linspace(-2.0, 8.0, 200_001)
    energy = 0.5 * x * x + 20.0 * np.maximum(0.0, -0.2 - x) ** 2.5
    density = np.exp(-energy)
    touching = math.exp(-0.02) / np.trapezoid(density, x)
    assert soft.impact_rate == pytest.approx(touching / math.sqrt(2.0 * math.pi), rel=1e-8)
    assert soft.x_mean == pytest.approx(np.trapezoid(density * x, x) / np.trapezoid(density, x), rel=1e-8)


@pytest.mark.parametrize("position", [-30.0, -0.5, 0.0, 2.0])
def test_of_an_oscillator_it_is_the_oscillators(position: float) -> None:
    asked = sp.Oscillator(2.0, sp.Springpot(1.0, 0.5), sp.Barrier(position, free_side="above"), sp.WhiteNoise(3.0))
    ours, theirs = exact(asked), exact(asked)
    for name in ("x_mean", "x_mean_square", "v_mean_square", "impact_rate", "amplitude_mean_square"):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), rel=1e-9, abs=1e-15)
    places = [position - 1.0, position + 0.1, position + 1.0]
    assert ours.x_density(places) == pytest.approx(theirs.x_density(places), rel=1e-9)
    assert ours.v_density([0.0, 1.0]) == pytest.approx(theirs.v_density([0.0, 1.0]), rel=1e-9)
    assert ours.joint_density(places, 0.5) == pytest.approx(theirs.joint_density(places, 0.5), rel=1e-9)


def test_narrow_wells_weigh_alike() -> None:
    """At a temperature of a ten-millionth of the barrier between them."""
    wells = sp.System(sp.Spring(-1.0), cubic(1.0), sp.Dashpot(0.5), sp.WhiteNoise(2.5e-8))
    found = exact(wells)
    assert found.x_mean == pytest.approx(0.0, abs=1e-9)
    assert found.x_mean_square == pytest.approx(1.0 - 2.5e-8, rel=1e-11)
    assert math.isnan(found.amplitude_mean_square)


def test_densities_take_any_argument() -> None:
    found = exact(sp.System(SPRING, cubic(1.0), sp.Dashpot(0.5), WHITE, sp.Barrier(-1.0)))
    assert found.x_density([-2.0, math.inf, math.nan])[:2].tolist() == [0.0, 0.0]
    assert math.isnan(found.x_density(math.nan))
    assert found.v_density([math.inf, 1e200]).tolist() == [0.0, 0.0]
    assert found.joint_density(0.5, math.inf) == 0.0
    grid = np.linspace(-1.0, 4.0, 20_001)
    assert np.trapezoid(found.x_density(grid), grid) == pytest.approx(1.0, rel=1e-6)
    with pytest.raises(TypeError, match="displacement"):
        found.x_density("here")


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((sp.Dashpot(1.0), sp.Barrier(0.0, 0.8)), "not a wall of restitution 0.8"),
        ((sp.Dashpot(1.0), cubic(1.0), sp.Barrier(0.0, 0.8)), "not barrier of restitution 0.8"),
        ((sp.Springpot(0.5, 1.0), cubic(1.0)), "not springpot of order 0.5 without ThermalNoise"),
        ((sp.Dashpot(1.0), sp.Contact(0.0, 5.0, dissipation=0.1)), "not the dissipation of contact"),
        ((sp.PolynomialDashpot((1.0, 0.0, 1.0)),), "not the nonlinear polynomial_dashpot"),
        ((sp.Dashpot(1.0), sp.ColoredNoise(1.0, 1.0)), "not colored_noise"),
        ((sp.VanDerPol(1.0), sp.Dashpot(1.0)), "needs a PolynomialDashpot with c3 = mu / Omega.2, here 1 "),
        ((sp.VanDerPol(1.0), cubic(1.0), sp.PolynomialDashpot((0.0, 0.0, 1.0))), "needs a linear spring, and no other"),
        ((sp.Springpot(0.5, 1.0), sp.ThermalNoise(1.0)), "not white noise beside it with springpot"),
        ((sp.ThermalNoise(1.0),), "needs something that dissipates"),
    ],
)
def test_what_the_exact_law_does_not_cover(parts, sentence: str) -> None:
    with pytest.raises(NotCoveredError, match=sentence):
        exact(sp.System(SPRING, WHITE, *parts))


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((SPRING, WHITE), "nothing dissipates energy"),
        ((SPRING, cubic(1.0), sp.Dashpot(1.0)), "nothing excites the motion"),
        ((sp.Dashpot(1.0), WHITE), "no spring or wall holds the mass"),
        ((sp.Dashpot(1.0), WHITE, sp.Barrier(0.0)), "no spring or wall holds the mass on one side"),
    ],
)
def test_what_has_no_stationary_state_says_why(parts, sentence: str) -> None:
    found = exact(sp.System(*parts))
    assert sentence in str(found.stationary)
    assert found.to_dict()["statement"] == found.stationary
    with pytest.raises(sp.theory.NoStationaryStateError):
        _ = found.x_mean


def test_a_weight_on_a_floor() -> None:
    """Constant force towards an elastic wall: the barometric formula."""
    found = exact(sp.System(sp.Constant(-2.0), sp.Dashpot(0.5), WHITE, sp.Barrier(0.0)))
    assert (found.x_mean, found.x_mean_square) == pytest.approx((0.5, 0.5), rel=1e-10)


PUMPED = sp.VanDerPol(0.3), sp.PolynomialDashpot((0.0, 0.0, 0.3)), sp.WhiteNoise(0.5)


@pytest.mark.parametrize("place", [0.5, validation(1.5)])
def test_van_der_pol_on_a_wall_beyond_the_springs_equilibrium(place: float) -> None:
    """Its damping depends on the energy counted from x = 0, which the mass cannot reach."""
    found = exact(sp.System(SPRING, *PUMPED, sp.Barrier(place, free_side="above")))

    def exponent(x: float, v: float) -> float:
        h = 0.5 * (x * x + v * v)
        return 2.0 / 0.5 * (2.0 * 0.3 * h * h / 2.0 - 0.3 * h)

    x, x_square, v_square, rates = moments_by_quadrature(exponent, place, 5.0, 5.0, (place,))
    assert (found.x_mean, found.x_mean_square, found.v_mean_square) == pytest.approx((x, x_square, v_square), rel=1e-7)
    assert rates_of(found) == pytest.approx(rates, rel=1e-7)


@pytest.mark.validation  # every day: van der Pol with a wall, in this file
def test_van_der_pol_under_a_constant_force_is_not_covered() -> None:
    with pytest.raises(NotCoveredError, match="no other spring or constant force"):
        exact(sp.System(SPRING, *PUMPED, sp.Constant(1.0)))
    as_spring = sp.System(sp.Springpot(0.0, 1.0), *PUMPED)
    assert exact(as_spring).x_mean_square == exact(sp.System(SPRING, *PUMPED)).x_mean_square


@pytest.mark.parametrize("q", [validation(1e-4), 1e-8, validation(1e-14)])
def test_a_limit_cycle_with_little_noise(q: float) -> None:
    parts = SPRING, sp.VanDerPol(0.3), sp.PolynomialDashpot((0.0, 0.0, 0.3)), sp.WhiteNoise(q)
    found = exact(sp.System(*parts))  # H stays at 1 / 2: <x^2> = <v^2> = 1 / 2
    assert (found.x_mean_square, found.v_mean_square) == pytest.approx((0.5, 0.5), rel=1e-9)


@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e9])
def test_a_thin_layer_at_two_walls(stiffness: float) -> None:
    """Pushed from the middle to walls at -1 and 1: exp(k x^2 / (2 kT)), half of it within kT / k of each wall."""
    found = exact(
        sp.System(sp.Spring(-stiffness), DASHPOT, WHITE, sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below"))
    )
    half = math.sqrt(2.0 / stiffness) * special.dawsn(math.sqrt(0.5 * stiffness))
    rate = 0.5 / half / math.sqrt(2.0 * math.pi)
    assert rates_of(found) == pytest.approx((rate, rate), rel=3e-7)
    assert any("chatter" not in each for each in found.warnings) == (stiffness > 1e8)


def test_far_from_zero_the_energies_do_not_cancel() -> None:
    for place in (1e2, 1e6, 1e10):  # pressed against a wall with the force b
        found = exact(sp.System(SPRING, DASHPOT, WHITE, sp.Barrier(place, free_side="above")))
        assert found.impact_rate == pytest.approx(place / math.sqrt(2.0 * math.pi), rel=2.0 / place**2 + 1e-9)
    device = sp.System(sp.Mass(1.0), sp.Spring(1e6), DASHPOT, sp.Constant(-9.81), sp.ThermalNoise(4.1e-21))
    found, spread = exact(device), math.sqrt(4.1e-27)
    assert found.x_density(found.x_mean) == pytest.approx(1.0 / (spread * math.sqrt(2.0 * math.pi)), rel=1e-7)


@pytest.mark.parametrize("push", [1.0, 30.0, 1e4])
def test_the_least_energy_inside_a_contact(push: float) -> None:
    """Pressed into a soft stop at 1: the well is neither at a root of the springs' force nor where the stop begins."""
    found = exact(sp.System(SPRING, sp.Constant(-push), sp.Contact(-0.1, 50.0), DASHPOT, WHITE))
    middle = -0.1 - (push / 50.0) ** (1.0 / 1.5)
    x = np.linspace(middle - 4.0, 12.0 if push < 2.0 else middle + 4.0, 800001)
    u = 0.5 * x * x + push * x + 20.0 * np.maximum(-0.1 - x, 0.0) ** 2.5
    p = np.exp(u.min() - u)
    total = integrate.simpson(p, x=x)
    mean, square = (integrate.simpson(p * x**n, x=x) / total for n in (1, 2))
    assert (found.x_mean, found.x_mean_square) == pytest.approx((mean, square), rel=1e-8)
    assert found.v_mean_square == pytest.approx(1.0, rel=1e-12)


def test_energies_beyond_double_precision_are_said_so() -> None:
    """Soon: what rounding leaves open no finer panel settles."""

    def found(temperature: float) -> Exact:
        return exact(sp.System(sp.Spring(-1.0), cubic(1.0), sp.Dashpot(1.0), sp.ThermalNoise(temperature)))

    for temperature in (1e-14, 1e-40):
        with pytest.raises(NoConvergenceError, match="double precision"):
            found(temperature)
    near = found(1e-11)  # two normal densities of the variance kT / 2
    assert near.x_density(1.0) == pytest.approx(0.5 / math.sqrt(math.pi * 1e-11), rel=2e-4)
    assert near.x_mean_square == pytest.approx(1.0, abs=1e-10)
    assert len(near.warnings) == 1
    assert "rounding changes the density by 8e-05" in near.warnings[0]


def test_matched_noise_needs_a_dissipator() -> None:
    for nothing in (sp.Springpot(0.0, 1.0), sp.Springpot(0.5, 0.0)):
        with pytest.raises(NotCoveredError, match="needs something that dissipates"):
            exact(sp.System(SPRING, nothing, sp.ThermalNoise(1.0)))
    both = sp.System(SPRING, sp.Springpot(1.0, 0.5), sp.ThermalNoise(1.0), WHITE)  # a dashpot by another name
    assert exact(both).v_mean_square == pytest.approx(2.0)


# --- linear --------------------------------------------------------------------------------------------------------

POT = sp.Springpot(0.5, 0.6)
TWO_POTS = sp.Spring(2.25), sp.Springpot(0.3, 0.5), sp.Springpot(0.7, 0.4), sp.Dashpot(0.1), sp.WhiteNoise(2.0)


@pytest.mark.parametrize(
    ("parts", "x", "v"),
    [
        (TWO_POTS, 0.63529, 1.89712),
        ((SPRING, POT, sp.ColoredNoise(1.0, 0.5)), 0.75668, 0.89368),
        ((sp.Spring(4.0), POT, sp.KanaiTajimiNoise(3.0, 0.4, 1.0)), 0.84854, 3.94674),
        ((SPRING, POT, sp.Harmonic(0.8, 1.2), sp.WhiteNoise(0.2)), 1.67331, 2.40655),
        ((SPRING, POT, sp.PoissonImpulses(0.5, 2.0)), 0.98010, 1.39626),
        ((SPRING, sp.Springpot(0.5, 0.3), sp.ParametricNoise(0.1), sp.WhiteNoise(0.5)), 1.35810, 1.64626),
        ((SPRING, sp.Dashpot(0.5), sp.ParametricNoise(0.2), WHITE), 1.25, 1.25),
        ((SPRING, sp.Dashpot(0.4), sp.ColoredNoise(1.0, 0.5)), 1.034483, 0.862069),
    ],
)  # fmt: skip
def test_linear_systems_with_every_excitation(parts, x: float, v: float) -> None:
    found = linear(sp.System(*parts))
    assert (found.x_mean_square, found.v_mean_square) == pytest.approx((x, v), abs=6e-6)


@pytest.mark.parametrize(
    ("order", "c"), [(0.02, 1.0), (0.1, 100.0), (0.5, 1e-5), (0.5, 1.0), (0.9, 50.0), (0.99, 1e-4), (1.0, 3.0)]
)
def test_of_a_free_oscillator_it_is_the_exact_answer(order: float, c: float) -> None:
    """Two ways to the same integrals: along the real frequencies, and by contours."""
    asked = sp.Oscillator(1.7, sp.Springpot(order, c), None, sp.WhiteNoise(2.0))
    ours, theirs = linear(asked), exact(asked)
    for name in ("x_mean_square", "v_mean_square", "amplitude_mean_square"):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), rel=2e-9)
    w = np.array([0.3, 1.0, 4.0])
    assert ours.spectrum(w) == pytest.approx(theirs.spectrum(w), rel=1e-10)


def test_a_harvester_in_closed_form() -> None:
    """Dashpot and circuit: Lyapunov's equation solved by hand; in volts the coupling is theta / m and theta / Cp."""
    mass, theta, resistance, capacitance, c, k, q = 0.4, 0.7, 3.0, 0.8, 0.1, 2.0, 1.5
    device = sp.System(
        sp.Mass(mass),
        sp.Spring(k),
        sp.Dashpot(c),
        sp.PiezoelectricCircuit(theta, resistance, capacitance),
        sp.WhiteNoise(q),
    )
    found = linear(device)
    a, g, o2, c1, q1 = (
        1.0 / (resistance * capacitance),
        theta**2 / (mass * capacitance),
        k / mass,
        c / mass,
        q / mass**2,
    )
    b = c1 * o2 + (c1 + a) * (c1 * a + g)
    voltage = (theta / capacitance) ** 2 * q1 / (2.0 * b)
    assert found.harvested_power == pytest.approx(voltage / resistance, rel=1e-9)
    assert found.v_mean_square == pytest.approx(q1 * (o2 + c1 * a + g + a * a) / (2.0 * b), rel=1e-9)
    assert found.x_mean_square == pytest.approx(q1 * (o2 + a * (a + c1)) / (2.0 * o2 * b), rel=1e-9)
    fed, dashpot = q / (2.0 * mass), c * found.v_mean_square
    assert found.harvested_power + dashpot == pytest.approx(fed, rel=1e-9)  # what is fed is used


def test_matched_noise_is_equipartition() -> None:
    parts = (
        sp.Springpot(0.3, 0.8), sp.Springpot(0.7, 0.3), sp.Maxwell(1.0, 2.0), sp.PiezoelectricCircuit(0.3, 2.0, 0.5),
        sp.Dashpot(0.1), sp.FractionalMaxwell(sp.Springpot(0.4, 2.0), sp.Spring(3.0)),
    )  # fmt: skip
    for part in parts:
        found = linear(sp.System(sp.Mass(2.0), sp.Spring(8.0), part, sp.ThermalNoise(0.7)))
        assert found.x_mean_square == pytest.approx(0.7 / 8.0, rel=1e-7), part
        assert found.v_mean_square == pytest.approx(0.7 / 2.0, rel=1e-7), part


@pytest.mark.parametrize(
    "part",
    [
        sp.Springpot(0.3, 0.8), validation(sp.Maxwell(1.0, 2.0)),
        validation(sp.PiezoelectricCircuit(3.0, 2.0, 0.5)), validation(sp.FractionalMaxwell(POT, sp.Spring(3.0))),
    ],
)  # fmt: skip
def test_the_spectrum_of_matched_noise_is_that_of_equipartition(part) -> None:
    found = linear(sp.System(sp.Mass(2.0), sp.Spring(8.0), part, sp.ThermalNoise(0.7)))
    u = np.linspace(-75.0, 12.0, 60001)
    w = np.exp(u)
    assert 2.0 * integrate.simpson(found.spectrum(w) * w, x=u) == pytest.approx(0.7 / 8.0, rel=1e-7)
    assert 2.0 * integrate.simpson(found.spectrum(w) * w**3, x=u) == pytest.approx(0.7 / 2.0, rel=1e-4)


@pytest.mark.parametrize(
    ("order", "c"), thinned(itertools.product([0.001, 0.03, 0.5, 0.97], [1e-7, 1e-4, 1.0, 1e8]), 3)
)
def test_small_and_large_springpots(order: float, c: float) -> None:
    """Very light damping, orders at both ends: no integral overflows, and none is wrong."""
    asked = sp.Oscillator(1.0, sp.Springpot(order, c), None, WHITE)
    hot = linear(sp.System(SPRING, sp.Springpot(order, c), sp.ThermalNoise(2.0)))
    assert (hot.x_mean_square, hot.v_mean_square) == pytest.approx((2.0, 2.0), rel=1e-12)
    try:
        ours = linear(asked)
    except NoConvergenceError:
        assert order * c < 1e-8  # narrower than frequencies can be told apart
        return
    theirs = exact(asked)
    assert ours.x_mean_square == pytest.approx(theirs.x_mean_square, rel=3e-8)
    assert ours.v_mean_square == pytest.approx(theirs.v_mean_square, rel=3e-8)


def test_far_filters_do_not_overflow() -> None:
    noise = sp.KanaiTajimiNoise(2.0, 0.3, 1.5)
    assert noise.density(1e200) == pytest.approx(0.0, abs=1e-300)
    w = 2.4
    passed = (16.0 + (1.2 * w) ** 2) / ((4.0 - w * w) ** 2 + (1.2 * w) ** 2)
    assert noise.density(w) == noise.density(-w) == pytest.approx(1.5 / (2.0 * math.pi) * passed, rel=1e-14)


def test_ground_and_force_differ_by_the_mass() -> None:
    base = sp.Mass(3.0), sp.Spring(6.0), sp.Dashpot(0.6)
    for shaken, pushed in (
        (sp.WhiteNoise(2.0, on="ground"), sp.WhiteNoise(18.0)),
        (sp.ColoredNoise(2.0, 0.5, on="ground"), sp.ColoredNoise(18.0, 0.5)),
        (sp.KanaiTajimiNoise(2.0, 0.5, 1.0), sp.KanaiTajimiNoise(2.0, 0.5, 9.0, on="mass")),
        (sp.Harmonic(2.0, 1.0, on="ground"), sp.Harmonic(6.0, 1.0)),
        (sp.PoissonImpulses(2.0, 1.0, on="ground"), sp.PoissonImpulses(2.0, 9.0)),
    ):
        one, other = (linear(sp.System(*base, part)) for part in (shaken, pushed))
        assert one.x_mean_square == pytest.approx(other.x_mean_square, rel=1e-12)


def test_frequency_response_is_displacement_over_force() -> None:
    found = linear(sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Springpot(0.5, 0.4), sp.Constant(4.0), WHITE))
    w = 1.3
    wanted = 1.0 / (8.0 - 2.0 * w * w + 0.4 * (1j * w) ** 0.5)
    assert complex(found.frequency_response(w)) == pytest.approx(wanted, rel=1e-12)
    assert found.x_mean == pytest.approx(0.5)
    assert found.x_mean_square - 0.25 == pytest.approx(
        linear(sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Springpot(0.5, 0.4), WHITE)).x_mean_square
    )


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((SPRING, sp.Barrier(0.0)), "not barrier"),
        ((SPRING, cubic(1.0)), "not polynomial_spring"),
        ((SPRING, sp.VanDerPol(1.0)), "not van_der_pol"),
        ((SPRING, sp.PolynomialDashpot((0.0, 1.0))), "not polynomial_dashpot"),
        ((SPRING, sp.Contact(-1.0, 1.0)), "not contact"),
    ],
)
def test_what_is_not_linear_is_named(parts, sentence: str) -> None:
    with pytest.raises(NotCoveredError, match=sentence):
        linear(sp.System(*parts, WHITE))


def test_too_much_parametric_noise_has_no_mean_square() -> None:
    found = linear(sp.System(SPRING, sp.Dashpot(0.5), sp.ParametricNoise(1.0), WHITE))  # stable below 2 c Omega^2 = 1
    assert "feeds more than is dissipated" in str(found.stationary)
    assert "wanders without end" in str(linear(sp.System(sp.Dashpot(1.0), WHITE)).stationary)
    assert "nothing dissipates" in str(linear(sp.System(SPRING, sp.Springpot(0.0, 1.0), WHITE)).stationary)


# --- linearization -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("memory", "k3", "x", "v"),
    [
        (sp.Springpot(0.5, 1.0), 1.0, 0.34603, 0.9978),
        validation(sp.Springpot(0.5, 0.5), 0.2, 0.9081, 1.7609),
        validation(sp.Springpot(0.6, 0.3), 1.0, 0.7648, 2.7116),
        (sp.Dashpot(0.5), 1.0, 0.43426, 1.0),
    ],
)
def test_fractional_duffing(memory, k3: float, x: float, v: float) -> None:
    found = linearization(sp.System(SPRING, cubic(k3), memory, WHITE))
    assert (found.x_mean_square, found.v_mean_square) == pytest.approx((x, v), abs=6e-5)
    assert found.stiffness == pytest.approx(1.0 + 3.0 * k3 * found.x_mean_square, rel=1e-6)


def test_of_a_linear_system_it_is_linear() -> None:
    parts = sp.Mass(2.0), sp.Spring(8.0), sp.Springpot(0.5, 1.0), sp.Constant(4.0), sp.ColoredNoise(3.0, 0.2)
    ours, theirs = linearization(sp.System(*parts)), linear(sp.System(*parts))
    for name in ("x_mean", "x_mean_square", "v_mean_square", "amplitude_mean_square"):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), rel=1e-7)
    assert (ours.stiffness, ours.damping) == pytest.approx((8.0, 0.0))


def test_an_asymmetric_spring_shifts_the_mean() -> None:
    parts = sp.Mass(2.0), sp.Spring(2.0), cubic(0.2, 0.4), sp.Dashpot(1.0), sp.WhiteNoise(0.8), sp.Constant(0.2)
    ours, true = linearization(sp.System(*parts)), exact(sp.System(*parts))
    m, square = ours.x_mean, ours.x_mean_square - ours.x_mean**2
    force = 2.0 * m + 0.4 * (m * m + square) + 0.2 * (m**3 + 3.0 * m * square) - 0.2
    assert force == pytest.approx(0.0, abs=1e-7)  # the mean force balances
    assert ours.x_mean_square == pytest.approx(true.x_mean_square, rel=0.08)
    assert ours.v_mean_square == pytest.approx(true.v_mean_square, rel=1e-7)


def test_dampers_by_their_equivalents() -> None:
    """c3: 3 c3 <v^2>; c2: 2 sqrt(2 / pi) c2 sigma_v; by energy: fed = dissipated in the Gaussian state."""
    found = linearization(sp.System(SPRING, sp.PolynomialDashpot((0.1, 0.2, 0.3)), WHITE))
    s = math.sqrt(found.v_mean_square)
    assert found.damping == pytest.approx(0.1 + 0.2 * 2.0 * math.sqrt(2.0 / math.pi) * s + 0.9 * s * s, rel=1e-6)
    assert found.damping * s * s == pytest.approx(0.5, rel=1e-6)


def test_what_linearization_does_not_cover() -> None:
    for parts, sentence in (
        ((sp.Spring(-1.0), cubic(1.0), sp.Dashpot(1.0)), "not two wells"),
        ((SPRING, sp.Dashpot(1.0), sp.Harmonic(1.0, 1.0)), "not harmonic"),
        ((SPRING, sp.Dashpot(1.0), sp.Barrier(0.0)), "not barrier"),
    ):
        with pytest.raises(NotCoveredError, match=sentence):
            linearization(sp.System(*parts, WHITE))


def test_two_wells_beside_far_roots_are_seen() -> None:
    """U' = x (x^2 - 1) (x^2 + 1e12): complex roots far away must not hide that there are two wells."""
    with pytest.raises(NotCoveredError, match="not two wells"):
        linearization(sp.System(sp.Spring(-1e12), sp.PolynomialSpring((0, 0, 1e12 - 1.0, 0, 1.0)), DASHPOT, WHITE))
    one_flat = sp.System(sp.PolynomialSpring((3.0, -3.0, 1.0)), DASHPOT, WHITE)  # (x - 1)^3 and a constant force
    assert linearization(one_flat).x_mean_square > 0.0


@pytest.mark.parametrize("power", [1, 3, validation(5), validation(7), 9])
@pytest.mark.parametrize("linear_stiffness", [1e-9, validation(1e-3)])
def test_a_spring_far_from_linear_warns(power: int, linear_stiffness: float) -> None:
    parts = sp.Spring(linear_stiffness), sp.PolynomialSpring((0.0,) * (power - 1) + (1.0,)), DASHPOT, WHITE
    near, true = linearization(sp.System(*parts)), exact(sp.System(*parts))
    error = near.x_mean_square / true.x_mean_square - 1.0
    assert (abs(error) > 0.05) == bool(near.warnings)
    if near.warnings:
        assert near.warnings[0].endswith("its variance comes out too small.")
        assert error < 0.0


def test_limit_cycles_and_rare_impulses_warn() -> None:
    pumped = linearization(sp.System(SPRING, sp.VanDerPol(0.1), WHITE))
    assert any("limit cycle" in warning for warning in pumped.warnings)
    hardening = SPRING, cubic(0.1), DASHPOT
    assert any("so rare" in warning for warning in linearization(
        sp.System(*hardening, sp.PoissonImpulses(1e-3, 1e3))).warnings)  # fmt: skip
    assert not any("so rare" in warning for warning in linearization(
        sp.System(*hardening, sp.PoissonImpulses(1e3, 1e-3))).warnings)  # fmt: skip


def test_linearization_without_noise_or_dissipation_says_so() -> None:
    for noise in ((), (sp.WhiteNoise(0.0),)):
        quiet = linearization(sp.System(SPRING, cubic(1.0), DASHPOT, *noise))
        assert "nothing excites" in str(quiet.stationary)
        assert math.isnan(quiet.stiffness)
    assert "nothing dissipates" in str(linearization(sp.System(SPRING, cubic(1.0), WHITE)).stationary)


def test_names_of_parts_are_free() -> None:
    parts = {"self": SPRING, "held": DASHPOT, "_held": sp.Constant(1.0), "parts": WHITE}
    found = linearization(sp.System(**parts))
    assert (found.x_mean, found.x_mean_square) == pytest.approx((1.0, 2.0))


def test_the_spectrum_of_matched_noise_at_zero_frequency() -> None:
    assert linear(sp.System(SPRING, DASHPOT, sp.ThermalNoise(2.0))).spectrum(0.0) == pytest.approx(1.0 / math.pi)
    assert linear(sp.System(SPRING, POT, sp.ThermalNoise(2.0))).spectrum(0.0) == math.inf


def test_the_exact_law_has_the_speeds_of_impacts_on_all_walls() -> None:
    walls = sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below")
    found = exact(sp.System(SPRING, cubic(1.0), sp.Dashpot(0.4), WHITE, *walls))
    speed = np.linspace(0.0, 15.0, 30_001)
    density = found.impact_speed_density(speed)
    assert np.trapezoid(density, speed) == pytest.approx(1.0, abs=1e-6)
    assert np.trapezoid(density * speed, speed) == pytest.approx(found.impact_speed_mean, rel=1e-6)
    with pytest.raises(NotCoveredError, match="no wall to strike"):
        exact(sp.System(SPRING, cubic(1.0), sp.Dashpot(0.4), WHITE)).impact_speed_density(1.0)


# --- together ------------------------------------------------------------------------------------------------------


def test_all_methods_answer_or_say_why() -> None:
    device = sp.System(SPRING, cubic(1.0), sp.Dashpot(0.5), WHITE)
    answers, statements = solve_all(device)
    assert list(answers) == ["averaging_amplitude", "linearization", "envelope", "exact"]
    assert statements["linear"].endswith("not polynomial_spring.")
    assert statements["memory_closure"].startswith("polynomial_spring cannot be part of an Oscillator")
    assert json.loads(json.dumps(answers["exact"].to_dict()))["x_mean_square"] == pytest.approx(0.46792, abs=1e-5)
    for system in (device, 3.0):
        with pytest.raises((NotCoveredError, TypeError)):
            sp.theory.memory_closure(system)


def test_a_system_that_is_an_oscillator_has_its_theory() -> None:
    asked = sp.Oscillator(2.0, sp.Springpot(0.5, 0.3), sp.Barrier(-0.1, 0.9), sp.WhiteNoise(0.5))
    assert sp.theory.envelope(asked).moments == sp.theory.envelope(asked).moments
    assert "memory_closure" in solve_all(asked)[0]


@pytest.mark.parametrize("damper", [sp.Dashpot(0.1), sp.Springpot(0.5, 0.1)])
def test_a_springpot_of_order_0_may_be_the_only_spring(damper: sp.Dashpot | sp.Springpot) -> None:
    found, usual = (
        sp.theory.linearization(sp.System(spring, damper, sp.WhiteNoise(1.0)))
        for spring in (sp.Springpot(0.0, 4.0), sp.Spring(4.0))
    )
    assert found.x_mean_square == pytest.approx(usual.x_mean_square, rel=1e-9)
    assert found.v_mean_square == pytest.approx(usual.v_mean_square, rel=1e-9)
    assert abs(found.x_mean) < 1e-9
    assert "linearization" in sp.explain(sp.System(sp.Springpot(0.0, 4.0), damper, sp.WhiteNoise(1.0)))


@pytest.mark.parametrize("noise", [WHITE, sp.ColoredNoise(1.0, 2.0), sp.ThermalNoise(1.0)])
def test_linearization_of_a_linear_system_warns_of_nothing(noise: object) -> None:
    """It is exact there, and warned of 21 and 50 %: its measure left out the springpots' stiffness."""
    for parts in ((SPRING, sp.Springpot(0.25, 3.0)), (SPRING, sp.PolynomialSpring((1.0,)), sp.Springpot(0.5, 1.0))):
        found = linearization(sp.System(*parts, noise))
        assert found.warnings == ()
        assert found.x_mean_square == pytest.approx(linear(sp.System(*parts, noise)).x_mean_square, rel=1e-6)


def test_linearization_warns_of_bent_springs_by_all_stiffness() -> None:
    """A springpot that is most of the stiffness makes a cubic spring a small part of it, but not in a bath."""
    bent, pot = cubic(1.0), sp.Springpot(0.25, 20.0)
    for noise, strained in ((WHITE, False), (sp.ThermalNoise(1.0), True)):
        warnings = linearization(sp.System(SPRING, bent, pot, noise)).warnings
        assert any("bend so much" in sentence for sentence in warnings) == strained
    light = linearization(sp.System(SPRING, bent, sp.Springpot(0.25, 0.05), WHITE))
    assert any("bend so much" in sentence for sentence in light.warnings)
