"""Where the parts of a system act: its coordinates, the masses on them, and rows of numbers for points and parts.

A row p says how a point moves with the coordinates q, its displacement is p.q.  A part between two points sees the
difference g of their rows: its elongation is g.q, and its force acts along g.  Each mass is a coordinate, and a point
of its own: its row has a single 1.  One mass is the case of one row, 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, meant, shown

MOST_PARTS = 64  # of a system: more than a device has, and few enough that every theory answers in seconds
_ROUNDED = 1e-12  # of the sum of the sizes of the terms: as little as this is what rounding leaves of 0


def product_of(one: Floats, other: Floats) -> float:
    """The product of two rows; 0 where nothing but rounding is left of it.

    Two masses that the ground moves alike are driven apart by nothing, and whether that is so turns on no last bit.

    Examples
    --------
    >>> product_of(np.array([0.1, 0.2, -0.3]), np.ones(3)), product_of(np.array([0.5, 0.25]), np.ones(2))
    (0.0, 0.75)
    """
    product = float(one @ other)
    return product if abs(product) > _ROUNDED * float(np.abs(one) @ np.abs(other)) else 0.0


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The coordinates of a system, and the rows of its points and parts.

    Attributes
    ----------
    points : tuple of str
        The names of the masses, in the order given, and after them those of the other points.
    rows : ndarray, shape (points, coordinates)
        How each moves.
    masses, participations : ndarray, shape (coordinates,)
        In kg; and how far each moves with the ground where everything does.
    mass : ndarray, shape (coordinates, coordinates)
        The mass matrix: of the masses, and of what inertial parts between points add.
    ends : dict of (str, str)
        Of each part with two ends, by its name.
    elongations : dict of ndarray, shape (coordinates,)
        The row g of each part with two ends, by its name.
    forces : dict of ndarray, shape (coordinates,)
        For each excitation the forces on the coordinates per unit of it: the row of a point, or minus all masses, times
        their participations, for an acceleration of the ground.
    """

    points: tuple[str, ...]
    rows: Floats
    masses: Floats
    participations: Floats
    mass: Floats
    ends: Mapping[str, tuple[str, str]]
    elongations: Mapping[str, Floats]
    forces: Mapping[str, Floats]

    @classmethod
    def of_masses(cls, points: Sequence[str], masses: Sequence[float] | None = None) -> Coordinates:
        """Those of masses alone, of 1 kg each where nothing else is given.

        Examples
        --------
        >>> Coordinates.of_masses("ab", [2.0, 3.0]).mass.tolist()
        [[2.0, 0.0], [0.0, 3.0]]
        """
        size = len(points)
        of_each = np.ones(size) if masses is None else np.array(masses, float)
        return cls(tuple(points), np.eye(size), of_each, np.ones(size), np.diag(of_each), {}, {}, {})

    @property
    def names(self) -> tuple[str, ...]:
        """Of the coordinates: those of the masses."""
        return self.points[: len(self.masses)]

    @property
    def lone(self) -> bool:
        """Whether there is one point: all parts lie on its row, 1, so that springs and walls make a potential of its
        place.
        """
        return len(self.points) == 1

    @property
    def beginnings(self) -> dict[str, Floats]:
        """The row of each point by how the names of its results begin: with its name, or with nothing if it is alone.

        Examples
        --------
        >>> [*Coordinates.of_masses("ab").beginnings], [*Coordinates.of_masses("a").beginnings]
        (['a_', 'b_'], [''])
        """
        return {"" if self.lone else f"{point}_": row for point, row in zip(self.points, self.rows, strict=True)}

    @property
    def called(self) -> dict[str, Floats]:
        """The row of each point by what it may be called: one alone needs no name, and may be called mass.

        Examples
        --------
        >>> [*Coordinates.of_masses("ab").called], [*Coordinates.of_masses(["box"]).called]
        (['a', 'b'], ['', 'mass', 'box'])
        """
        return {name: self._axis(name) for name in ("", "mass") * self.lone + self.points}

    def symbol(self, point: str) -> str:
        """Of its displacement in equations.

        Examples
        --------
        >>> Coordinates.of_masses("ab").symbol("b"), Coordinates.of_masses("a").symbol("a")
        ('x_b', 'x')
        """
        return "x" if self.lone else f"x_{point}"

    def said(self, points: Sequence[str]) -> str:
        """Some points in a sentence.

        Examples
        --------
        >>> Coordinates.of_masses("abc").said(["a", "c"]), Coordinates.of_masses("a").said(["a"])
        ('a and c', 'the mass')
        """
        return "the mass" if self.lone else listed(points)

    def as_given(self, places: Floats) -> Any:
        """Places, or velocities, of all masses as users state them: by their names, or the number of one alone.

        Examples
        --------
        >>> Coordinates.of_masses("ab").as_given(np.array([0.5, 0.0])), Coordinates.of_masses("a").as_given(np.ones(1))
        ({'a': 0.5, 'b': 0.0}, 1.0)
        """
        return float(places[0]) if self.lone else dict(zip(self.names, places.tolist(), strict=True))

    def places_of(self, given: Any) -> Floats:
        """Back from that form, with all masses in their order.

        Examples
        --------
        >>> Coordinates.of_masses("ab").places_of({"a": 0.5, "b": 0.0}).tolist()
        [0.5, 0.0]
        """
        return np.array([*given.values()] if isinstance(given, Mapping) else [given], float)

    def checked(self, given: Any, name: str) -> Any:
        """A number, or one for each mass: 0 of those not named.

        Raises
        ------
        TypeError, ValueError
            If it does not say of which masses it is, or of one that there is not, or is no number.

        Examples
        --------
        >>> Coordinates.of_masses("ab").checked({"b": 1}, "initial_position")
        {'a': 0.0, 'b': 1.0}
        """
        points = self.names
        if self.lone:
            return finite_number(given, name, low=-LARGEST, high=LARGEST)
        if not isinstance(given, Mapping):
            example = f"{ {points[0]: 0.01} }, in the command as {points[0]}=0.01"
            raise TypeError(f"{name} must say of which masses it is, in Python as {example}, not {shown(given)}.")
        for point in given:
            if point not in points:
                near = meant(point, points) or f"; there are {listed([*points])}."
                raise ValueError(f"{name} has {point!r}, which is no mass{near}")
        return {
            point: finite_number(given.get(point, 0.0), f"{name} of {point}", low=-LARGEST, high=LARGEST)
            for point in points
        }

    def row(self, between: tuple[str, str] | None) -> Floats:
        """The row of a part between two ends; not given, between the ground and the one mass.

        Examples
        --------
        >>> Coordinates.of_masses("ab").row(("a", "b")).tolist()
        [-1.0, 1.0]
        """
        first, second = between or ("ground", self.points[0])
        return self._axis(second) - self._axis(first)

    @property
    def numbers(self) -> dict[tuple[float, ...], int]:
        """The number of each row that is no coordinate's: of the other points, then of parts; equal ones share one.

        Examples
        --------
        >>> from springpot.problem.parts import Mass, Spring
        >>> from springpot.problem.system import System
        >>> springs = [Spring(1.0, between=ends) for ends in (("a", "b"), ("ground", "a"), ("a", "b"))]
        >>> System(Mass(1.0, at="a"), Mass(1.0, at="b"), *springs).coordinates.numbers
        {(-1.0, 1.0): 0, (1.0, 0.0): 1}
        """
        rows = (*self.rows[len(self.masses) :], *self.elongations.values())
        return {row: number for number, row in enumerate(dict.fromkeys(tuple(row.tolist()) for row in rows))}

    @property
    def pairs(self) -> dict[str, Floats]:
        """The rows between two points, each pair once, by the names of its ends in the order in which the first part
        between them has them.

        Examples
        --------
        >>> from springpot.problem.parts import Mass, Spring
        >>> from springpot.problem.system import System
        >>> springs = [Spring(1.0, between=ends) for ends in (("a", "b"), ("b", "a"), ("ground", "a"))]
        >>> pairs = System(Mass(1.0, at="a"), Mass(1.0, at="b"), *springs).coordinates.pairs
        >>> {name: row.tolist() for name, row in pairs.items()}
        {'a_b': [-1.0, 1.0]}
        """
        return {"_".join(pair): self.row(pair) for pair in self.linked}

    @property
    def linked(self) -> tuple[tuple[str, str], ...]:
        """The ends of `pairs`."""
        first: dict[frozenset[str], tuple[str, str]] = {}
        for pair in self.ends.values():
            if "ground" not in pair:
                first.setdefault(frozenset(pair), pair)
        return tuple(first.values())

    def push(self, on: str) -> Floats:
        """The forces on the coordinates per unit of a force on one point, or of an acceleration of the ground.

        Examples
        --------
        >>> Coordinates.of_masses("ab", [1.0, 2.0]).push("ground").tolist()
        [-1.0, -2.0]
        """
        return -self.masses * self.participations if on == "ground" else self._axis(on)

    def _axis(self, end: str) -> Floats:
        if end == "ground":
            return np.zeros(len(self.masses))
        row: Floats = self.rows[self.points.index(end) if end in self.points else 0]  # a mass alone is called mass too
        return row

    def sum_of(self, numbers: Mapping[str, Any]) -> Any:
        """The matrix sum of number g g^T over parts with two ends, such as the stiffness matrix of their stiffnesses.

        Examples
        --------
        >>> from springpot.problem.parts import Mass, Spring
        >>> from springpot.problem.system import System
        >>> springs = {"left": Spring(3.0, between=("ground", "a")), "link": Spring(2.0, between=("a", "b"))}
        >>> at = System(Mass(1.0, at="a"), Mass(1.0, at="b"), **springs).coordinates
        >>> at.sum_of({"left": 3.0, "link": 2.0}).tolist()
        [[5.0, -2.0], [-2.0, 2.0]]
        """
        size = len(self.masses)
        return sum(
            (number * np.outer(self.elongations[name], self.elongations[name]) for name, number in numbers.items()),
            np.zeros((size, size)),
        )

    def accelerations(self, forces: Floats) -> Floats:
        """Those of the coordinates under forces on them, one row each: M^-1 f.

        Examples
        --------
        >>> Coordinates.of_masses("ab", [1.0, 2.0]).accelerations(np.array([3.0, 3.0])).tolist()
        [3.0, 1.5]
        """
        own = np.diag(self.mass)
        if np.count_nonzero(self.mass) == own.size:
            return np.asarray(forces / own)
        return np.asarray(np.linalg.solve(self.mass, np.atleast_2d(forces).T).T.reshape(np.shape(forces)))

    def reduced(self, row: Floats) -> float:
        """The mass that moves along a row where all else is free: 1 / (g M^-1 g).

        Examples
        --------
        >>> Coordinates.of_masses("ab", [1.0, 1.0]).reduced(np.array([-1.0, 1.0]))
        0.5
        """
        return 1.0 / float((row * self.accelerations(row)).sum())
