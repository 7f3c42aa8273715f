"""The command, as ``springpot`` and as ``python -m springpot``: ready for Ctrl-C before anything large is loaded."""

from __future__ import annotations

import atexit
import os
import sys

from springpot.machine.interrupt import attended, ignore_ctrl_c, leave_at_once
from springpot.machine.one_thread import ONE_THREAD

__all__ = ["main"]


def main() -> int:
    """Load the command line and run it; see `springpot.cli.main`."""
    atexit.register(ignore_ctrl_c)  # the first one to be registered is the last one to be called
    for name, number in ONE_THREAD.items():
        os.environ.setdefault(name, number)
    return attended(_command)


def _command() -> int:
    with leave_at_once():
        from springpot.cli import main as command
    return command()


if __name__ == "__main__":
    sys.exit(main())
