"""Pictures of first passages, of how often levels are passed, and of counted cycles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.designs import CYCLE, next_design
from springpot.figures.style import LOOKS, method_curve, panel
from springpot.machine.arguments import finite_number
from springpot.machine.faults import listed, shown
from springpot.problem.basquin import HOUR
from springpot.simulation.rare.search import UNSETTLED, ExceedanceCurve
from springpot.simulation.result.results import Run
from springpot.simulation.watch.passage_times import PassagesOfLevels, PassageTimes
from springpot.simulation.watch.rainflow import longer_cycles
from springpot.theory.level_crossings import LevelRates
from springpot.theory.spectral_fatigue import Fatigue

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 200
_FIRST = 1e-4  # of the time that is drawn, where its axis begins at the earliest


def plot_passage_probability(
    passages: PassageTimes | PassagesOfLevels, ax: Axes | None = None, *, until: float | None = None
) -> Axes:
    """Draw how likely levels have been passed by a time, with 95 % bands; dashed beyond the end of the run.

    Parameters
    ----------
    passages : PassageTimes or PassagesOfLevels
        ``run.first_passages["x"]`` of a run with ``first_passage={"x": [...]}``.
    <ax>
    until : float, optional
        Time in s up to which it is drawn; the end of the run if left out.

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If these are no first passages, or ``until`` is not a positive number.

    Notes
    -----
    Beyond the run the rate is assumed to stay constant; where it is not known nothing is drawn, and of a level that no
    path has passed only the bound, dotted.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
    >>> run = sp.simulate(device, paths=256, duration=60.0, start="rest", first_passage={"x": [2.0, 3.0]})
    >>> axes = sp.figures.plot_passage_probability(run.first_passages["x"], until=600.0)
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['x through 2 m', 'x through 3 m', 'with a constant rate']
    """
    each = [passages] if isinstance(passages, PassageTimes) else passages
    if not isinstance(each, list | PassagesOfLevels):
        raise TypeError(f"passages must be those of a run, such as run.first_passages['x'], not {shown(passages)}.")
    horizon = each[0].horizon
    end = horizon if until is None else finite_number(until, "until", low=0.0, open_low=True, hint="It is in seconds.")
    ax, lowest = panel(ax), 1.0
    passed = np.concatenate([one.times for one in each])
    first = passed[passed > 0.0].min(initial=0.5 * min(horizon, end))
    times = np.geomspace(0.7 * max(first, _FIRST * end), end, _POINTS)
    parts = (("-", times[times <= horizon]), ("--", times[times > horizon]))
    for number, passage in enumerate(each):
        color, title = CYCLE[number % len(CYCLE)], passage.title
        unseen = passage.share_censored == 1.0
        title += ", at most" if unseen else ""
        for line, part in parts:
            found = [passage.probability(float(t)) for t in part]
            value, low, high = np.array([(own.value, own.low, own.high) for own in found]).reshape(-1, 3).T
            drawn = high if unseen else value
            seen = np.isfinite(value) & (drawn > 0.0)
            ax.plot(part[seen], drawn[seen], ":" if unseen else line, color=color, linewidth=1.4, label=title)
            if not unseen:
                ax.fill_between(part[seen], low[seen], high[seen], color=color, alpha=0.2, linewidth=0.0)
            title, lowest = "", min([lowest, *drawn[seen]])
    handles = [line for line in ax.lines if not str(line.get_label()).startswith("_") and line.get_label()]
    if end > horizon:
        ax.axvline(horizon, color="0.6", linewidth=0.8)
        handles += ax.plot([], [], "--", color="0.35", linewidth=1.4, label="with a constant rate")
    ax.set(xscale="log", yscale="log", ylim=(0.5 * lowest, 1.3), xlim=(times[0], end), xlabel="time $t$ (s)")
    ax.set_ylabel("probability that the level was passed")
    ax.legend(handles=handles, loc="best", framealpha=0.8, edgecolor="none")
    return ax


def plot_return_periods(
    data: PassageTimes | PassagesOfLevels | ExceedanceCurve | LevelRates,
    ax: Axes | None = None,
    *,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw the mean time between passages against the level: of a run, of `springpot.exceedance`, or of theory.

    Parameters
    ----------
    data : PassageTimes, PassagesOfLevels, ExceedanceCurve or LevelRates
        ``run.first_passages["x"]``, drawn with its 95 % intervals, an arrow upwards where no path has passed;
        ``sp.exceedance(...)["x"]``, with a 95 % band; or ``sp.theory.exceedance(...)["x"]``, a line for each formula.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if left out.  Draw several on the same axes to compare them.
    label, color : str, optional
        Of what is drawn.

    <returns axes>

    Raises
    ------
    TypeError
        If the data are none of these.
    ValueError
        Of `springpot.exceedance`, if the motion has no stationary state: there is no return period.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
    >>> axes = sp.figures.plot_return_periods(sp.theory.exceedance(device, {"x": [2.0, 3.0, 4.0]})["x"])
    >>> [line.get_label() for line in axes.lines], axes.get_xlabel()
    (['Rice', 'Vanmarcke'], 'level of x (m)')
    """
    if isinstance(data, ExceedanceCurve) and not data.settles:
        raise ValueError(f"return periods of {data.name} are {UNSETTLED}; draw its probability against levels.")
    ax = panel(ax)
    design = next_design(ax, color, label)
    mark, own = LOOKS[design.number % len(LOOKS)][1], color or CYCLE[design.number % len(CYCLE)]
    if isinstance(data, LevelRates):
        _curves(ax, data, color, label)
        name, unit = data.name, "m"
    elif isinstance(data, ExceedanceCurve):
        name, unit = data.name, data.unit
        known = np.argsort(np.ravel(data.levels))
        known = known[np.ravel(data.rate)[known] > 0.0]
        place, period, low, high = (
            np.ravel(each)[known] for each in (data.levels, data.return_period, *data.return_interval)
        )
        ax.fill_between(place, low, high, color=own, alpha=0.25, linewidth=0.0)
        ax.plot(
            place, period, marker=mark if place.size < 9 else "", markersize=4.0, color=own, gid=design.gid,
            label=label or f"{data.method}, 95 %",
        )  # fmt: skip
    elif isinstance(data, PassageTimes | PassagesOfLevels):
        each = [data] if isinstance(data, PassageTimes) else [*data]
        name, unit = each[0].quantity, each[0].unit
        found = [(one.level, one.return_period) for one in each if not math.isnan(one.return_period.value)]
        if seen := [(level, own.value, own.low, own.high) for level, own in found if own.high < math.inf]:
            place, period, low, high = np.array(seen).T
            ax.errorbar(
                place, period, [period - low, high - period], fmt=mark, color=own, markersize=4.0, elinewidth=0.9,
                capsize=2.0, label=label or "Monte Carlo, 95 %", gid=design.gid,
            )  # fmt: skip
        if unseen := [(level, own.low) for level, own in found if own.high == math.inf]:
            place, bound = np.array(unseen).T
            ax.plot(place, bound, "^", color=own, fillstyle="none", markersize=6.0, label="no passage: at least, 95 %")
    else:
        raise TypeError(f"data must be first passages of a run or of exceedance, not {shown(data)}.")
    ax.set(yscale="log", xlabel=f"level of {name.replace('_', ' ')} ({unit})", ylabel="return period (s)")
    ax.legend(frameon=False)
    return ax


def _curves(ax: Axes, data: LevelRates, color: str | None, label: str | None) -> None:
    """A line for each formula."""
    order = np.argsort(np.ravel(data.levels))
    lines = {"rice": ("Rice", ":"), "vanmarcke": ("Vanmarcke", "--")}
    for name, period in data.return_period.items():
        place, values = np.ravel(data.levels)[order], np.ravel(period)[order]
        words, line = lines.get(name, ("envelope", ""))
        words = ", ".join(filter(None, [label, words]))
        if line:
            ax.plot(place, values, line, color=color or "0.2", linewidth=1.4, label=words)
        else:
            method_curve(ax, name, place, values, color=color, label=words)


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
    <ax>
    theory : Fatigue, optional
        Of `springpot.theory.fatigue`: the narrow-band law of its ranges is drawn as a line.
    bars : int
        About how many ranges are drawn.
    <label, color>

    <returns axes>

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
