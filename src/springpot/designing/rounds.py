"""Rounds of a search and of Monte Carlo, which corrects what the next search is told."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import NormalDist

import numpy as np

from springpot.designing.pooling import Pooled, RoundValue, pooled
from springpot.designing.results import Promise, Round
from springpot.designing.search import CLOSE, Approximation, Found, search
from springpot.designing.statement import Limit
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, per_cent
from springpot.machine.progress import OutOfTimeError

MOST_ROUNDS = 6
SPARE = 0.15  # errors beyond those that the wanted probability needs
SHARE = 0.6  # of the wanted cost_rtol, for the error that is aimed at
FINER, FINEST = 0.25, 1.0 / 16.0  # least rtol over that of the round before, and over the one that was given
SMALLEST = 1e-4  # that a run takes
DOUBTFUL = 0.3  # excess of a limit that quick quantities may have where the true ones have none
NEAR = 0.8  # of the error, for the distance to the places that were simulated
PARTS = 128  # of the way to a place where the limits do not hold


@dataclass(frozen=True, eq=False)
class Searched:
    """What was found.

    Attributes
    ----------
    best : Round
        The best at which the limits hold, or the most probable one; not simulated itself if it is close to one that
        was.
    history : tuple of Round
        Those that were simulated.
    least : callable
        The place of least cost within other limits, near a place.
    margin : float
        By how much the cost is above that at the limits themselves, relative to it.
    warnings : tuple of str
        Of the last run by Monte Carlo.
    """

    best: Round
    history: tuple[Round, ...]
    least: Callable[[Sequence[Limit], Found | None], Found]
    margin: float
    warnings: tuple[str, ...]


Simulated = tuple[dict[str, RoundValue], tuple[str, ...]]
"""One run by Monte Carlo: quantities by name, and warnings."""


@dataclass(frozen=True, eq=False)
class DesignTask:
    """What is searched, and how well it must be known.

    Attributes
    ----------
    approximation : Approximation
        Quantities that are quick to compute, and the cost.
    limits : tuple of Limit
    places : ndarray, shape (n, numbers)
        Where searches start.
    seed : int
    probability : float
        With which all limits must hold.
    rtol, cost_rtol : float
        Of the first run; and of the cost, by which the distance to the limits may raise it.
    exact : bool
        Whether the quick quantities are those that Monte Carlo tends to.
    """

    approximation: Approximation
    limits: tuple[Limit, ...]
    places: Floats
    seed: int
    probability: float
    rtol: float
    cost_rtol: float
    exact: bool

    def holds(self, each: Round) -> bool:
        """Whether all limits hold with the wanted probability."""
        return each.probability >= self.wanted

    @property
    def used(self) -> set[str]:
        """The names of the quantities that are limited, or that the cost depends on."""
        return {*(limit.name for limit in self.limits), *self.approximation.cost.takes}

    @property
    def wanted(self) -> float:
        """The probability of each limit that makes that of all (Bonferroni's inequality)."""
        return 1.0 - (1.0 - self.probability) / max(len(self.limits), 1)


@dataclass(frozen=True, eq=False)
class _Known:
    """What the rounds so far have measured."""

    task: DesignTask
    rounds: tuple[dict[str, RoundValue], ...] = ()
    seen: dict[bytes, dict[str, Pooled]] = field(default_factory=dict)

    def correct(self, u: Floats, theory: dict[str, float]) -> dict[str, float]:
        """Quantities of a place, from those of theory there."""
        if self.task.exact or not self.rounds or not theory:
            return theory
        factors = {name: pool.factor for name, pool in self.at(u).items()}
        return {name: value * factors.get(name, 1.0) for name, value in theory.items()}

    def errors(self, u: Floats) -> dict[str, float]:
        """Of the limited quantities at a place."""
        return {limit.name: self.at(u)[limit.name].error for limit in self.task.limits}

    def least(
        self,
        limits: Sequence[Limit] | None = None,
        near: Found | None = None,
        errors: dict[str, float] | None = None,
    ) -> Found:
        """The place of least cost; near another place first, if one is given.

        With errors, so far inside the limits that these leave the wanted probability.
        """
        task = self.task
        limits = task.limits if limits is None else limits
        if errors is not None:
            away = float(NormalDist().inv_cdf(task.wanted)) + SPARE
            limits = [limit.tightened(away * errors[limit.name]) for limit in limits]
        if near is not None:
            found = search(task.approximation, limits, near.u[None, :], task.seed, self.correct)
            if found.excess <= CLOSE:
                return found
        return search(task.approximation, limits, task.places, task.seed, self.correct)

    def at(self, u: Floats) -> dict[str, Pooled]:
        """Every quantity at a place; computed once."""
        if (place := u.tobytes()) not in self.seen:
            theory = self.task.approximation.at(u)
            self.seen[place] = {
                name: pooled([each[name] for each in self.rounds], u, theory.get(name, math.nan), self.task.exact)
                for name in self.rounds[-1]
            }
        return self.seen[place]

    def round_at(self, u: Floats) -> Round:
        """A round at a place, measured there or near it."""
        task, pools, before = self.task, self.at(u), _Known(self.task, self.rounds[:-1])
        last = self.rounds[-1] if all(np.array_equal(each.place, u) for each in self.rounds[-1].values()) else {}
        numbers, theory = task.approximation.space.values(u), task.approximation.at(u)
        expected = before.correct(u, theory) if last else self.correct(u, theory)
        values = {name: each.value for name, each in pools.items()}
        errors = {name: each.error for name, each in pools.items()}
        return Round(
            values=numbers, theory=theory, expected=expected, quantities=values, errors=errors,
            measured={name: each.value for name, each in last.items()},
            measured_errors={name: each.error for name, each in last.items()},
            cost=task.approximation.cost.of({**expected, **values, **(theory if task.exact else {}), **numbers}),
            promises=tuple(Promise.of(limit, values[limit.name], errors[limit.name]) for limit in task.limits),
        )  # fmt: skip

    def farthest(self, start: Floats, end: Floats) -> Round | None:
        """How far one may go from a simulated place to another so that the limits hold there; None if nowhere."""
        if self.holds(end):
            return self.round_at(end)
        if not self.holds(start):
            return None
        way = (end - start) / PARTS
        last = bisect_left(range(1, PARTS), True, key=lambda part: not self.holds(start + part * way))
        return self.round_at(start + last * way)

    def holds(self, u: Floats) -> bool:
        """Whether the limits hold at a place, and most of the error there is that of the rounds themselves."""
        if not self.task.approximation.at(u):
            return False
        used = [pool for name, pool in self.at(u).items() if name in self.task.used]
        return all(pool.distance_error <= NEAR * pool.error for pool in used) and self.task.holds(self.round_at(u))


def rounds(task: DesignTask, measure: Callable[[Found, float, int], Simulated]) -> Searched:
    """Searches and runs in turn, until the limits hold at a cost that is close to the least.

    Parameters
    ----------
    task : DesignTask
    measure : callable
        Monte Carlo of what a search found, to this relative error, of this number of the round.

    Returns
    -------
    Searched

    Raises
    ------
    ValueError
        If no numbers satisfy the limits.
    """
    known, history, rtol = _Known(task), list[Round](), task.rtol
    finest = max(FINEST * rtol, SMALLEST)
    least = _possible(known, None)
    with_margin = known.least(near=least, errors={limit.name: 0.5 * rtol * abs(limit.bound) for limit in task.limits})
    found = with_margin if with_margin.excess <= CLOSE else least
    ends: list[Round] = []
    over: tuple[str, ...] = ()
    signed = task.approximation.cost.signed
    for number in range(MOST_ROUNDS):
        try:
            quantities, said = measure(found, rtol, number)
            known = _Known(task, (*known.rounds, quantities))
            history.append(known.round_at(found.u))
            if any(math.isnan(promise.probability) for promise in history[-1].promises):
                break
            errors, here = known.errors(found.u), found.u
            least = _possible(known, found)
            found = known.least(near=least, errors=errors)
            pair = history[-1], known.farthest(here, found.u)
            ends = [each for each in pair if each is not None and task.holds(each)]
            if min((_price(signed(each.cost), least.cost) for each in ends), default=math.inf) <= task.cost_rtol:
                break
            above = _price(found.cost, least.cost) if found.excess <= CLOSE else math.inf
            if ends and rtol <= finest and above > task.cost_rtol:
                break  # another run would not be precise enough either
            finer = min(max(_finer(task, above, errors, known.rounds[-1]), FINER, finest / rtol), 1.0)
            rtol *= finer
            if finer < 1.0:  # where the next run will allow it to be
                there = {name: min(finer * known.rounds[-1][name].error, error) for name, error in errors.items()}
                nearer_to_limits = known.least(near=least, errors=there)
                found = nearer_to_limits if nearer_to_limits.excess <= CLOSE else found
        except OutOfTimeError:
            if not history:
                raise
            over = ("max_time is over: this is the best design so far.",)
            break
    held = ends or [each for each in history if task.holds(each)]
    best = min(held, key=lambda each: signed(each.cost)) if held else max(history, key=lambda each: each.probability)
    margin = max(_price(signed(best.cost), least.cost), 0.0)
    return Searched(best, tuple(history), known.least, margin, (*over, *said))


def _price(cost: float, least: float) -> float:
    """By how much a cost is above the least one, relative to it."""
    return (cost - least) / abs(least) if least != 0.0 else math.inf if cost > least else 0.0


def _possible(known: _Known, near: Found | None) -> Found:
    """The place of least cost; before the first run also one that misses a limit by no more than theory may be off."""
    least = known.least(near=near)
    if least.excess > (CLOSE if known.rounds or known.task.exact else DOUBTFUL):
        raise ValueError(_missed(known.task.limits, least))
    return least


def _missed(limits: tuple[Limit, ...], found: Found) -> str:
    """Which limit is missed, and by how much, where that is least."""
    missed = max(limits, key=lambda limit: limit.excess(found.quantities.get(limit.name, math.inf)))
    value = found.quantities.get(missed.name, math.nan)
    where = listed([f"{name} = {value:.4g}" for name, value in found.values.items()])
    off = abs(value / missed.bound - 1.0) if missed.bound else math.nan
    share = f" by {per_cent(off, 3)}" if math.isfinite(off) else ""
    wanted = "a limit that can be reached" if len(limits) == 1 else "limits that can hold together"
    nearest = f"the nearest design, at {where}, has {missed.name} = {value:.4g}"
    return f"subject_to must have {wanted}: {nearest}, which misses {missed}{share}."


def _finer(task: DesignTask, above: float, errors: dict[str, float], latest: dict[str, RoundValue]) -> float:
    """Error of the next run over that of the last, so that the distance to the limits raises the cost by little."""
    share = SHARE * task.cost_rtol / above if above > 0.0 else math.inf
    if share >= 1.0:
        return 1.0
    needed = share / math.sqrt(1.0 - share**2)
    return min((needed * error / latest[name].error for name, error in errors.items()), default=1.0)
