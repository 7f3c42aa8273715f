"""A system of several masses from its matrices: which springs and dashpots they are made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import checked_name, items_of, numbers_in_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown
from springpot.problem.coordinates import MOST_PARTS
from springpot.problem.modes import check_points, numbers_for, rows_in, with_modes
from springpot.problem.parts import Dashpot, Mass, Spring
from springpot.problem.parts.registration import Part

_ROUNDING = 1e-13  # of a sum of a row, over the sum of its sizes
_ASYMMETRY = 1e-9  # of the largest entry: what rounding in another program leaves at most
_OF_SKEW = 10.0  # rounding of a number made of a matrix, over what it makes of the half by which two corners differ
_MOST_LINKS = 48  # springs and dashpots, so that a system has room for masses and more parts


def parts_of_matrices(
    mass: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike | None,
    names: Sequence[str] | Mapping[str, ArrayLike] | None,
    ground: ArrayLike | None = None,
) -> Iterator[Part]:
    """The parts of `springpot.System.from_matrices`.

    Raises
    ------
    TypeError, ValueError
        If a matrix is not one, has another shape, is not symmetric, or that of the masses is not positive definite.

    Examples
    --------
    >>> [*parts_of_matrices([[2.0]], [[8.0]], None, ["box"])]
    [Mass(value=2.0, at='box'), Spring(stiffness=8.0, between=('ground', 'box'))]
    """
    masses, _ = _symmetric(_matrix(mass, "mass", None), "mass")
    size = len(masses)
    held, of_held = _symmetric(_matrix(stiffness, "stiffness", size), "stiffness")
    given = np.zeros_like(held) if damping is None else _matrix(damping, "damping", size)
    damped, of_damped = _symmetric(given, "damping")
    least = np.linalg.eigvalsh(masses)
    if least[0] < -_ROUNDING * least[-1]:
        raise ValueError(f"mass must be positive definite: of one motion the mass is {least[0]:.3g} kg.")
    if not least[0] > _ROUNDING * least[-1]:
        raise ValueError(f"mass must not be singular: each motion must have a mass, but one has {least[0]:.3g} kg.")
    crowded = np.count_nonzero(np.triu(held)) + np.count_nonzero(np.triu(damped)) > _MOST_LINKS
    coupled = crowded or np.any(masses - np.diag(np.diag(masses))) or not _of_dashpots(damped, of_damped)
    if isinstance(names, Mapping) or ground is not None or coupled:
        yield from _by_modes(masses, held, damped, of_damped, names, ground)
        return
    points = _names(names, size)
    yield from (Mass(value, at=point) for value, point in zip(np.diag(masses).tolist(), points, strict=True))
    for kind, matrix, skew in ((Spring, held, of_held), (Dashpot, damped, of_damped)):
        yield from _between(kind, matrix, points, skew)


def _names(names: Sequence[str] | None, size: int) -> list[str]:
    must = f"names must be a name for each of the {size} masses"
    points = [f"m{place + 1}" for place in range(size)] if names is None else [*items_of(names, must)]
    if len(points) != size:
        raise ValueError(f"{must}, not {shown(names)}.")
    for point in points:
        checked_name(point, "each of names")
    if same := [point for place, point in enumerate(points) if point in points[:place]]:
        raise ValueError(f"names must be different, but {shown(same[0])} is the name of two masses.")
    return points


def _by_modes(
    masses: Floats, held: Floats, damped: Floats, skew: Floats, names: Any, ground: ArrayLike | None
) -> Iterator[Part]:
    """The modes of the matrices, and the points by their shapes; dampers that couple modes have points of their own.

    ``skew`` is what the damping has of asymmetry.
    """
    size = len(masses)
    if isinstance(names, Mapping):
        check_points(names, "names")
        rows = np.array([numbers_for(f"names of {point}", row, size, True) for point, row in names.items()])
        points, moves = [*names], np.zeros(size)
    else:
        points, rows, moves = _names(names, size), np.eye(size), np.ones(size)
    if ground is not None:
        moves = numbers_for("ground", ground, size, several=True)
    sizes, alike = np.linalg.eigh(damped)
    least = max(_ROUNDING * sizes[-1], _OF_SKEW * float(np.linalg.norm(skew, 2)))
    if sizes[0] < -least:
        raise ValueError(f"damping must take energy from every motion, but one has a coefficient of {sizes[0]:.6g}.")
    root = np.linalg.inv(np.linalg.cholesky(masses))
    squares, ways = np.linalg.eigh(root @ held @ root.T)
    squares[np.abs(squares) <= _ROUNDING * np.abs(squares).max()] = 0.0
    shapes = root.T @ ways
    seen = rows @ shapes
    seen[np.abs(seen) <= _ROUNDING * np.abs(seen).max()] = 0.0
    largest = np.take_along_axis(seen, np.abs(seen).argmax(axis=0)[None, :], axis=0)[0]
    scales = np.where(largest == 0.0, 1.0, largest)  # a mode's displacement is that of the point that moves most
    shapes, seen, modal = shapes / scales, seen / scales, scales**-2.0
    between = shapes.T @ damped @ shapes
    own, moved = np.diag(between), shapes.T @ masses @ moves / modal
    found = dict(zip(points, seen, strict=True))
    unequal = _OF_SKEW * np.abs(shapes.T @ skew @ shapes).max()
    if np.abs(between - np.diag(own)).max() <= max(1e-12 * np.abs(own).max(), unequal):
        yield from with_modes(modal, squares * modal, np.where(own > unequal, own, 0.0), moved, found)
        return
    dampers = [(c, way) for c, way in zip(sizes.tolist(), alike.T, strict=True) if c > least]
    found |= {f"damper_{n}": way @ shapes for n, (_, way) in enumerate(dampers, 1)}
    yield from with_modes(modal, squares * modal, np.zeros(size), moved, found)
    yield from (Dashpot(c, between=("ground", f"damper_{n}")) for n, (c, _) in enumerate(dampers, 1))


def _matrix(given: ArrayLike, name: str, size: int | None) -> Floats:
    if (rows := rows_in(given)) >= MOST_PARTS:  # before anything is done with so many
        raise ValueError(f"{name} must have fewer rows than {MOST_PARTS}, the most parts of a system, not {rows:,}.")
    found = numbers_in_array(given, f"{name} must be a matrix of numbers")
    if found.ndim != 2 or found.shape[0] != found.shape[1] or not found.size:
        raise ValueError(f"{name} must be a square matrix, not an array of shape {found.shape}.")
    if size is not None and len(found) != size:
        raise ValueError(f"{name} must be a matrix of {size} rows as the masses, not of {len(found)}.")
    if not np.all(np.isfinite(found)):
        raise ValueError(f"{name} must be a matrix of finite numbers.")
    return found


def _symmetric(matrix: Floats, name: str) -> tuple[Floats, Floats]:
    """The mean of a matrix and its transpose, and half their difference: about as large as the rounding of the mean."""
    apart, largest = np.abs(matrix - matrix.T), np.abs(matrix).max()
    if apart.max() > _ASYMMETRY * largest:
        first, second = sorted(np.unravel_index(apart.argmax(), apart.shape))
        raise ValueError(
            f"{name} must be a symmetric matrix, but {matrix[first, second]:g} at [{first}, {second}] and "
            f"{matrix[second, first]:g} at [{second}, {first}] differ by {apart.max():.3g}, "
            f"{apart.max() / largest:.2g} of the largest entry, and rounding leaves {_ASYMMETRY:g} at most."
        )
    mean, skew = 0.5 * (matrix + matrix.T), 0.5 * (matrix - matrix.T)
    return np.where(np.abs(mean) <= _OF_SKEW * np.abs(skew), 0.0, mean), skew


def _of_dashpots(damped: Floats, skew: Floats) -> bool:
    """Whether dashpots between the masses and to the ground have this matrix, none with a negative coefficient."""
    off = damped - np.diag(np.diag(damped))
    return bool((off <= 0.0).all() and (damped.sum(axis=1) >= -_rounding_of_sums(damped, skew)).all())


def _rounding_of_sums(matrix: Floats, skew: Floats) -> Floats:
    """Of each row."""
    return np.asarray(_ROUNDING * np.abs(matrix).sum(axis=1) + _OF_SKEW * np.abs(skew).sum(axis=1))


def _between(kind: Any, matrix: Floats, points: list[str], skew: Floats) -> Iterator[Part]:
    """A part to the ground for each sum of a row, and one between two masses for each number off the diagonal."""
    totals, rounding = matrix.sum(axis=1).tolist(), _rounding_of_sums(matrix, skew).tolist()
    for place, point in enumerate(points):
        if abs(totals[place]) > rounding[place]:
            yield kind(totals[place], between=("ground", point))
        for other in range(place + 1, len(points)):
            if matrix[place, other]:
                yield kind(-float(matrix[place, other]), between=(point, points[other]))
