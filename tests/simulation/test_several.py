"""Systems of several masses: exact laws, conservation, one mass as the limit, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.result.results import Run
from tests.kernels import in_memory
from tests.simulation.systems import of_many_kinds
from tests.sizes import validation

pytestmark = pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")

GROUND_A, A_B, GROUND_B = ("ground", "a"), ("a", "b"), ("ground", "b")
FAST = 2.101  # highest frequency of `thermal_pair`, in rad/s


def masses(**values: float) -> list[sp.Mass]:
    return [sp.Mass(value, at=name) for name, value in values.items()]


def thermal_pair(damping: float = 1.0, restitution: float = 1.0) -> sp.System:
    """Two unequal masses that pound, at the temperature 0.6: Boltzmann's law."""
    ends = GROUND_A, A_B, GROUND_B
    return sp.System(
        *masses(a=1.0, b=0.5),
        *(sp.Spring(k, between=e) for k, e in zip((2.0, 1.0, 0.5), ends, strict=True)),
        *(sp.Dashpot(damping * c, between=e) for c, e in zip((0.2, 0.1, 0.1), ends, strict=True)),
        sp.ThermalNoise(0.6), gap=sp.Barrier(-0.3, restitution, between=A_B),
    )  # fmt: skip


BOLTZMANN = {
    "a_x_mean_square": 0.25297, "b_x_mean_square": 0.44756, "a_v_mean_square": 0.6, "b_v_mean_square": 1.2,
    "gap_impact_rate": 0.434012, "gap_impact_speed_mean": 1.681529, "gap_force_mean": 0.486526,
}  # fmt: skip


def three(*more: object, **named: object) -> sp.System:
    ends = GROUND_A, A_B, ("b", "c"), ("ground", "c")
    return sp.System(
        *masses(a=1.0, b=0.7, c=0.5),
        *(sp.Spring(k, between=e) for k, e in zip((3.0, 2.0, 1.5, 1.0), ends, strict=True)),
        *(sp.Dashpot(c, between=e) for c, e in zip((0.3, 0.1, 0.2, 0.05), ends, strict=True)),
        *more, **named,
    )  # fmt: skip


def chain(*more: object) -> sp.System:
    """Four masses with a springpot beside each spring."""
    ends = GROUND_A, A_B, ("b", "c"), ("c", "d")
    return sp.System(
        *masses(a=1.0, b=1.0, c=0.8, d=0.6),
        *(sp.Spring(k, between=e) for k, e in zip((6.0, 5.0, 4.0, 3.0), ends, strict=True)),
        *(sp.Springpot(0.5, 0.3, between=e) for e in ends), *more,
    )  # fmt: skip


def off(run: Run, exact: dict[str, float], most: float = 0.0) -> dict[str, float]:
    """Deviations beyond ``most`` of the exact value, in standard errors."""
    return {
        name: max(abs(run[name].value - value) - most * value, 0.0) / run[name].error for name, value in exact.items()
    }


def check(run: Run, exact: dict[str, float], most: float = 0.0, precise: float = 0.02) -> None:
    assert all(run[name].error < precise * abs(value) for name, value in exact.items())
    far = off(run, exact, most)
    assert max(far.values()) < 4.0, far


# --- exact laws -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("paths", [640, validation(8192)])
def test_two_masses_that_pound_obey_boltzmanns_law(paths: int) -> None:
    run = sp.simulate(thermal_pair(), paths=paths, duration=400.0, window=(50.0, 400.0))
    assert run.settings.step * FAST == pytest.approx(0.1, rel=1e-3)
    check(run, BOLTZMANN, precise=0.3 / np.sqrt(paths))
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.02


@pytest.mark.validation
@pytest.mark.parametrize("coarse", [0.1, 0.2])
def test_impacts_do_not_heat_a_motion_with_little_damping(coarse: float) -> None:
    run = sp.simulate(thermal_pair(0.05), paths=16384, duration=4200.0, window=(3000.0, 4200.0), step=coarse / FAST)
    for name, value in (("a_v_mean_square", 0.6), ("b_v_mean_square", 1.2)):
        assert abs(run[name].value / value - 1.0) < 0.005
    assert abs(run["gap_impact_rate"].value / 0.434012 - 1.0) < 0.005


@pytest.mark.parametrize("paths", [640, validation(4096)])
def test_three_masses_with_two_contacts_obey_boltzmanns_law(paths: int) -> None:
    system = three(
        sp.ThermalNoise(0.5), left=sp.Barrier(-0.2, 1.0, between=A_B), right=sp.Barrier(-0.3, 1.0, between=("b", "c"))
    )
    exact = {
        "a_x_mean_square": 0.144533, "b_x_mean_square": 0.195483, "c_x_mean_square": 0.300795,
        "a_v_mean_square": 0.5, "b_v_mean_square": 0.714286, "c_v_mean_square": 1.0,
        "left_impact_rate": 0.609802, "right_impact_rate": 0.574781,
        "left_impact_speed_mean": 1.381085, "right_impact_speed_mean": 1.640973,
        "left_force_mean": 0.693567, "right_force_mean": 0.550200,
    }  # fmt: skip
    check(sp.simulate(system, paths=paths, duration=400.0, window=(50.0, 400.0)), exact, 0.001)


@pytest.mark.parametrize("paths", [640, validation(4096)])
def test_white_noise_on_some_of_three_masses(paths: int) -> None:
    """By the Lyapunov equation; the losses are what the noise feeds in."""
    system = three(sp.WhiteNoise(0.4, on="a"), sp.WhiteNoise(0.2, on="c"))
    exact = {
        "a_x_mean_square": 0.192367, "b_x_mean_square": 0.425852, "c_x_mean_square": 0.410021,
        "a_v_mean_square": 0.503975, "b_v_mean_square": 0.720382, "c_v_mean_square": 0.955507,
        "damping_power": 0.4, "input_power": 0.4,
    }  # fmt: skip
    run = sp.simulate(system, paths=paths, duration=400.0, window=(100.0, 400.0))
    check(run, exact, 0.001)
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.03


OF_CHAIN = {
    "d": ((0.323663, 1.186845, 2.311279, 3.365156), (0.559014, 1.286159, 2.073149, 3.424681)),
    "ground": ((0.519935, 2.109637, 4.279264, 6.032396), (0.499164, 1.830854, 3.591163, 5.158331)),
}  # fmt: skip
"""x^2 and v^2 with white noise on the last mass, of intensity 0.5, and of the ground, 0.2."""


@pytest.mark.parametrize(("on", "intensity"), [("d", 0.5), validation("ground", 0.2)])
def test_a_chain_with_springpots(on: str, intensity: float) -> None:
    """By quadrature of the spectra."""
    exact = {
        f"{point}_{of}_mean_square": value
        for of, each in zip("xv", OF_CHAIN[on], strict=True)
        for point, value in zip("abcd", each, strict=True)
    }
    run = sp.simulate(chain(sp.WhiteNoise(intensity, on=on)), paths=2048, duration=450.0, window=(150.0, 450.0))
    check(run, exact, 0.003)
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.04


def test_thermal_noise_of_springpots_of_different_orders() -> None:
    """Matched noise with memory, of each element: equipartition in every spring and mass."""
    ends = GROUND_A, A_B
    system = sp.System(
        *masses(a=1.0, b=0.5), sp.Spring(3.0, between=ends[0]), sp.Spring(2.0, between=ends[1]), sp.ThermalNoise(0.5),
        sp.Springpot(0.4, 0.5, between=ends[0]), sp.Springpot(0.8, 0.3, between=ends[1]),
        sp.PolynomialSpring((0.0, 0.0, 1.0), between=ends[1]),
    )  # fmt: skip
    u = np.linspace(-6.0, 6.0, 20001)
    weight = np.exp(-(u**2 + 0.25 * u**4) / 0.5)
    exact = {
        "a_x_mean_square": 0.5 / 3.0, "a_v_mean_square": 0.5, "b_v_mean_square": 1.0,
        "a_b_elongation_mean_square": float((weight * u**2).sum() / weight.sum()),
    }  # fmt: skip
    check(sp.simulate(system, paths=1280, duration=300.0, window=(100.0, 300.0), step=0.02), exact, 0.003)


@pytest.mark.parametrize("order", [0.5, 0.9, 1.0])
def test_strong_dampers_at_a_temperature(order: float) -> None:
    """The fastest rate is theirs: what they take again of the noise's impulse within a step belongs to <v^2>."""
    ends = GROUND_A, A_B
    dampers = [sp.Dashpot(10.0, between=e) if order == 1.0 else sp.Springpot(order, 10.0, between=e) for e in ends]
    pair = sp.System(*masses(a=1.0, b=1.0), *(sp.Spring(1.0, between=e) for e in ends), *dampers, sp.ThermalNoise(1.0))
    run = sp.simulate(pair, paths=12800, duration=10.0, window=(0.0, 10.0))
    check(run, {"a_v_mean_square": 1.0, "b_v_mean_square": 1.0}, 0.001, 0.004)


@pytest.mark.parametrize("order", [0.8, 1.0])
def test_strong_dampers_under_white_noise(order: float) -> None:
    ends = GROUND_A, A_B
    dampers = [sp.Dashpot(10.0, between=e) if order == 1.0 else sp.Springpot(order, 10.0, between=e) for e in ends]
    pair = sp.System(
        *masses(a=1.0, b=1.0), *(sp.Spring(1.0, between=e) for e in ends), *dampers,
        sp.WhiteNoise(1.0, on="a"), sp.WhiteNoise(0.3, on="b"),
    )  # fmt: skip
    exact = sp.theory.linear(pair).moments
    run = sp.simulate(pair, paths=2560, duration=100.0)
    check(run, {name: exact[name] for name in ("a_v_mean_square", "b_v_mean_square")}, 0.004, 0.003)


@pytest.mark.validation  # every day: thermal noise of springpots, in this file
def test_a_soft_contact_between_two_masses_obeys_boltzmanns_law() -> None:
    """By quadrature over both displacements; touches are those of the density there."""
    ends = GROUND_A, A_B, GROUND_B
    pair = sp.System(
        *masses(a=1.0, b=0.5), *(sp.Spring(k, between=e) for k, e in zip((2.0, 1.0, 0.5), ends, strict=True)),
        *(sp.Dashpot(c, between=e) for c, e in zip((0.2, 0.1, 0.1), ends, strict=True)),
        sp.ThermalNoise(0.6), gap=sp.Contact(-0.3, 20.0, 1.5, between=A_B),
    )  # fmt: skip
    x, y = np.linspace(-5.0, 5.0, 1001)[:, None], np.linspace(-7.0, 7.0, 1401)[None, :]
    depth = np.maximum(-0.3 - (y - x), 0.0)
    weight = np.exp(-(x**2 + 0.5 * (y - x) ** 2 + 0.25 * y**2 + 20.0 * depth**2.5 / 2.5) / 0.6)
    weight /= weight.sum()
    at_place = weight[np.abs(y - x + 0.3) < 0.0051].sum() / 0.01  # per length of y - x
    exact = {
        "a_x_mean_square": float((weight * x**2).sum()), "b_x_mean_square": float((weight * y**2).sum()),
        "a_v_mean_square": 0.6, "b_v_mean_square": 1.2, "gap_force_mean": float((weight * 20.0 * depth**1.5).sum()),
        "gap_impact_rate": float(at_place * np.sqrt(0.6 * 3.0 / (2.0 * np.pi))),
        "gap_impact_speed_mean": float(np.sqrt(0.5 * np.pi * 0.6 * 3.0)),
    }  # fmt: skip
    run = sp.simulate(pair, paths=1280, duration=400.0, window=(50.0, 400.0))
    check(run, exact, 0.003)
    assert run["gap_power"].value == 0.0


def response(w: Any, on: str) -> Any:
    """|x|^2 of both masses of `linear_pair` per unit of force, or of the ground's acceleration."""
    w = np.atleast_1d(w)
    m, k, c = np.diag([1.0, 0.5]), np.array([[3.0, -1.0], [-1.0, 1.5]]), np.array([[0.3, -0.1], [-0.1, 0.2]])
    force = {"b": np.array([0.0, 1.0]), "ground": -np.diag(m)}[on]
    matrix = k - w[:, None, None] ** 2 * m + 1j * w[:, None, None] * c
    return np.abs(np.linalg.solve(matrix, np.broadcast_to(force[:, None], (len(w), 2, 1)))[..., 0]) ** 2


def linear_pair(*more: object, **named: object) -> sp.System:
    ends = GROUND_A, A_B, GROUND_B
    return sp.System(
        *masses(a=1.0, b=0.5), *(sp.Spring(k, between=e) for k, e in zip((2.0, 1.0, 0.5), ends, strict=True)),
        *(sp.Dashpot(c, between=e) for c, e in zip((0.2, 0.1, 0.1), ends, strict=True)), *more, **named,
    )  # fmt: skip


@pytest.mark.parametrize(
    "noise",
    [
        sp.ColoredNoise(1.0, 0.4, on="b"), sp.KanaiTajimiNoise(2.0, 0.5, 0.5, on="ground"),
        sp.Harmonic(0.5, 1.3, on="ground"), sp.PoissonImpulses(2.0, 0.5, on="b"),
    ],
)  # fmt: skip
def test_other_excitation_of_a_linear_pair(noise: Any) -> None:
    """By quadrature of the spectrum."""
    if isinstance(noise, sp.Harmonic):
        x, v = (0.5 * noise.amplitude**2 * response(noise.frequency, noise.on)[0] * noise.frequency**n for n in (0, 2))
    else:
        w = np.linspace(-60.0, 60.0, 60001)
        density = np.array([noise.density(one) for one in w])[:, None] * response(w, noise.on) * (w[1] - w[0])
        x, v = density.sum(axis=0), (w[:, None] ** 2 * density).sum(axis=0)
    exact = {
        f"{p}_{q}_mean_square": float(value)
        for q, each in (("x", x), ("v", v))
        for p, value in zip("ab", each, strict=True)
    }
    run = sp.simulate(linear_pair(noise), paths=1280, duration=400.0, window=(100.0, 400.0), step=0.03)
    check(run, exact, 0.002)
    assert abs(run["input_power"].value - run["damping_power"].value) < 4.0 * run["damping_power"].error + 1e-3


def test_a_record_shakes_the_ground() -> None:
    """All paths alike: an integration of the equations of motion."""
    from scipy import integrate

    time = np.linspace(0.0, 20.0, 201)
    record = np.sin(1.1 * time) * np.exp(-0.1 * time)
    m, k, c = np.diag([1.0, 0.5]), np.array([[3.0, -1.0], [-1.0, 1.5]]), np.array([[0.3, -0.1], [-0.1, 0.2]])
    found = integrate.solve_ivp(
        lambda t, s: [*s[2:], *np.linalg.solve(m, -k @ s[:2] - c @ s[2:] - np.diag(m) * np.interp(t, time, record))],
        (0.0, 20.0), np.zeros(4), rtol=1e-9, atol=1e-12, t_eval=time, max_step=0.1,
    )  # fmt: skip
    shaken = linear_pair(sp.RecordedExcitation(tuple(time), tuple(record), on="ground"))
    run = sp.simulate(shaken, paths=1, step=0.01, record=1, record_every=10)
    assert run.settings.duration == 20.0
    assert np.abs(run.record[0, :, :, 0] - found.y[:2].T).max() < 1e-3 * np.abs(found.y[:2]).max()


# --- conservation ---------------------------------------------------------------------------------------------------

FREE = masses(a=1.0, b=0.3)
M = np.array([1.0, 0.3])
START: dict[str, Any] = {"initial_position": {"b": 0.1}, "initial_velocity": {"a": 0.7, "b": -0.5}}


def test_an_elastic_impact_conserves_momentum_and_energy() -> None:
    pair = sp.System(*FREE, gap=sp.Barrier(-0.2, 1.0, between=A_B))
    run = sp.simulate(pair, paths=1, duration=1.0, step=0.01, window=(0.0, 1.0), record=1, **START)
    v = run.record[0, :, :, 1]
    assert run["gap_impact_rate"].value == 1.0
    assert np.ptp(v @ M) < 1e-15
    assert np.ptp(v**2 @ M) < 1e-15
    assert v[-1, 1] - v[-1, 0] == pytest.approx(1.2)


def test_a_free_pair_keeps_its_momentum_through_ten_thousand_impacts() -> None:
    pair = sp.System(*FREE, sp.Spring(2.0, between=A_B), gap=sp.Barrier(0.0, 1.0, between=A_B))
    run = sp.simulate(pair, paths=1, duration=12000.0, step=0.02, window=(0.0, 12000.0), record=1, record_every=1000,
                      **START)  # fmt: skip
    assert run["gap_impact_rate"].value * 12000.0 > 1e4
    assert np.ptp(run.record[0, :, :, 1] @ M) < 1e-9


@pytest.mark.parametrize("restitution", [1.0, 0.3])
def test_a_graze_that_stops_on_a_wall_is_one_impact(restitution: float) -> None:
    """Springs push the masses apart while they close slowly: what rounding leaves of the speed is not struck again."""
    bar = sp.System(
        *masses(a=1.0, b=0.5), sp.Point("p", ("a", "b"), (0.3, 0.7)), sp.Spring(2.0, between=GROUND_A),
        sp.Spring(1.0, between=A_B), gap=sp.Barrier(-0.2, restitution, between=("a", "p")),
    )  # fmt: skip
    x, v = {"a": 0.63836, "b": 0.353136}, {"a": -1.08628, "b": -1.123}
    for n in range(20):
        run = simulated(
            bar, paths=1, duration=0.1, step=0.05, window=(0.0, 0.1), initial_position=x,
            initial_velocity=v | {"b": v["b"] + 1e-5 * n},
        )  # fmt: skip
        assert run["gap_impact_rate"].value * 0.1 == pytest.approx(1.0)
        assert run.diagnostics["collapses"] == 0


@pytest.mark.parametrize("restitution", [1.0, 0.7, 0.3])
def test_the_restitution_is_what_was_asked(restitution: float) -> None:
    """From momentum and closing speeds, and from the energy taken; a few grazing impacts are stopped instead.

    Of the four steps of a group the sums are in single precision.
    """
    run = sp.simulate(thermal_pair(restitution=restitution), paths=64, duration=100.0)
    closing = run["gap_impact_rate"].value * run["gap_impact_speed_mean"].value
    square = run["gap_impact_rate"].value * run["gap_impact_speed_mean_square"].value
    reduced = 1.0 / (1.0 + 1.0 / 0.5)
    assert run["gap_force_mean"].value / (reduced * closing) - 1.0 == pytest.approx(restitution, rel=1e-3)
    assert run["gap_power"].value == pytest.approx(0.5 * reduced * (1.0 - restitution**2) * square, rel=1e-7)


def test_an_elastic_chain_keeps_its_energy() -> None:
    """200,000 steps with nonlinear springs and pounding, between the same instants of the step.

    Impacts change the energy at random, by some h^2 each, and what one path comes to depends on rounding, for the
    motion is chaotic: a noise far below what can be seen makes others of it.
    """
    ends = A_B, ("b", "c"), ("c", "d")
    k, m = np.array([3.0, 2.0, 4.0]), np.array([1.0, 0.7, 0.5, 0.9])
    free = sp.System(
        *masses(a=1.0, b=0.7, c=0.5, d=0.9), *(sp.Spring(c, between=e) for c, e in zip(k, ends, strict=True)),
        sp.PolynomialSpring((0.0, 0.0, 0.5), between=A_B), *(sp.Barrier(-0.2, 1.0, between=e) for e in ends),
        sp.WhiteNoise(1e-24, on="a"),
    )  # fmt: skip
    early = []
    for step, duration in ((0.02, 4000.0), (0.04, 1000.0)):
        run = simulated(
            free, paths=64, duration=duration, step=step, window=(0.0, duration), record=64,
            record_every=round(40.0 / step), memory_tolerance=1e-9, initial_position={"b": 0.1, "c": -0.1, "d": 0.2},
            initial_velocity={"a": 0.5, "b": -0.7, "c": 0.3, "d": 0.4},
        )  # fmt: skip
        assert run.settings.precision == "float64"
        assert run["barrier_1_impact_rate"].value > 0.1
        x, v = run.record[..., 0], run.record[..., 1]
        u, momentum = np.diff(x, axis=2), v @ m
        energy = 0.5 * (v**2 @ m + u**2 @ k) + 0.125 * u[..., 0] ** 4 - 0.5 * momentum**2 / m.sum()
        off = (energy / energy[:, :1] - 1.0) ** 2
        early.append(np.sqrt(off[:, :26].mean()))
        assert step > 0.02 or np.sqrt(off.mean()) < 0.01
        assert np.ptp(x[:, -1, 0]) > 0.1  # other paths
        assert np.ptp(momentum) < 1e-9
    assert 3.0 < early[1] / early[0] < 7.0


PULLED = (*masses(a=1.0, b=1.0), sp.Spring(1.0, between=GROUND_A), sp.Spring(1.0, between=A_B))


@pytest.mark.parametrize("wall", [sp.Barrier(10.0, r, "above", between=A_B) for r in (0.8, 1.0)])
def test_the_default_step_resolves_hops_on_a_wall_that_springs_press_on(wall: sp.Barrier) -> None:
    system = sp.System(*PULLED, sp.Dashpot(0.1, between=GROUND_A), sp.WhiteNoise(1.0, on="a"), wall)
    run = sp.simulate(system, paths=640, duration=100.0, window=(50.0, 100.0))
    assert run.settings.step < 0.02
    assert run["barrier_force_mean"].value == pytest.approx(10.0, rel=0.1)
    assert abs(run["energy_residual"].value) < 0.02 + 4.0 * run["energy_residual"].error < 0.15


@pytest.mark.parametrize(
    "damper",
    [
        sp.VanDerPol(3.0, 1.0, between=A_B),
        *(sp.PolynomialDashpot(c, between=A_B) for c in ((0.1, 9.0), (0.1, 0.0, 9.0))),
    ],
)
def test_the_default_step_resolves_nonlinear_dampers(damper: Any) -> None:
    system = sp.System(*PULLED, sp.Dashpot(0.1, between=GROUND_A), damper, sp.WhiteNoise(1.0, on="a"))
    run = sp.simulate(system, paths=640, duration=100.0)
    assert run.settings.step < 0.025
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.1


@pytest.mark.parametrize("dissipation", [30.0, 1000.0])
def test_a_contact_that_hardly_rebounds_does_not_let_masses_sink_in(dissipation: float) -> None:
    gap = sp.Contact(-0.3, 1e3, 1.5, dissipation, between=A_B)
    system = sp.System(*PULLED, sp.Dashpot(0.1, between=GROUND_A), sp.WhiteNoise(1.0, on="a"), gap=gap)
    coarse, fine = (sp.simulate(system, paths=640, duration=50.0, step=h) for h in (0.0024, 0.0006))
    for name in ("a_v_mean_square", "gap_power"):
        one, other = coarse[name], fine[name]
        assert abs(one.value - other.value) < 4.0 * np.hypot(one.error, other.error)
    assert abs(coarse["energy_residual"].value) < 4.0 * coarse["energy_residual"].error < 0.1


# --- one mass as the limit ------------------------------------------------------------------------------------------


def test_a_heavy_mass_that_is_held_is_the_ground() -> None:
    """The same normals, so path by path."""

    def parts(**k: Any) -> list[Any]:
        return [sp.Spring(1.0, **k), sp.Springpot(0.5, 0.3, **k), sp.Barrier(-0.5, 0.8, **k)]

    one = sp.System(sp.Mass(1.0), *parts(), sp.WhiteNoise(1.0))
    two = sp.System(
        *masses(a=1.0, b=1e6), *parts(between=("b", "a")), sp.WhiteNoise(1.0, on="a"), sp.Spring(1e6, between=GROUND_B)
    )
    given: dict[str, Any] = {"paths": 1024, "duration": 200.0, "window": (100.0, 200.0), "step": 0.02, "start": "rest"}
    alone, held = sp.simulate(one, **given), sp.simulate(two, **given)
    for name in ("x_mean", "x_mean_square", "v_mean_square"):
        assert abs(held[f"a_{name}"].value - alone[name].value) < 0.5 * alone[name].error
    for name in ("barrier_impact_rate", "barrier_impact_speed_mean", "barrier_power", "barrier_force_mean"):
        assert abs(held[name].value - alone[name].value) < 0.5 * alone[name].error
    for name in ("damping_power", "energy_residual"):
        assert abs(held[name].value - alone[name].value) < 0.5 * alone[name].error


@pytest.mark.parametrize("stop", [(), (sp.Barrier(-0.5, 0.8),)], ids=["free", "wall"])
def test_a_mass_too_heavy_to_move_is_the_ground_to_single_precision(stop: tuple[sp.Barrier, ...]) -> None:
    """At 1e6 kg it still moves: mean squares are 2e-5 off without a wall, path by path."""

    def system(first: str) -> sp.System:
        parts = [replace(part, between=(first, "a")) for part in (sp.Spring(1.0), sp.Springpot(0.5, 0.3), *stop)]
        held = sp.Spring(1e9, between=GROUND_B)
        return sp.System(*masses(a=1.0, b=1e9), *parts, held, sp.WhiteNoise(1.0, on="a"))

    given: dict[str, Any] = {"paths": 256, "duration": 100.0, "window": (50.0, 100.0), "step": 0.02, "start": "rest"}
    heavy, ground = sp.simulate(system("b"), **given), sp.simulate(system("ground"), **given)
    names = ["a_x_mean_square", "a_v_mean_square", "damping_power"]
    for name in (*names, *(["barrier_impact_rate", "barrier_impact_speed_mean"] if stop else [])):
        assert heavy[name].value == pytest.approx(ground[name].value, rel=1e-6)


def alone_and_held(kind: Any, numbers: tuple[Any, ...]) -> tuple[Run, Run, dict[str, str]]:
    """One mass on the ground, and one on a mass that is held, with the same normals; what names their results have."""

    def parts(**k: Any) -> list[Any]:
        return [sp.Spring(1.0, **k), sp.Dashpot(0.1, **k), kind(*numbers, **k)]

    whole = of_many_kinds if kind in (sp.Contact, sp.PolynomialDashpot, sp.VanDerPol) else sp.System
    one = whole(sp.Mass(1.5), *parts(), sp.WhiteNoise(1.0))
    two = sp.System(
        *masses(a=1.5, b=1e6), *parts(between=("b", "a")), sp.WhiteNoise(1.0, on="a"), sp.Spring(1e6, between=GROUND_B)
    )
    given: dict[str, Any] = {"paths": 512, "duration": 150.0, "window": (50.0, 150.0), "step": 0.02, "start": "rest"}
    alone, held = sp.simulate(one, **given), sp.simulate(two, **given)
    names = {f"a_{name}": name for name in ("x_mean_square", "v_mean_square")}
    names |= {name: name for name in alone if name in held and not name.startswith("energy_residual")}
    return alone, held, names


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        validation(sp.Friction, (0.2,)), (sp.PolynomialDashpot, ((0.1, 0.2, 0.1),)), (sp.VanDerPol, (0.3, 1.0)),
        (sp.Contact, (-0.4, 30.0, 1.5, 0.2)), (sp.Maxwell, (1.0, 0.5)), (sp.FractionalMaxwell, (sp.Springpot(0.5, 1.0),
        sp.Spring(2.0))),
    ],
)  # fmt: skip
def test_parts_between_a_mass_and_one_that_is_held(kind: Any, numbers: tuple[Any, ...]) -> None:
    """Scaled by a mass that is not 1, and with the same normals as one mass on the ground."""
    alone, held, names = alone_and_held(kind, numbers)
    for name, other in names.items():
        assert abs(held[name].value - alone[other].value) <= alone[other].error + 0.003 * abs(alone[other].value), name
    assert abs(held["energy_residual"].value) < 4.0 * held["energy_residual"].error + 0.005


def test_impacts_on_a_lossy_wall_have_a_bound_on_the_bias_of_the_step() -> None:
    coarse, fine = (
        sp.simulate(thermal_pair(restitution=0.5), paths=2000, duration=100.0, step=h) for h in (0.04, 0.005)
    )
    one, other = coarse["gap_impact_rate"], fine["gap_impact_rate"]
    assert one.step_bias is not None
    assert other.step_bias is not None
    assert 0.01 * one.value < one.step_bias < 0.1 * one.value
    assert abs(one.value - other.value) < one.step_bias + other.step_bias + 3.0 * np.hypot(one.error, other.error)
    assert any("misses slow impacts" in sentence for sentence in coarse.warnings)


def test_a_wall_that_is_not_struck_has_no_step_bias() -> None:
    run = simulated(linear_pair(sp.WhiteNoise(1.0, on="a"), sp.Barrier(-50.0, between=A_B)), paths=64, duration=20.0)
    assert [name for name, each in run.estimates.items() if each.step_bias is not None] == []


@pytest.mark.parametrize(("order", "strength"), [(0.8, 10.0), (0.9, 3.0), (1.0, 3.0), (0.5, 0.1)])
def test_strong_dampers_have_a_bound_on_the_bias_of_the_step(order: float, strength: float) -> None:
    ends = GROUND_A, A_B
    dampers = [sp.Dashpot(strength, between=e) if order == 1.0 else sp.Springpot(order, strength, between=e)
               for e in ends]  # fmt: skip
    pair = sp.System(*masses(a=1.0, b=0.5), *(sp.Spring(1.0, between=e) for e in ends), *dampers,
                     sp.WhiteNoise(1.0, on="b"))  # fmt: skip
    run = simulated(pair, paths=1, duration=1.0)
    bias = run["a_v_mean_square"].step_bias
    assert (bias is None) == (strength < 1.0)
    assert bias is None or 1e-3 < bias / run["a_v_mean_square"].value < 0.03


def test_the_default_step_follows_a_contact_that_takes_all_speed() -> None:
    """Two masses that close once on a contact with strong losses, against a much finer step."""
    noise = sp.WhiteNoise(1e-12, on="a"), sp.WhiteNoise(1e-12, on="b")
    pair = linear_pair(sp.Contact(-0.3, 20.0, 1.5, 1000.0, between=A_B), sp.WhiteNoise(1.0, on="a"))
    step = plan_of(pair).settings.step
    lost = [
        simulated(sp.System(*pair.parts[:-1], *noise), paths=64, duration=0.4, window=(0.0, 0.4), step=h, start="rest",
                  initial_velocity={"a": 1.5, "b": -0.5})["contact_power"].value for h in (step, step / 16.0)
    ]  # fmt: skip
    assert lost[0] == pytest.approx(lost[1], rel=0.01)
    assert lost[1] > 0.1


def test_impacts_that_cannot_be_counted_are_named() -> None:
    """Noise that reaches a lossy wall through springs only, beside one that it acts on."""
    system = three(
        sp.WhiteNoise(0.4, on="a"),
        near=sp.Barrier(-0.2, 0.8, between=A_B),
        far=sp.Barrier(-0.3, 0.8, between=("b", "c")),
    )
    run = sp.simulate(system, paths=64, duration=20.0)
    assert np.isnan(run["far_impact_rate"].value)
    assert run["near_impact_rate"].value > 0.0
    assert run["far_power"].value > 0.0
    assert any(
        "far is lossy, and no white noise drives its two ends apart: a smooth" in sentence for sentence in run.warnings
    )


def test_more_paths_are_added_to_a_run() -> None:
    given: dict[str, Any] = {"duration": 20.0, "step": 0.05}
    longer = sp.extend(simulated(thermal_pair(), paths=100, **given), paths=200)
    assert longer.path_sums.tobytes() == simulated(thermal_pair(), paths=200, **given).path_sums.tobytes()


def test_a_symmetric_pair_has_decoupled_modes() -> None:
    """Noise on both masses alike moves the sum only: the elongation between them stays 0."""
    pair = sp.System(
        *masses(a=1.0, b=1.0), *(sp.Spring(1.0, between=e) for e in (GROUND_A, A_B, GROUND_B)),
        sp.Dashpot(0.1, between=GROUND_A), sp.Dashpot(0.1, between=GROUND_B), sp.WhiteNoise(1.0, on="ground"),
    )  # fmt: skip
    run = sp.simulate(pair, paths=64, duration=50.0)
    assert run["a_b_elongation_mean_square"].value == 0.0
    assert run["a_x_mean_square"].value == run["b_x_mean_square"].value > 0.0


# --- the run --------------------------------------------------------------------------------------------------------


def test_one_compilation_serves_all_sizes() -> None:
    sp.simulate(thermal_pair(), paths=1, duration=1.0)
    before = in_memory()
    sp.simulate(chain(sp.WhiteNoise(0.5, on="d")), paths=1, duration=1.0)
    sp.simulate(three(sp.WhiteNoise(0.5, on="a"), sp.Barrier(0.1, 0.5, between=A_B)), paths=1, duration=1.0)
    assert in_memory() == before


def test_the_same_bits_for_any_number_of_threads() -> None:
    one, two = (simulated(thermal_pair(), paths=300, duration=20.0, record=2, threads=n) for n in (1, 2))
    assert one.path_sums.tobytes() == two.path_sums.tobytes()
    assert one.record.tobytes() == two.record.tobytes()


def test_paths_of_another_window_are_the_same() -> None:
    """Windows that begin and end within a group of four steps."""
    long, short = (
        simulated(thermal_pair(), paths=64, duration=20.0, step=0.05, window=window, record=64)
        for window in ((0.0, 20.0), (3.05, 17.35))
    )
    assert long.record.tobytes() == short.record.tobytes()
    x = short.record[:, 62:348, :, 0]
    assert short["a_x_mean"].value == pytest.approx(x[:, :, 0].mean(), rel=1e-5)
    assert short["b_x_mean_square"].value == pytest.approx((x[:, :, 1] ** 2).mean(), rel=1e-5)
    u = x[:, :, 1] - x[:, :, 0]
    assert short["a_b_elongation_mean_square"].value == pytest.approx((u**2).mean(), rel=1e-5)
    assert short["b_x_mean_end"].value == pytest.approx(short.record[:, -1, 1, 0].mean(), rel=1e-5)


def test_weights_hold_masses_on_the_ground() -> None:
    """No spring: the heights have exponential laws, of the mean over the weight of all above."""
    stack = sp.System(
        *masses(a=1.0, b=1.0), *(sp.Barrier(0.0, 1.0, "above", between=e) for e in (GROUND_A, A_B)),
        *(sp.Constant(-1.0, on=p) for p in "ab"), *(sp.Dashpot(0.5, between=e) for e in (GROUND_A, GROUND_B)),
        sp.ThermalNoise(1.0),
    )  # fmt: skip
    run = sp.simulate(stack, paths=1280, duration=200.0, window=(50.0, 200.0))
    assert not any("nothing holds" in sentence for sentence in run.warnings)
    check(run, {"a_x_mean": 0.5, "b_x_mean": 1.5, "a_v_mean_square": 1.0, "barrier_1_force_mean": 2.0}, 0.002)


@pytest.mark.parametrize("suffix", [".nc", ".json"])
def test_a_run_is_saved_and_read(tmp_path: Path, suffix: str) -> None:
    run = sp.simulate(thermal_pair(), paths=64, duration=10.0, record=2, initial_position={"b": 0.2})
    again = sp.load_run(run.save(tmp_path / f"run{suffix}"))
    assert (again.estimates, again.settings, again.system) == (run.estimates, run.settings, run.system)
    assert again.record.tobytes() == run.record.tobytes()


def test_the_dataset_has_the_dimension_point() -> None:
    data = sp.simulate(thermal_pair(), paths=64, duration=10.0, record=2).to_xarray()
    assert data["point"].to_numpy().tolist() == ["a", "b"]
    assert data["x"].dims == ("path", "time", "point")
    assert data["x_mean_square"].dims == data["v_mean_square_end_se"].dims == ("point",)
    assert data["barrier_impact_rate"].sizes == {"barrier": 1}


def test_masses_start_before_walls_beyond_zero() -> None:
    """Preloaded: as near to 0 as the walls let them."""
    pair = three(sp.WhiteNoise(0.1, on="a"), sp.Barrier(0.3, 0.9, "above", between=A_B))
    run = sp.simulate(pair, paths=1, duration=1.0)
    assert run.settings.initial_position == pytest.approx({"a": -0.15, "b": 0.15, "c": 0.0})


def test_masses_start_where_springs_and_constant_forces_balance() -> None:
    """A weight on the first mass, with a cubic spring; 3 x + 2 (x - y) + 4 x^3 = 2 and so on."""
    cubic = sp.PolynomialSpring((0.0, 0.0, 4.0), between=GROUND_A)
    run = simulated(three(sp.Constant(2.0, on="a"), cubic), paths=1, duration=10.0)
    a, b, c = (run.settings.initial_position[point] for point in "abc")  # type: ignore[index]
    assert 3.0 * a + 4.0 * a**3 + 2.0 * (a - b) == pytest.approx(2.0)
    assert 2.0 * (b - a) + 1.5 * (b - c) == pytest.approx(0.0, abs=1e-12)
    assert 1.5 * (c - b) + c == pytest.approx(0.0, abs=1e-12)
    assert run["a_v_mean_square"].value < 1e-12
    assert run["a_x_mean"].value == pytest.approx(a)


def test_a_thermal_run_is_stationary_at_once() -> None:
    """Also with nonlinear springs and walls, and with more paths drawn later."""
    bent = sp.System(*thermal_pair().parts[:-1], sp.PolynomialSpring((0.0, 0.0, 1.0), between=A_B),
                     gap=sp.Barrier(-0.3, 1.0, between=A_B))  # fmt: skip
    early, late = (simulated(bent, paths=12800, duration=window[1], window=window, step=0.05, seed=seed)
                   for seed, window in ((1, (0.0, 1.0)), (2, (50.0, 60.0))))  # fmt: skip
    assert early.settings.start == "stationary"
    for name in ("a_x_mean", "b_x_mean", "a_x_mean_square", "b_x_mean_square", "a_v_mean_square", "gap_impact_rate"):
        one, other = early[name], late[name]
        assert abs(one.value - other.value) < 4.0 * np.hypot(one.error, other.error)
    given: dict[str, Any] = {"duration": 1.0, "step": 0.05, "record": 100}
    longer = sp.extend(simulated(bent, paths=100, **given), paths=200)
    assert longer.path_sums.tobytes() == simulated(bent, paths=200, **given).path_sums.tobytes()


def test_limits_on_impacts_are_counted_and_said() -> None:
    """Four masses pressed together that lose nearly all at each impact."""
    ends = A_B, ("b", "c"), ("c", "d")
    pile = sp.System(
        *masses(a=8.0, b=1.0, c=4.0, d=0.5), sp.Spring(5.0, between=("ground", "d")),
        *(sp.Spring(2.0, between=e) for e in ends), *(sp.WhiteNoise(0.2, on=p) for p in "abcd"),
        *(sp.Barrier(0.0, 0.05, "above", between=e) for e in (GROUND_A, *ends)),
        sp.Barrier(1.0, 0.05, "below", between=("ground", "d")),
    )  # fmt: skip
    run = sp.simulate(pile, paths=64, duration=100.0, step=0.02, record=64)
    assert run.diagnostics["collapses"] > 0
    assert any(getattr(message, "name", "") == "impacts_limited" for message in run.warnings)
    x = run.record[:, :, :, 0]
    assert np.isfinite(x).all()
    assert (
        min(x[:, :, 0].min(), np.diff(x, axis=2).min(), (1.0 - x[:, :, 3]).min()) > -2e-8
    )  # rounding of changes in single


# --- what is said ---------------------------------------------------------------------------------------------------

DRIVEN = thermal_pair()


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"rtol": 0.02, "quantities": ["gap"]}, "quantities must be among a_x_mean, b_x_mean"),
        ({"scheme": "grunwald"}, "scheme must be 'default': the paper's problem has one mass, and the system has 2."),
        ({"derivative": "riemann-liouville"}, "derivative must be 'caputo': the paper's problem has one mass"),
        (
            {"initial_position": 0.1},
            "initial_position must say of which masses it is, in Python as {'a': 0.01}",
        ),
        ({"initial_position": {"c": 0.1}}, "initial_position has 'c', which is no mass; there are a and b."),
        ({"initial_position": {"a": 1.0}}, "initial_position lies behind gap"),
        ({"initial_velocity": {"a": "fast"}}, "initial_velocity of a must be"),
        ({"step": 0.3}, "step is 0.3 s, too coarse for a system whose fastest rate is"),
    ],
)
def test_what_is_not_there_is_said(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((NotCoveredError, ValueError, TypeError)) as fault:
        sp.simulate(DRIVEN, **given)
    assert sentence in str(fault.value)


@pytest.mark.parametrize(
    ("system", "reason"),
    [
        (sp.System(*FREE, sp.Spring(1.0, between=A_B), sp.Dashpot(0.1, between=A_B), sp.WhiteNoise(1.0, on="a")),
         "no spring or wall keeps a and b near the ground"),
        (sp.System(*FREE, *(sp.Spring(1.0, between=e) for e in (GROUND_A, A_B)), sp.WhiteNoise(1.0, on="a")),
         "nothing dissipates energy, so it grows without limit"),
        (three(), "without excitation the motion dies out"),
    ],
)  # fmt: skip
def test_a_run_without_a_stationary_state_works_and_says_so(system: sp.System, reason: str) -> None:
    run = simulated(system, paths=64, duration=20.0)
    assert any(reason in sentence for sentence in run.warnings)
    assert run["a_v_mean_square"].value >= 0.0


def test_what_is_0_or_undefined_is_not_asked_of_a_tolerance() -> None:
    """One sentence says why; what is left out is not controlled either."""
    ends = (("ground", at) for at in "ab")
    held = [part for end in ends for part in (sp.Spring(1.0, between=end), sp.Dashpot(0.5, between=end))]
    apart = sp.System(*masses(a=1.0, b=1.0), *held, sp.WhiteNoise(1.0, on="b"))
    run = simulated(apart, rtol=0.3)
    assert run["a_x_mean_square"].value == 0.0
    assert run.diagnostics["reached"]
    with pytest.raises(ValueError, match="not a_x_mean_square: it is 0"):
        sp.simulate(apart, rtol=0.3, quantities="a_x_mean_square")
    smooth = three(sp.ColoredNoise(1.0, 1.0, on="a"), sp.Barrier(-0.1, 0.5, between=A_B))
    run = simulated(smooth, rtol=0.3, quantities="barrier_impact_rate")
    assert np.isnan(run["barrier_impact_rate"].value)
    assert any("barrier is lossy, and no white noise" in message for message in run.warnings)
    assert run["a_x_mean_square"].budget is not None


@pytest.mark.parametrize("number", range(20))
def test_the_ground_drives_two_masses_apart_by_nothing_whatever_is_rounded(number: int) -> None:
    """A product of rows is 0 there, of which rounding leaves 1e-17 on some processors: white noise for the wall."""
    draw = np.random.default_rng(number)
    a, b = draw.uniform(0.1, 3.0, 2)
    matrix = np.array([[a, 0.0], [0.0, b]])
    turned = np.array([[1.0, draw.uniform(-0.9, 0.9)], [draw.uniform(-0.9, 0.9), 1.0]])
    back = np.linalg.inv(turned)
    full = sp.System.from_matrices(back.T @ matrix @ back, back.T @ back, names={"a": back[0], "b": back[1]},
                                   ground=turned @ np.ones(2))  # fmt: skip
    wall, noise = sp.Barrier(-0.1, 0.5, between=A_B), sp.WhiteNoise(1.0, on="ground")
    for system in (
        sp.System(*masses(a=a, b=b), sp.Spring(1.0, between=GROUND_A), sp.Spring(1.0, between=A_B), wall, noise),
        sp.System(*full.parts, wall, noise),
    ):
        motion = motion_of(system)
        assert motion.struck_alone["barrier"].intensity == 0.0  # type: ignore[attr-defined]
        assert "that of the ground moves both masses alike" in motion.uncountable


def test_impacts_without_a_rate_have_advice_that_can_be_followed() -> None:
    """Those that are not slow have one; so has a contact in place of the wall."""
    smooth = sp.ColoredNoise(1.0, 1.0, on="a")
    lossy = three(smooth, sp.Barrier(-0.1, 0.5, between=A_B))
    # so many paths that hundreds of impacts are seen: whether a few paths strike turns on their last bits
    (sentence,) = (each for each in simulated(lossy, paths=64, duration=20.0).warnings if "undefined" in each)
    assert sentence.startswith("impact rate and speeds of barrier are undefined")
    assert sentence.endswith("slowest_counted_impact counts those that are faster.")
    run = simulated(lossy, paths=64, duration=20.0, slowest_counted_impact=0.1)
    assert not any("undefined" in each for each in run.warnings)  # the advice was followed
    assert np.isnan(run["barrier_impact_rate"].value)
    assert run["barrier_counted_impact_rate"].value > 0.0
    assert run["barrier_counted_impact_speed_mean"].value > 0.1
    ground = simulated(
        three(sp.WhiteNoise(1.0, on="ground"), sp.Barrier(-0.1, 0.5, between=A_B)), paths=64, duration=20.0
    )
    assert any("(that of the ground moves both masses alike)" in each for each in ground.warnings)
    soft = simulated(three(smooth, sp.Contact(-0.1, 50.0, between=A_B)), paths=64, duration=20.0)
    assert soft["contact_impact_rate"].value > 10.0 * soft["contact_impact_rate"].error > 0.0
