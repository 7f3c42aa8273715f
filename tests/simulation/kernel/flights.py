"""Flights with impacts and nothing else, in all lanes at once; and the same, one impact after another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import springpot as sp
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.tables import NOISE
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of

Floats = np.ndarray
FAINT = 1e-60  # N^2 s: the scales of the plan are then those of the start


def in_lanes(
    system: sp.System, starts: Floats, step: float, steps: int, *, noisy: bool = False, **given: Any
) -> tuple[Floats, dict[str, Floats]]:
    """x and v of LANES paths, each from its own start, and their sums by name; in double precision unless it is given.

    ``starts`` has the displacements of a path, then the velocities, in m and m/s.  White noise, under which no mass
    comes to rest, is part of the plan, and unless ``noisy`` its impulses are 0.
    """
    names = system.coordinates.names
    first = dict(zip(names, starts[0].tolist(), strict=False))
    plan = plan_of(
        system, paths=LANES, duration=step * steps, window=(0.0, step * steps), step=step, start="rest", record=LANES,
        initial_position=first if len(system.points) > 1 else first[names[0]], **{"memory_tolerance": 1e-8} | given,
    )  # fmt: skip
    simulation = simulation_of(plan)
    tables = simulation.parts.tables
    sweep, noise = tables.sweep.copy(), tables.integers[NOISE]
    sweep[noise : noise + tables.count("noises") * len(names)] *= noisy
    units = np.repeat(simulation.parts.units.state, len(names))
    found = simulation.with_parts(start=starts / units, tables=replace(tables, sweep=sweep)).advance()
    sums = simulation.parts.sums(found.rows)
    return found.record.reshape(LANES, steps + 1, -1, 2), sums


def one_after_another(
    walls: Sequence[tuple[float, float, float]], frequency: float, x: float, v: float, times: Floats
) -> tuple[Floats, list[float]]:
    """x and v of a mass on a spring at some times, and the speeds of its impacts; walls are (side, place, restitution).

    Each flight is a cosine of the time, which meets a wall where its angle is that of the wall.
    """
    seen, speeds, now = [], list[float](), 0.0
    for time in times:
        while True:
            met = min((_time_to(side, place, frequency, x, v), side, place, r) for side, place, r in walls)
            if now + met[0] >= time:
                break
            x, v = _turned(frequency, x, v, met[0])
            now, (_, side, x, r) = now + met[0], met
            speeds.append(-side * v)
            v *= -r
        x, v = _turned(frequency, x, v, time - now)
        now = time
        seen.append((x, v))
    return np.array(seen), speeds


def _turned(frequency: float, x: float, v: float, time: float) -> tuple[float, float]:
    c, s = math.cos(frequency * time), math.sin(frequency * time)
    return c * x + s / frequency * v, c * v - s * frequency * x


def _time_to(side: float, place: float, frequency: float, x: float, v: float) -> float:
    """Until a flight meets a wall, towards which it moves then."""
    size = math.hypot(x, v / frequency)
    if size <= abs(place):
        return math.inf
    angle = math.atan2(side * v / frequency, side * x) + math.acos(side * place / size)
    return angle % (2.0 * math.pi) / frequency
