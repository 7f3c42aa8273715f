"""Branches of paths, for splitting: a block starts lanes from kept states, and keeps states of its own.

A lane that is not born yet runs on idle, from the start of a run; when the block comes to the step of its birth, the
kept state is put in its place.  An observer keeps MARKS running maxima of each lane; whenever the first of them, the
coordinate, has risen, the state is kept with them at the next checkpoint.  The kept states of a path are a list, from
its birth on, linked by their rows in one pool.  What a path does depends on its number, its generation and its origin
only, never on the lanes beside it.

The kernel has a table of integers and addresses, whose first number is 0 for a plain run.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.cache import cached
from springpot.simulation.kernel.lanes import ENTRY, GROUP, LANES, LINKED, u32, yes
from springpot.simulation.kernel.random import philox
from springpot.simulation.kernel.tables import MODES, POINTS, ROWS
from springpot.simulation.kernel.vectors import doubles, integers, pointer_like, words

Numbers = npt.NDArray[np.int64]

MARKS = 3  # largest coordinate so far, largest asked quantity, and the same until half time
_PARENTS = 0x20000000  # counter word of the numbers that choose parents


class Kept(NamedTuple):
    """Kept states, one in a row: the pool that all calls share."""

    state: Floats  # x and v of each coordinate, and the marks
    memory: npt.NDArray[np.floating]  # of each row the two newest increments and its force in four steps; the modes
    sources: npt.NDArray[np.floating]  # states of the forces
    step: Numbers
    next: Numbers  # the next row of the same path, or -1


class Branches(NamedTuple):
    """What a call does beside advancing paths: of each path where it starts and what is kept of it."""

    every: int  # groups between two checkpoints
    floor: float  # of the coordinate, above which states are kept of the first paths
    rise: float  # of the coordinate, from one kept state to the next
    who: npt.NDArray[np.uint32]  # numbers of the paths
    origin: Numbers  # row of the kept state to start from, or -1: from the start of a run
    born: Numbers  # the step of that state; not sooner than that of the path before it in the block
    marks: Floats  # of the present block, as the observer has them: (MARKS * LANES,)
    constants: Floats  # of the observer for each path: (paths, count); none where all paths have the same
    now: Floats  # those of the present block, as the observer has them: (count * LANES,)
    ends: Floats  # (paths, MARKS) at the start of a run; they become those at the end
    head: Numbers  # the first row of each path, or -1
    free: Numbers  # rows of the pool that this call may use
    used: Numbers  # (2,) how many of them it has used, and how many states found no row
    kept: Kept


TABLE = (
    "any", "every", "limits", "who", "origin", "born", "marks", "constants", "now", "ends", "head", "free", "rows",
    "used", "state", "memory", "sources", "step", "next", "kept", "many",
)  # fmt: skip
"""Whether there are branches; groups between two checkpoints; the address of floor and rise of the coordinate; those
of the arrays of `Branches`; how many rows are free; those of the pool; how many states of sources it keeps; and how
many constants a path has.
"""
(ANY, EVERY, EDGES, WHO, ORIGIN, BORN, NOW_MARKS, CONSTANTS, NOW_CONSTANTS, ENDS, HEAD, FREE, FREE_ROWS, USED,
 KEPT_STATE, KEPT_MEMORY, KEPT_SOURCES, KEPT_STEP, KEPT_NEXT, KEPT_COUNT, MANY) = range(len(TABLE))  # fmt: skip


def table_of(branches: Branches | None = None) -> tuple[Any, ...]:
    """The table of branches, or of a plain run, and what must live as long as it is used."""
    if branches is None:
        return (np.zeros(len(TABLE), np.int64),)
    edges, kept = np.array([branches.floor, branches.rise]), branches.kept
    arrays = (
        edges, branches.who, branches.origin, branches.born, branches.marks, branches.constants, branches.now,
        branches.ends, branches.head, branches.free,
    )  # fmt: skip
    pool = branches.used, kept.state, kept.memory, kept.sources, kept.step, kept.next
    addresses = [array.ctypes.data for array in (*arrays, *pool)]
    counts = kept.sources.shape[1], branches.constants.shape[1]
    table = [1, branches.every, *addresses[:10], branches.free.size, *addresses[10:], *counts]
    return np.array(table, np.int64), arrays, pool


@njit(**LINKED)
def open_branches(B, row, who, risen, last):
    """The numbers of the paths of a block, their marks and their constants; its first step."""
    constants, now, many = doubles(B[CONSTANTS]), doubles(B[NOW_CONSTANTS]), B[MANY]
    marks, ends, names, floor = doubles(B[NOW_MARKS]), doubles(B[ENDS]), words(B[WHO]), doubles(B[EDGES])[0]
    for lane in range(LANES):
        who[lane] = names[row + lane]
        for k in range(MARKS):
            marks[k * LANES + lane] = ends[(row + lane) * MARKS + k]
        for k in range(many):
            now[k * LANES + lane] = constants[(row + lane) * many + k]
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
def bear(K, B, T, n, births, row, steps, risen, last):
    """Lanes that are born at step n take their kept states; returns the next step of births."""
    points, rows, modes, kept, soonest = K[POINTS], K[ROWS], K[MODES], B[KEPT_COUNT], steps
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
    keep(K, B, T, n, yes(), row, steps, risen, last)
    return soonest


@njit(**LINKED)
def keep(K, B, T, n, at_birth, row, steps, risen, last):
    """Keep the states of lanes whose coordinate has risen: of those born at step n, or sooner.

    A lane that is born at step n has run idle until now: what it holds at the end of the group before is nobody's.  A
    branch keeps the state of its birth as its own, so that parents and children share no rows.
    """
    if not at_birth and (n // GROUP % B[EVERY] != 0 or n >= steps):
        return
    points, rows, modes, kept, rise = K[POINTS], K[ROWS], K[MODES], B[KEPT_COUNT], doubles(B[EDGES])[1]
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


@cached
@njit(**ENTRY)
def choose_parents(
    ends, levels, splits, generation, first, k0, k1, head, kept, free, count, ancestors, living, branch, origin
):  # fmt: skip
    """Replace the paths at or below the level of their repetition by branches of the others.

    Parameters
    ----------
    ends : ndarray, shape (repetitions, paths, MARKS)
        A replaced path whose parent has no state above the level becomes a copy of it, in place.
    levels : ndarray
        Of the coordinate, for each repetition.
    splits : ndarray of bool
        Which repetitions go on.
    generation : int
        Of the branches.
    first : int
        Number of the first path, of the parents' random numbers.
    head, kept, free : ndarray of int, Kept, ndarray of int
        Rows that no branch can need any more are put among the ``count`` free ones.
    ancestors : ndarray of int
        From which of the first paths each comes; a branch comes from where its parent does.
    living : ndarray of int
        Room for the numbers of the paths of a repetition.

    Written: ``branch`` and ``origin``, the paths to run and the rows of the states where they begin.  Returns how many
    there are, and how many rows are free.
    """
    repetitions, paths, _ = ends.shape
    made, coordinate = 0, kept.state.shape[1] - MARKS
    for r in range(repetitions):
        if not splits[r]:
            continue
        z, alive = levels[r], 0
        for s in range(paths):
            above = ends[r, s, 0] > z
            if above:
                living[alive] = s
                alive += 1
            i = head[r * paths + s]
            while i >= 0 and (not above or kept.state[i, coordinate] <= z):
                free[count] = i
                count += 1
                i = kept.next[i]
            head[r * paths + s] = i
        if alive == 0:
            continue
        for s in range(paths):
            if ends[r, s, 0] > z:
                continue
            place = r * paths + s
            word, _, _, _ = philox(u32(0), u32(first + place), u32(generation), u32(_PARENTS), k0, k1)
            parent = living[(np.int64(word) * alive) >> 32]
            i = head[r * paths + parent]
            ancestors[place] = ancestors[r * paths + parent]
            branch[made], origin[made] = place, i if i >= 0 else -1 - (r * paths + parent)
            made += 1
    # copies last: until here the paths above the level are those that lived
    left = 0
    for b in range(made):
        if origin[b] >= 0:
            branch[left], origin[left] = branch[b], origin[b]
            left += 1
        else:
            place, parent = branch[b], -1 - origin[b]
            for k in range(ends.shape[2]):
                ends[place // paths, place % paths, k] = ends[parent // paths, parent % paths, k]
    return left, count
