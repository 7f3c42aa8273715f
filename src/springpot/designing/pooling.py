"""Quantities at the last place of a search, from all rounds of Monte Carlo: means of its ratio to theory."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Measured", "Pooled", "pooled"]

Floats = NDArray[np.float64]

DRIFT = 0.5  # change of the logarithm of the ratio over that of theory, between two places
SLIDE = 0.1  # change of the logarithm of the ratio over the distance of two places, as a share of the bounds


@dataclass(frozen=True, eq=False)
class Measured:
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
    drift: float


def pooled(rounds: Sequence[Measured], place: Floats, theory: float, exact: bool = False) -> Pooled:
    """A quantity at a place, from all rounds.

    The rounds have independent random numbers.  Each counts with its standard error, and with what the ratio to theory
    may change between its place and this one; with none of this if theory is exact.  The bias is that of the last
    round.

    Parameters
    ----------
    rounds : sequence of Measured
        In their order.
    place : ndarray
    theory : float
        There.
    exact : bool

    Examples
    --------
    >>> here = np.array([0.5])
    >>> both = pooled([Measured(here, 1.0, 2.0, 0.02, 0.0), Measured(here, 1.0, 2.0, 0.02, 0.0)], here, 1.0)
    >>> round(both.value, 6), round(both.error, 6), both.drift
    (2.0, 0.014142, 0.0)
    """
    last = rounds[-1]
    known = [each for each in rounds if math.isfinite(each.ratio) and each.theory * theory > 0.0]
    if last not in known:
        return Pooled(last.value, last.error, 1.0, 0.0 if np.array_equal(last.place, place) else math.inf)
    changes = np.array([0.0 if exact else _change(each, place, theory) for each in known])
    chances = np.array([(each.standard_error / each.value) ** 2 for each in known])
    weights = 1.0 / (chances + changes)
    weights /= weights.sum()
    mean = float(weights @ np.array([each.ratio for each in known]))
    value = theory * math.exp(mean)
    parts = weights**2 @ chances, weights**2 @ changes, (last.bias / last.value) ** 2
    return Pooled(value, abs(value) * math.sqrt(sum(parts)), math.exp(mean), abs(value) * math.sqrt(parts[1]))


def _change(one: Measured, place: Floats, theory: float) -> float:
    """Variance of the logarithm of the ratio between a round and a place."""
    along = DRIFT * math.log(theory / one.theory)
    return along**2 + (SLIDE * float(np.linalg.norm(place - one.place))) ** 2
