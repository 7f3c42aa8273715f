"""What is asked of the paths, and the coordinate by which splitting tells which of them are near to it.

The coordinate is the energy of mass and springs: how far a path could go if noise and losses stopped.  Where a wall
behind the motion takes energy, a path that moves towards it counts with what the next impact will leave.  Any
coordinate gives the right mean; a good one a small spread.

Between two kicks the mass moves exactly as the linear spring makes it, so that the extremes of x are those of circular
arcs, not of their ends.  Velocities jump at kicks: between two observations those of white noise of intensity q exceed
the observed ones by 0.5826 sqrt(q h) on average (see `springpot.simulation.watch.first_passage`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from springpot.problem.parts import Barrier
from springpot.problem.parts.walls import restitution_at
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.kernel.cache import callback
from springpot.simulation.kernel.lanes import GROUP, LANES
from springpot.simulation.kernel.watching import HEADER, ON_IMPACTS, ON_STEPS, Observer
from springpot.simulation.lowering.compose import Parts
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.watch.first_passage import SHIFT

__all__ = ["UNITS", "Asked", "asked_of"]

Floats = npt.NDArray[np.float64]

UNITS = {
    "x": "m", "distance": "m", "v": "m s-1", "speed": "m s-1", "amplitude": "m", "energy": "m2 s-2",
    "impact_speed": "m s-1",
}  # fmt: skip
"""Quantities that can be asked, and the units of their levels."""

SPACING = 0.05  # of kept states, in units of the mean square of v

_FIRST = len(HEADER)
_FREQUENCY = HEADER.index("frequency")
_TERMS = 12  # of the potential beside the quadratic one
# constants; then arrays with a number for each lane: the marks, and the potential of the moment
(
    _PLACED, _SIGN, _COSINE, _SINE, _LOWEST, _HIGHEST, _SQUARES, _PUSH, _STIFFNESS, _BEHIND, _LEFT, _STRUCK, _BEGIN,
    _HALF, _COUNT, _COEFFICIENTS,
) = range(_FIRST, _FIRST + 16)  # fmt: skip
_MARKS = _COEFFICIENTS + _TERMS
_MOST = _MARKS + LANES
_BY_HALF = _MOST + LANES
_POTENTIAL = _MARKS + MARKS * LANES
_SIZE = _POTENTIAL + LANES


@dataclass(frozen=True, eq=False)
class Asked:
    """A quantity whose largest value is asked of each path.

    Attributes
    ----------
    name : str
    given : ndarray
        The levels, in the user's units, in the order of rarity.
    levels : ndarray
        Of the mark that the observer keeps, in the kernel's units: a path exceeds a level if its mark does.
    observer : Observer
        Its array, without the header, holds the marks from ``marks`` on.
    spacing : float
        By which the coordinate must rise before a state is kept again.
    duration : float
        The time that counts, in s.
    target : float
        The coordinate that a path has, about, when it exceeds the last level.
    """

    name: str
    given: Floats
    levels: Floats
    observer: Observer
    spacing: float
    duration: float
    target: float

    @property
    def marks(self) -> slice:
        """Where in the array, with its header, the marks are."""
        return slice(_MARKS, _MARKS + MARKS * LANES)


def asked_of(plan: Plan, parts: Parts, name: str, levels: Floats, sign: float) -> Asked:
    """The quantity of this name, in the window of the plan; the coordinate counts in that of the run.

    Parameters
    ----------
    levels : ndarray
        In the user's units, in the order of rarity.
    sign : float
        1 if levels of x or v are exceeded upwards, -1 downwards.
    """
    motion, units, (low, high) = plan.motion, parts.units, plan.settings.window_steps
    phase = 0.5 * parts.frequency * parts.scheme.step
    root = SHIFT * math.sqrt(motion.intensity * plan.settings.step) / units.speed
    scale = {"m": units.length, "m s-1": units.speed, "m2 s-2": units.speed**2}[UNITS[name]]
    kernels = np.asarray(levels, float) * (sign if name in ("x", "v") else 1.0) / scale
    constants = np.zeros(_MARKS - _FIRST)

    def put(at: int, value: Any) -> None:
        constants[at - _FIRST : at - _FIRST + np.size(value)] = value

    up = sign * units.sign if name in ("x", "v") else 0.0
    put(_PLACED, 1.0 if name in ("x", "distance") else -1.0 if name == "impact_speed" else 0.0)
    put(_SIGN, up)
    put(_COSINE, math.cos(phase))
    put(_SINE, math.sin(phase))
    ends = sorted(units.sign * end / units.length for end in (motion.low, motion.high))
    put(_LOWEST, ends)
    if name in ("v", "speed"):
        put(_PUSH, 1.0)
        kernels = kernels - root
    if name in ("energy", "amplitude"):
        frequency = motion.system.natural_frequency if name == "energy" else motion.system.resonance
        put(_SQUARES, (frequency * units.time) ** 2)
        put(_PUSH, root)
        if name == "amplitude":
            kernels = 0.5 * (frequency * units.time * kernels) ** 2
    energy = _energy(motion, parts)
    put(_STIFFNESS, energy.stiffness)
    put(_BEHIND, math.inf)
    put(_LEFT, 1.0)
    struck = [energy(end) for end in ends if math.isfinite(end)]
    put(_STRUCK, min(struck, default=0.0))
    behind = ends[0] if up > 0.0 else ends[1]
    if name == "x" and math.isfinite(behind):
        put(_BEHIND, energy(behind))
        put(_LEFT, _share_left(motion, "above" if sign > 0.0 else "below"))
    put(_BEGIN, low)
    put(_HALF, low + (high - low) // (2 * GROUP) * GROUP)
    put(_COUNT, len(energy.beyond))
    put(_COEFFICIENTS, energy.beyond)
    initial = np.concatenate([constants, np.full(MARKS * LANES, -np.inf), np.zeros(LANES)])
    on_steps, on_impacts = _compiled()
    observer = Observer(on_steps, on_impacts if name == "impact_speed" else None, initial, per_path=True)
    target = _target(plan, name, float(levels[-1])) / units.speed**2
    spacing = SPACING * motion.law.temperature / units.speed**2
    return Asked(name, levels, kernels, observer, spacing, (high - low) * plan.settings.step, target)


@dataclass(frozen=True)
class _Energy:
    """The potential in the kernel's units: quadratic, and coefficients of x, x^2, ... beside that."""

    stiffness: float
    beyond: tuple[float, ...]

    def __call__(self, x: float) -> float:
        return 0.5 * self.stiffness * x * x + sum(c * x ** (n + 1) for n, c in enumerate(self.beyond))


def _energy(motion: Motion, parts: Parts) -> _Energy:
    """Of the springs, with what the elements with memory add at the resonance."""
    units, system = parts.units, motion.system
    force = [
        c * units.sign ** (n + 1) * units.length ** (n - 1) * units.time**2
        for n, c in enumerate(system.potential.coefficients)
    ]
    stiffness = force[1] if len(force) > 1 else 0.0
    if system.stiffness > 0.0:
        stiffness += (system.resonance**2 - system.natural_frequency**2) * units.time**2
    beyond = [0.0 if n == 1 else c / (n + 1) for n, c in enumerate(force)]
    while beyond and beyond[-1] == 0.0:
        beyond.pop()
    return _Energy(stiffness, tuple(beyond))


def _share_left(motion: Motion, side: str) -> float:
    """Of the energy, by an impact at a usual speed on the wall with the motion on this side of it."""
    wall = next(wall for wall in motion.unit.of(Barrier) if wall.side == side)
    return restitution_at(wall, math.sqrt(motion.law.temperature)) ** 2


def _target(plan: Plan, name: str, level: float) -> float:
    """The coordinate at a level, in m^2/s^2."""
    motion, system = plan.motion, plan.system
    more = system.resonance**2 - system.natural_frequency**2 if system.stiffness > 0.0 else 0.0

    def potential(x: Floats) -> Floats:
        return system.potential.energy(x) + 0.5 * more * x * x

    def height(end: float) -> float:
        return float(potential(np.linspace(start, end, 257)).max())

    start, (mean, spread, _) = float(cast(float, plan.settings.initial_position)), motion.size_of(motion.seen[0])
    if name == "x":
        return height(level)
    if name == "distance":
        return min(height(end) for end in (-level, level) if motion.low <= end <= motion.high)
    if name == "amplitude":
        return 0.5 * (system.resonance * level) ** 2
    if name == "energy":
        return level
    if name == "impact_speed":
        places = np.array([stop.position for stop in motion.touched.values()])
    else:
        places = np.clip(mean + spread * np.linspace(-6.0, 6.0, 257), motion.low, motion.high)
    return 0.5 * level**2 + float(potential(places).min())


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    @callback(ON_STEPS)
    def on_steps(x: Any, v: Any, step: float, n: int, low: int, high: int, array: Any) -> None:
        if n < low:
            return
        sign, squares, push = array[_SIGN], array[_SQUARES], array[_PUSH]
        cosine, sine, slow = array[_COSINE], array[_SINE], 1.0 / array[_FREQUENCY]
        lowest, highest = array[_LOWEST], array[_HIGHEST]
        stiffness, behind, left = array[_STIFFNESS], array[_BEHIND], array[_LEFT]
        terms = int(array[_COUNT])
        for j in range(GROUP):
            at = j * LANES
            if terms > 0:
                for lane in range(LANES):
                    array[_POTENTIAL + lane] = 0.0
                for k in range(terms - 1, -1, -1):
                    c = array[_COEFFICIENTS + k]
                    for lane in range(LANES):
                        array[_POTENTIAL + lane] = (array[_POTENTIAL + lane] + c) * x[at + lane]
            for lane in range(LANES):
                here, speed = x[at + lane], v[at + lane]
                energy = 0.5 * (speed * speed + stiffness * here * here) + array[_POTENTIAL + lane]
                kept = behind + left * (energy - behind)
                energy = kept if energy > behind and sign * speed < 0.0 else energy
                top = array[_MARKS + lane]
                array[_MARKS + lane] = energy if energy > top else top
            if array[_PLACED] > 0.0:
                for lane in range(LANES):
                    here, speed = x[at + lane], abs(v[at + lane]) * slow
                    end = highest if here > 0.0 else -lowest
                    out = abs(here)
                    end = end if sign == 0.0 else highest if sign > 0.0 else -lowest
                    out = out if sign == 0.0 else sign * here
                    far = cosine * out + sine * speed
                    far = math.sqrt(out * out + speed * speed) if sine * out > cosine * speed else far
                    far = far if far < end else end
                    most = array[_MOST + lane]
                    array[_MOST + lane] = far if far > most else most
            elif array[_PLACED] == 0.0:
                for lane in range(LANES):
                    here, speed = x[at + lane], v[at + lane]
                    out = abs(speed) if sign == 0.0 else sign * speed
                    value = push * out + (0.5 * (speed * speed + squares * here * here) if squares > 0.0 else 0.0)
                    most = array[_MOST + lane]
                    array[_MOST + lane] = value if value > most else most
        if n < array[_BEGIN]:
            for lane in range(LANES):
                array[_MOST + lane] = -np.inf
        if n < array[_HALF]:
            for lane in range(LANES):
                array[_BY_HALF + lane] = array[_MOST + lane]

    @callback(ON_IMPACTS)
    def on_impacts(count: float, speed: float, lane: int, array: Any) -> None:
        energy = array[_STRUCK] + 0.5 * speed * speed
        if energy > array[_MARKS + lane]:
            array[_MARKS + lane] = energy
        if speed > array[_MOST + lane]:
            array[_MOST + lane] = speed

    return on_steps, on_impacts
