"""Functions of the user as compiled code with an address: the kernel needs no compilation of its own for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import float64, njit
from numba.core.errors import NumbaError, UnsupportedBytecodeError

from springpot.machine.faults import cause_of
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.calling import FORCE, SHARE
from springpot.simulation.kernel.lanes import OF_USER
from springpot.simulation.kernel.loading import Code


def inlined(function: Callable[..., float], arguments: int, what: str) -> Any:
    """The function of some numbers, to be called from compiled code.

    Parameters
    ----------
    function : callable
        A plain function or one that Numba has compiled.
    arguments : int
        How many it takes.
    what : str
        Begins the sentence of the error.

    Raises
    ------
    ValueError
        If Numba cannot compile it, or it does not return a number.
    """
    plain = getattr(function, "py_func", function)
    try:
        njit(float64(*[float64] * arguments))(plain)
    except (NumbaError, UnsupportedBytecodeError, TypeError) as reason:
        raise ValueError(f"{what} that Numba cannot compile: {cause_of(reason)}") from None
    return njit(**OF_USER)(plain)


def force_of(function: Callable[[float, float, float], float], name: str) -> Code:
    """A force f(t, x, v) in the kernel.

    Its numbers: half a step over the user's unit of acceleration per unit of mass, and the kernel's units of time,
    length and speed.  The velocity follows v' = f(t, x, v) for half a step before the kick and half a step after it, by
    the midpoint method: of second order in the step, whether or not the force depends on the velocity.  Where the
    function raises an error the velocity becomes NaN.

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
    inner = inlined(function, 3, f"{name} has a function")

    def follow(time, numbers, x, v, change, count):  # type: ignore[no-untyped-def]
        half, t = numbers[0], numbers[1] * time
        for i in range(count):
            change[i] = np.nan
        for i in range(count):
            place = numbers[2] * x[i]
            middle = v[i] + 0.5 * half * inner(t, place, numbers[3] * v[i])
            later = v[i] + half * inner(t, place, numbers[3] * middle)
            change[i] = later - v[i]

    return callback(FORCE)(follow)


def restitution_of(function: Callable[..., float], name: str, numbers: tuple[float, ...] = ()) -> Code:
    """A restitution as a function of the speed in m/s, and of some numbers.

    What the function returns is cut off at 0 and 1, but not where it is no number.

    Raises
    ------
    ValueError
        If Numba cannot compile the function, or it does not return a number.
    """
    inner = inlined(function, 1 + len(numbers), f"{name} has a restitution")

    def follow(speed, found):  # type: ignore[no-untyped-def]
        found[0] = np.nan  # what is left if the function raises an error
        share = inner(speed, *numbers)
        found[0] = 0.0 if share < 0.0 else 1.0 if share > 1.0 else share

    return callback(SHARE)(follow)
