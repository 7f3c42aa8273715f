"""What happens to a process and to a disk: a kill at a chosen moment, and a disk without room."""

from __future__ import annotations

import contextlib
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.posix import KILLED

__all__ = ["fill", "kill_when", "lines_in"]

WAIT = 120.0  # s


def kill_when(command: Sequence[object], ready: Callable[[], bool]) -> None:
    """Start a command and kill it as soon as something is there; it must not have ended before."""
    process = subprocess.Popen([*map(str, command)], stdout=subprocess.DEVNULL)
    try:
        until = time.monotonic() + WAIT
        while not ready():
            assert process.poll() is None, "it ended before the kill"
            assert time.monotonic() < until
            time.sleep(0.005)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == KILLED


def lines_in(file: Path) -> int:
    """Ends of lines in a file; 0 if there is none."""
    return file.read_bytes().count(b"\n") if file.exists() else 0


def fill(file: Path, room: int = 0) -> None:
    """Write at the end of a file until the disk is full, and leave so many bytes."""
    with contextlib.suppress(OSError), file.open("ab", buffering=0) as out:
        while out.write(bytes(4096)):
            pass
    with file.open("r+b") as out:
        out.truncate(file.stat().st_size - room)
