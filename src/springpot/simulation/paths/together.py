"""Several simulations at once: those of one structure share the calls of the kernel, and all share the threads.

A system of few paths has few blocks, so that alone it keeps few threads busy.  In a call of several systems each has
blocks with numbers of its own in the kernel's tables.  Its paths have the numbers and so the bits that it has alone.

Many devices of few paths share blocks, in which each lane has numbers of its own.  A path-step takes half as long again
then, but no lane is empty.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.machine.crew import work_together
from springpot.simulation.kernel.native import key_words
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.kernel.tables import Tables, common, side_by_side, stacked
from springpot.simulation.paths.simulation import Ensemble, Progress, Simulation, addresses_of, blocks_of_a_call

_MOST_BY_LANE = 100_000  # numbers of a system, each of which stands LANES times in the tables of a block


def advance_together(simulations: Sequence[Simulation], progress: Progress | None = None) -> list[Ensemble]:
    """As `Simulation.advance` of each, without a record and observers, with the same bits.

    They may have any structure and settings, but the number of threads.
    """
    rooms = [np.empty((_blocks(each) * LANES, len(each.parts.columns))) for each in simulations]
    whole = sum(map(_path_steps, simulations))

    def do(call: _Call, stop: npt.NDArray[np.uint8]) -> float:
        own = [simulations[member] for member in call.members]
        first, count = call.begin * LANES, call.blocks * LANES
        tables = stacked([each.parts.tables for each in own], call.blocks)
        rows = _rows(own[0], tables, [start_of(each, first, count) for each in own], first, stop)
        for member, found in zip(call.members, rows.reshape(len(own), count, -1), strict=True):
            rooms[member][first : first + count] = found
        return sum(_path_steps(each) * call.blocks / _blocks(each) for each in own) / whole

    if simulations:
        _on_threads(list(_calls(simulations)), do, simulations[0].settings.threads, progress)
    return [_ensemble(each, rows) for each, rows in zip(simulations, rooms, strict=True)]


def advance_devices(simulations: Sequence[Simulation], progress: Progress | None = None) -> list[Ensemble]:
    """As `advance_together`, each system as one of many devices: no two paths have the same random numbers.

    All have the same settings.  Of fewer paths than a block has, neighbouring devices share one: then they must have
    the `common` numbers.
    """
    one, paths = simulations[0], simulations[0].settings.paths
    whole = paths % LANES == 0
    if whole:
        is_shared = len({_structure(each) for each in simulations}) == 1
    elif not (is_shared := alike([each.parts.tables for each in simulations])):
        raise ValueError(
            f"paths must be {LANES} or a multiple of it, not {paths}: the devices differ in a rate of their memory, in "
            "an exponent, in a function, such as a law of restitution, or in which parts act, so that they cannot "
            "share blocks of paths."
        )
    room = np.empty((len(simulations), paths, len(one.parts.columns)))
    steps, blocks = max(LANES // paths, 1), len(simulations) * paths // LANES
    size = steps * max(1, blocks_of_a_call(one.settings, blocks) * LANES // max(paths, LANES)) if is_shared else 1

    def do(begin: int, stop: npt.NDArray[np.uint8]) -> float:
        own, first = simulations[begin : begin + size], begin * paths
        tables = [each.parts.tables for each in own]
        together = stacked(tables, paths // LANES, goes_on=True) if whole else side_by_side(tables, paths)
        starts = [start_of(each, first + n * paths, paths) for n, each in enumerate(own)]
        room[begin : begin + size] = _rows(own[0], together, starts, first, stop).reshape(len(own), paths, -1)
        return len(own) / len(simulations)

    _on_threads(range(0, len(simulations), size), do, one.settings.threads, progress)
    return [_ensemble(each, rows) for each, rows in zip(simulations, room, strict=True)]


def alike(tables: Sequence[Tables]) -> bool:
    """Whether systems can be in neighbouring lanes."""
    return tables[0].sweep.size <= _MOST_BY_LANE and len({common(each) for each in tables}) == 1


def _on_threads(
    calls: Iterable[Any], do: Callable[[Any, npt.NDArray[np.uint8]], float], threads: int, progress: Progress | None
) -> None:
    """Do all calls; each returns its share of the work."""
    waiting, done, stop, telling = iter(calls), 0.0, np.zeros(1, np.uint8), threading.Lock()

    def work() -> None:
        nonlocal done
        while not stop[0] and (call := next(waiting, None)) is not None:
            share = do(call, stop)
            with telling:
                done += share
                if progress is not None and not stop[0]:
                    progress(min(done, 1.0))

    work_together(work, threads, stop=partial(stop.fill, 1))


@dataclass(frozen=True)
class _Call:
    """Blocks of one system, from one on, or all blocks of several."""

    members: Sequence[int]
    begin: int
    blocks: int


def _calls(simulations: Sequence[Simulation]) -> Iterator[_Call]:
    alike = dict[Hashable, list[int]]()
    for number, simulation in enumerate(simulations):
        alike.setdefault(_structure(simulation), []).append(number)
    for members in alike.values():
        one = simulations[members[0]]
        blocks = _blocks(one)
        most = blocks_of_a_call(one.settings, blocks * len(members))
        size = max(1, most // blocks)
        for first in range(0, len(members), size):
            for begin in range(0, blocks, most):
                yield _Call(members[first : first + size], begin, min(most, blocks - begin))


def _structure(simulation: Simulation) -> Hashable:
    """What the simulations in a call have in common."""
    tables, settings = simulation.parts.tables, simulation.settings
    return (
        tables.integers.tobytes(), tables.numbers.size, tables.sweep.size, tables.sweep.dtype.str,
        settings.paths, settings.steps, settings.window_steps, settings.seed,
    )  # fmt: skip


def start_of(simulation: Simulation, first: int, paths: int, stream: int = 0) -> Floats:
    """x and v at time 0 of so many paths of a system, which are numbered from ``first`` on."""
    before = first % LANES
    whole = -(-(before + paths) // LANES) * LANES
    states = simulation.parts.states(simulation.settings, first - before, whole, stream)
    return np.broadcast_to(states, (whole, states.shape[1]))[before : before + paths]


def _rows(
    one: Simulation, tables: Tables, starts: Sequence[Floats], first: int, stop: npt.NDArray[np.uint8]
) -> Floats:  # fmt: skip
    """The rows of all paths of a call in the kernel's units; ``one`` is of the systems, which have these tables."""
    parts, states = replace(one.parts, tables=tables), np.concatenate(starts)
    rows = np.empty((len(states), len(parts.columns)))
    parts.kernel()(
        states, first, len(states) // LANES, one.settings, *key_words(one.settings.seed), 0, False,
        addresses_of((), (), parts), _no_record(one), stop, rows,
    )  # fmt: skip
    return rows


def _ensemble(simulation: Simulation, rows: Floats) -> Ensemble:
    rows *= list(simulation.parts.columns.values())
    return Ensemble(rows[: simulation.settings.paths], _no_record(simulation))


def _no_record(simulation: Simulation) -> Floats:
    return np.empty((0, simulation.settings.recorded_points, *simulation.parts.shape_of_state))


def _blocks(simulation: Simulation) -> int:
    return -(-simulation.settings.paths // LANES)


def _path_steps(simulation: Simulation) -> float:
    return float(simulation.settings.paths) * simulation.settings.steps
