"""The search for the numbers at which simulated statistics agree with measured ones.

Runs at places all over a region, on common random numbers, give each statistic as a smooth surface over the numbers;
the best numbers on it are found by least squares, the region moves there, and so on until it stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springpot.designing.surfaces import Surface
from springpot.fitting.likelihood import Coordinates, How
from springpot.fitting.simulated_likelihood import MomentsLikelihood, StackedStatistics
from springpot.fitting.simulated_moments import Measured, case_of
from springpot.fitting.simulated_runs import MOST_PATHS, MOST_SHARE, Reporter, SimulatedRuns
from springpot.fitting.simulated_starts import other_starts
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, Stopped, listed
from springpot.problem.free_numbers import with_values
from springpot.simulation.plan.options import own_seed

_ROUNDS = 15  # that follow the slope
_LAST_ROUNDS = 8  # with surfaces of the second degree
_FIRST_REACH, _MOST_REACH = 0.3, 0.3  # of a region to either side, in logarithms
_LEAST_ROUGH, _LEAST_REACH = 0.1, 0.15  # where it is narrower, the error of simulation makes the slopes uncertain
_ERRORS = 2.5  # standard errors from the centre of the last region to its ends
_INSIDE = 0.6  # of the last region: where its minimum may be
_BEYOND = 1.6  # of the last region: as far as the surface is used, four standard errors
_MOST_MISFIT, _NARROWER = 0.5, 0.6  # of an error, that a surface may be wrong by; and what follows if it is more
_LITTLE = 0.1  # of the sum of squares: a third of a standard error
_POOR = 1e-4  # probability of the misfit at which other starts are tried
_STARTS = 2


def search_by_simulation(cases: Sequence[Measured], how: How) -> MomentsLikelihood:
    """The likelihood of statistics on the last surface, which starts at its minimum.

    Parameters
    ----------
    cases : sequence of (System, MeasuredStatistics)
        With free numbers; those of one name are one number.
    how : How
        ``paths`` are those of each run of the last surface, a power of two; None: as many as the measured errors need.

    Raises
    ------
    ValueError
        If a model has no stationary state, or not such results.
    Stopped
        If it was stopped before there was a surface.
    """
    coordinates, reporter = Coordinates.of(tuple(system for system, _ in cases)), Reporter(how.progress, how.stop)
    start = coordinates.named(coordinates.given)
    seeds = [
        own_seed(how.seed, {"case": n, **with_values(system, start).to_dict()}) for n, (system, _) in enumerate(cases)
    ]
    begun = [case_of(case, start, own, how.threads, reporter.check) for case, own in zip(cases, seeds, strict=True)]
    measured = StackedStatistics.of([data for _, data in cases])
    search = _Search(SimulatedRuns(begun, coordinates, how.seed, how.paths, reporter), measured)
    try:
        search.check_influence()
        search.lead()
        search.finish()
    except Stopped:
        if search.best is None:
            raise
        search.warnings = ("The fit was stopped: these are the best numbers so far.",)
    best = search.best
    assert best is not None
    if not search.warnings:
        reporter.end()
    return MomentsLikelihood(
        coordinates.moved(coordinates.outer(best.u)), search.measured, best.likelihood.surface, best.far, best.u,
        search.runs.cases, search.warnings, last=True,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Place:
    """Where a search stands: the best numbers on a surface."""

    likelihood: MomentsLikelihood
    u: Floats
    far: float

    @property
    def chi_square(self) -> float:
        return self.likelihood.chi_square(self.u)


class _Search:
    """Rounds of runs and of least squares; ``best`` is where it stands, and what a search that is stopped gives."""

    def __init__(self, runs: SimulatedRuns, measured: StackedStatistics) -> None:
        self.runs, self.measured, self.own = runs, measured, runs.own
        self.best: _Place | None = None
        self.warnings: tuple[str, ...] = ()

    def check_influence(self) -> None:
        """A number that changes nothing leaves every run as it is.

        Raises
        ------
        ValueError
            If there is one.
        """
        own, idle = self.own, []
        base = self.runs.shortest_runs(own.start)
        for n, name in enumerate(own.names):
            u = own.start
            u[n] += 0.1 * (own.high[n] - u[n]) if own.high[n] - u[n] > u[n] - own.low[n] else 0.1 * (own.low[n] - u[n])
            if not self.runs.differs(u, base):
                idle.append(name)
        if idle:
            raise ValueError(f"{listed(idle)} must not be free: such data do not depend on it.")

    def lead(self) -> None:
        """Rounds from the start; from other places too if the misfit stays large."""
        from scipy import stats

        runs, own = self.runs, self.own
        first = self._rounds(own.start)
        spare = max(self.measured.values.size - len(own.free), 1)
        if stats.chi2.sf(first.chi_square, spare) > _POOR:
            return
        found = [first]
        try:
            for u in other_starts(runs, first.u)[:_STARTS]:
                try:
                    runs.restart(u)
                    found.append(self._rounds(u))
                except (ValueError, NotCoveredError):
                    continue
        finally:  # also if it is stopped
            self.best = min([*found, self.best or first], key=lambda each: each.chi_square)

    def _rounds(self, begin: Floats) -> _Place:
        """Along the slope, until the minimum is inside a region as wide as the errors."""
        runs, own, u = self.runs, self.own, begin
        reach = self._reach(np.full(u.size, math.inf), _LEAST_ROUGH, _FIRST_REACH)
        surface: Surface | None = None
        for number in range(_ROUNDS):
            surface = runs.surface(u, reach, surface, runs.rough, rough=True)
            before, place = u, self._stand(surface, 1.0, u)
            u = place.u
            ended = (np.abs(u - before) < 0.9 * reach) | (u == own.low) | (u == own.high)
            if ended.all() or self._gain(place, before) < _LITTLE:
                wanted = self._reach(place.likelihood.errors_at(u), _LEAST_ROUGH, _FIRST_REACH)
                if (reach <= 1.3 * wanted).all():
                    break
                reach = np.minimum(reach, wanted)
            if number % 4 == 3:  # the scales of the problem have changed
                runs.restart(u)
                surface = None
        return place

    def finish(self) -> None:
        """Surfaces of the second degree, as wide as the errors are."""
        runs, own, place = self.runs, self.own, self.best
        assert place is not None
        u = place.u
        paths = runs.paths(place.likelihood.surface, u, self.measured.covariance)
        runs.restart(u)
        width = 1.0
        for _ in range(_LAST_ROUNDS):
            reach = width * self._reach(place.likelihood.errors_at(u), _LEAST_REACH, _MOST_REACH)
            surface = runs.surface(u, reach, place.likelihood.surface, paths, rough=False)
            before, place = u, self._stand(surface, _BEYOND, u, last=True)
            u, likelihood = place.u, place.likelihood
            free = (u > own.low) & (u < own.high)
            inside = bool((np.abs(u - before)[free] < _INSIDE * reach[free]).all())
            stays = inside or self._gain(place, before) < _LITTLE
            right = likelihood.wrong(u) <= _MOST_MISFIT
            added = float(likelihood.added(u).max())
            more = added > MOST_SHARE and runs.wanted is None and paths < MOST_PATHS
            if stays and right and not more:
                break
            width = width if right else _NARROWER * width
            paths = min(paths * _times(added / MOST_SHARE), MOST_PATHS) if more else paths
        if not stays:
            self.warnings = ("The search did not settle: start it nearer, or narrow the bounds.",)
        elif not right:
            self.warnings = ("The surface through the runs is not right near the result: narrow the bounds.",)

    def _stand(self, surface: Surface, far: float, u: Floats, *, last: bool = False) -> _Place:
        """The best numbers on a surface, with the weights there; the search stands there then."""
        u = MomentsLikelihood(self.own, self.measured, surface, far, last=last).minimum(u)
        self.best = _Place(MomentsLikelihood(self.own, self.measured, surface, far, u, last=last), u, far)
        return self.best

    def _gain(self, place: _Place, before: Floats) -> float:
        """By how much the sum of squares is less: little where the data tell nothing about the way that was gone."""
        own = self.own
        return place.likelihood.deviance(own.outer(before)) - place.likelihood.deviance(own.outer(place.u))

    def _reach(self, errors: Floats, least: float, most: float) -> Floats:
        """How far a region goes to either side: some errors, neither too near nor too far."""
        own = self.own
        width = np.where(own.logarithmic, 1.0, own.high - own.low)
        reach = np.clip(_ERRORS * errors, least * width, most * width)
        return np.minimum(reach, 0.25 * (own.high - own.low))


def _times(excess: float) -> int:
    """By how much there must be more paths: a power of two, 2 to 8.

    Examples
    --------
    >>> _times(1.1), _times(3.5), _times(100.0)
    (2, 4, 8)
    """
    return int(2 ** min(max(math.ceil(math.log2(excess)), 1), 3))
