"""Where the parts of a system act: the numbers of the two points of each, and what it sees of their displacements."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from springpot.problem.parts.registration import Element
from springpot.problem.system import System

__all__ = ["GROUND", "ends_of", "row_of", "rows_of"]

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
