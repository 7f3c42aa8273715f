"""Laws of parts between several masses: functions of the user, noise that multiplies an elongation, circuits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.problem.system import KINDS
from springpot.simulation.lowering.parts import lower
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.modes import modes_of
from springpot.theory.result import NoStationaryStateError
from tests.kernels import in_memory
from tests.simulation.test_several import (
    A_B,
    FREE,
    GROUND_A,
    GROUND_B,
    START,
    M,
    alone_and_held,
    check,
    linear_pair,
    masses,
)
from tests.sizes import validation

pytestmark = pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")

M_PAIR, K_PAIR, C_PAIR = np.diag([1.0, 0.5]), np.array([[3, -1], [-1, 1.5]]), np.array([[0.3, -0.1], [-0.1, 0.2]])
RATES = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M_PAIR, K_PAIR), -np.linalg.solve(M_PAIR, C_PAIR)]])
G_LINK, G_A = np.array([-1.0, 1.0]), np.array([1.0, 0.0])
"""x and v of `linear_pair` without more; the rows of A_B and GROUND_A."""


# --- a restitution that depends on the speed, forces of the user ----------------------------------------------------


def fading(v: float) -> float:
    return 0.9 / (1.0 + v)


def pull(t: float, x: float, v: float) -> float:
    return -0.8 * x**3 - 0.2 * v + 0.5 * math.cos(1.3 * t)


def link(t: float, x: float, v: float) -> float:
    return -0.6 * math.sin(2.0 * x) - 0.1 * v * abs(v)


@pytest.mark.parametrize("law", [sp.PowerRestitution(0.7, 0.5, 0.3), validation(fading)])
def test_a_restitution_that_depends_on_the_speed_is_what_was_asked(law: Any) -> None:
    """One impact: the velocities after it, momentum, and what the wall takes."""
    pair = sp.System(*FREE, gap=sp.Barrier(-0.2, law, between=A_B))
    run = sp.simulate(pair, paths=1, duration=1.0, step=0.01, window=(0.0, 1.0), record=1, **START)
    v, closing, reduced = run.record[0, :, :, 1], 1.2, 1.0 / (1.0 + 1.0 / 0.3)
    assert v[-1, 1] - v[-1, 0] == pytest.approx(law(closing) * closing, rel=1e-12)
    assert np.ptp(v @ M) < 1e-15
    assert run["gap_force_mean"].value == pytest.approx(reduced * (1.0 + law(closing)) * closing, rel=1e-12)
    assert run["gap_power"].value == pytest.approx(0.5 * reduced * (1.0 - law(closing) ** 2) * closing**2, rel=1e-12)


def test_functions_of_the_user_in_one_run() -> None:
    """Four masses with a wall each, with laws of their own, and two masses with forces, against an integration."""
    walls: dict[str, Any] = {"a": 0.8, "b": sp.PowerRestitution(0.7, 0.5, 0.3), "c": fading, "d": lambda v: 0.6}
    m, ends = {"e": 2.0, "f": 0.5}, ("e", "f")
    system = sp.System(
        *masses(**dict.fromkeys("abcd", 1.0), **m),
        *(sp.Spring(1.0, between=("ground", point)) for point in "abcdef"), *(sp.Spring(0.5, between=ends),),
        pull=sp.Force(pull, 1.5, on="e"), link=sp.Force(link, between=ends),
        **{f"at_{p}": sp.Barrier(0.0, law, "above", between=("ground", p)) for p, law in walls.items()},
    )  # fmt: skip
    run = sp.simulate(
        system, paths=1, duration=2.0, step=0.01, window=(0.0, 2.0), record=1,
        initial_position=dict.fromkeys("abcde", 1.0) | {"f": -0.5},
    )  # fmt: skip
    for point, law in walls.items():
        v = run[f"at_{point}_impact_speed_mean"].value
        r = law(v) if callable(law) else law
        assert v == pytest.approx(1.0, rel=1e-4)
        assert run[f"at_{point}_force_mean"].value == pytest.approx(0.5 * (1.0 + r) * v, rel=1e-6)
        assert run[f"at_{point}_power"].value == pytest.approx(0.25 * (1.0 - r**2) * v**2, rel=1e-6)

    def slope(t: float, s: Any) -> list[float]:
        e, f, ve, vf = s[:4]
        one, other = 1.5 * pull(t, e, ve), link(t, f - e, vf - ve)
        between = 0.5 * (f - e) - other
        return [ve, vf, (one - e + between) / 2.0, (-f - between) / 0.5, one * ve, other * (vf - ve)]

    exact = integrate.solve_ivp(slope, (0.0, 2.0), [1.0, -0.5, 0, 0, 0, 0], rtol=1e-10, atol=1e-12).y[:, -1]
    assert run.record[0, -1, 4:, :].T.ravel() == pytest.approx(exact[:4], rel=2e-4)
    assert run["pull_power"].value == pytest.approx(0.5 * exact[4], rel=1e-3)
    assert run["link_power"].value == pytest.approx(0.5 * exact[5], rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        (sp.PiezoelectricCircuit, (0.8, 1.5, 0.7)), validation(sp.Barrier, (-0.5, sp.PowerRestitution(0.7, 0.5, 0.3))),
        validation(sp.Barrier, (-0.5, fading)), validation(sp.Force, (pull,)),
    ],
)  # fmt: skip
def test_laws_between_a_mass_and_one_that_is_held(kind: Any, numbers: tuple[Any, ...]) -> None:
    """As one mass on the ground, with the same normals."""
    alone, held, names = alone_and_held(kind, numbers)
    assert len(names) > 4
    for name, other in names.items():
        assert abs(held[name].value - alone[other].value) <= 0.5 * alone[other].error + 5e-4 * abs(alone[other].value)
    assert abs(held["energy_residual"].value) < 4.0 * held["energy_residual"].error < 0.1


@pytest.mark.validation
def test_a_lossy_wall_with_a_law_of_its_own_has_a_balance_of_energy() -> None:
    pair = linear_pair(
        sp.WhiteNoise(0.5, on="b"), gap=sp.Barrier(-0.3, sp.PowerRestitution(0.7, 0.5, 0.3), between=A_B)
    )
    run = sp.simulate(pair, paths=12800, duration=200.0)
    assert run["gap_power"].value > 0.1 * run["input_power"].value
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.02


# --- noise that multiplies an elongation ----------------------------------------------------------------------------

SHAKEN = linear_pair(
    sp.WhiteNoise(0.5, on="b"), sp.ParametricNoise(0.05, between=A_B), sp.ParametricNoise(0.1, between=GROUND_A)
)


def second_moments(noises: dict[float, np.ndarray], push: np.ndarray, intensity: float) -> np.ndarray:
    """Of x and v of `linear_pair`, by Lyapunov's equation with what the noises that multiply elongations add."""
    size, kept = len(RATES), np.eye(len(RATES))
    operator = np.kron(RATES, kept) + np.kron(kept, RATES)
    for q, g in noises.items():
        kick, row = np.concatenate([0 * g, np.linalg.solve(M_PAIR, g)]), np.concatenate([g, 0 * g])
        operator += q * np.outer(np.kron(kick, kick), np.kron(row, row))
    kick = np.concatenate([0 * push, np.linalg.solve(M_PAIR, push)])
    return np.asarray(np.linalg.solve(operator, -intensity * np.kron(kick, kick)).reshape(size, size))


@pytest.mark.parametrize("paths", [1280, validation(20480)])
def test_noise_that_multiplies_elongations(paths: int) -> None:
    covariance = second_moments({0.05: G_LINK, 0.1: G_A}, np.array([0.0, 1.0]), 0.5)
    x, v = covariance[:2, :2], covariance[2:, 2:]
    link_square = float(G_LINK @ x @ G_LINK)
    exact = {f"{p}_{q}_mean_square": float(of[i, i]) for q, of in (("x", x), ("v", v)) for i, p in enumerate("ab")}
    exact["a_b_elongation_mean_square"] = link_square
    theory = sp.theory.linear(SHAKEN)
    assert [theory.moments[name] for name in exact] == pytest.approx([*exact.values()], rel=1e-9)
    assert theory.covariance() == pytest.approx(x, rel=1e-9)
    exact["input_power"] = exact["damping_power"] = 0.5 * (0.5 / 0.5 + 0.05 * link_square * 3.0 + 0.1 * x[0, 0])
    run = sp.simulate(SHAKEN, paths=paths, duration=200.0, window=(80.0, 200.0))
    check(run, exact, 0.002, precise=0.4 / np.sqrt(paths))
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.03


def test_the_guess_of_the_motion_counts_noise_that_multiplies_elongations() -> None:
    """The modes are nearly independent, so that the share by which it widens the motion is right within 3 %."""
    push, calm = np.array([0.0, 1.0]), linear_pair(sp.WhiteNoise(0.5, on="b"))
    exact, without = (second_moments(noises, push, 0.5)[:2, :2] for noises in ({0.05: G_LINK, 0.1: G_A}, {}))
    for row in (G_A, G_LINK):
        wider = float((row @ exact @ row) / (row @ without @ row))
        assert wider > 1.07
        assert (modes_of(SHAKEN).spread(row) / modes_of(calm).spread(row)) ** 2 == pytest.approx(wider, rel=0.03)


def test_noise_that_feeds_more_than_is_taken_has_no_mean_square() -> None:
    wild = linear_pair(sp.WhiteNoise(0.5, on="b"), sp.ParametricNoise(2.0, between=A_B))
    with pytest.raises(NoStationaryStateError, match="feeds more than is dissipated"):
        _ = sp.theory.linear(wild).a_x_mean_square
    assert np.isfinite(modes_of(wild).temperature).all()


@pytest.mark.parametrize(("place", "is_rough"), [(-0.3, True), (0.0, False)])
def test_noise_that_multiplies_a_gap_makes_its_impacts_countable_where_it_is_not_0(
    place: float, is_rough: bool
) -> None:
    smooth = sp.ColoredNoise(1.0, 1.0, on="b")
    wall = sp.Barrier(place, 0.8, "above", between=A_B)
    run = simulated(linear_pair(smooth, sp.ParametricNoise(0.1, between=("b", "a")), wall), paths=64, duration=10.0)
    assert (run["barrier_impact_rate"].value > 0.0) is is_rough


def test_held_noise_that_multiplies_x_is_that_of_one_mass() -> None:
    one = sp.System(sp.Mass(1.5), sp.Spring(1.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0), sp.ParametricNoise(0.1))
    two = sp.System(
        *masses(a=1.5, b=1e9), sp.Spring(1.0, between=("b", "a")), sp.Dashpot(0.3, between=("b", "a")),
        sp.WhiteNoise(1.0, on="a"), sp.ParametricNoise(0.1, between=("b", "a")), sp.Spring(1e9, between=GROUND_B),
    )  # fmt: skip
    exact = sp.theory.linear(one)
    power = 0.5 * (1.0 + 0.1 * exact.x_mean_square) / 1.5
    run = sp.simulate(two, paths=1280, duration=150.0, window=(50.0, 150.0), step=0.05)
    known = {"a_x_mean_square": exact.x_mean_square, "a_v_mean_square": exact.v_mean_square}
    check(run, known | {"input_power": power, "damping_power": power}, 0.002)


# --- circuits -------------------------------------------------------------------------------------------------------


def harvester(*more: object) -> sp.System:
    return linear_pair(
        *more, link=sp.PiezoelectricCircuit(0.3, 2.0, 0.5, between=A_B),
        base=sp.PiezoelectricCircuit(0.5, 1.0, 0.8, between=GROUND_A),
    )  # fmt: skip


def test_circuits_between_masses() -> None:
    """By Lyapunov's equation with the voltages: Cp V' = -V / R + theta u', and the force -theta V along the row."""
    rates, circuits = np.zeros((6, 6)), {"link": (0.3, 2.0, 0.5, G_LINK), "base": (0.5, 1.0, 0.8, G_A)}
    rates[:4, :4] = RATES
    for n, (theta, resistance, capacitance, g) in enumerate(circuits.values(), start=4):
        rates[n, n] = -1.0 / (resistance * capacitance)
        rates[n, 2:4] = theta / capacitance * g
        rates[2:4, n] = -theta * np.linalg.solve(M_PAIR, g)
    noise = np.zeros((6, 6))
    noise[3, 3] = 0.5 / 0.5**2
    operator = np.kron(rates, np.eye(6)) + np.kron(np.eye(6), rates)
    covariance = np.linalg.solve(operator, -noise.ravel()).reshape(6, 6)
    exact = {f"{p}_{q}_mean_square": float(covariance[i, i]) for i, (q, p) in enumerate(("xa", "xb", "va", "vb"))}
    driven = harvester(sp.WhiteNoise(0.5, on="b"))
    found = sp.theory.linear(driven).moments
    assert [found[name] for name in exact] == pytest.approx([*exact.values()], rel=1e-9)
    exact |= {f"{name}_voltage_mean_square": float(covariance[n, n]) for n, name in enumerate(circuits, start=4)}
    exact["harvested_power"] = sum(exact[f"{name}_voltage_mean_square"] / circuits[name][1] for name in circuits)
    assert found["harvested_power"] == pytest.approx(exact["harvested_power"], rel=1e-9)
    run = sp.simulate(driven, paths=1280, duration=200.0, window=(60.0, 200.0), step=0.05)
    check(run, exact, 0.002)
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.03


def test_circuits_at_a_temperature_have_equipartition_and_no_voltage() -> None:
    """The noise of the resistor is in the matched force."""
    run = sp.simulate(harvester(sp.ThermalNoise(0.5)), paths=1280, duration=200.0, window=(60.0, 200.0), step=0.05)
    check(run, {"a_v_mean_square": 0.5, "b_v_mean_square": 1.0}, 0.003)
    assert not any("voltage" in name or "harvested" in name for name in run)


@pytest.mark.parametrize(
    "arm", [sp.PiezoelectricCircuit(10.0, 1.0, 0.1, between=A_B), sp.Maxwell(1000.0, 20.0, between=A_B)]
)
def test_the_default_step_resolves_stiff_arms(arm: Any) -> None:
    """At once they are springs of 1000 N/m: 55 rad/s of the reduced mass."""
    run = simulated(linear_pair(sp.WhiteNoise(0.5, on="b"), arm), paths=64, duration=1.0)
    assert run.settings.step < 0.1 / 50.0


# --- what is said ---------------------------------------------------------------------------------------------------


def test_every_kind_of_part_has_a_law() -> None:
    """What has none is refused with its name, for one mass and for several alike."""
    without = {name for name, kind in KINDS.items() if lower.dispatch(kind) is lower.dispatch(object)}
    assert without == {"inerter", "mass", "point"}  # these are the mass matrix and rows


def test_laws_without_functions_need_no_compilation_of_their_own() -> None:
    simulated(linear_pair(sp.WhiteNoise(0.5, on="b")), paths=1, duration=1.0)
    before = in_memory()
    wall = sp.Barrier(-0.3, sp.PowerRestitution(0.7, 0.5, 0.3), between=A_B)
    simulated(harvester(sp.WhiteNoise(0.5, on="b"), sp.ParametricNoise(0.1, between=A_B), wall), paths=1, duration=1.0)
    assert in_memory() == before


def test_a_force_is_on_one_mass_or_between_two() -> None:
    with pytest.raises(ValueError, match="on must be left out of a force between two ends, not 'a'"):
        sp.Force(pull, on="a", between=A_B)
    with pytest.raises(ValueError, match="is between 'a' and 'z', but 'z' is no mass"):
        linear_pair(sp.Force(pull, between=("a", "z")))
    lines = sp.explain(linear_pair(sp.Force(pull, between=A_B), sp.ParametricNoise(0.05, between=A_B))).splitlines()
    assert lines[0].endswith("= -w(t) + (x_a - x_b) u(t)")
    assert lines[1].endswith("= w(t) + (x_b - x_a) u(t)")
    assert sp.read_system(SHAKEN.to_dict()) == SHAKEN


def test_a_wall_that_is_struck_beside_a_contact_is_no_touch_of_it() -> None:
    """An impact of one mass turns round how its distance to the other changes."""
    masses = sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b")
    ends = [("ground", "a"), ("a", "b")]
    parts = [part for own in ends for part in (sp.Spring(1.0, between=own), sp.Dashpot(0.2, between=own))]
    noise = [sp.WhiteNoise(0.5, on=point) for point in "ab"]
    walls = sp.Barrier(-0.3, 0.8, between=("ground", "b")), sp.Contact(-0.4, 30.0, between=ends[1])
    given: dict[str, Any] = {"paths": 640, "duration": 30.0, "window": (5.0, 30.0), "start": "rest", "step": 0.02}
    run = sp.simulate(sp.System(*masses, *parts, *noise, *walls), **given, record=640)
    apart = np.diff(run.record[:, 250:, :, 0], axis=2)[..., 0]
    seen = (np.diff((apart < -0.4).astype(int), axis=1) > 0).sum() / (640 * 25.0)
    assert run["barrier_impact_rate"].value > 0.2
    assert seen < run["contact_impact_rate"].value < 1.05 * seen  # some touches begin and end between two points
