"""Design charts: the response over order and strength of the springpot, from the atlas."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from springpot.evidence.atlases.lookup import COEFFICIENTS, ORDERS, read_table, table_for
from springpot.figures.style import MOMENT_WORDS, panel
from springpot.figures.sweeps import PARAMETER_LABELS
from springpot.machine.faults import known_word
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Barrier

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINE = 60  # points along each axis
LINES = 10
MOST_LINES = 14
_LADDERS = (
    (1.0, 1.05, *np.arange(1.1, 2.0, 0.1), *np.arange(2.0, 10.0, 0.5)),
    (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0),
    (1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    (1.0, 2.0, 5.0),
)


def plot_design_chart(
    quantity: str, ax: Axes | None = None, *, restitution: float = 1.0, position: float = 0.0
) -> Axes:
    """Draw contours of a moment over the order and the strength of the springpot, from the atlas.

    Everything is dimensionless, so that one chart is valid for every oscillator.

    Parameters
    ----------
    quantity : str
        A moment, such as ``"amplitude_mean_square"`` or ``"impact_rate"``.
    <ax>
    restitution : float
        Of the wall: 0.3 to 1 at the equilibrium, 1 or 0.8 elsewhere.
    position : float
        Of the wall, in units of sqrt(q / Omega^3), from -2 to 2.

    <returns axes>

    Raises
    ------
    ValueError
        If the quantity is unknown, or the atlas does not cover the wall.

    Examples
    --------
    >>> chart = plot_design_chart("impact_rate", restitution=0.7)
    >>> chart.get_yscale()
    'log'
    """
    from matplotlib.patheffects import AbstractPathEffect, withStroke

    known_word(quantity, MOMENT_WORDS, "quantity")
    wall = Barrier(position, restitution, free_side="above")
    orders = np.linspace(*ORDERS, FINE)
    strengths = np.geomspace(*COEFFICIENTS, FINE)
    name, third = table_for(Dimensionless.of(Oscillator(barrier=wall)))
    moments = read_table(name).moments
    values = np.array([[moments(order, c, third)[0][quantity] for order in orders] for c in strengths])
    ax = panel(ax, 5.6, 4.4)
    positive = bool(values.min() > 0.0)
    shown = np.log10(values) if positive else values
    # extreme values in a corner must not use up the colors
    low, high = np.quantile(shown, [0.04, 0.99])
    ax.contourf(orders, strengths, shown, levels=np.linspace(low, high, 41), cmap="cividis", extend="both")
    levels = _round_levels(10.0**low, 10.0**high) if positive else np.linspace(low, high, LINES)
    lines = ax.contour(
        orders, strengths, shown, levels=np.log10(levels) if positive else levels, colors="white", linewidths=0.9,
        linestyles="solid",
    )  # fmt: skip
    labels = ax.clabel(lines, fmt=lambda level: f"{10.0**level if positive else level:.3g}", fontsize=8)
    outline: list[AbstractPathEffect] = [withStroke(linewidth=1.8, foreground="0.25")]
    for drawn in (lines, *labels):  # readable on light and dark colors
        drawn.set_path_effects(outline)
    strength = r"strength of the springpot $C\,\Omega^{\alpha-2}$ (1)"
    ax.set(yscale="log", xlabel=PARAMETER_LABELS["order"], ylabel=strength)
    _, symbol, _, scale = MOMENT_WORDS[quantity]
    ax.set_title(
        f"{symbol}{scale}  at  $r$ = {restitution:g}, $b\\sqrt{{\\Omega^3/q}}$ = {position:g}", fontsize="medium"
    )
    return ax


def _round_levels(low: float, high: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Round numbers between two positive ones, at most MOST_LINES."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps in _LADDERS:
        levels = [step * 10.0**power for power in powers for step in steps if low < step * 10.0**power < high]
        if len(levels) <= MOST_LINES:
            return np.array(levels)
    return np.array(levels[:: -(-len(levels) // MOST_LINES)])
