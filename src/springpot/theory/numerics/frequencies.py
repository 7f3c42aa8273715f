"""Integrals over frequency of what resonates: in the logarithm of the frequency, cut at every resonance."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
from scipy import optimize

from springpot.machine.arrays import Complexes, Floats
from springpot.theory.numerics.panels import on_panels
from springpot.theory.result import NoConvergenceError

_FAR = 45.0  # logarithms beyond the outermost frequencies, where exp(-45) of an integrand is left
_POINTS = 4000
_MOST_ERROR = 2e-8
_NODES, _HALVINGS, _MOST_PANELS, _SETTLED = 20, 25, 10_000, 1e-13
_NARROW = "an integral over frequency did not settle: the resonance is too narrow, or too far off."
_SLOPE = 0.01  # logarithms over which the power of a density is seen
_WIDTHS = (0.3, 1.0, 3.0, *(10.0**power for power in range(1, 13)))  # of a resonance, at which the integral is cut


def resonances(stiffness: Callable[[Floats], Complexes], scales: Iterable[float]) -> list[float]:
    """Logarithms of the frequencies at which to cut an integral of 1 / \\|stiffness\\|^2.

    Parameters
    ----------
    stiffness : callable
        The dynamic stiffness D(w) of arrays of frequencies w > 0.
    scales : iterable of float
        Frequencies around which it changes; its resonances lie within a factor of 1e4 of them.

    Returns
    -------
    list of float
        Sorted, the ends of the integral included.

    Examples
    --------
    >>> cuts = resonances(lambda w: 1.0 - w**2 + 1e-3j * w, [1.0])
    >>> min(abs(cut) for cut in cuts) < 1e-6
    True
    """
    logs = [math.log(scale) for scale in scales if 0.0 < scale < math.inf]
    low, high = min(logs), max(logs)
    grid = np.linspace(low - 9.0, high + 9.0, _POINTS)
    size = np.abs(stiffness(np.exp(grid)))
    start = low - _FAR
    cuts = {start, high + _FAR, *logs}
    for place in np.flatnonzero((size[1:-1] < size[:-2]) & (size[1:-1] <= size[2:])) + 1:
        peak = _refined(stiffness, grid[place - 1], grid[place + 1])
        width = _half_width(stiffness, peak)
        factors = [factor for factor in _WIDTHS if width * factor < 3.0]
        cuts |= {peak, *(peak + sign * width * factor for factor in factors for sign in (-1.0, 1.0))}
    return sorted(cut for cut in cuts if start <= cut <= high + _FAR)


def integrals(
    densities: Callable[[Floats], Floats], cuts: list[float], within: Floats, as_powers: bool = False
) -> Floats:
    """The integrals of several densities over all frequencies, positive and negative, of even functions of w.

    They are sums over panels, which are halved where they are not fine enough.

    Parameters
    ----------
    densities : callable
        Of an array of frequencies w > 0: an array of shape (frequencies, densities).
    cuts : list of float
        Of `resonances`.
    within : ndarray, shape (densities,)
        Errors that do not matter.
    as_powers : bool
        Whether they go on below the first cut as powers of the frequency, above its power -1.

    Raises
    ------
    NoConvergenceError
        If an integral is not known to 2e-8 of its size.

    Examples
    --------
    >>> cuts = resonances(lambda w: 1.0 - w**2 + 0.4j * w, [1.0])
    >>> found = integrals(lambda w: 1.0 / abs(1.0 - w**2 + 0.4j * w)[:, None] ** 2, cuts, np.zeros(1))
    >>> round(float(found[0]) / (2.0 * math.pi), 12)  # 1 / (2 c)
    1.25
    """

    def on(low: Floats, high: Floats) -> Floats:
        nodes, weights = on_panels(low, high, _NODES)
        w = np.exp(nodes)
        there = densities(w.ravel()).reshape(*w.shape, -1)
        return np.asarray(np.einsum("pn,pnd->pd", weights * w, there))

    low, high = np.array(cuts[:-1]), np.array(cuts[1:])
    found, done, left = on(low, high), np.zeros(len(within)), np.zeros(len(within))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        finer = on(low, high)
        both = finer[: len(middle)] + finer[len(middle) :]
        errors = np.abs(both - found)
        open_ = np.any(errors > _SETTLED * (done + both.sum(axis=0)) + within / len(cuts), axis=1)
        done += both[~open_].sum(axis=0)
        left += errors[~open_].sum(axis=0)
        kept = np.tile(open_, 2)
        low, high, found = low[kept], high[kept], finer[kept]
        if not open_.any() or len(found) > _MOST_PANELS:  # of nothing but rounding all would be halved for ever
            break
    done += found.sum(axis=0)
    left += errors[open_].sum(axis=0)
    if not np.all(left <= np.maximum(_MOST_ERROR * done, within)):
        raise NoConvergenceError(_NARROW)
    if as_powers:
        ends = np.exp(cuts[0] + np.array([0.0, _SLOPE]))
        last, above = ends[:, None] * densities(ends)
        with np.errstate(divide="ignore", invalid="ignore"):
            done += np.where(last > 0.0, last * _SLOPE / np.log(above / last), 0.0)
    return 2.0 * done


def _refined(stiffness: Callable[[Floats], Complexes], low: float, high: float) -> float:
    """The logarithm of the frequency at which the real part vanishes, or else the size is least."""

    def real(u: float) -> float:
        return float(stiffness(np.array([math.exp(u)]))[0].real)

    if real(low) * real(high) < 0.0:
        return float(optimize.brentq(real, low, high, xtol=1e-15, rtol=1e-15))
    least = optimize.minimize_scalar(
        lambda u: float(abs(stiffness(np.array([math.exp(u)]))[0])), bounds=(low, high), method="bounded"
    )
    return float(least.x)


def _half_width(stiffness: Callable[[Floats], Complexes], peak: float) -> float:
    """Half the width of a resonance in the logarithm of the frequency, from the slope of the real part."""
    step = 1e-5
    below, there, above = stiffness(np.exp([peak - step, peak, peak + step]))
    slope = abs((above - below).real) / (2.0 * step)
    width = abs(there.imag) / slope if slope > 0.0 else 1.0
    return min(max(width, 1e-12), 1.0)
