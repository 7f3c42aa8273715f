"""What the parts of a system cost: time per path-step against the oscillator with the same springpot and wall."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

from benchmarks.measure import Row, cpu_by_turns
from springpot import (
    Barrier,
    ColoredNoise,
    Contact,
    Oscillator,
    PolynomialSpring,
    SpectralExcitation,
    Spring,
    Springpot,
    System,
    ThermalNoise,
    WhiteNoise,
)
from springpot.simulation.paths.simulation import Simulation, simulation_of
from springpot.simulation.plan.plan import plan_of

__all__ = ["systems"]

_BASE = (Spring(1.0), Springpot(0.5, 0.5))
_LOW, _HIGH, _WHITE = Barrier(-0.5, 0.9), Barrier(1.5, 0.9, "below"), WhiteNoise(1.0)
_CUBIC, _COLORED = PolynomialSpring((0.0, 0.0, 0.2)), ColoredNoise(1.0, 0.5)
_HERTZ = 1.0 / (60.0 * math.pi)  # a profile whose 30 Hz is the natural frequency
_FLAT, _STANDARD = (
    SpectralExcitation([_HERTZ * f for f in frequency], psd, on="mass")
    for frequency, psd in (((10.0, 2000.0), (1.0, 1.0)), ((10.0, 40.0, 500.0, 2000.0), (1.0, 4.0, 4.0, 0.5)))
)
_PROBLEMS: dict[str, System] = {
    "oscillator with a wall": Oscillator(1.0, Springpot(0.5, 0.5), _LOW, _WHITE),
    "and a cubic spring": System(*_BASE, _LOW, _WHITE, _CUBIC),
    "and a second wall": System(*_BASE, _LOW, _HIGH, _WHITE),
    "and colored noise": System(*_BASE, _LOW, _WHITE, _COLORED),
    "and all three": System(*_BASE, _LOW, _HIGH, _WHITE, _CUBIC, _COLORED),
    "a Hertz contact instead of the wall, touched 1 % of the time": System(*_BASE, Contact(-0.5, 3e4), _WHITE),
    "a flat band of 10 to 2000 Hz instead of white noise": System(*_BASE, _LOW, _FLAT),
    "the profile of a standard instead of white noise": System(*_BASE, _LOW, _STANDARD),
    "thermal noise instead of white, elastic wall": System(*_BASE, Barrier(-0.5), ThermalNoise(1.0)),
}


def systems(quick: bool, problems: Mapping[str, System] = _PROBLEMS) -> list[Row]:
    """Rows of the section on systems; the cases are run by turns, and each has its least time."""
    section = "systems of parts"
    steps, turns = (200, 1) if quick else (10_000, 25)
    prepared, first = dict[str, Simulation](), {}
    for name, problem in problems.items():
        begun = time.perf_counter()
        plan = plan_of(problem, paths=256, duration=0.01 * steps, step=0.01, threads=1, start="rest")
        prepared[name] = simulation_of(plan.but(initial_position=0.0))
        prepared[name].but(duration=0.1, window=(0.0, 0.1)).advance()
        first[name] = time.perf_counter() - begun
    least = cpu_by_turns({name: simulation.advance for name, simulation in prepared.items()}, turns)
    base, *_ = least.values()
    return [
        Row(section, name, 1e9 * taken / (256 * steps), "ns per path-step", taken / base, "the oscillator",
            f"{first[name]:.1f} s before the first path, from the cache or compiled")
        for name, taken in least.items()
    ]  # fmt: skip
