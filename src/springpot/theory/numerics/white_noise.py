"""What white noise makes of a linear system in a time."""

from __future__ import annotations

import math

import numpy as np
from scipy import linalg

from springpot.machine.arrays import Floats


def gathered(generator: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """exp(A) and the covariance that a linear equation gathers in a unit of time, for rates of any size.

    Van Loan's exponential overflows for fast decay, so short times are doubled: P(2 t) = P P, and the covariance of the
    first half is carried through the second.

    Examples
    --------
    >>> step, spread = gathered(np.array([[-1.0]]), np.array([[2.0]]))
    >>> round(float(step[0, 0]), 6), round(float(spread[0, 0]), 6)  # 1 / e, 1 - 1 / e^2
    (0.367879, 0.864665)
    """
    halvings = max(0, math.ceil(math.log2(max(float(np.abs(generator).sum(axis=1).max()), 1e-300))) + 1)
    size, short = len(generator), 0.5**halvings
    joint = np.zeros((2 * size, 2 * size))
    joint[:size, :size], joint[:size, size:], joint[size:, size:] = -generator, noise, generator.T
    power = linalg.expm(short * joint)
    step = power[size:, size:].T
    spread = step @ power[:size, size:]
    for _ in range(halvings):
        spread = spread + step @ spread @ step.T
        step = step @ step
    return step, 0.5 * (spread + spread.T)
