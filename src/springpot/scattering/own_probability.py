"""The probability that a device has of its own, over the devices: from what paths of few devices add to the mean.

Splitting tells the probability of single devices badly: most devices add nothing.  Its logarithm is a smooth function
of the normal scores of the uncertain numbers, so that a polynomial of them is fitted, by the likelihood of Poisson's
law.  Its degree is the one that agrees best with repetitions that are left out.

Errors are by a jackknife over the repetitions, which have devices of their own.  Most devices lie where hardly any
exceed the level: there a polynomial is continued beyond what it was fitted to.  So intervals reach to the value of the
polynomial that agrees second best.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats
from springpot.scattering.estimates import BELOW, PREDICTED, Interval, indices_of, jackknifed, one_sided
from springpot.scattering.stages import Lot, Stage, normal_scores
from springpot.scattering.surface import Powers, Surface, polynomials, powers_of, probability_surface, surface_missed

_SHARES = 0.5, 0.95  # lower quantiles are of devices that hardly ever exceed the level
_SETS = (1, 1.0), (2, 1.0), (3, 1.0), (4, 1.0)  # of polynomials
_A_TERM = 4  # devices that exceed the level, for each term of the polynomial


@dataclass(frozen=True, eq=False)
class OwnProbability:
    """Of the devices, at the last level.

    Attributes
    ----------
    quantiles : dict of Interval
        Below which these shares of the devices have it.
    tolerance : float
        Below which 99 % of the devices have it, 95 % sure.
    alone, together : dict of Interval
        First-order and total Sobol indices of its logarithm.
    above : Interval or None
        Share of the devices that have more than a limit.
    logarithms : ndarray, shape (1 + repetitions, devices)
        Of the probability of other devices: from all repetitions, and without each of them.
    others : ndarray, shape (devices,)
        The same from all repetitions by the second best polynomial.
    """

    quantiles: dict[float, Interval]
    tolerance: float
    alone: dict[str, Interval]
    together: dict[str, Interval]
    above: Interval | None
    logarithms: Floats
    others: Floats

    def times_within(self, times: float) -> Interval:
        """By which the mean probability grows where each device has so many times the time."""
        lines = np.vstack([self.logarithms, self.others])
        with np.errstate(divide="ignore"):
            own = -np.expm1(times * np.log1p(-np.exp(lines))).mean(axis=1)
        *logs, other = np.log(own / np.exp(lines).mean(axis=1)).tolist()
        found = _reaching(jackknifed(logs[0], np.array(logs[1:])), other)
        value, low, high = map(math.exp, (found.value, found.low, found.high))
        return Interval(value, value * found.error, low, high)


def own_probability(stage: Stage, lot: Lot, limit: float | None) -> OwnProbability | None:
    """All of it; None where too few devices exceeded the last level, or paths were not split.

    Parameters
    ----------
    stage : Stage
    lot : Lot
        From which its devices are.
    limit : float or None
    """
    repetitions, each, _ = stage.of_repetitions.shape
    values = stage.tally.of_devices[:, -1] * each / stage.weights
    numbers = stage.scores.shape[1]
    sets = [own for own in (powers_of(numbers, *terms) for terms in _SETS)
            if np.count_nonzero(values) >= _A_TERM * len(own)]  # fmt: skip
    if not sets or not stage.splits:
        return None
    size, of, normal = float(values.mean()), np.arange(len(values)) // each, (True,) * numbers
    shares_of_mean, fitted = values / size, list[tuple[float, Powers, list[Floats]]]()
    for powers in sets:
        terms = polynomials(stage.scores, normal, powers)
        own = [probability_surface(terms, shares_of_mean)]
        own += [probability_surface(terms[of != n], shares_of_mean[of != n]) for n in range(repetitions)]
        left_out = [surface_missed(terms[of == n], shares_of_mean[of == n], own[n + 1]) for n in range(repetitions)]
        fitted.append((math.fsum(left_out), powers, own))
    (_, powers, coefficients), second = [*sorted(fitted, key=lambda each: each[0]), fitted[0]][:2]
    devices = normal_scores(numbers, lot.plan.settings.seed, PREDICTED)

    def line_of(powers: Powers, own: Floats) -> Floats:
        return np.sort(np.minimum(polynomials(devices, normal, powers) @ own + math.log(size), 0.0))

    lines, others = [line_of(powers, own) for own in coefficients], line_of(second[1], second[2][0])

    def interval(of_line: Callable[[Floats], float]) -> Interval:
        found = [of_line(line) for line in lines]
        return _reaching(jackknifed(found[0], np.array(found[1:])), of_line(others))

    def below(share: float) -> Interval:
        return interval(lambda line: float(np.quantile(line, share)))

    def as_probability(own: Interval) -> Interval:
        low, value, high = (math.exp(min(end, 0.0)) for end in (own.low, own.value, own.high))
        return Interval(value, value * own.error, low, high)

    surfaces = [Surface(powers, own, np.zeros_like(own), 0.0, 0.0) for own in coefficients]
    alone, together = indices_of(surfaces, lot.together.inputs(lot.numbers), lot.together.groups)
    top, above = below(BELOW), None
    if limit is not None:
        share = interval(lambda line: float((line > math.log(limit)).mean()))
        unseen = 3.0 / PREDICTED if share.value in (0.0, 1.0) else 0.0  # three of them could be beyond by chance
        low, high = max(share.low - unseen, 0.0), min(share.high + unseen, 1.0)
        above = Interval(share.value, share.error, low, high)
    return OwnProbability(
        quantiles={share: as_probability(below(share)) for share in _SHARES},
        tolerance=min(math.exp(max(top.value + one_sided(repetitions, 0.95) * top.error, top.high)), 1.0),
        alone=alone, together=together, above=above, logarithms=np.array(lines), others=others,
    )  # fmt: skip


def _reaching(found: Interval, other: float) -> Interval:
    """An interval that has another value in it."""
    return Interval(found.value, found.error, min(found.low, other), max(found.high, other))
