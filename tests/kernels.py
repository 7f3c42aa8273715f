"""Compile the kernels that most tests use: ``python -m tests.kernels``, before processes that would each compile them.

They are then on disk.  Two at a time, for a compilation has one thread.
"""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import springpot as sp

SINGLE, DOUBLE = 1e-6, 1e-9  # relative errors of the memory, and with them its precision
KINDS = (
    ("default", sp.Barrier(), SINGLE), ("default", sp.Barrier(), DOUBLE),
    ("default", None, SINGLE), ("default", None, DOUBLE),
    ("grunwald", sp.Barrier(), SINGLE),
    ("grunwald", None, SINGLE), ("grunwald", None, DOUBLE),
)  # fmt: skip


def compiled(scheme: str, barrier: sp.Barrier | None, tolerance: float) -> None:
    """Have the kernel for one kind of problem."""
    oscillator = sp.Oscillator(barrier=barrier)
    sp.run(oscillator, paths=1, duration=1.0, step=0.1, start="rest", scheme=scheme, memory_tolerance=tolerance)


if __name__ == "__main__":
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        list(pool.map(compiled, *zip(*KINDS, strict=True)))
