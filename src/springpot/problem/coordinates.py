"""Where the parts of a system act: its points, the masses at them, and a row of numbers for each part.

A row g stands for what a part sees of the coordinates x: its elongation is g.x, and its force acts along g.  One mass
is the case of one row, 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Coordinates"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The points of a system, and the rows of its parts.

    Attributes
    ----------
    points : tuple of str
        The names of the masses, in the order given.
    masses : ndarray, shape (points,)
        In kg; what inertial parts between points add is not in it.
    elongations : dict of ndarray, shape (points,)
        The row g of each part with two ends, by the part's name.
    forces : dict of ndarray, shape (points,)
        For each excitation the forces on the points per unit of it: 1 on one mass, or minus all masses for an
        acceleration of the ground.
    """

    points: tuple[str, ...]
    masses: Floats
    elongations: Mapping[str, Floats]
    forces: Mapping[str, Floats]

    def row(self, between: tuple[str, str] | None) -> Floats:
        """The row of a part between two ends; not given, between the ground and the one mass.

        Examples
        --------
        >>> Coordinates(("a", "b"), np.ones(2), {}, {}).row(("a", "b")).tolist()
        [-1.0, 1.0]
        """
        first, second = between or ("ground", self.points[0])
        return self._axis(second) - self._axis(first)

    @property
    def numbers(self) -> dict[str, int]:
        """The number of each part's row; parts between the same two ends, in the same order, share one.

        Examples
        --------
        >>> g = {"mount": np.array([-1.0, 1.0]), "leg": np.array([1.0, 0.0]), "stop": np.array([-1.0, 1.0])}
        >>> Coordinates(("a", "b"), np.ones(2), g, {}).numbers
        {'mount': 0, 'leg': 1, 'stop': 0}
        """
        found: dict[tuple[float, ...], int] = {}
        return {name: found.setdefault(tuple(row), len(found)) for name, row in self.elongations.items()}

    @property
    def pairs(self) -> dict[str, Floats]:
        """The rows between two masses, each pair once, by the names of its ends in the order in which the first part
        between them has them.

        Examples
        --------
        >>> g = {"mount": np.array([-1.0, 1.0]), "stop": np.array([1.0, -1.0]), "leg": np.array([1.0, 0.0])}
        >>> {name: row.tolist() for name, row in Coordinates(("a", "b"), np.ones(2), g, {}).pairs.items()}
        {'a_b': [-1.0, 1.0]}
        """
        found: dict[tuple[int, int], Floats] = {}
        for row in self.elongations.values():
            if np.count_nonzero(row) == 2:
                first, second = int(np.argmin(row)), int(np.argmax(row))
                if (second, first) not in found:
                    found.setdefault((first, second), row)
        return {f"{self.points[first]}_{self.points[second]}": row for (first, second), row in found.items()}

    def push(self, on: str) -> Floats:
        """The forces on the points per unit of a force on one mass, or of an acceleration of the ground.

        Examples
        --------
        >>> Coordinates(("a", "b"), np.array([1.0, 2.0]), {}, {}).push("ground").tolist()
        [-1.0, -2.0]
        """
        return -self.masses if on == "ground" else self._axis(on)

    def _axis(self, end: str) -> Floats:
        found = np.zeros(len(self.points))
        if end != "ground":
            found[self.points.index(end) if end in self.points else 0] = 1.0  # a mass alone is called mass too
        return found

    def sum_of(self, numbers: Mapping[str, Any]) -> Any:
        """The matrix sum of number g g^T over parts with two ends, such as the stiffness matrix of their stiffnesses.

        Examples
        --------
        >>> g = {"left": np.array([1.0, 0.0]), "link": np.array([-1.0, 1.0])}
        >>> Coordinates(("a", "b"), np.ones(2), g, {}).sum_of({"left": 3.0, "link": 2.0}).tolist()
        [[5.0, -2.0], [-2.0, 2.0]]
        """
        size = len(self.points)
        return sum(
            (number * np.outer(self.elongations[name], self.elongations[name]) for name, number in numbers.items()),
            np.zeros((size, size)),
        )
