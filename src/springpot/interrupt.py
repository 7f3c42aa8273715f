"""Ctrl-C while modules load."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["leave_at_once"]


@contextmanager
def leave_at_once() -> Iterator[None]:
    """Let Ctrl-C end the process with one sentence and 130, without an exception.

    For while modules load: nothing needs tidying up then, and they may lose an exception or turn it into another one.

    Examples
    --------
    >>> with leave_at_once():
    ...     import json
    """
    before = signal.getsignal(signal.SIGINT)
    in_main = threading.current_thread() is threading.main_thread()  # signals can be arranged from there only
    if not in_main or before is not signal.default_int_handler:  # or the caller has arranged something else
        yield
        return
    signal.signal(signal.SIGINT, _leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _leave(_signal: int, _frame: FrameType | None) -> None:
    os.write(2, b"springpot: interrupted.\n")
    os._exit(130)
