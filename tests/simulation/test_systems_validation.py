"""Systems of parts against exact laws, sharp enough that a wrong factor of 2 % fails, and their energy balance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import springpot as sp
from tests.struck import rates_of

from .problems import assert_agrees, errors_of, values_of
from .systems import boltzmann, circuit, filtered, poisson_fourth_moment, rates_of_walls, white

pytestmark = pytest.mark.validation

SPRING, WHITE = sp.Spring(1.0), sp.WhiteNoise(1.0)
DUFFING = sp.PolynomialSpring((0.0, 0.1, 1.0))
WALLS = sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below")


def duffing(x: np.ndarray) -> np.ndarray:
    return 0.5 * x * x + 0.1 * x**3 / 3.0 + 0.25 * x**4


def check(system: sp.System, exact: dict[str, float], *, sharp: float = 0.005, **given: Any) -> Any:
    options = {"paths": 16_000, "duration": 120.0, "step": 0.025, "window": (40.0, 120.0), "seed": 11, **given}
    found = sp.simulate(system, **options)
    assert_agrees(found, exact, sharp=sharp)
    if "energy_residual" in found.estimates:  # there is noise with independent increments
        residual, error = found["energy_residual"].value, found["energy_residual"].error
        assert abs(residual) < 4 * error + 1e-12, f"energy_residual {residual} +- {error}"
    return found


# --- a dashpot and white noise: Boltzmann's law for any potential ---------------------------------------------------


@pytest.mark.parametrize(
    ("parts", "low", "high", "energy"),
    [
        ((SPRING, DUFFING, *WALLS), -0.5, 1.2, duffing),
        ((SPRING, *WALLS), -0.5, 1.2, lambda x: 0.5 * x * x),
        (
            (SPRING, sp.Barrier(0.3, free_side="above"), sp.Barrier(1.5, free_side="below")), 0.3, 1.5,
            lambda x: 0.5 * x * x,
        ),
        ((SPRING, sp.Barrier(-1.5), sp.Barrier(-0.3, free_side="below")), -1.5, -0.3, lambda x: 0.5 * x * x),
        ((SPRING, DUFFING, sp.Constant(-1.0), sp.Barrier(-0.5)), -0.5, 6.0, lambda x: duffing(x) + x),
        ((sp.Spring(-1.0), sp.PolynomialSpring((0, 0, 1.0)), WALLS[0]), -0.5, 6.0,
         lambda x: 0.25 * x**4 - 0.5 * x * x),
        ((sp.Constant(1.0), sp.PolynomialSpring((0, 0, 0, 0, 1.0)), sp.Barrier(-0.7)), -0.7, 5.0,
         lambda x: x**6 / 6.0 - x),
        ((sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Barrier(0.1, free_side="above")), 0.1, 6.0, lambda x: 0.25 * x**4),
    ],
    ids=["duffing", "linear", "pressed-down", "pressed-up", "preload", "two-wells", "sixth", "no-linear-spring"],
)  # fmt: skip
def test_dashpot_and_walls(parts: tuple[Any, ...], low: float, high: float, energy: Any) -> None:
    walls = sum(isinstance(part, sp.Barrier) for part in parts)
    names = ("barrier_1", "barrier_2") if walls == 2 else ("barrier",)
    exact = rates_of_walls(boltzmann(1.25, energy, low, high), names)
    if walls == 2:
        exact["impact_rate"] = exact["barrier_1_impact_rate"] + exact["barrier_2_impact_rate"]
    check(sp.System(*parts, sp.Dashpot(0.4), WHITE), exact, paths=24_000)


def test_the_numbers_of_two_walls() -> None:
    law = rates_of_walls(boltzmann(1.25, duffing, -0.5, 1.2))
    assert law["x_mean"] == pytest.approx(0.25606, abs=1e-5)
    assert law["x_mean_square"] == pytest.approx(0.27224, abs=1e-5)
    assert law["barrier_1_impact_rate"] == pytest.approx(0.28165, abs=1e-5)
    assert law["barrier_2_impact_rate"] == pytest.approx(0.11139, abs=1e-5)


@pytest.mark.parametrize(
    ("contacts", "step", "energy"),
    [
        ((sp.Contact(-0.2, 50.0),), 0.04, lambda x: 0.5 * x * x + 20.0 * np.maximum(-0.2 - x, 0.0) ** 2.5),
        ((sp.Contact(-0.2, 20.0, 1.0),), 0.04, lambda x: 0.5 * x * x + 10.0 * np.maximum(-0.2 - x, 0.0) ** 2),
        ((sp.Contact(-0.2, 2000.0, 2.0), sp.Contact(0.6, 3.0, 1.0, free_side="below")), 0.04,
         lambda x: 0.5 * x * x + 2000.0 * np.maximum(-0.2 - x, 0.0) ** 3 / 3.0 + 1.5 * np.maximum(x - 0.6, 0.0) ** 2),
        (
            (sp.Contact(0.5, 300.0, free_side="above"),),
            0.04,
            lambda x: 0.5 * x * x + 120.0 * np.maximum(0.5 - x, 0.0) ** 2.5,
        ),
    ],
    ids=["hertz", "linear", "both", "preloaded"],
)  # fmt: skip
def test_soft_stops(contacts: tuple[Any, ...], step: float, energy: Any) -> None:
    law = boltzmann(1.0, energy, -6.0, 6.0)
    exact = {name: law[name] for name in ("x_mean", "x_mean_square", "v_mean_square")}
    x = np.linspace(-6.0, 6.0, 200_001)
    weights = np.exp(-energy(x))
    weights /= np.trapezoid(weights, x)
    names = ["contact"] if len(contacts) == 1 else ["contact_1", "contact_2"]
    inside = np.zeros_like(x, bool)
    for name, contact in zip(names, contacts, strict=True):
        at = float(np.interp(contact.position, x, weights))
        exact[f"{name}_impact_rate"] = at / math.sqrt(2.0 * math.pi)
        exact[f"{name}_impact_speed_mean"] = math.sqrt(0.5 * math.pi)
        inside |= x < contact.position if contact.free_side == "above" else x > contact.position
    exact["contact_share"] = float(np.trapezoid(weights * inside, x))
    check(sp.System(SPRING, sp.Dashpot(0.5), *contacts, WHITE), exact, step=step, paths=24_000)


@pytest.mark.parametrize(
    "stops",
    [
        (sp.Contact(-0.3, 20.0), sp.Barrier(-0.6), sp.Barrier(1.0, free_side="below")),
        (sp.Contact(-0.2, 20.0, 1.0), sp.Contact(-0.5, 60.0), sp.Contact(0.4, 30.0, free_side="below")),
    ],
    ids=["rubber-before-steel", "two-on-one-side"],
)
def test_several_stops_on_one_side(stops: tuple[Any, ...]) -> None:
    system = sp.System(SPRING, sp.Dashpot(0.5), WHITE, *stops)
    law = sp.theory.exact(system)
    exact = {name: getattr(law, name) for name in ("x_mean", "x_mean_square", "v_mean_square", "impact_rate")}
    names = [name for name, part in system.named() if part in stops]
    exact |= {f"{name}_impact_rate": rate for name, rate in zip(names, rates_of(law), strict=True)}
    check(system, exact, step=0.01)


def _eight_tenths(speed: float) -> float:
    return 0.8


def test_a_law_of_restitution_that_is_a_number() -> None:
    """The laws have kernels of their own, which round in another way; the start is given: pilot runs round too."""
    parts = SPRING, sp.Springpot(0.5, 0.5), WHITE
    stop = sp.Barrier(0.5, 0.8, "below")
    given = {"paths": 500, "duration": 25.0, "window": (10.0, 25.0), "step": 0.02, "seed": 3, "memory_tolerance": 1e-8}
    given |= {"start": "rest", "initial_position": 0.095}
    number = sp.simulate(sp.System(*parts, sp.Barrier(-0.3, 0.8), stop), **given)
    for law in (_eight_tenths, sp.PowerRestitution(0.8, 1.0, 1e-12)):
        found = sp.simulate(sp.System(*parts, sp.Barrier(-0.3, law), stop), **given)
        for name, value in values_of(number).items():
            assert found[name].value == pytest.approx(value, rel=1e-6, abs=1e-8), name


@pytest.mark.parametrize("order", [0.5, 1.0])
def test_a_restitution_that_falls_with_the_speed(order: float) -> None:
    """The energy that the wall takes balances that of the noise, and the envelope is near."""
    wall = sp.Barrier(-0.3, sp.PowerRestitution(0.9, 0.5, 0.1))
    system = sp.System(SPRING, sp.Springpot(order, 0.05), sp.WhiteNoise(0.1), wall)
    found = check(system, {}, duration=160.0, window=(60.0, 160.0))
    taken = found["barrier_power"].value + found["damping_power"].value
    assert taken == pytest.approx(0.05, rel=0.01)
    theory = sp.theory.envelope(system).stationary
    assert found["x_mean_square"].value == pytest.approx(theory.x_mean_square, rel=0.03)
    assert found["barrier_impact_rate"].value == pytest.approx(theory.impact_rate, rel=0.05)


@pytest.mark.parametrize("scale", [1.0, 2e-3])
def test_van_der_pol_and_rayleigh_with_a_wall(scale: float) -> None:
    """In another unit of length, too."""
    system = sp.System(
        SPRING, sp.VanDerPol(0.3 / scale**2, scale), sp.PolynomialDashpot((0.0, 0.0, 0.3 / scale**2)),
        sp.WhiteNoise(0.5 * scale**2), sp.Barrier(-0.5 * scale),
    )  # fmt: skip
    exact = {
        "x_mean": 0.46633 * scale, "x_mean_square": 0.56726 * scale**2, "v_mean_square": 0.80043 * scale**2,
        "impact_rate": 0.21474, "impact_speed_mean": 1.08581 * scale,
    }  # fmt: skip
    check(system, exact, paths=24_000, duration=160.0)


# --- thermal noise --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "memory",
    [
        (sp.Springpot(0.8, 0.3), sp.Springpot(0.3, 0.7)),
        (sp.Springpot(0.3, 0.6),),
        (sp.Springpot(0.5, 0.6),),
        (sp.Springpot(0.7, 0.6),),
        (sp.Springpot(0.05, 3.0), sp.Dashpot(0.2)),
        (sp.Springpot(0.95, 0.5),),
        (sp.Maxwell(0.8, 1.5), sp.PiezoelectricCircuit(0.6, 2.0, 0.5)),
        (sp.Maxwell(40.0, 0.5),),
        (sp.FractionalMaxwell(sp.Springpot(0.5, 0.8), sp.Spring(2.0)),),
        (sp.FractionalMaxwell(sp.Springpot(0.9, 0.8), sp.Spring(2.0)), sp.Dashpot(0.1)),
    ],
    ids=["two", ".3", ".5", ".7", ".05", ".95", "maxwell-circuit", "stiff-maxwell", "series", "series-.9"],
)
def test_thermal_noise_gives_boltzmann(memory: tuple[Any, ...]) -> None:
    exact = rates_of_walls(boltzmann(0.7, duffing, -0.5, 1.2))
    assert exact["barrier_2_impact_rate"] == pytest.approx(0.04104, abs=1e-5)
    system = sp.System(SPRING, DUFFING, *WALLS, *memory, sp.ThermalNoise(0.7))
    check(system, exact, paths=48_000, duration=60.0, step=0.04, window=(0.0, 60.0), sharp=0.01)


def test_thermal_noise_with_a_soft_stop() -> None:
    law = boltzmann(0.7, lambda x: 0.5 * x * x + 20.0 * np.maximum(-0.2 - x, 0.0) ** 2.5, -6.0, 6.0)
    exact = {name: law[name] for name in ("x_mean", "x_mean_square", "v_mean_square")}
    system = sp.System(SPRING, sp.Springpot(0.5, 0.6), sp.Contact(-0.2, 50.0), sp.ThermalNoise(0.7))
    check(system, exact, paths=30_000, duration=60.0, step=0.04, window=(0.0, 60.0), sharp=0.008)


# --- linear systems: exact for any spectrum -------------------------------------------------------------------------

POT = sp.Springpot(0.5, 0.6)


def with_pots(*pots: Any, stiffness: float = 1.0) -> Any:
    return lambda p: stiffness + sum(pot.modulus(p) for pot in pots)


@pytest.mark.parametrize(
    ("parts", "exact"),
    [
        ((sp.Springpot(0.3, 1.0), WHITE), (0.77783, 1.50268)),
        ((sp.Springpot(0.8, 1.0), WHITE), (0.46509, 0.58975)),
        ((sp.Spring(1.25), sp.Springpot(0.3, 0.5), sp.Springpot(0.7, 0.4), sp.Dashpot(0.1), sp.WhiteNoise(2.0)),
         (0.63529, 1.89712)),
        ((POT, sp.ColoredNoise(1.0, 0.5)), (0.75668, 0.89368)),
        ((sp.Dashpot(0.4), sp.ColoredNoise(1.0, 0.5)), (1.034483, 0.862069)),
        ((sp.Spring(3.0), POT, sp.KanaiTajimiNoise(3.0, 0.4, 1.0)), (0.84854, 3.94674)),
        ((POT, sp.Harmonic(0.8, 1.2), sp.WhiteNoise(0.2)), (1.67331, 2.40655)),
        ((POT, sp.PoissonImpulses(0.5, 2.0)), (0.98010, 1.39626)),
        ((sp.Springpot(0.5, 0.3), sp.ParametricNoise(0.1), sp.WhiteNoise(0.5)), (1.35810, 1.64626)),
        ((sp.Dashpot(0.5), sp.ParametricNoise(0.2), WHITE), (1.25, 1.25)),
    ],
    ids=[".3", ".8", "three", "colored", "colored-dashpot", "filtered", "harmonic", "poisson", "parametric",
         "parametric-dashpot"],
)  # fmt: skip
def test_linear_numbers(parts: tuple[Any, ...], exact: tuple[float, float]) -> None:
    known = dict(zip(("x_mean_square", "v_mean_square"), exact, strict=True))
    check(sp.System(SPRING, *parts), known, paths=24_000, duration=160.0, window=(60.0, 160.0), sharp=0.006)


@pytest.mark.parametrize(
    "arms",
    [
        (sp.Maxwell(2.0, 1.0),),
        (sp.Maxwell(60.0, 0.4),),
        (sp.FractionalMaxwell(sp.Springpot(0.5, 0.8), sp.Spring(2.0)),),
        (sp.FractionalMaxwell(sp.Springpot(0.2, 1.8), sp.Spring(1.0)),),
        (sp.FractionalMaxwell(sp.Springpot(0.95, 0.8), sp.Spring(3.0)),),
        (sp.FractionalMaxwell(sp.Springpot(0.05, 1.8), sp.Spring(1.5)), sp.Springpot(0.9, 0.4)),
        (sp.Maxwell(1.0, 5.0), sp.FractionalMaxwell(sp.Springpot(0.7, 0.3), sp.Spring(9.0)), sp.Springpot(0.4, 0.2)),
    ],
    ids=["maxwell", "stiff", "series", "series-.2", "series-.95", "series-.05", "three"],
)
def test_arms(arms: tuple[Any, ...]) -> None:
    exact = filtered(with_pots(*arms), white(1.0))
    check(sp.System(SPRING, *arms, WHITE), exact, duration=160.0, window=(60.0, 160.0))


@pytest.mark.parametrize(
    ("pots", "part"), [((sp.Dashpot(0.2),), sp.PiezoelectricCircuit(0.6, 2.5, 0.45)), ((sp.Springpot(0.5, 0.3),),
                                                                          sp.PiezoelectricCircuit(1.1, 0.1, 3.0))]
)  # fmt: skip
@pytest.mark.parametrize("mass", [1.0, 3.0])
def test_circuit(pots: tuple[Any, ...], part: sp.PiezoelectricCircuit, mass: float) -> None:
    """The power that it takes from the motion is the power that it delivers, whatever the capacitance."""

    def of(p: complex) -> complex:
        own = sum(pot.modulus(p) if isinstance(pot, sp.Springpot) else pot.coefficient * p for pot in pots)
        return (1.0 + own + circuit(part)(p)) / mass

    exact = filtered(of, white(1.0 / mass**2), (mass**-0.5,))
    power = filtered(
        of, lambda w: abs(circuit(part)(1j * w) / part.coupling) ** 2 / (2.0 * math.pi * mass**2), (mass**-0.5,)
    )["x_mean_square"]
    exact |= {"piezoelectric_circuit_voltage_mean_square": power, "harvested_power": power / part.resistance}
    given = () if mass == 1.0 else (sp.Mass(mass),)
    found = check(sp.System(*given, SPRING, *pots, part, WHITE), exact, duration=200.0, window=(80.0, 200.0))
    assert found["input_power"].value == pytest.approx(0.5 / mass, rel=0.02)


def test_fourth_moment_of_poisson_impulses() -> None:
    known = poisson_fourth_moment(1.0, 0.6, 0.5, 2.0)
    assert known == pytest.approx(3.55971, abs=1e-5)
    system = sp.System(SPRING, sp.Dashpot(0.6), sp.PoissonImpulses(0.5, 2.0))
    found = sp.simulate(
        system, paths=60_000, duration=120.0, step=0.04, window=(20.0, 120.0), start="rest",
        observables={"fourth": lambda t, x, v: x * x * x * x},
    )  # fmt: skip
    assert_agrees(found, {"x_mean_square": 0.5 / 0.6, "v_mean_square": 0.5 / 0.6})
    assert_agrees(found, {"fourth": known}, sharp=0.01)


@pytest.mark.parametrize(("chi", "known"), [(0.1, 0.937476), (0.3, 0.832870), (0.6, 0.711950)])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("side", ["above", "below"])
def test_restitution_of_hunt_and_crossley(chi: float, known: float, exponent: float, side: Any) -> None:
    """chi v (1 + e) = ln[(1 + chi v) / (1 - chi v e)], for any exponent and stiffness."""
    sign = 1.0 if side == "above" else -1.0
    system = sp.System(sp.Spring(1e-6), sp.Contact(0.0, 100.0, exponent, chi, side), sp.WhiteNoise(0.0))
    found = sp.simulate(
        system, paths=1, duration=3.0, step=0.05, start="rest", initial_position=0.4 * sign, initial_velocity=-sign
    )
    assert math.sqrt(found["v_mean_square_end"].value) == pytest.approx(known, rel=2e-3)


# --- the energy balance of any combination ----------------------------------------------------------------------------

PARTS: dict[str, tuple[Any, ...]] = {
    "cubic": (sp.PolynomialSpring((0.0, 0.2, 0.6)),),
    "dashpot": (sp.Dashpot(0.3),),
    "powers": (sp.PolynomialDashpot((0.1, 0.2, 0.1)),),
    "van_der_pol": (sp.VanDerPol(0.2, 0.8),),
    "springpot": (sp.Springpot(0.4, 0.5),),
    "maxwell": (sp.Maxwell(0.8, 1.0),),
    "series": (sp.FractionalMaxwell(sp.Springpot(0.6, 0.7), sp.Spring(1.5)),),
    "circuit": (sp.PiezoelectricCircuit(0.6, 2.0, 0.5),),
    "wall": (sp.Barrier(-0.4, 0.8),),
    "walls": (sp.Barrier(-1.0, 0.9), sp.Barrier(0.7, 0.7, "below")),
    "contact": (sp.Contact(-0.3, 80.0, 1.5, 0.3),),
    "contacts": (sp.Contact(-0.3, 80.0, 1.0, 0.1), sp.Contact(0.8, 30.0, 2.0, 0.2, "below")),
    "colored": (sp.ColoredNoise(0.3, 0.5),),
    "filtered": (sp.KanaiTajimiNoise(3.0, 0.4, 0.3, "mass"),),
    "harmonic": (sp.Harmonic(0.5, 1.3),),
    "poisson": (sp.PoissonImpulses(0.8, 0.5),),
    "parametric": (sp.ParametricNoise(0.05),),
    "constant": (sp.Constant(-0.3),),
}


def combinations() -> list[tuple[str, ...]]:
    """Each part alone, and 40 of two to four parts."""
    dice = np.random.default_rng(7)
    found: list[tuple[str, ...]] = [(name,) for name in PARTS]
    while len(found) < len(PARTS) + 40:
        names = tuple(sorted(dice.choice(list(PARTS), size=int(dice.integers(2, 5)), replace=False)))
        stops = sum(name in ("wall", "walls", "contact", "contacts") for name in names)
        if stops <= 1 and names not in found:
            found.append(names)
    return found


@pytest.mark.parametrize("names", combinations(), ids="-".join)
def test_energy_balance(names: tuple[str, ...]) -> None:
    """Where it is an identity, the powers add up to rounding; the step's share of it is in the springs' potential."""
    parts = [part for name in names for part in PARTS[name]]
    system = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.2), *parts, sp.WhiteNoise(0.6))
    for step in (0.08, 0.02):
        found = sp.simulate(system, paths=3000, duration=50.0, step=step, window=(20.0, 50.0), start="rest", seed=23)
        values, errors = values_of(found), errors_of(found)
        assert abs(values["energy_residual"]) < 4 * errors["energy_residual"], f"step {step}: {values}"
        assert errors["energy_residual"] < 0.02
        known = 0.3 + (0.2 if "poisson" in names else 0.0)
        known += 0.025 * values["x_mean_square"] if "parametric" in names else 0.0
        fed = sum(values.get(f"{name}_power", 0.0) for name in ("colored_noise", "kanai_tajimi_noise", "harmonic"))
        assert values["input_power"] == pytest.approx(known + fed, rel=0.03 if step < 0.05 else 0.06)
        taken = sum(value for name, value in values.items() if name.endswith("_power")) - values["input_power"] - fed
        taken -= values.get("harvested_power", 0.0)
        assert taken == pytest.approx(values["input_power"], rel=0.03)
