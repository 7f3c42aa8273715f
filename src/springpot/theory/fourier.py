"""The Fourier series of |cos p| and the integrals that its fractional derivative needs (the paper's Eq. 10 and 13)."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import finite_number
from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import shown

__all__ = [
    "coefficients",
    "cosine_integral",
    "partial_sum",
    "sine_integral",
    "truncation_bound",
    "truncation_error",
]

_Branch = Callable[[Floats], Floats]

# Below this phase k t a Gauss-Jacobi rule resolves the oscillation; above it the tail from k t to infinity is smooth
# along the imaginary direction, for a Gauss-Laguerre rule.  Both are accurate to rounding on their side.
_SWITCH = 12.0
_NODES = 40


def coefficients(terms: int) -> Floats:
    """Coefficients A_m of \\|cos p\\| = 2/pi - sum_m A_m cos 2mp, for m = 1 ... terms (paper's Eq. 10).

    Parameters
    ----------
    terms : int
        Number of terms, at least 0.

    Returns
    -------
    ndarray, shape (terms,)
        A_m = (4 / pi) (-1)^m / (4 m^2 - 1), dimensionless.

    Raises
    ------
    TypeError, ValueError
        If ``terms`` is not an integer or is negative.

    Examples
    --------
    >>> coefficients(2).round(4)
    array([-0.4244,  0.0849])
    """
    m = np.arange(1, _count(terms) + 1)
    return 4.0 / math.pi * np.where(m % 2 == 0, 1.0, -1.0) / (4.0 * m * m - 1.0)


def partial_sum(phase: ArrayLike, terms: int) -> Floats:
    """Sum of the series of \\|cos p\\| up to m = terms (paper's Eq. 10, Fig. 1).

    Parameters
    ----------
    phase : array_like
        p in rad, any shape.
    terms : int
        Number of cosine terms, at least 0; with 0 the mean 2/pi is left.

    Returns
    -------
    ndarray
        Same shape as ``phase``.

    Raises
    ------
    TypeError, ValueError
        If ``terms`` is not an integer or is negative.

    Examples
    --------
    >>> float(partial_sum(0.0, 10).round(5))
    0.99856
    """
    p = np.asarray(phase, dtype=float)
    amplitudes = coefficients(terms)
    harmonics = np.cos(2.0 * np.multiply.outer(p, np.arange(1, amplitudes.size + 1)))
    return np.asarray(2.0 / math.pi - harmonics @ amplitudes)


def truncation_error(phase: ArrayLike, terms: int) -> Floats:
    """The partial sum minus \\|cos p\\|.

    Parameters and errors are those of `partial_sum`; the result has the shape of ``phase`` and never exceeds
    `truncation_bound` in size.

    Examples
    --------
    >>> bool(abs(truncation_error(1.0, 4)) <= truncation_bound(4))
    True
    """
    return np.asarray(partial_sum(phase, terms) - np.abs(np.cos(np.asarray(phase, dtype=float))))


def truncation_bound(terms: int) -> float:
    """Largest truncation error over all phases: 2 / (pi (2 n + 1)) after n terms, exactly.

    At p = pi/2 every omitted term has the same sign, so the triangle inequality is an equality there, and the sum
    of the omitted 4 / (pi (4 m^2 - 1)) telescopes.  The bound is reached at p = pi/2 and nowhere exceeded.

    Parameters
    ----------
    terms : int
        n, at least 0.

    Returns
    -------
    float

    Raises
    ------
    TypeError, ValueError
        If ``terms`` is not an integer or is negative.

    Examples
    --------
    >>> round(truncation_bound(10), 6)
    0.030315
    """
    return 2.0 / (math.pi * (2 * _count(terms) + 1))


def cosine_integral(
    wavenumber: ArrayLike, time: ArrayLike, alpha: float, *, form: Literal["exact", "asymptotic"] = "exact"
) -> Floats:
    """int_0^t cos(k s) s^-alpha ds (paper's Eq. 13a).

    Parameters
    ----------
    wavenumber : array_like
        k > 0 in rad/s; in the paper k = 2 m Omega.
    time : array_like
        t > 0 in s; broadcast against ``wavenumber``.
    alpha : float
        Order in [0, 1).  At alpha = 1 the integral diverges at its lower end for every t > 0, which is an error here;
        divided by Gamma(1 - alpha) it tends to 1 there.
    form : {"exact", "asymptotic"}
        ``"exact"`` holds at every t, to about 1e-13 of its size or, between its zeros, of the oscillation
        k^(alpha-1) (k t)^-alpha.  ``"asymptotic"`` is the paper's one term,
        k^(alpha-1) [Gamma(1-alpha) sin(alpha pi/2) + sin(kt) / (kt)^alpha]; its error is of order (kt)^-(1+alpha).

    Returns
    -------
    ndarray
        Unit s^(1 - alpha), broadcast shape.

    Raises
    ------
    TypeError, ValueError
        If alpha is not in [0, 1), k or t is not positive and finite, or ``form`` is another word.

    Examples
    --------
    >>> float(cosine_integral(6.0, 10.0, 0.5).round(6))
    0.49602
    >>> float(cosine_integral(6.0, 10.0, 0.5, form="asymptotic").round(6))
    0.495598
    """
    a = finite_number(alpha, "alpha", low=0.0, high=1.0)
    if a == 1.0:
        raise ValueError("the cosine integral diverges at alpha = 1: alpha must be in [0, 1).")
    k, z = _phase(wavenumber, time)
    limit = math.gamma(1.0 - a) * math.sin(a * math.pi / 2.0)
    if _is_asymptotic(form):
        return np.asarray(k ** (a - 1.0) * (limit + np.sin(z) / z**a))
    nodes, weights = _jacobi(a)

    def near(phase: Floats) -> Floats:
        # cos = 1 - 2 sin^2: the singular part, 1/(1 - alpha), is analytical, so that no digits are lost for alpha -> 1
        dip = 2.0 * np.sin(np.multiply.outer(phase, nodes / 2.0)) ** 2
        return np.asarray(phase ** (1.0 - a) * (1.0 / (1.0 - a) - dip @ weights))

    return np.asarray(k ** (a - 1.0) * _by_size(z, near, lambda phase: limit + _tail(phase, a).real))


def sine_integral(
    wavenumber: ArrayLike, time: ArrayLike, alpha: float, *, form: Literal["exact", "asymptotic"] = "exact"
) -> Floats:
    """int_0^t sin(k s) s^-alpha ds (paper's Eq. 13b).

    Parameters
    ----------
    wavenumber : array_like
        k > 0 in rad/s; in the paper k = 2 m Omega.
    time : array_like
        t > 0 in s; broadcast against ``wavenumber``.
    alpha : float
        Order in [0, 1].  At alpha = 1 it is the sine integral Si(kt), which tends to pi/2.
    form : {"exact", "asymptotic"}
        ``"exact"`` holds at every t, to about 1e-13 of its size or, between its zeros, of the oscillation
        k^(alpha-1) (k t)^-alpha.  ``"asymptotic"`` is the paper's one term,
        k^(alpha-1) [Gamma(1-alpha) cos(alpha pi/2) - cos(kt) / (kt)^alpha]; its error is of order (kt)^-(1+alpha).

    Returns
    -------
    ndarray
        Unit s^(1 - alpha), broadcast shape.

    Raises
    ------
    TypeError, ValueError
        If alpha is not in [0, 1], k or t is not positive and finite, or ``form`` is another word.

    Examples
    --------
    >>> float(sine_integral(1.0, 2.0, 1.0).round(6))
    1.605413
    """
    a = finite_number(alpha, "alpha", low=0.0, high=1.0)
    k, z = _phase(wavenumber, time)
    # Gamma(1-a) cos(a pi/2) by the reflection formula, finite at both ends: 1 at a = 0 and pi/2 at a = 1.
    limit = 1.0 / (math.gamma(1.0 + a) * float(np.sinc(a / 2.0)))
    if _is_asymptotic(form):
        return np.asarray(k ** (a - 1.0) * (limit - np.cos(z) / z**a))
    nodes, weights = _jacobi(a)

    def near(phase: Floats) -> Floats:
        return np.asarray(phase ** (1.0 - a) * (np.sin(np.multiply.outer(phase, nodes)) @ weights))

    return np.asarray(k ** (a - 1.0) * _by_size(z, near, lambda phase: limit + _tail(phase, a).imag))


def _count(terms: int) -> int:
    if isinstance(terms, bool) or not isinstance(terms, int | np.integer):
        raise TypeError(f"terms must be an integer, not {shown(terms)}.")
    if terms < 0:
        raise ValueError(f"terms must be at least 0, not {terms}.")
    return int(terms)


def _phase(wavenumber: ArrayLike, time: ArrayLike) -> tuple[Floats, Floats]:
    """k and k t, broadcast."""
    k, t = np.broadcast_arrays(np.asarray(wavenumber, dtype=float), np.asarray(time, dtype=float))
    z = k * t
    if not (np.all(k > 0.0) and np.all(t > 0.0) and np.all(np.isfinite(k)) and np.all(np.isfinite(z))):
        raise ValueError("wavenumber and time must be positive and finite.")
    return k, z


def _is_asymptotic(form: str) -> bool:
    if form not in ("exact", "asymptotic"):
        raise ValueError(f"form must be 'exact' or 'asymptotic', not {shown(form)}.")
    return form == "asymptotic"


def _by_size(z: Floats, near: _Branch, far: _Branch) -> Floats:
    result = np.empty(z.shape)
    small = z <= _SWITCH
    result[small] = near(z[small])
    result[~small] = far(z[~small])
    return result


@lru_cache(maxsize=32)
def _jacobi(alpha: float) -> tuple[Floats, Floats]:
    """Rule for int_0^1 g(u) u^-alpha du with g(0) = 0: nodes u and weights for g(u)."""
    from scipy import special  # slow to import, and most runs need none of it

    x, w = special.roots_jacobi(_NODES, 0.0, 1.0 - alpha)
    u = (x + 1.0) / 2.0
    return u, w * 2.0 ** (alpha - 2.0) / u


@lru_cache(maxsize=1)
def _laguerre() -> tuple[Floats, Floats]:
    from scipy import special  # slow to import, and most runs need none of it

    x, w = special.roots_laguerre(_NODES)
    return x, w


def _tail(phase: Floats, alpha: float) -> Complexes:
    """-int_z^inf e^(iu) u^-alpha du, along u = z + i y, where it decays without oscillating."""
    y, w = _laguerre()
    smooth = (phase[:, None] + 1j * y) ** -alpha @ w
    return np.asarray(-1j * np.exp(1j * phase) * smooth)
