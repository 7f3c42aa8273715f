"""The Fourier series of \\|cos\\| on which the averaging rests (the paper's Eq. 10 and Fig. 1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.figures.style import COLORS, panel
from springpot.theory.fourier import partial_sum, truncation_bound, truncation_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LOOKS: tuple[dict[str, Any], ...] = tuple(
    {"color": COLORS[color], "linestyle": style, "linewidth": 1.5}
    for color, style in zip(("vermilion", "green", "blue", "orange"), ("-", "--", "-.", ":"), strict=True)
)
_PHASE = np.linspace(-math.pi, math.pi, 2001)


def plot_fourier_series(ax: Axes | None = None, *, terms: Sequence[int] = (2, 4, 8, 10)) -> Axes:
    """Draw \\|cos p\\| and partial sums of its Fourier series (the paper's Fig. 1).

    Parameters
    ----------
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    terms : sequence of int
        Numbers of terms, at least 0; the paper's by default.

    Returns
    -------
    matplotlib.axes.Axes

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

    Returns
    -------
    matplotlib.axes.Axes

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
