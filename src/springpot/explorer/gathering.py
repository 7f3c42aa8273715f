"""An ensemble that grows block by block, and ends as the very numbers of `springpot.simulate`."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import cfunc

from springpot.oscillator import Oscillator
from springpot.simulation.adapted import Adapted
from springpot.simulation.compose import mirror, tables
from springpot.simulation.distributions import Distribution, distributions_in, sketches
from springpot.simulation.ensemble import advance
from springpot.simulation.forgetting import is_stationary
from springpot.simulation.kernel import COLUMNS
from springpot.simulation.lanes import FAST, GROUP, LANES
from springpot.simulation.listening import HEADER, WATCH, Observer
from springpot.simulation.run import measured
from springpot.simulation.scales import energy_time, fastest_rate
from springpot.simulation.settings import Settings
from springpot.simulation.warnings import about_slow_impacts, doubts

__all__ = ["BINS", "Gathering", "growth_times"]

BINS = 160  # of time, in which <A^2> is averaged
SHOWN_RELAXATIONS = 6.0  # of the transient
AT_ONCE = 0.03  # s of work between two looks at what else is to be done
MOST_BLOCKS = 64  # at once: each then has a row of its own in what is observed

Floats = npt.NDArray[np.float64]


def growth_times(oscillator: Oscillator, settings: Settings) -> Floats:
    """Middles of the BINS of time over which the transient is shown, in s."""
    steps = _growth_steps(oscillator, settings)
    edges = np.ceil(np.arange(BINS + 1) * steps / BINS)
    return np.asarray(0.5 * (edges[1:] + edges[:-1] + 1.0) * settings.step)


def _growth_steps(oscillator: Oscillator, settings: Settings) -> int:
    shown = max(SHOWN_RELAXATIONS * energy_time(oscillator), 15.0 / oscillator.natural_frequency)
    return max(min(settings.steps, int(min(shown / settings.step, 1e9))), min(BINS, settings.steps))


@cache
def _growth_part() -> Any:
    first = len(HEADER)
    length, frequency, lanes = HEADER.index("length"), HEADER.index("frequency"), HEADER.index("lanes")

    def watch(x: Any, v: Any, step: Any, n: Any, low: Any, high: Any, array: Any) -> None:
        for j in range(GROUP):
            if low <= n + j < high:
                total = 0.0
                for lane in range(int(array[lanes])):
                    reach = v[j * LANES + lane] / array[frequency]
                    total += x[j * LANES + lane] ** 2 + reach * reach
                array[first + (n + j) * BINS // high] += array[length] ** 2 * total

    return cfunc(WATCH, **FAST)(watch)


class Gathering:
    """Paths of one oscillator, simulated a few blocks at a time.

    The paths are those of `springpot.simulate` with the same settings, bit for bit, and so are the numbers once all
    paths are there.

    Parameters
    ----------
    oscillator : Oscillator
    settings : Settings
        Completed, with an adapted start's x(0).
    adapted : Adapted, optional
        Where x(0) comes from.

    Examples
    --------
    >>> from springpot import Oscillator
    >>> from springpot.simulation.settings import resolve
    >>> oscillator = Oscillator()
    >>> gathering = Gathering(oscillator, resolve(oscillator, paths=128, duration=10.0, step=0.02, start="rest"))
    >>> while not gathering.complete:
    ...     gathering.grow()
    >>> gathering.estimates()[0]["x_mean"] > 0.0
    True
    """

    def __init__(self, oscillator: Oscillator, settings: Settings, adapted: Adapted | None = None) -> None:
        self.oscillator, self.settings, self.adapted = oscillator, settings, adapted
        self.made = tables(oscillator, settings)
        self.paths = 0  # so far
        self.seconds = 0.0  # of work
        self._rows = np.empty((settings.paths, len(COLUMNS)))
        self._sketch = sketches(GROUP * settings.step * fastest_rate(oscillator))
        self._counts = np.zeros((1, self._sketch.initial.size))
        steps = _growth_steps(oscillator, settings)
        self._early = replace(settings, duration=steps * settings.step, window=(0.0, steps * settings.step))
        self._growth = Observer(_growth_part(), None, np.zeros(BINS), per_path=False)
        self._per_bin = np.bincount(np.arange(steps) * BINS // steps, minlength=BINS)
        self._sums, self._squares, self._batches = np.zeros(BINS), np.zeros(BINS), 0
        self._blocks = 1

    @property
    def complete(self) -> bool:
        """Whether all paths are there."""
        return self.paths >= self.settings.paths

    @property
    def stationary(self) -> bool:
        """Whether its averages are those of the stationary state, which theory describes."""
        return is_stationary(self.oscillator, self.settings)

    def grow(self) -> None:
        """Simulate a few more blocks, about so many as take AT_ONCE."""
        begun = time.perf_counter()
        settings = self.settings
        count = min(self._blocks * LANES, settings.paths - self.paths)
        found = advance(
            self.oscillator,
            replace(settings, paths=count, record=0),
            self.made,
            skipped=self.paths,
            observers=(self._sketch,),
        )
        self._rows[self.paths : self.paths + count] = found.rows
        self._counts[0] += found.observed[0].sum(axis=0)
        self._watch_growth(count)
        self.paths += count
        spent = time.perf_counter() - begun
        self.seconds += spent
        fitting = self._blocks * AT_ONCE / max(spent, 1e-6)
        self._blocks = max(1, min(MOST_BLOCKS, 2 * self._blocks, int(fitting)))

    def _watch_growth(self, count: int) -> None:
        """The first time of the same paths once more, watched from t = 0 on: rows take averages in the window only."""
        full = count // LANES * LANES or count
        found = advance(
            self.oscillator,
            replace(self._early, paths=full, record=0),
            self.made,
            skipped=self.paths,
            observers=(self._growth,),
        )
        means = found.observed[0] / (np.maximum(self._per_bin, 1) * min(full, LANES))
        self._sums += means.sum(axis=0)
        self._squares += (means**2).sum(axis=0)
        self._batches += len(means)

    def estimates(self) -> tuple[dict[str, float], dict[str, float]]:
        """Values and standard errors of the paths so far, by name."""
        return measured(self.oscillator, self.settings, self.made, self._rows[: self.paths], self.adapted)

    def warnings(self) -> tuple[str, ...]:
        """One sentence for each reason to doubt a number, as a run has them."""
        values, errors = self.estimates()
        return (
            *doubts(self.oscillator, self.settings, self.adapted, values, errors, self._rows[: self.paths]),
            *about_slow_impacts(self.oscillator, self.settings, values),
        )

    def distributions(self) -> dict[str, Distribution]:
        """Distributions over the window, of the paths so far."""
        return distributions_in(
            self._counts,
            length=self.made.length,
            speed=self.made.length / self.made.time,
            sign=mirror(self.oscillator),
            wall=0.0 if self.oscillator.barrier is None else self.oscillator.barrier.position,
        )

    def growth(self) -> tuple[Floats, Floats]:
        """<A^2> in each of BINS of time since the start, and its standard error (NaN while there is one block)."""
        n = self._batches
        mean = self._sums / n
        if n < 2:
            return mean, np.full(BINS, np.nan)
        return mean, np.sqrt(np.maximum(self._squares / n - mean**2, 0.0) / (n - 1))
