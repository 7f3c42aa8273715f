"""Pictures of results in bins of time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.data import Data, as_dataset
from springpot.figures.designs import next_design
from springpot.figures.style import panel
from springpot.machine.faults import listed, shown
from springpot.theory.transients import Transient

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_over_time(
    data: Data,
    quantity: str = "x_mean_square",
    ax: Axes | None = None,
    *,
    theory: Transient | None = None,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw a result against time, with its 95 % bars in the middle of each bin.

    Parameters
    ----------
    data : Run or xarray.Dataset
        With ``profile=`` bins.
    quantity : str
        Such as ``"x_mean_square"``, ``"impact_rate"``; of several masses ``"box_x_mean_square"``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.
    theory : Transient, optional
        Of `springpot.theory.transient`: drawn as a line if it has this quantity.
    label, color : str, optional
        Name of this design in the legend, and its color; by default the next ones of the axes.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    TypeError, ValueError
        If the data are no run, or hold no such profile.

    Examples
    --------
    >>> import springpot as sp
    >>> run = sp.simulate(sp.Oscillator(), paths=128, duration=4.0, start="rest", profile=10)
    >>> sp.figures.plot_over_time(run, "impact_rate").get_ylabel()
    'impact rate (s-1)'
    """
    dataset = as_dataset(data)
    known = [str(name).removesuffix("_profile") for name in dataset.data_vars if str(name).endswith("_profile")]
    if quantity not in known:
        have = f"it has {listed(known)}" if known else "simulate with profile= bins"
        raise ValueError(f"data holds no profile of {shown(quantity)}: {have}.")
    name = f"{quantity}_profile"
    design = next_design(panel(ax), color, label)
    time, value, error = (np.asarray(dataset[each], float) for each in ("time_bin", name, f"{name}_se"))
    design.bars(time, value, error, measured="Monte Carlo, 95 %", size=2.5)
    if theory is not None and quantity in theory.numbers:
        design.curve("linear", theory.time, theory.numbers[quantity])
    design.ax.set(xlabel="time $t$ (s)", ylabel=f"{quantity.replace('_', ' ')} ({dataset[name].units})")
    return design.ax
