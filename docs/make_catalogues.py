"""Writes the pages *All results*, *All warnings and errors* and *All flags*: ``python docs/make_catalogues.py``."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

from cyclopts import App

from springpot.cli import app
from springpot.machine.faults import FileError, NoFitError, NotCoveredError, Stopped
from springpot.machine.installed import MissingExtraError
from springpot.machine.trusted import CacheWarning
from springpot.problem import messages
from springpot.problem.catalogue import CATALOGUE, Quantity
from springpot.problem.messages import MESSAGES
from springpot.problem.parts.registration import per_unit_mass
from springpot.studies import StoreError
from springpot.theory import NoConvergenceError, NoStationaryStateError

__all__ = ["ERRORS", "PAGES"]

RESULTS = """\
# All results

<!-- written by docs/make_catalogues.py -->

Every result that a run can have, by its name: `run["impact_rate"]` has `value`, `error` (one standard error) and
`unit`. In the dataset of `run.to_xarray()` the error has the same name with `_se`. `<part>` stands for the name of a
part, as in `stop_impact_rate`, and `<point>` for that of one of several masses or of a `Point`, as in `box_x_mean`.
`<pair>` stands for the names of two of them, in the order of the first part between them: one with
`between=("panel", "box")` gives `panel_box_elongation_mean`. `<quantity>` stands for any displacement, elongation,
force or acceleration, as in `x_life` or `mount_force_life`, and `q` for its unit. In the dataset the walls and contacts
have the dimension `barrier`, as in `barrier_impact_rate`, and several masses the dimension `point`, as in `x_mean` and
in the paths `x` and `v`. Of equal parts (`count=`) forces, powers, currents and damage are those of all together, and a
result with `_of_one` is that of one. Elongations, voltages, and rates and speeds of impacts are the same for all and
for one. Powers,
forces and virials are those of the mass, or per unit mass in a system without a `Mass`: the second unit. $m$ is the
mass, $v^-$ the velocity before an impact, $\\nu$ the impacts per unit time, $r$ the restitution. With `rtol=` the
results that are marked have a bounded error, `run[name].budget.total`, in the dataset under their name with `_error`.

| name | unit | meaning | formula | when | `rtol` | dimensions |
|---|---|---|---|---|---|---|
"""
ENDINGS = """
## Errors and curves of each result

In `run.to_xarray()`, in files and in JSON further results have the same name with one of these endings; in Python they
are `run["x_mean"].error`, `.step_bias` and `.budget`:

| ending | meaning |
|---|---|
| `_se` | standard error: if there is no bias, the true value lies within 1.96 standard errors in 95 of 100 runs |
| `_step_bias` | bound on the bias from the step; without `rtol` for few results, impact rate and speeds among them |
| `_memory_bias`, `_transient` | with `rtol`: bounds on the bias from memory and start |
| `_error` | with `rtol`: 1.96 `_se` and the three bounds together: half-width of a 95 % interval, printed after `+-` |

The endings that need `rtol` exist for the results that are marked above. Of the distributions those of `impact_speed`
and the quantiles of `v_largest` have a `_step_bias`, of several masses those of each wall and each mass, such as
`gap_impact_speed_quantile_step_bias` and `box_v_largest_quantile_step_bias`.

## Impacts that have no rate

Behind a lossy wall without white noise, or at a restitution of 0.163 or below, impacts have no rate. `impact_rate`
and the mean speeds are NaN, which a warning says. With `slowest_counted_impact=` there is no warning: the `counted_`
results take their place. `forces=` gives no `<part>_impulse` there. `run.distributions["impact_speed"]` holds all
impacts that the step sees, not only the counted ones; where impacts have no rate its share of slow ones depends on
the step.
"""
FLAGS = """\
# All flags

<!-- written by docs/make_catalogues.py -->

Every flag of the command `springpot`, and the commands that take it. Words in capitals are given without a flag. What
the commands do is on the page [Command line](command.md); `springpot COMMAND --help` shows the flags of one.

| flag | commands | meaning |
|---|---|---|
"""
WARNINGS = """\
# All warnings and errors

<!-- written by docs/make_catalogues.py -->

`run.warnings` has one message for each reason to doubt a result, and each message knows its `name` and `category`.
`springpot.simulate` also raises them as Python warnings of that category, so they can be silenced or made errors:

```py
import warnings

warnings.filterwarnings("ignore", category=sp.NoEffectWarning)
warnings.filterwarnings("error", category=sp.AccuracyWarning)
```

All categories are kinds of `springpot.SpringpotWarning`. Words in *italics* stand for what the message says of your
run.
"""
WRONG = """
## Errors

A wrong argument is a `TypeError` or a `ValueError` whose message begins with the name of the argument; the command
prints the message and ends with exit code 2. Errors with a class of their own, and the warning about caches:

| class | is a | meaning | what to do |
|---|---|---|---|
"""
ERRORS = {
    "springpot.theory.NotCoveredError": (
        NotCoveredError, "Take another method, or Monte Carlo; `springpot.explain` shows which cover the system."
    ),
    "springpot.theory.NoStationaryStateError": (
        NoStationaryStateError, "Add what dissipates energy, or simulate with `start=\"rest\"` for a finite time."
    ),
    "springpot.theory.NoConvergenceError": (NoConvergenceError, "Take another method, or Monte Carlo."),
    "springpot.machine.faults.FileError": (FileError, "Correct the file at the place that the sentence names."),
    "springpot.machine.faults.NoFitError": (
        NoFitError, "Check signs and units, give starts that are nearer, or another model."
    ),
    "springpot.studies.StoreError": (
        StoreError, "Do what the sentence says: another folder, or the study to which the store belongs."
    ),
    "springpot.machine.installed.MissingExtraError": (
        MissingExtraError, "Run the command in the message; `all` in place of the extra's name adds everything."
    ),
    "springpot.machine.faults.Stopped": (Stopped, "Nothing: a fit was ended by `stop=` before it had a result."),
    "springpot.machine.trusted.CacheWarning": (
        CacheWarning, "Set `NUMBA_CACHE_DIR` to a folder that belongs to you and that nobody else can write."
    ),
}  # fmt: skip
"""Each error that a caller can meet, and the one warning outside the catalogue, with what to do."""


def results() -> str:
    """The text of the page *All results*."""
    rows = "".join(f"| {' | '.join(_cells(entry))} |\n" for entry in CATALOGUE)
    return RESULTS + rows + ENDINGS


def _cells(entry: Quantity) -> list[str]:
    units = dict.fromkeys((entry.unit, per_unit_mass(entry.unit)))
    return [
        f"`{entry.name}`", ", ".join(units), entry.meaning,
        f"${entry.formula}$".replace("|", r"\vert ") if entry.formula else "", entry.when,
        "yes" if entry.controlled and not entry.option else "", ", ".join(f"`{name}`" for name in entry.dimensions),
    ]  # fmt: skip


def warnings_and_errors() -> str:
    """The text of the page *All warnings and errors*."""
    pieces = [WARNINGS]
    for category in (getattr(messages, name) for name in messages.__all__ if name.endswith("Warning")):
        if kinds := {name: kind for name, kind in MESSAGES.items() if kind.category is category}:
            pieces.append(f"\n## {category.__name__}\n\n{_first_line(category)}\n\n")
            pieces.append("| name | message | what to do |\n|---|---|---|\n")
            pieces += [f"| `{name}` | {_plain(kind.sentence)} | {kind.advice} |\n" for name, kind in kinds.items()]
    pieces.append(WRONG)
    for place, (error, advice) in ERRORS.items():
        pieces.append(f"| `{place}` | `{error.__mro__[1].__name__}` | {_first_line(error)} | {advice} |\n")
    return "".join(pieces)


def _first_line(thing: type) -> str:
    return (inspect.getdoc(thing) or "").partition("\n\n")[0].replace("\n", " ")


def _plain(sentence: str) -> str:
    """With the names of the numbers in italics; formats such as ``:.2g`` are left out."""
    return re.sub(r"\{(\w+)[^}]*\}", r"*\1*", sentence).replace("|", r"\|").replace("_", r"\_")


def flags() -> str:
    """The text of the page *All flags*: what commands say of a flag in the same words is one row."""
    commands: dict[tuple[str, str], list[str]] = {}
    for command, its in _commands(app):
        for argument in its.assemble_argument_collection():
            if argument.show:
                commands.setdefault((", ".join(argument.names), argument.parameter.help or ""), []).append(command)
    rows = sorted(commands.items(), key=lambda row: (row[0][0].lower(), row[1]))
    return FLAGS + "".join(
        f"| {', '.join(f'`{name}`' for name in names.split(', '))} | {', '.join(of)} | {_as_text(meaning)} |\n"
        for (names, meaning), of in rows
    )


def _commands(group: App, before: str = "") -> Iterator[tuple[str, App]]:
    """Every command that takes flags of its own, by the words that call it."""
    for name in group:
        if not name.startswith("-"):
            within = list(_commands(group[name], f"{before}{name} "))
            yield from within or [(f"{before}{name}", group[name])]


def _as_text(words: str) -> str:
    """Without the signs that Markdown would read: bars, stars, and words that stand for a number."""
    return re.sub(r"([|*<>_^])", r"\\\1", " ".join(words.split()))


PAGES = {"results.md": results, "warnings.md": warnings_and_errors, "flags.md": flags}

if __name__ == "__main__":
    for name, text in PAGES.items():
        (Path(__file__).parent / name).write_text(text(), encoding="utf-8")
