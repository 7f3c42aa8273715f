"""Relaxation and creep of linear parts, from their modulus by the inverse Laplace transform."""

from __future__ import annotations

import numpy as np

from springpot.fitting.likelihood import Coordinates, GammaSquares, Table
from springpot.fitting.moduli import modulus_at, slopes_by_name
from springpot.fitting.part_data import MeasuredCreep, MeasuredRelaxation
from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import NotCoveredError, listed
from springpot.problem.free_numbers import free_numbers, restarted
from springpot.problem.parts import Dashpot, FractionalMaxwell, Maxwell, Spring, Springpot
from springpot.problem.system import System

_NODES = 32
_IDLE = 1e-9  # relative change of all data by which a number has an influence


def stepped(system: System, time: Floats, names: tuple[str, ...], creep: bool) -> tuple[Floats, Floats]:
    """The relaxation modulus of springs, dampers and memory, or their creep compliance.

    Parameters
    ----------
    system : System
    time : ndarray, shape (n,)
        Since the step, in s.
    names : tuple of str
        Of free numbers.
    creep : bool

    Returns
    -------
    found : ndarray, shape (n,)
    slopes : ndarray, shape (n, names)
        By the numbers.

    Raises
    ------
    NotCoveredError
        If a part is another one.

    Notes
    -----
    The modulus K(p) gives G(t) = L^-1[K(p) / p] and J(t) = L^-1[1 / (p K(p))].  Both have their singularities on the
    negative axis alone, so that the integral along a parabola around it converges like 2.85^-n with n nodes (J. A. C.
    Weideman and L. N. Trefethen, "Parabolic and hyperbolic contours for computing the Bromwich integral", Mathematics
    of Computation 76, 2007).

    Examples
    --------
    A springpot: G = C t^-order / Gamma(1 - order):

    >>> found, _ = stepped(System(Springpot(0.5, 2.0)), np.array([4.0]), (), creep=False)
    >>> float(found[0] * np.sqrt(np.pi)).__round__(12)
    1.0
    """
    for name, part in system.named():
        if {"stored", "damping", "inertia"}.isdisjoint(part.powers):
            continue
        if not isinstance(part, Spring | Dashpot | Springpot | Maxwell | FractionalMaxwell):
            raise NotCoveredError(f"relaxation and creep cover springs, dashpots, springpots and arms, not {name}.")
    angle = np.pi * (2.0 * np.arange(_NODES // 2) + 1.0) / _NODES
    place = _NODES * (0.1309 - 0.1194 * angle**2 + 0.25j * angle)
    weight = 2.0 / _NODES * np.exp(place) * _NODES * (0.25 + 0.2388j * angle)  # of the upper half; the real part counts
    p = np.asarray((place / time[:, None]).ravel(), complex)
    modulus, slopes = modulus_at(system, p)
    matrix = slopes_by_name(slopes, names, p.size)

    def integral(transform: Complexes) -> Floats:
        shaped = transform.reshape(time.size, angle.size, -1)
        return np.asarray((weight[:, None] * shaped).sum(axis=1).real / time[:, None])

    if creep:
        return integral(1.0 / (p * modulus))[:, 0], integral(-matrix / (p * modulus**2)[:, None])
    return integral(modulus / p)[:, 0], integral(matrix / p[:, None])


class SteppedLikelihood(GammaSquares):
    """Relaxation moduli or creep compliances that scatter with a variance proportional to their square.

    Parameters
    ----------
    system : System
        With free numbers.
    data : MeasuredRelaxation or MeasuredCreep

    Raises
    ------
    ValueError
        If a free number does not enter.
    """

    def __init__(self, system: System, data: MeasuredRelaxation | MeasuredCreep) -> None:
        self.system, self.at = system, data.time
        self.coordinates = Coordinates(tuple(free_numbers(system).values()))
        self.size = data.size
        self.known = data.relative_error is not None
        self.certainty = 1.0 / (data.relative_error or 1.0)
        self.creep = isinstance(data, MeasuredCreep)
        self.values = data.compliance if isinstance(data, MeasuredCreep) else data.modulus
        self.group = np.full(data.size, "creep" if self.creep else "relaxation")
        own = self.coordinates
        expected, slopes = self._stepped(own.outer(own.start))
        moves = np.abs(slopes * own.outer(own.start) / expected[:, None]).max(axis=0, initial=0.0)
        if idle := [name for name, move in zip(own.names, moves.tolist(), strict=True) if move < _IDLE]:
            raise ValueError(f"{listed(idle)} must not be free: {self.group[0]} does not depend on it.")

    def _stepped(self, theta: Floats) -> tuple[Floats, Floats]:
        system = restarted(self.system, self.coordinates.named(theta))
        found, slopes = stepped(system, self.at, self.coordinates.names, self.creep)
        if not (found > 0.0).all():
            raise ValueError(f"model must have a positive {self.group[0]} at every time.")
        return found, slopes

    def expected(self, theta: Floats) -> Floats:
        """The moduli or compliances."""
        return self._stepped(theta)[0]

    def sensitivity(self, theta: Floats) -> Floats:
        """Their relative change, in its standard deviations."""
        found, slopes = self._stepped(theta)
        return self.certainty * slopes / found[:, None]

    def table(self, theta: Floats) -> Table:
        """Data against time."""
        residual = self.pearson(theta) / self.scatter(theta, len(self.coordinates.free)) ** 0.5
        return Table("time_s", "s", self.at, self.group, self.values, self.expected(theta), residual)
