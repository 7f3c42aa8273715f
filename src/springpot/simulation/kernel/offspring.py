"""Branches of paths, for splitting: a block starts lanes from kept states, and keeps states of its own.

A lane that is not born yet runs on idle, from the start of a run; when the block comes to the step of its birth, the
kept state is put in its place.  An observer keeps MARKS running maxima of each lane; whenever the first of them, the
coordinate, has risen, the state is kept with them at the next checkpoint.  The kept states of a path are a list, from
its birth on, linked by their rows in one pool.  What a path does depends on its number, its generation and its origin
only, never on the lanes beside it.

The kernel has a table of integers and addresses, whose first number is 0 for a plain run.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from springpot.simulation.kernel.branches import MARKS, Branches
from springpot.simulation.kernel.calling import doubles, integers, pointer_like, words
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED
from springpot.simulation.kernel.tables import MODES, POINTS, ROWS, STATES

TABLE = (
    "any", "every", "limits", "who", "origin", "born", "marks", "ends", "head", "free", "rows", "used", "state", "memory",
    "sources", "step", "next", "kept",
)  # fmt: skip
"""Whether there are branches; groups between two checkpoints; the address of floor and rise of the coordinate; those of
the arrays of `springpot.simulation.kernel.branches.Branches`; how many rows are free; those of the pool; and how many
states of sources it keeps.
"""
(ANY, EVERY, EDGES, WHO, ORIGIN, BORN, NOW_MARKS, ENDS, HEAD, FREE, FREE_ROWS, USED, KEPT_STATE, KEPT_MEMORY, KEPT_SOURCES,
 KEPT_STEP, KEPT_NEXT, KEPT_COUNT) = range(len(TABLE))  # fmt: skip


def table_of(branches: Any) -> tuple[Any, ...]:
    """The table of branches and what must live as long as it is used."""
    if not isinstance(branches, Branches):
        return (np.zeros(len(TABLE), np.int64),)
    edges, kept = np.array([branches.floor, branches.rise]), branches.kept
    arrays = (
        edges, branches.who, branches.origin, branches.born, branches.marks, branches.ends, branches.head, branches.free,
    )  # fmt: skip
    pool = branches.used, kept.state, kept.memory, kept.sources, kept.step, kept.next
    addresses = [array.ctypes.data for array in (*arrays, *pool)]
    table = [1, branches.every, *addresses[:8], branches.free.size, *addresses[8:], kept.sources.shape[1]]
    return np.array(table, np.int64), arrays, pool


@njit(**LINKED)
def open_branches(B, row, who, risen, last):
    """The numbers of the paths of a block and their marks; its first step."""
    marks, ends, names, floor = doubles(B[NOW_MARKS]), doubles(B[ENDS]), words(B[WHO]), doubles(B[EDGES])[0]
    for lane in range(LANES):
        who[lane] = names[row + lane]
        for k in range(MARKS):
            marks[k * LANES + lane] = ends[(row + lane) * MARKS + k]
        risen[lane], last[lane] = floor, -1.0
    return integers(B[BORN])[row]


@njit(**LINKED)
def close_branches(B, row):
    """Write the marks at the end of a block."""
    marks, ends = doubles(B[NOW_MARKS]), doubles(B[ENDS])
    for lane in range(LANES):
        for k in range(MARKS):
            ends[(row + lane) * MARKS + k] = marks[k * LANES + lane]


@njit(**LINKED)
def bear(I, B, T, n, births, row, steps, risen, last):
    """Lanes that are born at step n take their kept states; returns the next step of births."""
    points, rows, modes, kept, soonest = I[POINTS], I[ROWS], I[MODES], B[KEPT_COUNT], steps
    state, marks, origin = doubles(B[KEPT_STATE]), doubles(B[NOW_MARKS]), integers(B[ORIGIN])
    memory, sources = pointer_like(B[KEPT_MEMORY], T.z), pointer_like(B[KEPT_SOURCES], T.state)
    for lane in range(LANES):
        i, born = origin[row + lane], integers(B[BORN])[row + lane]
        if n < born < soonest:
            soonest = born
        if born == n and i >= 0:
            at, of_memory = i * (2 * points + MARKS), i * ((2 + GROUP) * rows + modes)
            for p in range(points):
                T.now_x[p * LANES + lane], T.now_v[p * LANES + lane] = state[at + 2 * p], state[at + 2 * p + 1]
            for k in range(MARKS):
                marks[k * LANES + lane] = state[at + 2 * points + k]
            for e in range(rows):
                for k in range(2):
                    T.d[((GROUP + 2) * e + k) * LANES + lane] = memory[of_memory + 2 * e + k]
            for j in range(GROUP * rows):
                T.h[j * LANES + lane] = memory[of_memory + 2 * rows + j]
            for k in range(modes):
                T.z[k * LANES + lane] = memory[of_memory + (2 + GROUP) * rows + k]
            for k in range(kept):
                T.state[k * LANES + lane] = sources[i * kept + k]
            risen[lane] = -1e300
    keep(I, B, T, n, True, row, steps, risen, last)
    return soonest


@njit(**LINKED)
def keep(I, B, T, n, at_birth, row, steps, risen, last):
    """Keep the states of lanes whose coordinate has risen: of those born at step n, or sooner.

    A lane that is born at step n has run idle until now: what it holds at the end of the group before is nobody's.  A
    branch keeps the state of its birth as its own, so that parents and children share no rows.
    """
    if not at_birth and (n // GROUP % B[EVERY] != 0 or n >= steps):
        return
    points, rows, modes, kept, rise = I[POINTS], I[ROWS], I[MODES], B[KEPT_COUNT], doubles(B[EDGES])[1]
    state, marks, used = doubles(B[KEPT_STATE]), doubles(B[NOW_MARKS]), integers(B[USED])
    memory, sources = pointer_like(B[KEPT_MEMORY], T.z), pointer_like(B[KEPT_SOURCES], T.state)
    following = integers(B[KEPT_NEXT])
    for lane in range(LANES):
        born = integers(B[BORN])[row + lane]
        if marks[lane] > risen[lane] and (born == n if at_birth else born < n):
            if used[0] == B[FREE_ROWS]:
                used[1] += 1
                continue
            risen[lane] = marks[lane] + rise
            i = integers(B[FREE])[used[0]]
            used[0] += 1
            at, of_memory = i * (2 * points + MARKS), i * ((2 + GROUP) * rows + modes)
            for p in range(points):
                state[at + 2 * p], state[at + 2 * p + 1] = T.now_x[p * LANES + lane], T.now_v[p * LANES + lane]
            for k in range(MARKS):
                state[at + 2 * points + k] = marks[k * LANES + lane]
            for e in range(rows):
                for k in range(2):
                    memory[of_memory + 2 * e + k] = T.d[((GROUP + 2) * e + k) * LANES + lane]
            for j in range(GROUP * rows):
                memory[of_memory + 2 * rows + j] = T.h[j * LANES + lane]
            for k in range(modes):
                memory[of_memory + (2 + GROUP) * rows + k] = T.z[k * LANES + lane]
            for k in range(kept):
                sources[i * kept + k] = T.state[k * LANES + lane]
            integers(B[KEPT_STEP])[i], following[i] = n, -1
            if last[lane] < 0.0:
                integers(B[HEAD])[row + lane] = i
            else:
                following[int(last[lane])] = i
            last[lane] = i
