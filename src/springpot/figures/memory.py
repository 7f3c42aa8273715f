"""Pictures of a power law as a sum of exponentials: terms, error, and number of terms."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.designs import from_zero
from springpot.figures.style import COLORS, panel
from springpot.memory import power_law_sum
from springpot.memory.exponential_sum import mclean

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ORDERS = {0.25: ("blue", "o"), 0.5: ("vermilion", "s"), 0.75: ("green", "^")}


def even_spacing_terms(tolerance: float, ratio: float) -> float:
    """Number of terms for equidistant rates in log s, without the ends of the range: log(1/eps) log(T/delta) / pi^2.

    With s = e^y, t^(-alpha) = int exp(alpha y - t e^y) dy / Gamma(alpha).  By Poisson's formula the trapezoidal rule of
    spacing h has the relative error 2 |Gamma(alpha + 2 pi i / h)| / Gamma(alpha) in its first harmonic, the same at
    every t; and |Gamma(alpha + i w)| ~ sqrt(2 pi) w^(alpha - 1/2) exp(-pi w / 2).  So eps ~ exp(-pi^2 / h) up to a
    power of log(1 / eps), and log(T / delta) / h rates lie between 1 / T and 1 / delta.  Further terms of a sum are at
    the two ends of the interval.  Best approximation has the same exponent: for 1 / t on [1, R] the error of n terms is
    of order exp(-n pi^2 / log(8 R)) (Braess and Hackbusch), where the 8 is due to the ends.

    Parameters
    ----------
    tolerance : float
        eps, relative.
    ratio : float
        T / delta, longest lag over shortest.

    Returns
    -------
    float
        An asymptote, not a bound.

    References
    ----------
    D. Braess and W. Hackbusch, "On the efficient computation of high-dimensional integrals and the approximation by
    exponential sums", in: Multiscale, Nonlinear and Adaptive Approximation, Springer 2009, 39-74; G. Beylkin and
    L. Monzon, Applied and Computational Harmonic Analysis 28 (2010) 131-149, for the trapezoidal rule.

    Examples
    --------
    >>> round(even_spacing_terms(1e-6, 1e6), 1)
    19.3
    """
    return -math.log(tolerance) * math.log(ratio) / math.pi**2


def plot_terms_against_tolerance(
    ax: Axes | None = None,
    *,
    tolerances: Sequence[float] = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
) -> Axes:
    """Draw the number of terms of t^(-alpha) over six decades of lags against the tolerance.

    Full lines and filled marks are the sums used here, dashed lines and hollow marks McLean's, and the dotted line is
    `springpot.figures.memory.even_spacing_terms`.

    Parameters
    ----------
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    tolerances : sequence of float
        Relative errors allowed, in [1e-13, 0.1].

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If a tolerance is out of its range.

    Examples
    --------
    >>> axes = plot_terms_against_tolerance(tolerances=[1e-2, 1e-3])
    >>> [int(terms) for terms in axes.lines[0].get_ydata()]  # at order 0.25
    [8, 11]
    """
    ax = panel(ax, 6.0, 4.2)
    for order, (color, mark) in _ORDERS.items():
        ours = [power_law_sum(order, 1e-3, 1e3, float(eps)).rates.size for eps in tolerances]
        theirs = [mclean("power", order, 1e6, float(eps))[0].size for eps in tolerances]
        for terms, style, face, name in ((ours, "-", None, "fewest"), (theirs, "--", "none", "McLean")):
            ax.plot(
                tolerances, terms, style, marker=mark, markersize=5.0, markerfacecolor=face,
                color=COLORS[color], label=f"{name}, $\\alpha$ = {order:g}",
            )  # fmt: skip
    asymptote = [even_spacing_terms(float(eps), 1e6) for eps in tolerances]
    label = r"$\ln(1/\varepsilon)\,\ln(T/\delta)/\pi^2$"
    ax.plot(tolerances, asymptote, ":", color=COLORS["black"], label=label)
    ax.set_xscale("log")
    ax.invert_xaxis()
    from_zero(ax)
    ax.set_xlabel(
        r"Tolerance $\varepsilon$, relative error of $t^{-\alpha}$ for $10^{-3} \leq t \leq 10^{3}$ (any unit)"
    )
    ax.set_ylabel("Number of exponentials")
    ax.legend(frameon=False, fontsize="small")
    return ax


def plot_memory_terms(
    order: float, ax: Axes | None = None, *, shortest: float = 1e-3, longest: float = 1e3, tolerance: float = 1e-3
) -> Axes:
    """Draw t^(-alpha), the exponentials of its approximation, and their sum.

    Parameters
    ----------
    order : float
        alpha in (0, 1).
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    shortest, longest : float
        Lags in s between which the sum is valid; a decade more is drawn on either side.
    tolerance : float
        Relative error of the sum, in [1e-13, 0.1].

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If a number is out of its range.

    Examples
    --------
    >>> import springpot as sp
    >>> axes = sp.figures.plot_memory_terms(0.5, tolerance=1e-2)
    >>> len(axes.lines) - 2
    9
    """
    sum_of_terms = power_law_sum(order, shortest, longest, tolerance)
    ax = panel(ax, 6.0, 4.0)
    lag = np.geomspace(shortest / 10.0, longest * 10.0, 800)
    terms = sum_of_terms.weights * np.exp(-np.multiply.outer(lag, sum_of_terms.rates))
    for number, term in enumerate(terms.T):
        label = f"{terms.shape[1]} terms" if number == 0 else None
        ax.plot(lag, term, "-", color=COLORS["sky"], lw=0.8, label=label)
    ax.plot(lag, lag**-order, "-", color=COLORS["black"], lw=2.2, label=rf"$t^{{-{order:g}}}$")
    ax.plot(lag, terms.sum(axis=1), "--", color=COLORS["vermilion"], lw=1.4, label="their sum")
    ax.axvspan(shortest, longest, color="0.95", zorder=0)
    low = longest**-order
    ax.set(xscale="log", yscale="log", xlim=(lag[0], lag[-1]), ylim=(low / 30.0, 2.0 * lag[0] ** -order))
    ax.set(xlabel="lag $t$ (s)", ylabel=rf"kernel and terms (s$^{{-{order:g}}}$)")
    ax.legend(frameon=False, fontsize="small")
    return ax


def plot_memory_error(
    order: float,
    ax: Axes | None = None,
    *,
    shortest: float = 1e-3,
    longest: float = 1e3,
    tolerances: Sequence[float] = (1e-3, 1e-6, 1e-9),
) -> Axes:
    """Draw the relative error of the sum of exponentials against the lag.

    Parameters
    ----------
    order : float
        alpha in (0, 1).
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    shortest, longest : float
        Lags in s between which the sums are valid.
    tolerances : sequence of float
        Relative errors allowed, in [1e-13, 0.1], one curve for each.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If a number is out of its range.

    Examples
    --------
    >>> import springpot as sp
    >>> axes = sp.figures.plot_memory_error(0.5, tolerances=[1e-3])
    >>> bool(axes.lines[0].get_ydata().max() <= 1e-3)
    True
    """
    ax = panel(ax, 6.0, 4.0)
    lag = np.geomspace(shortest, longest, 4000)
    for tolerance, color in zip(tolerances, itertools.cycle(("blue", "vermilion", "green", "purple"))):
        sum_of_terms = power_law_sum(order, shortest, longest, tolerance)
        error = np.abs(np.exp(-np.multiply.outer(lag, sum_of_terms.rates)) @ sum_of_terms.weights * lag**order - 1.0)
        label = rf"$\varepsilon$ = {tolerance:g}: {sum_of_terms.rates.size} terms"
        ax.plot(lag, error, "-", color=COLORS[color], lw=0.9, label=label)
        ax.axhline(tolerance, color=COLORS[color], lw=0.6, linestyle=":")
    heights = min(tolerances) * 1e-2, 3e4 * max(tolerances)
    ax.set(xscale="log", yscale="log", xlim=(shortest, longest), ylim=heights)
    ax.set(xlabel="lag $t$ (s)", ylabel=rf"relative error of $t^{{-{order:g}}}$ (1)")
    ax.legend(frameon=False, fontsize="small", loc="upper right")
    return ax
