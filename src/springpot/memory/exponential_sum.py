"""The memory weights as a short sum of decaying exponentials with positive weights.

c_j = int_0^inf g(s) e^(-s j) ds with a positive g (:mod:`springpot.memory.weights`), so a positive sum exists; the
shortest one is the best approximation in the relative maximum norm (:mod:`springpot.memory.minimax`).  It is found in
double precision for tolerances down to about 1e-8, and one that is hardly longer for most down to 1e-10.  Otherwise
McLean's substitution s = exp(y - e^(-y)) / N is used ("Exponential sum approximations for t^(-beta)", in: Contemporary
Computational Mathematics, 2018; arXiv:1606.00123).  It makes the integrand decay faster than any exponential at both
ends, so that the trapezoidal rule always converges quickly, with a third more terms.  Rates much slower than 1 / N,
with N the steps of the run, are merged into one.  The spacing of the rule is the widest whose error is below the
tolerance.

Positive weights make the memory passive: it never returns more work than it has received.

Every sum has its largest error on a grid so fine that the error in between is hardly larger.  Sums are cached on disk
(:mod:`springpot.memory.store`), because a search takes 0.05 s at a tolerance of 1e-6 and up to 0.5 s at 1e-10.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from springpot.machine.arrays import Floats
from springpot.memory import store
from springpot.memory.minimax import fewest_terms, lag_grid
from springpot.memory.weights import Family, Target, at_lags, density

_FINEST = 1e-11  # below it the search for the shortest sum never succeeds
_CHECKED_LAGS = 8000
_COMPARED_LAGS = 422  # of a sum that was read from disk: every 19th of those
_MOST_TERMS = 128  # of a sum that was read from disk: the longest computed one has 87
_LEAST_ORDER = 1e-100  # kernels of smaller orders are this one's in double precision, and their masses overflow
_ROUNDING = 1e-14
# of this code: sums on disk from another version are not used
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
        Largest relative error on the checking grid.
    shortest, longest : float
        The lags between which the sum is valid.
    """

    rates: Floats
    weights: Floats
    relative_error: float
    shortest: float
    longest: float


def exponential_sum(family: Family, order: float, steps: int, tolerance: float = 1e-6) -> ExponentialSum:
    """Exponential sum of the memory weights.

    Parameters
    ----------
    family : {"grunwald", "average"}
    order : float
        alpha in [0, 1]; at 1 there is no memory beyond the last step (no terms), at 0 all weights are equal (one term
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
        If the tolerance cannot be reached (this never happened for orders in [0, 1] and up to 1e8 steps).

    Examples
    --------
    >>> memory = exponential_sum("grunwald", 0.5, 100_000, 1e-6)
    >>> memory.relative_error <= 1e-6, memory.rates.size
    (True, 19)
    """
    if order in (0.0, 1.0):
        kept = np.full(int(order == 0.0), 1.0)
        return ExponentialSum(np.zeros(kept.size), kept, 0.0, 1.0, float(steps))
    return _cached(family, max(order, _LEAST_ORDER), float(steps), tolerance)


def shared_span(steps: int) -> int:
    """A span of at least so many steps that runs of about the same length share, and with it a stored sum.

    Spans are powers of the square root of 2: a sum for one has a third of a term more than needed, on average.

    Examples
    --------
    >>> [shared_span(steps) for steps in (1, 5, 10_000, 11_000, 11_586)]
    [1, 6, 11586, 11586, 11586]
    """
    halves = math.floor(2.0 * math.log2(steps))
    spans = (math.ceil(math.pow(2.0, 0.5 * each) - 1e-9) for each in (halves, halves + 1))
    return next(span for span in spans if span >= steps)


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
    >>> power_law = power_law_sum(0.5, 1e-3, 1e3, 1e-6)
    >>> power_law.rates.size
    23
    >>> abs(float(np.exp(-2.0 * power_law.rates) @ power_law.weights) * 2.0**0.5 - 1.0) < 1e-6
    True
    """
    if not 0.0 < order < 1.0:
        raise ValueError(f"order must be above 0 and below 1, not {order!r}.")
    if not 0.0 < shortest <= longest < math.inf:
        raise ValueError(f"shortest and longest must be positive and in this order, not {shortest!r}, {longest!r}.")
    if not 1e-13 <= tolerance <= 0.1:
        raise ValueError(f"tolerance must be between 1e-13 and 0.1, not {tolerance!r}.")
    unit = _cached("power", max(order, _LEAST_ORDER), longest / shortest, tolerance)
    return ExponentialSum(
        unit.rates / shortest, unit.weights * shortest**-order, unit.relative_error, shortest, longest
    )


@lru_cache(maxsize=256)
def _cached(target: Target, order: float, longest: float, tolerance: float) -> ExponentialSum:
    """The sum on [1, longest], from disk or computed, with the same bits."""
    key = {"target": target, "order": order, "longest": longest, "tolerance": tolerance, "version": _VERSION}
    parts = store.load(key)
    if parts is None or not _is_valid(parts, target, order, longest, tolerance):
        parts = _computed(target, order, longest, tolerance)
        store.save(key, *parts)
    return ExponentialSum(*parts, 1.0, longest)


def _is_valid(
    parts: tuple[Floats, Floats, float], target: Target, order: float, longest: float, tolerance: float
) -> bool:
    """Whether a sum from disk has the error and a length that it should have; takes 0.1 ms.

    With positive weights it is completely monotone, like the kernel, so errors between the lags are small too.
    """
    rates, weights, error = parts
    if rates.ndim != 1 or rates.shape != weights.shape or not 0.0 <= error <= tolerance:
        return False
    # distinct rates in ascending order, as computed: another order would change the last bits
    if rates.size > _MOST_TERMS or not (np.diff(rates) > 0.0).all():
        return False
    if not (np.isfinite(rates).all() and np.isfinite(weights).all() and (rates >= 0.0).all() and (weights > 0.0).all()):
        return False
    lags = lag_grid(max(longest, 2.0), _COMPARED_LAGS)
    return _error(rates, weights, lags, at_lags(target, order, lags)) <= 1.001 * error + _ROUNDING


def _computed(target: Target, order: float, longest: float, tolerance: float) -> tuple[Floats, Floats, float]:
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
    """A rough sum: s^(alpha - 1) in cells equal in log s, the first from 0, each replaced by its mean rate."""
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
    # the ends: exp(-alpha e^(-y)) equals the tolerance at the slow one, exp(-s) at the first lag at the fast one
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
