"""Observers in the kernel: a table of addresses, which are called with groups of steps, with impacts and with peaks.

The table begins with a header, then come six integers of each observer: the two addresses (0: not called), that of its
array, the groups between two calls, where in the arrays of x and v it looks, and the number of its wall, ALL, or PEAKS
less the number of a contact.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.simulation.kernel.calling import calling
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, WIDTH, beyond, f64
from springpot.simulation.kernel.vectors import choose, double, store
from springpot.simulation.kernel.watching import ALL, ON_IMPACTS, ON_STEPS, PEAKS, Observers

HEADER = "observers", "on_steps", "on_impacts", "feels", "felt", "felt_begin", "felt_row", "numbers", "record", "points"
"""How many there are, and how many of them see steps and impacts; how many forces and accelerations are felt; where in
the table their numbers stand, where the terms of each begin, and the row of each term; and the addresses of the numbers
of the terms and of the record, with its points in time.
"""
(COUNT, ON_STEPS_COUNT, ON_IMPACTS_COUNT, FEELS, FELT, FELT_BEGIN, FELT_ROW, NUMBERS_OF_FELT, RECORD,
 RECORD_POINTS) = range(len(HEADER))  # fmt: skip
AFTER = len(HEADER)
OF_ONE = 6



def table_of(observers: Observers) -> npt.NDArray[np.int64]:
    """The table of some observers, whose arrays must live as long as it is used."""
    each = np.array([
        observers.on_steps, observers.on_impacts, observers.place, observers.every, observers.begin, observers.stop,
    ]).T  # fmt: skip
    felt, begins = AFTER + each.size, AFTER + each.size + observers.feels.size
    header = [
        len(each), np.count_nonzero(each[:, 0]), np.count_nonzero(each[:, 1]), observers.feels.size, felt, begins,
        begins + observers.felt_begin.size, observers.felt.ctypes.data, observers.record.ctypes.data,
        observers.record.shape[1],
    ]  # fmt: skip
    return np.concatenate([header, each.ravel(), observers.feels, observers.felt_begin, observers.felt_row]).astype(np.int64)


_call_on_steps, _call_on_impacts = calling(ON_STEPS, True), calling(ON_IMPACTS, True)


@njit(**INLINE)
def show_steps(O, x, v, step, n, low, high):
    """Call the observers with four steps of all lanes; the first group is that in which the window begins."""
    for i in range(O[COUNT]):
        b = AFTER + OF_ONE * i
        if O[b] != 0 and (n // GROUP - low // GROUP) % O[b + 3] == 0:
            _call_on_steps(O[b], (beyond(x, O[b + 4]), beyond(v, O[b + 4]), step, n, low, high, O[b + 2]))


@njit(**INLINE)
def show_impact(O, stop, speed, lane):
    """Call the observers of all walls, and of the wall of this number, with an impact of a lane."""
    for i in range(O[COUNT]):
        b = AFTER + OF_ONE * i
        if O[b + 1] != 0 and (O[b + 5] == ALL or O[b + 5] == stop):
            _call_on_impacts(O[b + 1], (1.0, speed, lane, O[b + 2]))


@njit(**INLINE)
def show_impacts(O, stop, where, speeds, o, room):
    """The same with impacts of some lanes of a vector."""
    if O[ON_IMPACTS_COUNT] > 0:
        store(room, 0, choose(where, double(speeds), -1.0))
        for lane in range(WIDTH):
            if room[lane] >= 0.0:
                show_impact(O, stop, f64(room[lane]), o + lane)


@njit(**INLINE)
def show_peaks(O, contact, where, forces, o, room):
    """Call the observers of the peaks of a contact with the largest forces of touches that end."""
    store(room, 0, choose(where, forces, -1.0))
    for lane in range(WIDTH):
        for i in range(O[COUNT] if room[lane] > 0.0 else 0):
            b = AFTER + OF_ONE * i
            if O[b + 1] != 0 and O[b + 5] == PEAKS - contact:
                _call_on_impacts(O[b + 1], (1.0, f64(room[lane]), o + lane, O[b + 2]))
