"""A root between two places and Riemann's zeta function, without SciPy, which takes longer to load than a short run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from springpot.machine.arrays import Floats

_FIRST = 10.0  # of zeta: of the terms that are not summed one by one
_EVEN = (1 / 12, -1 / 720, 1 / 30240, -1 / 1209600, 1 / 47900160, -691 / 1307674368000)  # B_2k / (2 k)!


def root_between(
    function: Callable[[float], Any], low: float, high: float, *, xtol: float = 2e-12, rtol: float = 9e-16
) -> float:
    """A root of a continuous function that has different signs at two places.

    Brent's method (R. P. Brent, "Algorithms for minimization without derivatives", 1973, chapter 4), as SciPy has it.

    Parameters
    ----------
    function : callable
    low, high : float
    xtol, rtol : float
        Absolute and relative error of the place.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If the signs are the same.

    Examples
    --------
    >>> round(root_between(lambda x: x * x - 2.0, 0.0, 2.0), 12)
    1.414213562373
    """
    before, now = low, high
    at_before, at_now = float(function(before)), float(function(now))
    if at_before == 0.0:
        return before
    if at_now == 0.0:
        return now
    if not at_before * math.copysign(1.0, at_now) < 0.0:
        raise ValueError("function must have different signs at low and high.")
    # the root lies between ``now`` and ``other``; ``step`` and ``last`` are the last two steps
    other, at_other, last, step = before, at_before, 0.0, 0.0
    while True:
        if at_before != 0.0 and (at_before < 0.0) != (at_now < 0.0):
            other, at_other = before, at_before
            last = step = now - before
        if abs(at_other) < abs(at_now):
            before, now, other = now, other, now
            at_before, at_now, at_other = at_now, at_other, at_now
        least, half = 0.5 * (xtol + rtol * abs(now)), 0.5 * (other - now)
        if at_now == 0.0 or abs(half) < least or now + half in (now, other):
            return now
        tried = math.inf
        if abs(last) > least and abs(at_now) < abs(at_before):  # where a line, or a hyperbola through three, is 0
            if before == other:
                above, below = -at_now * (now - before), at_now - at_before
            else:
                first, second = (at_before - at_now) / (before - now), (at_other - at_now) / (other - now)
                above = -at_now * (at_other * second - at_before * first)
                below = second * first * (at_other - at_before)
            tried = above / below if below != 0.0 else math.inf
        shorter = 2.0 * abs(tried) < min(abs(last), 3.0 * abs(half) - least)
        last, step = (step, tried) if shorter else (half, half)
        before, at_before = now, at_now
        now += step if abs(step) > least else math.copysign(least, half)
        at_now = float(function(now))


def zeta_beyond_one(excess: ArrayLike) -> Floats:
    """zeta(1 + e), to rounding, by Euler and Maclaurin's sum.

    Parameters
    ----------
    excess : float or array_like
        e > 0: so nothing is lost near the pole.

    Returns
    -------
    ndarray
        Of the shape of ``excess``.

    Examples
    --------
    >>> round(float(zeta_beyond_one(1.0)) * 6.0 / math.pi**2, 14)
    1.0
    """
    import numpy as np  # the parts of a system, which the help of a command lists, need none of it

    e = np.asarray(excess, float)
    s = 1.0 + e
    correction, product = np.zeros_like(s), s * _FIRST ** (-s - 1.0)
    for j, number in enumerate(_EVEN):
        correction += number * product
        product *= (s + 2.0 * j + 1.0) * (s + 2.0 * j + 2.0) / _FIRST**2
    one_by_one = np.arange(_FIRST - 1.0, 0.0, -1.0) ** -s[..., None]  # the smallest first
    return np.asarray(one_by_one.sum(axis=-1) + (correction + 0.5 * _FIRST**-s + _FIRST**-e / e))
