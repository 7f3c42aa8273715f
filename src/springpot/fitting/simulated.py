"""Simulated moments: numbers of a model at which simulated statistics agree with measured ones.

Runs at places all over a region, on common random numbers, give each statistic as a smooth surface over the numbers;
the best numbers on it are found by least squares, the region moves there, and so on until it stays.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.faults import NotCovered, listed
from springpot.fitting.likelihood import Coordinates, FloatArray, LeastSquares, Table, inverse, moved
from springpot.fitting.moments import Case, Moments, case_of, groups_of, moments_of, step_biases_at
from springpot.fitting.statistics import Statistics
from springpot.fitting.surfaces import Surface, places, surface_through
from springpot.free_numbers import free_numbers
from springpot.oscillator import Oscillator
from springpot.simulation.cost import Estimate, FractionDone
from springpot.simulation.simulation import Progress
from springpot.system import System

__all__ = ["MomentsLikelihood"]

ROUGH_PATHS = 1024
FEWEST_PATHS, MOST_PATHS = 1024, 65536
MOST_SHARE = 0.1  # by which the simulation may enlarge the errors of the numbers
_ROUNDS = 15  # that follow the slope
_LAST_ROUNDS = 8  # with surfaces of the second degree
_FIRST_REACH, _MOST_REACH = 0.3, 0.3  # of a region to either side, in logarithms
_LEAST_ROUGH, _LEAST_REACH = 0.1, 0.15  # where it is narrower, the error of simulation makes the slopes uncertain
_ERRORS = 2.5  # standard errors from the centre of the last region to its ends
_INSIDE = 0.6  # of the last region: where its minimum may be
_BEYOND = 1.6  # of the last region: as far as the surface is used, four standard errors
_MOST_MISFIT, _NARROWER = 0.5, 0.6  # of an error, that a surface may be wrong by; and what follows if it is more
_MOST_BLUR = 0.8  # of the information that is seen in a direction: where the errors are no longer corrected for it
_LITTLE = 0.1  # of the sum of squares: a third of a standard error
_POOR = 1e-4  # probability of the misfit at which other starts are tried
_DRAWN, _STARTS = 24, 2


@dataclass(frozen=True, eq=False)
class _Region:
    """Where the runs of a round are."""

    centre: FloatArray
    reach: FloatArray


class _Explorer:
    """Runs of all models at places between the bounds, and what they have taken so far."""

    def __init__(
        self, cases: Sequence[Case], own: Coordinates, seed: int, paths: int | None, progress: Progress | None
    ) -> None:
        self.cases, self.own, self.seed, self.wanted, self.progress = [*cases], own, seed, paths, progress
        self.quantiles = any(case.has_quantiles for case in cases)
        self.rough = 2 * ROUGH_PATHS if self.quantiles else ROUGH_PATHS
        self.data = np.concatenate([case.data.values for case in cases])
        self.errors = np.concatenate([case.data.errors for case in cases])
        self.seconds_per_step = 0.0
        self.done = 0.0

    def surface(self, region: _Region, known: Surface | None, paths: int, *, rough: bool) -> Surface:
        """The surface through the runs of a region; ``known`` tells where each run starts.

        Raises
        ------
        ValueError
            If the model cannot be run at most places, or has no such results.
        """
        z = places(self.own.start.size, quadratic=not rough, seed=self.seed)
        u = np.clip(region.centre + z * region.reach, self.own.low, self.own.high)
        steps = len(u) * paths * sum((case.rough if rough else case.settings).steps for case in self.cases)
        begun, kept, found = time.perf_counter(), [], []
        fault: Exception | None = None
        for n, place in enumerate(u):
            self._say(n / len(u), rough, steps)
            try:
                moments = self._at(place, known, paths, rough=rough)
            except (ValueError, NotCovered) as error:  # a part refuses its number
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
            raise fault or ValueError(self._nothing(region.centre))
        values = np.array([np.concatenate([*(m.values for m in each), [m.mean for m in each]]) for each in found])
        samples = np.array([
            np.concatenate([*(m.samples for m in each), np.zeros((len(each[0].samples), len(each)))], axis=1)
            for each in found
        ])  # fmt: skip
        positive = np.asarray((values > 0.0).all(axis=0))
        positive[: self.data.size] &= self.data > 0.0
        positive[self.data.size :] = False
        return surface_through(
            u[kept], values, samples, region.centre, region.reach, quadratic=not rough, logarithmic=positive
        )

    def _at(self, u: FloatArray, known: Surface | None, paths: int, *, rough: bool = True) -> list[Moments]:
        named = self.own.named(self.own.outer(u))
        means = [None] * len(self.cases) if known is None else known(_near(known, u, 1.0))[self.data.size :].tolist()
        groups = groups_of(paths, quantiles=self.quantiles)
        progress = self.progress
        alive = None if progress is None else (lambda _: progress(self.done))  # Ctrl-C comes through it
        return [moments_of(case, named, paths, groups, mean, rough=rough, progress=alive)
                for case, mean in zip(self.cases, means, strict=True)]  # fmt: skip

    def _nothing(self, centre: FloatArray) -> str:
        """Which statistic has no value."""
        found = self._at(centre, None, self.rough)
        missing = [
            name for case, own in zip(self.cases, found, strict=True)
            for name, value in zip(case.data.names, own.values.tolist(), strict=True) if not math.isfinite(value)
        ]  # fmt: skip
        where = ", ".join(f"{name} = {value:.6g}" for name, value in self.own.named(self.own.outer(centre)).items())
        return f"model must have a finite {listed(missing or ['result'])} near {where}: there it has none."

    def restart(self, u: FloatArray) -> None:
        """Steps, durations and starts for these numbers."""
        named = self.own.named(self.own.outer(u))
        self.cases = [case.begun_at(named) for case in self.cases]

    def misfit(self, u: FloatArray) -> float:
        """The sum of squares of one rough run, in measured errors with a tenth of the values added."""
        try:
            self.restart(u)
            values = np.concatenate([own.values for own in self._at(u, None, self.rough // 2)])
        except (ValueError, NotCovered):
            return math.inf
        found = float((((values - self.data) / np.hypot(self.errors, 0.1 * np.abs(self.data))) ** 2).sum())
        return found if math.isfinite(found) else math.inf

    def paths(self, surface: Surface, u: FloatArray, measured: FloatArray) -> int:
        """So many that the simulation enlarges the errors of the numbers by a tenth at most: a power of two."""
        if self.wanted is not None:
            return self.wanted
        n = self.data.size
        slope, simulated = surface.slope(u)[:n], surface.covariance(u)[:n, :n]

        def spread(whole: FloatArray) -> FloatArray:
            return np.sqrt(np.diag(inverse(slope.T @ np.linalg.solve(whole, slope))))

        paths = (4 if self.quantiles else 1) * FEWEST_PATHS
        while paths < MOST_PATHS:
            whole = measured + simulated * self.rough / paths
            if (spread(whole) <= (1.0 + MOST_SHARE) * spread(measured)).all():
                break
            paths *= 2
        return paths

    def _say(self, fraction: float, rough: bool, steps: float) -> None:
        """The first rounds are a quarter of the whole; of the last ones the time is known before."""
        if self.progress is None:
            return
        self.done = max(self.done, 0.25 + 0.75 * fraction if not rough else min(0.25, self.done + 0.002))
        if rough or not self.seconds_per_step:
            self.progress(self.done)
            return
        left = (1.0 - fraction) * steps * self.seconds_per_step
        self.progress(FractionDone(self.done, Estimate(steps, left, "the runs of the last surface", math.nan)))


class MomentsLikelihood(LeastSquares):
    """Measured statistics beside simulated ones.

    Parameters
    ----------
    cases : sequence of (model, Statistics)
        With free numbers; those of one name are one number.
    seed : int
        Of all runs.
    paths : int or None
        Of each run of the last surface, a power of two; None: as many as the measured errors need.
    threads : int or None
    progress : callable or None

    Raises
    ------
    ValueError
        If a model has no stationary state, or not such results.

    Notes
    -----
    D. McFadden, "A method of simulated moments for estimation of discrete response models without numerical
    integration", Econometrica 57 (1989).  The weights are the inverse of the measured covariance plus that of the
    surface, which is found from the samples path by path, so that common random numbers are taken into account.
    """

    known = True
    smooth_start = True
    simulated = True

    def __init__(
        self,
        cases: Sequence[tuple[System | Oscillator, Statistics]],
        seed: int = 1,
        paths: int | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> None:
        free = tuple(free_numbers(tuple(model for model, _ in cases)).values())
        self.coordinates = Coordinates(free)
        self.size = sum(data.size for _, data in cases)
        self.said: tuple[str, ...] = ()
        if not free or self.size < len(free):
            return  # `springpot.fit` says so
        start = self.coordinates.named(np.array([float(number) for number in free]))
        begun = [case_of(model, data, start, seed, threads) for model, data in cases]
        explorer = _Explorer(begun, self.coordinates, seed, paths, progress)
        self._measured = _in_blocks([data.covariance for _, data in cases])
        self._data = explorer.data
        self._names = _labels([data.names for _, data in cases])
        self._idle(explorer)
        settled = self._search(explorer)
        self._last(explorer, settled)
        self.coordinates = Coordinates(moved(free, self.coordinates.outer(self._best)))
        self._cases = explorer.cases
        if progress is not None:
            progress(1.0)

    # -- the search -----------------------------------------------------------------------------------------------

    def _idle(self, explorer: _Explorer) -> None:
        """A number that changes nothing leaves every run as it is."""
        own = self.coordinates
        base = explorer._at(own.start, None, 64 * 8 if not explorer.quantiles else explorer.rough)
        idle = []
        for n, name in enumerate(own.names):
            u = own.start
            u[n] += 0.1 * (own.high[n] - u[n]) if own.high[n] - u[n] > u[n] - own.low[n] else 0.1 * (own.low[n] - u[n])
            try:
                there = explorer._at(u, None, 64 * 8 if not explorer.quantiles else explorer.rough)
            except (ValueError, NotCovered):
                continue
            same = [np.array_equal(a.values, b.values, equal_nan=True) for a, b in zip(base, there, strict=True)]
            if all(same):
                idle.append(name)
        if idle:
            raise ValueError(f"{listed(idle)} must not be free: such data do not depend on it.")

    def _search(self, explorer: _Explorer) -> FloatArray:
        """Rounds from the start; from other places too if the misfit stays large."""
        from scipy import stats

        own = self.coordinates
        best = self._rounds(explorer, own.start)
        spare = max(self.size - len(own.free), 1)
        if stats.chi2.sf(best[0], spare) > _POOR:
            return best[1]
        from scipy.stats import qmc

        drawn = qmc.LatinHypercube(own.start.size, rng=np.random.default_rng(explorer.seed)).random(_DRAWN)
        begins = [own.low + place * (own.high - own.low) for place in drawn]
        fits = [explorer.misfit(u) for u in begins]
        for n in np.argsort(fits)[:_STARTS]:
            if not math.isfinite(fits[n]):
                continue
            try:
                explorer.restart(begins[n])
                found = self._rounds(explorer, begins[n])
            except (ValueError, NotCovered):
                continue
            best = min(best, found, key=lambda each: each[0])
        self._use(best[2], 1.0, best[1])
        return best[1]

    def _rounds(self, explorer: _Explorer, begin: FloatArray) -> tuple[float, FloatArray, Surface]:
        """Along the slope, until the minimum is inside a region as wide as the errors; the sum of squares there."""
        own, u = self.coordinates, begin
        reach = self._reach(np.full(u.size, math.inf), _LEAST_ROUGH, _FIRST_REACH)
        surface: Surface | None = None
        for number in range(_ROUNDS):
            surface = explorer.surface(_Region(u, reach), surface, explorer.rough, rough=True)
            self._use(surface, 1.0)
            before, u = u, self._minimum(u)
            self._use(surface, 1.0, u)
            ended = (np.abs(u - before) < 0.9 * reach) | (u == own.low) | (u == own.high)
            if ended.all() or self._gain(before, u) < _LITTLE:
                wanted = self._reach(self._errors_at(u), _LEAST_ROUGH, _FIRST_REACH)
                if (reach <= 1.3 * wanted).all():
                    break
                reach = np.minimum(reach, wanted)
            if number % 4 == 3:  # the scales of the problem have changed
                explorer.restart(u)
                surface = None
        left = self._data - self._surface(u)[: self.size]
        whole = self._measured + self._simulated + np.diag(self._misfit(u) ** 2)
        return float(left @ np.linalg.solve(whole, left)), u, self._surface

    def _gain(self, before: FloatArray, u: FloatArray) -> float:
        """By how much the sum of squares is less: little where the data tell nothing about the way that was gone."""
        own = self.coordinates
        return self.deviance(own.outer(before)) - self.deviance(own.outer(u))

    def _errors_at(self, u: FloatArray) -> FloatArray:
        """Standard errors of the coordinates."""
        return np.sqrt(np.diag(self.covariance(self.coordinates.outer(u), np.ones(u.size, bool))))

    def _reach(self, errors: FloatArray, least: float, most: float) -> FloatArray:
        """How far a region goes to either side: some errors, neither too near nor too far."""
        own = self.coordinates
        width = np.where(own.logarithmic, 1.0, own.high - own.low)
        reach = np.clip(_ERRORS * errors, least * width, most * width)
        return np.minimum(reach, 0.25 * (own.high - own.low))

    def _last(self, explorer: _Explorer, u: FloatArray) -> None:
        """Surfaces of the second degree, as wide as the errors are."""
        own = self.coordinates
        paths = explorer.paths(self._surface, u, self._measured)
        explorer.restart(u)
        known, width = self._surface, 1.0
        for _ in range(_LAST_ROUNDS):
            reach = width * self._reach(self._errors_at(u), _LEAST_REACH, _MOST_REACH)
            known = explorer.surface(_Region(u, reach), known, paths, rough=False)
            self._use(known, _BEYOND)
            before, u = u, self._minimum(u)
            self._use(known, _BEYOND, u)
            free = (u > own.low) & (u < own.high)
            settled = bool((np.abs(u - before)[free] < _INSIDE * reach[free]).all()) or self._gain(before, u) < _LITTLE
            right = bool((self._misfit(u) <= _MOST_MISFIT * self._spread).all())
            sharp = self._blur(u) <= 1.0 + MOST_SHARE
            more = not sharp and explorer.wanted is None and paths < MOST_PATHS
            if settled and right and not more:
                break
            width = width if right else _NARROWER * width
            paths = 2 * paths if more else paths
        self._best, self.paths = u, paths
        if not settled:
            self.said = ("The search did not settle: start it nearer, or narrow the bounds.",)
        elif not right:
            self.said = ("The surface through the runs is not right near the result: narrow the bounds.",)
        elif not sharp:
            self.said = ("The slopes of the simulated statistics are uncertain: give more paths.",)

    def _misfit(self, u: FloatArray) -> FloatArray:
        """How far runs are off the surface, in the units of the statistics."""
        n, surface = self.size, self._surface
        return np.asarray(surface.misfit[:n] * np.where(surface.logarithmic[:n], surface(u)[:n], 1.0))

    def _blur(self, u: FloatArray) -> float:
        """How much the uncertain slopes enlarge the errors: of the number that has it worst."""
        every = np.ones(u.size, bool)
        theta = self.coordinates.outer(u)
        plain = super().covariance(theta, every)
        return float(np.sqrt(np.max(np.diag(self.covariance(theta, every)) / np.diag(plain))))

    def covariance(self, theta: FloatArray, moves: NDArray[np.bool_]) -> FloatArray:
        """With the error of the slopes, which makes the information of the data look larger than it is.

        With slopes J + e and weights W the estimates solve (J + e)' W (...) = 0; the information is
        J' W J = (J + e)' W (J + e) - E[e' W e], and the covariance of the score is the first of these terms.
        """
        own = (self.sensitivity(theta) * self.coordinates.slope(theta))[:, moves]
        errors = self._surface.slope_samples(self.coordinates.inner(theta))[:, : self.size][..., moves]
        errors = np.einsum("ij,gjk->gik", self._root, errors)
        seen, excess = own.T @ own, np.einsum("gia,gib->ab", errors, errors)
        # in directions in which the data tell nothing, the excess may be all that is seen
        root = np.linalg.cholesky(inverse(seen))
        shares, turn = np.linalg.eigh(root.T @ excess @ root)
        root = root @ turn / (1.0 - np.minimum(shares, _MOST_BLUR))
        return np.asarray(root @ root.T)

    def _minimum(self, u: FloatArray) -> FloatArray:
        every = np.ones(u.size, bool)
        return self.solve(self.solve(u, every), every)

    def _use(self, surface: Surface, far: float, u: FloatArray | None = None) -> None:
        """Take a surface, with the weights at a place."""
        self._surface, self._far = surface, far
        at = surface.centre if u is None else u
        n = self.size
        self._simulated = surface.covariance(at)[:n, :n]
        whole = self._measured + self._simulated
        self._spread = np.sqrt(np.diag(whole))
        self._root = np.linalg.inv(np.linalg.cholesky(whole))

    def limits(self) -> tuple[FloatArray, FloatArray]:
        """As far as the surface is used."""
        own, surface = self.coordinates, self._surface
        reach = self._far * surface.reach
        return np.maximum(own.low, surface.centre - reach), np.minimum(own.high, surface.centre + reach)

    # -- what every likelihood answers ----------------------------------------------------------------------------

    def _expected(self, theta: FloatArray) -> FloatArray:
        return self._surface(self.coordinates.inner(theta))[: self.size]

    def residuals(self, theta: FloatArray) -> FloatArray:
        """Differences, made independent with unit variance."""
        return np.asarray(self._root @ (self._data - self._expected(theta)))

    def sensitivity(self, theta: FloatArray) -> FloatArray:
        """Change of the expected statistics, as the residuals are."""
        slope = self._surface.slope(self.coordinates.inner(theta))[: self.size]
        return np.asarray(self._root @ (slope / self.coordinates.slope(theta)))

    def checks(self, theta: FloatArray, moving: int) -> dict[str, tuple[float, str]]:
        """The J-test: the size of the residuals, where there are more statistics than numbers."""
        from scipy import stats

        spare = self.size - moving
        if spare < 1:
            return {}
        meaning = "the model misses more than the stated errors explain"
        return {"size of the residuals (J-test)": (float(stats.chi2.sf(self.deviance(theta), spare)), meaning)}

    def doubts(self, theta: FloatArray) -> tuple[str, ...]:
        """About the simulation: its errors, its step, and whether the search came to an end."""
        said = [*self.said]
        measured = np.diag(self._measured)
        large = np.diag(self._simulated) > measured
        if large.any():
            names = listed([name for name, own in zip(self._names, large, strict=True) if own])
            said.append(f"The simulation's error of {names} is larger than the measured one: give more paths.")
        expected, at, named = self._expected(theta), 0, self.coordinates.named(theta)
        for case in self._cases:
            own = dict(zip(case.data.names, expected[at : at + case.data.size].tolist(), strict=True))
            spread = dict(zip(case.data.names, self._spread[at : at + case.data.size].tolist(), strict=True))
            at += case.data.size
            speed = own.get("impact_speed_mean_square", own.get("impact_speed_mean", 0.0) ** 2 * math.pi / 2.0)
            values = {"impact_rate": 1.0, "impact_speed_mean": 1.0, "impact_speed_mean_square": speed, **own}
            for name, bias in step_biases_at(case, named, values).items():
                if name in own and bias > 0.3 * spread[name]:
                    said.append(
                        f"The step's bias of {name} may be {bias:.2g}, beside an error of {spread[name]:.2g}: "
                        "slow impacts on a lossy wall are missed."
                    )
        return tuple(said)

    def table(self, theta: FloatArray) -> Table:
        """Statistic by statistic."""
        expected = self._expected(theta)
        return Table(
            "statistic", "1", np.arange(1.0, self.size + 1.0), np.array(self._names), self._data, expected,
            (self._data - expected) / self._spread, self._spread,
        )  # fmt: skip


def _near(surface: Surface, u: FloatArray, far: float) -> FloatArray:
    """The nearest place in the surface's region."""
    return np.clip(u, surface.centre - far * surface.reach, surface.centre + far * surface.reach)


def _in_blocks(matrices: Sequence[FloatArray]) -> FloatArray:
    from scipy.linalg import block_diag

    return np.asarray(block_diag(*matrices))


def _labels(names: Sequence[tuple[str, ...]]) -> list[str]:
    """Names of statistics, with the number of the data set where there are several.

    Examples
    --------
    >>> _labels([("x_mean",), ("x_mean", "v_rms")])
    ['1: x_mean', '2: x_mean', '2: v_rms']
    """
    if len(names) == 1:
        return [*names[0]]
    return [f"{place}: {name}" for place, own in enumerate(names, start=1) for name in own]
