"""The command, as ``springpot`` and as ``python -m springpot``: ready for Ctrl-C before anything large is loaded."""

from __future__ import annotations

import sys

from springpot.interrupt import attended, leave_at_once

__all__ = ["main"]


def main() -> int:
    """Load the command line and run it; see `springpot.cli.main`."""
    return attended(_command)


def _command() -> int:
    with leave_at_once():
        from springpot.cli import main as command
    return command()


if __name__ == "__main__":
    sys.exit(main())
