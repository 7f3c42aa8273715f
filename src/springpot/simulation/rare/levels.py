"""The level that is exceeded with a given probability: the inverse of the curve of levels and probabilities.

Plain paths tell how fast the probability falls; the logarithm of the rate falls about like the square of the level, or
like an energy.  Rounds of splitting go farther, each to the third power of the probability that is known, until one has
passed the one asked.  Then levels close to it are asked with the wanted error, on paths of their own, so that where
they lie does not depend on the noise that tells their probabilities.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import with_error
from springpot.machine.plain import plain
from springpot.machine.progress import Clock, part_of
from springpot.problem.messages import say
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.plan.plan import Plan
from springpot.simulation.rare.event import Quantity, event_of
from springpot.simulation.rare.saved import Saved
from springpot.simulation.rare.search import ExceedanceCurve, search, shares_of_plain_paths

ROUNDS = 6  # of splitting until the probability is passed, most
STREAMS = 8  # of random numbers, for each round
FARTHER = 3.0  # power of the probability known to which the next round goes
ROUGH = 1.0  # relative error of these rounds, whose repetitions have a smaller one
LEVELS = 12  # of a round
NEAR = np.linspace(-1.0, 1.0, 7)  # of the last levels, in units of WIDE or so of the logarithm of the probability
WIDE, ERRORS = 0.6, 3.5  # at least, and in relative errors
_FINE = 0.004  # relative distance of the levels that plain paths are asked
_DECADES = 12  # of these levels, on both sides of 1
_OVER = "max_time is over"
_USUAL = (0.5, 0.02)  # probabilities between which plain paths tell how they fall


@dataclass(frozen=True, eq=False)
class ExceedanceLevel:
    """Levels that are exceeded with given probabilities, with their errors.

    Attributes
    ----------
    name, unit : str
    probability, level, error : ndarray
        The level of each probability, and its standard error; NaN where it was not found.  Of return periods the
        probability is that within the time of the paths.
    low, high : ndarray
        Ends of the 95 % intervals of the levels.
    duration : float
        The time in s within which it is exceeded with this probability.
    return_period : ndarray or None
        The return periods in s, if these were asked.
    downwards : bool
        Whether a level is exceeded by what is below it.
    """

    name: str
    unit: str
    probability: Floats
    level: Floats
    error: Floats
    low: Floats
    high: Floats
    duration: float
    return_period: Floats | None = None
    downwards: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Its numbers; what is not finite is None."""
        names = "probability", "level", "error", "low", "high", "duration", "return_period"
        return plain({name: own for name in names if (own := getattr(self, name)) is not None})

    @property
    def asked(self) -> tuple[str, ...]:
        """How often each level is exceeded, in words."""
        if self.return_period is not None:
            return tuple(f"once in {each:g} s" for each in self.return_period.ravel())
        return tuple(f"with a probability of {each:g} in {self.duration:g} s" for each in self.probability.ravel())

    def __str__(self) -> str:
        columns = (self.level, self.error, self.low, self.high)
        return "\n".join(map(self._said, self.asked, *map(np.ravel, columns)))

    def _said(self, asked: str, level: float, error: float, low: float, high: float) -> str:
        if not math.isfinite(level):
            return f"no level of {self.name} was found that is exceeded {asked}"
        at = f"{self.name} {'<' if self.downwards else '>'} {with_error(level, error, self.unit).strip()}"
        return f"{at} {asked} (95 %: {low:.4g} to {high:.4g})"


def level_of(curve: ExceedanceCurve, probability: Floats) -> ExceedanceLevel:
    """The level of each probability, from a curve: between neighbouring levels its logarithm is a straight line."""
    order = np.argsort(-curve.levels if curve.downwards else curve.levels)
    levels, p, error, low, high = (
        each[order] for each in (curve.levels, curve.probability, curve.error, curve.low, curve.high)
    )
    known, wanted = (low > 0.0) & (p < 1.0), np.ravel(probability)
    if np.count_nonzero(known) < 2:
        found = np.full((4, wanted.size), np.nan)
    else:
        logs, target = np.log([each[known] for each in (p, low, high)]), np.log(wanted)
        places = levels[known]
        level, one, other = (_inverse(places, each, target) for each in logs)
        slopes = np.gradient(logs[0], places)
        off = np.interp(target, logs[0][::-1], np.abs(error[known] / p[known] / slopes)[::-1])
        found = np.array([level, off, np.minimum(one, other), np.maximum(one, other)])
        found[:, ~np.isfinite(level)] = np.nan
    at, off, low, high = (each.reshape(np.shape(probability)) for each in found)
    return ExceedanceLevel(
        curve.name, curve.unit, np.asarray(probability, float), at, off, low, high, curve.duration,
        downwards=curve.downwards,
    )  # fmt: skip


def _inverse(levels: Floats, logs: Floats, target: Floats) -> Floats:
    """Where falling numbers have these values: beyond the ends as far again as the last two, and not farther."""
    falling = np.minimum.accumulate(logs) - 1e-12 * np.arange(logs.size)
    found = np.interp(-target, -falling, levels)
    for end, beside, beyond in ((0, 1, target > falling[0]), (-1, -2, target < falling[-1])):
        slope = (levels[end] - levels[beside]) / (falling[end] - falling[beside])
        far = np.abs(target - falling[end]) > falling[0] - falling[-1]
        found = np.where(beyond, np.where(far, np.nan, levels[end] + slope * (target - falling[end])), found)
    return np.asarray(found)


@dataclass(frozen=True, eq=False)
class Sought:
    """A quantity whose levels are sought.

    Attributes
    ----------
    quantity : Quantity
    given : ndarray
        The probabilities, or the return periods in s.
    duration : float or None
        The time in s within which the levels are exceeded with these probabilities; None of return periods.
    window : float
        That of the paths.
    sign, start, farthest : float
        Levels lie on this side of the start, and at most so far from it.
    """

    quantity: Quantity
    given: Floats
    duration: float | None
    window: float
    sign: float
    start: float
    farthest: float

    @property
    def probability(self) -> Floats:
        """Within the time of the paths: of a longer time by the rate."""
        if self.duration is None:
            return np.asarray(-np.expm1(-self.window / self.given))
        if self.duration == self.window:
            return self.given
        return np.asarray(-np.expm1(np.log1p(-self.given) * self.window / self.duration))

    def found_in(self, curve: ExceedanceCurve) -> ExceedanceLevel:
        """The levels, from a curve close to them."""
        if self.duration is None:
            low, high = (self.window / each for each in curve.return_interval[::-1])
            rates = self.window * curve.rate, self.window * curve.rate_error
            own = replace(curve, probability=rates[0], error=rates[1], low=low, high=high)
            found = level_of(own, self.window / self.given)
            return replace(found, probability=self.probability, return_period=self.given)
        if self.duration == self.window:
            return level_of(curve, self.given)
        later = curve.within(self.duration)
        own = replace(curve, probability=later.probability, error=later.error, low=later.low, high=later.high)
        return replace(level_of(own, self.given), duration=self.duration)

    @property
    def power(self) -> float:
        """Of the distance from the start with which the logarithm of the rate falls, about."""
        return 1.0 if self.quantity.kind == "energy" else 2.0

    def levels(self, distances: Floats) -> Floats:
        """At these distances from the start."""
        return self.start + self.sign * distances

    def distances(self, levels: Floats) -> Floats:
        """The inverse of `levels`."""
        return self.sign * (levels - self.start)


def sought_curve(
    simulation: Simulation, plan: Plan, sought: Sought, rtol: float, clock: Clock, told: Callable[[float], None],
    stream: int, saved: Callable[[Floats], Saved],
) -> tuple[ExceedanceCurve, ExceedanceLevel]:  # fmt: skip
    """The curve close to the levels that have these probabilities, and these levels.

    Parameters
    ----------
    saved : callable
        The saved repetitions of levels.

    Raises
    ------
    TimeoutError
        As `search`.
    """
    rarest, number = float(sought.probability.min()), 0

    def curve(distances: Floats, rtol: float, begin: float, end: float) -> ExceedanceCurve:
        levels = sought.levels(np.unique(np.minimum(distances, sought.farthest)))
        asked = event_of(plan, simulation.parts, sought.quantity, levels, sought.sign)
        return search(
            simulation, asked, rtol, clock, part_of(told, begin, end), stream + STREAMS * number, saved(levels)
        )  # fmt: skip

    law, reason = _law_of_plain_paths(simulation, plan, sought, clock, stream), ""
    while True:
        known = max(math.log(rarest), FARTHER * min(law.last, -1.0))
        logs = np.linspace(min(law.first, -0.3), known - WIDE, LEVELS)
        rough = curve(law.distance(logs), ROUGH, 0.5 - 0.5 ** (number + 1), 0.5 - 0.5 ** (number + 2))
        number, positive = number + 1, rough.probability > 0.0
        if rough.probability[0] < rarest or np.count_nonzero(positive) < 2:
            reason = f"{rough.levels[0]:.4g} {rough.unit} has a probability of only {rough.probability[0]:.2g}"
            break
        law = _Law.of(sought.distances(rough.levels[positive]), rough.probability[positive], sought.power)
        if law.last < math.log(rarest):
            break
        end = sought.distances(rough.levels[-1]) >= sought.farthest * (1.0 - 1e-9)
        if end or number == ROUNDS or clock.left <= 0.0:
            farthest = f"the farthest level, {rough.levels[-1]:.4g} {rough.unit}, has {rough.probability[-1]:.2g}"
            reason = _OVER if clock.left <= 0.0 else farthest
            break
    found = rough
    if not reason and clock.left > 0.0:
        wide, number = max(WIDE, ERRORS * rtol), STREAMS - 1
        logs = (np.log(np.ravel(sought.probability))[:, None] - wide * NEAR).ravel()
        found = curve(law.distance(np.minimum(logs, -1e-3)), rtol, 0.5, 1.0)
    level = sought.found_in(found)
    if not np.isfinite(level.level).all():
        lost = np.where(np.isfinite(level.level), math.inf, level.probability).argmin()
        doubt = say("level_not_found", name=found.name, asked=level.asked[lost], reason=reason or _OVER)
        found = replace(found, warnings=(*found.warnings, doubt))
    return found, level


@dataclass(frozen=True, eq=False)
class _Law:
    """The logarithm of the rate, ln(-ln(1 - p)), against a power of the distance: straight between known ones."""

    powers: Floats
    logs: Floats
    power: float

    @classmethod
    def of(cls, distances: Floats, probability: Floats, power: float) -> _Law:
        order = np.argsort(distances)
        rates = np.log(-np.log1p(-np.minimum(probability[order], 1.0 - 1e-9)))
        falling = np.minimum.accumulate(rates)
        kept = np.concatenate([[True], np.diff(falling) < -1e-9])
        return cls(distances[order][kept] ** power, falling[kept], power)

    @property
    def first(self) -> float:
        """The largest logarithm of the rate."""
        return float(self.logs[0])

    @property
    def last(self) -> float:
        """The smallest one."""
        return float(self.logs[-1])

    def distance(self, logs: Floats) -> Floats:
        """Where the logarithm of the probability has these values, which are negative; beyond the ends straight on."""
        rates = np.log(-np.log1p(-np.exp(logs)))
        found = np.interp(-rates, -self.logs, self.powers)
        if self.logs.size > 1:
            back = max(int(np.searchsorted(-self.logs, 1.0 - self.last, side="right")) - 1, 0)  # about one apart
            back = min(back, self.logs.size - 2)
            slope = (self.powers[-1] - self.powers[back]) / (self.logs[-1] - self.logs[back])
            found = np.where(rates < self.last, self.powers[-1] + slope * (rates - self.last), found)
        return np.asarray(np.maximum(found, 0.0) ** (1.0 / self.power))


def _law_of_plain_paths(simulation: Simulation, plan: Plan, sought: Sought, clock: Clock, stream: int) -> _Law:
    """How fast the probability falls, as the largest values of plain paths tell; of what they do not come to, a guess
    by the usual size of the motion.
    """
    distances = np.geomspace(10.0**-_DECADES, 10.0**_DECADES, int(2 * _DECADES * math.log(10.0) / _FINE))
    distances = distances[distances < sought.farthest]
    asked = event_of(plan, simulation.parts, sought.quantity, sought.levels(distances), sought.sign)
    shares = shares_of_plain_paths(simulation, asked, clock, stream)
    places = [int(np.count_nonzero(shares >= p)) - 1 for p in _USUAL]
    if places[0] < 0 or places[0] == places[1]:
        _, spread, speed = plan.motion.size_of(sought.quantity.signal)
        size = {"energy": speed**2, "x": spread, "distance": spread, "amplitude": spread}
        usual = size.get(sought.quantity.kind, speed)
        return _Law.of(np.array([0.1, 2.0]) * usual, np.array(_USUAL), sought.power)
    return _Law.of(distances[places], shares[places], sought.power)
