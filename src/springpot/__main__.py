"""The command, as ``springpot`` and as ``python -m springpot``: ready for Ctrl-C before anything large is loaded."""

from __future__ import annotations

import atexit
import io
import os
import signal
import sys

from springpot.machine.crew import ONE_THREAD
from springpot.machine.interrupt import attended, leave_at_once


def main() -> int:
    """Load the command line and run it; see `springpot.cli.main`."""
    # Python removes its signal handlers some milliseconds before it has ended, and Ctrl-C would then change the exit
    # code; the first to be registered is the last to be called
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    for name, number in ONE_THREAD.items():
        os.environ.setdefault(name, number)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr has it, for letters in names
    return attended(_command)


def _command() -> int:
    with leave_at_once():
        from springpot.cli import main as command
    return command()


if __name__ == "__main__":
    sys.exit(main())
