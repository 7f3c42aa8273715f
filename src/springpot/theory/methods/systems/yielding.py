"""Parts that yield in statistical linearization: each is replaced by a spring and a dashpot in series."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy import optimize

from springpot.machine.arrays import Floats
from springpot.problem.parts import Maxwell
from springpot.problem.parts.hysteresis import Yielding
from springpot.theory.methods.systems.linear import Companion, pulled
from springpot.theory.result import NoConvergenceError, NoStationaryStateError

_ROUNDS = 40  # of halfway steps, before Newton's method
_TOLERANCE = 1e-10


def with_arms(companion: Companion, parts: Sequence[Yielding], settled: Callable[[Companion], Companion]) -> Companion:
    """A linear system with Maxwell elements that agree with its motion, last among its elements.

    Parameters
    ----------
    companion : Companion
        The linear system without them.
    parts : sequence of BoucWen or Jenkins
    settled : callable
        What makes of a linear system with them one whose springs and dampers agree with its motion too.

    Raises
    ------
    NoConvergenceError, NoStationaryStateError
        If there are none that are found, or no stationary state.
    """
    count = len(parts)

    def arms(state: Floats) -> tuple[list[Maxwell], Floats]:
        speeds = np.exp(state[:count])
        each = (
            part.nearest_arm(speed, part.arm_state(free))
            for part, speed, free in zip(parts, speeds.tolist(), state[count:].tolist(), strict=True)
        )
        found, forces = zip(*each, strict=True)
        return [*found], np.concatenate([speeds, forces])

    def missing(state: Floats) -> Floats:
        found, sizes = arms(state)
        return np.log(_sizes(settled(_with(companion, found)), found) / sizes)

    heaviest = float(np.diag(companion.mass).max())
    speeds = [part.yield_displacement * math.sqrt(part.stiffness / heaviest) for part in parts]
    state = np.concatenate([np.log(speeds), np.zeros(count)])
    for _ in range(_ROUNDS):
        step = missing(state)
        state = state + 0.5 * step
        if np.abs(step).max() < 0.01:
            break
    state = optimize.root(missing, state, method="hybr", options={"xtol": _TOLERANCE}).x
    if not np.abs(missing(state)).max() < 1e-7:
        raise NoConvergenceError("statistical linearization found no solution: its equations did not settle.")
    return _with(companion, arms(state)[0])


def _with(companion: Companion, arms: Sequence[Maxwell]) -> Companion:
    return replace(companion, elements=(*companion.elements, *arms))


def _sizes(companion: Companion, arms: Sequence[Maxwell]) -> Floats:
    """Standard deviations of the velocities of the arms' elongations, and of their forces."""
    found = pulled(companion, arms)
    if isinstance(found, str):
        raise NoStationaryStateError(found)
    return np.asarray(np.sqrt(found)).T.ravel()
