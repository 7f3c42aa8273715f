"""Compiled functions that the kernel calls by their addresses: observers, and functions of the user.

Their machine code is made, loaded and kept as that of the kernel (:mod:`springpot.simulation.kernel.native`), but under
a key of what they are made of (:mod:`springpot.simulation.kernel.fingerprint`).  So the same function is compiled once
for all processes, and once in a process however often it is asked for.  A function of which nobody can tell what it
depends on, or that needs Python while it runs, is compiled by Numba as any callback.
"""

from __future__ import annotations

import sys
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import numpy as np
from numba import float64, njit
from numba.core.errors import NumbaError, UnsupportedBytecodeError

from springpot.machine.faults import cause_of
from springpot.simulation.kernel import kept
from springpot.simulation.kernel.compiling import LEVEL, alone, object_of
from springpot.simulation.kernel.fingerprint import fingerprint
from springpot.simulation.kernel.kept import Code, MissingSymbolError, loaded, needed
from springpot.simulation.kernel.lanes import OF_USER, QUICK
from springpot.simulation.kernel.native import compiler
from springpot.simulation.kernel.targets import target_to_run
from springpot.simulation.kernel.vectors import FORCE, SHARE

_MOST = 256  # that stay in memory when nobody uses them
_IN_C = """
acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs floor fmod hypot ldexp
lgamma log log10 log1p log2 modf nearbyint pow remainder rint round sin sincos sinh sqrt tan tanh tgamma trunc
"""
_MATHEMATICS = frozenset(name + kind for name in _IN_C.split() for kind in ("", "f")) | {"memcpy", "memmove", "memset"}
"""What code may call that is not its own: functions of C that only compute."""


class _Recent:
    """Those of this process by key, the ones last asked for."""

    def __init__(self) -> None:
        self._lock, self._made = Lock(), OrderedDict[str, Code]()

    def get(self, key: str) -> Code | None:
        with self._lock:
            if key in self._made:
                self._made.move_to_end(key)
            return self._made.get(key)

    def put(self, key: str, made: Code) -> Code:
        with self._lock:
            self._made[key] = made
            while len(self._made) > _MOST:
                self._made.popitem(last=False)
        return made


_recent = _Recent()


@contextmanager
def caught() -> Iterator[list[BaseException]]:
    """What functions raise that the kernel calls meanwhile: they end with NaN, and Python would only print it."""
    found, before = list[BaseException](), sys.unraisablehook

    def keep(fault: sys.UnraisableHookArgs) -> None:
        if fault.exc_value is not None:
            found.append(fault.exc_value)

    sys.unraisablehook = keep
    try:
        yield found
    finally:
        sys.unraisablehook = before


def callback(signature: Any) -> Callable[[Callable[..., None]], Code]:
    """Compile a function that returns nothing, for use through its address.

    Parameters
    ----------
    signature : Numba's signature
        Of numbers and of arrays of them (``CPointer``).

    Returns
    -------
    callable
        Of the function, to its `Code`, whose ``how`` begins with "kept", "compiled now", or "compiled by Numba": of one
        that cannot be kept.

    Examples
    --------
    >>> import ctypes
    >>> from numba import types
    >>> @callback(types.void(types.CPointer(types.float64)))
    ... def double(number):
    ...     number[0] *= 2.0
    >>> number = ctypes.c_double(3.0)
    >>> ctypes.CFUNCTYPE(None, ctypes.c_void_p)(double.address)(ctypes.addressof(number))
    >>> number.value
    6.0
    """

    def made(function: Callable[..., None]) -> Code:
        words = fingerprint(function) if QUICK else None
        if words is None:
            return alone(function, signature)
        goal = target_to_run()
        key = repr((words, str(signature), compiler(), goal.key, LEVEL))
        if found := _recent.get(key):
            return found
        name = f"{function.__name__}.{goal.name}".replace("<", "").replace(">", "")
        if content := kept.load(name, key):
            try:
                return _recent.put(key, loaded(content, "kept on disk"))
            except MissingSymbolError:
                pass
        kept.warn_if_unused()
        content = object_of(function, signature, goal, OF_USER)
        if not needed(content) <= _MATHEMATICS:
            return _recent.put(key, alone(function, signature))
        kept.save(name, key, content)
        return _recent.put(key, loaded(content, "compiled now, and kept"))

    return made


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
