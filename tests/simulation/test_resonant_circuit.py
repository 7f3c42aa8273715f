"""A circuit with a coil: exact answers, a second mass that does the same, and runs of both kernels against them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import linalg

import springpot as sp
from springpot.fitting.state_space import state_space
from springpot.machine.faults import NotCoveredError
from springpot.simulation.lowering.memory import turned_in_step
from springpot.simulation.lowering.parts import Arm

from .problems import assert_agrees

THETA, R, C, L = 0.6, 0.3, 0.8, 1.25
COIL = sp.ResonantCircuit(THETA, R, C, L)
PARTS = sp.Spring(1.0), sp.Dashpot(0.1)


def pair(*parts: Any, **named: Any) -> sp.System:
    """Two masses; what is given acts on them too."""
    springs = (sp.Spring(1.0, between=("ground", end)) for end in "ab")
    dampers = (sp.Dashpot(0.1, between=("ground", end)) for end in "ab")
    return sp.System(sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), *springs, *dampers, *parts, **named)


@pytest.mark.parametrize("rate", [0.05, 1.9, 2.0, 6.0])  # twice the frequency is the critical damping
def test_it_is_a_second_mass_for_theory(rate: float) -> None:
    """A mass theta^2 L behind a spring theta^2 / Cp, with a dashpot theta^2 R to the ground."""
    circuit = sp.ResonantCircuit(THETA, rate * L, C, L)
    found = sp.theory.linear(sp.System(*PARTS, circuit, sp.WhiteNoise(1.0)))
    to_a, to_q = ("ground", "a"), ("ground", "q")
    same = sp.theory.linear(
        sp.System(
            sp.Mass(1.0, at="a"), sp.Mass(THETA**2 * L, at="q"), sp.Spring(1.0, between=to_a),
            sp.Dashpot(0.1, between=to_a), sp.Spring(THETA**2 / C, between=("a", "q")),
            sp.Dashpot(THETA**2 * rate * L, between=to_q), sp.WhiteNoise(1.0, on="a"),
        )
    )  # fmt: skip
    assert found.x_mean_square == pytest.approx(same.a_x_mean_square, rel=1e-9)
    assert found.v_mean_square == pytest.approx(same.a_v_mean_square, rel=1e-9)
    delivered = THETA**2 * rate * L * same.q_v_mean_square
    assert found.harvested_power == pytest.approx(delivered, rel=1e-9)
    assert delivered + 0.1 * found.v_mean_square == pytest.approx(0.5, rel=1e-9)  # all that is fed in


@pytest.mark.parametrize("rate", [0.1, 2.0 - 1e-9, 2.0, 2.0 + 1e-9, 7.0])
def test_a_step_of_its_states_is_exact(rate: float) -> None:
    matrix = np.array([[0.0, -1.0], [1.0, -rate]])
    for step in (1e-3, 0.3):
        turned, moved = turned_in_step(Arm(1.0, rate, turn=1.0), step)
        np.testing.assert_allclose(turned, linalg.expm(matrix * step), atol=1e-9)
        mean = np.linalg.solve(matrix * step, linalg.expm(matrix * step) - np.eye(2))[:, 0]
        np.testing.assert_allclose(moved, mean, atol=1e-9)


@pytest.mark.parametrize("several", [False, True])
def test_a_free_motion_has_an_error_of_second_order(several: bool) -> None:
    """Of x from 1, with voltage and current from 0, against the exponential of the whole."""
    matrix = np.array([[0, 1, 0, 0], [-1, -0.1, -THETA, 0], [0, THETA / C, 0, -1 / C], [0, 0, 1 / L, -R / L]])
    worst = []
    for step in (0.1, 0.05):
        if several:
            circuit = sp.ResonantCircuit(THETA, R, C, L, between=("ground", "a"))
            system, x0 = pair(circuit, sp.WhiteNoise(0.0, on="b")), {"a": 1.0}
        else:
            system, x0 = sp.System(*PARTS, COIL, sp.WhiteNoise(0.0)), 1.0
        given = {"paths": 1, "duration": 20.0, "start": "rest", "record": 1, "memory_tolerance": 1e-9}
        run = sp.simulate(system, **given, step=step, initial_position=x0)
        data = run.to_xarray()
        x = data["x"].sel(point="a") if several else data["x"]
        exact = [(linalg.expm(matrix * t) @ [1.0, 0.0, 0.0, 0.0])[0] for t in data["time"].values]
        worst.append(np.abs(x.values.ravel() - exact).max())
    assert worst[0] < 1.1e-3
    assert math.log2(worst[0] / worst[1]) == pytest.approx(2.0, abs=0.05)


def test_a_run_has_the_exact_moments() -> None:
    """Of the motion, the voltage, the current and the power; in single precision."""
    system = sp.System(*PARTS, coil=COIL, shake=sp.WhiteNoise(1.0))
    exact = sp.theory.linear(system)
    known = {name: getattr(exact, name) for name in ("x_mean_square", "v_mean_square", "harvested_power")}
    known["coil_current_mean_square"] = exact.harvested_power / R
    known["coil_voltage_mean_square"] = exact.mean_square("coil_force") / THETA**2
    run = sp.simulate(system, paths=16_000, duration=150.0, window=(50.0, 150.0), start="rest", step=0.05, seed=1)
    assert_agrees(run, known, sharp=0.005)
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error


@pytest.mark.validation
def test_runs_of_several_masses_and_with_matched_noise() -> None:
    """To a third of a per cent."""
    coil = sp.ResonantCircuit(0.5, 0.4, 0.8, 1.0, between=("a", "b"))
    driven = pair(coil, sp.WhiteNoise(1.0, on="a"))
    exact = sp.theory.linear(driven)
    names = "a_x_mean_square", "b_x_mean_square", "b_v_mean_square", "harvested_power"
    run = sp.simulate(driven, paths=16_000, duration=300.0, window=(100.0, 300.0), start="rest", seed=3)
    assert_agrees(run, {name: getattr(exact, name) for name in names}, sharp=0.0035)
    hot = sp.System(sp.Mass(2.0), sp.Spring(2.0), COIL, sp.ThermalNoise(0.7))
    run = sp.simulate(hot, paths=32_000, duration=400.0, seed=11)
    assert_agrees(run, {"x_mean_square": 0.35, "v_mean_square": 0.35}, sharp=0.0035)


@pytest.mark.parametrize("noise", [sp.WhiteNoise(1.0), sp.ThermalNoise(0.7)])
def test_a_fit_of_a_record_knows_its_states(noise: Any) -> None:
    system = sp.System(*PARTS, COIL, noise)
    own = state_space(system, "x", 0.1, 100.0)
    assert own.row @ own.stationary @ own.row == pytest.approx(sp.theory.linear(system).x_mean_square, rel=1e-9)


def test_the_step_follows_a_fast_circuit_and_the_run_a_slow_one() -> None:
    """Of 20 rad/s; and one whose energy decays in 200 s."""
    fast = sp.System(*PARTS, sp.ResonantCircuit(0.05, 0.02, 1.0, 1.0 / 400.0), sp.WhiteNoise(1.0))
    plain = sp.System(*PARTS, sp.PiezoelectricCircuit(0.05, 0.02, 1.0), sp.WhiteNoise(1.0))
    runs = [sp.simulate(each, paths=1, seed=1, start="rest") for each in (fast, plain)]
    assert runs[1].settings.step / runs[0].settings.step == pytest.approx(20.0, rel=1e-3)
    slow = sp.System(*PARTS, sp.ResonantCircuit(0.05, 0.005, 1.0, 1.0), sp.WhiteNoise(1.0))
    assert sp.simulate(slow, paths=1, start="rest").settings.duration > 200.0


def test_methods_that_do_not_know_it_say_so() -> None:
    system = sp.System(*PARTS, coil=COIL, shake=sp.WhiteNoise(1.0))
    for method in (sp.theory.envelope, sp.theory.path_integration, sp.theory.memory_closure):
        with pytest.raises(NotCoveredError, match="coil"):
            method(system)


def test_linearization_and_files_know_it() -> None:
    system = sp.System(sp.Mass(2.0), sp.PolynomialSpring((1.0, 0.0, 0.3)), coil=COIL, shake=sp.WhiteNoise(1.0))
    assert sp.read_system(system.to_dict()) == system
    assert sp.theory.linearization(system).x_mean_square > 0.0
    assert "1.25 I' + 0.3 I = V, 1/sqrt(L Cp) = 1 rad/s" in sp.explain(system)
    with pytest.raises(ValueError, match=r"^inductance must be in \(0, 1e\+50\], not -1. It is L in henry.$"):
        sp.ResonantCircuit(THETA, R, C, -1.0)


def test_the_page_draws_its_voltage() -> None:
    """Along straight lines: against small steps of the two equations."""
    from springpot.explorer.motion import voltages

    x = np.array([[0.0, 0.4, 0.1, 0.3]])
    found, h, volts, amperes, seen = voltages(sp.System(*PARTS, COIL), 0.5, x)[0], 1e-4, 0.0, 0.0, [0.0]
    for slope in np.diff(x[0]) / 0.5:
        for _ in range(5000):
            volts, amperes = volts + h * (THETA * slope - amperes) / C, amperes + h * (volts - R * amperes) / L
        seen.append(volts)
    np.testing.assert_allclose(found, seen, atol=2e-4)


@pytest.mark.parametrize("number", [0, 1, 2, 4])
def test_a_strong_coil_has_a_resonance_too(number: int) -> None:
    """Its force pushes above its own frequency, so that no iteration from the spring's frequency contracts."""
    rng = np.random.default_rng(number)
    stiffness, coupling, resistance, capacitance, inductance = rng.uniform(
        (0.1, 0.5, 0.05, 0.2, 0.5), (1.0, 2.0, 0.5, 0.6, 3.0)
    )
    circuit = sp.ResonantCircuit(coupling, resistance, capacitance, inductance)
    system = sp.System(sp.Spring(stiffness), sp.Dashpot(0.1), circuit, sp.WhiteNoise(1.0))
    held = stiffness + circuit.modulus(1j * system.resonance).real
    assert system.resonance**2 == pytest.approx(held, rel=1e-10)


def test_a_system_with_a_strong_coil_is_simulated() -> None:
    system = sp.System(sp.Spring(0.77), sp.Dashpot(0.1), sp.ResonantCircuit(0.67, 0.29, 0.52, 1.75), sp.WhiteNoise(1.0))
    found = sp.simulate(system, paths=8192, duration=120.0, step=0.05)["x_mean_square"]
    assert found.error < 0.006 * found.value
    assert abs(found.value - sp.theory.linear(system).x_mean_square) < 4.0 * found.error
