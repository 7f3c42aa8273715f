"""Pictures of approximations and their errors.

A power law as a sum of exponentials: its terms, error, and number of terms.  The Fourier series of \\|cos\\| on which
the averaging rests (the paper's Eq. 10 and Fig. 1).  Errors against the step.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.figures.designs import from_zero
from springpot.figures.style import COLORS, LOOKS, bars, panel
from springpot.memory import power_law_sum
from springpot.memory.exponential_sum import mclean
from springpot.theory.fourier import partial_sum, truncation_bound, truncation_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ORDERS = {0.25: ("blue", "o"), 0.5: ("vermilion", "s"), 0.75: ("green", "^")}
_LOOKS: tuple[dict[str, Any], ...] = tuple(
    {"color": COLORS[color], "linestyle": style, "linewidth": 1.5}
    for color, style in zip(("vermilion", "green", "blue", "orange"), ("-", "--", "-.", ":"), strict=True)
)
_PHASE = np.linspace(-math.pi, math.pi, 2001)
_LENGTH = 5.0  # of the line of known slope: the ratio of the steps at its ends


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
    `springpot.figures.approximations.even_spacing_terms`.

    Parameters
    ----------
    <ax>
    tolerances : sequence of float
        Relative errors allowed, in [1e-13, 0.1].

    <returns axes>

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
    <ax>
    shortest, longest : float
        Lags in s between which the sum is valid; a decade more is drawn on either side.
    tolerance : float
        Relative error of the sum, in [1e-13, 0.1].

    <returns axes>

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
    <ax>
    shortest, longest : float
        Lags in s between which the sums are valid.
    tolerances : sequence of float
        Relative errors allowed, in [1e-13, 0.1], one curve for each.

    <returns axes>

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


def plot_fourier_series(ax: Axes | None = None, *, terms: Sequence[int] = (2, 4, 8, 10)) -> Axes:
    """Draw \\|cos p\\| and partial sums of its Fourier series (the paper's Fig. 1).

    Parameters
    ----------
    <ax>
    terms : sequence of int
        Numbers of terms, at least 0; the paper's by default.

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If a number of terms is not a whole number or negative.

    Examples
    --------
    >>> import springpot as sp
    >>> len(sp.figures.plot_fourier_series(terms=[2, 10]).lines)
    3
    """
    ax = panel(ax, 7.0, 3.6)
    ax.plot(_PHASE, np.abs(np.cos(_PHASE)), color=COLORS["black"], linewidth=2.2, label=r"$|\cos\varphi|$")
    for number, count in enumerate(terms):
        ax.plot(_PHASE, partial_sum(_PHASE, count), label=f"$n = {count}$", **_LOOKS[number % len(_LOOKS)])
    ax.set_ylabel(r"$|\cos\varphi|$ and its series (1)")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=5, frameon=False)
    _phase_axis(ax)
    return ax


def plot_fourier_error(ax: Axes | None = None, *, terms: Sequence[int] = (2, 4, 8, 10)) -> Axes:
    """Draw the error of the partial sums, with the largest one in the legend.

    Parameters
    ----------
    ax, terms
        As in `plot_fourier_series`.

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        As in `plot_fourier_series`.

    Examples
    --------
    >>> import springpot as sp
    >>> sp.figures.plot_fourier_error(terms=[10]).get_legend_handles_labels()[1]
    ['$n = 10$: at most 0.0303']
    """
    ax = panel(ax, 7.0, 3.0)
    for number, count in enumerate(terms):
        label = f"$n = {count}$: at most {truncation_bound(count):.4f}"
        ax.plot(_PHASE, truncation_error(_PHASE, count), label=label, **_LOOKS[number % len(_LOOKS)])
    bound = max((truncation_bound(count) for count in terms), default=1.0)
    ax.set_ylim(-0.48 * bound, 1.65 * bound)
    ax.set_ylabel("series less function (1)")
    ax.legend(loc="upper center", ncols=2, frameon=False)
    _phase_axis(ax)
    return ax


def _phase_axis(ax: Axes) -> None:
    ax.set_xlabel(r"phase $\varphi$ (rad)")
    ax.set_xlim(-math.pi, math.pi)
    ax.set_xticks([-math.pi, -math.pi / 2, 0, math.pi / 2, math.pi], ["−π", "−π/2", "0", "π/2", "π"])


def plot_convergence(
    errors: Mapping[str, tuple[ArrayLike, ...]],
    ax: Axes | None = None,
    *,
    orders: Sequence[float] = (1.0, 2.0),
    xlabel: str = "time step (s)",
    ylabel: str = "error",
) -> Axes:
    """Draw errors against the step, on logarithmic axes, with lines of known slope to compare with.

    Parameters
    ----------
    errors : dict
        Name of a scheme to its steps and the sizes of its errors, two arrays of shape (n,), and if they are known a
        third one with the standard errors of the errors.
    <ax>
    orders : sequence of float
        Slopes to draw for comparison.
    xlabel, ylabel : str
        With units.

    <returns axes>

    Raises
    ------
    ValueError
        If a scheme has another number of errors than steps, or a step or an error is not positive.

    Examples
    --------
    >>> import springpot as sp
    >>> euler = {"Euler": ([0.1, 0.05], [2e-2, 1e-2])}
    >>> axes = sp.figures.plot_convergence(euler, orders=[1.0], ylabel="error of x (m)")
    >>> axes.get_xscale(), axes.get_ylabel()
    ('log', 'error of x (m)')
    """
    ax = panel(ax)
    corner = math.inf, math.inf  # smallest step and smallest error
    for number, (name, columns) in enumerate(errors.items()):
        steps, sizes, *rest = (np.asarray(column, dtype=float) for column in columns)
        if steps.shape != sizes.shape or steps.ndim != 1 or steps.size == 0:
            raise ValueError(f"{name} must have as many errors as steps, not {sizes.shape} for {steps.shape}.")
        if not (np.all(steps > 0.0) and np.all(sizes > 0.0)):
            raise ValueError(f"steps and errors of {name} must be positive: take the absolute value of an error.")
        color, mark = LOOKS[number % len(LOOKS)]
        ax.plot(steps, sizes, "-", color=COLORS[color], lw=1.0)
        bars(ax, steps, sizes, rest[0] if rest else np.zeros_like(sizes), color=COLORS[color], marker=mark,
             size=4.5, label=name)  # fmt: skip
        corner = min(corner[0], float(steps.min())), min(corner[1], float(sizes.min()))
    for order in orders if errors else ():
        ends = np.array([1.0, _LENGTH])
        ax.plot(corner[0] * ends, corner[1] / 3.0 * ends**order, "-", color="0.5", lw=0.9)
        ax.annotate(
            f"order {order:g}", (corner[0] * _LENGTH, corner[1] / 3.0 * _LENGTH**order), xytext=(4, 0),
            textcoords="offset points", ha="left", va="center", fontsize="small", color="0.4",
        )  # fmt: skip
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
    return ax
