"""Runs of models at places between the bounds of their free numbers, and surfaces through them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

import numpy as np

from springpot.designing.quantities import if_allowed
from springpot.designing.surfaces import Surface, places, surface_through
from springpot.fitting.likelihood import Coordinates, inverse
from springpot.fitting.simulated_moments import Case, Moments, case_of, groups_of, moments_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, Stopped, listed
from springpot.machine.progress import Estimate, FractionDone
from springpot.simulation.paths.simulation import Progress

MOST_PATHS = 65536
MOST_SHARE = 0.1  # by which the simulation may enlarge the errors of the numbers
_ROUGH_PATHS = 1024
_FEWEST_PATHS = 1024
_FEW_PATHS = 512  # to see whether a number changes anything


class Reporter:
    """How far the work is, for whoever waits; and whether it is to stop.

    Parameters
    ----------
    progress : callable or None
    stop : callable or None
        Tells whether to stop.
    """

    def __init__(self, progress: Progress | None, stop: Callable[[], bool] | None) -> None:
        self._progress, self._stop = progress, stop
        self._done: float = 0.0  # with an estimate of the time, as soon as there is one

    def check(self, _: float = 0.0) -> None:
        """Called again and again by what works.

        Raises
        ------
        Stopped
            If it is to stop.
        """
        if self._stop is not None and self._stop():
            raise Stopped("the fit was stopped before it had found anything.")
        if self._progress is not None:  # Ctrl-C comes through it
            self._progress(self._done)

    def rough_run(self) -> None:
        """One more run that leads to the last ones; all of them are a quarter of the whole."""
        self._done = max(self._done, min(0.25, self._done + 0.002))
        self.check()

    def last_run(self, fraction: float, steps: float, seconds_per_step: float) -> None:
        """The share of the last runs that is done; their time is known before."""
        left = (1.0 - fraction) * steps * seconds_per_step
        done = max(float(self._done), 0.25 + 0.75 * fraction)
        self._done = FractionDone(done, Estimate(steps, left, "the runs of the last surface", math.nan))
        self.check()

    def end(self) -> None:
        """All is done."""
        if self._progress is not None:
            self._progress(1.0)


class SimulatedRuns:
    """Runs of all models at places between the bounds, and what they have taken so far.

    Parameters
    ----------
    cases : sequence of Case
    own : Coordinates
        Of the free numbers.
    seed : int
    paths : int or None
        Of each of the last runs; None: as many as the measured errors need.
    reporter : Reporter
    """

    def __init__(
        self, cases: Sequence[Case], own: Coordinates, seed: int, paths: int | None, reporter: Reporter
    ) -> None:
        self.cases, self.own, self.seed, self.wanted, self.reporter = [*cases], own, seed, paths, reporter
        self.quantiles = any(case.has_quantiles for case in cases)
        self.rough = 2 * _ROUGH_PATHS if self.quantiles else _ROUGH_PATHS
        self.data = np.concatenate([case.data.values for case in cases])
        self.errors = np.concatenate([case.data.errors for case in cases])
        self.seconds_per_step = 0.0

    def surface(self, centre: Floats, reach: Floats, known: Surface | None, paths: int, *, rough: bool) -> Surface:
        """The surface through the runs to either side of a place; ``known`` tells where each run starts.

        Raises
        ------
        ValueError
            If the model cannot be run at most places, or has no such results.
        """
        z = places(self.own.start.size, quadratic=not rough, seed=self.seed)
        u = np.clip(centre + z * reach, self.own.low, self.own.high)
        steps = len(u) * paths * sum((case.rough if rough else case.settings).steps for case in self.cases)
        begun, kept, found = time.perf_counter(), [], []
        fault: Exception | None = None
        for n, place in enumerate(u):
            if rough:
                self.reporter.rough_run()
            else:
                self.reporter.last_run(n / len(u), steps, self.seconds_per_step)
            try:
                moments = self.at(place, known, paths, rough=rough)
            except (ValueError, NotCoveredError) as error:  # a part refuses its number
                if n == 0:
                    raise
                fault = error
                continue
            if all(np.isfinite(own.values).all() for own in moments):
                kept.append(n)
                found.append(moments)
        self.seconds_per_step = (time.perf_counter() - begun) / steps
        needed = len(u) // 2 + 1
        if len(found) < needed:
            raise fault or ValueError(self._nothing(centre))
        values = np.array([np.concatenate([*(m.values for m in each), [m.mean for m in each]]) for each in found])
        samples = np.array([
            np.concatenate([*(m.samples for m in each), np.zeros((len(each[0].samples), len(each)))], axis=1)
            for each in found
        ])  # fmt: skip
        positive = (values > 0.0).all(axis=0) & np.append(self.data > 0.0, np.zeros(len(self.cases), bool))
        return surface_through(
            u[kept], values, centre, reach, form="plane" if rough else "quadratic",
            logarithmic=positive, samples=samples,
        )  # fmt: skip

    def at(self, u: Floats, known: Surface | None, paths: int, *, rough: bool = True) -> list[Moments]:
        """One run of each model; ``known`` tells where each starts."""
        named = self.own.named_at(u)
        means = [None] * len(self.cases)
        if known is not None:
            near = np.clip(u, known.centre - known.reach, known.centre + known.reach)
            means = known(near)[self.data.size :].tolist()
        groups = groups_of(paths, quantiles=self.quantiles)
        return [moments_of(case, named, paths, groups, mean, rough=rough, progress=self.reporter.check)
                for case, mean in zip(self.cases, means, strict=True)]  # fmt: skip

    def differs(self, u: Floats, base: Sequence[Moments]) -> bool:
        """Whether runs at a place differ from others; if the model cannot be there, they do."""
        there = if_allowed(lambda: self.shortest_runs(u))
        return there is None or not all(
            np.array_equal(a.values, b.values, equal_nan=True) for a, b in zip(base, there, strict=True)
        )

    def shortest_runs(self, u: Floats) -> list[Moments]:
        """Runs of as few paths as there can be."""
        return self.at(u, None, self.rough if self.quantiles else _FEW_PATHS)

    def _nothing(self, centre: Floats) -> str:
        """Which statistic has no value."""
        found = self.at(centre, None, self.rough)
        missing = [
            name for case, own in zip(self.cases, found, strict=True)
            for name, value in zip(case.data.names, own.values.tolist(), strict=True) if not math.isfinite(value)
        ]  # fmt: skip
        where = ", ".join(f"{name} = {value:.6g}" for name, value in self.own.named_at(centre).items())
        return f"model must have a finite {listed(missing or ['result'])} near {where}: there it has none."

    def restart(self, u: Floats) -> None:
        """Steps, durations and starts for these numbers."""
        named = self.own.named_at(u)
        self.cases = [
            case_of((own.system, own.data), named, own.settings.seed, own.settings.threads, self.reporter.check)
            for own in self.cases
        ]

    def steps(self, u: Floats) -> float:
        """Of one path of every model there; infinite where a model cannot be run."""
        named = self.own.named_at(u)
        found = if_allowed(lambda: float(sum(case.steps_at(named) for case in self.cases)))
        return math.inf if found is None else found

    def misfit(self, u: Floats) -> float:
        """Of one rough run, see `misfit_of`."""

        def moments() -> list[Moments]:
            self.restart(u)
            return self.at(u, None, self.rough // 2)

        if (found := if_allowed(moments)) is None:
            return math.inf
        misfit = misfit_of(np.concatenate([own.values for own in found]), self.data, self.errors)
        return misfit if math.isfinite(misfit) else math.inf

    def paths(self, surface: Surface, u: Floats, measured: Floats) -> int:
        """So many that the runs enlarge the errors of the numbers by a twentieth: a power of two.

        The other half of `MOST_SHARE` is for the slopes, and for what the surface leaves of the runs.
        """
        if self.wanted is not None:
            return self.wanted
        n = self.data.size
        slope, simulated = surface.slope(u)[:n], surface.covariance(u)[:n, :n]

        def spread(whole: Floats) -> Floats:
            return np.sqrt(np.diag(inverse(slope.T @ np.linalg.solve(whole, slope))))

        paths = (4 if self.quantiles else 1) * _FEWEST_PATHS
        while paths < MOST_PATHS:
            whole = measured + simulated * self.rough / paths
            if (spread(whole) <= (1.0 + 0.5 * MOST_SHARE) * spread(measured)).all():
                break
            paths *= 2
        return paths


def misfit_of(values: Floats, data: Floats, errors: Floats) -> float:
    """A sum of squares in measured errors with a tenth of the values added: what is far off does not outweigh all.

    Examples
    --------
    >>> misfit_of(np.array([2.0, 1.0]), np.array([1.0, 1.0]), np.array([0.0, 0.1]))
    100.0
    """
    return float((((values - data) / np.hypot(errors, 0.1 * np.abs(data))) ** 2).sum())
