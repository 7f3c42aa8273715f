"""A lognormal law of capacities, fitted by likelihood, with intervals by its profiles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize
from scipy.special import chdtrc, gammaincinv, log_ndtr, ndtr, ndtri, stdtrit, xlogy

from springpot.machine.arrays import Floats
from springpot.scattering.estimates import Interval

_SURE = 0.95
_CHI_SQUARED = 2.0 * float(gammaincinv(0.5, _SURE))  # that a value with one degree of freedom stays below
_LEAST, _MOST = 1e-3, 20.0  # dispersions that are looked at
_FAR = 60.0  # and medians, in logarithms beyond the intensities
_CLOSE = 1e-9
_ALL = {"no record exceeds": "any", "all records exceed": "each"}


@dataclass(frozen=True)
class Fit:
    """The median and the dispersion of a lognormal law, each with its 95 % interval.

    Attributes
    ----------
    median, dispersion : Interval
        In units of the intensity, and the standard deviation of the logarithm.
    covariance : tuple of float
        Of the logarithms of both: variance, covariance, variance; near the estimate.
    chance : float
        Of points that lie so far from the law or farther, if it is lognormal; NaN where there are no such points.
    """

    median: Interval
    dispersion: Interval
    covariance: tuple[float, float, float]
    chance: float = math.nan

    def probability(self, intensity: Floats) -> Floats:
        """That the capacity lies below."""
        return np.asarray(ndtr(np.log(intensity / self.median.value) / self.dispersion.value))

    def band(self, intensity: Floats) -> tuple[Floats, Floats]:
        """The ends of 95 % intervals of the probability at each intensity alone."""
        score = np.log(intensity / self.median.value) / self.dispersion.value
        one, both, other = self.covariance
        spread = np.sqrt(np.maximum(one / self.dispersion.value**2 + 2.0 * both * score / self.dispersion.value
                                    + other * score**2, 0.0))  # fmt: skip
        wide = float(ndtri(0.5 + 0.5 * _SURE)) * spread
        return np.asarray(ndtr(score - wide)), np.asarray(ndtr(score + wide))


def fit_counts(intensity: Floats, exceeded: Floats, tried: Floats) -> Fit:
    """From how many of so many exceeded the limit at each intensity.

    Raises
    ------
    ValueError
        If none did, all did, or one intensity parts those that did from those that did not: then any small dispersion
        is as likely.

    Examples
    --------
    >>> found = fit_counts(np.array([1.0, 2.0, 4.0]), np.array([2.0, 10.0, 18.0]), np.full(3, 20.0))
    >>> round(found.median.value, 3), round(found.dispersion.value, 2)
    (2.0, 0.54)
    """
    if not exceeded.any() or (exceeded == tried).all():
        which = "no path exceeds" if not exceeded.any() else "all paths exceed"
        raise ValueError(f"intensities must reach from below the limit to beyond it: {which} it at any of them.")
    if intensity[exceeded > 0].min() >= intensity[exceeded < tried].max():
        raise ValueError(
            "intensities must be closer together: none exceeds the limit below one of them and all do above it, so "
            "that the dispersion has no lower end."
        )
    logs = np.log(intensity)

    def likelihood(middle: float, dispersion: float) -> float:
        score = (logs - middle) / dispersion
        return float((exceeded * log_ndtr(score) + (tried - exceeded) * log_ndtr(-score)).sum())

    found = _fitted(likelihood, logs, _CHI_SQUARED)
    perfect = float((xlogy(exceeded, exceeded / tried) + xlogy(tried - exceeded, 1.0 - exceeded / tried)).sum())
    return _with_chance(found, likelihood, perfect, logs.size)


def fit_brackets(low: Floats, high: Floats) -> Fit:
    """From two intensities of each record between which its capacity lies; 0 and infinity are none.

    A record that is scaled from stripe to stripe has one capacity: how many of the same records exceed the limit at
    each stripe are no independent counts.

    Raises
    ------
    ValueError
        As `fit_counts`.

    Examples
    --------
    >>> low, high = np.repeat([0.0, 1.0, 2.0, 4.0], [2, 8, 8, 2]), np.repeat([1.0, 2.0, 4.0, np.inf], [2, 8, 8, 2])
    >>> found = fit_brackets(low, high)
    >>> round(found.median.value, 3), round(found.dispersion.value, 2), bool(found.median.low < 1.75)
    (2.0, 0.54, True)
    """
    if not (high < math.inf).any() or not (low > 0.0).any():
        which = "no record exceeds" if not (high < math.inf).any() else "all records exceed"
        raise ValueError(
            f"intensities must reach from below the limit to beyond it: {which} it at {_ALL[which]} of them."
        )
    if low.max() <= high.min():  # one intensity between all of them is enough for a dispersion of 0
        raise ValueError(
            "intensities must be closer together: the capacities of all records lie next to one of them, so that "
            "the dispersion has no lower end."
        )
    with np.errstate(divide="ignore"):
        below, above = np.log(low), np.log(high)

    def likelihood(middle: float, dispersion: float) -> float:
        first, last = (below - middle) / dispersion, (above - middle) / dispersion
        first, last = np.where(first > 0.0, -last, first), np.where(first > 0.0, -first, last)  # the tail with digits
        upper, lower = log_ndtr(last), log_ndtr(first)
        return float((upper + np.log(np.maximum(-np.expm1(np.minimum(lower - upper, -1e-300)), 1e-300))).sum())

    return _fitted(likelihood, np.log([*low[low > 0.0], *high[high < math.inf]]), _CHI_SQUARED)


def fit_probabilities(intensity: Floats, logarithm: Floats, error: Floats) -> Fit:
    """From the logarithms of probabilities at each intensity, with their standard errors.

    Examples
    --------
    >>> intensity = np.array([1.0, 1.5, 2.0])
    >>> found = fit_probabilities(intensity, log_ndtr(np.log(intensity / 4.0) / 0.3), np.full(3, 0.1))
    >>> round(found.median.value, 6), round(found.dispersion.value, 6)
    (4.0, 0.3)
    """
    logs = np.log(intensity)

    def likelihood(middle: float, dispersion: float) -> float:
        return float(-0.5 * (((log_ndtr((logs - middle) / dispersion) - logarithm) / error) ** 2).sum())

    found = _fitted(likelihood, logs, _CHI_SQUARED)
    return _with_chance(found, likelihood, 0.0, logs.size)


def _with_chance(found: Fit, likelihood: Callable[[float, float], float], perfect: float, points: int) -> Fit:
    """By twice the lack of the likelihood, about chi-squared with two degrees of freedom less than points."""
    lack = perfect - likelihood(math.log(found.median.value), found.dispersion.value)
    return replace(found, chance=float(chdtrc(points - 2, 2.0 * lack))) if points > 2 else found


def fit_cloud(intensity: Floats, demand: Floats, limit: float) -> tuple[Fit, float, float]:
    """From a demand of each record: its logarithm is a straight line in that of the intensity, with normal deviations.

    Returns
    -------
    fit : Fit
    slope : float
    curved : float
        How many standard errors a term of second order is from 0.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> intensity = rng.lognormal(0.0, 0.5, 200)
    >>> demand = 0.1 * intensity**1.2 * rng.lognormal(0.0, 0.24, 200)  # exceeds 0.2 at 2^(1 / 1.2), with 0.24 / 1.2
    >>> found, slope, _ = fit_cloud(intensity, demand, 0.2)
    >>> bool(abs(found.median.value / 1.782 - 1.0) < 0.1), bool(abs(found.dispersion.value - 0.2) < 0.03)
    (True, True)
    """
    logs, values, count = np.log(intensity), np.log(demand / limit), intensity.size
    slope, _ = np.polyfit(logs, values, 1)
    if not slope > 0.0:
        raise ValueError(f"measure must be one with which the demand grows, but its slope is {slope:.3g}.")
    if count > 4:
        curve, covariance = np.polyfit(logs, values, 2, cov=True)
        curved = float(abs(curve[0]) / math.sqrt(covariance[0, 0]))
    else:
        curved = 0.0

    def likelihood(middle: float, dispersion: float) -> float:
        """At the best slope: deviations are b (logs - middle) with the size b times the dispersion."""
        # maximum over b of -n ln(b s) - sum (values - b z)^2 / (2 b^2 s^2), z = logs - middle: with q = 1 / b
        z = logs - middle
        a, cross, square = float(values @ values), float(values @ z), float(z @ z)
        s2 = dispersion**2
        # n / q - (a q - cross) / s2 = 0
        q = (cross + math.sqrt(cross**2 + 4.0 * a * count * s2)) / (2.0 * a)
        return count * math.log(q / dispersion) - 0.5 * (a * q * q - 2.0 * cross * q + square) / s2

    drop = count * math.log1p(float(stdtrit(count - 2, 0.5 + 0.5 * _SURE)) ** 2 / (count - 2))
    return _fitted(likelihood, logs, drop), float(slope), curved


def _fitted(likelihood: Callable[[float, float], float], logs: Floats, drop: float) -> Fit:
    """The largest likelihood, and where twice its logarithm has fallen by ``drop`` along the profiles."""
    spread = max(float(logs.std()), 0.1)

    def minus(place: Floats) -> float:
        return -likelihood(float(place[0]), math.exp(float(np.clip(place[1], -12.0, 6.0))))

    starts = [np.array([float(logs.mean()) + shift, math.log(spread)]) for shift in (0.0, spread, -spread)]
    found = min(
        (optimize.minimize(minus, start, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-11, "maxiter": 4000})
         for start in starts), key=lambda each: float(each.fun),
    )  # fmt: skip
    middle, log_dispersion, top = float(found.x[0]), float(found.x[1]), -float(found.fun)
    if log_dispersion > math.log(_MOST):
        raise ValueError("intensities must be ones with which the share beyond the limit grows: here it does not.")

    def profile(fixed: int) -> Callable[[float], float]:
        """Twice the fall of the likelihood at a value of one number, at the best value of the other."""
        last = [log_dispersion if fixed == 0 else middle]

        def fall(value: float) -> float:
            def of_other(other: float) -> float:
                return minus(np.array([value, other] if fixed == 0 else [other, value]))

            best = optimize.minimize_scalar(of_other, bracket=(last[0], last[0] + 0.05), tol=_CLOSE)
            last[0] = float(best.x)
            return 2.0 * (float(best.fun) + top) - drop

        return fall

    ends = []
    for fixed, start, farthest in ((0, middle, _FAR), (1, log_dispersion, math.log(_MOST / _LEAST))):
        for sign in (-1.0, 1.0):
            fall, far = profile(fixed), 0.05
            while far < farthest and fall(start + sign * far) < 0.0:
                far *= 1.6
            if far >= farthest:
                ends.append(sign * math.inf)
                continue
            fresh = profile(fixed)
            ends.append(float(optimize.brentq(fresh, start, start + sign * far, xtol=1e-7)))
    lower, upper, least, most = (math.exp(end) if end < 700.0 else math.inf for end in ends)
    covariance = _inverse_curvature(minus, found.x)
    errors = [math.sqrt(own) if own > 0.0 else math.inf for own in np.diag(covariance).tolist()]
    median, dispersion = math.exp(middle), math.exp(log_dispersion)
    return Fit(
        Interval(median, median * errors[0], lower, upper), Interval(dispersion, dispersion * errors[1], least, most),
        (float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])),
    )  # fmt: skip


def _inverse_curvature(function: Callable[[Floats], float], place: Floats, step: float = 1e-3) -> Floats:
    """The inverse of the matrix of second derivatives: the covariance of an estimate by likelihood."""
    steps, at = step * np.eye(2), function(place)
    found = np.empty((2, 2))
    for i in range(2):
        found[i, i] = (function(place + steps[i]) - 2.0 * at + function(place - steps[i])) / step**2
    corners = [sign * function(place + steps[0] + sign * steps[1]) - sign * function(place - steps[0] + sign * steps[1])
               for sign in (1.0, -1.0)]  # fmt: skip
    found[0, 1] = found[1, 0] = sum(corners) / (4.0 * step**2)
    return np.asarray(np.linalg.pinv(found))
