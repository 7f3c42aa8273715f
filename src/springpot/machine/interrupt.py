"""Ctrl-C ends every command soon, with one sentence and exit code 130.

While modules load there is nothing to tidy up, and `leave_at_once` ends the process at the signal.  While a command
works Ctrl-C is the exception KeyboardInterrupt, so that it can tidy up.  But Python raises it between two of its own
steps only, and a command may be in the middle of a long call of compiled code; so a thread is notified of the signal by
the system, and ends the process if the command has not ended after a while.  Nothing is lost: all files are written
beside their place and moved there when they are whole.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time

from springpot.machine.platforms import WINDOWS, waking_pipe

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

INTERRUPTED = 130  # exit code
PATIENCE = 2.0  # s that a command has to tidy up after a signal


def _is_usual() -> bool:
    """Whether Ctrl-C may be arranged here: from the main thread, and where neither a caller nor a script has."""
    in_main = threading.current_thread() is threading.main_thread()
    return in_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler


class leave_at_once:  # a class, for contextlib takes longer to load than all the rest here
    """Let Ctrl-C end the process with one sentence and 130, without an exception.

    For while modules load: nothing needs tidying up then, and they may lose an exception or turn it into another one.

    Examples
    --------
    >>> with leave_at_once():
    ...     import json
    """

    def __enter__(self) -> None:
        self._ours = _is_usual()
        if self._ours:
            signal.signal(signal.SIGINT, lambda *_: _end_interrupted())

    def __exit__(self, *_: object) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


class asked_to_stop:
    """Context in which the first Ctrl-C only asks to stop, and the next one ends the command as always.

    Parameters
    ----------
    said : str
        A line for stderr at the first Ctrl-C.

    Examples
    --------
    >>> import signal
    >>> usual = signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background may ignore Ctrl-C
    >>> with asked_to_stop("stopping.") as asked:
    ...     before = asked()
    ...     signal.raise_signal(signal.SIGINT)
    ...     print(before, asked())
    False True
    >>> _ = signal.signal(signal.SIGINT, usual)
    """

    def __init__(self, said: str) -> None:
        self._said, self._asked, self._ours = said, False, False

    def __enter__(self) -> Callable[[], bool]:
        self._ours = _is_usual()
        if self._ours:
            signal.signal(signal.SIGINT, self._first)
            self._told = signal.set_wakeup_fd(-1)  # who is told of a signal ends the process soon
        return lambda: self._asked

    def _first(self, _signal: int, _frame: FrameType | None) -> None:
        self._asked = True
        self._give_back()
        os.write(2, f"{self._said}\n".encode())

    def _give_back(self) -> None:
        if self._ours:
            self._ours = False
            signal.signal(signal.SIGINT, signal.default_int_handler)
            signal.set_wakeup_fd(self._told, warn_on_full_buffer=False)

    def __exit__(self, *_: object) -> None:
        self._give_back()


class Terminated(KeyboardInterrupt):
    """Raised by SIGTERM; handled like Ctrl-C."""


class sigterm_as_ctrl_c:
    """Context in which SIGTERM raises an exception, as Ctrl-C does, so that files and processes are cleaned up.

    Examples
    --------
    >>> import signal
    >>> try:
    ...     with sigterm_as_ctrl_c():
    ...         signal.raise_signal(signal.SIGTERM)
    ... except KeyboardInterrupt as error:
    ...     print(type(error).__name__)
    Terminated
    """

    def __enter__(self) -> None:
        self._in_main = threading.current_thread() is threading.main_thread()
        if self._in_main:
            self._before = signal.signal(signal.SIGTERM, _terminate)

    def __exit__(self, *_: object) -> None:
        if self._in_main:
            signal.signal(signal.SIGTERM, signal.SIG_DFL if self._before is None else self._before)


def _terminate(_signal: int, _frame: FrameType | None) -> None:
    raise Terminated


def attended(command: Callable[[], int]) -> int:
    """Run a command to its exit code, or end the process if Ctrl-C or SIGTERM came and it does not end soon.

    Parameters
    ----------
    command : callable
        Returns the exit code; it says itself that it was interrupted.

    Returns
    -------
    int
        Its exit code.  From here on Ctrl-C changes nothing: the process ends at once, with this code.

    Examples
    --------
    >>> attended(lambda: 0)
    0
    """
    # in the background of a script Ctrl-C is ignored, and SIGTERM is not
    ours = signal.getsignal(signal.SIGINT) in (signal.default_int_handler, signal.SIG_IGN)
    if not ours or WINDOWS or threading.current_thread() is not threading.main_thread():
        return command()  # in Windows a signal wakes sockets only
    with leave_at_once():
        reading, writing = waking_pipe()
        before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
        waiting = threading.Thread(target=_wait_and_end, args=(reading,), daemon=True)
        waiting.start()
    try:
        code = command()
        if _is_usual():  # the exit code is known: a later Ctrl-C ends the process with it
            signal.signal(signal.SIGINT, lambda *_: os._exit(code))
    except KeyboardInterrupt:  # between two lines of the command's own handling
        _say_interrupted()
        code = INTERRUPTED
    finally:
        signal.set_wakeup_fd(before)
        os.close(writing)
    if code == INTERRUPTED and set(threading.enumerate()) - {threading.main_thread(), waiting}:
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except (AttributeError, OSError, ValueError):
                continue
        os._exit(code)  # what still computes is not waited for
    return code


def _wait_and_end(reading: int) -> None:
    """Wait for a signal to end this process, and end it if it does not end by itself."""
    while received := os.read(reading, 1):
        if received[0] in (signal.SIGINT, signal.SIGTERM):
            time.sleep(PATIENCE)
            _end_interrupted()
    os.close(reading)


def _end_interrupted() -> None:
    _say_interrupted()
    os._exit(INTERRUPTED)


def _say_interrupted() -> None:
    if os.isatty(2):
        os.write(2, b"\r\x1b[K\x1b[?25h")  # in place of a progress bar, which hides the cursor
    os.write(2, b"springpot: interrupted.\n")
