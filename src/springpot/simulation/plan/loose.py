"""Masses that no spring holds: only walls do, as the ball of an impact damper, or springpots alone.

From rest a mass between walls lies still until its neighbour reaches it, which may take very long, and the energy that
it takes from then on changes that of all others.  A start with the mass on its way from wall to wall is near the
stationary state at once: a fast mass strikes often and so soon loses what it has too much of, a slow one waits.

With the impulse response h of springpots, a power t^(alpha - 1) / (C Gamma(alpha)) of late times, a path from an empty
memory lacks at time t the part q times the integral of h^2 from t on of its mean square, a power t^(2 alpha - 1): that
is finite below order 1/2, and nearly all of it at orders near that.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.problem.parts import Springpot
from springpot.problem.parts.springpots import resonance, springpot_in
from springpot.problem.potential import Potential
from springpot.problem.system import System

TRIED, LEAST_KEPT = 4096, 0.01  # draws, and the share that must be kept
FROM_REST, HOT = 28.0, 9.0  # mean times between the neighbour's visits until 1 % is left of either start
LASTS = math.log(100.0)
_NEVER = 1e7  # radians of the slowest motion between visits: no run has one
_TOUCHES = 1e-9  # least share of a direction in an elongation
_NOTHING = 1e-200  # of a stiffness, from which the search for one begins


@dataclass(frozen=True, eq=False)
class Loose:
    """Directions in which only walls hold masses, and the start in which these are on their way.

    Attributes
    ----------
    points : tuple of str
        The masses.
    visits : float
        Mean time in s between two visits of the neighbour at the walls, by Rice's rate in its motion without them.
    rest : ndarray, shape (coordinates,)
    places, speeds : ndarray, shape (coordinates, modes)
        Of the held masses, by their linear law, per normal.
    directions : ndarray, shape (coordinates, loose)
    own_speeds : ndarray, shape (loose,)
        Standard deviations along them.
    inward, least : ndarray
        Rows of all walls, turned inwards, and their places.
    """

    points: tuple[str, ...]
    visits: float
    rest: Floats
    places: Floats
    speeds: Floats
    directions: Floats
    own_speeds: Floats
    inward: Floats
    least: Floats

    def waiting_time(self, start: str) -> float:
        """In which what a start does falls by a factor of e, in s."""
        return (FROM_REST if start == "rest" else HOT) * self.visits / LASTS

    def drawn(self, normals: np.random.Generator, count: int) -> tuple[Floats, Floats]:
        """x and v of some paths."""
        x = drawn_until_kept(lambda: self._tried(normals, count))
        v = normals.standard_normal((count, self.speeds.shape[1])) @ self.speeds.T
        loose = normals.standard_normal((count, self.own_speeds.size)) * self.own_speeds
        return x, v + loose @ self.directions.T

    def kept(self) -> float:
        """The share of draws that all walls allow, about."""
        return float(self._tried(np.random.Generator(np.random.Philox(0)), TRIED)[1].mean())

    def _tried(self, normals: np.random.Generator, count: int) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Held masses by their linear law, the others anywhere between their walls; and whether all walls allow it."""
        x = self.rest + normals.standard_normal((count, self.places.shape[1])) @ self.places.T
        chance = normals.random((count, self.own_speeds.size))
        for direction, share in zip(self.directions.T, chance.T, strict=True):
            low, high = _room(self.inward, self.least, x, direction)
            x = x + (low + share * (high - low))[:, None] * direction
        return x, np.asarray((x @ self.inward.T >= self.least).all(axis=1))


def drawn_until_kept(tried: Callable[[], tuple[Floats, npt.NDArray[np.bool_]]]) -> Floats:
    """Rows, each of the first draw that is kept of it; a draw of all of them says which are."""
    x, kept = tried()
    while not kept.all():
        again, found = tried()
        found &= ~kept
        x[found], kept = again[found], kept | found
    return x


def _room(inward: Floats, least: Floats, x: Floats, direction: Floats) -> tuple[Floats, Floats]:
    """How far each of some displacements may go in a direction: from the nearest wall behind to that before."""
    along, left = inward @ direction, least - x @ inward.T
    ahead, behind = along < -_TOUCHES, along > _TOUCHES
    low = (left[:, behind] / along[behind]).max(axis=1, initial=-math.inf)
    return low, (left[:, ahead] / along[ahead]).min(axis=1, initial=math.inf)


def loose_masses(
    system: System, held: Callable[[], tuple[Floats, Floats]], frequency: float, rest: Floats
) -> Loose | None:
    """What only walls hold; None where nothing is loose, or where the start cannot be drawn so.

    Loose is what no spring, damper or force touches, so that it moves straight from wall to wall: what noise or a
    damper moves does not wait.

    Parameters
    ----------
    system : System
    held : callable
        Displacements and velocities of the modes that springs hold, per normal, of shape (coordinates, modes).
    frequency : float
        Of the slowest of them, in rad/s.
    rest : ndarray
        The places nearest to rest.
    """
    at = system.coordinates
    rows = at.elongations
    stops = [(part.inwards * rows[name], part.inwards * part.position) for name, part in system.stops.items()]
    others = [rows[name] for name, part in system.elements.items() if name not in system.stops]
    directions = _separate([*others, *at.forces.values()], len(rest)) if stops else np.zeros((len(rest), 0))
    if not directions.shape[1] or system.constant_force.any():
        return None
    inward, least = np.array([row for row, _ in stops]), np.array([place for _, place in stops])
    if ((np.abs(inward @ directions) > _TOUCHES).sum(axis=1) > 1).any():  # between two loose masses
        return None
    places, speeds = held()
    of_wall, spread = (np.sqrt(((inward @ each) ** 2).sum(axis=1)) for each in (speeds, places))
    visits, own_speeds = [], []
    for direction in directions.T:
        along = np.abs(inward @ direction)
        walls = (along > _TOUCHES) & (spread > 0.0)
        low, high = (float(end[0]) for end in _room(inward, least, rest[None, :], direction))
        if not walls.any() or not math.isfinite(high - low):
            return None
        gaps = 0.5 * (high - low) * along[walls]
        often = of_wall[walls] / (2.0 * math.pi * spread[walls]) * np.exp(-0.5 * (gaps / spread[walls]) ** 2)
        visits.append(float(often.sum()))
        own_speeds.append(float((of_wall[walls] / along[walls]).max()))
    if not min(visits) * _NEVER > frequency:
        return None
    if any(part.remembers for part in system.parts):  # a place that is drawn would be remembered
        places, speeds = np.zeros_like(places), math.sqrt(2.0) * speeds
    points = tuple(
        point for point, row in zip(at.points, at.rows, strict=True) if (np.abs(row @ directions) > _TOUCHES).any()
    )
    found = Loose(
        points, 1.0 / min(visits), rest, places, speeds, directions, np.array(own_speeds), inward, least
    )  # fmt: skip
    return found if found.kept() > LEAST_KEPT else None


def _separate(rows: list[Floats], size: int) -> Floats:
    """The directions that no row sees, so that each mass that is loose alone has its own."""
    _, values, turned = np.linalg.svd(np.array([np.zeros(size), *rows]))
    basis = turned[int((values > _TOUCHES * values.max()).sum()) :].copy()
    for n in range(len(basis)):
        column = int(np.abs(basis[n:]).max(axis=0).argmax())
        best = n + int(np.abs(basis[n:, column]).argmax())
        basis[[n, best]] = basis[[best, n]]
        basis[n] /= basis[n, column]
        others = np.arange(len(basis)) != n
        basis[others] -= basis[others, column][:, None] * basis[n]
    return np.asarray(np.where(np.abs(basis) > _TOUCHES, basis, 0.0).T)


def holding_alone(system: System) -> dict[str, Springpot]:
    """The springpots that may hold masses without a spring, by the names of their parts; none where something pushes.

    A wall or a constant force on one side pushes such a mass away without end.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier
    >>> [*holding_alone(System(Springpot(0.3, 1.0), Springpot(0.6, 1.0)))]
    ['springpot_1']
    >>> holding_alone(System(Springpot(0.3, 1.0), Barrier(-1.0)))
    {}
    """
    if system.stops or system.constant_force.any():
        return {}
    springpots = {name: springpot_in(part) for name, part in system.elements.items()}
    return {name: springpot for name, springpot in springpots.items() if springpot and 0.0 < springpot.order < 0.5}


def springpot_alone(unit: System) -> Springpot | None:
    """The springpot that holds a mass in the end, where springpots of an order below 1/2 alone do; else None.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, WhiteNoise
    >>> springpot_alone(System(Springpot(0.3, 1.0), Springpot(0.6, 1.0), WhiteNoise(1.0)))
    Springpot(order=0.3, coefficient=1.0)
    >>> springpot_alone(System(Springpot(0.3, 1.0), Spring(1.0))) is None
    True
    """
    alone = () if any(unit.potential.coefficients) else holding_alone(unit).values()
    return min(alone, key=lambda springpot: springpot.order, default=None)


def held_by_springpots(unit: System) -> Potential:
    """The potential of a mass that springpots alone hold, with the stiffness that they have for its fast motion."""
    frequency = resonance(_NOTHING, [part for part in unit.parts if part.remembers])
    return replace(unit.potential, coefficients=(0.0, frequency**2))
