"""Noise with a given spectral density: its filter, the law of its impulses, and runs against exact and other laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.lowering.filters import filtered
from springpot.simulation.lowering.shaping import FAR, FLOOR, filter_of, shape_of
from tests.sizes import validation

from .problems import assert_agrees
from .systems import AWAY, NEARLY_LINEAR

Floats = Any
STANDARD = (10.0, 40.0, 500.0, 2000.0), (0.01, 0.04, 0.04, 0.005)
FLAT = (10.0, 2000.0), (0.02, 0.02)
NARROW = (50.0, 60.0), (0.02, 0.02)
STEEP = (10.0, 90.0, 110.0, 500.0), (0.01, 0.01, 0.1, 0.1)
_F = np.geomspace(10.0, 2000.0, 120)
_PEAKS = (1.0 / (1.0 + (q * (_F / f - f / _F)) ** 2) for q, f in ((10.0, 60.0), (15.0, 420.0)))
MEASURED = tuple(_F), tuple(0.02 * (_F / 100.0) ** -0.5 * (1.0 + 8.0 * next(_PEAKS) + 4.0 * next(_PEAKS)))
PROFILES = {"standard": STANDARD, "flat": FLAT, "narrow": NARROW, "steep": STEEP, "measured": MEASURED}


def noise(profile: tuple[Any, Any], at: float = 1.0, **given: Any) -> sp.SpectralExcitation:
    """A profile with all frequencies times a factor, and a mean square of 1."""
    raw = sp.SpectralExcitation([at * f for f in profile[0]], profile[1], **given)
    return sp.SpectralExcitation(raw.frequency, raw.psd, 1.0 / raw.mean_square, raw.on)


@pytest.mark.parametrize("name", ["flat", *map(validation, ("standard", "narrow", "steep", "measured"))])
def test_the_filter_has_the_density_of_the_table(name: str) -> None:
    part = noise(PROFILES[name])
    shape = shape_of(part, name)
    low, high = part.frequency[0], part.frequency[-1]
    edge = min(math.log(1.1), 0.1 * math.log(high / low))
    u = np.linspace(math.log(low) + edge, math.log(high) - edge, 20_001)
    table = np.array([part.one_sided(at) for at in np.exp(u)]) / part.scale / max(part.psd)
    window = np.ones(round(0.4 * edge / (u[1] - u[0])))  # no resonance is narrower
    made, wanted = (np.convolve(each, window, "valid") for each in (shape.density(np.exp(u)), table))
    off = np.abs(made / wanted - 1.0)
    assert off.max() < (0.01 if name != "measured" else FAR)
    assert math.sqrt(np.mean(off**2)) < 0.0025
    assert len(shape.poles) <= (15 if name != "measured" else 24)
    for far in (1.4, 3.0, 30.0):
        ends = shape.density(np.array([low / far**2, high * far**2]))
        assert np.all(ends < 3e-4)
    f = np.geomspace(low / 10.0, high * 10.0, 400_001)
    area = np.trapezoid(shape.density(f) * f, np.log(f)) * max(part.psd) * part.scale
    assert area == pytest.approx(part.mean_square, rel=2e-3)


@pytest.mark.parametrize("step", [2e-6, 1e-4, 1e-3, 7e-3])
def test_impulses_are_integrals_of_the_force_over_the_steps(step: float) -> None:
    """Their density is that of the force times sinc^2, folded: of the innovations form, within the band."""
    part = noise(FLAT)
    shape = shape_of(part, "flat")
    law = filtered([filter_of(shape, 1.0, 2.0 * math.pi * step)], 1.0, floor=FLOOR)
    size = law.start.shape[0]
    move, seen, gain = np.zeros((size, size)), np.zeros(size), np.zeros(size)
    for k, pair in enumerate(law.pairs):  # of four steps
        own = slice(2 * k, 2 * k + 2)
        move[own, own] = pair[:4].reshape(2, 2) + np.eye(2)
        seen[own], gain[own] = pair[4:6], pair[18:20]
    root = np.linalg.eigvals(move)
    assert np.abs(root).max() < 1.0
    shown, moved = (
        np.concatenate([pair[at].reshape(4, 2) for pair in law.pairs], axis=1) for at in (slice(4, 12), slice(12, 20))
    )
    direct = np.zeros((4, 4))
    for n in range(4):
        direct[n, : n + 1] = law.newest[: n + 1][::-1]
    for f in np.geomspace(11.0, min(1900.0, 0.45 / step), 15):
        turn = 2.0 * math.pi * f * step
        phase = np.exp(-1j * turn * np.arange(4))
        response = direct + shown @ np.linalg.solve(np.exp(4j * turn) * np.eye(size) - move, moved.T)
        # four steps together: the transfer from one normal to the sum of the aligned impulses
        transfer = sum((response[n] * phase[n]) @ phase.conj() for n in range(4)) / 4.0
        folds = np.abs(f + np.arange(-2000, 2001) / step)
        wanted = (shape.density(folds) * np.sinc(folds * step) ** 2).sum()
        assert abs(transfer) ** 2 == pytest.approx(wanted, rel=2e-4)


AT_1 = 1.0 / (2.0 * math.pi) / 30.0  # 30 Hz of a profile at 1 rad/s


def test_a_run_has_the_exact_mean_squares() -> None:
    parts = sp.Spring(1.0), sp.Springpot(0.5, 0.3), noise(STANDARD, AT_1, on="mass")
    exact = sp.theory.linear(sp.System(*parts))
    known = {name: getattr(exact, name) for name in ("x_mean_square", "v_mean_square")}
    run = sp.simulate(
        sp.System(*parts, NEARLY_LINEAR, *AWAY), paths=8000, duration=70.0, step=0.05, start="rest", seed=2
    )
    assert_agrees(run, known, sharp=0.01)
    assert run["spectral_excitation_power"].value == pytest.approx(run["damping_power"].value, rel=0.03)
    assert run["input_power"].value == pytest.approx(run["spectral_excitation_power"].value, rel=1e-6)
    assert not [message for message in run.warnings if message.name == "shaped_density"]


@pytest.mark.validation
@pytest.mark.parametrize("order", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("name", PROFILES)
def test_runs_have_the_exact_mean_squares_to_half_a_per_cent(order: float, name: str) -> None:
    """Standard errors of a third of it; the resonance is at 30 Hz, of the narrow band at 55 Hz."""
    parts = sp.Spring(1.0), sp.Springpot(order, 0.3)
    at = sp.System(*parts).resonance / (2.0 * math.pi) / (30.0 if name != "narrow" else 55.0)
    system, end = sp.System(*parts, noise(PROFILES[name], at)), 240.0 if name != "narrow" else 440.0
    exact = sp.theory.linear(system)
    known = {"x_mean_square": exact.x_mean_square, "v_mean_square": exact.v_mean_square,
             "acceleration_mean_square": exact.mean_square(of="acceleration")}  # fmt: skip
    run = sp.simulate(
        system, paths=64_000, duration=end, window=(40.0, end), step=0.02, seed=5, forces=["acceleration"]
    )
    for quantity, wanted in known.items():
        value, error = run[quantity].value, run[quantity].error
        assert error < 0.0015 * wanted
        assert abs(value / wanted - 1.0) < 0.005, (quantity, value / wanted - 1.0, error / wanted)


def test_several_masses_take_it_too() -> None:
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(1.0, between=("ground", "a")),
        sp.Dashpot(0.3, between=("ground", "a")), sp.Spring(0.4, between=("a", "b")),
        sp.Springpot(0.5, 0.2, between=("a", "b")), noise(FLAT, AT_1), push=noise(STANDARD, AT_1, on="b"),
    )  # fmt: skip
    exact = sp.theory.linear(system)
    names = [f"{point}_{of}_mean_square" for point in "ab" for of in "xv"] + ["a_b_elongation_mean_square"]
    run = sp.simulate(system, paths=4000, duration=100.0, window=(40.0, 100.0), step=0.05, seed=3)
    assert_agrees(run, {name: getattr(exact, name) for name in names}, sharp=0.015)
    fed = run["spectral_excitation_power"].value + run["push_power"].value
    assert run["input_power"].value == pytest.approx(fed, rel=1e-6)


@pytest.mark.validation  # every day: how near a filter is, in problem/
def test_a_resonance_beside_the_band_is_told() -> None:
    """The filter passes a little there, and the message says by how much it changes the mean squares."""
    shake = noise(NARROW, AT_1 * 30.0 / 200.0, on="mass")  # a quarter of the natural frequency
    system = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.05), shake, NEARLY_LINEAR, *AWAY)
    run = sp.simulate(system, paths=64, duration=20.0, start="rest")
    (found,) = [message for message in run.warnings if message.name == "shaped_density"]
    assert found.startswith("spectral_excitation is made by a filter, which changes the linear response by ")


def box(m: float = 2.5, bare: float = 68.9, with_them: float = 96.0, order: float = 0.25) -> sp.System:
    """2.5 kg on four springpots of order 0.25 between two stops: 11 Hz without the springpots, 15.3 Hz with them."""
    pot = m * (with_them**2 - bare**2) / (with_them**order * math.cos(order * math.pi / 2.0))
    shake = sp.SpectralExcitation.from_psd((10, 2000), 0.02, "g2/Hz")
    stops = sp.Barrier(-4e-3, 0.6), sp.Barrier(4e-3, 0.6, free_side="below")
    return sp.System(sp.Mass(m), sp.Spring(m * bare**2), sp.Springpot(order, pot), *stops, shake)


def impacts_of_sinusoids(system: sp.System, slowest: float, paths: int, lines: int = 2000) -> dict[str, Floats]:
    """The same box under a sum of sinusoids, with its own memory and steps: samples of each path from 1 s to 3 s.

    One frequency in each of the bins that share the band's logarithm, and Gaussian amplitudes for each path.
    """
    rng, h, steps, first = np.random.default_rng(5), 2e-4, 15_000, 5000
    (mass,), (spring,), (pot,), (shake,) = (
        system.of(kind) for kind in (sp.Mass, sp.Spring, sp.Springpot, sp.SpectralExcitation)
    )
    (low_wall, high_wall), order = system.of(sp.Barrier), pot.order
    edges = np.geomspace(*shake.frequency, lines + 1)
    w = 2.0 * np.pi * (edges[:-1] + rng.random(lines) * np.diff(edges))
    size = np.sqrt(shake.psd[0] * np.diff(edges)) * np.sinc(w * h / (2.0 * np.pi))  # the mean of a step
    amplitudes = (rng.standard_normal((2 * lines, paths)) * np.tile(size, 2)[:, None]).astype(np.float32)
    # t^-order / Gamma(1 - order) = int exp(-s t) s^(order - 1) ds, by the trapezoidal rule over the logarithm of s
    u = np.arange(math.log(0.02), math.log(3.0 / h), 0.5)
    s, scale = np.exp(u), pot.coefficient / mass.value / (math.gamma(order) * math.gamma(1.0 - order))
    weight, decay = 0.5 * scale * np.exp(order * u), np.exp(-s * h)[:, None]
    gain = (1.0 - decay) / (s * h)[:, None]
    k = spring.stiffness / mass.value + scale * math.exp(order * (u[0] - 0.25)) / order
    c = scale * math.exp((order - 1.0) * (u[-1] + 0.25)) / (1.0 - order)
    x, v, z = np.zeros(paths), np.zeros(paths), np.zeros((len(s), paths))
    squares, speeds, count = np.zeros(paths), np.zeros(paths), np.zeros(paths)
    for block in range(0, steps, 500):
        t = (np.arange(block, block + 500) + 0.5) * h
        waves = np.concatenate([np.cos(np.outer(t, w)), np.sin(np.outer(t, w))], axis=1).astype(np.float32)
        for acceleration in waves @ amplitudes:
            v = v + h * (acceleration - k * x - c * v - weight @ z)
            after = x + h * v
            for wall, sign in ((low_wall, -1.0), (high_wall, 1.0)):
                beyond = sign * (after - wall.position)
                struck = beyond > 0.0
                if block >= first:
                    count += struck & (np.abs(v) > slowest)
                after = np.where(struck, wall.position - sign * wall.restitution * beyond, after)
                v = np.where(struck, -wall.restitution * v, v)
            z, x = decay * z + gain * (after - x), after
            if block >= first:
                squares, speeds = squares + x * x, speeds + v * v
    seen = steps - first
    return {"counted_impact_rate": count / (seen * h), "x_mean_square": squares / seen, "v_mean_square": speeds / seen}


@pytest.mark.validation
def test_impacts_of_a_box_against_two_thousand_sinusoids() -> None:
    """Impacts faster than 2 cm/s, about 80 a minute, within 3 %."""
    slowest, system = 0.02, box()
    sinusoids = impacts_of_sinusoids(system, slowest, paths=12_288)
    run = sp.simulate(
        system, paths=65_536, duration=3.0, window=(1.0, 3.0), start="rest", slowest_counted_impact=slowest, seed=6
    )
    for name, share in (("counted_impact_rate", 0.03), ("x_mean_square", 0.015), ("v_mean_square", 0.015)):
        other, error = sinusoids[name].mean(), sinusoids[name].std() / math.sqrt(len(sinusoids[name]))
        assert math.hypot(error, run[name].error) < 0.012 * other
        assert abs(run[name].value / other - 1.0) < share, (name, run[name], other, error)


@pytest.mark.validation
@pytest.mark.parametrize(("steps", "share"), [(20, 0.01), (80, 0.0)])
def test_a_wall_needs_no_finer_step_for_a_wide_band(steps: int, share: float) -> None:
    """A stop at one standard deviation, r = 0.7, damping ratio 0.05, 15 Hz, the standard profile.

    The numbers are those of another program with 320 steps in a period and a filter for that step: mean squares and
    the wall's power over those of the free motion, and impacts per second that are faster than 0.3 of its v.
    """
    shake, w = sp.SpectralExcitation.from_psd(*STANDARD, "g2/Hz"), 2.0 * math.pi * 15.0
    parts = sp.Spring(w**2), sp.Dashpot(0.1 * w)
    free = sp.theory.linear(sp.System(*parts, shake))
    x, v = math.sqrt(free.x_mean_square), math.sqrt(free.v_mean_square)
    run = sp.simulate(
        sp.System(*parts, sp.Barrier(-x, 0.7), shake), paths=32_768, duration=3.0, window=(1.0, 3.0), start="rest",
        step=1.0 / (15.0 * steps), slowest_counted_impact=0.3 * v, seed=8,
    )  # fmt: skip
    for name, unit, known, error in (
        ("x_mean_square", x * x, 0.6547, 0.0013), ("v_mean_square", v * v, 0.8847, 0.0018),
        ("barrier_power", 0.1 * w * v * v, 0.5335, 0.0021), ("counted_impact_rate", 1.0, 10.44, 0.03),
    ):  # fmt: skip
        found, own = run[name].value / unit, run[name].error / unit
        assert own < 0.004 * known
        assert abs(found - known) < 4.0 * math.hypot(own, error) + share * known, name
