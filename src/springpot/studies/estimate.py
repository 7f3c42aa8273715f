"""What a study will take, before it is run: tasks, time and disk; and what a store holds."""

from __future__ import annotations

import contextlib
import math
import time
from dataclasses import dataclass, replace

from springpot.studies.labelled import AnswersDigest, State, state
from springpot.studies.layout import SENTENCES
from springpot.studies.question import Study
from springpot.studies.store import Damaged, Store
from springpot.studies.tasks import Answer, Task, check_some, columns_of, compute, spread, task_at, tasks

__all__ = ["Estimate", "Status", "estimate", "status"]

SAMPLE = 12  # tasks of a method that are tried
LARGEST_SAMPLE = 1.0  # s spent on each method, one task after another
CHECKED = 500  # points at which the settings of Monte Carlo are checked
BLOCK = 4096  # bytes a file system gives the smallest file
ROUGH = {"rtol": 0.05, "path_times": 1e4}  # as Monte Carlo is tried
FEW_PATHS, MORE_PATHS = 256, 1024  # as a run with a given number of paths is tried: its pilot runs are a fixed cost


@dataclass(frozen=True)
class Estimate:
    """What a study will take.

    Attributes
    ----------
    tasks : dict
        Number of tasks of each method.
    seconds : dict
        Time of all its tasks on one processor, from a sample of them; good to a factor of two.
    bytes : int
        Room that the store will take, at most.
    silent : dict
        Share of the tried tasks of each method that have no answer: not covered, or no stationary state.
    tried : dict
        Number of tasks of each method in the sample that ``seconds`` and ``silent`` are taken from.
    checked : int
        Number of points at which the settings of Monte Carlo were checked.
    """

    tasks: dict[str, int]
    seconds: dict[str, float]
    bytes: int
    silent: dict[str, float]
    tried: dict[str, int]
    checked: int


@dataclass(frozen=True)
class Status:
    """What a store holds of its study.

    Attributes
    ----------
    done, damaged, missing : dict
        Number of tasks of each method.
    labelled : {"right", "outdated", "damaged", "missing"}
        How the group that any xarray opens compares with the answers.
    """

    done: dict[str, int]
    damaged: dict[str, int]
    missing: dict[str, int]
    labelled: State


def estimate(study: Study) -> Estimate:
    """Check a study, and say what it will take from a few of its tasks: the time does not grow with the grid.

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
        room += count * math.ceil((8 * (2 + len(columns_of(method))) + 4) / BLOCK) * BLOCK
        room += count * math.ceil((SENTENCES + 4) / BLOCK) * BLOCK
        tried = [task_at(study, method, index) for index in spread(count, SAMPLE)]
        _cost(tried[0])  # kernels are compiled and loaded
        spent, mute, used[method] = 0.0, 0, 0
        begun = time.perf_counter()
        for task in tried:
            taken, statement = _cost(task)
            spent += taken
            mute += bool(statement)
            used[method] += 1
            if time.perf_counter() - begun > LARGEST_SAMPLE:
                break
        seconds[method], silent[method] = spent / used[method] * count, mute / used[method]
    return Estimate(counts, seconds, room, silent, used, checked)


def _cost(task: Task) -> tuple[float, str]:
    """Estimate of a task's time from a cheaper version of it, and why it has no answer, if it has none."""
    wanted = task.settings.get("paths")
    if wanted is None or wanted <= MORE_PATHS:
        rough, factor = _roughly(task)
        taken, statement = _try(rough)
        return factor * taken, statement
    few, statement = _try(_with(task, "paths", FEW_PATHS))
    more, _ = _try(_with(task, "paths", MORE_PATHS))
    per_path = max(more - few, 0.0) / (MORE_PATHS - FEW_PATHS)
    return few + per_path * (wanted - FEW_PATHS), statement


def _try(task: Task) -> tuple[float, str]:
    """Time that a task takes, and why it has no answer, if it has none."""
    begun = time.perf_counter()
    statement = ""
    with contextlib.suppress(Exception):  # running it will tell
        statement = compute(task).statement
    return time.perf_counter() - begun, statement


def _roughly(task: Task) -> tuple[Task, float]:
    """A cheaper version of a task, and how many times longer the task itself will take."""
    for name, rough in ROUGH.items():
        wanted = task.settings.get(name)
        if wanted is None or (wanted >= rough if name == "rtol" else wanted <= rough):
            continue
        factor = (rough / wanted) ** 2 if name == "rtol" else wanted / rough
        # a coarse answer has its fixed costs as well, which do not grow
        return _with(task, name, rough), max(1.0, 0.5 * factor)
    return task, 1.0


def _with(task: Task, name: str, value: float) -> Task:
    """The task with one of its settings changed."""
    return replace(task, settings={**task.settings, name: value})


def status(store: Store) -> Status:
    """Look at every answer of a store's study, with its checksum."""
    done, damaged, missing = (dict.fromkeys(map(str, store.study.methods), 0) for _ in range(3))
    digest = AnswersDigest(store)
    for task in tasks(store.study):
        answer: Answer | None = None
        try:
            answer = store.read(task)
        except Damaged:
            damaged[task.method] += 1
        else:
            (missing if answer is None else done)[task.method] += 1
        digest.add(task, answer)
    return Status(done, damaged, missing, state(store, digest.value()))
