"""What a study of 10^12 path-steps takes: times measured on this machine, and more cores simulated from them.

Processor time is counted where it can be: it depends little on what else the machine does.
"""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.cores import Cores, Costs, Work, bounds, simulated
from benchmarks.measure import Row, best_cpu, best_wall, load, machine
from springpot import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.machine.crew import work_together
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.paths.simulation import Simulation, simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.studies import Study, read_study, run_study
from springpot.studies.tasks import compute, tasks

__all__ = ["many_cores", "table", "two_threads"]

SECTION = "a study of 10^12 path-steps"
PATH_STEPS = 10**12
STEP = 0.01
LAYOUTS = {
    "2 cores: 2 threads": Cores(1, 2),
    "64 cores: 64 threads of one process": Cores(1, 64),
    "64 cores: 64 Dask workers of 1 thread": Cores(64, 1),
    "64 cores: 8 Dask workers of 8 threads": Cores(8, 8),
    "1000 cores: 1000 Dask workers of 1 thread": Cores(1000, 1),
    "1000 cores: 20 Dask workers of 50 threads": Cores(20, 50),
}
LIMITS = {
    "cores": "all cores work",
    "busy": "the other cores have no task",
    "lock": "the lock of Python",
    "scheduler": "the scheduler hands out tasks",
}
_OSCILLATOR = Oscillator(1.0, Springpot(0.5, 0.5), Barrier(-0.5, 0.9), WhiteNoise(1.0))
_FIXED = {"coefficient": 0.5, "position": -0.5, "restitution": 0.9}

Times = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Points:
    """A study of `PATH_STEPS`: points, and the paths and steps of each."""

    points: int
    paths: int
    steps: int

    @property
    def size(self) -> str:
        """Which of the measured calls are its own."""
        return "long" if self.steps > 40_000 else "usual"


STUDIES = (Points(10, 1_000_000, 100_000), Points(1_000, 100_000, 10_000), Points(10_000, 10_000, 10_000))
CALLS = {"usual": (4, 10_000), "long": (1, 100_000)}  # blocks of a call, steps


@dataclass(frozen=True, eq=False)
class Measured:
    """Times in s: of calls of each size, of Python for each call, and of a task."""

    calls: dict[str, Times]
    python: float
    start: float  # compiled code of a stationary start
    task: float  # Python of a task of few paths
    path: float  # Python for each path of a task
    hand_out: float
    work: float  # Python of a worker for each task, beyond that of a task without Dask


def many_cores(quick: bool) -> list[Row]:
    """Rows of the section on a study of 10^12 path-steps."""
    processor, *_ = machine()
    alone, both = _calls(1, quick), _calls(2, quick)
    python = float(np.median(_small_calls(quick)))
    start, task, path = _of_a_task(quick)
    rows = [
        Row(SECTION, "where these rows were measured", None, "", note=f"{processor.note}; load {load():.1f} before"),
        *(_row_of_calls(f"a call, {CALLS[size][1]:,} steps", CALLS[size], times) for size, times in alone.items()),
        *(
            _row_of_calls(f"the same while two threads compute ({size})", CALLS[size], times, float(alone[size].mean()))
            for size, times in both.items()
        ),
        Row(SECTION, "Python for each call", 1e3 * python, "ms CPU", note="median of calls of 8 steps"),
        Row(SECTION, "a point: compiled code of its start", 1e3 * start, "ms CPU", note="stationary; median of orders"),
        Row(SECTION, "a point: Python", 1e3 * task, "ms CPU", note="the same"),
        Row(SECTION, "a point: Python for 10,000 paths more", 1e7 * path, "ms CPU", note="sums and errors of results"),
        two_threads(quick),
        *_sleeping(quick),
    ]
    hand_out, work = 0.0, 0.0
    if find_spec("distributed") is not None:
        hand_out, work = _dask(quick)
        rows += [
            Row(SECTION, "Dask: scheduler and client, for each task", 1e3 * hand_out, "ms CPU", note="one worker"),
            Row(SECTION, "Dask: worker, for each task", 1e3 * work, "ms CPU", note="its computation included: 0.2 ms"),
        ]
    return rows + _simulated(Measured(both, python, start, task, path, hand_out, work), quick)


def table(rows: Sequence[Row]) -> str:
    """The simulated times as a table for the page on studies, in s to two digits."""
    value = {row.case: row.value for row in rows if row.section == SECTION and row.value is not None}
    heads = " | ".join(f"{study.points:,} points" for study in STUDIES)
    lines = [f"| | {heads} |", "|---|" + "---:|" * len(STUDIES)]
    for case in LAYOUTS:
        seconds = [value[f"{case}, {study.points:,} points"] for study in STUDIES]
        cells = " | ".join(f"{_short(each)} s" for each in seconds)
        lines.append(f"| {case} | {cells} |")
    return "\n".join(lines)


def _short(seconds: float) -> str:
    return f"{float(f'{seconds:.2g}'):,g}"


def _simulation(paths: int, steps: int, threads: int = 1) -> Simulation:
    plan = plan_of(_OSCILLATOR, paths=paths, duration=STEP * steps, step=STEP, threads=threads, start="rest")
    return simulation_of(plan)


def _times_of_calls(simulation: Simulation) -> Times:
    """Processor time from the end of a call to that of the next one of the same thread, Python included."""
    ends: dict[int, list[float]] = {}

    def note(_: float) -> None:
        ends.setdefault(threading.get_ident(), []).append(time.thread_time())

    simulation.advance(progress=note)
    return np.concatenate([np.diff(of_one) for of_one in ends.values()])


def _calls(threads: int, quick: bool) -> dict[str, Times]:
    """Of each size, from the turn with the least mean."""
    found = {}
    for size, (blocks, steps) in CALLS.items():
        calls = 8 if quick else 40
        simulation = _simulation(LANES * blocks * calls * threads, steps // 100 if quick else steps, threads)
        simulation.but(paths=LANES, duration=STEP, window=(0.0, STEP)).advance()
        found[size] = min((_times_of_calls(simulation) for _ in range(1 if quick else 2)), key=np.mean)
    return found


def _small_calls(quick: bool) -> Times:
    simulation = _simulation(8 * LANES, 8)
    return np.concatenate([_times_of_calls(simulation) for _ in range(5 if quick else 100)])


def _row_of_calls(case: str, size: tuple[int, int], times: Times, alone: float | None = None) -> Row:
    blocks, steps = size
    low, middle, high = 1e3 * np.quantile(times, [0.05, 0.5, 0.95])
    note = f"5 %, median, 95 %: {low:.3g}, {middle:.3g}, {high:.3g} ms; {blocks * LANES} paths"
    note += f", {1e9 * times.mean() / (blocks * LANES * steps):.3g} ns per path-step"
    ratio = None if alone is None else float(times.mean()) / alone
    return Row(SECTION, case, 1e3 * float(times.mean()), "ms CPU", ratio, "" if alone is None else "one thread", note)


def _monte_carlo(name: str, orders: int, **settings: Any) -> Study:
    axes = {"order": {"linspace": [0.3, 0.7, orders]}}
    content = {"name": name, "methods": ["monte_carlo"], "fixed": _FIXED, "axes": axes, "monte_carlo": settings}
    return read_study(content)


def _of_a_task(quick: bool) -> tuple[float, float, float]:
    """Compiled code of the start, Python of a task, and Python for each path, in s; medians over orders.

    A run computes on threads of its own: this thread's time is Python.
    """

    def medians(paths: int, **start: str) -> tuple[float, float]:
        study = _monte_carlo("task", 3 if quick else 9, paths=paths, duration=1.0, step=STEP, **start)
        taken = []
        for task in tasks(study):
            begun = time.thread_time(), time.process_time()
            compute(task)
            taken.append((time.thread_time() - begun[0], time.process_time() - begun[1]))
        python, whole = np.median(np.array(taken[1:]), axis=0)  # the first one loads the compiled code
        return float(python), float(whole)

    few, many = 64, 20_000
    python, whole = medians(few)
    of_few, of_many = (medians(paths, start="rest")[0] for paths in (few, many))
    return max(0.0, whole - python), python, max(0.0, of_many - of_few) / (many - few)


def two_threads(quick: bool) -> Row:
    """Wall time of one run, on one thread and on two by turns."""
    steps, blocks = (100, 16) if quick else (10_000, 64)
    one, two = (_simulation(LANES * blocks, steps, threads) for threads in (1, 2))
    taken = [(best_wall(one.advance, 1), best_wall(two.advance, 1)) for _ in range(1 if quick else 20)]
    single, double = (min(times) for times in zip(*taken, strict=True))
    note = f"least of {len(taken)} turns each; one thread {single:.3g} s; load {load():.1f}"
    return Row(SECTION, "two threads", double, "s wall", single / double, "one thread's speed", note)


def _sleeping(quick: bool) -> list[Row]:
    """Many threads that sleep instead of computing, so that they need no cores: the lock's part of the model."""
    rows = []
    for threads in (16, 64):
        calls, sleep, python = 10 if quick else 30, 0.01, 0.0003
        spins = _spins(python)
        least = min(_slept(threads, calls, sleep, spins) for _ in range(1 if quick else 10))
        model = simulated(Work(threads, calls), Cores(1, threads), Costs(np.array([sleep]), python))
        note = f"measured; the model says {model:.3g} s: {calls} calls each of {1e3 * python} ms of Python"
        case = f"{threads} threads that sleep {1e3 * sleep:g} ms for a call"
        rows.append(Row(SECTION, case, least, "s wall", least / model, "the model", note))
    return rows


def _spin(times: int) -> None:
    for _ in range(times):
        pass


def _spins(seconds: float) -> int:
    trial = 1_000_000
    return max(1, round(trial * seconds / best_cpu(lambda: _spin(trial), 10)))


def _slept(threads: int, calls: int, sleep: float, spins: int) -> float:
    def work() -> None:
        for _ in range(calls):
            _spin(spins)
            time.sleep(sleep)

    return best_wall(lambda: work_together(work, threads, stop=lambda: None), 1)


def _dask(quick: bool) -> tuple[float, float]:
    """Processor time of each task in s: of the process that hands out tasks, and of a worker with the computation."""

    def spent(work: Callable[[], object]) -> tuple[float, float]:
        begun = time.process_time(), _of_children()
        work()
        return time.process_time() - begun[0], _of_children() - begun[1]

    few, many = (10, 50) if quick else (200, 1_200)
    with tempfile.TemporaryDirectory() as folder:
        taken = []
        for count in (few, many):
            axes = {"coefficient": {"linspace": [0.1, 1.0, count // 10]}, "order": {"linspace": [0.1, 1.0, 10]}}
            study = read_study({"name": "dask", "methods": ["averaging"], "axes": axes})
            place = Path(folder) / f"{count}.store"
            taken.append(spent(lambda: run_study(study, place, workers=1, labelled=False)))  # noqa: B023
    ours, theirs = ((large - small) / (many - few) for small, large in zip(*taken, strict=True))
    return ours, theirs


def _of_children() -> float:
    import resource  # which Windows lacks

    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _simulated(measured: Measured, quick: bool) -> list[Row]:
    """A row for each number of cores and of points; the ratio is to one core."""
    rows = []
    for study in STUDIES[-1:] if quick else STUDIES:
        blocks, _ = CALLS[study.size]
        times = np.maximum(measured.calls[study.size] - measured.python, 0.0)
        calls = -(-study.paths // (LANES * blocks)) + round(measured.start / float(times.mean()))
        for case, cores in LAYOUTS.items():
            dask = cores.processes > 1
            task = measured.task + (measured.work if dask else 0.0)
            hand_out = measured.hand_out if dask else 0.0
            costs = Costs(times, measured.python, task, measured.path * study.paths, hand_out)
            work = Work(study.points // (100 if quick else 1), calls)
            limits = bounds(work, cores, costs)
            single = limits["cores"] * cores.processes * cores.threads
            taken = simulated(work, cores, costs)
            name, least = max(limits.items(), key=lambda item: item[1])
            reason = LIMITS[name] if taken < 1.1 * least else f"waiting for the last; {LIMITS[name]}: {least:.3g} s"
            note = f"simulated; {reason}"
            rows.append(Row(SECTION, f"{case}, {study.points:,} points", taken, "s", single / taken, "one core", note))
    return rows
