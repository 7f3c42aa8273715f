"""Pictures of rare events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.figures.designs import next_design
from springpot.figures.style import COLORS, CONFIDENCE, named, panel
from springpot.machine.faults import meant, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from springpot.simulation import Exceedance

__all__ = ["plot_exceedance"]

TIMES = {"minute": 60.0, "hour": 3600.0, "day": 86400.0, "year": 365.25 * 86400.0, "century": 36525.0 * 86400.0}


def plot_exceedance(
    found: Exceedance,
    quantity: str | None = None,
    ax: Axes | None = None,
    *,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw levels against their return periods, with the 95 % interval of these as a band.

    Parameters
    ----------
    found : Exceedance
        Of `springpot.exceedance`; levels whose rate is not known are left out.
    quantity : str, optional
        One of those asked; the first if left out.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    label, color : str, optional
        Name of this design in the legend, and its color; by default the next ones of the axes.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If the quantity was not asked.

    Examples
    --------
    >>> import springpot as sp
    >>> found = sp.exceedance(sp.Oscillator(), {"x": [1.0, 2.0]}, duration=10.0, start="rest", rtol=0.3)
    >>> sp.figures.plot_exceedance(found).get_xlabel()
    'return period (s)'
    """
    name = next(iter(found.curves)) if quantity is None else quantity
    if name not in found.curves:
        raise ValueError(f"quantity {shown(name)} was not asked{meant(str(name), found.curves) or '.'}")
    curve, design = found.curves[name], next_design(panel(ax), color, label)
    levels, rate, error = (np.ravel(each) for each in (curve.levels, curve.rate, curve.rate_error))
    order = np.argsort(np.abs(levels))
    order = order[(rate > 0.0)[order]]
    levels, period, share = levels[order], 1.0 / rate[order], np.exp(CONFIDENCE * error[order] / rate[order])
    own: Any = {"color": design.color or COLORS["blue"], "gid": design.gid}
    design.ax.fill_betweenx(levels, period / share, period * share, color=own["color"], alpha=0.25, linewidth=0.0)
    design.ax.plot(period, levels, ".-" if levels.size < 5 else "-", label=design.label or None, **own)
    design.ax.set(xscale="log", xlabel="return period (s)", ylabel=named(name.replace("_", " "), curve.unit))
    if design.number == 0:
        across = design.ax.get_xaxis_transform()
        for word, seconds in TIMES.items():
            if levels.size and period.min() < seconds < period.max():
                design.ax.axvline(seconds, color="0.8", linewidth=0.8, zorder=0)
                design.ax.text(seconds, 0.02, word, rotation=90, va="bottom", ha="right", color="0.4", transform=across)
    if design.label:
        design.ax.legend(frameon=False)
    return design.ax
