"""One simulation: an oscillator with settings, prepared for the kernel, and its blocks of paths on threads."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.crew import work_together
from springpot.problem.oscillator import Oscillator
from springpot.problem.system import System
from springpot.problem.units import UNITS
from springpot.simulation.estimate.few_events import errors_of_unseen
from springpot.simulation.estimate.slow_impacts import impacts_are_countable
from springpot.simulation.estimate.statistics import ratio, residual, standard_error
from springpot.simulation.estimate.system_samples import (
    errors_of_the_start_of_system,
    impacts_of_system,
    samples_of_system,
)
from springpot.simulation.kernel.block import COLUMNS, block
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.questions import Start
from springpot.simulation.kernel.random import key_words, start_normals
from springpot.simulation.kernel.watching import BATCHES, HEADER, Observer, Observers
from springpot.simulation.lowering.compose import Floats, Parts, compose
from springpot.simulation.plan.scales import Scales
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.start import Adapted
from springpot.simulation.plan.system_scales import scales_of_problem

__all__ = ["Ensemble", "Progress", "Simulation", "simulation_of"]

_STEPS_OF_A_CALL = 40_000  # of one block or several: 10 ms

Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Results of paths, in the user's units and on the user's side of the wall.

    Attributes
    ----------
    rows : ndarray, shape (paths, len(COLUMNS))
        Sums of each path.
    record : ndarray, shape (recorded, points, 2)
        x and v at 0 and after every ``record_every`` steps.
    observed : tuple of ndarray
        Result of each observer: shape (paths, numbers), or (batches, size) for counts.
    """

    rows: Floats
    record: Floats
    observed: tuple[Floats, ...] = ()


@dataclass(frozen=True, eq=False)
class Simulation:
    """One problem with settings, prepared for the kernel.  Made by `simulation_of`.

    Attributes
    ----------
    problem : Oscillator or System
    settings : Settings
        Complete: x(0) is known.
    scales : Scales
    parts : Parts
    adapted : Adapted or None
        x(0) of a stationary start.
    """

    problem: Oscillator | System
    settings: Settings
    scales: Scales
    parts: Parts
    adapted: Adapted | None = None

    @property
    def oscillator(self) -> Oscillator:
        """The problem, where it is an oscillator.

        Raises
        ------
        TypeError
            If it is another system.
        """
        if not isinstance(self.problem, Oscillator):
            raise TypeError("this simulation is of a system that is no oscillator.")
        return self.problem

    def but(self, **changes: Any) -> Simulation:
        """The same with other settings; step, start and memory cannot be changed, the parts depend on them."""
        return replace(self, settings=replace(self.settings, **changes))

    def with_parts(self, **parts: Any) -> Simulation:
        """The same with other parts of the kernel, by their names in `Parts`."""
        return replace(self, parts=replace(self.parts, **parts))

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
        record = np.empty((settings.record, settings.recorded_points, 2))
        stop = np.zeros(1, np.uint8)
        k0, k1 = key_words(settings.seed)
        low, high = settings.window_steps
        together = 1 if observers or settings.record else _blocks_of_a_call(settings, blocks)
        next_call = itertools.count()
        done = itertools.count(1)
        parts, units = self.parts, self.parts.units
        exact, sweep = parts.of_kernel()
        header = [*units.state, units.time, parts.frequency, parts.wall_position, LANES]
        states = self._states(skipped, blocks * LANES, stream)
        observed = [_room(observer, blocks) for observer in observers]
        adding = threading.Lock()

        def work() -> None:
            arrays = [np.concatenate([header, observer.initial]) for observer in observers]
            addresses = _addresses(observers, arrays)
            while not stop[0] and (number := together * next(next_call)) < blocks:
                first, count = number * LANES, min(together, blocks - number)
                some = slice(first, first + count * LANES)
                for observer, array in zip(observers, arrays, strict=True):
                    array[len(HEADER) :] = observer.initial
                    array[HEADER.index("lanes")] = min(LANES, settings.paths - first)
                block(
                    exact, sweep, parts.memory, parts.drive,
                    _part_of(parts.start, states, some), parts.tapped, parts.frequency**2,
                    skipped + first, count, settings.steps, low, high, k0, k1, stream, halved, addresses,
                    record[some], settings.record_every, stop, rows[some],
                )  # fmt: skip
                for observer, array, room in zip(observers, arrays, observed, strict=True):
                    if observer.per_path:
                        room[first : first + LANES] = array[len(HEADER) :].reshape(-1, LANES).T
                    else:
                        with adding:  # whole numbers: their sum does not depend on the order
                            room[number % BATCHES] += array[len(HEADER) :]
                finished = min(together * next(done), blocks)
                if progress is not None and not stop[0]:
                    progress(finished / blocks)

        def halt() -> None:
            stop[0] = 1

        work_together(work, min(settings.threads, -(-blocks // together)), stop=halt)
        record[:, 0] = states[: settings.record if len(states) > 1 else 1, :2]  # the kernel writes from t = h on
        record *= units.state
        rows *= list(columns.values())
        kept = tuple(
            room[: settings.paths] if observer.per_path else room
            for observer, room in zip(observers, observed, strict=True)
        )
        return Ensemble(rows[: settings.paths], record, kept)

    def _states(self, skipped: int, paths: int, stream: int) -> Floats:
        """x, v and energy at time 0: of every path if they are drawn, otherwise once for all."""
        law, units = self.parts.law, self.parts.units
        if law is None or self.settings.start != "stationary":
            return self.parts.start.states
        from scipy import special  # slow to import, and most runs need none of it

        normals = start_normals(self.settings.seed, skipped, paths, stream=stream).astype(float)
        x = law.drawn(special.ndtr(normals[:, 0])) / units.length
        v = math.sqrt(law.temperature) / units.speed * normals[:, 1]
        return np.stack([x, v, 0.5 * (v * v + self.parts.frequency**2 * x * x)], axis=1)

    def samples(self, rows: Floats) -> dict[str, tuple[float, Floats]]:
        """Each estimate with its samples, one per path; its mean is that of the samples (ratios are linearized).

        Differences and sums of samples from the same paths give the standard errors of differences and sums.

        Parameters
        ----------
        rows : ndarray, shape (paths, len(COLUMNS))
            Of `advance`.
        """
        if isinstance(self.problem, System):
            return samples_of_system(self.problem, self.parts, self.settings, rows)
        oscillator, (low, high) = self.oscillator, self.settings.window_steps
        steps, time = high - low, (high - low) * self.settings.step
        column = dict(zip(COLUMNS, rows.T, strict=True))
        stiffness = oscillator.natural_frequency**2
        restitution = 1.0 if oscillator.barrier is None else oscillator.restitution
        taken = column["power"] / steps + self.parts.taken_at_once
        spent = taken + 0.5 * (1.0 - restitution**2) * column["impact_speed_squares"] / time
        gained = (column["energy_last"] - column["energy_first"]) / time
        per_path = {
            "x_mean": column["x"] / steps,
            "x_mean_square": column["x_square"] / steps,
            "v_mean_square": column["v_square"] / steps,
            "amplitude_mean_square": (column["x_square"] + column["v_square"] / stiffness) / steps,
            "impact_rate": column["impacts"] / time,
            "springpot_force_mean": column["force"] / steps,
            "springpot_power": taken,
            "springpot_virial": column["virial"] / steps,
            "energy_residual": residual(spent + gained, self.parts.expected_power, column["energy_first"] / time),
            "x_mean_end": column["x_end"],
            "x_mean_square_end": column["x_end"] ** 2,
            "v_mean_square_end": column["v_end"] ** 2,
            "amplitude_mean_square_end": column["x_end"] ** 2 + column["v_end"] ** 2 / stiffness,
        }
        estimates = {name: (float(samples.mean()), samples) for name, samples in per_path.items()}
        estimates["impact_speed_mean"] = ratio(column["impact_speeds"], column["impacts"])
        estimates["impact_speed_mean_square"] = ratio(column["impact_speed_squares"], column["impacts"])
        if oscillator.barrier is not None and not impacts_are_countable(oscillator):
            undefined = math.nan, np.full(len(rows), np.nan)
            estimates |= dict.fromkeys(("impact_rate", "impact_speed_mean", "impact_speed_mean_square"), undefined)
        return estimates

    def estimates(self, rows: Floats) -> tuple[dict[str, float], dict[str, float]]:
        """Values and standard errors, both by name; the errors include that of an adapted start.

        Returns
        -------
        values, errors : dict
            Keys of `UNITS`.  With a single path the errors are NaN; a speed without impacts is NaN, and so are impact
            rate and speeds at a restitution that makes infinitely many impacts.  What is 0 since no impact was seen has
            the errors of `springpot.simulation.estimate.few_events`.
        """
        samples = self.samples(rows)
        names = tuple(UNITS) if isinstance(self.problem, Oscillator) else tuple(samples)
        values = {name: samples[name][0] for name in names}
        start = self.errors_of_the_start(values)
        errors = {name: math.hypot(standard_error(samples[name][1]), start[name]) for name in names}
        return values, errors | errors_of_unseen(values, self.impacts(rows), self.watched(rows))

    def impacts(self, rows: Floats) -> dict[str, Floats]:
        """Impacts of each path in the window: on each wall of a system by its name, on all under an empty one."""
        column = dict(zip(self.parts.columns, rows.T, strict=True))
        if isinstance(self.problem, System):
            return impacts_of_system(self.problem, column)
        return {} if self.problem.barrier is None else {"": column["impacts"]}

    def watched(self, rows: Floats) -> float:
        """The time in all windows together, in s."""
        low, high = self.settings.window_steps
        return len(rows) * (high - low) * self.settings.step

    def errors_of_the_start(self, values: dict[str, float]) -> dict[str, float]:
        """Standard error of each value due to the sampling error of an adapted x(0), which is the same for all paths.

        An x(0) that is off by d leaves the force C d t^-alpha / Gamma(1 - alpha), here taken where the window begins.
        By simulation it moves mean, impact rate and speeds by less than that over Omega^2, relative to the root mean
        square displacement, and energies by less than half of it (at alpha = 0.1, c = 1: 0.47 of it for the rate, 0.2
        for <v^2>).
        """
        if isinstance(self.problem, System):
            return errors_of_the_start_of_system(self.problem, self.scales, self.settings, self.adapted, values)
        order, frequency = self.oscillator.springpot.order, self.oscillator.natural_frequency
        error = None if self.adapted is None else self.adapted.error
        if error is None or order == 1.0 or not error > 0.0:
            return dict.fromkeys(values, 0.0)
        fading = max(frequency * self.settings.window[0], 1.0) ** -order / math.gamma(1.0 - order)
        share = float(error * self.oscillator.dimensionless_coefficient * fading)
        energies = {name for name in values if name.startswith(("x_mean_square", "v_", "amplitude", "springpot"))}
        errors = {name: (0.5 if name in energies else 1.0) * share * abs(value) for name, value in values.items()}
        size = math.sqrt(values["x_mean_square"])
        errors |= dict.fromkeys(("x_mean", "x_mean_end"), share * size)
        errors["springpot_force_mean"] = share * frequency**2 * size
        errors["energy_residual"] = 0.0
        return errors


def simulation_of(
    problem: Oscillator | System, settings: Settings, adapted: Adapted | None = None, *, halved: bool = False
) -> Simulation:
    """Prepare a simulation; ``adapted`` gives x(0) of a stationary start, ``halved`` is as in `compose`."""
    if adapted is not None:
        settings = replace(settings, initial_position=adapted.position)
    scales = scales_of_problem(problem)
    return Simulation(problem, settings, scales, compose(problem, settings, scales, halved=halved), adapted)


def _part_of(start: Start, states: Floats, some: slice) -> Start:
    """The start of some paths."""
    return start._replace(states=states[some] if len(states) > 1 else states)


def _blocks_of_a_call(settings: Settings, blocks: int) -> int:
    """How many short blocks share a call: each takes 0.1 ms of Python, in which no other thread computes."""
    return max(1, min(_STEPS_OF_A_CALL // settings.steps, blocks // (8 * settings.threads)))


def _room(observer: Observer, blocks: int) -> Floats:
    """The array for the results of an observer from all blocks."""
    if observer.per_path:
        return np.empty((blocks * LANES, observer.initial.size // LANES))
    return np.zeros((min(blocks, BATCHES), observer.initial.size))


def _addresses(observers: Sequence[Observer], arrays: Sequence[Floats]) -> Observers:
    """The observers in the form that the kernel takes: addresses."""

    def numbers(values: Iterable[int]) -> npt.NDArray[np.int64]:
        return np.fromiter(values, np.int64)

    return Observers(
        on_steps=numbers(0 if o.on_steps is None else o.on_steps.address for o in observers),
        on_impacts=numbers(0 if o.on_impacts is None else o.on_impacts.address for o in observers),
        place=numbers(array.ctypes.data for array in arrays),
        every=numbers(o.every for o in observers),
    )
