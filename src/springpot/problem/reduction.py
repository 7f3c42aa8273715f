"""The lowest modes of a stiffness and a mass matrix, dense or sparse, and what the modes that are left out would add.

Coordinates without a mass follow the others statically: with the stiffness K and the mass M, whose rows of them are 0,
each mode of a finite frequency satisfies (K - w^2 M) phi = 0 in these rows too, which is their static condensation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats

Matrix = Any
"""An array, or one of scipy.sparse in columns."""

_ROUNDING = 1e-12  # of a mode's stiffness, over what it is made of: no stiffness
_ROUNDED = 1e-7  # the same, of a negative stiffness that is rounding of another program
_LOOSE = "stiffness must not be negative for any motion, and must hold each coordinate that has no mass."
_NO_RESIDUE = 1e-9  # of the flexibility at a point: nothing to be added
_LIGHT = 1e-12  # of the largest mass over stiffness, that of the lowest mode: no mass
_FEW = 20  # masses beside three times the modes, below which all modes are found
_MOST_SEARCHES = 16  # for equal frequencies: each finds one more of them at least
_EQUAL = 1e-6  # squares of frequencies that are closer than so are equal


@dataclass(frozen=True, eq=False)
class NormalModes:
    """Modes of unit modal mass.

    Attributes
    ----------
    squares : ndarray, shape (modes,)
        Of the frequencies in rad/s, rising; 0 of motion that nothing holds.
    shapes : ndarray, shape (coordinates, modes)
    left : ndarray, shape (points,)
        Of the static flexibility at each point, the share of the modes that are not among these.
    """

    squares: Floats
    shapes: Floats
    left: Floats


def is_sparse(given: object) -> bool:
    """Whether it is a matrix of scipy.sparse, which is loaded then.

    Examples
    --------
    >>> is_sparse(np.eye(2))
    False
    """
    return hasattr(given, "tocsc") and hasattr(given, "nnz")


def factor(matrix: Matrix) -> tuple[Callable[[Floats], Floats], int]:
    """The solution of matrix x = b, and how many eigenvalues are negative.

    Raises
    ------
    LinAlgError
        If the matrix is singular.

    Examples
    --------
    >>> solve, negative = factor(np.diag([2.0, 4.0]))
    >>> solve(np.ones(2)).round(12).tolist(), negative
    ([0.5, 0.25], 0)
    """
    if is_sparse(matrix):
        from scipy.sparse.linalg import splu

        try:  # without an exchange of rows the signs of the pivots are those of the eigenvalues (Sylvester)
            found = splu(matrix, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError:
            raise np.linalg.LinAlgError from None
        return found.solve, int(np.count_nonzero(found.U.diagonal() < 0.0))
    from scipy.linalg import cho_factor, cho_solve

    root = cho_factor(matrix, check_finite=False)
    return lambda b: np.asarray(cho_solve(root, b, check_finite=False)), 0


def normal_modes(mass: Matrix, stiffness: Matrix, count: int, points: Floats, residual: Floats) -> NormalModes:
    """The lowest modes, and one more for each point whose static flexibility is kept.

    Parameters
    ----------
    mass, stiffness : ndarray or sparse matrix, shape (coordinates, coordinates)
        Symmetric, and not negative; coordinates of which the mass has only zeros have none.
    count : int
        At most the number of coordinates that have a mass.
    points : ndarray, shape (points, coordinates)
        The rows of those at which the share of the flexibility is wanted.
    residual : ndarray, shape (points,)
        Of bool: at which of them it is kept.

    Raises
    ------
    ValueError
        If a stiffness is negative, or the lowest modes are not found.

    Notes
    -----
    The inverse problem M phi = (K + s M) phi / (w^2 + s) is solved, whose largest eigenvalues are the lowest modes: so
    these have the smallest error, and K may be singular.  s is first below the frequencies, then among them.  The
    residual of a force f at a point is psi = K^-1 f less what the modes have of it (MacNeal, Rubin), orthogonal to all
    of them in M and K; the Ritz vectors of these are the modes that are added.

    Examples
    --------
    >>> chain = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    >>> found = normal_modes(np.eye(3), chain, 1, np.eye(3)[2:], np.array([False]))
    >>> found.squares.round(4).tolist(), found.left.round(4).tolist()
    ([0.1981], [0.0859])
    >>> kept = normal_modes(np.eye(3), chain, 1, np.eye(3)[2:], np.array([True]))
    >>> len(kept.squares), bool((kept.shapes[2] ** 2 / kept.squares).sum().round(12) == 3.0)
    (2, True)
    """
    own, held = mass.diagonal(), stiffness.diagonal()
    ratios = held[own > 0.0] / own[own > 0.0]
    first, find = float(min(ratios[ratios > 0.0], default=1.0)), _of_sparse if is_sparse(mass) else _of_dense
    for shift in (1e-6 * first, 1e-4 * first, 1e-2 * first):
        try:
            squares, shapes = find(mass, stiffness, count, shift)
            break
        except np.linalg.LinAlgError:
            continue
    else:
        raise ValueError(_LOOSE)
    for last in (False, True):
        sizes = np.abs(shapes)
        made_of = (sizes * (abs(stiffness) @ sizes)).sum(axis=0)
        rounding = max(_ROUNDING, float((-squares / made_of).max()) if made_of.all() else 0.0)
        if rounding > _ROUNDED:
            raise ValueError(_LOOSE)
        squares = np.where(squares <= rounding * made_of, 0.0, squares)
        elastic = squares[squares > 0.0]
        if not last and elastic.size:
            squares, shapes = find(mass, stiffness, count, math.sqrt(elastic[0] * elastic[-1]))
    if not elastic.size:
        if count < np.count_nonzero(own):
            raise ValueError(f"modes must be more than {count}, for nothing holds the motion of {count} or more.")
        return NormalModes(squares, shapes, np.zeros(len(points)))
    residues = _residues(mass, stiffness, squares, shapes, points)
    left = np.maximum((points * residues.T).sum(axis=1), 0.0)
    whole = left + (points @ shapes[:, squares > 0.0]) ** 2 @ (1.0 / elastic)
    kept = residual & (left > _NO_RESIDUE * whole)
    if kept.any():
        new_squares, new_shapes = _ritz(mass, stiffness, residues[:, kept], _LIGHT / elastic[0])
        left = left - (points @ new_shapes) ** 2 @ (1.0 / new_squares)
        squares, shapes = np.append(squares, new_squares), np.hstack([shapes, new_shapes])
    return NormalModes(squares, shapes, np.where(left > _NO_RESIDUE * whole, left / np.where(whole, whole, 1.0), 0.0))


def _of_dense(mass: Floats, stiffness: Floats, count: int, shift: float) -> tuple[Floats, Floats]:
    from scipy.linalg import eigh

    size = len(mass)
    found, shapes = eigh(mass, stiffness + shift * mass, subset_by_index=(size - count, size - 1))
    found, shapes = found[::-1], shapes[:, ::-1]
    return 1.0 / found - shift, shapes / np.sqrt(found)


def _of_sparse(mass: Matrix, stiffness: Matrix, count: int, shift: float) -> tuple[Floats, Floats]:
    """By Lanczos' method, which may miss some of equal frequencies.

    Those below the last one are counted (Sylvester), and what is missing is looked for beside the modes that are known.

    Of few masses all modes are found, from the static flexibility at these.
    """
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

    solve, negative = factor(stiffness + shift * mass)
    if negative:
        raise np.linalg.LinAlgError
    own = np.flatnonzero(mass.diagonal())
    if len(own) < 3 * count + _FEW:
        root = np.linalg.cholesky(mass[:, own][own].toarray())
        columns = solve((np.arange(mass.shape[0])[:, None] == own).astype(float))
        found, ways = np.linalg.eigh(root.T @ columns[own] @ root)
        found, ways = found[: -count - 1 : -1], ways[:, : -count - 1 : -1]
        return 1.0 / found - shift, columns @ (root @ ways) / found
    start = np.random.default_rng(1).normal(size=mass.shape[0])
    squares, shapes = np.zeros(0), np.zeros((mass.shape[0], 0))
    for more in range(2, 2 + _MOST_SEARCHES):
        weighted = mass @ shapes

        def beside(force: Floats, shapes: Floats = shapes, weighted: Floats = weighted) -> Floats:
            """What it displaces, without the modes that are known."""
            moved = solve(force)
            return np.asarray(moved - shapes @ (weighted.T @ moved))

        try:
            inverse = LinearOperator(mass.shape, matvec=beside, dtype=float)
            new, new_shapes = eigsh(stiffness, count + more, mass, -shift, v0=start, OPinv=inverse)
        except ArpackNoConvergence:
            continue
        squares, shapes = np.append(squares, new), np.hstack([shapes, new_shapes])
        order = np.argsort(squares)
        squares, shapes = squares[order], shapes[:, order]
        border = squares[count - 1] - _EQUAL * (squares[count - 1] + shift)
        _, below = factor(stiffness - border * mass)
        if below == np.count_nonzero(squares < border):
            return squares[:count], shapes[:, :count]
    raise ValueError(f"modes must be another number: the lowest {count} are not all found.")


def _residues(mass: Matrix, stiffness: Matrix, squares: Floats, shapes: Floats, points: Floats) -> Floats:
    """What a unit force at each point displaces, less what the modes have of it; a column for each."""
    weighted = mass @ shapes

    def without_modes(given: Floats) -> Floats:
        return np.asarray(given - shapes @ (weighted.T @ given))

    free = squares == 0.0
    shift = 1e-3 * squares[~free][0] if free.any() else 0.0
    solve, _ = factor(stiffness + shift * mass)
    first = found = without_modes(solve(np.ascontiguousarray(points.T)))
    for _ in range(6 if shift else 0):  # K^-1 = A^-1 + s A^-1 M A^-1 + ... of A = K + s M, each a thousandth
        found = first + shift * without_modes(solve(mass @ found))
    return found


def _ritz(mass: Matrix, stiffness: Matrix, residues: Floats, least: float) -> tuple[Floats, Floats]:
    """The modes within some displacements, by their frequencies."""
    from scipy.linalg import eigh

    held = residues.T @ (stiffness @ residues)
    ways = residues / np.sqrt(held.diagonal())
    try:
        found, own = eigh(ways.T @ (mass @ ways), ways.T @ (stiffness @ ways))
    except np.linalg.LinAlgError:
        raise ValueError("residual must not name points that always move alike.") from None
    if not found[0] > least:
        raise ValueError("residual must name points where what is left out has a mass.")
    return 1.0 / found[::-1], (ways @ own)[:, ::-1] / np.sqrt(found[::-1])
