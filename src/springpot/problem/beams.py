"""A uniform beam in bending by its modes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.machine.arguments import check_whole, finite_number, positive_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import meant, shown
from springpot.problem.modes import check_points
from springpot.problem.system import System

BeamKind = Literal["cantilever", "simply supported"]

MOST_MODES = 8  # as many masses as the simulation holds
_ROUNDING = 1e-12


def beam(
    length: float,
    bending_stiffness: float,
    mass: float,
    points: Mapping[str, float],
    *,
    kind: BeamKind = "cantilever",
    modes: int = 3,
    damping_ratios: ArrayLike = 0.0,
) -> System:
    """The slowest modes of a uniform Euler-Bernoulli beam, with points on which parts and excitations may act.

    Parameters
    ----------
    length : float
        L in m.
    bending_stiffness : float
        E I in N m^2.
    mass : float
        Of the whole beam, in kg.
    points : dict
        The places of points by their names, in m from the clamped end, or from one of the supports.
    kind : {"cantilever", "simply supported"}
    modes : int
        How many, from 1 to 8.
    damping_ratios : float or sequence of float
        Of each mode, or of all; over the critical damping.

    Returns
    -------
    System
        Of masses ``mode_1``, ``mode_2`` ..., each with its spring and dashpot, and of the points.  The displacement of
        a mode is that of the tip, or of the place where a supported beam moves most.  The ground moves the clamp or
        both supports.  Add other parts as ``System(*sp.beam(...).parts, WhiteNoise(0.1, on="ground"))``.

    Raises
    ------
    TypeError, ValueError
        If a number or a kind is not as said, or a point lies where the beam never moves.

    Notes
    -----
    w_n = (beta_n L)^2 sqrt(E I / (m L^3)) with the whole mass m; cos(beta L) cosh(beta L) = -1 of a cantilever, and
    beta L = n pi of a supported beam.  Shear and rotary inertia are neglected, so each half wave of a mode must be long
    against the depth of the beam.

    Examples
    --------
    >>> strip = beam(0.3, 0.6, 0.05, {"tip": 0.3, "middle": 0.15}, modes=3, damping_ratios=0.01)
    >>> strip.points
    ('mode_1', 'mode_2', 'mode_3', 'tip', 'middle')
    """
    length, stiffness, whole = (
        positive_number(value, name)
        for name, value in (("length", length), ("bending_stiffness", bending_stiffness), ("mass", mass))
    )
    if not isinstance(kind, str) or kind not in get_args(BeamKind):
        near = meant(kind, get_args(BeamKind)) or "."
        raise ValueError(f"kind must be 'cantilever' or 'simply supported', not {shown(kind)}{near}")
    check_whole(modes, "modes", 1, MOST_MODES)
    if not isinstance(points, Mapping) or not points:
        raise TypeError(f"points must be places by name, as {{'tip': {length:g}}}, not {shown(points)}.")
    check_points(points, "points")
    roots, share, moved, shape = (_cantilever if kind == "cantilever" else _supported)(np.arange(1, modes + 1))
    shapes = {}
    for point, place in points.items():
        where = finite_number(place, f"place of {point}", low=0.0, high=length, open_low=True) / length
        row = shape(where)
        if not np.any(np.abs(row) > _ROUNDING):
            raise ValueError(f"place of {point} must be where the beam moves, not {place:g} m.")
        shapes[point] = np.where(np.abs(row) > _ROUNDING, row, 0.0)
    return System.from_modes(
        roots**2 * np.sqrt(stiffness / (whole * length**3)), share * whole, shapes, damping_ratios, moved
    )


Solved = tuple[Floats, float, Floats, Callable[[float], Floats]]
"""beta L; the mass of each mode over that of the beam; how each moves with the ground; and its shape at a place."""


def _supported(n: NDArray[np.int64]) -> Solved:
    roots: Floats = np.asarray(np.pi * n, float)
    return roots, 0.5, np.where(n % 2 == 1, 4.0 / roots, 0.0), lambda place: np.asarray(np.sin(roots * place))


def _cantilever(n: NDArray[np.int64]) -> Solved:
    roots: Floats = np.asarray(np.pi * (n - 0.5), float)
    for _ in range(20):  # Newton's method for cos b + 1 / cosh b = 0
        light = 1.0 / np.cosh(roots)
        roots = np.asarray(roots + (np.cos(roots) + light) / (np.sin(roots) + light * np.tanh(roots)))
    # 1 - s of s = (cosh b + cos b) / (sinh b + sin b), without the difference of large numbers
    left = (np.sin(roots) - np.cos(roots) - np.exp(-roots)) / (np.sinh(roots) + np.sin(roots))
    signs = np.where(n % 2 == 1, 0.5, -0.5)

    def shape(place: float) -> Floats:
        b = roots * place
        growing = 0.5 * left * np.exp(b) + (1.0 - 0.5 * left) * np.exp(-b)
        return np.asarray(signs * (growing - np.cos(b) + (1.0 - left) * np.sin(b)))

    return roots, 0.25, np.asarray(8.0 * signs * (1.0 - left) / roots), shape
