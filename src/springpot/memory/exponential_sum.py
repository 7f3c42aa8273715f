"""The weights of the past as a short sum of decaying exponentials with positive weights.

c_j = int_0^inf g(s) e^(-s j) ds with a positive g (:mod:`springpot.memory.weights`), so a positive sum exists; the
shortest one is the best approximation in the relative maximum norm (:mod:`springpot.memory.minimax`).  Double precision
finds it for tolerances down to about 1e-8, and one hardly longer for most down to 1e-10.  Beyond, and wherever that
search does not succeed, McLean's substitution
s = exp(y - e^(-y)) / N ("Exponential sum approximations for t^(-beta)", in: Contemporary Computational Mathematics,
2018; arXiv:1606.00123) makes the integrand fall off at both ends faster than any exponential, so that the trapezoidal
rule converges quickly: with a third more terms, but surely.  Rates too slow to be told apart within the N steps of
the run are merged into one.  The spacing of the rule is the widest whose error is below the tolerance.

Positive weights keep the memory passive: from no stored energy it never gives back more work than it took.

Every sum carries the largest error found on a grid so fine that the error between its lags is hardly larger.  Sums are
kept on disk (:mod:`springpot.memory.store`), for a search takes 0.05 s at a tolerance of 1e-6 and up to 0.5 s at 1e-10.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from springpot.memory import store
from springpot.memory.minimax import fewest_terms, lag_grid
from springpot.memory.weights import Family, Floats, Target, at_lags, density

__all__ = ["ExponentialSum", "exponential_sum", "mclean", "power_law_sum"]

_FINEST = 1e-11  # below it the search only loses time
_CHECKED_LAGS = 8000
_COMPARED_LAGS = 422  # of a sum that was read from disk: every 19th of those
_MOST_TERMS = 128  # of a sum that was read from disk: the longest one made here has 87
_ROUNDING = 1e-14
# of the construction: sums kept on disk by another one are not used
_VERSION = hashlib.sha256(b"".join(f.read_bytes() for f in sorted(Path(__file__).parent.glob("*.py")))).hexdigest()


@dataclass(frozen=True, eq=False)
class ExponentialSum:
    """c(t) ~ sum_k weights[k] * exp(-rates[k] * t) for shortest <= t <= longest.

    Attributes
    ----------
    rates : ndarray, shape (terms,)
        Not negative; per unit of the lags (per step for the weights of a scheme).
    weights : ndarray, shape (terms,)
        Positive, in the unit of c.
    relative_error : float
        Largest relative error found on the checking grid.
    shortest, longest : float
        The lags between which it holds.
    """

    rates: Floats
    weights: Floats
    relative_error: float
    shortest: float
    longest: float


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
        The shortest positive sum that is found (see the module), else McLean's.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached (none was met for orders in [0, 1] and up to 1e8 steps).

    Examples
    --------
    >>> found = exponential_sum("grunwald", 0.5, 100_000, 1e-6)
    >>> found.relative_error <= 1e-6, found.rates.size
    (True, 19)
    """
    if order in (0.0, 1.0):
        kept = np.full(int(order == 0.0), 1.0)
        return ExponentialSum(np.zeros(kept.size), kept, 0.0, 1.0, float(steps))
    return _kept(family, order, float(steps), tolerance)


def power_law_sum(order: float, shortest: float, longest: float, tolerance: float = 1e-6) -> ExponentialSum:
    """Exponential sum of t^(-alpha) itself on an interval.

    Parameters
    ----------
    order : float
        alpha in (0, 1).
    shortest, longest : float
        Ends of the interval, positive, in any unit of time.
    tolerance : float
        Relative, in [1e-13, 0.1].

    Returns
    -------
    ExponentialSum
        Rates per unit of time, weights in (unit of time)^(-alpha); the shortest positive sum that is found
        (see the module), else McLean's.

    Raises
    ------
    ValueError
        If a number is out of its range, or the tolerance cannot be reached.

    Examples
    --------
    >>> found = power_law_sum(0.5, 1e-3, 1e3, 1e-6)
    >>> found.rates.size
    23
    >>> abs(float(np.exp(-2.0 * found.rates) @ found.weights) * 2.0**0.5 - 1.0) < 1e-6
    True
    """
    if not 0.0 < order < 1.0:
        raise ValueError(f"order must be above 0 and below 1, not {order!r}.")
    if not 0.0 < shortest <= longest < math.inf:
        raise ValueError(f"shortest and longest must be positive and in this order, not {shortest!r}, {longest!r}.")
    if not 1e-13 <= tolerance <= 0.1:
        raise ValueError(f"tolerance must be between 1e-13 and 0.1, not {tolerance!r}.")
    unit = _kept("power", order, longest / shortest, tolerance)
    return ExponentialSum(
        unit.rates / shortest, unit.weights * shortest**-order, unit.relative_error, shortest, longest
    )


@lru_cache(maxsize=256)
def _kept(target: Target, order: float, longest: float, tolerance: float) -> ExponentialSum:
    """The sum on [1, longest], from disk or made anew, and the same bits either way."""
    key = {"target": target, "order": order, "longest": longest, "tolerance": tolerance, "version": _VERSION}
    found = store.load(key)
    if found is None or not _answers(found, target, order, longest, tolerance):
        found = _made(target, order, longest, tolerance)
        store.save(key, *found)
    return ExponentialSum(*found, 1.0, longest)


def _answers(
    found: tuple[Floats, Floats, float], target: Target, order: float, longest: float, tolerance: float
) -> bool:
    """Whether a sum that was read is as near to the kernel as it says, in 0.1 ms, and as short as those made here.

    With positive weights it is completely monotone, as the kernel is, so between the lags it cannot be far off.
    """
    rates, weights, error = found
    if rates.ndim != 1 or rates.shape != weights.shape or not 0.0 <= error <= tolerance:
        return False
    # each rate once, in ascending order: so are those made here, and another order would change the last bits
    if rates.size > _MOST_TERMS or not (np.diff(rates) > 0.0).all():
        return False
    if not (np.isfinite(rates).all() and np.isfinite(weights).all() and (rates >= 0.0).all() and (weights > 0.0).all()):
        return False
    lags = lag_grid(max(longest, 2.0), _COMPARED_LAGS)
    return _error(rates, weights, lags, at_lags(target, order, lags)) <= 1.001 * error + _ROUNDING


def _made(target: Target, order: float, longest: float, tolerance: float) -> tuple[Floats, Floats, float]:
    end = max(longest, 2.0)
    lags = lag_grid(end, _CHECKED_LAGS)
    exact = at_lags(target, order, lags)
    if tolerance >= _FINEST:
        best = fewest_terms(
            lambda t: at_lags(target, order, t),
            lambda n, stretch: _cells(target, order, end, n, stretch),
            end,
            tolerance,
        )
        if best is not None:
            error = _error(best.rates, best.weights, lags, exact)
            if error <= tolerance:
                return best.rates, best.weights, error
    return mclean(target, order, end, tolerance)


def _error(rates: Floats, weights: Floats, lags: Floats, exact: Floats) -> float:
    terms = np.exp(-np.multiply.outer(lags, rates)) * weights
    return float(np.abs(terms.sum(axis=1) / exact - 1.0).max())


def _cells(target: Target, order: float, longest: float, terms: int, stretch: float) -> tuple[Floats, Floats]:
    """A rough sum: s^(alpha - 1) in cells even in log s, the slowest from 0 on, each gathered at its mean rate."""
    if terms == 1:
        edges = np.array([math.exp(stretch) / math.sqrt(longest)])
    else:
        edges = np.geomspace(math.exp(-stretch) / longest, 3.0 * math.exp(stretch), terms)
    widths = np.diff(np.log(edges))
    ahead = edges[:-1]

    def masses(power: float) -> Floats:
        """Integrals of s^(power - 1), without the cancellation of nearly equal powers."""
        return np.concatenate([edges[:1] ** power, ahead**power * np.expm1(power * widths)]) / power

    rates = masses(order + 1.0) / masses(order)
    return rates, density(target, order, rates) * masses(order)


def mclean(target: Target, order: float, longest: float, tolerance: float) -> tuple[Floats, Floats, float]:
    """McLean's sum on [1, longest] with the fewest terms that meet the tolerance.

    Returns
    -------
    rates, weights : ndarray
    relative_error : float

    Raises
    ------
    ValueError
        If the tolerance cannot be reached.

    Examples
    --------
    >>> rates, weights, error = mclean("power", 0.5, 1e6, 1e-6)
    >>> rates.size, error < 1e-6
    (32, True)
    """
    lags = lag_grid(longest, _CHECKED_LAGS)
    exact = at_lags(target, order, lags)
    some = slice(None, None, 16)
    spacing = 2.5
    while spacing > 0.05:
        rates, weights = _trapezoid(target, order, longest, tolerance, spacing)
        if _error(rates, weights, lags[some], exact[some]) <= tolerance:
            error = _error(rates, weights, lags, exact)
            if error <= tolerance:
                return rates, weights, error
        spacing *= 0.97
    raise ValueError(f"no exponential sum of {tolerance:g} was found for order {order:g} and a range of {longest:g}.")


def _trapezoid(target: Target, order: float, longest: float, tolerance: float, spacing: float) -> tuple[Floats, Floats]:
    digits = -math.log(min(tolerance, 0.1)) + 3.0
    # the slow end: exp(-alpha e^(-y)) has fallen to the tolerance; the fast end: exp(-s) has, at the first lag
    slow = -math.log(2.0 * digits / order)
    fast = math.log(60.0 * longest)
    y = np.arange(slow, fast, spacing)
    log_rates = y - np.exp(-y) - math.log(longest)
    rates = np.exp(log_rates)
    weights = spacing * (1.0 + np.exp(-y)) * np.exp(order * log_rates)  # ds, with the s^(alpha - 1) of the density
    weights *= density(target, order, np.maximum(rates, 1e-300))
    weights_at_first, weights_at_last = weights * np.exp(-rates), weights * np.exp(-rates * longest)
    needed = np.zeros(rates.size, bool)
    for contribution in (weights_at_first, weights_at_last):
        needed |= contribution > 1e-3 * tolerance * contribution.sum()
    rates, weights = rates[needed], weights[needed]
    merged = rates * longest < 0.3 * math.sqrt(tolerance)
    if merged.sum() > 1:
        total = weights[merged].sum()
        rate = float(weights[merged] @ rates[merged] / total)
        rates, weights = np.append(rate, rates[~merged]), np.append(total, weights[~merged])
    return rates, weights
