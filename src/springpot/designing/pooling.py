"""Quantities at a place, from all rounds of Monte Carlo: what its ratio to theory is there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats

SLOPE_WITH_THEORY = 0.5  # change of the logarithm of the ratio over that of theory, between two places
SLOPE_WITH_PLACE = 0.1  # change of the logarithm of the ratio over the distance of two places, as a share of the bounds


@dataclass(frozen=True, eq=False)
class RoundValue:
    """One quantity of one round.

    Attributes
    ----------
    place : ndarray
        Coordinates of the numbers, between 0 and 1.
    theory : float
        NaN where it has no answer.
    value, standard_error, bias : float
        By Monte Carlo; of the bias its standard deviation.
    """

    place: Floats
    theory: float
    value: float
    standard_error: float
    bias: float

    @property
    def error(self) -> float:
        """Standard error and bias together."""
        return math.hypot(self.standard_error, self.bias)

    @property
    def ratio(self) -> float:
        """Logarithm of Monte Carlo over theory; NaN without one."""
        known = math.isfinite(self.theory) and self.theory != 0.0 and self.standard_error > 0.0
        return math.log(self.value / self.theory) if known and self.value / self.theory > 0.0 else math.nan


@dataclass(frozen=True)
class Pooled:
    """Value and error at a place, the mean ratio to theory (1 if not known), and the error's part for the distance."""

    value: float
    error: float
    factor: float
    distance_error: float


def pooled(rounds: Sequence[RoundValue], place: Floats, theory: float, exact: bool = False) -> Pooled:
    """A quantity at a place, from all rounds.

    The rounds have independent random numbers.  The ratio to theory may change between their places and this one: its
    logarithm with a slope in that of theory and in the coordinates, and with a bend, neither of which is known
    beforehand; not at all if theory is exact.  What the rounds together say of the place is the best linear unbiased
    prediction ("kriging"; N. Cressie, Statistics for Spatial Data, 1993, section 3.4): rounds at several places show
    the slope.  The bias is that of the last round; that by which others exceed it is counted as their chance.

    Parameters
    ----------
    rounds : sequence of RoundValue
        In their order.
    place : ndarray
    theory : float
        There.
    exact : bool

    Examples
    --------
    >>> here = np.array([0.5])
    >>> both = pooled([RoundValue(here, 1.0, 2.0, 0.02, 0.0), RoundValue(here, 1.0, 2.0, 0.02, 0.0)], here, 1.0)
    >>> round(both.value, 6), round(both.error, 6), both.distance_error
    (2.0, 0.014142, 0.0)
    """
    last = rounds[-1]
    known = [each for each in rounds if math.isfinite(each.ratio) and each.theory * theory > 0.0]
    if last not in known:
        return Pooled(last.value, last.error, 1.0, 0.0 if np.array_equal(last.place, place) else math.inf)
    errors, biases = np.array([(each.standard_error, each.bias) for each in known]).T / [each.value for each in known]
    relative_bias = last.bias / last.value
    variances = errors**2 + np.maximum(biases**2 - relative_bias**2, 0.0)
    changes = np.zeros((len(known), len(known))) if exact else _changes(known, place, theory)
    weights = np.linalg.solve(np.diag(variances) + changes, np.ones(len(known)))
    weights /= weights.sum()
    mean = float(weights @ np.array([each.ratio for each in known]))
    value = theory * math.exp(mean)
    parts = float(weights**2 @ variances), max(float(weights @ changes @ weights), 0.0), relative_bias**2
    return Pooled(value, abs(value) * math.sqrt(sum(parts)), math.exp(mean), abs(value) * math.sqrt(parts[1]))


def _changes(rounds: Sequence[RoundValue], place: Floats, theory: float) -> Floats:
    """Covariance of the logarithms of the ratios of the rounds, less that of a place."""
    along = SLOPE_WITH_THEORY * np.array([math.log(theory / each.theory) for each in rounds])
    apart = np.stack([place - each.place for each in rounds])
    slopes = np.outer(along, along) + SLOPE_WITH_PLACE**2 * (apart @ apart.T)
    bends = (along**2 / SLOPE_WITH_THEORY) ** 2 + (SLOPE_WITH_PLACE * (apart**2).sum(axis=1)) ** 2
    return np.asarray(slopes + np.diag(bends))
