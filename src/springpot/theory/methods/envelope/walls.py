"""What walls do to cycles: the energy before an impact, the restitution, and whether impacts can be counted."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts import Barrier
from springpot.problem.parts.walls import restitution_at, slow_restitution
from springpot.problem.system import System
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.methods.envelope.cycles import Cycles, Problem

_REBOUNDS = 20  # iterations for the restitution of a law of the speed


def after_impact(
    problem: Problem, wall: Barrier, speed: Floats, damped: Floats, cycles: Cycles
) -> tuple[float | Floats, Floats]:
    """The restitution, and the energy before an impact over the mean energy between two impacts.

    They are as in the envelope of an oscillator.  With a law of the speed the squares of the speeds before and after an
    impact have that of ``speed`` as their mean.
    """
    if not callable(wall.restitution):
        damping = np.maximum(damped / np.maximum(cycles.v_square, 1e-300), 0.0)
        return wall.restitution, before_impact(np.nan_to_num(damping * cycles.period / problem.walls), wall.restitution)
    known = np.nan_to_num(speed)
    r = restitutions(wall, known)
    for _ in range(_REBOUNDS):
        r = restitutions(wall, known * np.sqrt(2.0 / (1.0 + r**2)))
    return r, np.asarray(2.0 / (1.0 + r**2))


def restitutions(wall: Barrier, speed: Floats) -> Floats:
    """The restitution of impacts with these speeds, from 0 to 1."""
    if not callable(wall.restitution):
        return np.full_like(speed, wall.restitution)
    return np.array([restitution_at(wall, v) for v in speed.tolist()])


def endless_walls(system: System, endless: Callable[[Barrier], bool]) -> Iterator[str]:
    """What is said of each wall that is struck infinitely often."""
    for name, wall in system.walls.items():
        if endless(wall):
            yield f"{name} is struck infinitely often by slow impacts: its impact rate and speeds do not exist."


def is_endless(unit: System, wall: Barrier) -> bool:
    """Whether a wall is struck infinitely often: by slow impacts, or without white noise."""
    slow = slow_restitution(wall)
    return slow <= COLLAPSE_BELOW or (slow < 1.0 and is_smooth(unit))


def is_smooth(unit: System) -> bool:
    """Whether the excitation has no jumps in the momentum."""
    return unit.thermal is None and not any(noise.white_intensity > 0.0 for noise in unit.excitations.values())


def before_impact(damping: Floats, r: float) -> Floats:
    """Energy before an impact over the mean energy between two impacts.

    With damping d and period T the energy H grows towards q / 2d, from r^2 times its value before the impact: the ratio
    is (1 - E) / (1 - r^2 E) over 1 - (1 - r^2) (1 - E) / ((1 - r^2 E) d T), with E = e^(-d T); 2 / (1 + r^2) undamped.
    """
    if r == 1.0:
        return np.ones_like(damping)
    z = np.maximum(damping, 1e-12)
    gone = -np.expm1(-z)
    # (z - gone) / z^2, without cancellation
    lag = np.where(z < 1e-3, 0.5 - z / 6.0, (z - gone) / z**2)
    return np.asarray(gone / (z * ((1.0 - r * r) * lag + r * r * gone / z)))
