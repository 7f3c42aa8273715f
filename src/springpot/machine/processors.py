"""Number of processors that this process may use: affinity, control group of a container, and SLURM."""

from __future__ import annotations

import contextlib
import math
import os
from pathlib import Path

from springpot.machine.platforms import processors


def control_group_quota(root: Path = Path("/sys/fs/cgroup")) -> float:
    """Processors granted by the control group (version 2, then version 1); infinite without a limit.

    Examples
    --------
    >>> control_group_quota() > 0.0
    True
    """
    for quota_file, period_file in (("cpu.max", None), ("cpu/cpu.cfs_quota_us", "cpu/cpu.cfs_period_us")):
        try:
            words = (root / quota_file).read_text(encoding="ascii").split()
            if period_file is not None:
                words += (root / period_file).read_text(encoding="ascii").split()
            quota, period = float(words[0]), float(words[1])
        except (OSError, ValueError, IndexError):  # no such file, or the word "max"
            continue
        if quota > 0 and period > 0:
            return quota / period
    return math.inf


def threads_available() -> int:
    """Number of threads worth starting: processors in this process's affinity, at most what was granted.

    Granted are the control group's share and, in a job of SLURM, ``SLURM_CPUS_PER_TASK``: not every cluster binds a
    job to its processors.

    Examples
    --------
    >>> threads_available() >= 1
    True
    """
    ours = processors()
    granted = control_group_quota()
    with contextlib.suppress(KeyError, ValueError):
        granted = min(granted, int(os.environ["SLURM_CPUS_PER_TASK"]))
    return ours if math.isinf(granted) else max(1, min(ours, math.floor(granted)))
