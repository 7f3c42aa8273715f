"""Branches of paths, for splitting: a block starts lanes from kept states, and keeps states of its own.

What a call of the kernel does with branches is asked with the functions below; the *type* of ``branches`` chooses the
code when it is compiled.  Of `NoBranches` every answer is nothing, so that a plain run has none of this in its kernel.

A lane that is not born yet runs on idle, from the start of a run; when the block comes to the step of its birth, the
kept state is put in its place.  An observer keeps MARKS running maxima of each lane; whenever the first of them, the
coordinate, has risen, the state is kept with them at the next checkpoint.  The kept states of a path are a list, from
its birth on, linked by their rows in one pool.  What a path does depends on its number, its generation and its origin
only, never on the lanes beside it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.cache import cached
from springpot.simulation.kernel.lanes import ENTRY, GROUP, LANES, no, u32, yes
from springpot.simulation.kernel.questions import answers
from springpot.simulation.kernel.random import number_lanes, philox

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
    ends: Floats  # (paths, MARKS) at the start of a run; they become those at the end
    head: Numbers  # the first row of each path, or -1
    free: Numbers  # rows of the pool that this call may use
    used: Numbers  # (2,) how many of them it has used, and how many states found no row
    kept: Kept


class NoBranches(NamedTuple):
    """A plain run."""

    every: int


NO_BRANCHES = NoBranches(0)


def name_paths(branches: Any, first: Any, row: Any, who: Any) -> Any:
    """Compiled code only: the numbers of the paths of a block; ``row`` is that of its first path in the call."""
    raise NotImplementedError


def opened(branches: Any, row: Any, lanes: Any) -> Any:
    """Compiled code only: the first step of a block, whose marks are set."""
    raise NotImplementedError


def closed(branches: Any, row: Any) -> Any:
    """Compiled code only: the marks at the end of a block are written."""
    raise NotImplementedError


def may_be_crowded(branches: Any) -> Any:
    """Compiled code only: whether the lanes beside a path may decide how its impacts are found, and so its bits."""
    raise NotImplementedError


def birth(branches: Any, n: Any, births: Any, row: Any, steps: Any, lanes: Any) -> Any:
    """Compiled code only: lanes that are born at step n take their kept states; returns the next step of births."""
    raise NotImplementedError


def keep(branches: Any, n: Any, at_birth: Any, row: Any, steps: Any, lanes: Any) -> Any:
    """Compiled code only: keep the states of lanes whose coordinate has risen: of those born at step n, or sooner."""
    raise NotImplementedError


@answers(name_paths, NoBranches)
def _name_plain(branches, first, row, who):
    number_lanes(first + row, who)


@answers(opened, NoBranches)
def _open_plain(branches, row, lanes):
    return 0


@answers(closed, NoBranches)
def _close_plain(branches, row):
    pass


@answers(may_be_crowded, NoBranches)
def _may_be_crowded(branches):
    return yes()


@answers(birth, NoBranches)
def _no_birth(branches, n, births, row, steps, lanes):
    return births


@answers(keep, NoBranches)
def _keep_nothing(branches, n, at_birth, row, steps, lanes):
    pass


@answers(name_paths, Branches)
def _name_branches(branches, first, row, who):
    for lane in range(LANES):
        who[lane] = branches.who[row + lane]


@answers(opened, Branches)
def _open_branches(branches, row, lanes):
    risen, last = lanes[-2], lanes[-1]
    for lane in range(LANES):
        for k in range(MARKS):
            branches.marks[k * LANES + lane] = branches.ends[row + lane, k]
        risen[lane], last[lane] = branches.floor, -1.0
    return branches.born[row]


@answers(closed, Branches)
def _close_branches(branches, row):
    for lane in range(LANES):
        for k in range(MARKS):
            branches.ends[row + lane, k] = branches.marks[k * LANES + lane]


@answers(may_be_crowded, Branches)
def _never_crowded(branches):
    return no()


@answers(birth, Branches)
def _birth(branches, n, births, row, steps, lanes):
    if n != births:
        return births
    points, rows, now, begun, d, h, z, modes, forcing, risen, _ = lanes
    kept, soonest = branches.kept, steps
    for lane in range(LANES):
        i, born = branches.origin[row + lane], branches.born[row + lane]
        if n < born < soonest:
            soonest = born
        if born == n and i >= 0:
            for p in range(points):
                at = p * LANES + lane
                now.x[at], now.v[at] = kept.state[i, 2 * p], kept.state[i, 2 * p + 1]
                begun.x[at], begun.v[at] = now.x[at], now.v[at]
            for k in range(MARKS):
                branches.marks[k * LANES + lane] = kept.state[i, 2 * points + k]
            for e in range(rows):
                for k in range(2):
                    d[((GROUP + 2) * e + k) * LANES + lane] = kept.memory[i, 2 * e + k]
            for j in range(GROUP * rows):
                h[j * LANES + lane] = kept.memory[i, 2 * rows + j]
            for k in range(modes):
                z[k * LANES + lane] = kept.memory[i, (2 + GROUP) * rows + k]
            for k in range(kept.sources.shape[1]):
                forcing.state[k * LANES + lane] = kept.sources[i, k]
            risen[lane] = -np.inf
    keep(branches, n, yes(), row, steps, lanes)
    return soonest


@answers(keep, Branches)
def _keep(branches, n, at_birth, row, steps, lanes):
    """A lane that is born at step n has run idle until now: what it holds at the end of the group before is nobody's.

    A branch keeps the state of its birth as its own, so that parents and children share no rows.
    """
    if not at_birth and (n // GROUP % branches.every != 0 or n >= steps):
        return
    points, rows, now, _, d, h, z, modes, forcing, risen, last = lanes
    kept, marks = branches.kept, branches.marks
    for lane in range(LANES):
        born = branches.born[row + lane]
        if marks[lane] > risen[lane] and (born == n if at_birth else born < n):
            if branches.used[0] == branches.free.size:
                branches.used[1] += 1
                continue
            risen[lane] = marks[lane] + branches.rise
            i = branches.free[branches.used[0]]
            branches.used[0] += 1
            for p in range(points):
                kept.state[i, 2 * p], kept.state[i, 2 * p + 1] = now.x[p * LANES + lane], now.v[p * LANES + lane]
            for k in range(MARKS):
                kept.state[i, 2 * points + k] = marks[k * LANES + lane]
            for e in range(rows):
                for k in range(2):
                    kept.memory[i, 2 * e + k] = d[((GROUP + 2) * e + k) * LANES + lane]
            for j in range(GROUP * rows):
                kept.memory[i, 2 * rows + j] = h[j * LANES + lane]
            for k in range(modes):
                kept.memory[i, (2 + GROUP) * rows + k] = z[k * LANES + lane]
            for k in range(kept.sources.shape[1]):
                kept.sources[i, k] = forcing.state[k * LANES + lane]
            kept.step[i], kept.next[i] = n, -1
            if last[lane] < 0.0:
                branches.head[row + lane] = i
            else:
                kept.next[np.int64(last[lane])] = i
            last[lane] = i


@cached
@njit(**ENTRY)
def choose_parents(ends, levels, splits, generation, first, k0, k1, head, kept, free, count, living, branch, origin):
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
