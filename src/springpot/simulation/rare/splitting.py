"""Adaptive multilevel splitting: repetitions of it, advanced together.

Each repetition has so many paths.  Again and again the half of them with the smallest largest coordinate is replaced by
branches of the others: each copies another path up to the first kept state above that level, and goes on from there
with noise of its own, to the end of the run.  What a replaced path had reached counts with its weight, and the weight
of those that are left is multiplied by the share that survived: so the mean over the repetitions of every probability
is right, whatever the coordinate, the number of paths, the spacing of kept states and the last level of the coordinate,
if it is fixed beforehand; an end that depends on what the paths have reached beyond their levels would favor them.
Ties are replaced together.  A repetition all of whose paths are to be replaced has died out: it keeps what it has
counted, and its zero counts.

Cerou and Guyader, "Adaptive multilevel splitting for rare event analysis", Stoch. Anal. Appl. 25, 2007; Brehier,
Gazeau, Goudenege, Lelievre and Rousset, "Unbiasedness of some generalized adaptive multilevel splitting algorithms",
Ann. Appl. Probab. 26, 2016.

Where devices differ, each repetition has devices of its own, and so many neighbouring paths begin as one device.  A
branch is of the device of its parent, so that devices that come near to the event are copied too.

The noise of a path is a function of seed, generation, number and step, and what a repetition gives depends on nothing
but its number: not on threads, nor on the repetitions beside it.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.machine.crew import work_together
from springpot.machine.progress import Clock, OutOfTimeError
from springpot.simulation.kernel.branches import MARKS, Branches, choose_parents
from springpot.simulation.kernel.native import key_words
from springpot.simulation.kernel.sizes import GROUP, LANES
from springpot.simulation.kernel.tables import by_lane
from springpot.simulation.lowering.compose import Parts
from springpot.simulation.paths.simulation import Simulation, addresses_of
from springpot.simulation.paths.together import start_of
from springpot.simulation.rare.event import Event

Numbers = npt.NDArray[np.int64]

REPLACED = 0.5  # share of the paths that is replaced in an iteration
MOST_ITERATIONS = 200
ROWS_OF_A_PATH = 64  # kept states, on average: those that wait for a branch
ROWS_OF_A_CALL = 256  # of each path, most
BLOCKS_OF_A_CALL = 16
MOST_CHECKPOINTS_PER_CYCLE = 50


@dataclass(frozen=True, eq=False)
class Tally:
    """What repetitions gave.

    Attributes
    ----------
    exceeded : ndarray, shape (repetitions, 2, levels)
        Probability of exceeding each level by half time, and by the end.
    weights : ndarray, shape (repetitions,)
        Probability of having passed the last level of the coordinate at which paths survived.
    reached : ndarray, shape (repetitions,)
        That level of the coordinate.
    iterations : ndarray of int, shape (repetitions,)
    path_steps : float
    complete : bool
        Whether all repetitions have ended by themselves.
    ends : ndarray, shape (paths, MARKS)
        The marks of plain paths.
    of_devices : ndarray, shape (devices, levels)
        What the branches of the paths of each device add to the probability by the end, in their repetition.
    of_ancestors : ndarray, shape (paths,)
        The same of each of the first paths, to that of the last level.
    """

    exceeded: Floats
    weights: Floats
    reached: Floats
    iterations: Numbers
    path_steps: float
    complete: bool
    ends: Floats
    of_devices: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    of_ancestors: Floats = field(default_factory=lambda: np.zeros(0))

    def apart(self) -> list[Tally]:
        """Each repetition of plain paths alone."""
        paths, steps = len(self.ends) // len(self.weights), self.path_steps / len(self.weights)
        return [
            Tally(self.exceeded[n], self.weights[n], self.reached[n], self.iterations[n], steps, self.complete,
                  self.ends[n.start * paths : n.stop * paths])
            for n in (slice(k, k + 1) for k in range(len(self.weights)))
        ]  # fmt: skip


@dataclass(frozen=True, eq=False)
class Population:
    """Devices of repetitions: so many neighbouring paths begin as one.

    Attributes
    ----------
    simulations : sequence of Simulation
        Of the devices, with the same settings and the same `common` numbers, in the order of the repetitions.
    constants : ndarray, shape (devices, constants)
        Of the observers of what is asked.
    weights : ndarray, shape (devices,)
        With which a device counts: its probability over that with which it was drawn.
    """

    simulations: Sequence[Simulation]
    constants: Floats
    weights: Floats

    @cached_property
    def _numbers(self) -> tuple[Floats, npt.NDArray[np.floating]]:
        tables = [each.parts.tables for each in self.simulations]
        return np.stack([each.numbers for each in tables]), np.stack([each.sweep for each in tables])

    def parts_of(self, which: Numbers) -> Parts:
        """The kernel's arguments for lanes of these devices."""
        parts = self.simulations[0].parts
        return replace(parts, tables=by_lane(parts.tables, *self._numbers, which))

    def starts(self, first: int, paths: int, stream: int) -> Floats:
        """x and v at time 0 of each of so many first paths of the devices."""
        return np.concatenate([
            start_of(each, first + n * paths, paths, stream) for n, each in enumerate(self.simulations)
        ])  # fmt: skip


def repetitions(
    simulation: Simulation,
    event: Event,
    *,
    first: int,
    count: int,
    paths: int,
    stream: int,
    splits: bool,
    clock: Clock,
    tell: Callable[[float], None],
    watch: Callable[[Tally], None] | None = None,
    population: Population | None = None,
) -> Tally:
    """So many repetitions of so many paths each, from the one with the number ``first`` on.

    Parameters
    ----------
    paths : int
        A multiple of LANES.
    stream : int
        Of the random numbers, below 65536.
    splits : bool
        Without, the paths are plain ones, and nothing is kept.
    clock : Clock
        When its time is over, the result is that of the iterations so far.
    tell : callable
        Called several times a second, with the iterations so far.
    watch : callable
        Called after each iteration with what is known by then of every level: most of those that are frequent.
    population : Population, optional
        The devices of these repetitions; without, all paths are of ``simulation``.

    Raises
    ------
    OutOfTimeError
        If the time is over before the first paths have ended.
    ValueError
        If a function of the user gives no number.
    """
    run = _Paths(simulation, event, first * paths, count * paths, stream, splits, clock, tell, population)
    size, levels = count * paths, event.levels
    devices = 1 if population is None else len(population.simulations)
    each, ancestors = size // devices, np.arange(size)
    worth = np.ones(1) if population is None else population.weights
    of_ancestors, of_devices = np.zeros(0), np.zeros((0, levels.size))
    if population is not None:
        of_ancestors, of_devices = np.zeros(size), np.zeros((devices, levels.size))
    ends = np.full((count, paths, MARKS), -np.inf)
    flat = ends.reshape(size, MARKS)
    head = run.advance(np.arange(size), np.full(size, -1), np.zeros(size, np.int64), flat, 0, ancestors)
    work = float(size) * run.steps
    weights, reached, going = np.ones(count), np.full(count, -np.inf), np.full(count, splits)
    gone, iterations = np.zeros((count, 2, levels.size)), np.zeros(count, np.int64)
    rank = int(REPLACED * paths) - 1

    def counted(which: npt.NDArray[np.bool_], weights: Floats) -> tuple[Floats, Floats, Floats]:
        """What the paths give that are marked, each with the weight of its repetition and of its device; the same by
        devices, and by the first paths.
        """
        shares, these = np.empty_like(gone), np.flatnonzero(which)
        repetition, device = these // paths, ancestors[these] // each
        own = None if population is None else weights[repetition] / paths * worth[device]
        for k in (0, 1):
            beyond = np.searchsorted(levels, flat[these, 2 - k], side="left")  # levels that each path has exceeded
            counts = _beyond_levels(repetition, beyond, own, (count, levels.size))
            shares[:, k] = counts * (weights / paths)[:, None] if own is None else counts
        if own is None:
            return shares, of_devices, of_ancestors
        last = np.where(beyond == levels.size, own, 0.0)
        return (
            shares,
            _beyond_levels(device, beyond, own, (devices, levels.size)),
            np.bincount(ancestors[these], last, size).astype(np.float64),
        )

    there = np.ones((count, paths), bool)
    branch, origin = np.empty(size, np.int64), np.empty(size, np.int64)
    living = np.empty(paths, np.int64)
    for generation in itertools.count(1):
        at = np.partition(ends[:, :, 0], rank, axis=1)[:, rank]
        going &= at < event.target
        if not going.any() or generation > MOST_ITERATIONS:
            marks, found = np.zeros((0, MARKS)) if splits else flat, counted(there, weights)
            return Tally(
                gone + found[0], weights, reached, iterations, work, True, marks, of_devices + found[1],
                of_ancestors + found[2],
            )  # fmt: skip
        before = Tally(gone, weights.copy(), reached.copy(), iterations.copy(), work, False, flat[:0])
        if watch is not None:
            watch(replace(before, exceeded=gone + counted(there, weights)[0]))
        replaced = (ends[:, :, 0] <= at[:, None]) & going[:, None]
        found = counted(replaced, weights)
        gone, of_devices, of_ancestors = gone + found[0], of_devices + found[1], of_ancestors + found[2]
        living_still = there & ~replaced
        left = np.count_nonzero(replaced, axis=1)
        iterations += going
        going &= left < paths
        there &= (left < paths)[:, None]  # the others have died out
        weights[going] *= 1.0 - left[going] / paths
        reached[going] = at[going]
        made, run.unused = choose_parents(
            ends, at, going, generation << 16 | stream, first * paths, *run.keys, head, run.kept, run.free, run.unused,
            ancestors, living, branch, origin,
        )  # fmt: skip
        # blocks of branches that are born together; of the same step in the order of the paths
        groups = run.kept.step[origin[:made]] // GROUP
        few = run.steps // GROUP < 1 << 16  # sorted by their digits
        order = np.argsort(groups.astype(np.uint16) if few else groups, kind="stable")
        of, rows = branch[:made][order], origin[:made][order]
        born, marks = GROUP * groups[order], np.empty((made, MARKS))
        try:
            head[of] = run.advance(of, rows, born, marks, generation, ancestors[of])
        except OutOfTimeError:
            return replace(before, exceeded=gone + counted(living_still, before.weights)[0])
        flat[of] = marks
        work += float((run.steps - born).sum())
    raise AssertionError


class _Paths:
    """The pool of kept states, and calls of the kernel on threads."""

    def __init__(
        self, simulation: Simulation, event: Event, first: int, paths: int, stream: int, splits: bool, clock: Clock,
        tell: Callable[[float], None], population: Population | None,
    ) -> None:  # fmt: skip
        settings, parts = simulation.settings, simulation.parts
        self.settings, self.parts, self.event, self.first, self.stream = settings, parts, event, first, stream
        self.clock, self.tell, self.steps = clock, tell, settings.steps
        self.keys, self.kernel = key_words(settings.seed), parts.kernel()
        cycle = 2.0 * np.pi / (simulation.motion.scales.frequency * settings.step)
        self.every = max(1, round(cycle / (GROUP * MOST_CHECKPOINTS_PER_CYCLE))) if splits else self.steps
        low, high = settings.window_steps
        self.most = min(-(-(high - low) // (GROUP * self.every)) + 1, ROWS_OF_A_CALL)
        calls = (settings.threads + 1) * BLOCKS_OF_A_CALL * LANES
        pool = paths * min(self.most, ROWS_OF_A_PATH) + calls * self.most if splits else 0
        self.kept = parts.room_for_states(pool)
        self.free, self.unused = np.arange(pool)[::-1].copy(), pool
        self.population = population
        if population is not None:
            self.each = paths // len(population.simulations)
            self.starts = population.starts(first, self.each, stream)
        self.lock = threading.Lock()

    def advance(
        self, paths: Numbers, rows: Numbers, born: Numbers, ends: Floats, generation: int, ancestors: Numbers
    ) -> Numbers:  # fmt: skip
        """Run paths from kept states; ``ends``, their marks, becomes those at the end.  Returns their first rows.

        ``ancestors`` are those of the first paths from which they come.
        """
        self.clock.check()
        settings, parts = self.settings, self.parts
        blocks = -(-len(paths) // LANES)
        size = blocks * LANES
        who, origin = _padded(self.first + paths, size, 0).astype(np.uint32), _padded(rows, size, -1)
        begin = _padded(born, size, self.steps)  # the last lanes are never born
        marks = np.full((size, MARKS), -np.inf)
        marks[: len(paths)] = ends
        head, stop, calls = np.full(size, -1), np.zeros(1, np.uint8), itertools.count()
        together = max(1, min(BLOCKS_OF_A_CALL, blocks // (6 * settings.threads)))
        population, of, device = self.population, _padded(ancestors, size, 0), np.zeros(size, np.int64)
        if population is None:
            states = parts.states(settings, self.first, size if generation == 0 else LANES, self.stream)
        else:
            states, device = self.starts[of], of // self.each
        word, observers = generation << 16 | self.stream, self.event.observers

        def work() -> None:
            array = np.concatenate([parts.header_of(observers[0]), observers[0].initial])
            addresses = addresses_of(observers, [array] * len(observers), parts)
            out, record = np.empty((together * LANES, len(parts.columns))), np.empty((0, 1, *parts.shape_of_state))
            while not stop[0] and (number := together * next(calls)) < blocks:
                some = slice(number * LANES, min(number + together, blocks) * LANES)
                mine, used = self._take((some.stop - some.start) * self.most), np.zeros(2, np.int64)
                kernel, constants = self.kernel, np.zeros((0, 0))
                if population is not None:
                    kernel, constants = population.parts_of(device[some]).kernel(), population.constants[device[some]]
                branches = Branches(
                    self.every, self.event.floor, self.event.spacing, who[some], origin[some], begin[some],
                    array[self.event.marks], constants, array[self.event.constants], marks[some], head[some], mine,
                    used, self.kept,
                )  # fmt: skip
                kernel(
                    states[some] if len(states) > LANES else states, 0, (some.stop - some.start) // LANES, settings,
                    *self.keys, word, False, addresses, record, stop, out, branches,
                )  # fmt: skip
                self._give_back(mine[used[0] :])
                if used[1] > 0:
                    raise MemoryError("too many states of paths had to be kept: use a shorter duration.")

        def tell() -> None:
            self.clock.check()
            self.tell(generation)

        work_together(work, min(settings.threads, -(-blocks // together)), stop=partial(stop.fill, 1), tell=tell)
        if np.isnan(marks).any():
            raise ValueError(f"levels: {self.event.name} gives no number at some place that the motion comes to.")
        ends[:] = marks[: len(paths)]
        return head[: len(paths)]

    def _take(self, rows: int) -> Numbers:
        with self.lock:
            taken = min(rows, self.unused)
            self.unused -= taken
            return self.free[self.unused : self.unused + taken][::-1].copy()

    def _give_back(self, rows: Numbers) -> None:
        with self.lock:
            self.free[self.unused : self.unused + rows.size] = rows[::-1]
            self.unused += rows.size


def _beyond_levels(of: Numbers, beyond: Numbers, weights: Floats | None, shape: tuple[int, int]) -> Floats:
    """How many paths, or how much of their weights, of each repetition or device exceed each level."""
    many, levels = shape
    counts = np.bincount(of * (levels + 1) + beyond, weights, many * (levels + 1)).reshape(many, -1)
    return np.asarray(counts[:, ::-1].cumsum(axis=1)[:, ::-1][:, 1:])


def _padded(numbers: Numbers, size: int, filling: int) -> Numbers:
    return np.concatenate([numbers, np.full(size - numbers.size, filling)])
