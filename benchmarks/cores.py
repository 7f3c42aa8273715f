"""How long a study takes on many cores, simulated event by event from measured times.

The model: a process has threads and one lock (Python's: of its threads one at a time runs Python).  A task begins with
Python, then the threads of its place make its calls of compiled code: for each a moment of Python, then, without the
lock, the call.  After the last call it ends with Python, and the place takes the next task.  Tasks are handed out one
after the other, which takes the scheduler a while for each.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["Cores", "Costs", "Work", "bounds", "simulated"]

_BEGIN, _CALL = 0, 1


@dataclass(frozen=True)
class Work:
    """A study: so many tasks, each of so many calls of compiled code."""

    tasks: int
    calls: int


@dataclass(frozen=True)
class Cores:
    """Processes, and the threads of each; one core for each thread."""

    processes: int
    threads: int

    def threads_of_a_task(self, tasks: int) -> int:
        """As `run_study` and the workers of a cluster choose it: few tasks share the threads of their process."""
        return max(1, self.threads // math.ceil(tasks / self.processes))


@dataclass(frozen=True, eq=False)
class Costs:
    """Measured times in s.

    Parameters
    ----------
    calls : ndarray
        Sample of the time of a call, without Python.
    python : float
        Python for each call.
    begin, end : float
        Python before the first call of a task, and after its last.
    hand_out : float
        The scheduler's time for each task; 0 where there is none.
    """

    calls: npt.NDArray[np.float64]
    python: float
    begin: float = 0.0
    end: float = 0.0
    hand_out: float = 0.0


@dataclass
class _Place:
    """Where a task runs: some threads of one process."""

    process: int
    threads: int
    left: int = 0
    busy: int = 0


def bounds(work: Work, cores: Cores, costs: Costs) -> dict[str, float]:
    """The least time in s that each limit alone allows, with calls of mean length.

    Parameters
    ----------
    work : Work
    cores : Cores
    costs : Costs

    Returns
    -------
    dict
        ``cores``: all work over all cores.  ``busy``: over those that have a task.  ``lock``: all Python over the
        processes that have one.  ``scheduler``: all tasks handed out.
    """
    python = work.tasks * (costs.begin + costs.end + work.calls * costs.python)
    whole = python + work.tasks * work.calls * float(costs.calls.mean())
    processes = min(cores.processes, work.tasks)
    places = min(work.tasks, cores.processes * max(1, cores.threads // cores.threads_of_a_task(work.tasks)))
    return {
        "cores": whole / (cores.processes * cores.threads),
        "busy": whole / min(cores.processes * cores.threads, places * cores.threads_of_a_task(work.tasks)),
        "lock": python / processes,
        "scheduler": work.tasks * costs.hand_out,
    }


def simulated(work: Work, cores: Cores, costs: Costs, seed: int = 0) -> float:
    """Time in s until the last task has ended; each call's time is drawn from the sample.

    The lock is given in the order in which it is asked for.  The scheduler works ahead: it is waited for only where it
    is the slowest.

    Parameters
    ----------
    work : Work
    cores : Cores
    costs : Costs
    seed : int

    Returns
    -------
    float

    Examples
    --------
    >>> import numpy as np
    >>> costs = Costs(calls=np.array([1.0]), python=0.5)
    >>> simulated(Work(tasks=2, calls=3), Cores(1, 1), costs)  # one after the other
    9.0
    >>> simulated(Work(tasks=2, calls=3), Cores(2, 1), costs)
    4.5
    """
    drawn = np.random.default_rng(seed).choice(costs.calls, work.tasks * work.calls).tolist()
    inner = cores.threads_of_a_task(work.tasks)
    # place by place over the processes, as a scheduler spreads tasks
    places = [_Place(process, inner) for _ in range(cores.threads // inner) for process in range(cores.processes)]
    free = [0.0] * cores.processes  # when each lock is free
    events: list[tuple[float, int, int]] = []
    given = 0

    def hold(process: int, asked: float, seconds: float) -> float:
        free[process] = max(asked, free[process]) + seconds
        return free[process]

    def take_a_task(number: int, now: float) -> None:
        nonlocal given
        if given < work.tasks:
            given += 1
            heapq.heappush(events, (max(now, given * costs.hand_out), number, _BEGIN))

    for number in range(len(places)):
        take_a_task(number, 0.0)
    while events:
        now, number, what = heapq.heappop(events)
        place = places[number]
        if what == _BEGIN:
            begun = hold(place.process, now, costs.begin)
            place.left, place.busy = work.calls, place.threads
            for _ in range(place.threads):
                heapq.heappush(events, (begun, number, _CALL))
        elif place.left:
            place.left -= 1
            heapq.heappush(events, (hold(place.process, now, costs.python) + drawn.pop(), number, _CALL))
        else:
            place.busy -= 1
            if place.busy == 0:
                take_a_task(number, hold(place.process, now, costs.end))
    return max(free)
