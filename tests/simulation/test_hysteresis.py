"""Parts that yield: against other simulations, against their limits, and against their own law along a path."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.monte_carlo import simulated

# Monte Carlo of another program: 512 paths of 2000 s, with steps of 0.02 and 0.04: values, and their standard errors
SMOOTH = sp.Spring(0.5), sp.Dashpot(0.1), sp.BoucWen(0.5, 0.5), sp.WhiteNoise(0.2)
SOFTER = sp.Spring(0.1), sp.Dashpot(0.04), sp.BoucWen(0.9, 0.9), sp.WhiteNoise(0.1)
BILINEAR = sp.Spring(0.1), sp.Dashpot(0.04), sp.Jenkins(0.9, 0.9), sp.WhiteNoise(0.1)
FOUND = {
    "smooth": (SMOOTH, (0.6061, 0.0014), (0.4701, 0.0010), (0.2561 * 0.25, 0.0004 * 0.25)),
    "softer": (SOFTER, (0.4860, 0.0013), (0.2337, 0.0003), (0.1707 * 0.81, 0.0002 * 0.81)),
    "bilinear": (BILINEAR, (0.7092, 0.0023), (0.3790, 0.0005), (0.3511 * 0.81, 0.0004 * 0.81)),
}  # of x, v and the force


def side_by_side(**oscillators: tuple[Any, ...]) -> sp.System:
    """Masses of 1 kg that do not meet."""
    parts: dict[str, Any] = {name: sp.Mass(1.0, at=name) for name in oscillators}
    for name, (*elements, noise) in oscillators.items():
        for element in elements:
            kind = "slider" if isinstance(element, sp.BoucWen | sp.Jenkins) else type(element).__name__.lower()
            parts[f"{name}_{kind}"] = replace(element, between=("ground", name))
        parts[f"{name}_noise"] = replace(noise, on=name)
    return sp.System(**parts)


def agrees(found: Any, value: float, error: float, bias: float = 0.0) -> bool:
    return abs(found.value - value) < 3.0 * math.hypot(found.error, error) + bias * value


def test_mean_squares_and_powers_are_those_of_another_simulation() -> None:
    system = side_by_side(**{name: oscillator for name, (oscillator, *_) in FOUND.items()})
    run = simulated(
        system, paths=512, duration=800.0, window=(160.0, 800.0), step=0.05, start="rest", seed=1,
        forces=tuple(f"{name}_slider_force" for name in FOUND),
    )  # fmt: skip
    for name, ((_, dashpot, _, noise), x, v, force) in FOUND.items():
        assert agrees(run[f"{name}_x_mean_square"], *x, bias=0.001)
        assert agrees(run[f"{name}_v_mean_square"], *v, bias=0.001)
        assert agrees(run[f"{name}_slider_force_mean_square"], *force, bias=0.001)
        taken = 0.5 * noise.intensity - dashpot.coefficient * v[0]  # all that is not lost in the dashpot
        assert agrees(run[f"{name}_slider_power"], taken, dashpot.coefficient * v[1], bias=0.002)
        assert run[f"{name}_x_mean_square"].error < 0.012 * x[0]
    assert abs(run["energy_residual"].value) < 3.0 * run["energy_residual"].error < 0.02


def test_what_never_yields_is_a_spring_and_what_always_does_is_friction() -> None:
    beside, noise = (sp.Spring(0.5), sp.Dashpot(0.1)), sp.WhiteNoise(0.2)
    system = side_by_side(
        spring=(*beside, sp.Jenkins(0.5, 1e9), noise), smooth=(*beside, sp.BoucWen(0.5, 1e9, 1.7), noise),
        sprung=(sp.Spring(1.0), sp.Dashpot(0.1), noise), stiff=(*beside, sp.Jenkins(40.0, 0.1), noise),
        rubbed=(*beside, sp.Friction(0.1), noise),
    )  # fmt: skip
    run = simulated(system, paths=256, duration=300.0, window=(60.0, 300.0), step=0.04, start="rest", seed=2)
    for name in ("spring", "smooth"):
        assert abs(run[f"{name}_slider_power"].value) < 0.01 * run["damping_power"].value
        for of, exact in (("x", 1.0), ("v", 1.0)):
            assert agrees(run[f"{name}_{of}_mean_square"], exact, run[f"sprung_{of}_mean_square"].error)
    for of in "xv":
        one, other = (run[f"{name}_{of}_mean_square"] for name in ("stiff", "rubbed"))
        assert agrees(one, other.value, other.error)


@pytest.mark.validation  # every day: Bouc-Wen, path by path, in test_reference.py
def test_a_record_of_the_force_follows_the_law_along_the_path() -> None:
    """The force is that of the recorded displacement, step by step, and the area of its loops is the power."""
    oscillators = {"plastic": BILINEAR, "smooth": (*SOFTER[:2], sp.BoucWen(0.9, 0.9, 2.0, 0.8), SOFTER[3])}
    run = simulated(
        side_by_side(**oscillators), paths=64, duration=200.0, window=(0.0, 200.0), step=0.02, start="rest", seed=3,
        forces=("plastic_slider_force", "smooth_slider_force"), record=64,
    )  # fmt: skip
    for place, (name, (*_, part, _)) in enumerate(oscillators.items()):
        force, x = run.forces[f"{name}_slider_force"], run.record[:, :, place, 0]
        moved = np.diff(x, axis=1)
        work = float((force[:, 1:] * moved).sum()) / 64 / 200.0  # the force is that of half a step before
        assert work == pytest.approx(run[f"{name}_slider_power"].value, rel=0.003)
        at_kick, z = 0.5 * (x[:, 1:] + x[:, :-1]), np.zeros(64)
        for n, step in enumerate(np.diff(at_kick, axis=1, prepend=0.0).T):
            z = followed(part, z, step)
            assert np.abs(part.stiffness * z - force[:, n + 1]).max() < 4e-3


def followed(part: Any, z: np.ndarray, way: np.ndarray) -> np.ndarray:
    """z after a short way of x."""
    if isinstance(part, sp.Jenkins):
        return np.clip(z + way, -part.yield_displacement, part.yield_displacement)
    for _ in range(8):
        ratio = np.abs(z / part.yield_displacement) ** part.exponent
        z = z + way / 8.0 * (1.0 - ratio * (part.beta * np.sign(z * way) + 1.0 - part.beta))
    return z


def test_between_two_masses_it_acts_on_both() -> None:
    """On a mass too heavy to move it is the part of one mass, and momentum is kept."""
    between = ("wall", "box")
    elements = *(replace(part, between=between) for part in SOFTER[:3]), sp.WhiteNoise(0.1, on="box")
    heavy, mass = 1e9, sp.Mass(1.0, at="box")
    held = sp.System(
        mass, sp.Mass(heavy, at="wall"), *elements, sp.Spring(heavy, between=("ground", "wall")),
        sp.Dashpot(0.5 * heavy, between=("ground", "wall")),
    )  # fmt: skip
    options: dict[str, Any] = {"paths": 64, "duration": 100.0, "step": 0.05, "start": "rest", "seed": 4}
    run, alone = (simulated(each, **options) for each in (held, side_by_side(box=SOFTER, other=BILINEAR)))
    for name in ("x", "v"):
        found = run[f"box_{name}_mean_square"].value
        assert found == pytest.approx(alone[f"box_{name}_mean_square"].value, rel=1e-4)
    free = sp.System(mass, sp.Mass(2.0, at="wall"), *elements[:3])
    thrown = {"box": 1.0, "wall": -0.5}
    speeds = simulated(free, record=1, initial_velocity=thrown, **options).record[0, :, :, 1]
    assert np.abs(speeds @ [1.0, 2.0]).max() < 1e-12
    assert np.abs(speeds[-1]).max() < 0.1


def test_the_same_bits_for_any_threads() -> None:
    system = side_by_side(one=SMOOTH, other=BILINEAR)
    options: dict[str, Any] = {"paths": 192, "duration": 20.0, "step": 0.05, "start": "rest", "seed": 5}
    one, two = (simulated(system, threads=threads, **options) for threads in (1, 2))
    assert [each.value for each in one.estimates.values()] == [each.value for each in two.estimates.values()]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.BoucWen(1.0, 0.0), r"yield_force must be in \(0, 1e\+50\], not 0"),
        (lambda: sp.BoucWen(1.0, 1.0, 0.5), "exponent must be in .* It is how sharply the force yields"),
        (lambda: sp.BoucWen(1.0, 1.0, beta=0.3), "below 1/2 it would feed some motions"),
        (lambda: sp.Jenkins(-1.0, 1.0), r"stiffness must be in \(0, 1e\+50\], not -1"),
        (lambda: sp.System(sp.Spring(1.0), sp.Jenkins(1.0, 1.0), sp.ThermalNoise(1.0)), "jenkins cannot be combined"),
        (lambda: sp.simulate(sp.System(*SMOOTH[1:])), "with parts that yield alone the mass drifts without end"),
        (lambda: sp.simulate(sp.System(*SMOOTH), scheme="grunwald"), "scheme must be 'default': bouc_wen cannot be"),
        (
            lambda: sp.simulate(sp.System(sp.Spring(1.0), sp.WhiteNoise(1.0), *[sp.Jenkins(1.0, 1.0)] * 13)),
            "at most 12",
        ),
        (lambda: sp.theory.linearization(sp.System(*SMOOTH, sp.Barrier(-1.0, 0.5))), "without walls.*, not barrier"),
        (lambda: sp.theory.envelope(sp.System(*SMOOTH)), "with stationary noise, not bouc_wen"),
        (lambda: sp.theory.linear(sp.System(*BILINEAR)), "not jenkins"),
    ],
)
def test_what_cannot_be_is_one_sentence(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()


@pytest.mark.validation  # every day: moments of yielding parts, in theory/test_yielding.py
def test_without_a_spring_it_is_said_that_it_drifts() -> None:
    system = sp.System(*SMOOTH[1:])
    assert "it drifts without end: only parts that yield hold the mass" in sp.explain(system)
    found = sp.theory.linearization(system)
    assert math.isnan(found.x_mean_square)
    assert (
        found.warnings[0] == "The mass drifts, since only parts that yield hold it: x has no stationary law, v has one."
    )
    loose = sp.theory.linearization(sp.System(sp.Dashpot(0.1), sp.WhiteNoise(0.1)))
    assert "no spring pulls the mass back" in loose.stationary


# --- one mass ---------------------------------------------------------------------------------------------------------


@pytest.mark.validation
@pytest.mark.parametrize("name", FOUND)
def test_one_mass_has_the_law_of_several(name: str) -> None:
    oscillator, x, v, force = FOUND[name]
    system = sp.System(*oscillator[:2], oscillator[3], slider=oscillator[2])
    run = simulated(
        system, paths=512, duration=2000.0, window=(200.0, 2000.0), step=0.04, start="rest", seed=6,
        forces=("slider_force",),
    )  # fmt: skip
    assert agrees(run["x_mean_square"], *x)
    assert agrees(run["v_mean_square"], *v)
    assert agrees(run["slider_force_mean_square"], *force)
    assert agrees(run["energy_residual"], 0.0, 0.0)
    kept = simulated(system, paths=64, duration=20.0, step=0.04, start="rest", seed=6)
    pair = side_by_side(one=oscillator, other=BILINEAR)
    several = simulated(pair, paths=64, duration=20.0, step=0.04, start="rest", seed=6)
    assert kept["x_mean_square"].value == pytest.approx(several["one_x_mean_square"].value, rel=2e-3)


@pytest.mark.validation
def test_impacts_turn_the_way() -> None:
    """The slider follows x to the stop and back within a step: a long step has the moments of a short one."""
    system = sp.System(*SMOOTH, sp.Barrier(-0.3, 0.8))
    coarse, fine = (
        simulated(system, paths=4096, duration=100.0, window=(20.0, 100.0), step=step, start="rest", seed=7)
        for step in (0.1, 0.0125)
    )
    for name in ("x_mean_square", "v_mean_square", "impact_rate", "bouc_wen_power"):
        assert agrees(coarse[name], fine[name].value, fine[name].error, bias=0.008)


@pytest.mark.validation
def test_alone_it_drifts() -> None:
    """<x^2> grows in proportion to time, and <v^2> and z are stationary; the spring is too weak to matter."""
    system = sp.System(sp.Spring(1e-9), sp.Dashpot(0.1), sp.BoucWen(1.0, 1.0), sp.WhiteNoise(0.2))
    for duration, x, error in ((400.0, 14.8, 0.9), (800.0, 28.7, 2.0)):
        run = simulated(
            system, paths=2048, duration=duration, window=(100.0, duration), step=0.04, start="rest",
            forces=("bouc_wen_force",),
        )  # fmt: skip
        assert agrees(run["x_mean_square_end"], x, error)
        assert agrees(run["v_mean_square"], 0.310, 0.001)
        assert agrees(run["bouc_wen_force_mean_square"], 0.211, 0.001)


@pytest.mark.validation
def test_a_split_path_goes_on_from_its_own_slider() -> None:
    system = sp.System(*SOFTER)
    options: dict[str, Any] = {"duration": 40.0, "step": 0.05, "start": "rest"}
    rare = sp.exceedance(system, {"x": 2.5}, rtol=0.05, seed=8, **options)
    run = simulated(system, paths=200_000, seed=9, first_passage={"x": 2.5}, **options)
    (left,), (error,) = run.first_passages["x"].survival([39.99])
    chance, own = float(rare.probability["x"]), float(rare.error["x"])
    assert abs(chance - (1.0 - left)) < 3.0 * math.hypot(own, error)
