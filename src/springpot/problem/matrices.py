"""A system of several masses from its matrices: which springs and dashpots they are made of, or its lowest modes."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import check_plain, checked_name, items_of, numbers_in_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import known_word, listed, per_cent, shown
from springpot.problem.coordinates import MOST_PARTS
from springpot.problem.messages import AccuracyWarning, ProblemWarning, say
from springpot.problem.modes import MARK_PARTS, check_points, numbers_for, rows_in, say_if_free, with_modes
from springpot.problem.parts import Dashpot, Mass, Spring
from springpot.problem.parts.registration import Part
from springpot.problem.reduction import Matrix, NormalModes, factor, is_sparse, normal_modes

_ROUNDING = 1e-13  # of a sum of a row, over the sum of its sizes
_ASYMMETRY = 1e-9  # of the largest entry: what rounding in another program leaves at most
_OF_SKEW = 10.0  # rounding of a number made of a matrix, over what it makes of the half by which two corners differ
_UNSEEN = 1e-10  # of what moves most: a point that a mode does not move
_UNCOUPLED = 1e-8  # of the largest damping of a mode: what couples two is rounding
_MOST_LINKS = 48  # springs and dashpots, so that a system has room for masses and more parts
_MOST_DENSE, _MOST_SPARSE, _MOST_NUMBERS = 3000, 200_000, 20_000_000  # rows, and numbers, of a matrix to be reduced
_SAID, _SAID_OF_MASS = 0.01, 0.1  # shares of flexibility and mass that are said where modes leave them out


Form = Literal["whole", "dense", "sparse"]
"""How a matrix is taken: all modes of it; or a few of one that is dense, or sparse."""


def parts_of_matrices(
    mass: ArrayLike | Matrix,
    stiffness: ArrayLike | Matrix,
    damping: ArrayLike | Matrix | None,
    names: Sequence[str] | Mapping[str, ArrayLike] | None,
    ground: ArrayLike | None = None,
    modes: int | None = None,
    damping_ratios: ArrayLike | None = None,
    residual: Sequence[str] = (),
) -> Iterator[Part]:
    """The parts of `springpot.System.from_matrices`.

    Raises
    ------
    TypeError, ValueError
        If a matrix is not one, has another shape, is not symmetric, or has a motion without a mass or with a negative
        one, or an argument is not what it must be.

    Examples
    --------
    >>> [*parts_of_matrices([[2.0]], [[8.0]], None, ["box"])]
    [Mass(value=2.0, at='box'), Spring(stiffness=8.0, between=('ground', 'box'))]
    """
    form: Form = "whole" if modes is None else "dense"
    if modes is not None and any(is_sparse(given) for given in (mass, stiffness, damping)):
        form = "sparse"
    masses, _ = _symmetric(_matrix(mass, "mass", None, form), "mass")
    size = masses.shape[0]
    held, of_held = _symmetric(_matrix(stiffness, "stiffness", size, form), "stiffness")
    given = 0.0 * held if damping is None else _matrix(damping, "damping", size, form)
    damped, of_damped = _symmetric(given, "damping")
    heavy = _with_mass(masses, held)
    if modes is not None and (not _is_whole(modes) or not 0 < modes <= heavy):
        raise ValueError(f"modes must be a whole number from 1 to {heavy}, those of the matrices, not {shown(modes)}.")
    if heavy < size:
        sentence = say("massless_coordinates", count=size - heavy, size=size)
        warnings.warn(sentence, ProblemWarning, stacklevel=3)
    wanted = items_of(residual, "residual must be names of points")
    if wanted and modes is None:
        raise ValueError("residual must be left out without modes=, for all modes are kept then.")
    whole = modes is None and heavy == size and damping_ratios is None
    if whole and not isinstance(names, Mapping) and ground is None:
        crowded = np.count_nonzero(np.triu(held)) + np.count_nonzero(np.triu(damped)) > _MOST_LINKS
        if not crowded and not np.any(masses - np.diag(np.diag(masses))) and _of_dashpots(damped, of_damped):
            points = _names(names, size)
            free = np.linalg.eigvalsh(held)
            say_if_free(int(np.count_nonzero(np.abs(free) <= _ROUNDING * np.abs(free).max())))
            yield from (Mass(value, at=point) for value, point in zip(np.diag(masses).tolist(), points, strict=True))
            for kind, matrix, skew in ((Spring, held, of_held), (Dashpot, damped, of_damped)):
                yield from _between(kind, matrix, points, skew)
            return
    points, rows, moves = _points(names, size, ground)
    for point in wanted:
        known_word(point, points, "residual", "must have names of points:")
    own = normal_modes(masses, held, modes or heavy, rows, np.array([point in wanted for point in points]))
    say_if_free(int(np.count_nonzero(own.squares == 0.0)))
    if modes is not None or heavy < size:
        _say_of_left(own, modes or heavy, points, masses, moves)
    yield from _by_modes(own, masses, damped, of_damped, points, rows, moves, damping_ratios)


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


def _points(names: Any, size: int, ground: ArrayLike | None) -> tuple[list[str], Floats, Floats]:
    """The names of the points, their rows, and how far each coordinate moves with the ground."""
    if isinstance(names, Mapping):
        check_points(names, "names")
        points, moves = [*names], np.zeros(size)
        rows = np.array([_row(f"names of {point}", given, size) for point, given in names.items()])
    else:
        if size >= MOST_PARTS:
            raise ValueError(
                f"names must be of some points, as {{'tip': {size - 1}}} for the last coordinate: a system has at most "
                f"{MOST_PARTS} parts, not a point for each of {size:,} coordinates."
            )
        points, rows, moves = _names(names, size), np.eye(size), np.ones(size)
    if ground is not None:
        moves = numbers_for("ground", ground, size, several=True, each="coordinate")
    return points, rows, moves


def _row(name: str, given: Any, size: int) -> Floats:
    """How a point moves where each coordinate moves by 1 alone: of a whole number, as that coordinate."""
    if _is_whole(given):
        if not 0 <= given < size:
            raise ValueError(f"{name} must be a coordinate from 0 to {size - 1}, not {given}.")
        row = np.zeros(size)
        row[given] = 1.0
        return row
    return numbers_for(name, given, size, several=True, each="coordinate")


def _is_whole(given: object) -> bool:
    return isinstance(given, int | np.integer) and not isinstance(given, bool)


def _say_of_left(own: NormalModes, modes: int, points: Sequence[str], masses: Matrix, moves: Floats) -> None:
    """Warn of the static flexibility at points, and of the mass, that belong to modes that are left out."""
    whole = float(moves @ (masses @ moves))
    mass = 1.0 - float(((moves @ (masses @ own.shapes)) ** 2).sum()) / whole if whole else 0.0
    most = sorted(zip(own.left.tolist(), points, strict=True), reverse=True)
    said = [f"{per_cent(share)} at {point}" for share, point in most if share > _SAID]
    said[:1] = [each.replace(" at ", " of the static flexibility at ") for each in said[:1]]
    said += [f"{per_cent(mass)} of the mass that the ground moves"] * (mass > _SAID_OF_MASS)
    if said:
        top = float(np.sqrt(own.squares[modes - 1]) / (2.0 * np.pi))
        sentence = say("modes_left_out", modes=modes, size=len(moves), top=top, left=listed(said))
        warnings.warn(sentence, AccuracyWarning, stacklevel=4)


def _by_modes(
    own: NormalModes, masses: Matrix, damped: Matrix, skew: Matrix, points: Sequence[str], rows: Floats, moves: Floats,
    damping_ratios: ArrayLike | None,
) -> Iterator[Part]:  # fmt: skip
    """The modes, and the points by their shapes; dampers that couple modes have points of their own.

    ``skew`` is what the damping has of asymmetry.
    """
    shapes, size = own.shapes, len(own.squares)
    ratios = numbers_for("damping_ratios", 0.0 if damping_ratios is None else damping_ratios, size)
    if ratios.min() < 0.0:
        raise ValueError(f"damping_ratios must not be negative, and {ratios.min():g} is among them.")
    seen = rows @ shapes
    seen[np.abs(seen) <= _UNSEEN * np.abs(seen).max()] = 0.0
    largest = np.take_along_axis(seen, np.abs(seen).argmax(axis=0)[None, :], axis=0)[0]
    scales = np.where(largest == 0.0, 1.0, largest)  # a mode's displacement is that of the point that moves most
    moved = (shapes.T @ (masses @ moves)) * scales
    between, unequal = shapes.T @ (damped @ shapes), _OF_SKEW * np.abs(shapes.T @ (skew @ shapes))
    sizes, ways = np.linalg.eigh(between)
    lengths = np.linalg.norm(shapes @ ways, axis=0)  # so that coefficients are in N s/m
    least = max(_ROUNDING * sizes[-1], float(np.linalg.norm(unequal, 2)))
    if sizes[0] < -least:
        worst = sizes[0] / lengths[0] ** 2
        raise ValueError(f"damping must take energy from every motion, but one has a coefficient of {worst:.6g}.")
    found, dampers = dict(zip(points, seen / scales, strict=True)), list[Dashpot]()
    dampings = np.where(np.diag(between) > unequal.max(), np.diag(between), 0.0)
    if np.abs(between - np.diag(np.diag(between))).max() > max(_UNCOUPLED * dampings.max(), unequal.max()):
        for size, way, length in zip(sizes.tolist(), ways.T, lengths.tolist(), strict=True):
            if size > least:
                if (name := f"damper_{len(dampers) + 1}") in points:
                    raise ValueError(f"{name} cannot be the name of a point, for that of a damper is called so.")
                dampers.append(Dashpot(size / length**2, between=("ground", name)))
                found[name] = length * way / scales
        dampings = np.zeros_like(dampings)
    modal = scales**-2.0
    dampings = (dampings + 2.0 * ratios * np.sqrt(own.squares)) * modal
    yield from with_modes(modal, own.squares * modal, dampings, moved, found)
    yield from dampers


def _matrix(given: Any, name: str, size: int | None, form: Form) -> Matrix:
    """A square matrix of finite numbers: an array, or where sparse ones are reduced one of scipy.sparse, in columns."""
    rows, most = (given.shape[0], _MOST_SPARSE) if is_sparse(given) else (rows_in(given), _MOST_DENSE)
    if form == "whole" and rows >= MOST_PARTS:  # before anything is done with so many
        raise ValueError(
            f"{name} must have fewer rows than {MOST_PARTS}, the most parts of a system, not {rows:,}: give modes= for "
            "the lowest modes of a larger one."
        )
    if rows > most or (is_sparse(given) and given.nnz > _MOST_NUMBERS):
        more = f" and {_MOST_NUMBERS:,} numbers" if is_sparse(given) else "; one of scipy.sparse may have more"
        raise ValueError(f"{name} must have at most {most:,} rows{more}.")
    if is_sparse(given) and given.dtype.kind not in "biuf":
        raise TypeError(f"{name} must be a matrix of real numbers, not of {given.dtype}.")
    if is_sparse(given) and form != "sparse":
        given = given.toarray()
    check_plain(given, name, MARK_PARTS)
    found: Any = given if is_sparse(given) else numbers_in_array(given, f"{name} must be a matrix of numbers")
    if found.ndim != 2 or found.shape[0] != found.shape[1] or not found.shape[0]:
        raise ValueError(f"{name} must be a square matrix, not an array of shape {found.shape}.")
    if size is not None and found.shape[0] != size:
        raise ValueError(f"{name} must be a matrix of {size} rows as the masses, not of {found.shape[0]}.")
    if form == "sparse":
        from scipy.sparse import csc_array

        found = csc_array(found, dtype=float)
    if not np.isfinite(found.data if form == "sparse" else found).all():
        raise ValueError(f"{name} must be a matrix of finite numbers.")
    return found


def _symmetric(matrix: Matrix, name: str) -> tuple[Matrix, Matrix]:
    """The mean of a matrix and its transpose, and half their difference: about as large as the rounding of the mean."""
    apart, largest = abs(matrix - matrix.T), abs(matrix).max()
    if apart.max() > _ASYMMETRY * largest:
        one_side = ((matrix * matrix.T) != 0.0).sum() == np.count_nonzero(matrix.diagonal())
        more = "; of a matrix that is stored on one side of its diagonal, add the other side" if one_side else ""
        first, second = sorted(np.unravel_index(apart.argmax(), apart.shape))
        raise ValueError(
            f"{name} must be a symmetric matrix, but {matrix[first, second]:g} at [{first}, {second}] and "
            f"{matrix[second, first]:g} at [{second}, {first}] differ by {apart.max():.3g}, "
            f"{apart.max() / largest:.2g} of the largest entry, and rounding leaves {_ASYMMETRY:g} at most{more}."
        )
    mean, skew = 0.5 * (matrix + matrix.T), 0.5 * (matrix - matrix.T)
    return mean if is_sparse(mean) else np.where(np.abs(mean) <= _OF_SKEW * np.abs(skew), 0.0, mean), skew


def _with_mass(masses: Matrix, held: Matrix) -> int:
    """How many coordinates have a mass: the others must be held."""
    some, stiff = (np.asarray(abs(matrix).sum(axis=0)).ravel() > 0.0 for matrix in (masses, held))
    if loose := np.flatnonzero(~some & ~stiff).tolist():
        which = listed([str(place) for place in loose])
        raise ValueError(f"mass and stiffness must not both be 0 in a row, as in {which} (from 0): leave these out.")
    own = masses.diagonal()[some]
    if not own.size:
        raise ValueError("mass must not be 0 everywhere.")
    if not own.min() > 0.0:
        raise ValueError(f"mass must be positive definite: of one coordinate the mass is {own.min():.3g} kg.")
    scaled = (masses[:, some][some] / np.sqrt(own)).T / np.sqrt(own)
    if is_sparse(scaled):
        try:
            least = -1.0 if factor(scaled.tocsc())[1] else 1.0
        except ValueError:
            least = 0.0
    else:
        least = float(np.linalg.eigvalsh(scaled)[0])
    if least < -_ROUNDING * len(own):
        raise ValueError("mass must be positive definite: the mass of one motion is negative.")
    if not least > _ROUNDING:
        raise ValueError("mass must not be singular: each motion must have a mass, but that of one is 0.")
    return int(own.size)


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
