"""Where a system rests: in the equilibrium of springs and constant forces, or as near to it as walls let it.

One mass is measured from the rest of its linear springs, so that constant forces act in the exact flight between kicks:
a linear spring under a constant force is the same spring with another rest.  Seen from there the force is gone: a
weight above a floor and a preload are one problem, with one step and the same bits where the shift has no rounding.
Springpots and other memory follow changes of x only, which a shift leaves as they are.
"""

from __future__ import annotations

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import listed
from springpot.problem.system import System

_ROUNDS = 60
_HELD = 1e-14  # least eigenvalue of the stiffness over the largest


def nearest_to_rest(system: System) -> Floats:
    """The least change from the equilibrium that puts every elongation before its wall.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Constant, Mass, Spring
    >>> ends = ("ground", "a"), ("a", "b")
    >>> pair = System(
    ...     Mass(1.0, at="a"), Mass(1.0, at="b"), *(Spring(1.0, between=each) for each in ends), Constant(2.0, on="b"),
    ...     Barrier(3.5, free_side="below", between=("ground", "b")),
    ... )
    >>> nearest_to_rest(pair).round(6).tolist()
    [2.0, 3.5]
    """
    return within_walls(system, equilibrium(system))


def equilibrium(system: System) -> Floats:
    """Where springs and constant forces balance, by Newton's method from 0; 0 where that finds no place."""
    coordinates, parts = system.coordinates, dict(system.named())
    force = system.constant_force
    x = np.zeros(len(force))
    if not force.any():
        return x
    for _ in range(_ROUNDS):
        left, stiffness = np.asarray(-force), np.zeros((x.size, x.size))
        for name, row in coordinates.elongations.items():
            springs, u = parts[name].force_coefficients() or (0.0,), float(row @ x)
            left = left + row * np.polynomial.polynomial.polyval(u, springs)
            slope = float(np.polynomial.polynomial.polyval(u, np.polynomial.polynomial.polyder(springs)))
            stiffness += slope * np.outer(row, row)
        values = np.linalg.eigvalsh(stiffness)
        if not values[0] > _HELD * values[-1]:
            return np.zeros(x.size)
        change = np.linalg.solve(stiffness, left)
        x = x - change
        if np.abs(change).max() <= 1e-12 * np.abs(x).max():
            return x
    return np.zeros(x.size)


def within_walls(system: System, places: Floats) -> Floats:
    """The least change of the places that puts every elongation before its wall.

    Raises
    ------
    ValueError
        If the walls leave no room.
    """
    inward, least = walls_at(system, places)
    if not (least > 0.0).any():
        return places
    behind = least > 0.0
    of_one = np.where(behind, least, 0.0) / (inward**2).sum(axis=1)  # of the only wall with something behind it
    enough = behind.sum() == 1 and (inward @ (inward.T @ of_one) >= least)[~behind].all()
    forces = of_one if enough else least_forces(inward, least)
    if forces is None:
        raise ValueError(f"the walls must leave room: {listed([*system.walls])} cannot all be kept.")
    return np.asarray(places + inward.T @ forces)


def walls_at(system: System, x: Floats) -> tuple[Floats, Floats]:
    """The rows of rigid walls, turned inwards, and how far some displacements are behind each."""
    rows = [part.inwards * system.coordinates.elongations[name] for name, part in system.walls.items()]
    inward = np.array(rows).reshape(-1, len(x))
    return inward, np.array([part.inwards * part.position for part in system.walls.values()]) - inward @ x


def least_forces(inward: Floats, least: Floats) -> Floats | None:
    """The forces of walls that keep ``inward @ x`` at ``least`` or above with the smallest x; None if nothing does.

    Least distance programming (Lawson and Hanson, "Solving least squares problems", chapter 23); x is then
    ``inward.T @ forces``.
    """
    from scipy import optimize  # slow to import

    unit = float(np.abs(least).max())
    dual, _ = optimize.nnls(np.vstack([inward.T, least / unit]), np.append(np.zeros(inward.shape[1]), 1.0))
    left = float(least / unit @ dual) - 1.0
    return np.asarray(-unit * dual / left) if abs(left) > 1e-9 else None


def origin_of(system: System) -> float:
    """The rest of the springs under the constant forces, in m; 0 where these stay beside the flight.

    They do without a linear spring, and with parts of which a shift would make another law.

    Examples
    --------
    >>> from springpot.problem.parts import Constant, PolynomialSpring, Spring
    >>> springs = Spring(4.0), PolynomialSpring((4.0, 0.0, 1.0))
    >>> [origin_of(System(spring, Constant(-9.0))) for spring in springs]
    [-2.25, 0.0]
    """
    if not system.constants or any(part.is_placed for part in system.parts):
        return 0.0
    forces = [part.force_coefficients() for _, part in system.named()]
    pulled, stiffness = (sum(force[n] for force in forces if n < len(force)) for n in (0, 1))
    linear = not any(any(force[2:]) for force in forces)
    return -pulled / stiffness + 0.0 if linear and stiffness > 0.0 else 0.0


def seen_from(system: System, origin: float) -> System:
    """The same motion as a function of x - origin, which is that of `origin_of`: without the constant forces.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Constant, Spring
    >>> seen_from(System(Spring(4.0), weight=Constant(-9.0), floor=Barrier(0.0, 0.5)), -2.25)
    System(Spring(stiffness=4.0), floor=Barrier(position=2.25, restitution=0.5, free_side='above'))
    """
    if origin == 0.0:
        return system
    return System(**{name: part.seen_from(origin) for name, part in system.named() if name not in system.constants})
