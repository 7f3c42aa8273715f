"""A user's own force in the kernel: each function gets a type of part of its own, because types choose the code."""

from __future__ import annotations

import itertools
from collections import namedtuple
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from numba import float64

from springpot.simulation.kernel.forces import register_damper
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.questions import answers, damp
from springpot.simulation.kernel.user_functions import inlined

_FIELDS = ("half", "step", "time", "length", "speed")
_numbers = itertools.count(1)


@lru_cache(maxsize=64)
def user_force(function: Callable[[float, float, float], float], name: str) -> Any:
    """The kernel's type of part for a force f(t, x, v).

    Its fields: half a step over the user's unit of acceleration, the step, and the kernel's units of time, length and
    speed.  The velocity follows v' = f(t, x, v) for half a step before the kick and half a step after it, by the
    midpoint method: of second order in the step, whether or not the force depends on the velocity.

    Parameters
    ----------
    function : callable
    name : str
        Of the part, for the sentence.

    Raises
    ------
    ValueError
        If Numba cannot compile the function, or it does not return a number.
    """
    inner = inlined(function, float64(float64, float64, float64), f"{name} has a function")
    make: Any = namedtuple  # a type checker wants the name to be known
    kind = make(f"UserForce{next(_numbers)}", _FIELDS)
    kind.__module__ = "__user__"  # so that its kernels are not kept on disk

    @answers(damp, kind)
    def follow(force, slot, n, x, v, forcing, lane, weight, after):  # type: ignore[no-untyped-def]
        t, place = force.time * force.step * (n + 0.5), force.length * x
        middle = v + 0.5 * force.half * inner(t, place, force.speed * v)
        later = v + force.half * inner(t, place, force.speed * middle)
        forcing.works[slot * LANES + lane] += weight * 0.5 * (later - v) * (later + v)
        return later - v

    register_damper(kind)
    return kind
