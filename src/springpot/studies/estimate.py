"""What a study will take, before it is run: tasks, time and disk; and what a store holds."""

from __future__ import annotations

import contextlib
import math
import time
from dataclasses import dataclass

from springpot.studies.layout import SENTENCES
from springpot.studies.question import Study
from springpot.studies.store import Damaged, Store
from springpot.studies.tasks import Answer, Task, check_tasks, columns_of, compute, tasks

__all__ = ["Estimate", "Status", "estimate", "status"]

SAMPLE = 12  # tasks of a method that are tried
LARGEST_SAMPLE = 6.0  # s spent on each method
BLOCK = 4096  # bytes a file system gives the smallest file
ROUGH = {"rtol": 0.05, "path_times": 1e4, "paths": 256}  # as Monte Carlo is tried


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
    """

    tasks: dict[str, int]
    seconds: dict[str, float]
    bytes: int
    silent: dict[str, float]


@dataclass(frozen=True)
class Status:
    """What a store holds of its study.

    Attributes
    ----------
    done, damaged, missing : dict
        Number of tasks of each method.
    """

    done: dict[str, int]
    damaged: dict[str, int]
    missing: dict[str, int]


def estimate(study: Study) -> Estimate:
    """Check a study, and tell what it will take by trying a few of its tasks.

    Raises
    ------
    TypeError, ValueError
        If a point or a setting is wrong.
    """
    check_tasks(study)
    counts: dict[str, int] = {}
    seconds: dict[str, float] = {}
    silent: dict[str, float] = {}
    room = 0
    for method in study.methods:
        mine = list(tasks(study.model_copy(update={"methods": (method,)})))
        counts[method] = len(mine)
        room += len(mine) * math.ceil((8 * (2 + len(columns_of(method))) + 4) / BLOCK) * BLOCK
        room += len(mine) * math.ceil((SENTENCES + 4) / BLOCK) * BLOCK
        tried = _spread(mine)
        _try(_roughly(tried[0])[0])  # kernels are compiled and loaded
        spent, mute, used = 0.0, 0, 0
        begun = time.perf_counter()
        for task in tried:
            rough, factor = _roughly(task)
            taken, statement = _try(rough)
            spent += factor * taken
            mute += bool(statement)
            used += 1
            if time.perf_counter() - begun > LARGEST_SAMPLE:
                break
        seconds[method], silent[method] = spent / used * len(mine), mute / used
    return Estimate(counts, seconds, room, silent)


def _try(task: Task) -> tuple[float, str]:
    """Time that a task takes, and why it has no answer, if it has none."""
    begun = time.perf_counter()
    statement = ""
    with contextlib.suppress(Exception):  # running it will tell
        statement = compute(task).statement
    return time.perf_counter() - begun, statement


def _spread(mine: list[Task]) -> list[Task]:
    """A sample from all over the grid: neither its corners only nor one line of it."""
    count = min(SAMPLE, len(mine))
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    return [mine[int(((number + 0.5) * golden) % 1.0 * len(mine))] for number in range(count)]


def _roughly(task: Task) -> tuple[Task, float]:
    """A cheaper version of a task, and how many times longer the task itself will take."""
    settings = dict(task.settings)
    for name, rough in ROUGH.items():
        wanted = settings.get(name)
        if wanted is None or (wanted >= rough if name == "rtol" else wanted <= rough):
            continue
        settings[name] = rough
        factor = (rough / wanted) ** 2 if name == "rtol" else wanted / rough
        # a coarse answer has its fixed costs as well, which do not grow
        return Task(**{**task.__dict__, "settings": settings}), max(1.0, 0.5 * factor)
    return task, 1.0


def status(store: Store) -> Status:
    """Look at every answer of a store's study, with its checksum."""
    done, damaged, missing = (dict.fromkeys(map(str, store.study.methods), 0) for _ in range(3))
    for task in tasks(store.study):
        try:
            answer: Answer | None = store.read(task)
        except Damaged:
            damaged[task.method] += 1
        else:
            (missing if answer is None else done)[task.method] += 1
    return Status(done, damaged, missing)
