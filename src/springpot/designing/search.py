"""The search for the numbers of least cost within limits, on quantities that are quick to compute."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from springpot.designing.statement import Cost, Limit, Space
from springpot.machine.arrays import Floats
from springpot.machine.progress import Clock, Estimate, FractionDone
from springpot.simulation.paths.simulation import Progress

SEARCH = 0.2  # of the whole: what comes before the first round of Monte Carlo
LITTLE = 0.01  # of what is left of the search: one step of it, whose number is not known beforehand


class DesignProgress:
    """Says that the work goes on, and ends it when the time is over.

    Parameters
    ----------
    limit : float or None
        In s, of the whole.
    progress : callable or None
    rounds : int
        Of Monte Carlo, at most.

    Examples
    --------
    >>> told = []
    >>> work = DesignProgress(None, told.append, 6)
    >>> work.step()
    >>> work.round(5, 1.0)
    >>> told
    [0.002, 1.0]
    """

    def __init__(self, limit: float | None, progress: Progress | None, rounds: int) -> None:
        self.clock, self._progress, self._rounds = Clock(limit), progress, rounds
        self._done = 0.0
        self._second: tuple[float, float] | None = None  # when the second short run began, and the share done then

    @property
    def left(self) -> float | None:
        """Seconds that are left; None without a limit."""
        return self.clock.left if math.isfinite(self.clock.limit) else None

    def say(self) -> None:
        """At the beginning."""
        self._tell(0.0)

    def step(self) -> None:
        """Between two steps of a search.

        Raises
        ------
        OutOfTimeError
            If the time is over.
        """
        self._tell(self._done + LITTLE * max(SEARCH - self._done, 0.0))

    def short_run(self, fraction: float, run: int, runs: int, path_steps: float) -> None:
        """Within one of the short runs that take the place of theory."""
        share, seconds = (run + fraction) / runs, math.nan
        if run and self._second is None:  # the first one may have compiled the kernel
            self._second = self.clock.elapsed, share
        elif self._second is not None and share > self._second[1]:
            begun, before = self._second
            seconds = (self.clock.elapsed - begun) * (1.0 - share) / (share - before)
        self._tell(SEARCH * share, Estimate(path_steps, seconds, f"short runs at {runs} places", math.nan))

    def round(self, number: int, fraction: float) -> None:
        """Within one round of Monte Carlo."""
        estimate = getattr(fraction, "estimate", None)
        self._tell(SEARCH + (1.0 - SEARCH) * (number + fraction) / self._rounds, estimate)

    def end(self) -> None:
        """All is done; what is asked of the result later has its own time."""
        self.clock.limit, progress, self._progress = math.inf, self._progress, None
        if progress is not None:
            progress(1.0)

    def _tell(self, fraction: float, estimate: Estimate | None = None) -> None:
        self.clock.check()
        self._done = max(self._done, min(fraction, 1.0))
        if self._progress is not None:
            self._progress(FractionDone(self._done, estimate))


Correct = Callable[[Floats, dict[str, float]], dict[str, float]]
"""What is known of quantities at a place, from those of a model there."""

STARTS = 3
CLOSE = 1e-5  # excess of a limit that is still taken as held
SAME = 0.01  # difference of two excesses that are taken as one, relative to them
DIFFERENCE = 1e-4  # of the whole range, for slopes
NO_ANSWER = 20.0  # in place of a cost or an excess where there is none


@dataclass(frozen=True)
class Found:
    """Where a search ended.

    Attributes
    ----------
    u : ndarray
        Coordinates in the space.
    values, quantities : dict
        Numbers and quantities there.
    cost : float
        What is to be least; of what is to be greatest its negative.
    excess : float
        The largest of the limits'; positive if no place was found where all hold.
    how : str
        The optimizer, in a word.
    """

    u: Floats
    values: dict[str, float]
    quantities: dict[str, float]
    cost: float
    excess: float
    how: str


@dataclass(frozen=True, eq=False)
class Approximation:
    """Quantities of free numbers that are quick to compute.

    Attributes
    ----------
    space : Space
    quantities : callable
        From numbers by name to quantities by name; empty where there is no answer.
    cost : Cost
    """

    space: Space
    quantities: Callable[[Mapping[str, float]], dict[str, float]]
    cost: Cost
    known: dict[tuple[float, ...], dict[str, float]] = field(default_factory=dict)

    def at(self, u: Floats) -> dict[str, float]:
        """Quantities at a place; computed once."""
        place = tuple(float(each) for each in np.clip(u, 0.0, 1.0))
        if place not in self.known:
            self.known[place] = self.quantities(self.space.values(np.array(place)))
        return self.known[place]


@dataclass(frozen=True, eq=False)
class _Task:
    """One search: a model with its corrections, limits, and one of its costs, if all are positive or all negative."""

    model: Approximation
    limits: Sequence[Limit]
    correct: Correct
    scale: float = 0.0

    def corrected(self, u: Floats) -> dict[str, float]:
        u = np.clip(u, 0.0, 1.0)
        return self.correct(u, self.model.at(u))

    def whole_cost(self, u: Floats) -> float:
        found = self.corrected(u)
        if not found:
            return math.nan
        cost = self.model.cost
        return cost.signed(cost.of({**found, **self.model.space.values(np.clip(u, 0.0, 1.0))}))

    def cost(self, u: Floats) -> float:
        cost = self.whole_cost(u)
        if not math.isfinite(cost):
            return NO_ANSWER
        if self.scale == 0.0:
            return cost
        ratio = math.log(max(cost / self.scale, 1e-300))
        return ratio if self.scale > 0.0 else -ratio  # of what is negative a larger ratio is less

    def excesses(self, u: Floats) -> Floats:
        found = self.corrected(u)
        return np.array([
            limit.excess(found[limit.name]) if math.isfinite(found.get(limit.name, math.nan)) else NO_ANSWER
            for limit in self.limits
        ])  # fmt: skip

    def worst(self, u: Floats) -> float:
        if not self.model.at(u):
            return NO_ANSWER
        return float(self.excesses(u).max(initial=-math.inf))

    def found(self, u: Floats, how: str) -> Found:
        u = np.clip(u, 0.0, 1.0)
        return Found(u, self.model.space.values(u), self.corrected(u), self.whole_cost(u), self.worst(u), how)


def search(
    model: Approximation,
    limits: Sequence[Limit],
    places: Floats,
    seed: int,
    correct: Correct = lambda u, known: known,
) -> Found:
    """The place of least cost at which the limits hold, or the one at which they are missed by least.

    Sequential quadratic programming (SLSQP of SciPy) from the best of the given places; differential evolution where
    that ends nowhere.

    Parameters
    ----------
    model : Approximation
    limits : sequence of Limit
    places : ndarray, shape (n, numbers)
    seed : int
    correct : callable
        From a place and the model's quantities there to what is known of them.

    Examples
    --------
    >>> from springpot.machine.arguments import Free
    >>> space = Space({"k": Free(2.0, "k", 1.0, 100.0)})
    >>> model = Approximation(space, lambda values: {"a": values["k"] ** 2}, Cost("k", ("k",)))
    >>> found = search(model, [Limit("a", 25.0, upper=False)], np.array([[0.1], [0.9]]), 1)
    >>> round(found.cost, 3)
    5.0
    """
    costs = [_Task(model, limits, correct).whole_cost(place) for place in places]
    finite = [cost for cost in costs if math.isfinite(cost)]
    one_sign = bool(finite) and (min(finite) > 0.0 or max(finite) < 0.0)
    task = _Task(model, limits, correct, min(finite) if one_sign else 0.0)
    answered = [place for place, cost in zip(places, costs, strict=True) if math.isfinite(cost)]
    ranked = sorted(answered, key=lambda u: (max(task.worst(u), 0.0), task.cost(u)))
    ends = [task.found(u, "screening") for u in ranked[:1]]
    starts = ranked[:STARTS]
    if ends and ends[0].excess > CLOSE:
        nearest = list[Found]()  # where the limits are missed by least, until two of them say the same
        for u in starts:
            nearest.append(task.found(_nearest(task, u), "nearest"))
            if _agree(nearest):
                break
        ends += nearest
        starts = [end.u for end in nearest if end.excess <= CLOSE]
        if _agree(nearest):
            return min(ends, key=lambda end: end.excess)
    for u in starts:
        found = task.found(_least(task.cost, u, np.ones(u.size), lambda place: -task.excesses(place)), "SLSQP")
        ends += [found] if math.isfinite(found.cost) else []
    if limits and all(end.excess > CLOSE or end.how == "screening" for end in ends):
        ends.append(_by_evolution(task, ranked[0] if ranked else places[0], seed))
    held = [end for end in ends if end.excess <= CLOSE and math.isfinite(end.cost)]
    return min(held, key=lambda end: end.cost) if held else min(ends, key=lambda end: end.excess)


def _agree(found: Sequence[Found]) -> bool:
    """Whether the last two places miss the limits by the same: there is nothing better then."""
    if len(found) < 2 or found[-1].excess <= CLOSE:
        return False
    return abs(found[-1].excess - found[-2].excess) <= SAME * found[-1].excess


def _least(function: Callable[[Floats], float], u: Floats, highest: Floats, positive: Any) -> Floats:
    """Where a function is least, while others are positive; a last coordinate with a bound above 1 may be negative."""
    from scipy.optimize import Bounds, minimize

    limits: Any = [{"type": "ineq", "fun": positive}] if positive(u).size else ()
    answer = minimize(
        function, u, method="SLSQP", bounds=Bounds(np.where(highest > 1.0, -highest, 0.0), highest), constraints=limits,
        options={"eps": DIFFERENCE, "ftol": 1e-8, "maxiter": 60},
    )  # fmt: skip
    return np.asarray(answer.x, float)


def _nearest(task: _Task, u: Floats) -> Floats:
    """Where the largest excess is least: that of an auxiliary variable above all of them."""
    end = _least(
        lambda both: float(both[-1]), np.append(u, task.worst(u)), np.append(np.ones(u.size), 2.0 * NO_ANSWER),
        lambda both: both[-1] - task.excesses(both[:-1]),
    )[:-1]  # fmt: skip
    return end if task.worst(end) < task.worst(u) else u


def _by_evolution(task: _Task, u: Floats, seed: int) -> Found:
    from scipy.optimize import Bounds, differential_evolution

    def penalised(place: Floats) -> float:
        worst = task.worst(place)
        return 1e3 * (1.0 + worst) if worst > CLOSE else task.cost(place)

    answer = differential_evolution(
        penalised, Bounds(np.zeros(u.size), np.ones(u.size)), x0=np.clip(u, 0.0, 1.0), rng=seed, popsize=6, maxiter=15,
        polish=False,
    )  # fmt: skip
    return task.found(np.asarray(answer.x, float), "differential evolution")
