"""Run a function on several threads; Ctrl-C does not wait for them."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable

PATIENCE = 0.4  # s for threads to end after Ctrl-C, or when nobody waits for them; those in a long call end later


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
