"""Pictures of counted cycles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.designs import CYCLE, next_design
from springpot.figures.style import panel
from springpot.machine.faults import listed, shown
from springpot.problem.basquin import HOUR
from springpot.simulation.result.results import Run
from springpot.simulation.watch.rainflow import longer_cycles
from springpot.theory.spectral_fatigue import Fatigue

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_rainflow(
    run: Run,
    quantity: str = "x",
    ax: Axes | None = None,
    *,
    theory: Fatigue | None = None,
    bars: int = 30,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw how many cycles per hour have a longer range, with 95 % bars.

    Parameters
    ----------
    run : Run
        With ``rainflow=`` of this quantity.
    quantity : str
        Such as ``"x"``, ``"mount_elongation"`` or ``"mount_force"``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    theory : Fatigue, optional
        Of `springpot.theory.fatigue`: the narrow-band law of its ranges is drawn as a line.
    bars : int
        About how many ranges are drawn.
    label, color : str, optional
        Name of this design in the legend, and its color; by default the next ones of the axes.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    TypeError, ValueError
        If it is no run, or the cycles of this quantity were not counted.

    Examples
    --------
    >>> import springpot as sp
    >>> run = sp.simulate(sp.Oscillator(), paths=640, duration=40.0, rainflow={"x": sp.Basquin(5.0)})
    >>> sp.figures.plot_rainflow(run, "x").get_ylabel()
    'longer cycles per hour'
    """
    if not isinstance(run, Run):
        raise TypeError(f"run must be a Run with counted cycles, not {shown(run)}.")
    known = [name.removesuffix("_range") for name in run.distributions if name.endswith("_range")]
    if quantity not in known:
        have = f"it has those of {listed(known)}" if known else "simulate with rainflow="
        raise ValueError(f"run holds no cycles of {shown(quantity)}: {have}.")
    ranges, rate = run.distributions[f"{quantity}_range"], HOUR * run[f"{quantity}_cycle_rate"].value
    design = next_design(panel(ax), color, label)
    place, longer, error = longer_cycles(ranges, rate, bars)
    design.bars(place, longer, error, measured="Monte Carlo, 95 %", size=2.5)
    if theory is not None:
        narrow = HOUR * theory.crossing_rate * np.exp(-(place**2) / (8.0 * theory.moments[0.0]))
        design.ax.plot(place, narrow, color=design.color or CYCLE[0], lw=1.2, label=design.named("narrow band"),
                       gid=design.gid)  # fmt: skip
    lowest = 0.3 * float(longer.min()) if longer.size else 1.0
    lowest = min(lowest, design.ax.get_ylim()[0]) if design.number else lowest
    design.ax.set(
        yscale="log", ylim=(lowest, None), xlabel=f"range of {quantity.replace('_', ' ')} ({ranges.unit})",
        ylabel="longer cycles per hour",
    )  # fmt: skip
    return design.ax
