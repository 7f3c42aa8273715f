"""An ensemble that grows block by block; its final numbers are those of `springpot.simulate`, bit for bit."""

from __future__ import annotations

import math
import time
from functools import cache
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.simulation.estimate.samples import estimates_of, watched
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.outputs import MOST_OUTPUTS
from springpot.simulation.kernel.sizes import GROUP, LANES
from springpot.simulation.kernel.watching import BATCHES, ON_STEPS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.plan.plan import Plan
from springpot.simulation.result.warnings import doubts
from springpot.simulation.watch.distributions import Distribution, Sketch
from springpot.simulation.watch.extremes import Extremes

BINS = 160  # of time, in which <A^2> is averaged
SHOWN_RELAXATIONS = 6.0  # of the transient
AT_ONCE = 0.03  # s of work per call of `grow`
FAST = 0.99  # share of the impacts that are slower than the speed that is shown
MOST_BLOCKS = 64  # per call: each has its own row in the observer's result


def growth_times(plan: Plan) -> Floats:
    """Centres of the BINS of time over which the transient is shown, in s."""
    steps = _growth_steps(plan)
    edges = np.ceil(np.arange(BINS + 1) * steps / BINS)
    return np.asarray(0.5 * (edges[1:] + edges[:-1] + 1.0) * plan.settings.step)


def _growth_steps(plan: Plan) -> int:
    scales, settings = plan.motion.scales, plan.settings
    if plan.motion.ends:  # the whole of a record, or of an envelope
        return settings.steps
    shown = max(SHOWN_RELAXATIONS * scales.energy_time, 15.0 / scales.frequency)
    return max(min(settings.steps, int(min(shown / settings.step, 1e9))), min(BINS, settings.steps))


_LAYOUT = layout(x_squares=BINS, v_squares=BINS)


@cache
def _growth_part() -> Any:
    length, speed, lanes, x_first, v_first = begins(_LAYOUT, "length", "speed", "lanes", "x_squares", "v_squares")

    def on_steps(x: Any, v: Any, step: Any, n: Any, low: Any, high: Any, array: Any) -> None:
        for j in range(GROUP):
            if low <= n + j < high:
                x_squares, v_squares = 0.0, 0.0
                for lane in range(int(array[lanes])):
                    x_squares += x[j * LANES + lane] ** 2
                    v_squares += v[j * LANES + lane] ** 2
                at = (n + j) * BINS // high
                array[x_first + at] += array[length] ** 2 * x_squares
                array[v_first + at] += array[speed] ** 2 * v_squares

    return callback(ON_STEPS)(on_steps)


class Gathering:
    """Paths of one problem, simulated a few blocks at a time.

    Paths, and the numbers of all paths, are those of `springpot.simulate` with the same settings, bit for bit.

    Parameters
    ----------
    simulation : Simulation
    speeds : float
        What v^2 is multiplied with in the mean over time of x^2 + speeds v^2: 1 / Omega^2 for <A^2>, 0 for <x^2>.

    Examples
    --------
    >>> from springpot import Dashpot, Spring, System, WhiteNoise
    >>> from springpot.simulation.plan.plan import plan_of
    >>> from springpot.simulation.paths.simulation import simulation_of
    >>> system = System(Spring(1.0), Dashpot(0.5), WhiteNoise(1.0))
    >>> gathering = Gathering(simulation_of(plan_of(system, paths=128, duration=10.0, step=0.02, start="rest")))
    >>> while not gathering.complete:
    ...     gathering.grow()
    >>> gathering.estimates()[0]["x_mean_square"] > 0.5
    True
    """

    def __init__(self, simulation: Simulation, *, speeds: float = 0.0) -> None:
        self.simulation, settings = simulation, simulation.settings
        self.paths = 0  # so far
        self.seconds = 0.0  # of work
        self._rows = np.empty((settings.paths, len(simulation.parts.columns)))
        motion = simulation.motion
        moving = [signal for signal in motion.signals if "x" in signal.names]
        self._sketches = [Sketch.of(each, motion, settings) for each in motion.signals]
        self._counts = [dict[str, Floats]() for _ in self._sketches]
        shown = [*motion.outputs.items()][:MOST_OUTPUTS]
        outputs = [name for name, one in shown if name.endswith("acceleration") and not one.reason]
        self._accelerations = [Extremes.of(motion.signal_by_name(name, "forces")) for name in outputs]
        self._largest = np.empty((len(outputs), settings.paths))
        steps = _growth_steps(simulation.plan)
        self._early = simulation.but(duration=steps * settings.step, window=(0.0, steps * settings.step), record=0)
        self._speeds = speeds
        self._growth = [
            Observer(each, _growth_part(), None, np.zeros((), _LAYOUT), of_blocks=("x_squares", "v_squares"))
            for each in moving
        ]
        self._per_bin = np.bincount(np.arange(steps) * BINS // steps, minlength=BINS)
        self._sums, self._squares, self._batches = *np.zeros((2, len(moving), BINS)), 0
        self._blocks = 1

    @property
    def complete(self) -> bool:
        """Whether all paths are simulated."""
        return self.paths >= self.simulation.settings.paths

    @property
    def stationary(self) -> bool:
        """Whether the averages are stationary, as in the theory."""
        return self.simulation.plan.is_stationary

    def grow(self) -> None:
        """Simulate a few more blocks, for about AT_ONCE seconds."""
        begun = time.perf_counter()
        count = min(self._blocks * LANES, self.simulation.settings.paths - self.paths)
        more = self.simulation.but(paths=count, record=0)
        watching = [each.observer for each in (*self._sketches, *self._accelerations)]
        ensemble = more.advance(skipped=self.paths, observers=watching)
        self._rows[self.paths : self.paths + count] = ensemble.rows
        for number, extremes in enumerate(self._accelerations):
            found = ensemble.observed[extremes.observer]
            largest = np.maximum(-found["x_minimum"], found["x_maximum"])
            self._largest[number, self.paths : self.paths + count] = largest
        for sketch, counts in zip(self._sketches, self._counts, strict=True):
            for name, counted in ensemble.observed[sketch.observer].items():
                rows = BATCHES if name == "impact_speed" else 1  # the only one whose quantile is shown, with its error
                kept = counts.setdefault(name, np.zeros((rows, counted.shape[1])))
                for row, batch in enumerate(counted):
                    kept[(self.paths // LANES + row) % rows] += batch
        # the beginning of the same paths once more, for averages from t = 0 on, outside the window
        full = count // LANES * LANES or count
        beginning = self._early.but(paths=full).advance(skipped=self.paths, observers=self._growth)
        grown = [beginning.observed[each] for each in self._growth]
        x_squares, v_squares = (np.array([each[name] for each in grown]) for name in ("x_squares", "v_squares"))
        means = (x_squares + self._speeds * v_squares) / (np.maximum(self._per_bin, 1) * min(full, LANES))
        self._sums += means.sum(axis=1)
        self._squares += (means**2).sum(axis=1)
        self._batches += means.shape[1]
        self.paths += count
        spent = time.perf_counter() - begun
        self.seconds += spent
        fitting = self._blocks * AT_ONCE / max(spent, 1e-6)
        self._blocks = max(1, min(MOST_BLOCKS, 2 * self._blocks, int(fitting)))

    def estimates(self) -> tuple[dict[str, float], dict[str, float]]:
        """Values and standard errors of the paths so far, by name."""
        rows = self._rows[: self.paths]
        return estimates_of(self.simulation, rows, watched(self.simulation, rows))

    def warnings(self) -> tuple[str, ...]:
        """One sentence for each reason to doubt a number, as in a run."""
        rows = self._rows[: self.paths]
        seen = watched(self.simulation, rows)
        return tuple(doubts(self.simulation, *estimates_of(self.simulation, rows, seen), rows, seen))

    def distributions(self) -> dict[str, Distribution]:
        """Distributions over the window, of the paths so far."""
        every = zip(self._sketches, self._counts, strict=True)
        found = (sketch.distributions(self.simulation, counts) for sketch, counts in every)
        return {name: distribution for one in found for name, distribution in one.items()}

    def peaks(self) -> tuple[dict[str, float], dict[str, float]]:
        """What an engineer asks first beside the moments, and its standard errors, by name.

        Of impact speeds the 99 % quantile; of accelerations, which are those between impacts on rigid walls, the mean
        over the paths of the largest in the window.
        """
        values, errors = dict[str, float](), dict[str, float]()
        for name, distribution in self.distributions().items():
            rate = f"{name.removesuffix('impact_speed')}impact_rate"
            known = distribution.size and not self.simulation.motion.uncounted_because(rate)
            if known and name.endswith("impact_speed"):
                at, error = distribution.quantile(FAST)
                values[f"{name}_quantile_{FAST}"], errors[f"{name}_quantile_{FAST}"] = float(at), float(error)
        for extremes, largest in zip(self._accelerations, self._largest[:, : self.paths], strict=True):
            name = f"{extremes.observer.signal.names['x']}_peak_mean"
            values[name], errors[name] = float(largest.mean()), float(largest.std() / math.sqrt(self.paths - 1))
        return values, errors

    def growth(self) -> tuple[Floats, Floats]:
        """<x^2 + speeds v^2> of what is seen in each of BINS of time, and its error (NaN while there is one block)."""
        n = self._batches
        mean = self._sums / n
        if n < 2:
            return mean, np.full_like(mean, np.nan)
        return mean, np.sqrt(np.maximum(self._squares / n - mean**2, 0.0) / (n - 1))
