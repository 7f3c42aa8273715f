"""Natural frequencies and mode shapes of the masses on their linear springs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.system import System, checked_system

_EQUAL = 1e-9  # frequencies that are one, and what a row sees of a mode that does not move it


@dataclass(frozen=True, eq=False)
class Modes:
    """The modes, from the slowest to the fastest.

    Parameters
    ----------
    points : tuple of str
        The names of the masses, and of other points.
    frequencies : ndarray, shape (modes,)
        In rad/s; 0 of motion that no spring holds, NaN of motion that springs push away.
    shapes : ndarray, shape (points, modes)
        A column for each mode; on the masses Phi^T M Phi = 1.
    participations : ndarray, shape (modes,)
        Phi^T M 1, in kg^(1/2): what an acceleration of the ground feeds to each.  Of masses that have participations
        these are in place of the ones.
    """

    points: tuple[str, ...]
    frequencies: Floats
    shapes: Floats
    participations: Floats

    @property
    def effective_masses(self) -> Floats:
        """The squares of the participations, in kg: they add up to the mass of the whole."""
        return np.asarray(self.participations**2)


def modes(system: System) -> Modes:
    """The modes of small motion on the linear springs, without what has memory.

    Parameters
    ----------
    system : System

    Returns
    -------
    Modes
        Each shape has the sign with which the ground's acceleration feeds it, or, where it feeds nothing, that of its
        largest share.

    Raises
    ------
    TypeError
        If it is not a System.

    Examples
    --------
    >>> import springpot as sp
    >>> isolated = sp.System(
    ...     sp.Mass(0.2, at="base"), sp.Mass(1.0, at="storey"),
    ...     sp.Spring(0.192, between=("ground", "base")), sp.Spring(4.0, between=("base", "storey")),
    ... )
    >>> found = modes(isolated)
    >>> found.frequencies.round(6).tolist(), float(found.effective_masses.sum().round(12))
    ([0.393454, 4.980481], 1.2)
    """
    at = checked_system(system).coordinates
    squares, shapes = free_motion(at.mass, system.stiffness_matrix)
    squares[np.abs(squares) < 1e-14 * np.abs(squares).max()] = 0.0
    participations = -shapes.T @ at.push("ground")
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(axis=0)[None, :], axis=0)[0]
    fed = np.abs(participations) > 1e-9 * np.linalg.norm(participations)
    signs = np.where(np.where(fed, participations, largest) < 0.0, -1.0, 1.0)
    with np.errstate(invalid="ignore"):
        frequencies = np.sqrt(squares)
    return Modes(at.points, frequencies, at.rows @ shapes * signs, participations * signs)


def free_motion(mass: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """The squares of the frequencies, rising, and the shapes, in columns of unit modal mass.

    Examples
    --------
    >>> squares, shapes = free_motion(np.diag([1.0, 4.0]), np.diag([9.0, 4.0]))
    >>> squares.tolist(), np.abs(shapes).tolist()
    ([1.0, 9.0], [[0.0, 1.0], [0.5, 0.0]])
    """
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares, ways = np.linalg.eigh(root @ stiffness @ root.T)
    return squares, root.T @ ways


def unseen_mode(squares: Floats, shapes: Floats, rows: Sequence[Floats]) -> float | None:
    """The frequency of a mode of `free_motion` that stretches none of some rows; None if there is none.

    Examples
    --------
    >>> motion = free_motion(np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> unseen_mode(*motion, [np.array([-1.0, 1.0])]), unseen_mode(*motion, [np.array([1.0, 0.0])])
    (1.0, None)
    """
    seen = np.array(rows).reshape(len(rows), -1) @ shapes
    seen = seen / np.linalg.norm(seen, axis=1)[:, None]
    frequencies = np.sqrt(np.maximum(squares, 0.0))
    start = 0
    for stop in range(1, len(squares) + 1):
        if stop == len(squares) or frequencies[stop] - frequencies[start] > _EQUAL * frequencies[stop]:
            alike = seen[:, start:stop]  # of equal frequency: any sum of them is a mode
            if np.linalg.matrix_rank(alike, tol=_EQUAL) < stop - start:
                return float(frequencies[start])
            start = stop
    return None
