"""Where the parts of a system act: the numbers of the two points of each, and what it sees of their displacements."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.problem.parts.registration import Element
from springpot.problem.system import System

__all__ = ["GROUND", "ends_of", "followed", "row_of", "rows_of", "titled"]

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
    for name, part in system.named():
        if isinstance(part, Element):
            first, second = part.between or ("ground", points[0])
            found[name] = known.get(first, 0), known.get(second, 0)  # a mass alone is called mass too
    return found


def row_of(system: System, ends: tuple[int, int]) -> npt.NDArray[np.float64]:
    """The displacement of the second end less that of the first, as a row of numbers for those of all points.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> row_of(System(Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(2.0, between=("a", "b"))), (0, 1)).tolist()
    [-1.0, 1.0]
    """
    places = np.arange(len(system.points))
    return np.asarray((places == ends[1]) - 1.0 * (places == ends[0]))


def rows_of(system: System, kind: type[Element]) -> npt.NDArray[np.float64]:
    """The row of each part of a kind, in their order."""
    ends = ends_of(system)
    found = [row_of(system, ends[name]) for name, part in system.named() if isinstance(part, kind)]
    return np.array(found).reshape(-1, len(system.points))


def followed(system: System) -> Iterator[dict[str, Any]]:
    """What the charts can show: the one mass, or each point of several and each two with a part between them.

    ``name`` is how the names of its results begin, ``row`` what it takes of the displacement of each point.
    """
    points = system.points
    if len(points) == 1:
        yield {"name": "", "title": "", "row": [1.0], "pair": False}
        return
    for number, point in enumerate(points):
        yield {
            "name": f"{point}_", "title": titled(point), "row": row_of(system, (GROUND, number)).tolist(), "pair": False
        }  # fmt: skip
    for first, second in system.coordinates.linked:
        row = row_of(system, (points.index(first), points.index(second))).tolist()
        title = f"{titled(first)} to {titled(second)}"
        yield {"name": f"{first}_{second}_elongation_", "title": title, "row": row, "pair": True}


def titled(name: str) -> str:
    """A name as the page writes it.

    Examples
    --------
    >>> titled("left_wall")
    'left wall'
    """
    return name.replace("_", " ")
