"""An observer as the kernel calls it: compiled functions, what they see, and an array of numbers with names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.simulation.kernel.kept import Code
from springpot.simulation.kernel.watching import HEADER
from springpot.simulation.plan.signals import Signal


def layout(**fields: int | tuple[int, ...]) -> np.dtype[np.void]:
    """The numbers of an observer's array: those of `HEADER`, then its own fields, each with its shape.

    Examples
    --------
    >>> begins(layout(count=(), sums=(2, 64), ends=3), "length", "count", "ends")
    (0, 6, 135)
    """
    return np.dtype([(name, np.float64, shape) for name, shape in {**dict.fromkeys(HEADER, ()), **fields}.items()])


def begins(kind: np.dtype[np.void], *names: str) -> tuple[int, ...]:
    """Where fields begin in the array of numbers that compiled functions have."""
    assert kind.fields is not None
    return tuple(kind.fields[name][1] // np.dtype(np.float64).itemsize for name in names)


@dataclass(frozen=True, eq=False)
class Observer:
    """One observer: two compiled functions and the array they accumulate in.

    Attributes
    ----------
    signal : Signal
        What they see: a displacement, a force or an acceleration at each step, unless its number is None, and the
        impacts on its wall, or all, unless that is None.
    on_steps, on_impacts : Code or None
        Of the signatures `ON_STEPS` and `ON_IMPACTS` of `springpot.simulation.kernel.watching`.
    initial : ndarray of a `layout`, or callable
        The array at the start of a block, but for its header; or a function of the kernel's arguments that gives it.
    of_paths : tuple of str
        Fields that are results of each path; their last axis is that of the lanes.
    of_batches : tuple of str
        Counts, in whole numbers or halves, which are added up over the blocks of each batch.
    of_blocks : tuple of str
        Fields that are kept of each block: sums, for which the order of the blocks matters.
    every : int
        Groups of steps between two calls of ``on_steps``.
    """

    signal: Signal
    on_steps: Code | None
    on_impacts: Code | None
    initial: Any
    of_paths: tuple[str, ...] = ()
    of_batches: tuple[str, ...] = ()
    of_blocks: tuple[str, ...] = ()
    every: int = 1
