"""How many exponentials a memory needs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.style import COLOURS, new_figure
from springpot.memory import power_law_sum
from springpot.memory.exponential_sum import mclean

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["even_spacing_terms", "terms_against_tolerance"]

_ORDERS = {0.25: ("blue", "o"), 0.5: ("vermilion", "s"), 0.75: ("green", "^")}


def even_spacing_terms(tolerance: float, ratio: float) -> float:
    """Terms that rates even in log s need for the range of the lags alone, log(1 / eps) log(T / delta) / pi^2.

    With s = e^y, t^(-alpha) = int exp(alpha y - t e^y) dy / Gamma(alpha).  By Poisson's formula the trapezoidal rule of
    spacing h has the relative error 2 |Gamma(alpha + 2 pi i / h)| / Gamma(alpha) in its first harmonic, the same at
    every t; and |Gamma(alpha + i w)| ~ sqrt(2 pi) w^(alpha - 1/2) exp(-pi w / 2).  So eps ~ exp(-pi^2 / h) up to a
    power of log(1 / eps), and log(T / delta) / h rates lie between 1 / T and 1 / delta.  What a sum has beyond this
    number stands at the two ends of the interval.  Best approximation has the same exponent: for 1 / t on [1, R] the
    error of n terms is of order exp(-n pi^2 / log(8 R)) (Braess and Hackbusch), whose 8 is part of the ends.

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


def terms_against_tolerance(axes: Axes | None = None) -> Axes:
    """Draw the number of terms of t^(-alpha) over six decades of lags against the tolerance.

    Full lines and filled marks are the sums used here, dashed lines and hollow marks McLean's, and the dotted line is
    :func:`even_spacing_terms`.

    Parameters
    ----------
    axes : matplotlib.axes.Axes, optional
        Where to draw; a new figure if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> terms_against_tolerance().get_ylabel()
    'Number of exponentials'
    """
    if axes is None:
        _, (axes,) = new_figure(6.0, 4.2)
    tolerances = 10.0 ** -np.arange(2.0, 10.1, 1.0)
    for order, (colour, mark) in _ORDERS.items():
        ours = [power_law_sum(order, 1e-3, 1e3, float(eps)).rates.size for eps in tolerances]
        theirs = [mclean("power", order, 1e6, float(eps))[0].size for eps in tolerances]
        for terms, style, face, name in ((ours, "-", None, "fewest"), (theirs, "--", "none", "McLean")):
            axes.plot(
                tolerances, terms, style, marker=mark, markersize=5.0, markerfacecolor=face,
                color=COLOURS[colour], label=f"{name}, $\\alpha$ = {order:g}",
            )  # fmt: skip
    asymptote = [even_spacing_terms(float(eps), 1e6) for eps in tolerances]
    label = r"$\ln(1/\varepsilon)\,\ln(T/\delta)/\pi^2$"
    axes.plot(tolerances, asymptote, ":", color=COLOURS["black"], label=label)
    axes.set_xscale("log")
    axes.invert_xaxis()
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(
        r"Tolerance $\varepsilon$, relative error of $t^{-\alpha}$ for $10^{-3} \leq t \leq 10^{3}$ (any unit)"
    )
    axes.set_ylabel("Number of exponentials")
    axes.legend(frameon=False, fontsize="small")
    return axes
