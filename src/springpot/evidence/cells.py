"""The dimensionless numbers of the systems on the validity map: a hardening spring, one springpot, walls and noise.

The unit of time is 1 / Omega and that of length sqrt(q / Omega^3), where Omega^2 is the linear stiffness over the mass
and q the intensity of the force per unit mass.  Of colored noise q is 2 pi times the spectral density at Omega.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    Barrier,
    ColoredNoise,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    WhiteNoise,
)
from springpot.problem.parts.walls import slow_restitution
from springpot.problem.system import System
from springpot.theory.coverage import DAMPERS, SPRINGS, Coverage


class PaperCell(NamedTuple):
    """One point of the map of the paper's problem, in the same units."""

    order: float
    c: float
    restitution: float
    position: float


class Cell(NamedTuple):
    """One point of the map.

    Attributes
    ----------
    walls : int
        0, 1 or 2; two walls are on both sides of the equilibrium.
    position : float
        With one wall its place (positive for a preload) in sqrt(q / Omega^3).  With two the distance of the nearer one
        from the equilibrium over the root mean square of x that averaging gives without walls and without hardening,
        sqrt(q / (2 C Omega^(alpha+1) sin(alpha pi/2))).  0 without walls.
    apart : float
        How much farther from the equilibrium the other one of two walls is, in the same unit; otherwise 0.
    restitution : float
        1 without walls.  Of two walls the mean, weighed by exp(-(distance / root mean square)^2 / 2), which is how
        often they are reached without each other; of one wall that is much nearer it is nearly that one's.
    color : float
        Correlation time times Omega; 0 for white noise.
    hardening : float
        kappa q / Omega^5, for a spring force kappa x^3 per unit mass.
    order, c : float
        alpha and C Omega^(alpha-2).
    """

    walls: int
    position: float
    apart: float
    restitution: float
    color: float
    hardening: float
    order: float
    c: float


def _free_spread(order: float, c: float) -> float:
    """The unit of distance of two walls."""
    return 1.0 / math.sqrt(2.0 * c * math.sin(order * math.pi / 2.0))


def system_of(cell: Cell | PaperCell) -> System:
    """The system of a cell, with Omega = q = 1.

    Examples
    --------
    >>> cell = Cell(2, 1.5, 0.5, 0.8, 0.0, 1.0, 0.5, 0.1)
    >>> [round(number, 9) for number in cell_of(system_of(cell))]
    [2, 1.5, 0.5, 0.8, 0.0, 1.0, 0.5, 0.1]
    """
    if isinstance(cell, PaperCell):
        cell = Cell(1, cell.position, 0.0, cell.restitution, 0.0, 0.0, cell.order, cell.c)
    parts: list[object] = [Spring(1.0), Springpot(cell.order, cell.c)]
    if cell.hardening > 0.0:
        parts.append(PolynomialSpring((0.0, 0.0, cell.hardening)))
    if cell.walls == 1:
        parts.append(Barrier(cell.position, cell.restitution, free_side="above"))
    elif cell.walls == 2:
        spread = _free_spread(cell.order, cell.c)
        near, far = cell.position * spread, (cell.position + cell.apart) * spread
        parts += [Barrier(-near, cell.restitution), Barrier(far, cell.restitution, free_side="below")]
    if cell.color > 0.0:
        parts.append(ColoredNoise((1.0 + cell.color**2) / (2.0 * cell.color), cell.color))
    else:
        parts.append(WhiteNoise(1.0))
    return System(*parts)


_REACH = (
    "The validity map of systems has a linear spring with a cubic one that hardens, one springpot or dashpot, a wall "
    "or two, one on each side of the equilibrium, and white or colored noise"
)
_COVERED = Coverage(
    _REACH, SPRINGS | DAMPERS | Springpot | Barrier | WhiteNoise | ColoredNoise, linear=PolynomialDashpot, nonlinear=""
)


def cell_of(system: System) -> Cell:
    """Where a system is on the map.

    Raises
    ------
    NotCoveredError
        If it has other parts; the sentence names the part.
    """
    unit = system.per_unit_mass
    _COVERED.check(unit)
    for name, wall in unit.walls.items():
        if wall.has_law:
            raise NotCoveredError(f"{_REACH}, not the restitution of {name}.")
    coefficients = (*unit.potential.coefficients, *[0.0] * 10)
    if not coefficients[1] > 0.0 or any(coefficients[n] != 0.0 for n in (0, 2, *range(4, 10))) or coefficients[3] < 0.0:
        raise NotCoveredError(f"{_REACH}; here the springs are others.")
    omega, kappa = math.sqrt(coefficients[1]), coefficients[3]
    order, coefficient = _dissipator(unit)
    intensity, color = _noise(unit, omega)
    walls, c = [*unit.walls.values()], coefficient * omega ** (order - 2.0)
    length = math.sqrt(intensity / omega**3)
    position, apart, restitution = 0.0, 0.0, 1.0
    if len(walls) == 1:
        position = walls[0].inwards * walls[0].position / length + 0.0
        restitution = slow_restitution(walls[0])  # a number
    elif len(walls) == 2:
        gaps = [-w.inwards * w.position / (length * _free_spread(order, c)) for w in walls]
        position, apart = min(gaps), abs(gaps[1] - gaps[0])
        if position < 0.0:
            raise NotCoveredError(f"{_REACH}; here the two walls are not on both sides of it.")
        reached = [math.exp(0.5 * (position**2 - gap**2)) for gap in gaps]
        lost = math.fsum(often * slow_restitution(wall) for often, wall in zip(reached, walls, strict=True))
        restitution = lost / math.fsum(reached)
        apart = 0.0 if apart < 1e-6 * position else apart
    return Cell(
        walls=len(walls),
        position=position,
        apart=apart,
        restitution=restitution,
        color=color * omega,
        hardening=kappa * intensity / omega**5,
        order=order,
        c=c,
    )


def _dissipator(unit: System) -> tuple[float, float]:
    """Order and coefficient of the one springpot or dashpot."""
    found = [(springpot.order, springpot.coefficient) for springpot in unit.springpots.values() if springpot.dissipates]
    if unit.damping > 0.0:
        found.append((1.0, unit.damping))
    if len({order for order, _ in found}) != 1:
        raise NotCoveredError(f"{_REACH}; here there is {'no' if not found else 'more than one'} springpot or dashpot.")
    return found[0][0], sum(coefficient for _, coefficient in found)


def _noise(unit: System, omega: float) -> tuple[float, float]:
    """Intensity at Omega and correlation time of the one noise."""
    white = sum(noise.white_intensity for noise in unit.excitations.values())
    colored = [noise for noise in unit.excitations.values() if noise.noise == "filtered"]
    if len(colored) > 1 or (colored and white > 0.0):
        raise NotCoveredError(f"{_REACH}; here there are several noises.")
    if colored:
        return 2.0 * math.pi * colored[0].density(omega), colored[0].correlated_for
    if not white > 0.0:
        raise NotCoveredError(f"{_REACH}; here there is no noise.")
    return white, 0.0
