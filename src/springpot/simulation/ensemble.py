"""Blocks of paths on threads: from an oscillator and settings to one row of sums per path.

Always seen from a wall below the motion; a wall above is its mirror image, x -> -x, and is mirrored back when the rows
are read (:mod:`springpot.simulation.statistics`).
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.crew import work_together
from springpot.memory import ExponentialSum, direct, exponential_sum
from springpot.memory.weights import Family
from springpot.oscillator import Oscillator
from springpot.simulation.kernel import COLUMNS, Memory, block
from springpot.simulation.lanes import GROUP, LANES, MOST_MODES
from springpot.simulation.listening import HEADER, Observers
from springpot.simulation.observers import BATCHES, Observer
from springpot.simulation.parts import (
    Euler,
    NoWall,
    Rigid,
    Splitting,
    Start,
    White,
    euler,
    newest_weights_splitting,
    splitting,
)
from springpot.simulation.random import key_words
from springpot.simulation.settings import Settings, fastest_rate, mirror

__all__ = ["Ensemble", "Tables", "advance", "tables"]

Progress = Callable[[float], None]
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Tables:
    """The parts and tables a kernel needs for one oscillator and one step.

    Attributes
    ----------
    scheme, wall, load, memory, start
        Parts of the kernel.
    drive : ndarray
        Force in each step that stems from x(0), or empty (Caputo's derivative, or x(0) = 0).
    expected_power : float
        Mean power that the noise feeds into this scheme's motion, q/2 up to the order of the step.
    length, time : float
        The kernel's units, powers of two, in m and s: whatever the problem's scales, what it computes with is near 1,
        and a change of scale by a power of two changes no bit.
    sum : ExponentialSum
        The memory before it was given units.
    """

    scheme: Splitting | Euler
    wall: NoWall | Rigid
    load: White
    memory: Memory
    start: Start
    drive: npt.NDArray[np.floating]
    expected_power: float
    length: float
    time: float
    sum: ExponentialSum


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


def family(settings: Settings) -> Family:
    """The weights of the past that a scheme uses."""
    return "grunwald" if settings.scheme == "grunwald" else "average"


def tables(oscillator: Oscillator, settings: Settings) -> Tables:
    """Everything the kernel needs, computed once per run."""
    length, time = _units(oscillator, settings)
    order, sign = oscillator.springpot.order, mirror(oscillator)
    coefficient = oscillator.springpot.coefficient * time ** (2.0 - order)
    frequency, step = oscillator.natural_frequency * time, settings.step / time
    intensity = oscillator.excitation.intensity / length**2 * time**3
    x0, v0 = sign * settings.initial_position / length, sign * settings.initial_velocity / length * time
    scale = coefficient * step**-order
    past = exponential_sum(family(settings), order, settings.steps + 1, settings.memory_tolerance)
    scheme: Splitting | Euler
    if settings.scheme == "grunwald":
        scheme = euler(frequency, step, settings.contact_tolerance / length)
        older, share = 0.0, 1.0
    else:
        scheme = splitting(frequency, order, coefficient, step)
        older, share = newest_weights_splitting(order)[1], scheme.share
    drive = _drive(order, scale, x0, settings)
    # Riemann-Liouville's force at the start is largest at once, and the kick that stands for its first step comes later
    late = settings.scheme == "default" and drive.size > 0
    early = -float(drive[0]) * step**2 * 0.5 * order / (2.0 - order) if late else 0.0
    barrier = oscillator.barrier
    wall = NoWall(0.0) if barrier is None else Rigid(sign * barrier.position / length, barrier.restitution)
    return Tables(
        scheme=scheme,
        wall=wall,
        load=White(math.sqrt(intensity * step)),
        memory=_memory(past, scale, recent_weights(order, settings), older, settings.precision),
        start=Start(x0, v0, 0.5 * (v0 * v0 + frequency * frequency * x0 * x0), early),
        drive=drive,
        expected_power=0.5 * oscillator.excitation.intensity * share,
        length=length,
        time=time,
        sum=past,
    )


def _units(oscillator: Oscillator, settings: Settings) -> tuple[float, float]:
    """Powers of two near the largest length and the shortest time of the problem."""
    time = 2.0 ** round(-math.log2(fastest_rate(oscillator)))
    lengths = (
        oscillator.length_scale,
        abs(settings.initial_position),
        abs(settings.initial_velocity) / oscillator.natural_frequency,
        0.0 if oscillator.barrier is None else abs(oscillator.barrier.position),
    )
    longest = max(lengths)
    return (2.0 ** round(math.log2(longest)) if longest > 0.0 else 1.0), time


def recent_weights(order: float, settings: Settings) -> Floats:
    """Weights of the four newest increments, in units of h^-alpha."""
    weights = direct(family(settings), order, GROUP)
    if settings.scheme == "default":
        weights[:2] += newest_weights_splitting(order)
    return weights


def _memory(past: ExponentialSum, scale: float, recent: Floats, older: float, precision: str) -> Memory:
    if past.rates.size > MOST_MODES:
        raise ValueError(f"memory_tolerance asks for {past.rates.size} memory modes; the kernel holds {MOST_MODES}.")
    # an even number of modes, for the kernel takes two at a time; the odd one out weighs nothing
    size = past.rates.size + past.rates.size % 2
    rates, strengths = np.zeros(size), np.zeros(size)
    rates[: past.rates.size], strengths[: past.rates.size] = past.rates, scale * past.weights
    powers = np.exp(-np.outer(rates, np.arange(1, GROUP + 1)))
    weights_of_modes = strengths[:, None] * powers
    powers[:, -1] = np.expm1(-GROUP * rates)
    return Memory(
        powers.ravel().astype(precision),
        weights_of_modes.ravel().astype(precision),
        *(np.dtype(precision).type(scale * w) for w in (recent[0], older, *recent[1:])),
    )


def _drive(order: float, scale: float, x0: float, settings: Settings) -> npt.NDArray[np.floating]:
    """Riemann-Liouville's x(0) t^-alpha / Gamma(1 - alpha), as the scheme's own weights see it."""
    if settings.derivative == "caputo" or x0 == 0.0:
        return np.zeros(0, settings.precision)
    weights = direct(family(settings), order, settings.steps + GROUP)
    return np.asarray(scale * x0 * weights, settings.precision)


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
