"""Compile what most tests need: ``python -m tests.kernels``, before processes that would each compile it.

It is then on disk.  Two at a time, for a compilation has one thread.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor

import numpy as np

import springpot as sp
from springpot.fitting.impact_filter import Flow, filtered
from springpot.simulation.kernel import callbacks
from springpot.simulation.kernel.native import ENTRIES, KERNELS, KERNELS_BY_LANE
from springpot.simulation.monte_carlo import simulate  # noqa: F401  (one process makes the bytecode that all need)

PAIR = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), *(sp.Spring(1.0, between=("ground", end)) for end in "ab"),
    sp.Dashpot(0.5, between=("ground", "a")), sp.WhiteNoise(1.0, on="a"),
)  # fmt: skip


def filter_of_walls() -> None:
    """Of fits to records of a mass that strikes walls."""
    wall = Flow(9.0, 0.4, 1.0, *np.zeros((2, 0)), np.array([[-0.1, 1.0, 0.7]]), np.zeros(0), np.zeros((0, 5)))
    filtered(np.zeros((1, 2)), 0.1, 1, 0, 0, 0.01, np.eye(2), wall, *np.zeros((3, 1, 2)))


TO_COMPILE: tuple[Callable[[], object], ...] = (
    filter_of_walls, *(kernels[kind].load for kernels in (KERNELS, KERNELS_BY_LANE) for kind in kernels),
)  # fmt: skip


def compiled(number: int) -> None:
    """Have one of them."""
    TO_COMPILE[number]()


def in_memory() -> tuple[int, int]:
    """How many compiled functions this process has: those that Python calls, and those that the kernel calls."""
    return sum(entry.is_loaded for entry in ENTRIES), len(callbacks._recent._made)


if __name__ == "__main__":
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        list(pool.map(compiled, range(len(TO_COMPILE))))
