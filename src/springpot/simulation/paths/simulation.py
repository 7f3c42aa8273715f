"""One simulation: a plan, prepared for the kernel, and its blocks of paths on threads."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.machine.crew import work_together
from springpot.simulation.kernel.kept import Code
from springpot.simulation.kernel.native import key_words
from springpot.simulation.kernel.sizes import GROUP, LANES
from springpot.simulation.kernel.watching import ALL, BATCHES, HEADER, PEAKS, table_of
from springpot.simulation.lowering.compose import Parts, compose
from springpot.simulation.lowering.observers import Observer
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.signals import Signal

_NO_RECORD = np.zeros((0, 0, 0))
_STEPS_OF_A_CALL = 40_000  # of one block or several: 10 ms

Progress = Callable[[float], None]
Found = Mapping[str, Floats]
"""What an observer kept of its fields, by their names: of each path, batch or block."""


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Results of paths, in the user's units and on the user's side of the wall.

    Attributes
    ----------
    rows : ndarray, shape (paths, columns)
        Sums of each path, as `Parts.columns` names them.
    record : ndarray, shape (recorded, points, 2)
        x and v at 0 and after every ``record_every`` steps.
    observed : dict
        What each observer kept, by the observer and the name of the field.
    outputs : dict of ndarray
        Of the recorded paths, shape (recorded, points), by the numbers of the forces and accelerations that are seen.
    """

    rows: Floats
    record: Floats
    observed: Mapping[Observer, Found] = field(default_factory=dict)
    outputs: dict[int, Floats] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Simulation:
    """One plan, prepared for the kernel.  Made by `simulation_of`.

    Attributes
    ----------
    plan : Plan
        Complete: x(0) is known.
    parts : Parts
    """

    plan: Plan
    parts: Parts

    @property
    def settings(self) -> Settings:
        """Of the plan."""
        return self.plan.settings

    @property
    def motion(self) -> Motion:
        """Of the plan."""
        return self.plan.motion

    @property
    def substeps(self) -> int:
        """Short steps of half a drift in which a contact is touched."""
        return self.parts.tables.count("substeps")

    def but(self, **changes: Any) -> Simulation:
        """The same with other settings; step, start and memory cannot be changed, the parts depend on them."""
        return replace(self, plan=self.plan.but(**changes))

    def with_parts(self, **parts: Any) -> Simulation:
        """The same with other parts of the kernel, by their names in `Parts`."""
        return replace(self, parts=replace(self.parts, **parts))

    def timed(self, **given: Any) -> tuple[float, float]:
        """Path-steps of a short run, and its seconds; arguments are those of `advance`."""
        settings = self.settings
        steps = min(settings.steps, 8192)
        length = steps * settings.step
        few = self.but(paths=LANES * settings.threads, duration=length, window=(0.0, length), record=0)
        for _ in range(2):  # the first may have to load or compile the kernel
            begun = time.perf_counter()
            few.advance(**given)
        return float(few.settings.paths * steps), time.perf_counter() - begun

    def advance(
        self,
        *,
        stream: int = 0,
        skipped: int = 0,
        halved: bool = False,
        observers: Sequence[Observer] = (),
        progress: Progress | None = None,
    ) -> Ensemble:
        """Run all paths, block by block, on ``settings.threads`` threads.

        The paths are those numbered from ``skipped``, a multiple of LANES.  With ``halved`` the noise is that of a run
        with half the step, summed in pairs.  The bits of a path depend on the seed, the stream and its number only.  An
        interrupt (Ctrl-C) ends the threads within a fraction of a second and is passed on.
        """
        settings = self.settings
        blocks = -(-settings.paths // LANES)
        columns = self.parts.columns
        rows = np.empty((blocks * LANES, len(columns)))
        record = np.empty((settings.record, settings.recorded_points, *self.parts.shape_of_state))
        stop = np.zeros(1, np.uint8)
        k0, k1 = key_words(settings.seed)
        together = 1 if observers or settings.record else blocks_of_a_call(settings, blocks)
        next_call = itertools.count()
        done = itertools.count(1)
        kernel = self.parts.kernel()
        states = self.parts.states(settings, skipped, blocks * LANES, stream)
        beginnings = [_array_of(observer, self.parts) for observer in observers]
        rooms = [_rooms(*each, blocks) for each in zip(observers, beginnings, strict=True)]
        seen = outputs_seen(observers)
        outputs = np.empty((settings.record if seen else 0, settings.recorded_points, len(seen)))
        adding = threading.Lock()

        def work() -> None:
            arrays = [beginning.copy() for beginning in beginnings]
            while not stop[0] and (number := together * next(next_call)) < blocks:
                first, count = number * LANES, min(together, blocks - number)
                some = slice(first, first + count * LANES)
                for array, beginning in zip(arrays, beginnings, strict=True):
                    array[:] = beginning
                    array["lanes"] = min(LANES, settings.paths - first)
                kernel(
                    states[some] if len(states) > 1 else states, skipped + first, count, settings,
                    k0, k1, stream, halved, addresses_of(observers, arrays, self.parts, outputs[some]), record[some],
                    stop, rows[some],
                )  # fmt: skip
                for observer, (array,), room in zip(observers, arrays, rooms, strict=True):
                    for name in observer.of_paths:
                        room[name][first : first + LANES] = np.moveaxis(array[name], -1, 0)
                    for name in observer.of_blocks:
                        room[name][number] = array[name]
                    with adding:  # whole numbers and halves: their sum does not depend on the order
                        for name in observer.of_batches:
                            room[name][number % BATCHES] += array[name]
                finished = min(together * next(done), blocks)
                if progress is not None and not stop[0]:
                    progress(finished / blocks)

        work_together(work, min(settings.threads, -(-blocks // together)), stop=partial(stop.fill, 1))
        started = states[: settings.record if len(states) > 1 else 1]
        record[:, 0] = self.parts.start_of_record(started)  # the kernel writes from t = h on
        record *= self.parts.units.state
        rows *= list(columns.values())
        outputs *= self.parts.units.state[0]
        for observer, room in zip(observers, rooms, strict=True):
            room |= {name: room[name][: settings.paths] for name in observer.of_paths}
        observed = dict(zip(observers, rooms, strict=True))
        return Ensemble(
            rows[: settings.paths], record, observed, dict(zip(seen, np.moveaxis(outputs, 2, 0), strict=True))
        )


def simulation_of(plan: Plan, *, halved: bool = False) -> Simulation:
    """Prepare a simulation; ``halved`` is as in `compose`."""
    return Simulation(plan, compose(plan, halved=halved))


def blocks_of_a_call(settings: Settings, blocks: int) -> int:
    """How many short blocks share a call: each takes 0.1 ms of Python, in which no other thread computes."""
    return max(1, min(_STEPS_OF_A_CALL // settings.steps, blocks // (8 * settings.threads)))


def _array_of(observer: Observer, parts: Parts) -> npt.NDArray[np.void]:
    """The array of an observer at the start of a block, with its header."""
    array: npt.NDArray[np.void] = observer.initial(parts) if callable(observer.initial) else observer.initial
    array = array.reshape(1).copy()
    for name, number in zip(HEADER, parts.header_of(observer), strict=True):
        array[name] = number
    return array


def _rooms(observer: Observer, array: npt.NDArray[np.void], blocks: int) -> dict[str, Floats]:
    """Arrays for what an observer keeps of all blocks, by the names of its fields."""
    shapes = {name: array[name].shape[1:] for name in array.dtype.names or ()}
    return {
        **{name: np.empty((blocks * LANES, *shapes[name][:-1])) for name in observer.of_paths},
        **{name: np.zeros((min(blocks, BATCHES), *shapes[name])) for name in observer.of_batches},
        **{name: np.empty((blocks, *shapes[name])) for name in observer.of_blocks},
    }


def addresses_of(
    observers: Sequence[Observer], arrays: Sequence[npt.NDArray[Any]], parts: Parts, record: Floats = _NO_RECORD
) -> npt.NDArray[np.int64]:
    """The observers as the kernel has them, with their arrays and the room for the record of outputs."""

    def address(compiled: Code | None) -> int:
        return 0 if compiled is None else compiled.address

    def wall(signal: Signal) -> int:
        if signal.peaks:
            return PEAKS - parts.contacts.index(signal.stop or "")
        return parts.walls.index(signal.stop) if signal.stop else ALL

    each = [
        (
            address(own.on_steps) if own.signal.number is not None else 0,
            address(own.on_impacts) if own.signal.stop is not None else 0,
            array.ctypes.data, own.every, (own.signal.number or 0) * GROUP * LANES, wall(own.signal),
        )
        for own, array in zip(observers, arrays, strict=True)
    ]  # fmt: skip
    seen, known = outputs_seen(observers), parts.outputs
    return table_of(each, seen, known.begin.tolist(), known.row.tolist(), known.numbers, record)


def outputs_seen(observers: Sequence[Observer]) -> list[int]:
    """The numbers of the forces and accelerations that are seen, in the order of their record."""
    return sorted({number for observer in observers for number in observer.signal.outputs})
