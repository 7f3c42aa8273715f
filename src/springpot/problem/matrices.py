"""A system of several masses from its matrices: which springs and dashpots they are made of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.machine.faults import shown
from springpot.problem.parts import Dashpot, Mass, Spring
from springpot.problem.parts.registration import Part

__all__ = ["parts_of_matrices"]

_ROUNDING = 1e-13  # of a sum of a row, over the sum of its sizes


def parts_of_matrices(
    mass: ArrayLike, stiffness: ArrayLike, damping: ArrayLike | None, names: Sequence[str] | None
) -> Iterator[Part]:
    """The masses, springs and dashpots of `springpot.System.from_matrices`.

    Raises
    ------
    TypeError, ValueError
        If a matrix is not one, has another shape, is not symmetric, or that of the masses is not diagonal or singular.

    Examples
    --------
    >>> [*parts_of_matrices([[2.0]], [[8.0]], None, ["box"])]
    [Mass(value=2.0, at='box'), Spring(stiffness=8.0, between=('ground', 'box'))]
    """
    masses = _matrix(mass, "mass", None)
    size = len(masses)
    if np.any(masses - np.diag(np.diag(masses))):
        raise ValueError("mass must be a diagonal matrix: a mass that two points share has no place in a System.")
    if not np.all(np.diag(masses) > 0.0):
        raise ValueError(f"mass must not be singular: each mass must be positive, not {np.diag(masses).min():g}.")
    points = [f"m{place + 1}" for place in range(size)] if names is None else [*names]
    if isinstance(names, str) or len(points) != size:
        raise ValueError(f"names must be a name for each of the {size} masses, not {shown(names)}.")
    if same := [point for place, point in enumerate(points) if point in points[:place]]:
        raise ValueError(f"names must be different, but {shown(same[0])} is the name of two masses.")
    yield from (Mass(value, at=point) for value, point in zip(np.diag(masses).tolist(), points, strict=True))
    for kind, given, name in ((Spring, stiffness, "stiffness"), (Dashpot, damping, "damping")):
        if given is not None:
            yield from _between(kind, _symmetric(_matrix(given, name, size), name), points, name)


def _matrix(given: ArrayLike, name: str, size: int | None) -> NDArray[np.float64]:
    try:
        found = np.asarray(given, float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a matrix of numbers, not {shown(given)}.") from None
    if found.ndim != 2 or found.shape[0] != found.shape[1] or not found.size:
        raise ValueError(f"{name} must be a square matrix, not an array of shape {found.shape}.")
    if size is not None and len(found) != size:
        raise ValueError(f"{name} must be a matrix of {size} rows as the masses, not of {len(found)}.")
    if not np.all(np.isfinite(found)):
        raise ValueError(f"{name} must be a matrix of finite numbers.")
    return found


def _symmetric(matrix: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    apart = np.abs(matrix - matrix.T)
    if apart.max() > _ROUNDING * np.abs(matrix).max():
        first, second = sorted(np.unravel_index(apart.argmax(), apart.shape))
        raise ValueError(
            f"{name} must be a symmetric matrix, but it has {matrix[first, second]:g} at [{first}, {second}] and "
            f"{matrix[second, first]:g} at [{second}, {first}]."
        )
    return 0.5 * (matrix + matrix.T)


def _between(kind: Any, matrix: NDArray[np.float64], points: list[str], name: str) -> Iterator[Part]:
    """A part to the ground for each sum of a row, and one between two masses for each number off the diagonal."""
    for place, point in enumerate(points):
        total, size = matrix[place].sum(), np.abs(matrix[place]).sum()
        if abs(total) > _ROUNDING * size:
            yield _part(kind, float(total), ("ground", point), f"the sum of row {place} of {name}")
        for other in range(place + 1, len(points)):
            if matrix[place, other]:
                where = f"minus {name}[{place}, {other}]"
                yield _part(kind, -float(matrix[place, other]), (point, points[other]), where)


def _part(kind: Any, value: float, between: tuple[str, str], where: str) -> Part:
    if kind is Dashpot and value < 0.0:
        raise ValueError(f"{where} must not be negative: it is the coefficient of the dashpot between them.")
    part: Part = kind(value, between=between)
    return part
