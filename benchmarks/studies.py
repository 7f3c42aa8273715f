"""Studies: what a task costs beyond its computation, what a second worker brings, how quickly a store is looked at."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from benchmarks.measure import Row, best_wall
from springpot.studies import Study, open_store, read_study, run_study
from springpot.studies.tasks import Answer, compute, tasks

__all__ = ["overhead", "status", "studies"]

SECTION = "studies"
_SKIPPED = "skipped: Dask is not installed"


def studies(quick: bool) -> list[Row]:
    """Rows of the section on studies."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        rows = [overhead(place, 40 if quick else 500), status(place, 100 if quick else 10_000, 1 if quick else 5)]
        if find_spec("distributed") is None:
            return [*rows, *(Row(SECTION, case, None, "", note=_SKIPPED) for case in ("second worker", "memory"))]
        return [*rows, _second_worker(place, quick), _memory(place, quick)]


def _grid(name: str, methods: list[str], count: int, **more: Any) -> Study:
    """A study of so many points: up to ten, or a multiple of ten."""
    orders = min(count, 10)
    axes = {
        "coefficient": {"geomspace": [0.05, 1.0, count // orders]},
        "order": {"linspace": [0.1, 1.0, orders]},
    }
    return read_study({"name": name, "methods": methods, "axes": axes, **more})


def overhead(place: Path, count: int) -> Row:
    """Wall time of a study on one thread, less that of its computations alone."""
    study = _grid("overhead", ["averaging"], count)

    def alone() -> None:
        for task in tasks(study):
            compute(task)

    alone()
    number = iter(range(100))
    whole = best_wall(lambda: run_study(study, place / f"overhead{next(number)}.store", threads=1))
    bare = best_wall(alone)
    note = f"{count} tasks of {1e3 * bare / count:.2g} ms on one thread; goal: at most 2 ms"
    return Row(SECTION, "cost of a task beyond its computation", 1e3 * (whole - bare) / count, "ms", note=note)


def status(place: Path, count: int, times: int) -> Row:
    """``springpot study status`` as it is typed: Python's start, every line read, every checksum compared."""
    study = _grid("status", ["averaging"], count)
    store = open_store(place / "status.store", study)
    for task in tasks(study):
        store.write(task, Answer({column.name: 1.0 for column in study.columns_of(task.method)}, "", ()))
    words = [sys.executable, "-m", "springpot", "study", "status", str(store.path)]
    seconds = best_wall(lambda: subprocess.run(words, check=True, capture_output=True), times)
    return Row(SECTION, f"study status, {count:,} tasks", seconds, "s wall", note="goal: at most 5 s")


def _second_worker(place: Path, quick: bool) -> Row:
    """Tasks of a second on one worker and on two, each of one thread, after they have loaded the kernel."""
    from distributed import LocalCluster

    long, count = (0.05, 4) if quick else (1.0, 30)
    settings: dict[str, Any] = {"paths": 1024, "duration": 100.0, "step": 0.01}
    if quick:  # without pilot runs
        settings |= {"paths": 64, "start": "rest"}
    first = next(tasks(_grid("calibration", ["monte_carlo"], 2, monte_carlo=settings)))
    compute(first)
    settings["duration"] = max(20.0, 100.0 * long / best_wall(lambda: compute(first)))
    study = _grid("workers", ["monte_carlo"], count, monte_carlo=settings)
    nothing = _grid("nothing", ["monte_carlo"], 8, monte_carlo={**settings, "paths": 64, "duration": 1.0})
    taken = []
    for workers in (1, 2):
        with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
            run_study(nothing, place / f"nothing{workers}.store", scheduler=cluster.scheduler_address)
            begun = time.perf_counter()
            run_study(study, place / f"workers{workers}.store", scheduler=cluster.scheduler_address)
            taken.append(time.perf_counter() - begun)
    note = f"{count} tasks of {taken[0] / count:.2g} s: {taken[0]:.3g} s with one; goal: at least 1.9 times as fast"
    ratio = taken[0] / taken[1] if taken[1] > 0.0 else None
    return Row(SECTION, "two Dask workers", taken[1], "s wall", ratio, "one worker's speed", note)


def _memory(place: Path, quick: bool) -> Row:
    """How much more memory the process that hands out the tasks has held after many of them."""

    def peak() -> float:
        import resource  # which Windows lacks

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0

    few, many = (50, 100) if quick else (1_000, 10_000)
    run_study(_grid("few", ["averaging"], few), place / "few.store", workers=2)
    before = peak()
    run_study(_grid("many", ["averaging"], many), place / "many.store", workers=2)
    note = f"peak after {many:,} tasks on two workers, beyond the {before:.0f} MB after {few:,}"
    return Row(SECTION, "memory of the scheduling process", peak() - before, "MB", note=note)
