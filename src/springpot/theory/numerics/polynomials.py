"""Roots of polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats

_NOTHING = 1e-150  # of the largest coefficient: roots that it makes lie beyond double precision


def roots_of(coefficients: Floats | Sequence[float]) -> Any:
    """The roots of c0 + c1 x + c2 x^2 + ..., without those that a denormal last coefficient would put anywhere.

    Examples
    --------
    >>> roots_of([-1.0, 1.0]).tolist(), roots_of([-1.0, 1.0, 1e-320]).tolist(), roots_of([2.0]).tolist()
    ([1.0], [1.0], [])
    """
    given = np.asarray(coefficients, float)
    kept = np.flatnonzero(np.abs(given) > _NOTHING * np.abs(given).max(initial=0.0))
    return np.polynomial.polynomial.polyroots(given[: kept[-1] + 1]) if kept.size else np.zeros(0)
