"""Pictures of fits: data beside the fit with the residuals, and profiles."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.style import COLORS, LOOKS, new_figure, panel, plain_ticks
from springpot.fitting.likelihood import Table
from springpot.fitting.motion_data import MeasuredRecord
from springpot.fitting.result import Fit, Profile
from springpot.machine.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 2000
_PERIODS = 20  # of a path, that can be told apart in a picture
UNITS_OF = {"x": "m", "v": "m/s", "a": "m/s$^2$"}
PLACES = {"frequency_hz": "frequency (Hz)", "before": "speed before the impact (m/s)", "time": "time (s)",
          "time_s": "time since the step (s)"}  # fmt: skip
_VALUES = {
    "storage": "modulus", "loss": "modulus", "relaxation": "relaxation modulus", "creep": "creep compliance",
    "density": "spectral density", "restitution": "restitution",
    "magnitude": "magnitude", "phase": "phase (deg)",
}  # fmt: skip


def plot_fit(fit: Fit) -> Figure:
    """Draw data with the fit through them, and below it the residuals in standard deviations.

    Of statistics each is drawn over its fitted value, with error bars of one standard deviation.  Of a record with its
    input some periods of the measured path are drawn, the simulated one over it, and the residuals of the same time.

    Parameters
    ----------
    fit : Fit
        Of `springpot.fit`.  Of a long record without input the first 2000 samples are drawn.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import springpot as sp
    >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79])
    >>> figure = sp.figures.plot_fit(sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts))
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['restitution', 'residual (sd)']
    """
    table = fit.table
    if table.axis == "statistic":
        return _of_statistics(table)
    if is_driven(fit.data):
        return _of_driven(table, fit.data)
    groups = dict.fromkeys(table.group.tolist())
    response = "phase" in groups  # its phase has another unit, and a panel of its own
    size, ratios = (5.8, (2.2, 1.4, 1.2)) if response else (4.6, (3.0, 1.2))
    figure, (*above, below) = new_figure(5.6, size, ratios=ratios)
    shown = above if response else above * len(groups)
    for ax, (color, mark), group in zip(shown, itertools.cycle(LOOKS), groups):
        own = np.flatnonzero(table.group == group)[:_MOST]
        unit = 180.0 / np.pi if group == "phase" else 1.0
        small = 3.0 if response else 3.5 if own.size < 200 else 1.5
        label = "data" if response else f"{group}, data"
        ax.plot(table.at[own], unit * table.data[own], mark, markersize=small, color=COLORS[color], label=label)
        ax.plot(table.at[own], unit * table.fitted[own], color="black", linewidth=1.2)
        below.plot(table.at[own], table.residual[own], mark, markersize=small, color=COLORS[color])
    above[0].plot([], [], color="black", linewidth=1.2, label="fit")
    if table.axis in ("frequency_hz", "time_s"):
        above[0].set(xscale="log", yscale="log")
    for ax, group in zip(above, groups, strict=False):
        ax.set_ylabel(_VALUES.get(group, "value"))
    above[0].legend(frameon=False)
    _residuals(below)
    if table.axis == "frequency_hz" and max(table.at) < 100.0 * min(table.at):
        plain_ticks(below)
    below.set_xlabel(PLACES[table.axis])
    return figure


def is_driven(data: object) -> bool:
    """Whether data are a record with its measured input."""
    return isinstance(data, MeasuredRecord) and data.has_input


def some_periods(data: MeasuredRecord) -> slice:
    """The samples of the first periods that are compared, so few that each can be seen.

    Examples
    --------
    >>> time = 0.05 * np.arange(10_000)
    >>> own = some_periods(MeasuredRecord(time, np.sin(6.0 * time), input=np.cos(time), skip=1.0))
    >>> own.start, round((own.stop - own.start) * 0.05 * 6.0 / (2.0 * np.pi))
    (20, 20)
    """
    path = data.values[0, data.first :]
    crossed = np.flatnonzero(np.diff(path > path.mean()))[: 2 * _PERIODS + 1]
    last = int(crossed[-1]) + 1 if crossed.size > 2 * _PERIODS else path.size
    return slice(data.first, data.first + min(last, _MOST))


def driven_parts(table: Table, data: MeasuredRecord) -> Iterator[tuple[str, str, tuple[Floats, Floats, Floats]]]:
    """Of each measured point, or of the first piece: what it is of, its mass, and some periods of it.

    They are measured, simulated, and what is left over its rms at this point.
    """
    own, samples = some_periods(data), data.time.size
    for n, (of, at) in enumerate(data.channels):
        measured, fitted = (each[n * samples : (n + 1) * samples] for each in (table.data, table.fitted))
        left = measured - fitted
        residual = left / max(float(np.sqrt(np.mean(left[own.start :] ** 2))), 1e-300)
        yield of, at or "", (measured[own], fitted[own], residual[own])


def _of_driven(table: Table, data: MeasuredRecord) -> Figure:
    """The first three measured points."""
    parts, time = [*driven_parts(table, data)][:3], data.time[some_periods(data)]
    figure, (*above, below) = new_figure(6.4, 2.0 + 1.8 * len(parts), ratios=(1.9,) * len(parts) + (1.2,))
    for ax, (color, _), (of, at, (measured, fitted, residual)) in zip(above, LOOKS, parts, strict=False):
        ax.plot(time, measured, color=COLORS[color], linewidth=2.4, alpha=0.55, label="measured")
        ax.plot(time, fitted, color="black", linewidth=0.8, label="simulated")
        ax.set_ylabel(f"{of}{f' of {at}' if at else ''} ({UNITS_OF[of]})")
        below.plot(time, residual, color=COLORS[color], linewidth=0.8)
    above[0].legend(frameon=False, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    _residuals(below)
    below.set_xlabel(PLACES["time"])
    below.margins(x=0.0)
    return figure


def _residuals(ax: Axes) -> None:
    """Lines at two standard deviations, and what the axis shows."""
    for level in (-2.0, 0.0, 2.0):
        ax.axhline(level, color="0.5", linewidth=0.8, linestyle="-" if level == 0.0 else ":")
    ax.set_ylabel("residual (sd)")


def _of_statistics(table: Table) -> Figure:
    figure, (above, below) = new_figure(max(4.2, 1.6 + 0.45 * table.at.size), 5.0, ratios=(3.0, 1.4))
    error = np.zeros(table.at.size) if table.error is None else table.error
    size = np.abs(table.fitted)
    ratio = table.data / table.fitted
    above.errorbar(table.at, ratio, error / size, fmt="o", markersize=4.0, color=COLORS["blue"], capsize=2.5,
                   linewidth=1.2, label="measured")  # fmt: skip
    above.axhline(1.0, color="black", linewidth=1.2, label="fit")
    reach = 1.3 * float(np.max(np.abs(ratio - 1.0) + error / size))
    above.set(ylim=(1.0 - reach, 1.0 + reach), ylabel="measured / fitted")
    above.legend(frameon=False)
    below.plot(table.at, table.residual, "o", markersize=4.0, color=COLORS["blue"])
    _residuals(below)
    largest = max(3.0, 1.2 * np.abs(table.residual).max())
    below.set_ylim(-largest, largest)
    below.set_xticks(table.at, table.group.tolist(), rotation=40.0, ha="right")
    above.tick_params(labelbottom=False)
    return figure


def plot_profile(own: Profile, ax: Axes | None = None) -> Axes:
    """Draw how the fit becomes worse when one number is moved, and its 95 % interval.

    Parameters
    ----------
    own : Profile
        Of `springpot.fitting.Fit.profile`.
    <ax>

    <returns axes>

    Examples
    --------
    >>> import springpot as sp
    >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79])
    >>> found = sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts)
    >>> sp.figures.plot_profile(found.profile("r")).get_xlabel()
    'r'
    """
    ax = panel(ax)
    ax.plot(own.values, own.rise, color=COLORS["blue"], linewidth=1.4)
    ax.axhline(own.level, color="0.5", linewidth=0.9, linestyle="--")
    ax.axvspan(*own.limits, color=COLORS["sky"], alpha=0.25, linewidth=0.0, label="95 % interval")
    ax.set_ylim(0.0, min(3.0 * own.level, 1.05 * float(np.max(own.rise[np.isfinite(own.rise)]))))
    ax.set_xlabel(own.name)
    ax.set_ylabel("rise of the deviance")
    ax.legend(frameon=False)
    return ax
