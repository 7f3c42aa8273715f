"""What tests ask of a system that not every one has: where it has none, the test is skipped and says why."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

__all__ = ["KILLED", "link", "make_pipe", "needs_signals"]

KILLED = 1 if sys.platform == "win32" else -9  # exit code of a process that another one has killed
needs_signals = pytest.mark.skipif(sys.platform == "win32", reason="signals as POSIX has them")


def make_pipe(place: Path) -> None:
    """A pipe with a name."""
    if not hasattr(os, "mkfifo"):
        pytest.skip("pipes have no place among the files here")
    os.mkfifo(place)


def link(place: Path, target: str | Path) -> None:
    """A link to a file, which Windows lets few users make, or to a device."""
    if Path(target).parent == Path("/dev") and not Path(target).exists():
        pytest.skip("devices have no place among the files here")
    try:
        place.symlink_to(target)
    except (OSError, NotImplementedError):
        pytest.skip("this user may make no links")
