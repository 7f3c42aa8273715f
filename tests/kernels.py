"""Compile the kernels that most tests use: ``python -m tests.kernels``, before processes that would each compile them.

They are then on disk.  Two at a time, for a compilation has one thread.
"""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import springpot as sp
from springpot.simulation.monte_carlo import simulated  # here, so that one process makes the bytecode that both need
from tests.simulation.systems import AWAY, NEARLY_LINEAR, of_many_kinds

SINGLE, DOUBLE = 1e-6, 1e-9  # relative errors of the memory, and with them its precision
FREE = sp.Oscillator(barrier=None)
FEW = sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)
PAIR = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), *(sp.Spring(1.0, between=("ground", end)) for end in "ab"),
    sp.Dashpot(0.5, between=("ground", "a")), sp.WhiteNoise(1.0, on="a"),
)  # fmt: skip
KINDS = (
    # the longest first
    (PAIR, "default", SINGLE), (PAIR, "default", DOUBLE),
    (of_many_kinds(*FEW), "default", SINGLE),
    (sp.System(*FEW, NEARLY_LINEAR, *AWAY, sp.ColoredNoise(1.0, 0.5)), "default", SINGLE),
    (sp.System(*FEW, NEARLY_LINEAR, *AWAY), "default", SINGLE),
    (sp.Oscillator(), "default", SINGLE), (sp.Oscillator(), "default", DOUBLE),
    (sp.Oscillator(), "grunwald", SINGLE), (FREE, "grunwald", DOUBLE),
    (FREE, "default", SINGLE), (FREE, "default", DOUBLE),
)  # fmt: skip


BRANCHED = (PAIR, "a_distance"), (of_many_kinds(*FEW), "distance"), (sp.Oscillator(), "distance")


def branched(problem: sp.System, name: str) -> None:
    """Have the kernel that splits paths."""
    sp.exceedance(problem, {name: 1e-9}, duration=1.0, step=0.1, start="rest", rtol=1.0)


def compiled(problem: sp.System, scheme: str, tolerance: float) -> None:
    """Have the kernel for one kind of problem."""
    simulated(problem, paths=1, duration=1.0, step=0.1, start="rest", scheme=scheme, memory_tolerance=tolerance)


if __name__ == "__main__":
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        own = pool.map(branched, *zip(*BRANCHED, strict=True))
        list(pool.map(compiled, *zip(*KINDS, strict=True)))
        list(own)
