"""The times to an equal error: the table with which the page begins, and its picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.equal_error import METHODS, OURS, QUANTITIES, RTOL, TARGETS, section_of
from benchmarks.measure import Row
from springpot.figures.style import COLORS, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["ABOUT_MEASURED", "draw_times", "lead"]

ABOUT_MEASURED = (
    "What the times at the top of this page are computed from: processor time of a path-step (one thread, least of "
    "the turns), and the measured bias of each method at each step h, with its standard error. At order 0.5 the bias "
    "is against a run of springpot with h = 0.025. With the whole past the cost is that of a path of 40 s, half of "
    "which is averaged; it grows with 1 / h."
)

_ABOUT_TIMES = """
Processor time until an estimate has a relative error of 1 % or 0.2 %, C = Ω = q = 1, elastic wall at 0. The error is
step bias and sampling error together, as a root mean square. Each method runs at its best step: the least over the
steps h tried of (time of a path-step) x (path-steps after which bias² + variance = error²), from the measured numbers
in the sections on equal error below. Not counted: compilation, the time of a call before its first step, and the steps
until the start is forgotten (also not for springpot's best step). The best step and the paths needed must be known
beforehand. `simulate(rtol=)` finds them itself and bounds the bias: its times are those of whole calls, pilot runs
included, asked for a 95 % interval of 1.96 times the error.

At order 0.5 the start is forgotten slowly. Averages between 40 and 400 s from rest differ from those of
`simulate(rtol=)`, which starts from the stationary mean, by START. No step cures this: the error stated for the other
methods is that of step and sampling alone.
"""

_STYLE = {  # color and marker: distinct without color too
    OURS: ("blue", "o"), RTOL: ("sky", "s"), "plain kernel": ("vermilion", "^"),
    "NumPy normals, Numba step": ("orange", "D"), "NumPy": ("green", "v"), "diffrax": ("purple", "P"),
    "NumPy, whole past": ("black", "X"),
}  # fmt: skip


def _times(rows: Sequence[Row]) -> dict[tuple[str, str], Row]:
    return {(row.section, row.case): row for row in rows}


def _time(seconds: float) -> str:
    """A time in words.

    Examples
    --------
    >>> _time(0.00123), _time(2.0), _time(7300.0)
    ('1.2 ms', '2 s', '2 h')
    """
    for limit, size, unit in ((0.1, 1e-3, "ms"), (300.0, 1.0, "s"), (7200.0, 60.0, "min")):
        if seconds < limit:
            return f"{_two(seconds / size)} {unit}"
    return f"{_two(seconds / 3600.0)} h"


def _two(value: float) -> str:
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2g}"


def _cell(row: Row | None) -> str:
    if row is None:
        return ""
    if row.value is None:
        return row.note.partition(" ")[0] if row.note.startswith("skipped") else "not reached"
    return f"{_time(row.value)} ({_two(row.ratio or 0.0)})"


def lead(rows: Sequence[Row]) -> str:
    """The first section of the page; empty without its rows."""
    times = _times(rows)
    conditions = next((row.note for row in rows if row.section == "equal error, conditions"), "")
    if not conditions:
        return ""
    off = {
        word: times[section_of(0.5, word, TARGETS[0]), RTOL].note.partition(" by ")[2].partition(" (")[0]
        for word in QUANTITIES.values()
        if (section_of(0.5, word, TARGETS[0]), RTOL) in times
    }
    about = _ABOUT_TIMES.replace("START", ", ".join(f"{size} of {word}" for word, size in off.items()))
    parts = [
        "## Time to an equal error\n\n![Time to 1 % and to 0.2 %, each method at its best step]"
        "(../benchmarks/results/equal_error.png)",
        f"{about}\nMeasured by turns: {conditions}.\n",
    ]
    for order, methods in METHODS.items():
        cases = [(word, target) for word in QUANTITIES.values() for target in TARGETS]
        parts.append(f"Order {order:g}. In parentheses: over the time of springpot at its best step.\n")
        parts.append("| method | " + " | ".join(f"{word} to {100 * target:g} %" for word, target in cases) + " |")
        parts.append("|---|" + "---:|" * len(cases))
        for method in methods:
            cells = (_cell(times.get((section_of(order, word, target), method))) for word, target in cases)
            parts.append(f"| {method} | " + " | ".join(cells) + " |")
        parts.append("")
    return "\n".join(parts) + "\n"


def draw_times(rows: Sequence[Row], path: Path) -> Path | None:
    """One panel for each order: time of each method to 1 % (filled) and to 0.2 % (open).  None without rows."""
    times = _times(rows)
    if not any(section.startswith("equal error") for section, _ in times):
        return None
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 6.2), layout="constrained")
    sizes = [len(methods) for methods in METHODS.values()]
    panels = figure.subplots(2, 3, sharex=True, height_ratios=sizes, squeeze=False)
    for row_of_panels, (order, methods) in zip(panels, METHODS.items(), strict=True):
        for axes, word in zip(row_of_panels, QUANTITIES.values(), strict=True):
            _panel(axes, times, order, word, methods, names=axes is row_of_panels[0])
    for axes in panels[-1]:
        axes.set_xlabel("processor time, s", fontsize=9)
    filled, hollow = (
        panels[0][0].plot([], [], "o", color="0.3", fillstyle=fill, linestyle="")[0] for fill in ("full", "none")
    )
    figure.legend(
        [filled, hollow], ["to an error of 1 %", "to 0.2 %"], loc="outside upper center", ncols=2, frameon=False,
        fontsize=9,
    )  # fmt: skip
    return save(figure, path)


def _panel(
    axes: Axes, times: dict[tuple[str, str], Row], order: float, word: str, methods: Sequence[str], *, names: bool
) -> None:
    for place, method in enumerate(methods):
        color, marker = _STYLE[method]
        found = [times.get((section_of(order, word, target), method)) for target in TARGETS]
        values = [row.value if row else None for row in found]
        known = [value for value in values if value is not None]
        axes.plot(known, [place] * len(known), color=COLORS[color], linewidth=1.0, alpha=0.6)
        for value, fill in zip(values, ("full", "none"), strict=True):
            if value is not None:
                axes.plot(value, place, marker, color=COLORS[color], fillstyle=fill, markersize=7)
        words = " to 0.2 %: not reached" if known and values[-1] is None else "not reached"
        if values[-1] is None and (found[-1] is None or not found[-1].note.startswith("skipped")):
            x, up = (known[0], 8) if known else (0.5, 0)
            where = "data" if known else axes.get_yaxis_transform()
            side = ("right" if known[0] > 0.3 else "left") if known else "center"
            note = axes.annotate(words.strip(), (x, place), (0, up), xycoords=where, textcoords="offset points",
                                 ha=side, va="bottom" if known else "center", fontsize=7, color="0.35")  # fmt: skip
            note.set_in_layout(False)
    axes.set_xscale("log")
    axes.set_ylim(len(methods) - 0.5, -0.5)
    axes.set_yticks(range(len(methods)), methods if names else [""] * len(methods), fontsize=8)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(axis="x", color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_title(f"order {order:g}: {word.replace('<', '⟨').replace('>', '⟩').replace('^2', '²')}", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
