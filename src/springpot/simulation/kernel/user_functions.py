"""A user's own function in compiled code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.errors import NumbaError, UnsupportedBytecodeError

from springpot.machine.faults import cause_of
from springpot.simulation.kernel.lanes import OF_USER


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
