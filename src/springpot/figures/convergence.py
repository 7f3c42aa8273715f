"""Pictures of errors against the step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from springpot.figures.style import COLORS, LOOKS, bars, panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LENGTH = 5.0  # of the line of known slope: the ratio of the steps at its ends


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
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    orders : sequence of float
        Slopes to draw for comparison.
    xlabel, ylabel : str
        With units.

    Returns
    -------
    matplotlib.axes.Axes

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
