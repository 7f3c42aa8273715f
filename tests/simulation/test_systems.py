"""Monte Carlo of systems of parts: exact laws, energy, and the same bits however a run is made."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.problem.parts import WhiteNoise
from springpot.problem.parts.walls import restitution_at, slow_restitution
from springpot.simulation.error.budget import orders_of_step
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.estimate.step_biases import impact_biases
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.lowering.parts import lower
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.guess import dissipated
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.scales import Units
from tests.sizes import thinned, validation

from .problems import assert_agrees, values_of
from .systems import (
    AWAY,
    NEARLY_LINEAR,
    boltzmann,
    circuit,
    filtered,
    of_many_kinds,
    poisson_fourth_moment,
    rates_of_walls,
    white,
)

SPRING, WHITE = sp.Spring(1.0), WhiteNoise(1.0)
DUFFING = sp.PolynomialSpring((0.0, 0.1, 1.0))
WALLS = sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below")
FAINT = sp.ColoredNoise(1e-20, 1.0)


def duffing(x: np.ndarray) -> np.ndarray:
    return 0.5 * x * x + 0.1 * x**3 / 3.0 + 0.25 * x**4


def check(system: sp.System, exact: dict[str, float], *, sharp: float = 0.01, **given: Any) -> Any:
    options = {"paths": 6000, "duration": 50.0, "step": 0.04, "window": (20.0, 50.0), "start": "rest", **given}
    found = sp.simulate(system, **options)
    assert_agrees(found, exact, sharp=sharp)
    if "energy_residual" in found.estimates:
        assert abs(found["energy_residual"].value) < 4 * found["energy_residual"].error + 1e-9
    return found


# --- one kernel: white noise, a cubic spring, a Gaussian force and two walls ------------------------------------------


def test_dashpot_between_two_walls() -> None:
    """The numbers are those of the stationary law."""
    exact = rates_of_walls(boltzmann(1.25, duffing, -0.5, 1.2))
    known = {
        "x_mean": 0.25606, "x_mean_square": 0.27224, "barrier_1_impact_rate": 0.28165, "barrier_2_impact_rate": 0.11139
    }  # fmt: skip
    assert {name: exact[name] for name in known} == pytest.approx(known, abs=1e-5)
    exact["impact_rate"] = exact["barrier_1_impact_rate"] + exact["barrier_2_impact_rate"]
    law = boltzmann(1.25, duffing, -0.5, 1.2)
    exact |= {"barrier_1_force_mean": 1.25 * law["low"], "barrier_2_force_mean": 1.25 * law["high"]}  # kT times density
    exact["counted_impact_rate"] = math.exp(-(1.5**2) / 2.5) * exact["impact_rate"]  # the speeds have Rayleigh's law
    system = sp.System(SPRING, DUFFING, *WALLS, sp.Dashpot(0.4), FAINT, WHITE)
    found = check(system, exact, paths=12_000, slowest_counted_impact=1.5)
    assert found.units["counted_impact_rate"] == "s-1"


@pytest.mark.parametrize(
    "memory",
    [
        (sp.Springpot(0.8, 0.3), sp.Springpot(0.3, 0.7)),
        (sp.Maxwell(0.8, 1.5), sp.FractionalMaxwell(sp.Springpot(0.5, 0.8), sp.Spring(1.0)), sp.Dashpot(0.1)),
        (sp.Dashpot(0.5),),
    ],
    ids=["springpots", "arms", "dashpot"],
)
def test_thermal_noise(memory: tuple[Any, ...]) -> None:
    exact = rates_of_walls(boltzmann(0.7, duffing, -0.5, 1.2))
    system = sp.System(SPRING, DUFFING, *WALLS, *memory, sp.ThermalNoise(0.7))
    check(system, exact, paths=12_000, duration=20.0, step=0.05, window=(0.0, 20.0), start="stationary", sharp=0.05)


@pytest.mark.parametrize(
    ("parts", "exact"),
    [
        ((sp.Springpot(0.5, 0.6), sp.ColoredNoise(1.0, 0.5)), (0.75668, 0.89368)),
        ((sp.Spring(3.0), sp.Springpot(0.5, 0.6), sp.KanaiTajimiNoise(3.0, 0.4, 1.0)), (0.84854, 3.94674)),
    ],
    ids=["colored", "filtered"],
)
def test_colored_noise(parts: tuple[Any, ...], exact: tuple[float, float]) -> None:
    known = dict(zip(("x_mean_square", "v_mean_square"), exact, strict=True))
    system = sp.System(SPRING, *parts, NEARLY_LINEAR, *AWAY, WhiteNoise(0.0))
    found = check(system, known, sharp=0.02)
    assert abs(found["x_mean"].value) < 4 * found["x_mean"].error


def test_power_fed_by_colored_noise() -> None:
    """s2 s G(s) at s = 1 / tau, for any memory."""
    parts = sp.Springpot(0.5, 0.6), sp.ColoredNoise(1.0, 0.5)
    found = check(sp.System(SPRING, *parts, NEARLY_LINEAR, *AWAY), {"colored_noise_power": 0.341966}, sharp=0.02)
    assert found["damping_power"].value == pytest.approx(0.341966, abs=4 * found["damping_power"].error)
    assert found["input_power"].value == pytest.approx(found["colored_noise_power"].value, rel=1e-6)


def test_colored_and_white_noise_share_their_normals() -> None:
    """Moments of the sum, power of the colored noise alone, and the balance of energy."""

    def density(w: float) -> float:
        return 0.8 / (2.0 * math.pi) + 0.5 / (math.pi * (1.0 + (0.5 * w) ** 2))

    exact = filtered(lambda p: 1.0 + 0.6 * p**0.5, density) | {"colored_noise_power": 0.341966}
    parts = sp.Springpot(0.5, 0.6), sp.ColoredNoise(1.0, 0.5), WhiteNoise(0.8)
    found = check(sp.System(SPRING, *parts, NEARLY_LINEAR, *AWAY), exact, sharp=0.02)
    assert abs(found["damping_power"].value - 0.341966 - 0.4) < 4 * found["damping_power"].error


@pytest.mark.parametrize("order", [validation(0.05), 0.9])
def test_springpot_in_series_with_a_spring(order: float) -> None:
    series, pot = sp.FractionalMaxwell(sp.Springpot(order, 0.8), sp.Spring(2.0)), sp.Springpot(0.9, 0.3)
    exact = filtered(lambda p: 1.0 + series.modulus(p) + pot.modulus(p), white(1.0), (1.0, 1.4))
    check(sp.System(SPRING, series, pot, NEARLY_LINEAR, *AWAY, FAINT, WHITE), exact, sharp=0.02)


def test_circuit_delivers_what_it_takes() -> None:
    part = sp.PiezoelectricCircuit(0.6, 2.5, 0.45)

    def modulus(p: complex) -> complex:
        return 1.0 + 0.4 * p + circuit(part)(p)

    exact = filtered(modulus, white(1.0))
    power = filtered(modulus, lambda w: abs(circuit(part)(1j * w) / part.coupling) ** 2 / (2.0 * math.pi))
    exact |= {"harvested_power": power["x_mean_square"] / part.resistance}
    check(sp.System(SPRING, sp.Dashpot(0.4), part, NEARLY_LINEAR, *AWAY, FAINT, WHITE), exact, sharp=0.02)


def test_energy_with_lossy_walls_and_memory() -> None:
    walls = sp.Barrier(-1.0, 0.9), sp.Barrier(0.7, 0.8, "below")
    system = sp.System(SPRING, sp.Springpot(0.5, 0.3), NEARLY_LINEAR, *walls, FAINT, WHITE)
    found = check(system, {"input_power": 0.5}, sharp=0.02)
    taken = sum(found[name].value for name in ("damping_power", "barrier_1_power", "barrier_2_power"))
    assert taken == pytest.approx(0.5, rel=0.03)
    assert found["damping_power"].value == pytest.approx(0.1968, rel=0.03)


# --- nonlinear dampers, a rigid wall ----------------------------------------------------------------------------------


def test_van_der_pol_and_rayleigh_with_a_wall() -> None:
    parts = sp.Dashpot(0.0), sp.VanDerPol(0.3), sp.PolynomialDashpot((0.0, 0.0, 0.3)), WhiteNoise(0.5), sp.Barrier(-0.5)
    exact = {
        "x_mean": 0.46633, "x_mean_square": 0.56726, "v_mean_square": 0.80043, "impact_rate": 0.21474,
        "impact_speed_mean": 1.08581,
    }  # fmt: skip
    check(of_many_kinds(SPRING, *parts), exact, paths=10_000)


# --- soft contacts ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("contact", "known"),
    [validation(sp.Contact(-0.2, 50.0), (0.52414, 0.75815)), (sp.Contact(-0.2, 20.0, 1.0), (0.51677, 0.7574))],
)
def test_soft_stops(contact: sp.Contact, known: tuple[float, float]) -> None:
    exact = dict(zip(("x_mean", "x_mean_square"), known, strict=True)) | {"v_mean_square": 1.0}
    check(of_many_kinds(SPRING, sp.Dashpot(0.5), contact, WHITE), exact, sharp=0.02)


def test_a_touch_counts_also_where_a_wall_close_behind_sends_the_mass_out_within_a_short_step() -> None:
    parts = sp.Spring(1.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0)
    device = of_many_kinds(*parts, sp.Contact(-0.5, 100.0, 1.0), sp.Barrier(-0.501, 0.7))
    rates = values_of(sp.simulate(device, paths=512, duration=40.0, seed=3))
    touches, all_impacts = rates["contact_impact_rate"], rates["impact_rate"]
    assert 0.98 < touches / (all_impacts - touches) < 1.02


@pytest.mark.parametrize(("chi", "known"), [(0.1, 0.937476), (0.6, 0.711950)])
@pytest.mark.parametrize(
    ("exponent", "side"), [validation(1.0, "above"), (1.5, "above"), (1.0, "below"), validation(1.5, "below")]
)
def test_restitution_of_hunt_and_crossley(chi: float, known: float, exponent: float, side: Any) -> None:
    """chi v (1 + e) = ln[(1 + chi v) / (1 - chi v e)], for any exponent and stiffness."""
    sign = 1.0 if side == "above" else -1.0
    system = of_many_kinds(sp.Spring(1e-6), sp.Contact(0.0, 100.0, exponent, chi, side), WhiteNoise(0.0))
    found = sp.simulate(
        system, paths=1, duration=3.0, step=0.05, start="rest", initial_position=0.4 * sign, initial_velocity=-sign
    )
    assert math.sqrt(found["v_mean_square_end"].value) == pytest.approx(known, rel=2e-3)


# --- Poisson impulses, a harmonic force, parametric and white noise ---------------------------------------------------


def all_at_once(
    pot: Any, white: float = 1e-14, parametric: float = 1e-14, impulses: float = 1e-14, force: float = 0.0
) -> sp.System:
    return of_many_kinds(
        SPRING, pot, WhiteNoise(white), sp.ParametricNoise(parametric), sp.PoissonImpulses(0.5, 2.0 * impulses),
        sp.Harmonic(force, 1.2),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("system", "exact"),
    [
        (all_at_once(sp.Springpot(0.5, 0.6), white=0.2, force=0.8), (1.67331, 2.40655)),
        (all_at_once(sp.Springpot(0.5, 0.6), impulses=1.0), (0.98010, 1.39626)),
        (all_at_once(sp.Dashpot(0.5), white=1.0, parametric=0.2), (1.25, 1.25)),
    ],
    ids=["harmonic", "poisson", "parametric"],
)
def test_linear_numbers(system: sp.System, exact: tuple[float, float]) -> None:
    check(system, dict(zip(("x_mean_square", "v_mean_square"), exact, strict=True)), sharp=0.02)


def test_the_work_of_all_excitations() -> None:
    """Parametric and additive white noise, Poisson impulses and a harmonic force act on <x^2> as one equation."""
    pot = sp.Springpot(0.5, 0.6)
    alone = filtered(lambda p: 1.0 + pot.modulus(p), white(1.0))
    answer = 1.0 / abs(1.0 - 1.44 + pot.modulus(1.2j)) ** 2
    fed = 0.5 * 0.8**2 * answer
    square = (fed + 0.7 * alone["x_mean_square"]) / (1.0 - 0.1 * alone["x_mean_square"])
    exact = {
        "x_mean_square": square,
        "v_mean_square": 1.44 * fed + (0.7 + 0.1 * square) * alone["v_mean_square"],
        "input_power": 0.5 * (0.7 + 0.1 * square) + 0.5 * 0.8**2 * answer * pot.modulus(1.2j).imag * 1.2,
    }
    check(all_at_once(pot, white=0.2, parametric=0.1, impulses=0.5, force=0.8), exact, sharp=0.02)


def test_fourth_moment_of_poisson_impulses() -> None:
    known = poisson_fourth_moment(1.0, 0.6, 0.5, 2.0)
    assert known == pytest.approx(3.55971, abs=1e-5)
    found = sp.simulate(
        all_at_once(sp.Dashpot(0.6), impulses=1.0), paths=12_000, duration=60.0, step=0.05, window=(20.0, 60.0),
        start="rest", observables={"fourth": lambda t, x, v: x * x * x * x},
    )  # fmt: skip
    assert_agrees(found, {"fourth": known}, sharp=0.03)


# --- the same bits ----------------------------------------------------------------------------------------------------

KINDS = {
    "thermal": sp.System(SPRING, DUFFING, *WALLS, sp.Springpot(0.4, 0.5), sp.Maxwell(1.0, 2.0), sp.ThermalNoise(0.7)),
    "colored": sp.System(
        SPRING, DUFFING, *WALLS, sp.PiezoelectricCircuit(0.5, 2.0, 0.5), sp.ColoredNoise(1.0, 0.5), WHITE
    ),
    "filtered": sp.System(
        SPRING,
        DUFFING,
        sp.Barrier(-0.5, 0.7),
        sp.Barrier(1.2, 0.8, "below"),
        sp.Springpot(0.6, 0.4),
        sp.KanaiTajimiNoise(3.0, 0.4, 1.0),
        WHITE,
    ),
    "dampers": of_many_kinds(
        SPRING, sp.VanDerPol(0.3), sp.PolynomialDashpot((0.0, 0.1, 0.3)), sp.Barrier(-0.5, 0.8), WhiteNoise(0.5)
    ),
    "contact": of_many_kinds(SPRING, sp.Springpot(0.5, 0.4), sp.Contact(-0.2, 50.0, 1.5, 0.2), WHITE),
    "all": all_at_once(sp.Springpot(0.5, 0.6), white=0.2, parametric=0.1, impulses=0.5, force=0.8),
}


@pytest.mark.parametrize("name", thinned(KINDS, 2))
def test_bits_do_not_depend_on_threads_or_shards(name: str) -> None:
    system, paths = KINDS[name], 3 * LANES
    start: Any = "stationary" if name == "thermal" else "rest"
    plan = plan_of(system, paths=paths, duration=4.0, step=0.05, threads=1, start=start)
    whole = simulation_of(adapt(plan) if name == "thermal" else plan)
    rows = whole.advance().rows
    assert np.isfinite(rows).all()
    assert np.array_equal(rows, whole.but(threads=2).advance().rows)
    shards = [whole.but(paths=LANES * size).advance(skipped=LANES * skipped).rows for skipped, size in ((0, 1), (1, 2))]
    assert np.array_equal(rows, np.concatenate(shards))
    assert len(np.unique(rows[:, 0])) == paths  # no two paths are alike
    options: dict[str, Any] = {"paths": paths, "duration": 4.0, "step": 0.04, "start": start}
    found, again = (sp.simulate(system, threads=threads, **options) for threads in (1, 2))
    assert values_of(again) == pytest.approx(values_of(found), rel=0.0, abs=0.0, nan_ok=True)


def scaled(system: sp.System, length: float) -> sp.System:
    """The same system with x in another unit of length, a power of two; linear and quadratic quantities change."""

    def of(part: Any) -> Any:
        match part:
            case WhiteNoise():
                return WhiteNoise(part.intensity * length**2)
            case sp.ThermalNoise():
                return sp.ThermalNoise(part.temperature * length**2)
            case sp.ColoredNoise():
                return sp.ColoredNoise(part.variance * length**2, part.correlation_time)
            case sp.KanaiTajimiNoise():
                return sp.KanaiTajimiNoise(part.frequency, part.damping, part.intensity * length**2)
            case sp.PoissonImpulses():
                return sp.PoissonImpulses(part.rate, part.mean_square * length**2)
            case sp.Harmonic():
                return sp.Harmonic(part.amplitude * length, part.frequency)
            case sp.PolynomialSpring():
                return sp.PolynomialSpring(tuple(k / length**n for n, k in enumerate(part.coefficients)))
            case sp.PolynomialDashpot():
                return sp.PolynomialDashpot(tuple(c / length**n for n, c in enumerate(part.coefficients)))
            case sp.VanDerPol():
                return sp.VanDerPol(part.coefficient / length**2, part.length * length)
            case sp.Barrier():
                return sp.Barrier(part.position * length, part.restitution, part.free_side)
            case sp.Contact():
                stiffness = part.stiffness * length ** (1.0 - part.exponent)
                return sp.Contact(
                    part.position * length, stiffness, part.exponent, part.dissipation / length, part.free_side
                )
        return part

    return sp.System(**{name: of(part) for name, part in system.named()})


@pytest.mark.parametrize("name", thinned(KINDS, 2))
def test_another_unit_of_length_changes_no_bit(name: str) -> None:
    """By 16, whose root is a power of two as well."""
    options: dict[str, Any] = {
        "paths": 2 * LANES, "duration": 3.0, "step": 0.05, "start": "rest" if name != "thermal" else "stationary"
    }  # fmt: skip
    one, other = (values_of(sp.simulate(system, **options)) for system in (KINDS[name], scaled(KINDS[name], 16.0)))
    for key, power in (("x_mean", 1), ("x_mean_square", 2), ("v_mean_square", 2), ("input_power", 2)):
        assert other[key] == one[key] * 16.0**power, key


def test_mirrored_walls() -> None:
    """Walls, contacts and forces on the other side: the same law."""
    exact = rates_of_walls(boltzmann(1.25, duffing, -0.5, 1.2), ("barrier_2", "barrier_1"))
    exact["x_mean"] *= -1.0
    parts = SPRING, sp.PolynomialSpring((0.0, -0.1, 1.0)), sp.Barrier(-1.2), sp.Barrier(0.5, free_side="below")
    check(sp.System(*parts, sp.Dashpot(0.4), FAINT, WHITE), exact, paths=12_000)


def test_saved_and_loaded(tmp_path: Path) -> None:
    found = sp.simulate(KINDS["colored"], paths=2 * LANES, duration=3.0, step=0.05, start="rest")
    found.save(tmp_path / "run.json")
    again = sp.load_run(tmp_path / "run.json")
    assert values_of(again) == pytest.approx(values_of(found), rel=0, abs=0, nan_ok=True)
    assert again.system == KINDS["colored"]


# --- the memory of a springpot in series with a spring, and what is refused -------------------------------------------


@pytest.mark.parametrize("order", [0.05, 0.3, 0.5, 0.8, 0.95, 0.98])
def test_modes_of_a_series_relax_like_it(order: float) -> None:
    """The Laplace transform of the kernel, k / (p + p^(1 - order) k / c), at rates within the run."""
    series = sp.FractionalMaxwell(sp.Springpot(order, 0.8), sp.Spring(2.0))
    arms = lower(series, "series", Units(1.0, 1.0), 0.01).arms
    assert len(arms) < 60
    for p in (0.01, 0.1, 1.0, 2.5, 10.0):
        found = sum(p * arm.strength / (p + arm.rate) for arm in arms)
        assert found == pytest.approx(series.modulus(p), rel=2e-3 if order < 0.5 else 3e-4)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (tuple(sp.Contact(-1.0, 50.0 + n) for n in range(13)), "13 walls and contacts, .* holds at most 12"),
        ((sp.Contact(-1.0, 1e12), sp.Contact(1.0, 50.0, free_side="below")), "contact_1 is so stiff that half a step"),
        ((sp.Barrier(-1.0, lambda v: float(f"{v:.1f}")),), "barrier has a restitution that Numba cannot compile"),
        ((sp.PoissonImpulses(1e7, 1e-7),), "poisson_impulses"),
        (tuple(sp.FractionalMaxwell(sp.Springpot(0.5, 1.0), sp.Spring(0.1 * n)) for n in range(1, 31)), "memory modes"),
        (tuple(sp.Harmonic(1.0, 1.0 + n) for n in range(13)), "13 sources of other excitation, .* at most 12"),
        (tuple(sp.BoucWen(1.0, 0.1 + n) for n in range(13)), "13 nonlinear dampers and forces, .* at most 12"),
    ],
)
def test_what_is_refused(parts: tuple[Any, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        sp.simulate(sp.System(SPRING, sp.Dashpot(0.5), WHITE, *parts), paths=64, duration=1.0, step=0.01)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_restitution_that_falls_with_the_speed() -> None:
    """One impact of a flight: at 16 times the speed half the restitution, and the energy that the wall took."""
    speed, walls = (
        32.0,
        (sp.Barrier(-1.0, sp.PowerRestitution(0.5, 2.0, 0.25)), sp.Barrier(100.0, 0.9, free_side="below")),
    )
    end = 2.0 / speed
    found = sp.simulate(
        sp.System(sp.Spring(1e-9), *walls), paths=1, duration=end, step=end / 16, window=(0.0, end), record=1,
        start="rest", initial_velocity=-speed,
    )  # fmt: skip
    assert found.record[0, -1] == pytest.approx([-1.0 + 0.25, 0.25 * speed], rel=1e-6)
    assert found["barrier_1_power"].value * end == pytest.approx(0.5 * speed**2 * (1.0 - 0.25**2), rel=1e-6)
    assert found["barrier_1_impact_rate"].value * end == pytest.approx(1.0)
    assert found["barrier_2_impact_rate"].value == 0.0
    assert slow_restitution(sp.Barrier(0.0, sp.PowerRestitution(0.5, 2.0))) == 1.0


@pytest.mark.parametrize(
    ("parts", "theta"),
    [
        ((sp.PolynomialSpring((0.0, 0.0, 1.0)),), 1.0),
        ((sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below")), 1.0),
        ((sp.PolynomialSpring((0.0, 0.0, 1e-6)), sp.Barrier(0.1, free_side="above")), 1.0),
        ((SPRING, sp.Contact(0.5, 300.0, free_side="above")), 1.0),
        ((sp.Constant(-9.81), sp.Contact(0.0, 300.0)), 1.0),
        ((sp.Constant(1.0), sp.PolynomialSpring((0.0, 0.0, 0.0, 0.0, 1.0)), sp.Barrier(-0.7)), 1.0),
        ((sp.PolynomialSpring((0.0, 0.0, 1e24)), sp.Barrier(-1e-13), sp.Barrier(1e-12, free_side="below")), 1e-20),
    ],
    ids=["cubic", "box", "cubic-wall", "preloaded", "weight-on-contact", "sixth", "tiny"],
)
def test_temperature_of_any_potential(parts: tuple[Any, ...], theta: float) -> None:
    law = motion_of(sp.System(*parts, sp.Dashpot(0.5), WhiteNoise(theta))).law
    assert law.temperature == pytest.approx(theta, rel=1e-6)
    assert law.variance > 0.0


def test_a_temperature_that_the_search_meets_exactly_is_found() -> None:
    """q / (2 c) is ten times the first guess: the surplus there is zero, but for rounding."""
    device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(1.0))
    assert motion_of(device).law.temperature == pytest.approx(5.0, rel=1e-9)


def test_a_contact_alone_can_take_the_power() -> None:
    """Its loss at the guessed temperature is what is fed in, and the run takes it."""
    system = sp.System(SPRING, sp.Contact(-0.3, 50.0, 1.5, 0.2), sp.WhiteNoise(1.0))
    motion = motion_of(system)
    assert motion.not_stationary == ""
    assert dissipated(motion.unit.parts, motion.law) == pytest.approx(0.5, rel=1e-9)
    found = simulated(of_many_kinds(*system.parts), rtol=0.05, seed=1)
    assert found["contact_power"].value == pytest.approx(0.5, abs=1e-9 + 4.0 * found["contact_power"].error)
    assert found["v_mean_square"].value == pytest.approx(motion.law.temperature, rel=0.3)


def test_an_energy_that_drifts_without_any_noise_is_said() -> None:
    """All paths are alike, so the drift has no standard error."""
    growing = sp.System(SPRING, sp.VanDerPol(0.2, 1.0))
    found = simulated(
        growing, paths=8, duration=60.0, window=(40.0, 50.0), step=0.02, start="rest", initial_position=1e-3
    )
    assert found.warnings == (
        "not stationary: the mean energy still changes by 150 % from the beginning of the window to its end; a run "
        "with a window from 50 s on is needed.",
    )


def test_a_law_below_the_limit_at_the_speeds_of_a_step_is_far_too_low() -> None:
    """Rates of 1.74, 2.05 and 2.42 were measured at steps of 0.02, 0.005 and 0.00125 s with this law."""
    law = sp.PowerRestitution(0.25, speed=0.01)
    system = sp.System(
        sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0), sp.Barrier(0.4, law, free_side="above")
    )
    values = {"impact_rate": 1.74, "impact_speed_mean": 0.42, "impact_speed_mean_square": 0.5}
    for step in (0.02, 1e-3):  # the law is 0.13 and 0.19 at the speeds that these steps resolve
        assert impact_biases(motion_of(system), step, values)["impact_rate"] > 1.0
        assert orders_of_step(motion_of(system), "impact_rate", step)[0] < 0.25
    assert orders_of_step(motion_of(system), "v_mean_square", 0.02)[0] > 0.7


def test_a_law_that_is_no_number_at_some_speed_is_named() -> None:
    def law(speed: float) -> float:
        return 0.9 if speed < 2.0 else math.nan

    with pytest.raises(
        ValueError, match=r"restitution must be a number at every speed, but law\(v\) .* is NaN at 3 m/s"
    ):
        restitution_at(sp.Barrier(0.0, law), 3.0)


def test_walls_keep_their_names_where_paths_are_stored() -> None:
    walls = sp.Barrier(-0.5, 0.5), sp.Barrier(0.7, 0.5, free_side="below")
    system = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0), NEARLY_LINEAR, *walls)
    given: dict[str, Any] = {"paths": 64, "duration": 10.0, "step": 0.1}
    alone, stored = sp.simulate(system, **given).to_xarray(), sp.simulate(system, record=2, **given).to_xarray()
    assert stored["x"].dims == ("path", "time")
    assert list(stored["barrier"].values) == list(alone["barrier"].values) == ["barrier_1", "barrier_2"]
