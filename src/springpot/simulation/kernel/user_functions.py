"""A user's own function in compiled code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit, types
from numba.core.errors import NumbaError, UnsupportedBytecodeError

from springpot.machine.faults import cause_of
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import INLINE, OF_USER
from springpot.simulation.kernel.loading import Code

_numbers = types.CPointer(types.float64)
OF_LANES = types.void(types.int64, _numbers, _numbers)
"""How the kernel calls a function of the user, by its address: (lanes, arguments, results).

Argument k of a lane is at ``k * lanes + lane``.
"""


def inlined(function: Callable[..., float], signature: Any, what: str) -> Any:
    """The function, to be called from compiled code.

    Parameters
    ----------
    function : callable
        A plain function or one that Numba has compiled.
    signature : Numba's signature
        With which it is tried.
    what : str
        Begins the sentence of the error.

    Raises
    ------
    ValueError
        If Numba cannot compile it, or it does not return a number.
    """
    plain = getattr(function, "py_func", function)
    try:
        njit(signature)(plain)
    except (NumbaError, UnsupportedBytecodeError, TypeError) as reason:
        raise ValueError(f"{what} that Numba cannot compile: {cause_of(reason)}") from None
    return njit(**OF_USER)(plain)


def in_lanes(function: Callable[..., float], arguments: int, what: str) -> Code:
    """The function of some numbers as `OF_LANES`, compiled once for all processes.

    What it captures has its value of this moment.  Where it raises an error its result is NaN.

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

    Examples
    --------
    >>> import ctypes
    >>> law = in_lanes(lambda speed: 0.8 - 0.1 * speed, 1, "the wall has a restitution")
    >>> speeds, found = np.array([1.0, 2.0]), np.empty(2)
    >>> call = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)(law.address)
    >>> call(2, speeds.ctypes.data, found.ctypes.data)
    >>> found.tolist()
    [0.7000000000000001, 0.6000000000000001]
    """
    inner = njit(**OF_USER)(getattr(function, "py_func", function))

    @njit(**INLINE)
    def value(lanes, given, lane, taken):  # type: ignore[no-untyped-def]
        return inner(*taken)

    for number in reversed(range(arguments)):
        value = _taking(value, number)

    def all_lanes(lanes, given, found):  # type: ignore[no-untyped-def]
        for lane in range(lanes):
            found[lane] = np.nan
            found[lane] = value(lanes, given, lane, ())

    try:
        return callback(OF_LANES)(all_lanes)
    except (NumbaError, UnsupportedBytecodeError, TypeError) as reason:
        raise ValueError(f"{what} that Numba cannot compile: {cause_of(reason)}") from None


def _taking(rest: Any, number: int) -> Any:
    """``rest``, which is given one argument more, that of this number."""

    @njit(**INLINE)
    def value(lanes, given, lane, taken):  # type: ignore[no-untyped-def]
        return rest(lanes, given, lane, (*taken, given[number * lanes + lane]))

    return value
