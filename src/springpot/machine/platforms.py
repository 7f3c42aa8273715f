"""What not every system has: owners, signals and open files as POSIX has them on one side, as Windows on the other.

Whatever else the library asks of a system, each has.  A test finds names that Windows lacks in any other file.
`machine/interrupt.py` loads this before all else, so no module is imported here that takes long.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    import socket
    from collections.abc import Callable
    from pathlib import PurePath
    from typing import ParamSpec, TypeVar

    P = ParamSpec("P")
    T = TypeVar("T")

WINDOWS = sys.platform == "win32"
PATIENCE = 2.0  # s for which another process may have a file open in Windows
AT_ONCE = getattr(os, "O_NONBLOCK", 0)  # opens a pipe or a device without waiting for anybody
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_FAR = 2**31 - 2  # where no record has bytes; Windows counts no farther


def user_number() -> int | None:
    """The number of this user; None where users have none."""
    return os.geteuid() if hasattr(os, "geteuid") else None


def processors() -> int:
    """How many this process may use, as far as the system tells."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def is_alive(process: int) -> bool:
    """Whether there may be a process of this number.

    Windows has no question that does no harm: signal 0 is Ctrl-C there.

    Examples
    --------
    >>> is_alive(os.getpid())
    True
    """
    if sys.platform == "win32":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        pass
    return True


def patiently(action: Callable[P, T], *words: P.args, **more: P.kwargs) -> T:
    """Do something to a file, in Windows again and again where another process has it open just now."""
    until = time.monotonic() + PATIENCE * WINDOWS
    while True:
        try:
            return action(*words, **more)
        except PermissionError:
            if time.monotonic() >= until:
                raise
        time.sleep(0.01)


class alone:
    """A context in which no other process adds to a file: a line that is half written looks like one cut by a kill.

    Where a file system knows no locks, lines are whole all the same, and at worst there is an empty one between two.

    Parameters
    ----------
    file : int
        Its descriptor, which is anywhere in the file afterwards.
    """

    def __init__(self, file: int) -> None:
        self._file = file

    def __enter__(self) -> None:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(self._file, _FAR, os.SEEK_SET)
            patiently(msvcrt.locking, self._file, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            with contextlib.suppress(OSError):
                fcntl.flock(self._file, fcntl.LOCK_EX)  # ends with the file, or with the process

    def __exit__(self, *_: object) -> None:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(self._file, _FAR, os.SEEK_SET)
            msvcrt.locking(self._file, msvcrt.LK_UNLCK, 1)


class without_ctrl_c:
    """A context: processes started in it ignore Ctrl-C, which a terminal sends to all; the first one ends them.

    It gives the ``creationflags`` that they need.
    """

    def __enter__(self) -> int:
        if sys.platform == "win32":
            import subprocess

            return subprocess.CREATE_NEW_PROCESS_GROUP
        self._before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        return 0

    def __exit__(self, *_: object) -> None:
        if sys.platform != "win32":
            signal.pthread_sigmask(signal.SIG_SETMASK, self._before)


def waking_pipe() -> tuple[int, int]:
    """The ends of a pipe into which the system can write each signal, though not in Windows."""
    reading, writing = os.pipe()
    if sys.platform != "win32":
        os.set_blocking(writing, False)
    return reading, writing


def claim_port(listening: socket.socket) -> None:
    """Let a server have a port that was in use a moment ago, and no other process have it meanwhile."""
    import socket

    if sys.platform == "win32":  # SO_REUSEADDR shares it there with whoever asks
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    else:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)


def wrong_letters(path: PurePath) -> str:
    """Letters of a path that no name has in Windows; with a colon it would be a hidden part of another file.

    Examples
    --------
    >>> from pathlib import PurePosixPath, PureWindowsPath
    >>> wrong_letters(PureWindowsPath("C:/runs/a:b?.nc")), wrong_letters(PurePosixPath("a:b?.nc"))
    (':?', '')
    """
    from pathlib import PureWindowsPath

    never = {*'<>:"|?*'} if isinstance(path, PureWindowsPath) else set()
    return "".join(sorted(never & {*str(path).removeprefix(path.anchor)}))
