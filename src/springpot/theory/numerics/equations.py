"""Equations that are solved: fixed points x = g(x), and roots of polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats

_NOTHING = 1e-150  # of the largest coefficient: roots that it makes lie beyond double precision


class Anderson:
    """Combines the last steps of an iteration so that the step is shortest if g is linear.

    The method is that of D. G. Anderson, J. ACM 12 (1965) 547.

    Parameters
    ----------
    depth : int
        Number of earlier steps that are used.
    cutoff : float
        Singular values of the differences of the steps below this part of the largest count as 0.

    Examples
    --------
    >>> mix, x = Anderson(3), np.array([0.5, 0.5])
    >>> for _ in range(12):
    ...     x = mix.step(x, np.cos(x[::-1]))
    >>> [round(float(value), 9) for value in x]
    [0.739085133, 0.739085133]
    """

    def __init__(self, depth: int, cutoff: float = 1e-10) -> None:
        self._depth, self._cutoff = depth, cutoff
        self._points: list[Floats] = []
        self._images: list[Floats] = []
        self._steps: list[Floats] = []

    def step(self, point: Floats, image: Floats) -> Floats:
        """The next point, from the last one and its image g(point)."""
        self._remember(point, image)
        if len(self._steps) == 1:
            return image
        return np.asarray(image - self._shares() @ np.diff(np.array(self._images), axis=0))

    def part_of_step(self, point: Floats, image: Floats, part: float) -> Floats:
        """The same with a step reduced by the factor ``part``; restarts if the steps have become twice as long."""
        step = image - point
        if self._steps and np.abs(step).max() > 2.0 * np.abs(self._steps[-1]).max():
            self._points, self._images, self._steps = [], [], []
        self._remember(point, image)
        if len(self._steps) == 1:
            return np.asarray(point + part * step)
        shares = self._shares()
        there = point - np.diff(self._points, axis=0).T @ shares
        return np.asarray(there + part * (step - np.diff(self._steps, axis=0).T @ shares))

    def _remember(self, point: Floats, image: Floats) -> None:
        self._points = [*self._points[-self._depth :], point]
        self._images = [*self._images[-self._depth :], image]
        self._steps = [*self._steps[-self._depth :], image - point]

    def _shares(self) -> Floats:
        """The combination of the differences between the steps that is closest to the last step."""
        differences = np.diff(np.array(self._steps), axis=0)
        return np.asarray(np.linalg.lstsq(differences.T, self._steps[-1], rcond=self._cutoff)[0])


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
