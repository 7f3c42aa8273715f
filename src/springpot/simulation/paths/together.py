"""Several simulations at once: those of one structure share the calls of the kernel, and all share the threads.

A system of few paths has few blocks, so that alone it keeps few threads busy.  In a call of several systems each has
blocks with numbers of its own in the kernel's tables.  Its paths have the numbers and so the bits that it has alone.

Systems of few paths can also share a block, in which each lane has numbers of its own.  A path-step takes half as long
again then, but no lane is empty.  Their paths are those of each alone to rounding.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.machine.crew import work_together
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.normals import key_words
from springpot.simulation.kernel.tables import Tables, common, side_by_side, stacked
from springpot.simulation.paths.simulation import Ensemble, Progress, Simulation, addresses_of, blocks_of_a_call

_MOST_BY_LANE = 100_000  # numbers of a system, each of which stands LANES times in the tables of a block


def advance_together(
    simulations: Sequence[Simulation], progress: Progress | None = None, *, by_lane: bool = False
) -> list[Ensemble]:
    """As `Simulation.advance` of each, without a record and observers, with the same bits; ``by_lane`` to rounding.

    They may have any structure and settings, but the number of threads.
    """
    rooms = [np.zeros((_blocks(each) * LANES, len(each.parts.columns))) for each in simulations]
    waiting = iter(list(_calls(simulations, by_lane)))
    whole, done = sum(map(_path_steps, simulations)), 0.0
    stop, telling = np.zeros(1, np.uint8), threading.Lock()

    def work() -> None:
        nonlocal done
        while not stop[0] and (call := next(waiting, None)) is not None:
            own = [simulations[member] for member in call.members]
            for member, found in zip(call.members, _advance(own, call, stop), strict=True):
                rooms[member][call.begin * LANES :][: len(found)] = found
            with telling:
                done += sum(_path_steps(each) * call.blocks / _blocks(each) for each in own)
                if progress is not None and not stop[0]:
                    progress(min(done / whole, 1.0))

    def halt() -> None:
        stop[0] = 1

    if simulations:
        work_together(work, simulations[0].settings.threads, stop=halt)
    return [_ensemble(each, rows) for each, rows in zip(simulations, rooms, strict=True)]


def advance_devices(simulations: Sequence[Simulation], progress: Progress | None = None) -> list[Ensemble]:
    """As `advance_together`, each system as one of many devices: no two paths have the same random numbers.

    All have the same settings.  Where they have the `common` numbers, neighbouring devices share a block; otherwise
    each has blocks of its own.
    """
    one, paths = simulations[0], simulations[0].settings.paths
    is_shared = alike([each.parts.tables for each in simulations])
    if not is_shared and paths % LANES:
        raise ValueError(
            f"paths must be {LANES} or a multiple of it, not {paths}: the devices differ in a rate of their memory, in "
            "an exponent, or in which parts act, so that they cannot share blocks of paths."
        )
    room = np.empty((len(simulations), paths, len(one.parts.columns)))
    steps, stop, telling = max(LANES // paths, 1), np.zeros(1, np.uint8), threading.Lock()
    blocks = len(simulations) * paths // LANES
    size = steps * max(1, blocks_of_a_call(one.settings, blocks) * LANES // max(paths, LANES)) if is_shared else 1
    waiting, done = iter(range(0, len(simulations), size)), 0

    def work() -> None:
        nonlocal done
        while not stop[0] and (first := next(waiting, None)) is not None:
            own = simulations[first : first + size]
            room[first : first + size] = _advance_devices(own, first * paths, is_shared, stop)
            with telling:
                done += len(own)
                if progress is not None and not stop[0]:
                    progress(done / len(simulations))

    def halt() -> None:
        stop[0] = 1

    work_together(work, one.settings.threads, stop=halt)
    return [_ensemble(each, rows) for each, rows in zip(simulations, room, strict=True)]


def alike(tables: Sequence[Tables]) -> bool:
    """Whether systems can be in neighbouring lanes."""
    return tables[0].sweep.size <= _MOST_BY_LANE and len({common(each) for each in tables}) == 1


def _advance_devices(
    simulations: Sequence[Simulation], first: int, is_shared: bool, stop: npt.NDArray[np.uint8]
) -> Floats:  # fmt: skip
    """The rows of each system in the kernel's units, shape (systems, paths, columns)."""
    one, paths, tables = simulations[0], simulations[0].settings.paths, [each.parts.tables for each in simulations]
    parts = replace(one.parts, tables=side_by_side(tables, paths, goes_on=True) if is_shared else tables[0])
    blocks = len(simulations) * paths // LANES
    starts = [_start(each, first + n * paths) for n, each in enumerate(simulations)]
    rows = np.empty((blocks * LANES, len(parts.columns)))
    parts.kernel()(
        np.concatenate(starts), first, blocks, one.settings, *key_words(one.settings.seed), 0, False,
        addresses_of((), (), parts), _no_record(one), stop, rows,
    )  # fmt: skip
    return rows.reshape(len(simulations), paths, -1)


def _start(simulation: Simulation, first: int) -> Floats:
    """x and v at time 0 of all paths of a system, which are numbered from ``first`` on."""
    paths, before = simulation.settings.paths, first % LANES
    whole = -(-(before + paths) // LANES) * LANES
    states = simulation.parts.states(simulation.settings, first - before, whole, 0)
    return np.broadcast_to(states, (whole, states.shape[1]))[before : before + paths]


@dataclass(frozen=True)
class _Call:
    """Blocks of one system, from one on, or all blocks of several; or systems of ``neighbours`` lanes of a block."""

    members: Sequence[int]
    begin: int
    blocks: int
    neighbours: int = 0


def _calls(simulations: Sequence[Simulation], by_lane: bool = False) -> Iterator[_Call]:
    alike = dict[Hashable, list[int]]()
    for number, simulation in enumerate(simulations):
        alike.setdefault(_structure(simulation, by_lane), []).append(number)
    for members in alike.values():
        one = simulations[members[0]]
        blocks, neighbours = _blocks(one), _neighbours(one) if by_lane else 0
        if neighbours and len(members) > 1:
            size = max(1, blocks_of_a_call(one.settings, -(-len(members) * neighbours // LANES))) * LANES // neighbours
            yield from (
                _Call(members[first : first + size], 0, 1, neighbours) for first in range(0, len(members), size)
            )
            continue
        most = blocks_of_a_call(one.settings, blocks * len(members))
        size = max(1, most // blocks)
        for first in range(0, len(members), size):
            for begin in range(0, blocks, most):
                yield _Call(members[first : first + size], begin, min(most, blocks - begin))


def _structure(simulation: Simulation, by_lane: bool) -> Hashable:
    """What the simulations in a call have in common."""
    tables, settings = simulation.parts.tables, simulation.settings
    alike = common(tables) if by_lane else tables.integers.tobytes()
    return (
        alike, tables.numbers.size, tables.sweep.size, tables.sweep.dtype.str, settings.paths, settings.steps,
        settings.window_steps, settings.seed,
    )  # fmt: skip


def _neighbours(simulation: Simulation) -> int:
    """The lanes of a block that a system takes if others share it; 0 where it needs a block, or has long lists."""
    lanes = max(8, 2 ** math.ceil(math.log2(simulation.settings.paths)))
    return lanes if lanes < LANES and simulation.parts.tables.sweep.size <= _MOST_BY_LANE else 0


def _advance(simulations: Sequence[Simulation], call: _Call, stop: npt.NDArray[np.uint8]) -> Floats:
    """The rows of each system in the kernel's units, shape (systems, paths, columns)."""
    one, tables = simulations[0], [each.parts.tables for each in simulations]
    parts = replace(
        one.parts, tables=side_by_side(tables, call.neighbours) if call.neighbours else stacked(tables, call.blocks)
    )
    paths = call.neighbours or call.blocks * LANES
    starts = [each.parts.states(each.settings, call.begin * LANES, call.blocks * LANES, 0) for each in simulations]
    starts = [np.broadcast_to(states, (call.blocks * LANES, states.shape[1]))[:paths] for states in starts]
    blocks = -(-len(simulations) * paths // LANES)
    starts += [starts[-1]] * (blocks * LANES // paths - len(starts))  # of lanes that are left over
    rows = np.empty((blocks * LANES, len(parts.columns)))
    keys, observers = key_words(one.settings.seed), addresses_of((), (), parts)
    parts.kernel()(
        np.concatenate(starts), call.begin * LANES, blocks, one.settings, *keys, 0, False, observers, _no_record(one),
        stop, rows,
    )  # fmt: skip
    return rows.reshape(-1, paths, rows.shape[1])[: len(simulations)]


def _ensemble(simulation: Simulation, rows: Floats) -> Ensemble:
    rows *= list(simulation.parts.columns.values())
    return Ensemble(rows[: simulation.settings.paths], _no_record(simulation))


def _no_record(simulation: Simulation) -> Floats:
    return np.empty((0, simulation.settings.recorded_points, *simulation.parts.shape_of_state))


def _blocks(simulation: Simulation) -> int:
    return -(-simulation.settings.paths // LANES)


def _path_steps(simulation: Simulation) -> float:
    return float(simulation.settings.paths) * simulation.settings.steps
