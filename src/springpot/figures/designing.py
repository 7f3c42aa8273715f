"""Pictures of designs, of sensitivities, and of what scatters from device to device."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from springpot.designing import Curve, Design, Sensitivity
from springpot.figures.style import COLORS, CONFIDENCE, method_label, named, new_grid, panel, plain_ticks
from springpot.machine.faults import known_word
from springpot.problem.catalogue import unit_of_result
from springpot.scattering import Scatter

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOKS = (("blue", ""), ("orange", "//"), ("green", ".."), ("purple", "xx"))
_BINS = 60


def plot_design_curve(curve: Curve, found: Design | None = None, ax: Axes | None = None) -> Axes:
    """Draw the least cost against a limit; grey where it cannot hold.

    Parameters
    ----------
    curve : Curve
        Of `springpot.designing.Design.curve`.
    found : Design, optional
        Whose limit is marked, and what Monte Carlo found there, with its 95 % interval.
    <ax>

    <returns axes>

    Examples
    --------
    >>> import springpot as sp
    >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
    >>> device = sp.System(sp.Spring(4.0), damper, sp.WhiteNoise(1.0))
    >>> found = sp.design(device, minimize="c", subject_to={"x_mean_square": (None, 0.4)}, rtol=0.1)
    >>> sp.figures.plot_design_curve(found.curve(limits=[0.2, 0.4, 0.8]), found).get_xlabel()
    'limit of x mean square (m$^{2}$)'
    """
    ax = panel(ax)
    order = np.argsort(curve.limits)
    limits, costs = curve.limits[order], curve.costs[order]
    label = f"{'greatest gain' if curve.greatest else 'least cost'}, corrected theory"
    ax.plot(limits, costs, "o-", color=COLORS["blue"], linewidth=1.4, markersize=3.0, label=label)
    held = np.isfinite(costs)
    if not held.all():
        edges = (limits[0], limits[held].min() if held.any() else limits[-1])
        if not curve.upper:
            edges = (limits[held].max() if held.any() else limits[0], limits[-1])
        ax.axvspan(*edges, color="0.9", linewidth=0.0, label="cannot hold")
    if found is not None:
        for promise in found.promises:
            name, sign, bound = promise.limit.split()
            if name == curve.name and (sign == "<") == curve.upper:
                ax.axvline(float(bound), color="0.35", linewidth=1.0, linestyle="--", label="limit")
        ax.errorbar(
            [found.quantities[curve.name]], [found.cost], xerr=[CONFIDENCE * found.errors[curve.name]], fmt="s",
            yerr=[CONFIDENCE * found.cost_error] if found.cost_error > 0.0 else None,
            color=COLORS["vermilion"], markersize=5.0, capsize=2.5, label="the design, Monte Carlo, 95 %",
        )  # fmt: skip
    if (limits > 0.0).all() and limits[-1] > 3.0 * limits[0]:
        ax.set_xscale("log")
    known = costs[held]
    if known.size and (known > 0.0).all() and known.max() > 3.0 * known.min():
        ax.set_yscale("log")
    plain_ticks(ax)
    ax.set_xlabel(f"limit of {named(curve.name.replace('_', ' '), curve.unit)}")
    ax.set_ylabel(named(curve.cost_name.replace("_", " "), curve.cost_unit))
    ax.legend(frameon=False)
    return ax


def plot_sensitivities(*found: Sensitivity) -> Figure:
    """Draw sensitivities as bars, one panel for each quantity, several side by side: theory beside Monte Carlo.

    Parameters
    ----------
    *found : Sensitivity
        Of `springpot.sensitivity`, of the same numbers.  The lines on the bars of Monte Carlo are 95 % intervals.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there are none, or they have no quantity in common.

    Examples
    --------
    >>> import springpot as sp
    >>> linear = sp.System(sp.Spring(9.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0))
    >>> figure = sp.figures.plot_sensitivities(sp.sensitivity(linear, ["x_mean_square", "v_mean_square"]))
    >>> [ax.get_title() for ax in figure.axes]
    ['x mean square', 'v mean square']
    """
    if not found:
        raise ValueError("found must be at least one result of springpot.sensitivity.")
    quantities = [name for name in found[0].values if all(name in each.values for each in found)]
    if not quantities:
        raise ValueError("found must have a quantity in common.")
    numbers = [name for name in found[0].numbers if all(name in each.numbers for each in found)]
    rows = math.ceil(len(quantities) / 3)
    columns = min(len(quantities), 3)
    height = 0.9 + len(numbers) * (0.14 + 0.16 * len(found))
    figure, panels = new_grid(1.4 + 2.6 * columns, rows * height + 0.3, rows, columns)
    for at, (ax, quantity) in enumerate(zip(panels, quantities, strict=False)):
        for place, each in enumerate(found):
            _bars(ax, each, quantity, numbers, place, len(found))
        ax.axvline(0.0, color="0.35", linewidth=0.8)
        ax.set_yticks(range(len(numbers)), [name.replace("_", " ") for name in numbers] if at % columns == 0 else [])
        ax.set_ylim(len(numbers) - 0.5, -0.5)
        ax.grid(visible=False, axis="y")
        ax.set_title(quantity.replace("_", " "), fontsize=10)
        ax.set_xlabel("d ln(quantity) / d ln(number)")
    for ax in panels[len(quantities) :]:
        ax.set_visible(False)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(found), frameon=False)
    return figure


def _bars(ax: Axes, found: Sensitivity, quantity: str, numbers: list[str], place: int, count: int) -> None:
    """The bars of one result."""
    color, hatch = _LOOKS[place % len(_LOOKS)]
    by_chance = bool(found.gains)
    thick = 0.8 / count
    label = f"Monte Carlo, {found.settings.paths} paths, 95 %" if found.settings else method_label(found.method)
    values = np.array([found.values[quantity][name] for name in numbers])
    errors = CONFIDENCE * np.array([found.errors[quantity][name] for name in numbers])
    ax.barh(
        np.arange(len(numbers)) + (place - 0.5 * (count - 1)) * thick, values, 0.9 * thick,
        xerr=np.nan_to_num(errors) if by_chance else None, color=COLORS[color], hatch=hatch, edgecolor="white",
        linewidth=0.0, error_kw={"elinewidth": 1.0, "capsize": 2.0, "ecolor": "black"}, label=label,
    )  # fmt: skip


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
