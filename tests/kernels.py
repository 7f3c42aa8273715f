"""Compile the kernel in both precisions: ``python -m tests.kernels``, before processes that would each compile it.

It is then on disk.  Two at a time, for a compilation has one thread.
"""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import springpot as sp
from springpot.simulation.monte_carlo import simulated  # here, so that one process makes the bytecode that both need

PAIR = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), *(sp.Spring(1.0, between=("ground", end)) for end in "ab"),
    sp.Dashpot(0.5, between=("ground", "a")), sp.WhiteNoise(1.0, on="a"),
)  # fmt: skip
TOLERANCES = 1e-6, 1e-9  # relative errors of the memory, and with them single and double precision


def compiled(tolerance: float) -> None:
    """Have the kernel in the precision that goes with a tolerance."""
    simulated(sp.Oscillator(), paths=1, duration=1.0, step=0.1, start="rest", memory_tolerance=tolerance)


if __name__ == "__main__":
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        list(pool.map(compiled, TOLERANCES))
