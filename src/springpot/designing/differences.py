"""Differences: where a function is evaluated, and with which weights that gives its derivative."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats


@dataclass(frozen=True)
class Stencil:
    """Places in units of the step, and weights times the step.

    Attributes
    ----------
    offsets, weights : tuple of float
    powers : tuple of int
        Powers of the step in the error, the lowest first.
    """

    offsets: tuple[float, ...]
    weights: tuple[float, ...]
    powers: tuple[int, ...]


CENTRAL = Stencil((-1.0, 1.0), (-0.5, 0.5), (2, 4, 6))
BACKWARD = Stencil((-1.0, -0.5, 0.0), (1.0, -4.0, 3.0), (2, 3, 4))
FORWARD = Stencil((0.0, 0.5, 1.0), (-3.0, 4.0, -1.0), (2, 3, 4))


def stencil(allowed: Callable[[float], bool], step: float) -> Stencil | None:
    """Central where both sides are allowed, one-sided where one is; None if neither is.

    Parameters
    ----------
    allowed : callable
        Whether the function exists at this distance.
    step : float

    Examples
    --------
    >>> stencil(lambda distance: distance <= 0.0, 0.1).offsets
    (-1.0, -0.5, 0.0)
    """
    below, above = allowed(-step), allowed(step)
    if below and above:
        return CENTRAL
    return BACKWARD if below else FORWARD if above else None


def extrapolated(differences: Sequence[Floats], powers: Sequence[int]) -> tuple[Floats, Floats]:
    """Richardson's extrapolation of differences at a step and its halves, with an estimate of the error.

    Parameters
    ----------
    differences : sequence of ndarray
        The largest step first, each half of the one before.
    powers : sequence of int
        Of the step in the error.

    Returns
    -------
    value, error : ndarray
        The error is the last change, of the orders and of the steps, whichever is larger.

    Examples
    --------
    >>> f = lambda h: np.array([(np.exp(h) - np.exp(-h)) / (2.0 * h)])
    >>> value, error = extrapolated([f(0.04), f(0.02), f(0.01)], (2, 4, 6))
    >>> bool(abs(value[0] - 1.0) < error[0] < 1e-8)
    True
    """
    column = list(differences)
    error = np.abs(column[-1] - column[0])
    for power in powers[: len(differences) - 1]:
        finer = [later + (later - before) / (2.0**power - 1.0) for before, later in itertools.pairwise(column)]
        error = np.abs(finer[-1] - column[-1])
        if len(finer) > 1:
            error = np.maximum(error, np.abs(finer[-1] - finer[-2]))
        column = finer
    return column[-1], error
