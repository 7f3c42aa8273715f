"""The weights of the past as a short sum of decaying exponentials with positive weights.

c_j = int_0^inf g(s) e^(-s j) ds with a positive g (:mod:`springpot.memory.weights`).  McLean's substitution
s = exp(y - e^(-y)) / N ("Exponential sum approximations for t^(-beta)", in: Contemporary Computational Mathematics,
2018; arXiv:1606.00123) makes the integrand fall off at both ends faster than any exponential, so that the trapezoidal
rule converges quickly; rates too slow to be told apart within the N steps of the run are merged into one.  The spacing
of the rule is the widest whose error, measured against the weights themselves over 1 <= j <= N, is below the tolerance.

Positive weights keep the memory passive: from no stored energy it never gives back more work than it took.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from springpot.memory.weights import Family, at_lags, density

__all__ = ["ExponentialSum", "exponential_sum"]


@dataclass(frozen=True, eq=False)
class ExponentialSum:
    """c_j ~ sum_k weights[k] * exp(-rates[k] * j) for 1 <= j <= steps.

    Attributes
    ----------
    rates : ndarray, shape (terms,)
        Per step, not negative.
    weights : ndarray, shape (terms,)
        Positive.
    relative_error : float
        Largest relative error found on the checking grid.
    steps : int
        The longest lag, in steps, for which it holds.
    """

    rates: npt.NDArray[np.float64]
    weights: npt.NDArray[np.float64]
    relative_error: float
    steps: int


@lru_cache(maxsize=256)
def exponential_sum(family: Family, order: float, steps: int, tolerance: float = 1e-6) -> ExponentialSum:
    """Exponential sum of the weights of the past.

    Parameters
    ----------
    family : {"grunwald", "average"}
    order : float
        alpha in [0, 1]; at 1 nothing older than the last step counts (no terms), at 0 everything counts alike (one term
        that never decays).
    steps : int
        Longest lag, in steps.
    tolerance : float
        Relative, in [1e-13, 0.1].

    Returns
    -------
    ExponentialSum

    Raises
    ------
    ValueError
        If the tolerance cannot be reached (none was met for orders in [0, 1] and up to 1e7 steps).

    Examples
    --------
    >>> found = exponential_sum("grunwald", 0.5, 100_000, 1e-6)
    >>> found.relative_error <= 1e-6 and found.rates.size < 45
    True
    """
    if order in (0.0, 1.0):
        kept = np.full(int(order == 0.0), 1.0)
        return ExponentialSum(np.zeros(kept.size), kept, 0.0, steps)
    lags = np.unique(np.geomspace(1, max(steps, 2), 1500).astype(np.int64))
    exact = at_lags(family, order, lags)
    spacing = 2.5
    while spacing > 0.05:
        rates, weights = _trapezoid(family, order, int(lags[-1]), tolerance, spacing)
        error = float(np.abs((np.exp(-np.outer(lags, rates)) @ weights) / exact - 1.0).max())
        if error <= tolerance:
            return ExponentialSum(rates, weights, error, steps)
        spacing *= 0.97
    raise ValueError(f"no exponential sum of {tolerance:g} was found for order {order:g} and {steps} steps.")


def _trapezoid(
    family: Family, order: float, steps: int, tolerance: float, spacing: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    digits = -math.log(min(tolerance, 0.1)) + 3.0
    # the slow end: exp(-alpha e^(-y)) has fallen to the tolerance; the fast end: exp(-s) has, at the first lag
    slow = -math.log(2.0 * digits / order)
    fast = math.log(60.0 * steps)
    y = np.arange(slow, fast, spacing)
    log_rates = y - np.exp(-y) - math.log(steps)
    rates = np.exp(log_rates)
    weights = spacing * (1.0 + np.exp(-y)) * np.exp(order * log_rates)  # ds, with the s^(alpha - 1) of the density
    weights *= density(family, order, np.maximum(rates, 1e-300))
    weights_at_first, weights_at_last = weights * np.exp(-rates), weights * np.exp(-rates * steps)
    needed = np.zeros(rates.size, bool)
    for contribution in (weights_at_first, weights_at_last):
        needed |= contribution > 1e-3 * tolerance * contribution.sum()
    rates, weights = rates[needed], weights[needed]
    merged = rates * steps < 0.3 * math.sqrt(tolerance)
    if merged.sum() > 1:
        total = weights[merged].sum()
        rate = float(weights[merged] @ rates[merged] / total)
        rates, weights = np.append(rate, rates[~merged]), np.append(total, weights[~merged])
    return rates, weights
