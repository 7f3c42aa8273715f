"""Gauss's rule on panels."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike

from springpot.machine.arrays import Floats


@lru_cache(maxsize=16)
def _unit(order: int) -> tuple[Floats, Floats]:
    nodes, weights = legendre.leggauss(order)
    return 0.5 * (nodes + 1.0), 0.5 * weights


def on_panels(low: ArrayLike, high: ArrayLike, order: int) -> tuple[Floats, Floats]:
    """Nodes and weights of Gauss's rule from each low to each high end, one row for each panel.

    Examples
    --------
    >>> nodes, weights = on_panels([0.0, 1.0], [1.0, 3.0], 4)
    >>> np.sum(weights * nodes**2, axis=1).round(6)
    array([0.333333, 8.666667])
    """
    start, end = np.asarray(low, float)[:, None], np.asarray(high, float)[:, None]
    nodes, weights = _unit(order)
    return start + (end - start) * nodes, (end - start) * weights


def panel_rule(edges: ArrayLike, order: int) -> tuple[Floats, Floats]:
    """The same on each panel between consecutive edges, in one row.

    Examples
    --------
    >>> nodes, weights = panel_rule([0.0, 0.3, 1.0], 4)
    >>> round(float(weights @ nodes**2), 12)
    0.333333333333
    """
    ends = np.asarray(edges)
    nodes, weights = on_panels(ends[:-1], ends[1:], order)
    return nodes.ravel(), weights.ravel()
