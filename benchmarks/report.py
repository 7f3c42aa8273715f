"""The table as CSV, as text and as a page, and its picture.  That of equal errors is in a file of its own."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, fields
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.equal_error import is_time
from benchmarks.equal_error_report import ABOUT_MEASURED, lead
from benchmarks.measure import LIMIT, Row
from springpot.figures.style import COLORS, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw", "joined", "measured_later", "page", "read", "text", "write"]

ABOUT = {
    "one core": (
        "Multiply-adds of one core: of independent chains of them on arrays on the stack, and of the memory modes, "
        "8 per mode for four steps, each counted as 2 flops. All are run by turns, and the limit is the most that any "
        "of them does in this precision: no share is above 100 %. Then where the time of a path-step goes: normals and "
        "memory are timed alone, a block without a wall has kicks, drifts and sums besides, and the rest is the wall."
    ),
    "systems": (
        "The time of a path-step with more parts, one thread, h = 0.01. All of them have one kernel, which is compiled "
        "once, in 10 to 15 s, and kept on disk."
    ),
    "observers": (
        "What a run of a springpot with a wall costs with each observer, one thread, h = 0.01, order 0.5, 256 paths of "
        "10,000 steps, in turns. Observers see every step of the window, which here is the whole run."
    ),
    "several masses": (
        "The time of a path-step with more masses, one thread, h = 0.02: a row of masses from the ground, each with "
        "white noise. One compilation serves all of them."
    ),
    "plain kernel": (
        "The simplest fast kernel one would write in Numba (lanes of paths, modes in a flat array on the stack, one "
        "step at a time, Euler step, mirrored at the end of a step in which it crosses the wall), with 32 modes and "
        "the same normals, at the same step. It keeps four sums, springpot keeps 14. It misses the impacts "
        "between two instants, and the time at which they happen. This row does not compare the cost of the same "
        "*error*."
    ),
    "Fig. 2": (
        "The paper's own Monte Carlo in NumPy, vectorised over paths, on one core, with the whole past summed at every "
        "step. "
        "**Scaled, not run**: measured at two lengths, then scaled with the square of the number of steps. springpot "
        "runs `scheme='grunwald'`, the same scheme with the past as a sum of exponentials, run at full length for "
        "three of the 63 points."
    ),
    "white noise": (
        "No memory: x'' + x' + x = white noise above a wall at 0, where <x^2 + v^2> = 1 exactly. Wall time, best of "
        "several, after compilation."
    ),
    "free response": (
        "One path of x'' + 0.5 D^0.5 x + x = 0, x(0) = 1, no noise and no wall, against the exact solution: time to an "
        "error at least as small. springpot is a call of `run`, which takes a millisecond or two before its first "
        "step. So for one short path a few lines of Numba with the whole past are faster."
    ),
    "<A^2>": "Time to reach a given total error (sampling, step, memory, start): `simulate(oscillator, rtol=0.01)`.",
    "one block": "Cost against the number of steps N, with a fixed number of modes and with the number that N needs.",
    "memory held": "What a run holds per path, for two lengths.",
    "the command": "`springpot simulate`, first with empty caches and then again.",
    "one oscillator": "Stationary moments of one oscillator by each method, warm, on one core.",
    "equal error": ABOUT_MEASURED,
    "a study of 10^12": (
        "Processor times measured on the machine in the first row, and the time of a study **simulated** from them, "
        "event by event: threads, the lock of Python in each process, calls drawn from those measured, the scheduler "
        "of Dask (benchmarks/cores.py). The points have stationary starts, and 10^6 paths of 10^5 steps (10 points), "
        "10^5 of 10^4 (1,000) or 10^4 of 10^4 (10,000). Each core is taken to be as fast as one of that machine while "
        "two compute. Not counted: the start of workers, which takes seconds, and the network's and the disk's time."
    ),
    "machine": "All measurements were made on this machine, but for the sections named here.",
}  # fmt: skip

BEGINNING = """# Performance

LEAD
## About the numbers

This page is written by `make bench`, which runs everything once on one machine. Ratios are of numbers from the same
section; processor time is the best of several where one thread works, wall time where threads matter. On another
machine, or on a busy one, the numbers differ; the ratios differ less. The same rows are in
[benchmarks/results/table.csv](../benchmarks/results/table.csv).

To run it again: `make bench` (its environment, with diffrax and pycaputo, is made in `.tools/bench`; it takes some ten
minutes), or `python -m benchmarks --quick` to see that every part works. `--only equal_error` measures that section
anew and keeps the other rows. Without diffrax and pycaputo their rows say that they were skipped.

![Time over springpot's, and where a path-step goes](../benchmarks/results/speed.png)
"""

TRIED = """
## How `rtol` spends its time: what was tried and what it gained

Processor seconds of both threads, warm, first seed, on a busy machine (AMD EPYC, 2 threads; 22 November 2026), with
the same kernel before and after but where a star stands (an older kernel, about a quarter slower):

| answer | before | now |
|---|---:|---:|
| <A^2> to 0.1 %, order 0.5, C = Omega = q = 1, elastic wall at 0 | 48.7 | 1.3 |
| impact rate to 1 %, the same with restitution 0.5 | 6.5 | 0.4 |
| impact rate to 1 %, C = 0.3, restitution 0.5, preload b = 0.5 | 9.6 | 0.4 |
| impact rate to 1 %, C = 0.3, restitution 0.3 | 91* | 4.8 |

Where the first of them went before (with the older kernel, 63 s): 16 s into paths at a first step that was then
halved, which were thrown away; 20 s into paths at the second step; 16 s into pairs of paths at that step and at
half of it; 0.3 s into pilot runs; 11 s into the statistics of eleven rounds. 44 % of the steps of each path lay
before its window.

**Control variates.** Variance of the time average of one path (window of ten relaxation times), with one control
after the other; all have a mean that is known to be zero:

| average | none | energy | and its gain | and momentum | and virial |
|---|---:|---:|---:|---:|---:|
| <A^2>, elastic wall | 0.627 | 0.0575 | 0.0121 | 0.0095 | 0.0069 |
| impact rate, elastic wall | 0.00373 | 0.00361 | 0.00360 | 0.00152 | 0.00135 |
| impact rate, r = 0.5 | 0.0224 | 0.0224 | 0.0224 | 0.0125 | 0.0111 |
| impact rate, r = 0.3, C = 0.3 | 0.138 | 0.134 | 0.134 | 0.096 | 0.086 |
| mean of x, r = 0.5 | 0.0169 | 0.0096 | 0.0092 | 0.0012 | 0.0009 |

The balance of energy was there before. The other three cost nothing: their sums were kept already. In the
difference of a pair the gain of energy matters most (0.0138 to 0.0043 for <A^2>), momentum and virial take out a
few per cent. The sum of a path's normals is the balance of momentum, and their squares are in that of energy. State
and velocity at the end of the window as further controls: less than 1 %.

**Where the pairs are.** Pairs summed with paths at the coarse step bring their whole noise into the value. Now the
paths are at a finer step and the difference D of the pairs, at two coarse steps, is scaled down to it: at an eighth
of the pairs' finer step the bias is at most 0.32 D. A shorter step costs little behind a wall, where most of the
time goes into impacts: a path at a step of 0.0125 took 2.3 times as long as one at 0.2.

**Longer windows.** Variance times length does not depend on the length, so that twenty relaxation times instead of
ten save only part of the time before the window: 22 % of each path at 0.1 %, and nothing at a loose tolerance.

**Not done.** More levels: the difference of a pair has a third of the variance of a path or more. A linear
companion without the wall, antithetic pairs and quasi-random starts were not measured: a companion or a mirrored
path costs as much as a path, and little variance is left for it to take.
"""


def write(rows: Sequence[Row], path: Path) -> Path:
    """Write the table as CSV."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        for row in rows:
            numbers = {name: _number(getattr(row, name), 6) for name in ("value", "ratio")}
            writer.writerow({**asdict(row), **numbers})
    return path


def read(path: Path) -> list[Row]:
    """Read the table back."""
    with path.open(newline="", encoding="utf-8") as stream:
        return [
            Row(**{**row, "value": _value(row["value"]), "ratio": _value(row["ratio"])})  # type: ignore[arg-type]
            for row in csv.DictReader(stream)
        ]


def joined(kept: Sequence[Row], new: Sequence[Row]) -> list[Row]:
    """The rows kept, with the sections of new rows in place of those of the same name, or at the end.

    Examples
    --------
    >>> old = [Row("machine", "a", None, ""), Row("b", "x", 1.0, "s"), Row("c", "x", 1.0, "s")]
    >>> [row.value for row in joined(old, [Row("c", "x", 2.0, "s")])]
    [None, 1.0, 2.0]
    """
    sections = dict.fromkeys(row.section for row in (*kept, *new))
    replaced = {row.section for row in new}
    return [row for section in sections for row in (new if section in replaced else kept) if row.section == section]


def measured_later(kept: Sequence[Row], section: str, now: Sequence[Row]) -> list[Row]:
    """The rows of the machine, with one more that says with what a section was measured on its own.

    Examples
    --------
    >>> old, now = [Row("machine", "processor", None, "", note="a")], [Row("machine", "processor", None, "", note="b")]
    >>> [(row.case, row.note) for row in measured_later(old, "systems", now)]
    [('processor', 'a'), ('systems, measured later', 'processor b')]
    """
    case = f"{section}, measured later"
    rows = [row for row in kept if row.section == "machine" and row.case != case]
    return [*rows, Row("machine", case, None, "", note="; ".join(f"{row.case} {row.note}" for row in now))]


def _value(word: str) -> float | None:
    return float(word) if word else None


def _number(value: float | None, digits: int = 3) -> str:
    if value is None:
        return ""
    if digits == 3 and 100.0 <= abs(value) < 1e7:
        return f"{value:,.0f}"
    return f"{value:.{digits}g}"


def _ratio(row: Row) -> str:
    if row.ratio is None:
        return ""
    if row.ratio_to in (LIMIT, "the whole"):
        return f"{round(100.0 * row.ratio)} % of {row.ratio_to}"
    return f"{_number(row.ratio)} x {row.ratio_to}"


def text(rows: Sequence[Row]) -> str:
    """The table for a terminal."""
    lines = []
    for section, group in groupby(rows, lambda row: row.section):
        lines.append(f"\n{section}")
        lines += [
            f"  {row.case:<42} {_number(row.value):>9} {row.unit:<17} {_ratio(row):<20} {row.note}".rstrip()
            for row in group
        ]
    return "\n".join(lines)


def page(rows: Sequence[Row]) -> str:
    """The page of the documentation."""
    parts = [BEGINNING.replace("LEAD\n", lead(rows))]
    told = ""
    for section, group in groupby((row for row in rows if not is_time(row)), lambda row: row.section):
        parts.append(f"\n## {section[0].upper()}{section[1:]}\n")
        begin = next((name for name in ABOUT if section.startswith(name)), "")
        if begin and begin != told:
            parts.append(f"{ABOUT[begin]}\n")
        told = begin
        listed = list(group)
        if all(row.value is None and not row.unit for row in listed):
            parts += [f"- {row.case}: {row.note}" for row in listed]
        else:
            parts += ["| what | value | ratio | note |", "|---|---:|---|---|"]
            parts += [
                f"| {row.case} | {_number(row.value)} {row.unit} | {_ratio(row)} | {row.note} |".replace("  ", " ")
                for row in listed
            ]
    return "\n".join([*parts, TRIED]).replace("<", "&lt;") + "\n"  # <x^2> is no tag


def draw(rows: Sequence[Row], path: Path) -> Path:
    """Two panels: time over springpot's, and where a path-step goes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=[3.0, 1.2])
    _ratios(above, rows)
    _division(below, rows)
    return save(figure, path)


def _shown(row: Row) -> str:
    """What the picture calls a row."""
    where = row.section.partition(":")[0].replace("of the paper", "").replace("  ", " ").strip()
    if where == "free response, order 0.5, one path, 10 s":
        where = "free response, same error"
    return f"{row.case}\n{where}"


def _ratios(axes: Axes, rows: Sequence[Row]) -> None:
    others = [
        row for row in rows
        if row.ratio is not None and row.ratio_to.startswith("springpot") and not row.case.startswith("springpot")
        and not row.section.startswith(("one core", "equal error"))
    ]  # fmt: skip
    others.sort(key=lambda row: row.ratio or 0.0)
    ratios = [row.ratio or 0.0 for row in others]
    colors = [COLORS["blue"] if ratio >= 1.0 else COLORS["vermilion"] for ratio in ratios]
    places = range(len(others))
    axes.barh(places, [ratio - 1.0 for ratio in ratios], left=1.0, color=colors, height=0.7)
    axes.set_xscale("log")
    axes.set_yticks(list(places), [_shown(row) for row in others], fontsize=6.5)
    axes.set_xlim(min(0.05, *ratios) / 3.0 if ratios else 0.1, 10.0 * max(10.0, *ratios) if ratios else 10.0)
    for place, ratio in zip(places, ratios, strict=True):
        left = ratio < 1.0
        axes.annotate(
            f"{ratio:,.0f}" if ratio >= 100.0 else f"{ratio:.2g}", (ratio, place), (-4 if left else 4, 0),
            textcoords="offset points", ha="right" if left else "left", va="center", fontsize=7,
        )  # fmt: skip
    axes.tick_params(axis="x", labelsize=8)
    axes.axvline(1.0, color=COLORS["black"], linewidth=0.8)
    axes.set_xlabel("time, over springpot's for the same work or error (right of 1: springpot is faster)", fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)


def _division(axes: Axes, rows: Sequence[Row]) -> None:
    colors = [COLORS[name] for name in ("sky", "orange", "green", "purple")]
    sections = sorted({row.section for row in rows if row.section.startswith("one core")})
    for place, section in enumerate(sections):
        left = 0.0
        axes.tick_params(labelsize=8)
        parts = [row for row in rows if row.section == section and row.case.startswith("of it ")]
        for row, color in zip(parts, colors, strict=True):
            width = max(row.value or 0.0, 0.0)
            label = row.case.removeprefix("of it ") if place == 0 else None
            axes.barh(place, width, left=left, color=color, height=0.6, label=label)
            if width > 0.1:
                axes.text(left + width / 2, place, f"{width:.2f}", ha="center", va="center", fontsize=7)
            left += width
    axes.margins(x=0.04)
    axes.set_yticks(range(len(sections)), [section.partition(", ")[2] for section in sections])
    axes.set_ylim(-0.5, len(sections) + 0.2)
    axes.set_xlabel("ns of processor time per path-step, 32 memory modes", fontsize=8)
    if sections:
        axes.legend(ncols=4, loc="upper left", frameon=False, fontsize=7)
    axes.spines[["top", "right"]].set_visible(False)
