"""How a process that a test starts takes Ctrl-C: as in a terminal, or as in the background of a script."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def in_a_terminal() -> Iterator[None]:
    """Processes begun here obey Ctrl-C, even where these tests run in the background of a script."""
    with _handling(signal.default_int_handler):
        yield


@contextmanager
def in_the_background() -> Iterator[None]:
    """Processes begun here ignore Ctrl-C, as a shell arranges it for ``command &`` in a script."""
    with _handling(signal.SIG_IGN):
        yield


@contextmanager
def _handling(how: signal._HANDLER) -> Iterator[None]:
    before = signal.signal(signal.SIGINT, how)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
