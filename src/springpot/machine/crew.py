"""How many threads are worth starting, and a function run on several of them; Ctrl-C does not wait for them.

The processors that this process may use are those of its affinity, of the control group of a container, and of SLURM.
"""

from __future__ import annotations

import contextlib
import math
import os
import queue
import threading
import time
from collections.abc import Callable
from pathlib import Path

from springpot.machine.platforms import processors

ONE_THREAD = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Environment variables for linear algebra on one thread: the number of threads changes the last bits of a sum.

The command and the workers start with them, so that a study has the same bits on threads, on workers and with any
number of processors.  Variables that the user has set are kept.  NumPy reads them when it is loaded.
"""
PATIENCE = 0.4  # s for threads to end after Ctrl-C, or when nobody waits for them; those in a long call end later


def control_group_quota(root: Path = Path("/sys/fs/cgroup")) -> float:
    """Processors granted by the control group (version 2, then version 1); infinite without a limit.

    Examples
    --------
    >>> control_group_quota() > 0.0
    True
    """
    for quota_file, period_file in (("cpu.max", None), ("cpu/cpu.cfs_quota_us", "cpu/cpu.cfs_period_us")):
        try:
            words = (root / quota_file).read_text(encoding="ascii").split()
            if period_file is not None:
                words += (root / period_file).read_text(encoding="ascii").split()
            quota, period = float(words[0]), float(words[1])
        except (OSError, ValueError, IndexError):  # no such file, or the word "max"
            continue
        if quota > 0 and period > 0:
            return quota / period
    return math.inf


def threads_available() -> int:
    """Number of threads worth starting: processors in this process's affinity, at most what was granted.

    Granted are the control group's share and, in a job of SLURM, ``SLURM_CPUS_PER_TASK``: not every cluster binds a
    job to its processors.

    Examples
    --------
    >>> threads_available() >= 1
    True
    """
    ours = processors()
    granted = control_group_quota()
    with contextlib.suppress(KeyError, ValueError):
        granted = min(granted, int(os.environ["SLURM_CPUS_PER_TASK"]))
    return ours if math.isinf(granted) else max(1, min(ours, math.floor(granted)))


def work_together(
    work: Callable[[], None],
    threads: int,
    *,
    stop: Callable[[], None],
    tell: Callable[[], None] | None = None,
    every: float = 0.1,
) -> None:
    """Run a function on so many threads at once and wait until all have returned.

    Parameters
    ----------
    work : callable
    threads : int
    stop : callable
        Makes ``work`` return soon.  Called when one of the threads, or ``tell``, raises, or on Ctrl-C.
    tell : callable, optional
        Called by the calling thread while it waits.
    every : float
        Time between these calls, in s.

    Raises
    ------
    BaseException
        The first exception of ``work``, after all threads have ended; of ``tell``, or KeyboardInterrupt, within half a
        second: a thread that is busy for longer, for example compiling, ends by itself later.

    Examples
    --------
    >>> finished = []
    >>> work_together(lambda: finished.append(1), 3, stop=finished.clear)
    >>> finished
    [1, 1, 1]
    """
    ended: queue.SimpleQueue[BaseException | None] = queue.SimpleQueue()

    def one() -> None:
        error: BaseException | None = None
        try:
            work()
        except BaseException as raised:
            error = raised
        ended.put(error)

    # daemons: the process can end before them
    team = [threading.Thread(target=one, daemon=True) for _ in range(threads)]
    first: BaseException | None = None
    try:
        for thread in team:
            thread.start()
        left = threads
        while left:
            with contextlib.suppress(queue.Empty):
                error = ended.get(timeout=every)
                left -= 1
                if error is not None and first is None:
                    first = error
                    stop()
            if tell is not None and first is None:
                tell()
    except BaseException:
        stop()
        until = time.monotonic() + PATIENCE
        for thread in team:
            if thread.ident is not None:
                thread.join(max(0.0, until - time.monotonic()))
        raise
    if first is not None:
        raise first
