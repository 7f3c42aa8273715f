"""Clocks, rows of the table, and what machine this is."""

from __future__ import annotations

import math
import os
import platform
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from llvmlite.binding import get_host_cpu_name
from numba.core.config import CPU_NAME

from springpot.machine.crew import threads_available
from springpot.machine.installed import versions

__all__ = [
    "LIMIT",
    "RESULTS",
    "Row",
    "best_cpu",
    "best_wall",
    "cpu_by_turns",
    "exponent",
    "folder_for",
    "load",
    "machine",
]

RESULTS = Path(__file__).parent / "results"
LIMIT = "the limit"  # what a rate of multiply-adds is a share of


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Parameters
    ----------
    section : str
        What is compared.
    case : str
        Who, and at what.
    value : float or None
        Measured or, where the note says so, scaled.
    unit : str
    ratio : float or None
        This value over what ``ratio_to`` names, measured in the same run.
    ratio_to : str
    note : str
    """

    section: str
    case: str
    value: float | None
    unit: str
    ratio: float | None = None
    ratio_to: str = ""
    note: str = ""


def _best(clock: Callable[[], float], work: Callable[[], object], times: int) -> float:
    taken = []
    for _ in range(times):
        begun = clock()
        work()
        taken.append(clock() - begun)
    return min(taken)


def best_cpu(work: Callable[[], object], times: int = 5) -> float:
    """Least processor time in s of ``work``: for one thread, and little disturbed by others on the machine."""
    return _best(time.process_time, work, times)


def cpu_by_turns(works: Mapping[str, Callable[[], object]], turns: int = 9) -> dict[str, float]:
    """Least processor time in s of each, run by turns: what is compared has the same chances on a busy machine."""
    least = dict.fromkeys(works, math.inf)
    for _ in range(turns):
        for name, work in works.items():
            least[name] = min(least[name], best_cpu(work, 1))
    return least


def best_wall(work: Callable[[], object], times: int = 3) -> float:
    """Least wall time in s of ``work``: where threads matter."""
    return _best(time.perf_counter, work, times)


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Slope of log(time) over log(size), by least squares.

    Examples
    --------
    >>> round(exponent([1.0, 2.0, 4.0], [3.0, 12.0, 48.0]), 6)
    2.0
    """
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


def folder_for(asked: Path | None, quick: bool) -> Path:
    """Where results go: where it was asked for, or with those that are kept; those of a quick run, elsewhere."""
    folder = asked or (Path(tempfile.mkdtemp()) if quick else RESULTS)
    if quick and folder.resolve() == RESULTS.resolve():
        raise SystemExit(f"a quick run means nothing and is not kept in {folder}: choose another folder with --out")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def load() -> float:
    """Processes that have waited for a processor in the last minute, on average; NaN where the system does not say."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else math.nan


def machine() -> list[Row]:
    """What the numbers were measured with."""
    waiting = load()
    packages = ", ".join(f"{name} {own}" for name, own in versions("numba", "llvmlite", "numpy").items())
    words = {
        "processor": f"{_processor()} (LLVM: {CPU_NAME or get_host_cpu_name()}), {threads_available()} threads",
        "system": f"{platform.system()} {platform.machine()}",
        "versions": f"Python {platform.python_version()}, {packages}",
        "load before the run": "unknown" if math.isnan(waiting) else f"{waiting:.1f}",
    }
    return [Row("machine", name, None, "", note=text) for name, text in words.items()]


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
