"""The past of a fractional derivative as weights on displacement increments.

On a grid of step h both discretisations used here have the form

    D^alpha x(t_n) = h^(-alpha) * sum_{j >= 0} c_j (x_{n-j} - x_{n-j-1}),

with positive weights that fall like j^(-alpha) / Gamma(1 - alpha):

* ``grunwald``: the Grunwald-Letnikov derivative summed by parts, c_j = Gamma(j + 1 - alpha) / (Gamma(1 - alpha) j!);
* ``average``: the mean of the kernel t^(-alpha) / Gamma(1 - alpha) over each step (the L1 formula),
  c_j = [(j + 1)^(1 - alpha) - j^(1 - alpha)] / Gamma(2 - alpha).

Both are Laplace transforms of a positive density g on the rates s per step, c_j = int_0^inf g(s) e^(-s j) ds.  So a
quadrature of that integral is a sum of decaying exponentials with positive weights, which costs the same at every step
of a run (:mod:`springpot.memory.exponential_sum`), while the weights themselves (:func:`direct`) cost more with every
step and serve as its oracle.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import special

__all__ = ["Family", "at_lags", "density", "direct"]

Family = Literal["grunwald", "average"]
_FAR = 1_000_000


def direct(family: Family, order: float, count: int) -> npt.NDArray[np.float64]:
    """The first ``count`` weights c_0, c_1, ... themselves.

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
    """
    j = np.arange(count, dtype=np.float64)
    if family == "grunwald":
        # in extended precision: the rounding of a million factors would show in the twelfth digit
        ratios = np.ones(count, np.longdouble)
        ratios[1:] = 1 - np.longdouble(order) / j[1:].astype(np.longdouble)
        return np.cumprod(ratios).astype(np.float64)
    weights = np.empty(count)
    weights[:1] = 1.0
    # (j + 1)^p - j^p without the cancellation
    power = 1.0 - order
    weights[1:] = j[1:] ** power * np.expm1(power * np.log1p(1.0 / j[1:]))
    return weights / special.gamma(2.0 - order)


def at_lags(family: Family, order: float, lags: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """The weights at some lags, however long.

    Parameters
    ----------
    family : {"grunwald", "average"}
    order : float
        alpha in [0, 1).
    lags : ndarray of int
        Increasing, not negative.

    Returns
    -------
    ndarray
        c at these lags, relative error below 1e-13.

    Examples
    --------
    >>> at_lags("grunwald", 0.5, np.array([1, 10**8])).round(9)
    array([5.0000e-01, 5.6419e-05])
    """
    near = lags[lags < _FAR]
    weights = direct(family, order, int(near[-1]) + 1 if near.size else 1)[near]
    far = lags[lags >= _FAR].astype(np.float64)
    if family == "grunwald":  # Tricomi and Erdelyi's expansion: the next term is of relative size 1 / (24 j^2)
        tail = (far + 0.5 * (1.0 - order)) ** -order / special.gamma(1.0 - order)
    else:
        power = 1.0 - order
        tail = far**power * np.expm1(power * np.log1p(1.0 / far)) / special.gamma(2.0 - order)
    return np.concatenate([weights, tail])


def density(family: Family, order: float, rates: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The density g(s) of which the weights are the Laplace transform, times s^(1 - alpha) to be finite at s = 0.

    Parameters
    ----------
    family : {"grunwald", "average"}
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
    forgotten = -np.expm1(-rates) / rates
    if family == "grunwald":
        return np.asarray(scale * np.exp(-rates * (1.0 - order)) * forgotten ** (order - 1.0))
    return np.asarray(scale * forgotten)
