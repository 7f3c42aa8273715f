"""Integrals over polytopes: simplices, cut at planes, with Gauss's rule on each, halved where it is not fine enough."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from springpot.machine.arrays import Floats
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.result import NoConvergenceError

_ORDERS = 16, 12  # of the rule, and of the one that it is compared with
_CHUNK = 200_000  # points at once
_MOST_POINTS = 30_000_000
_ON = 1e-12  # of the size of a simplex, of a corner that is on a plane
_LATTICE = 8  # subdivisions of a facet


def simplices_of_box(low: Floats, high: Floats) -> Floats:
    """The simplices of a box, one for each order of its edges: shape (simplices, corners, axes).

    Examples
    --------
    >>> simplices_of_box(np.zeros(2), np.ones(2)).tolist()
    [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]]
    """
    size = len(low)
    steps = [np.eye(size)[list(order)] for order in itertools.permutations(range(size))]
    unit = np.array([np.vstack([np.zeros(size), np.cumsum(step, axis=0)]) for step in steps])
    return np.asarray(low + unit * (high - low))


def cut(simplices: Floats, normal: Floats, place: float) -> tuple[Floats, Floats]:
    """The simplices before a plane, ``normal @ x >= place``, and behind it; those that it goes through are divided.

    Examples
    --------
    >>> before, behind = cut(simplices_of_box(np.zeros(2), np.ones(2)), np.array([1.0, 0.0]), 0.25)
    >>> len(before), len(behind)
    (3, 3)
    """
    whole, found = simplices, simplices @ normal - place
    size = float(np.abs(normal) @ np.ptp(simplices, axis=(0, 1))) if len(simplices) else 0.0
    found[np.abs(found) <= _ON * size] = 0.0
    while (crossed := (found.min(axis=1) < 0.0) & (found.max(axis=1) > 0.0)).any():
        at, distance = whole[crossed], found[crossed]
        rows = np.arange(len(at))
        first, last = distance.argmin(axis=1), distance.argmax(axis=1)
        below, above = distance[rows, first], distance[rows, last]
        point = at[rows, first] + (at[rows, last] - at[rows, first]) * (below / (below - above))[:, None]
        parts, distances = [whole[~crossed]], [found[~crossed]]
        for corner in (first, last):
            part, own = at.copy(), distance.copy()
            part[rows, corner], own[rows, corner] = point, 0.0
            parts.append(part)
            distances.append(own)
        whole, found = np.concatenate(parts), np.concatenate(distances)
    before = found.max(axis=1) > 0.0
    return whole[before], whole[~before]


def facets_on(simplices: Floats, axis: int, place: float) -> Floats:
    """Points on the facets of simplices that lie on the plane of one coordinate.

    Examples
    --------
    >>> len(facets_on(simplices_of_box(np.zeros(2), np.ones(2)), 0, 1.0))
    9
    """
    size = simplices.shape[2]
    on = np.abs(simplices[..., axis] - place) <= _ON * np.ptp(simplices[..., axis])
    kept = on.sum(axis=1) == size
    if not kept.any():
        return np.zeros((0, size))
    corners = simplices[kept][on[kept]].reshape(-1, size, size)
    return np.asarray((_lattice(size) @ corners).reshape(-1, size))


def _lattice(corners: int) -> Floats:
    """Shares of corners, evenly spread."""
    counts = itertools.product(range(_LATTICE + 1), repeat=corners)
    return np.array([count for count in counts if sum(count) == _LATTICE]) / _LATTICE


@lru_cache(maxsize=16)
def _rule(size: int, order: int) -> tuple[Floats, Floats]:
    """Gauss's rule on a simplex with one collapsed axis after the other: shares of corners, and weights."""
    nodes, weights = panel_rule(np.array([0.0, 1.0]), order)
    shares, sizes = np.ones((1, 1)), np.ones(1)
    for axis in range(size):  # what the last corner had is divided between it and one more
        left = shares[:, None, -1] * (1.0 - nodes)
        moved = shares[:, None, -1] * nodes
        kept = np.repeat(shares[:, None, :-1], order, axis=1)
        sizes = (sizes[:, None] * weights * (1.0 - nodes) ** (size - 1 - axis)).ravel()
        shares = np.concatenate([kept, moved[..., None], left[..., None]], axis=2)
        shares = shares.reshape(-1, axis + 2)
    return shares, sizes


def integral(
    values: Callable[[Floats], Floats], simplices: Floats, tolerance: float, positive: int = 0
) -> tuple[Floats, float]:
    """The integrals of several functions over simplices, and a bound on their errors.

    Parameters
    ----------
    values : callable
        Of points, shape (points, axes): an array of shape (points, functions), the first of which is positive.
    simplices : ndarray
        Of `simplices_of_box` or `cut`.
    tolerance : float
        Over the first integral, which is positive.
    positive : int
        How many of the last functions are positive too, and have the tolerance over their own integrals.

    Returns
    -------
    found : ndarray, shape (functions,)
    error : float
        The sum of the differences between two rules, as the tolerance: far more than the error itself.

    Raises
    ------
    NoConvergenceError
        If too many points are needed.

    Examples
    --------
    >>> square = simplices_of_box(np.zeros(2), np.ones(2))
    >>> found, error = integral(lambda x: np.exp(x.sum(axis=1))[:, None], square, 1e-10)
    >>> bool(abs(found[0] - (np.e - 1.0) ** 2) < 1e-12)
    True
    """
    found, errors = _both(values, simplices)
    points = 0
    while True:
        total = found.sum(axis=0)
        own = np.arange(len(total)) >= len(total) - positive
        scale = np.where(own, np.maximum(total, 1e-300), total[0])
        worst = (errors / scale).max(axis=1)
        if worst.sum() <= tolerance:
            return total, float(worst.sum())
        rising = np.argsort(worst)
        open_ = np.zeros(len(worst), bool)
        open_[rising[np.cumsum(worst[rising]) > 0.5 * tolerance]] = True
        halves = _halved(simplices[open_])
        points += len(halves) * sum(order ** simplices.shape[2] for order in _ORDERS)
        if points > _MOST_POINTS or not np.isfinite(total).all():
            raise NoConvergenceError("an integral over the displacements did not settle: the density is too narrow.")
        more = _both(values, halves)
        simplices = np.concatenate([simplices[~open_], halves])
        found, errors = (np.concatenate([old[~open_], new]) for old, new in zip((found, errors), more, strict=True))


def _both(values: Callable[[Floats], Floats], simplices: Floats) -> tuple[Floats, Floats]:
    """The integrals over each simplex, and their differences to those of the lower order."""
    fine, coarse = (_on_each(values, simplices, order) for order in _ORDERS)
    return fine, np.abs(fine - coarse)


def _on_each(values: Callable[[Floats], Floats], simplices: Floats, order: int) -> Floats:
    size = simplices.shape[2]
    shares, weights = _rule(size, order)
    volumes = np.abs(np.linalg.det(simplices[:, 1:] - simplices[:, :1]))
    at_once = max(_CHUNK // len(weights), 1)
    found = []
    for start in range(0, len(simplices), at_once):
        points = shares @ simplices[start : start + at_once]
        there = values(points.reshape(-1, size)).reshape(*points.shape[:2], -1)
        found.append(np.einsum("q,sqf->sf", weights, there))
    return np.asarray(np.concatenate(found) * volumes[:, None])


def _halved(simplices: Floats) -> Floats:
    """Each simplex divided at the middle of its longest edge."""
    pairs = np.array([*itertools.combinations(range(simplices.shape[1]), 2)])
    lengths = np.linalg.norm(simplices[:, pairs[:, 0]] - simplices[:, pairs[:, 1]], axis=2)
    first, last = pairs[lengths.argmax(axis=1)].T
    rows = np.arange(len(simplices))
    middle = 0.5 * (simplices[rows, first] + simplices[rows, last])
    one, other = simplices.copy(), simplices.copy()
    one[rows, first], other[rows, last] = middle, middle
    return np.concatenate([one, other])
