"""Natural frequencies and mode shapes of the masses on their linear springs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.problem.parts import Springpot
from springpot.problem.parts.registration import Element
from springpot.problem.system import System, checked_system

__all__ = ["Modes", "modes"]

FloatArray = NDArray[np.float64]


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
    frequencies: FloatArray
    shapes: FloatArray
    participations: FloatArray

    @property
    def effective_masses(self) -> FloatArray:
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
    parts = [(name, part) for name, part in system.named() if isinstance(part, Element)]
    stiffness = at.sum_of({name: part.linear_stiffness + _of_order_0(part) for name, part in parts})
    root = np.linalg.inv(np.linalg.cholesky(at.mass))
    squares, ways = np.linalg.eigh(root @ stiffness @ root.T)
    squares[np.abs(squares) < 1e-14 * np.abs(squares).max()] = 0.0
    shapes = root.T @ ways
    participations = -shapes.T @ at.push("ground")
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(axis=0)[None, :], axis=0)[0]
    fed = np.abs(participations) > 1e-9 * np.linalg.norm(participations)
    signs = np.where(np.where(fed, participations, largest) < 0.0, -1.0, 1.0)
    with np.errstate(invalid="ignore"):
        frequencies = np.sqrt(squares)
    return Modes(at.points, frequencies, at.rows @ shapes * signs, participations * signs)


def _of_order_0(part: Element) -> float:
    """The stiffness of a springpot that is a spring."""
    return part.coefficient if isinstance(part, Springpot) and part.order == 0.0 else 0.0
