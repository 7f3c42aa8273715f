"""Blocks of paths on threads: from an oscillator and settings to one row of sums per path.

Always seen from a wall below the motion; a wall above is its mirror image, x -> -x, and is mirrored back when the rows
are read (:mod:`springpot.simulation.statistics`).
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.crew import work_together
from springpot.oscillator import Oscillator
from springpot.simulation.compose import Floats, Tables, mirror
from springpot.simulation.kernel import COLUMNS, block
from springpot.simulation.lanes import LANES
from springpot.simulation.listening import BATCHES, HEADER, Observer, Observers
from springpot.simulation.parts import Rigid
from springpot.simulation.random import key_words
from springpot.simulation.settings import Settings

__all__ = ["Ensemble", "Progress", "advance"]

Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What the blocks left: one row of COLUMNS per path, and the recorded paths.

    Attributes
    ----------
    rows : ndarray, shape (paths, len(COLUMNS))
    record : ndarray, shape (recorded, points, 2)
        x and v at 0 and after every ``record_every`` steps.
    observed : tuple of ndarray
        What each observer left: shape (paths, numbers), or (batches, size) for counts.
    """

    rows: Floats
    record: Floats
    observed: tuple[Floats, ...] = ()


def advance(
    oscillator: Oscillator,
    settings: Settings,
    made: Tables,
    *,
    stream: int = 0,
    skipped: int = 0,
    halved: bool = False,
    observers: Sequence[Observer] = (),
    progress: Progress | None = None,
) -> Ensemble:
    """Run all paths, block by block, on ``settings.threads`` threads.

    The paths are those numbered from ``skipped``, a multiple of LANES.  With ``halved`` the noise is that of a run with
    half the step, summed in pairs.  The bits of a path depend on the seed, the stream and its number only.  An
    interrupt (Ctrl-C) ends the threads within a fraction of a second and is passed on.
    """
    blocks = -(-settings.paths // LANES)
    rows = np.empty((blocks * LANES, len(COLUMNS)))
    record = np.empty((settings.record, settings.recorded_points, 2))
    stop = np.zeros(1, np.uint8)
    k0, k1 = key_words(settings.seed)
    low, high = settings.window_steps
    next_block = itertools.count()
    done = itertools.count(1)
    stiffness = (oscillator.natural_frequency * made.time) ** 2

    sign, speed = mirror(oscillator), made.length / made.time
    place = made.wall.position if isinstance(made.wall, Rigid) else 0.0
    header = [sign * made.length, sign * speed, made.time, oscillator.natural_frequency * made.time, place, LANES]
    observed = [_room(observer, blocks) for observer in observers]
    adding = threading.Lock()

    def work() -> None:
        arrays = [np.concatenate([header, observer.initial]) for observer in observers]
        listening = _addresses(observers, arrays)
        while not stop[0] and (number := next(next_block)) < blocks:
            first = number * LANES
            for observer, array in zip(observers, arrays, strict=True):
                array[len(HEADER) :] = observer.initial
                array[HEADER.index("lanes")] = min(LANES, settings.paths - first)
            block(
                made.scheme, made.wall, made.load, made.memory, made.drive, made.start, stiffness,
                skipped + first, settings.steps, low, high, k0, k1, stream, halved, listening,
                record[first : first + LANES], settings.record_every, stop, rows[first : first + LANES],
            )  # fmt: skip
            for observer, array, room in zip(observers, arrays, observed, strict=True):
                if observer.per_path:
                    room[first : first + LANES] = array[len(HEADER) :].reshape(-1, LANES).T
                else:
                    with adding:  # whole numbers: their sum does not depend on the order
                        room[number % BATCHES] += array[len(HEADER) :]
            finished = next(done)
            if progress is not None and not stop[0]:
                progress(finished / blocks)

    def halt() -> None:
        stop[0] = 1

    work_together(work, min(settings.threads, blocks), stop=halt)
    record[:, 1:] *= made.length, speed  # the kernel leaves the first to us
    record[:, 0] = sign * settings.initial_position, sign * settings.initial_velocity
    units = {
        "x": made.length, "x_square": made.length**2, "v_square": speed**2, "force": speed / made.time,
        "power": speed**2 / made.time, "virial": speed**2, "impacts": 1.0, "impact_speeds": speed,
        "impact_speed_squares": speed**2, "collapses": 1.0, "energy_first": speed**2, "energy_last": speed**2,
        "x_end": made.length, "v_end": speed,
    }  # fmt: skip
    rows *= [units[name] for name in COLUMNS]
    kept = tuple(
        room[: settings.paths] if observer.per_path else room
        for observer, room in zip(observers, observed, strict=True)
    )
    return Ensemble(rows[: settings.paths], record, kept)


def _room(observer: Observer, blocks: int) -> Floats:
    """Where the blocks put what an observer has accumulated."""
    if observer.per_path:
        return np.empty((blocks * LANES, observer.initial.size // LANES))
    return np.zeros((min(blocks, BATCHES), observer.initial.size))


def _addresses(observers: Sequence[Observer], arrays: Sequence[Floats]) -> Observers:
    """The observers as the kernel knows them."""

    def numbers(found: Iterable[int]) -> npt.NDArray[np.int64]:
        return np.fromiter(found, np.int64)

    return Observers(
        watch=numbers(0 if o.watch is None else o.watch.address for o in observers),
        hear=numbers(0 if o.hear is None else o.hear.address for o in observers),
        place=numbers(array.ctypes.data for array in arrays),
        every=numbers(o.every for o in observers),
    )
