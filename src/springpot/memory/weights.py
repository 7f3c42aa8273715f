"""The memory weights of a fractional derivative, which multiply displacement increments.

On a grid of step h both discretizations used here have the form

    D^alpha x(t_n) = h^(-alpha) * sum_{j >= 0} c_j (x_{n-j} - x_{n-j-1}),

with positive weights that fall like j^(-alpha) / Gamma(1 - alpha):

* ``grunwald``: the Grunwald-Letnikov derivative summed by parts, c_j = Gamma(j + 1 - alpha) / (Gamma(1 - alpha) j!);
* ``average``: the mean of the kernel t^(-alpha) / Gamma(1 - alpha) over each step (the L1 formula),
  c_j = [(j + 1)^(1 - alpha) - j^(1 - alpha)] / Gamma(2 - alpha).

Both are Laplace transforms of a positive density g on the rates s per step, c_j = int_0^inf g(s) e^(-s j) ds.  So a
quadrature of that integral is a sum of decaying exponentials with positive weights, which costs the same at every step
of a run (:mod:`springpot.memory.exponential_sum`), while the weights themselves (:func:`direct`) cost more with every
step and serve as its reference.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from springpot.machine.arrays import Floats

Family = Literal["grunwald", "average"]
Target = Literal["grunwald", "average", "power"]
_STIRLING = 30


def direct(family: Family, order: float, count: int) -> Floats:
    """The first ``count`` weights c_0, c_1, ...

    They apply to the increments of the displacement, the latest first, and h^-alpha times their sum is the derivative:
    D^alpha x(t_n) = h^-alpha [c_0 (x_n - x_{n-1}) + c_1 (x_{n-1} - x_{n-2}) + ...].  They are not those of the
    displacements themselves, as in the usual form of the Grunwald-Letnikov derivative.

    Parameters
    ----------
    family : {"grunwald", "average"}
    order : float
        alpha in [0, 1].
    count : int

    Returns
    -------
    ndarray, shape (count,)
        Dimensionless; relative error below 1e-13 for up to 1e6 weights.

    Examples
    --------
    >>> direct("grunwald", 0.5, 4)
    array([1.    , 0.5   , 0.375 , 0.3125])

    The derivative of order 0.5 of t at t = 1 is 2 / sqrt(pi) = 1.128.

    >>> t = np.linspace(0.0, 1.0, 1001)
    >>> round(float(0.001**-0.5 * direct("average", 0.5, 1000) @ np.diff(t)[::-1]), 3)
    1.128
    """
    j = np.arange(count, dtype=np.float64)
    if family == "grunwald":
        # in extended precision: the rounding errors of a million factors would reach the twelfth digit
        ratios = np.ones(count, np.longdouble)
        ratios[1:] = 1 - np.longdouble(order) / j[1:].astype(np.longdouble)
        return np.cumprod(ratios).astype(np.float64)
    return np.concatenate([[1.0 / math.gamma(2.0 - order)][:count], at_lags(family, order, j[1:])])


def at_lags(target: Target, order: float, lags: Floats) -> Floats:
    """The weights at any lags, also very long ones and between the steps.

    Parameters
    ----------
    target : {"grunwald", "average", "power"}
        "power" is t^(-alpha) itself.
    order : float
        alpha in [0, 1).
    lags : ndarray
        At least 1; in steps, for the weights.

    Returns
    -------
    ndarray
        c at these lags, relative error below 1e-13.

    Examples
    --------
    >>> at_lags("grunwald", 0.5, np.array([1.0, 1e8])).round(9)
    array([5.0000e-01, 5.6419e-05])
    """
    if target == "power":
        return np.asarray(lags**-order)
    if target == "average":
        power = 1.0 - order  # (t + 1)^p - t^p without the cancellation
        return np.asarray(lags**power * np.expm1(power * np.log1p(1.0 / lags)) / math.gamma(2.0 - order))
    # c(t) = c(t + 1) (t + 1) / (t + 1 - alpha), up to lags where Stirling's series is exact to rounding
    last = lags + _STIRLING
    shifts = np.arange(1.0, _STIRLING + 1.0)[:, None]
    return np.asarray(np.prod(1.0 + order / (lags + shifts - order), axis=0) * _gamma_ratio(last + 1.0, order))


def _gamma_ratio(z: Floats, order: float) -> Floats:
    """Gamma(z - alpha) / (Gamma(z) Gamma(1 - alpha)) for z > 30, where Stirling's series to z^(-7) is exact."""

    def series(x: Floats) -> Floats:
        q = 1.0 / (x * x)
        return np.asarray((1.0 / 12.0 - q * (1.0 / 360.0 - q * (1.0 / 1260.0 - q / 1680.0))) / x)

    # the logarithm of z^alpha times the ratio, free of the cancellation of two long logarithms
    logarithm = (z - order - 0.5) * np.log1p(-order / z) + order + series(z - order) - series(z)
    return np.asarray(z**-order * np.exp(logarithm) / math.gamma(1.0 - order))


def density(target: Target, order: float, rates: Floats) -> Floats:
    """The density g(s) of which the weights are the Laplace transform, times s^(1 - alpha) to be finite at s = 0.

    Parameters
    ----------
    target : {"grunwald", "average", "power"}
    order : float
        alpha in (0, 1).
    rates : ndarray
        Rates s > 0, per step.

    Returns
    -------
    ndarray
        s^(1 - alpha) g(s).

    Examples
    --------
    >>> density("average", 0.5, np.array([1e-9])).round(6)
    array([0.31831])
    """
    scale = math.sin(math.pi * min(order, 1.0 - order)) / math.pi  # no cancellation near order 1
    if target == "power":
        return np.full_like(rates, 1.0 / math.gamma(order))
    decayed = -np.expm1(-rates) / rates
    if target == "grunwald":
        return np.asarray(scale * np.exp(-rates * (1.0 - order)) * decayed ** (order - 1.0))
    return np.asarray(scale * decayed)
