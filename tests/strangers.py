"""Another user of this machine, for tests of what he could do: only the administrator can act as one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

STRANGER = 65534  # "nobody", on every Unix

needs_another_user = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only the administrator can act as another user"
)
needs_limits = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="this user may read and write everything"
)
needs_owners = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="files have no owner number here")


@contextmanager
def as_stranger() -> Iterator[None]:
    """What is done to files here, another user does, and the system lets him do no more than it would."""
    groups, group = os.getgroups(), os.getegid()
    os.setgroups([])
    os.setegid(STRANGER)
    os.seteuid(STRANGER)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(group)
        os.setgroups(groups)
