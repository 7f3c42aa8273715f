"""Estimate of a study before it is run: tasks, time and disk space."""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass, replace

from springpot.studies.axes import spread
from springpot.studies.question import Study
from springpot.studies.tasks import Task, check_some, compute, task_at

SAMPLE = 12  # tasks of a method that are tried
LARGEST_SAMPLE = 1.0  # s spent on each method
CHECKED = 500  # points at which the settings of Monte Carlo are checked
WORDS, DIGITS = 500, 26  # bytes of a line in the store without its numbers, and of a number without its name
ROUGH = {"rtol": 0.02, "paths": 512}  # settings with which Monte Carlo is tried; its pilot runs are a fixed cost
LONGEST_TRY = 0.3  # s after the pilot runs, when the time of a task is extrapolated
LONGEST_PILOT = 3.0  # s for pilot runs, which cannot be extrapolated


@dataclass(frozen=True)
class Estimate:
    """Estimated work of a study.

    Attributes
    ----------
    tasks : dict
        Number of tasks of each method.
    seconds : dict
        Time of all its tasks on one processor, from a sample of them; right to a factor of two.
    bytes : int
        Largest disk space of the store.
    silent : dict
        Share of the tried tasks of each method that have no result: not covered, or no stationary state.
    tried : dict
        Number of tasks of each method in the sample.
    checked : int
        Number of points at which the settings of Monte Carlo were checked.
    """

    tasks: dict[str, int]
    seconds: dict[str, float]
    bytes: int
    silent: dict[str, float]
    tried: dict[str, int]
    checked: int


def estimate(study: Study) -> Estimate:
    """Check a study, and estimate its work from a sample of its tasks.

    Raises
    ------
    TypeError, ValueError
        If a point or a setting is wrong.
    """
    checked = check_some(study, CHECKED)
    count = math.prod(study.shape.values())
    counts = dict.fromkeys(map(str, study.methods), count)
    seconds: dict[str, float] = {}
    silent: dict[str, float] = {}
    used: dict[str, int] = {}
    room = 0
    for method in study.methods:
        room += count * (WORDS + sum(DIGITS + len(column.name) for column in study.columns_of(method)))
        tried = [task_at(study, method, index) for index in spread(count, SAMPLE)]
        _cost(tried[0])  # loads the method
        costs, begun = [], time.perf_counter()
        for task in tried:
            before = _kernels()
            cost = _cost(task)
            costs.append(cost if _kernels() == before else _cost(task))  # else that was the time of a compiler
            if time.perf_counter() - begun > LARGEST_SAMPLE:
                break
        used[method] = len(costs)
        seconds[method] = sum(taken for taken, _ in costs) / len(costs) * count
        silent[method] = sum(bool(statement) for _, statement in costs) / len(costs)
    return Estimate(counts, seconds, room, silent, used, checked)


def _kernels() -> int:
    """Number of kernels that are compiled or read from disk: there is one for each precision."""
    entries = sys.modules.get("springpot.simulation.kernel.native")
    return 0 if entries is None else sum(entry.is_loaded for entry in entries.ENTRIES)


class _Enough(Exception):
    """Raised to end a task whose time can be extrapolated."""


def _cost(task: Task) -> tuple[float, str]:
    """Time of a task, extrapolated from the beginning of a cheaper one if it is long, and why it has no result."""
    cheap, factor = _cheaper(task)
    begun = time.perf_counter()
    pilots, expected = 0.0, math.nan

    def extrapolate(done: float) -> None:
        nonlocal pilots, expected
        spent = time.perf_counter() - begun
        if not done > 0.0:
            pilots = spent
        else:
            of_the_run = getattr(done, "estimate", None)  # of a run with rtol
            whole = spent - pilots + of_the_run.seconds if of_the_run is not None else (spent - pilots) / done
            expected = pilots + factor * whole
        if spent > (pilots + LONGEST_TRY if math.isfinite(expected) else LONGEST_PILOT):
            raise _Enough

    statement = ""
    try:
        statement = compute(cheap, progress=extrapolate).statement
    except _Enough:
        spent = time.perf_counter() - begun
        return (expected if math.isfinite(expected) else factor * spent), ""
    except Exception:  # reported when the study is run
        pass
    spent = time.perf_counter() - begun
    return pilots + factor * (spent - pilots), statement


def _cheaper(task: Task) -> tuple[Task, float]:
    """A task with fewer paths, and the ratio of the times after the pilot runs."""
    for name, rough in ROUGH.items():
        wanted = task.settings.get(name)
        if wanted is None or (wanted >= rough if name == "rtol" else wanted <= rough):
            continue
        cheap = replace(task, settings={**task.settings, name: rough})
        return cheap, (rough / wanted) ** 2 if name == "rtol" else wanted / rough
    return task, 1.0
