"""Observers of a block of paths: called through addresses, so that a new observer needs no new kernel.

An observer is compiled separately.  The kernel has two addresses of it (either may be missing): one is called with
every group of four steps of all lanes, one with every impact.  It accumulates in an array of doubles, one for each
block, that starts with a header (:data:`HEADER`) for the conversion of the kernel's units to the user's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import llvmlite.ir as ir
import numpy as np
import numpy.typing as npt
from numba import njit, types
from numba.extending import intrinsic

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, beyond, f64, typed

BATCHES = 64  # groups of paths with separate counts, for standard errors
ALL, PEAKS = -1, -2  # walls; less its number, the largest forces of a contact
LOWER, UPPER, CONTACTS = 0, 1, 2  # the walls of one mass: a lone one is the lower; then contacts, one after another

HEADER = ("length", "speed", "time", "frequency", "wall", "lanes")
"""First numbers of an observer's array: x, v and t of the kernel times the first three are x, v and t of the user.

``length`` and ``speed`` are negative for a wall above the motion, which is mirrored in the kernel; ``frequency`` is
Omega and ``wall`` the position of the wall (0 without one), both in the kernel's units; only the first ``lanes`` lanes
are paths of the run.  Of a force or an acceleration, which has the place of x, ``frequency`` is what brings it near 1,
and ``wall`` twice the root of what its mean square lacks.
"""

_numbers = types.CPointer(types.float64)
ON_STEPS = types.void(_numbers, _numbers, types.float64, types.int64, types.int64, types.int64, _numbers)
"""(x, v, step, n, low, high, array): x[j * LANES + lane] at the end of step n + j, of which low .. high - 1 count.

Of several masses x and v are those of the displacement that the observer is ``of``, and after them, GROUP * LANES
numbers each, those of the next ones.  Beyond the displacements v is of the whole group: the power of dampers and
memory summed over its steps, then the work of each named force, LANES numbers each.
"""
ON_IMPACTS = types.void(types.float64, types.float64, types.int64, _numbers)
"""(count, speed, lane, array): ``count`` impacts at this speed."""


@dataclass(frozen=True, eq=False)
class Observer:
    """One observer: two compiled functions and the array they accumulate in.

    Attributes
    ----------
    on_steps, on_impacts : compiled function or None
        Of the signatures ``ON_STEPS`` and ``ON_IMPACTS``.
    initial : ndarray of float
        Content of the array at the start of a block, without the header.
    per_path : bool
        Whether the array has LANES numbers for each observed quantity, or counts of the whole block.
    every : int
        Groups of steps between two calls of ``on_steps``.
    of : int
        Number of the displacement that ``on_steps`` sees first.
    stop : str
        The wall or contact whose impacts ``on_impacts`` sees; empty for all.
    place : float
        Of this wall, in m, where there are several masses.
    per_block : bool
        Whether the whole array of each block is kept: of sums that are no whole numbers, so that the order of the
        blocks matters.
    feels : tuple of int
        Which forces and accelerations ``on_steps`` sees.
    peaks : bool
        Whether ``on_impacts`` sees the largest force of each touch of the contact ``stop``, in place of the speed.
    impulse : float
        By which speeds are multiplied if it is not 0.
    behind : callable
        From the kernel's arguments to numbers that are put behind the array.
    counts, forgotten : int
        Numbers at the end of the array of an observer ``per_path``: counts of the whole block, and behind them what is
        not kept.
    """

    on_steps: Any
    on_impacts: Any
    initial: Floats
    per_path: bool
    every: int = 1
    of: int = 0
    stop: str = ""
    place: float = 0.0
    per_block: bool = False
    feels: tuple[int, ...] = ()
    peaks: bool = False
    impulse: float = 0.0
    counts: int = 0
    forgotten: int = 0
    behind: Callable[[Any], Floats] = lambda parts: np.zeros(0)

    @property
    def own(self) -> int:
        """How many numbers of the array are those of lanes."""
        return self.initial.size - self.counts - self.forgotten if self.per_path else 0


class Observers(NamedTuple):
    """Addresses of the observers of a block and of their arrays; an address of 0 is not called."""

    on_steps: npt.NDArray[np.int64]
    on_impacts: npt.NDArray[np.int64]
    place: npt.NDArray[np.int64]
    every: npt.NDArray[np.int64]  # groups between two calls of on_steps
    begin: npt.NDArray[np.int64]  # where in the arrays of x and v
    stop: npt.NDArray[np.int64]  # number of the wall, or ALL, or PEAKS less the number of a contact
    # forces and accelerations, which `springpot.simulation.kernel.felt` makes of rows
    feels: npt.NDArray[np.int64]  # the numbers of those that are seen
    felt_begin: npt.NDArray[np.int64]  # of the terms of each
    felt_row: npt.NDArray[np.int64]  # (terms,)
    felt: Floats  # (terms, NUMBERS)
    record: Floats  # (paths, points in time, seen): of the first paths, at the kicks before those points


NO_OBSERVERS = Observers(*(np.zeros(0, np.int64),) * 9, np.zeros(0), np.zeros((0, 0, 0)))


class Accumulators(NamedTuple):
    """Sums of impacts for each lane, and the observers."""

    impacts: Any
    speeds: Any
    squares: Any
    collapses: Any  # over the whole run
    extras: Any  # sums of the wall's own, one after another
    observers: Observers


def _calling(count: int, signature: Any) -> Any:
    """An intrinsic that calls an address with ``count`` arguments and, last, the address of an array."""

    @intrinsic
    def call(typing_context, address, arguments):
        def codegen(context, builder, call_signature, values):
            kinds = [context.get_value_type(kind) for kind in signature.args]
            function = builder.inttoptr(values[0], ir.FunctionType(ir.VoidType(), kinds).as_pointer())
            given = [builder.extract_value(values[1], i) for i in range(count + 1)]
            given[-1] = builder.inttoptr(given[-1], kinds[-1])
            builder.call(function, given)
            return context.get_dummy_value()

        wanted = types.Tuple((*signature.args[:-1], types.int64))
        return types.void(types.int64, wanted), codegen

    return call


_call_on_steps = _calling(len(ON_STEPS.args) - 1, ON_STEPS)
_call_on_impacts = _calling(len(ON_IMPACTS.args) - 1, ON_IMPACTS)


@njit(**INLINE)
def _is_due(observers, i, n, low):
    """Whether an observer is called with the group of step n; the first is that in which the window begins."""
    return observers.on_steps[i] != 0 and (n // GROUP - low // GROUP) % observers.every[i] == 0


@njit(**INLINE)
def is_seen(observers, n, low, begin):
    """Whether any observer of what is shown before or at this place is called with the group of step n."""
    found = False
    for i in range(observers.on_steps.size):
        found = found or (observers.begin[i] <= begin and _is_due(observers, i, n, low))
    return found


@njit(**INLINE)
def show_steps(observers, x, v, step, n, low, high):
    """Call the observers with four steps of all lanes."""
    for i in range(observers.on_steps.size):
        if _is_due(observers, i, n, low):
            begin = observers.begin[i]
            _call_on_steps(
                observers.on_steps[i], (beyond(x, begin), beyond(v, begin), step, n, low, high, observers.place[i])
            )


@njit(**INLINE)
def in_window(count, speeds, squares, by_half, clear, lane, within, beyond):
    """Of the impacts of a lane at one wall those in the window: count, sum of the speeds and of their squares.

    None of a lane that is not clear.  The last half step of a group belongs to the next step: ``beyond`` tells whether
    that one is in the window, ``within`` whether the group is.
    """
    last, share = by_half[(2 * GROUP - 1) * LANES + lane], clear[lane]
    nothing, one = typed(0.0, last), typed(1.0, last)
    whole, more = share if within else nothing, nothing if within == beyond else one if beyond else -one
    return (
        whole * count[lane] + share * (more if last > nothing else nothing),
        whole * speeds[lane] + share * (more * last),
        whole * squares[lane] + share * (more * last * last),
    )


@njit(**INLINE)
def _sees(observers, i, stop):
    """Whether observer ``i`` sees the impacts on the wall of this number."""
    return observers.on_impacts[i] != 0 and (observers.stop[i] == ALL or observers.stop[i] == stop)


@njit(**INLINE)
def show_impacts(observers, stop, speeds, sums, clear, within, beyond):
    """Call the observers with the impacts of a group on a wall by half steps, of lanes that are clear; 0 is none.

    ``sums`` are those of the speeds of a lane; ``within`` and ``beyond`` are those of `in_window`.
    """
    first, end = 0 if within else 2 * GROUP - 1, 2 * GROUP if beyond else 2 * GROUP - 1
    for i in range(observers.on_impacts.size):
        for lane in range(LANES if _sees(observers, i, stop) else 0):
            if clear[lane] * sums[lane] > 0.0:
                for half in range(first, end):
                    speed = f64(speeds[half * LANES + lane])
                    if speed > 0.0:
                        _call_on_impacts(observers.on_impacts[i], (1.0, speed, lane, observers.place[i]))


@njit(**INLINE)
def show_impact(observers, stop, count, speed, lane):
    """Call the observers of all walls, and of the wall of this number, with ``count`` impacts of a lane."""
    for i in range(observers.on_impacts.size):
        if _sees(observers, i, stop):
            _call_on_impacts(observers.on_impacts[i], (count, speed, lane, observers.place[i]))


@njit(**INLINE)
def show_peak(observers, contact, force, lane):
    """Call the observers of the peaks of a contact with the largest force of one touch."""
    for i in range(observers.on_impacts.size):
        if observers.on_impacts[i] != 0 and observers.stop[i] == PEAKS - contact:
            _call_on_impacts(observers.on_impacts[i], (1.0, force, lane, observers.place[i]))


@njit(**INLINE)
def add_impacts(accumulators, stop, lane, weight, count, speed):
    """Add ``count`` impacts on a wall at one speed if they lie in the window (``weight`` 1, otherwise 0)."""
    if weight > 0.0:
        accumulators.impacts[lane] += count
        accumulators.speeds[lane] += count * speed
        accumulators.squares[lane] += count * speed * speed
        show_impact(accumulators.observers, stop, count, speed, lane)
