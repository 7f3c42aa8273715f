"""The simulation of many cores, where the answer is known."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from benchmarks.cores import Cores, Costs, Work, bounds, simulated
from benchmarks.many_cores import table
from benchmarks.report import read

ROOT = Path(__file__).parents[2]

RNG = np.random.default_rng(3)
_CORES = [Cores(1, 1), Cores(1, 5), Cores(3, 4), Cores(40, 1)]
SPREAD = RNG.lognormal(-5.0, 0.3, 200)


def one(seconds: float, **more: float) -> Costs:
    return Costs(np.array([seconds]), **{"python": 0.0, **more})


def test_one_thread_takes_the_sum() -> None:
    costs = one(0.01, python=0.001, begin=0.02, end=0.005)
    assert simulated(Work(7, 11), Cores(1, 1), costs) == pytest.approx(7 * (0.025 + 11 * 0.011), rel=1e-12)
    drawn = np.random.default_rng(5).choice(SPREAD, 77).sum()
    assert simulated(Work(7, 11), Cores(1, 1), Costs(SPREAD, 0.0), seed=5) == pytest.approx(drawn, rel=1e-12)


@pytest.mark.parametrize(("threads", "tasks"), [(4, 40), (4, 2), (64, 100)])
def test_only_one_thread_of_a_process_has_the_lock(threads: int, tasks: int) -> None:
    costs = one(0.0, python=0.001, begin=0.02, end=0.005)
    whole = tasks * (0.025 + 10 * 0.001)
    assert simulated(Work(tasks, 10), Cores(1, threads), costs) == pytest.approx(whole, rel=1e-12)
    assert simulated(Work(tasks, 10), Cores(2, threads), costs) == pytest.approx(whole / 2, rel=1e-12)


def test_without_a_lock_the_threads_divide_the_work() -> None:
    assert simulated(Work(64, 10), Cores(1, 16), one(0.01)) == pytest.approx(0.4, rel=1e-12)
    assert simulated(Work(64, 10), Cores(4, 4), one(0.01)) == pytest.approx(0.4, rel=1e-12)
    assert simulated(Work(2, 80), Cores(1, 16), one(0.01)) == pytest.approx(0.1, rel=1e-12), "eight threads for each"
    assert simulated(Work(17, 10), Cores(1, 16), one(0.01)) == pytest.approx(0.2, rel=1e-12), "the last one waits"


def test_calls_longer_than_the_waiting_for_the_lock_hide_it() -> None:
    """Eight threads with calls of 7 and Python of 1 keep the lock busy without a pause; nine cannot do more."""
    costs = one(7.0, python=1.0)
    assert simulated(Work(8, 50), Cores(1, 8), costs) == pytest.approx(8 * 50 + 7, rel=1e-12)
    assert simulated(Work(9, 50), Cores(1, 9), costs) == pytest.approx(9 * 50 + 7, rel=1e-12)
    assert simulated(Work(4, 50), Cores(1, 4), costs) == pytest.approx(50 * 8 + 3, rel=1e-12), "a pause of 4 each time"


def test_the_scheduler_is_the_slowest() -> None:
    costs = one(0.01, hand_out=0.1)
    assert simulated(Work(50, 3), Cores(10, 1), costs) == pytest.approx(50 * 0.1 + 0.03, rel=1e-12)
    assert bounds(Work(50, 3), Cores(10, 1), costs)["scheduler"] == pytest.approx(5.0)


def test_tasks_fewer_than_processes_leave_cores_idle() -> None:
    assert Cores(20, 50).threads_of_a_task(10) == 50
    assert simulated(Work(10, 100), Cores(20, 50), one(0.01)) == pytest.approx(0.02, rel=1e-12)
    limits = bounds(Work(10, 100), Cores(20, 50), one(0.01))
    assert (limits["cores"], limits["busy"]) == pytest.approx((0.01, 0.02))


@pytest.mark.parametrize(("tasks", "cores"), list(product([1, 3, 30], _CORES)))
def test_no_limit_is_beaten_and_the_rest_is_waiting_for_the_last(tasks: int, cores: Cores) -> None:
    """Never faster than each limit alone; without a lock, no slower than any list of jobs can be (Graham 1969)."""
    work, costs = Work(tasks, 25), Costs(SPREAD, python=2e-4, begin=1e-3, end=1e-3, hand_out=1e-4)
    limits = bounds(work, cores, costs)
    spread = 5.0 * SPREAD.std() * np.sqrt(tasks * 25)  # of the sum of the calls drawn
    workers = min(cores.processes * cores.threads, tasks * cores.threads_of_a_task(tasks))
    taken = simulated(work, cores, costs, seed=1)
    assert taken > max(limits.values()) - spread / workers
    free = Costs(SPREAD, python=0.0)
    last = 25 * SPREAD.max() if tasks > 1 else SPREAD.max()
    assert simulated(work, cores, free, seed=1) <= bounds(work, cores, free)["busy"] + spread / workers + last


def test_the_page_on_studies_has_the_numbers_of_the_table() -> None:
    page = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    assert table(read(ROOT / "benchmarks" / "results" / "table.csv")) in page
