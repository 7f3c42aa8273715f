"""Where the parts of a system act: the numbers of the two points of each, and what it sees of their displacements."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.coordinates import Coordinates
from springpot.problem.parts.registration import Element
from springpot.problem.system import System

GROUND = -1


def ends_of(system: System) -> dict[str, tuple[int, int]]:
    """The numbers of the two points of each part, `GROUND` of the ground.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> ends_of(System(Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(2.0, between=("ground", "b"))))
    {'spring': (-1, 1)}
    """
    points = system.points
    known = {"ground": GROUND} | {point: number for number, point in enumerate(points)}
    found = {}
    for name, part in system.elements.items():
        first, second = part.between or ("ground", points[0])
        found[name] = known.get(first, 0), known.get(second, 0)  # a mass alone is called mass too
    return found


def rows_of(system: System, kind: type[Element]) -> Floats:
    """The row of each part of a kind, in their order: of numbers for the displacements of all points.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> rows_of(System(Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(2.0, between=("a", "b"))), Spring).tolist()
    [[-1.0, 1.0]]
    """
    at = Coordinates.of_masses(system.points)
    return np.array([at.row(part.between) for part in system.of(kind)]).reshape(-1, len(system.points))


def followed(system: System) -> Iterator[dict[str, Any]]:
    """What the charts can show: the one mass, or each point of several and each two with a part between them.

    ``name`` is how the names of its results begin, ``row`` what it takes of the displacement of each point.
    """
    at = Coordinates.of_masses(system.points)
    for own, row in at.beginnings.items():
        yield {"name": own, "title": titled(own[:-1]), "row": row.tolist(), "pair": False}
    for pair in system.coordinates.linked:
        name, title = f"{'_'.join(pair)}_elongation_", " to ".join(map(titled, pair))
        yield {"name": name, "title": title, "row": at.row(pair).tolist(), "pair": True}


def titled(name: str) -> str:
    """A name as the page writes it.

    Examples
    --------
    >>> titled("left_wall")
    'left wall'
    """
    return name.replace("_", " ")
