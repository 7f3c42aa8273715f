"""The ``springpot study`` commands: parse, call, print."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from springpot.cli.terminal import Json, Whole, check_picture, print_json, print_table
from springpot.machine.arguments import check_folder
from springpot.machine.bar import Bar, say
from springpot.machine.files import shell_word
from springpot.machine.interrupt import leave_at_once
from springpot.problem.numbers import label_of

app = App(
    name="study",
    help="Study: a grid of oscillators or systems, described in a file.  Results are saved on disk; interrupted runs "
    "resume.",
    help_format="plaintext",
)

_File = Annotated[str, Parameter(help="The study file (TOML).")]
_Store = Annotated[str, Parameter(help="Folder of the store, as springpot study run has written it.")]


@app.command
def new(
    file: Annotated[str, Parameter(help="The file to write; it must end in .toml, and must not exist yet.")],
    *,
    system: Annotated[
        str | None,
        Parameter(help="A system's file: the study is then of this system, with a line for each of its numbers."),
    ] = None,
) -> int:
    """Write an example of a study file, with comments; running it takes ten seconds.

    Example: springpot study new dampers.toml
    """
    from springpot.problem.file import read_system
    from springpot.studies.template import OF_OSCILLATORS, TEMPLATE, of_system

    place = Path(file)
    if place.suffix != ".toml":
        raise ValueError(f"the study file must end in .toml, not {place.name!r}.")
    check_folder(place, "the study file")
    endings = {"file": "toml", "store": "store", "picture": "png", "table": "csv"}
    places = {name: shell_word(place.with_suffix(f".{ending}")) for name, ending in endings.items()}
    words = OF_OSCILLATORS
    if system is not None:
        words = of_system(read_system(system), Path(os.path.relpath(system, place.resolve().parent)).as_posix())
    text = TEMPLATE.format(name=json.dumps(place.stem, ensure_ascii=False), **places, **words)
    try:
        with place.open("x", encoding="utf-8") as out:
            out.write(text)
    except FileExistsError:
        raise ValueError(f"{file!r} exists already: give another name, or remove it first.") from None
    print(file)
    return 0


@app.command
def schema() -> int:
    """Print the JSON schema of study files: an editor can use it to check a file while you type.

    Example: springpot study schema
    """
    from springpot.studies.question import Study

    print(json.dumps(Study.model_json_schema(), indent=2))
    return 0


@app.command
def check(file: _File, *, json_: Json = False) -> int:
    """Check a study file, and estimate its number of tasks, its time and its size on disk.

    Example: springpot study check dampers.toml
    """
    with leave_at_once():
        from springpot.machine.crew import threads_available
        from springpot.studies.estimate import estimate
        from springpot.studies.question import read_study

    study = read_study(file)
    with Bar("trying some tasks"):
        estimated = estimate(study)
    threads = threads_available()
    total = sum(estimated.seconds.values()) / threads
    if json_:
        print_json(
            {"name": study.name, "shape": study.shape, "tasks": estimated.tasks, "processor_seconds": estimated.seconds,
             "threads": threads, "seconds": total, "bytes": estimated.bytes, "without_answer": estimated.silent,
             "tried": estimated.tried, "points_checked": estimated.checked}
        )  # fmt: skip
        return 0
    grid = " x ".join(f"{count} {name}" for name, count in study.shape.items())
    print(f"{study.name}: {grid}")
    rows = [["", "tasks", "tried", "processor time", "without an answer"]]
    for method, count in estimated.tasks.items():
        time, silent = _time(estimated.seconds[method]), f"{estimated.silent[method]:.0%}"
        rows.append([method, f"{count:,}", str(estimated.tried[method]), time, silent])
    print_table(rows)
    points = math.prod(study.shape.values())
    if study.monte_carlo is not None and estimated.checked < points:
        print(f"settings of Monte Carlo checked at {estimated.checked:,} of {points:,} points.")
    print(
        f"{sum(estimated.tasks.values()):,} tasks, about {_time(total)} on {threads} threads, "
        f"{_size(estimated.bytes)} at most (estimated from the tasks tried, to a factor of two)."
    )
    return 0


@app.command
def run(
    file: _File,
    *,
    store: Annotated[str, Parameter(help="Folder of the store; created if missing; results in it are kept.")],
    threads: Annotated[Whole | None, Parameter(help="Number of tasks at once; all processors if not given.")] = None,
    workers: Annotated[
        Whole | None,
        Parameter(help="Instead of threads: this number of Dask worker processes, which share the processors."),
    ] = None,
    scheduler: Annotated[
        str | None, Parameter(help="Instead of threads: use the Dask scheduler at this address.")
    ] = None,
    shard: Annotated[
        str, Parameter(help="i/N, for job arrays: compute only every N-th task, from the i-th on.")
    ] = "1/1",
    json_: Json = False,
) -> int:
    """Run a study: compute what the store does not hold yet.  After an interruption, the same command resumes it.

    Example: springpot study run dampers.toml --store dampers.store
    """
    with leave_at_once():
        from springpot.studies.labelled import LABELLED
        from springpot.studies.question import read_study
        from springpot.studies.running import run_study

    study = read_study(file)
    first, slash, last = shard.partition("/")
    if not (slash and first.isdigit() and last.isdigit()):
        raise ValueError(f"--shard must be i/N, such as 1/4, not {shard!r}.")
    part = int(first), int(last)
    try:
        with Bar(study.name) as bar:
            outcome = run_study(
                study, store, threads=threads, workers=workers, scheduler=scheduler, shard=part, progress=bar
            )
    except KeyboardInterrupt:
        say("interrupted; all results so far are kept; the same command continues.")
        return 130
    if json_:
        print_json({"store": store, "tasks": outcome.tasks, "found": outcome.found, "computed": outcome.computed,
                    "failed": len(outcome.failures), "labelled": outcome.labelled})  # fmt: skip
    else:
        print(f"{store}: {outcome.tasks} tasks, {outcome.found} already there, {outcome.computed} computed.")
        if outcome.labelled:
            group = (outcome.path / LABELLED).as_posix()
            print(f'finished: xarray.open_datatree({group!r}, engine="zarr") opens it.')
    if outcome.failures:
        task, reason = outcome.failures[0]
        where = ", ".join(f"{label_of(name)} {task.point[name]:g}" for name in study.columns)
        say(f"{len(outcome.failures)} tasks failed, the first of them {task.method} at {where}: {reason}")
        return 1
    return 0


@app.command
def status(store: _Store, *, json_: Json = False) -> int:
    """Count what is done and missing in a store.  Every result is read and its checksum compared.

    Example: springpot study status dampers.store
    """
    from springpot.studies.labelled import status as look
    from springpot.studies.store import open_store

    opened = open_store(store)
    counts = look(opened)
    if json_:
        print_json({"name": opened.study.name, "shape": opened.study.shape, "done": counts.done,
                    "missing": counts.missing, "damaged": counts.damaged, "labelled": counts.labelled})  # fmt: skip
        return 0
    print(f"{opened.study.name}: {' x '.join(f'{count} {name}' for name, count in opened.study.shape.items())}")
    print_table(
        [["", "done", "missing"]] + [[m, str(counts.done[m]), str(counts.missing[m])] for m in opened.study.methods]
    )
    if counts.damaged:
        print(f"damaged lines: {counts.damaged}; what they held is missing, or was computed again.")
    print(f"labelled group, for xarray: {counts.labelled}")
    if any(counts.missing.values()) or counts.labelled != "right":
        words = f"springpot study run FILE --store {shell_word(store)}"
        print(f"{words} computes what is missing and repairs what is damaged.")
    return 0


@app.command
def export(
    store: _Store,
    out: Annotated[str, Parameter(help="The file to write: .nc or .csv, or a folder that ends in .zarr.")],
    *,
    overwrite: Annotated[bool, Parameter(negative="", help="Replace OUT if it exists.")] = False,
) -> int:
    """Write all results of a store to one file: netCDF or Zarr with units and labels, or a table (CSV).

    Example: springpot study export dampers.store dampers.nc
    """
    with leave_at_once():
        from springpot.studies.export import export as write
        from springpot.studies.store import open_store

    print(write(open_store(store), out, overwrite=overwrite))
    return 0


@app.command
def plot(
    store: _Store,
    *,
    out: Annotated[str, Parameter(help="File for the picture; it must end in .png.")],
    quantities: Annotated[
        list[str] | None,
        Parameter(negative="", consume_multiple=True, help="What to draw; those named in the study file if not given."),
    ] = None,
    kind: Annotated[
        Literal["curves", "lines", "map"] | None,
        Parameter(
            help="curves: along one axis of the study; lines: the same, in a color for each value of a second axis; "
            "map: over two axes. Lines and maps are of Monte Carlo, or of the last theory if there is no Monte Carlo. "
            "Curves if not given."
        ),
    ] = None,
    along: Annotated[
        str | None, Parameter(help="Horizontal axis: an axis of the study; the longest if not given.")
    ] = None,
) -> int:
    """Draw the results of a store: curves of theory and Monte Carlo, or maps, with one panel for each quantity.

    Example: springpot study plot dampers.store --out dampers.png
    """
    with leave_at_once():
        from springpot.figures.studies import plot_study
        from springpot.figures.style import save
        from springpot.studies.running import open_study

    check_picture(out, "out")
    print(save(plot_study(open_study(store), quantities=quantities, kind=kind, along=along), Path(out)))
    return 0


def _time(seconds: float) -> str:
    for unit, size in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{_short(seconds / size)} {unit}"
    return f"{_short(max(seconds, 0.1))} s"


def _size(size: float) -> str:
    for unit in ("B", "kB", "MB", "GB"):
        if size < 999.5:
            return f"{_short(size)} {unit}"
        size /= 1000.0
    return f"{_short(size)} TB"


def _short(number: float) -> str:
    """Two digits, and no power of ten."""
    return f"{number:.0f}" if number >= 9.95 else f"{number:.1f}"
