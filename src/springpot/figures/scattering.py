"""A picture of what scatters from device to device."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.style import COLORS, named, new_grid, plain_ticks
from springpot.machine.faults import known_word
from springpot.problem.catalogue import unit_of_result
from springpot.scattering import Scatter

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BINS = 60


def plot_scatter(found: Scatter, name: str | None = None) -> Figure:
    """Draw which uncertain numbers matter for a result, and how the result is distributed over the devices.

    Parameters
    ----------
    found : Scatter
        Of `springpot.scatter`.
    name : str, optional
        Of the result; the first if left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there is no such result, or no scatter is seen in it.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(sp.uncertain("k", 4.0, cov=0.1)), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
    >>> figure = sp.figures.plot_scatter(sp.scatter(device, ["x_mean_square"], method="linear", devices=64))
    >>> [panel.get_title() for panel in figure.axes]
    ['which input matters', 'from device to device']
    """
    name = next(iter(found)) if name is None else known_word(name, found, "name")
    own, unit = found[name], unit_of_result(found.system, name)
    if not own.alone:
        raise ValueError(f"name must be of a result that scatters: of {name} no scatter is seen.")
    figure, (left, right) = new_grid(8.4, 3.6, 1, 2)
    order = sorted(found.inputs, key=lambda each: own.together[each].value)
    places = np.arange(len(order))
    for found_of, shift, face, label in (
        (own.together, 0.19, "white", "with all others"),
        (own.alone, -0.19, COLORS["blue"], "alone"),
    ):
        values = np.array([[getattr(found_of[each], end) for each in order] for end in ("value", "low", "high")])
        about = np.maximum(np.stack([values[0] - values[1], values[2] - values[0]]), 0.0)
        left.barh(
            places + shift, values[0], 0.36, xerr=about, capsize=2.0, label=label, linewidth=1.2, color=face,
            edgecolor=COLORS["blue"], error_kw={"linewidth": 0.9, "ecolor": "0.3"},
        )  # fmt: skip
    left.axvline(0.0, color="0.5", linewidth=0.8)
    left.set(
        yticks=places, yticklabels=order, xlabel="share of the variance between devices", title="which input matters"
    )
    left.legend(loc="lower right", frameon=False)
    right.hist(own.of_devices, _BINS, density=True, color=COLORS["blue"], alpha=0.35, label="devices")
    for value, label, color, style in (
        (found.nominal[name].value, "nominal device", "0.2", "-"),
        (own.mean.value, "mean over devices", COLORS["vermilion"], "--"),
        *((limit, "limit", COLORS["green"], ":") for limit in own.above),
    ):
        right.axvline(value, color=color, linewidth=1.4, linestyle=style, label=label)
    right.set(xlabel=named(name.replace("_", " "), unit), ylabel="density", title="from device to device")
    right.set_yticks([])
    right.legend(frameon=False)
    plain_ticks(right)
    return figure
