"""Interpolation in the atlas.

The moments depend on four dimensionless numbers: the order, c = C Omega^(alpha-2), the restitution and
b sqrt(Omega^3 / q).  The atlas (``atlas.npz``, written by ``make atlas`` from the study files in the folder ``atlas``)
has three tables of the moments at Omega = q = 1: an elastic wall and one of restitution 0.8, both over order, c and
position, and any restitution with the wall at the equilibrium, over order, c and restitution.  Each is on an
equidistant grid in coordinates along which the moments vary smoothly; cubic polynomials through the four nearest nodes
of each axis interpolate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.catalogue import unit_of
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system
from springpot.theory.result import MOMENTS, OF_A_WALL, Moments, Result

ATLAS_FILE = Path(__file__).with_name("atlas.npz")
ORDERS, COEFFICIENTS, RESTITUTIONS, PLACES = (0.05, 1.0), (0.01, 10.0), (0.3, 1.0), (-2.0, 2.0)
LOSSY = 0.8
EDGE = 1e-9  # relative margin of the ranges for rounding errors
NORMAL = 1.959964
COLLAPSE, BEYOND = 0.163, 1.003
SMALLEST, RATIO = 1e-5, 1.05  # of the standard errors that are kept


@dataclass(frozen=True)
class AtlasAnswer(Result):
    """Result of the atlas.

    Attributes
    ----------
    errors : dict
        Half-width of the 95 % interval of each moment, in its unit: sampling error of the Monte Carlo, and
        interpolation.

    Notes
    -----
    The moments are attributes, as in every result of the theory (`springpot.theory.Result`); `to_dict` has the errors
    under ``_error``.
    """

    errors: dict[str, float]

    def _more(self) -> dict[str, object]:
        return {f"{name}_error": None if math.isnan(error) else error for name, error in self.errors.items()}


@dataclass(frozen=True, eq=False)
class Table:
    """One of the atlas's tables.

    Attributes
    ----------
    starts, steps : tuple of float
        Of the even grid along log(order), log(c), and place or `crowding` of the restitution.
    values : ndarray, shape (n, n, n, 7)
        Logarithms of the moments; of the mean displacement its ratio to the root mean square displacement.
    errors : ndarray, shape (n, n, n, 7)
        Standard errors of the same.
    """

    starts: tuple[float, ...]
    steps: tuple[float, ...]
    values: npt.NDArray[np.float32]
    errors: npt.NDArray[np.float32]

    def at(self, *place: float) -> tuple[Floats, npt.NDArray[np.float32]]:
        """Interpolated values, and the largest standard error of the nodes used."""
        (i, first), (j, second), (k, third) = (
            weights((coordinate - start) / step, size)
            for coordinate, start, step, size in zip(place, self.starts, self.steps, self.values.shape, strict=False)
        )
        block = self.values[i : i + 4, j : j + 4, k : k + 4]
        along = second @ (first @ block.reshape(4, -1)).reshape(4, -1)
        errors = self.errors[i : i + 4, j : j + 4, k : k + 4].reshape(-1, len(MOMENTS)).max(axis=0)
        return np.asarray(third @ along.reshape(4, -1)), errors

    def moments(self, order: float, coefficient: float, third: float) -> tuple[dict[str, float], dict[str, float]]:
        """Moments and their standard errors at Omega = q = 1; ``third`` is the third coordinate of the table."""
        logs, spreads = self.at(math.log(order), math.log(coefficient), third)
        numbers = dict(zip(MOMENTS, np.exp(logs).tolist(), strict=True))
        relative = dict(zip(MOMENTS, spreads.tolist(), strict=True))
        errors = {name: relative[name] * numbers[name] for name in MOMENTS}
        # the mean is stored over the root mean square, whose error is added
        size = math.sqrt(numbers["x_mean_square"])
        numbers["x_mean"] = float(logs[MOMENTS.index("x_mean")]) * size
        errors["x_mean"] = math.hypot(relative["x_mean"] * size, 0.5 * relative["x_mean_square"] * numbers["x_mean"])
        return numbers, errors


def weights(position: float, size: int) -> tuple[int, Floats]:
    """First of four nodes, and Lagrange weights of the cubic through them, at a position in units of nodes.

    Examples
    --------
    >>> first, share = weights(2.5, 10)
    >>> first, share.tolist()
    (1, [-0.0625, 0.5625, 0.5625, -0.0625])
    """
    first = min(max(math.floor(position) - 1, 0), size - 4)
    t = position - first
    a, b, c = t - 1.0, t - 2.0, t - 3.0
    return first, np.array([-a * b * c / 6.0, 0.5 * t * b * c, -0.5 * t * a * c, t * a * b / 6.0])


def crowding(restitution: Any, beyond: float = BEYOND) -> Any:
    """Coordinate of a restitution: finest near 1, where small losses matter with light damping (finer for ``beyond``
    nearer to 1), and at low values, where slow impacts are frequent (infinitely many at 0.163).

    Examples
    --------
    >>> float(crowding(1.0).round(3)), float(restitution_at(crowding(0.5)).round(12))
    (5.631, 0.5)
    """
    r = np.asarray(restitution)
    return np.log((r - COLLAPSE) / (beyond - r))


def restitution_at(coordinate: Any) -> Any:
    """The inverse of `crowding`."""
    odds = np.exp(np.asarray(coordinate))
    return np.minimum((COLLAPSE + BEYOND * odds) / (1.0 + odds), 1.0)


def error_codes(errors: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Codes of standard errors: steps of 5 %, rounded up.

    Examples
    --------
    >>> error_codes([1e-5, 1e-3])
    array([ 0, 95], dtype=uint8)
    """
    steps = np.ceil(np.log(np.maximum(np.asarray(errors, np.float64), SMALLEST) / SMALLEST) / math.log(RATIO))
    return np.asarray(np.minimum(steps, 255), np.uint8)


@cache
def read_table(name: str, path: Path = ATLAS_FILE) -> Table:
    """One of the tables ``elastic``, ``lossy`` and ``losses``."""
    with np.load(path) as file:
        grid = file[f"{name}_grid"]
        return Table(
            tuple(grid[0].tolist()),
            tuple(grid[1].tolist()),
            file[f"{name}_values"],
            np.float32(SMALLEST) * np.float32(RATIO) ** file[f"{name}_errors"],
        )


def atlas(system: System) -> AtlasAnswer:
    """Stationary moments from the atlas, in microseconds (the first time it is read from disk).

    Parameters
    ----------
    system : System
        Order in [0.05, 1] and C Omega^(alpha-2) in [0.01, 10].  A wall is at the equilibrium with a restitution from
        0.3 to 1, or within 2 sqrt(q / Omega^3) of it with a restitution of 1 or 0.8.  It must be the paper's problem: a
        linear spring, one springpot or dashpot, one rigid wall and white noise.

    Returns
    -------
    AtlasAnswer
        Moments with half-widths of their 95 % intervals.

    Raises
    ------
    TypeError
        If it is not a System.
    springpot.theory.NotCoveredError
        Outside the range of the atlas; of a system with other parts the sentence names the part.

    Examples
    --------
    >>> import springpot as sp
    >>> from springpot import Springpot
    >>> moments = atlas(sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0)))
    >>> abs(moments.amplitude_mean_square - 1.0) < 2.0 * moments.errors["amplitude_mean_square"]
    True
    """
    system = checked_system(system)
    paper = Dimensionless.of(system)
    name, third = table_for(paper)
    numbers, own = read_table(name).moments(paper.springpot.order, paper.dimensionless_coefficient, third)
    scales = _scales(paper)
    values = {name: numbers[name] * scales[name] for name in MOMENTS}
    errors = {name: NORMAL * own[name] * abs(scales[name]) for name in MOMENTS}
    of_wall = {f"{wall}_{what}": values[what] for wall in system.stops for what in OF_A_WALL if what in values}
    return AtlasAnswer(
        method="atlas",
        system=system,
        stationary=Moments(**values, of_parts=of_wall),
        assumptions=("Stationary response; interpolated between Monte Carlo of the same problem.",),
        warnings=(),
        errors=errors,
    )


def table_for(paper: Dimensionless) -> tuple[str, float]:
    """Name of the table, and the third coordinate in it."""
    _check("order", paper.springpot.order, ORDERS)
    if paper.barrier is None:
        raise NotCoveredError(
            "The atlas covers oscillators with a wall; without one theory.exact gives the exact result."
        )
    if paper.excitation.intensity == 0.0:
        raise NotCoveredError("The atlas covers positive intensities: without noise the only stationary state is rest.")
    _check("C Omega^(alpha-2)", paper.dimensionless_coefficient, COEFFICIENTS)
    place, restitution = paper.dimensionless_position, paper.restitution
    if restitution == 1.0 or (restitution == LOSSY and place != 0.0):
        _check("the wall's position in units of sqrt(q / Omega^3)", place, PLACES)
        return ("elastic" if restitution == 1.0 else "lossy"), place
    if place != 0.0:
        raise NotCoveredError(
            f"The atlas covers a wall away from the equilibrium with a restitution of 1 or {LOSSY} only, not "
            f"{restitution:g}: use theory.envelope or simulate."
        )
    _check("restitution", restitution, RESTITUTIONS)
    return "losses", float(crowding(restitution))


def _check(what: str, value: float, interval: tuple[float, float]) -> None:
    low, high = interval
    slack = EDGE * max(abs(low), abs(high))
    if not low - slack <= value <= high + slack:
        raise NotCoveredError(
            f"The atlas covers {what} from {low:g} to {high:g}, not {value:g}: use theory or simulate."
        )


def _scales(paper: Dimensionless) -> dict[str, float]:
    """Factors from the units of the atlas to those of the problem; with a wall above the mean changes its sign."""
    length, speed = paper.length_scale, paper.speed_scale
    units = {"m": paper.direction * length, "m2": length**2, "m s-1": speed, "m2 s-2": speed**2,
             "s-1": paper.natural_frequency}  # fmt: skip
    return {name: units[unit_of(name)] for name in MOMENTS}
