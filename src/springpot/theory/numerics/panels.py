"""Gauss's rule on panels, and functions that are known at its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike

from springpot.machine.arrays import Floats

_NODES = 10  # of a panel of labels


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


@dataclass(frozen=True)
class Labels:
    """Panels of a label, by which cycles of different size are told apart, with the nodes of Gauss's rule.

    Parameters
    ----------
    edges : ndarray
        Ends of the panels.
    """

    edges: Floats

    @property
    def nodes(self) -> Floats:
        """Labels of the nodes, one row for each panel."""
        return on_panels(self.edges[:-1], self.edges[1:], _NODES)[0]

    @property
    def weights(self) -> Floats:
        """Weights of the integral over the label, in the shape of the nodes."""
        return on_panels(self.edges[:-1], self.edges[1:], _NODES)[1]

    def derivative(self, values: Floats) -> Floats:
        """Derivative by the label."""
        return np.asarray((self._rows(values) @ _DERIVATIVE.T / np.diff(self.edges)[:, None]).ravel())

    def integral(self, values: Floats) -> Floats:
        """Integral over the label from the first edge to each node."""
        width = np.diff(self.edges)[:, None]
        rows = self._rows(values) * width
        before = np.r_[0.0, np.cumsum(rows @ _WEIGHTS)[:-1]]
        return np.asarray((rows @ _INTEGRAL.T + before[:, None]).ravel())

    def interpolate(self, values: Floats, label: Floats) -> Floats:
        """Values of the nodes' polynomials at any labels, shape (..., quantities) for values (nodes, quantities)."""
        panel = np.clip(np.searchsorted(self.edges, label, side="right") - 1, 0, self.edges.size - 2)
        place = 2.0 * (label - self.edges[panel]) / (self.edges[panel + 1] - self.edges[panel]) - 1.0
        series = np.einsum("kn,pnq->pkq", _TO_LEGENDRE, values.reshape(-1, _NODES, values.shape[-1]))
        return np.asarray(np.einsum("...k,...kq->...q", legendre.legvander(place, _NODES - 1), series[panel]))

    def _rows(self, values: Floats) -> Floats:
        return values.reshape(-1, _NODES)


_X, _W = legendre.leggauss(_NODES)
_WEIGHTS = _W / 2.0
_TO_LEGENDRE = np.linalg.inv(legendre.legvander(_X, _NODES - 1))
_UNIT = np.eye(_NODES)
_DERIVATIVE = 2.0 * legendre.legval(_X, legendre.legder(_UNIT)).T @ _TO_LEGENDRE
_INTEGRAL = 0.5 * legendre.legval(_X, legendre.legint(_UNIT, lbnd=-1)).T @ _TO_LEGENDRE
