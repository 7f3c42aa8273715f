"""Observers of a block of paths: called through addresses, so that a new observer needs no new kernel.

An observer is compiled separately.  The kernel has two addresses of it (either may be missing): one is called with
every group of four steps of all lanes, one with every impact.  It accumulates in an array of doubles, one for each
block, that starts with a header (:data:`HEADER`) for the conversion of the kernel's units to the user's.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
import numpy.typing as npt
from numba import njit, types

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.lanes import GROUP, INLINE, WIDTH, beyond, f64
from springpot.simulation.kernel.vectors import calling, choose, double, store

BATCHES = 64  # groups of paths with separate counts, for standard errors
ALL, PEAKS = -1, -2  # walls; less its number, the largest forces of a contact

HEADER = ("length", "speed", "time", "frequency", "wall", "lanes")
"""First numbers of an observer's array: x, v and t of the kernel times the first three are x, v and t of the user.

``frequency`` is that of the circle on which one mass turns (1 without) and ``wall`` the position of a lone wall (0
without one), both in the kernel's units; only the first ``lanes`` lanes are paths of the run.  Of a force or an
acceleration, which has the place of x, ``frequency`` is what brings it near 1, and ``wall`` twice the root of what its
mean square lacks.
"""

_numbers = types.CPointer(types.float64)
ON_STEPS = types.void(_numbers, _numbers, types.float64, types.int64, types.int64, types.int64, _numbers)
"""(x, v, step, n, low, high, array): x[j * LANES + lane] at the end of step n + j, of which low .. high - 1 count.

x and v are those of the displacement that the observer is ``of``, and after them, GROUP * LANES numbers each, those of
the next ones: of the coordinates, then of all rows.  Beyond the displacements v is of the whole group: the power of
dampers and memory summed over its steps, then the work of each named force, LANES numbers each.
"""
ON_IMPACTS = types.void(types.float64, types.float64, types.int64, _numbers)
"""(count, speed, lane, array): ``count`` impacts at this speed."""


TABLE = (
    "observers", "on_steps", "on_impacts", "outputs_count", "outputs", "output_begin", "output_row", "numbers",
    "record", "points",
)  # fmt: skip
"""The table of observers in the kernel: how many there are, and how many of them see steps and impacts; how many
outputs are seen; where in the table their numbers stand, where the terms of each begin, and the row of each term; and
the addresses of the numbers of the terms and of the record, with its points in time.  Then come OF_ONE
integers of each observer: the two addresses (0: not called), that of its array, the groups between two calls, where in
the arrays of x and v it looks, and the number of its wall, ALL, or PEAKS less the number of a contact.
"""
(COUNT, ON_STEPS_COUNT, ON_IMPACTS_COUNT, OUTPUTS_COUNT, OUTPUTS, OUTPUT_BEGIN, OUTPUT_ROW, OUTPUT_NUMBERS, RECORD,
 RECORD_POINTS) = range(len(TABLE))  # fmt: skip
AFTER = len(TABLE)
OF_ONE = 6


def table_of(
    observers: Sequence[Sequence[int]], outputs: Sequence[int], begins: Sequence[int], rows: Sequence[int],
    numbers: Floats, record: Floats,
) -> npt.NDArray[np.int64]:  # fmt: skip
    """The table of some observers, whose arrays must live as long as it is used.

    Parameters
    ----------
    observers : sequence
        OF_ONE integers of each.
    outputs : sequence of int
        The numbers of the forces and accelerations that are seen, which `springpot.simulation.kernel.outputs` makes.
    begins, rows : sequence of int
        Where the terms of each force begin, and the row of each term.
    numbers : ndarray, shape (terms, NUMBERS)
    record : ndarray, shape (paths, points in time, seen)
        Of the first paths, at the kicks before those points.
    """
    first = AFTER + OF_ONE * len(observers)
    begin = first + len(outputs)
    on_steps, on_impacts = (sum(own[which] != 0 for own in observers) for which in (0, 1))
    header = [
        len(observers), on_steps, on_impacts, len(outputs), first, begin, begin + len(begins),
        numbers.ctypes.data, record.ctypes.data, record.shape[1],
    ]  # fmt: skip
    return np.array([*header, *chain.from_iterable(observers), *outputs, *begins, *rows], np.int64)


_call_on_steps, _call_on_impacts = calling(ON_STEPS, True), calling(ON_IMPACTS, True)


@njit(**INLINE)
def show_steps(S, x, v, step, n, low, high):
    """Call the observers with four steps of all lanes; the first group is that in which the window begins."""
    for i in range(S[COUNT]):
        b = AFTER + OF_ONE * i
        if S[b] != 0 and (n // GROUP - low // GROUP) % S[b + 3] == 0:
            _call_on_steps(S[b], (beyond(x, S[b + 4]), beyond(v, S[b + 4]), step, n, low, high, S[b + 2]))


@njit(**INLINE)
def show_impact(S, stop, speed, lane, count=1.0):
    """Call the observers of all walls, and of the wall of this number, with impacts of a lane that are alike."""
    for i in range(S[COUNT]):
        b = AFTER + OF_ONE * i
        if S[b + 1] != 0 and (S[b + 5] == ALL or S[b + 5] == stop):
            _call_on_impacts(S[b + 1], (f64(count), speed, lane, S[b + 2]))


@njit(**INLINE)
def show_impacts(S, stop, where, speeds, o, room):
    """The same with impacts of some lanes of a vector."""
    if S[ON_IMPACTS_COUNT] > 0:
        store(room, 0, choose(where, double(speeds), -1.0))
        for lane in range(WIDTH):
            if room[lane] >= 0.0:
                show_impact(S, stop, f64(room[lane]), o + lane)


@njit(**INLINE)
def show_peaks(S, contact, where, forces, o, room):
    """Call the observers of the peaks of a contact with the largest forces of touches that end."""
    store(room, 0, choose(where, forces, -1.0))
    for lane in range(WIDTH):
        for i in range(S[COUNT] if room[lane] > 0.0 else 0):
            b = AFTER + OF_ONE * i
            if S[b + 1] != 0 and S[b + 5] == PEAKS - contact:
                _call_on_impacts(S[b + 1], (1.0, f64(room[lane]), o + lane, S[b + 2]))
