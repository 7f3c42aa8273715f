"""Boltzmann's law, from which a thermal run starts.

Where all springs lie on one row it is the law of a number, on a grid of the potential.  Otherwise displacements are
drawn from the normal law of the linear springs, and kept with the probability that the other springs, contacts and
walls leave; what is kept has Boltzmann's law.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.problem.system import System
from springpot.simulation.plan.guess import BoltzmannLaw
from springpot.simulation.plan.loose import LEAST_KEPT, TRIED, drawn_until_kept

_HELD = 1e-10  # least eigenvalue of the stiffness over the largest


@dataclass(frozen=True, eq=False)
class FromPotential:
    """The law of one coordinate, whose places are measured from an origin."""

    law: BoltzmannLaw
    origin: float

    def drawn(self, normals: np.random.Generator, count: int) -> tuple[Floats, Floats]:
        """x and v of some paths."""
        x = self.origin + self.law.drawn(normals.random(count))
        return x[:, None], math.sqrt(self.law.temperature) * normals.standard_normal((count, 1))


@dataclass(frozen=True, eq=False)
class BoltzmannOfModes:
    """The law of several coordinates.

    Attributes
    ----------
    temperature : float
    root : ndarray, shape (coordinates, coordinates)
        Displacements of the linear springs' law per normal.
    speeds : ndarray, shape (coordinates, coordinates)
        Velocities per normal.
    others : tuple
        Rows, with what lies on them beside linear springs.
    """

    temperature: float
    root: Floats
    speeds: Floats
    others: tuple[tuple[Floats, Any], ...]

    def kept(self, x: Floats) -> Floats:
        """The probability with which each of some displacements is kept."""
        energy = np.zeros(len(x))
        for row, part in self.others:
            energy += part.energy_beside(x @ row)
        return np.exp(-energy / self.temperature)

    def drawn(self, normals: np.random.Generator, count: int) -> tuple[Floats, Floats]:
        """x and v of some paths."""

        def tried() -> tuple[Floats, npt.NDArray[np.bool_]]:
            x = normals.standard_normal((count, len(self.speeds))) @ self.root.T
            return x, normals.random(count) < self.kept(x)

        x = drawn_until_kept(tried)
        return x, normals.standard_normal(x.shape) @ self.speeds.T


def boltzmann_of_modes(system: System) -> BoltzmannOfModes | None:
    """The law; None where there is none, or it cannot be drawn so.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring, ThermalNoise
    >>> pair = System(
    ...     Mass(1.0, at="a"), Mass(0.5, at="b"), Spring(2.0, between=("ground", "a")), Spring(1.0, between=("a", "b")),
    ...     ThermalNoise(0.6),
    ... )
    >>> boltzmann_of_modes(pair).speeds.round(4).tolist()
    [[0.7746, 0.0], [0.0, 1.0954]]
    """
    driven = len(system.excitations) > 1
    lossy = any(stop.dissipates for stop in system.stops.values())
    if not system.thermal or driven or lossy:
        return None
    coordinates = system.coordinates
    elements = [(coordinates.elongations[name], part) for name, part in system.elements.items()]
    size = len(coordinates.names)
    values, shapes = np.linalg.eigh(system.stiffness_matrix)
    others = tuple((row, part) for row, part in elements if not part.is_linear)
    bent = [part.force_coefficients() for _, part in others]  # of walls nothing
    rises = all(not any(force[2::2]) and all(k >= 0.0 for k in force[3::2]) for force in bent)
    if not values[0] > _HELD * values[-1] or not rises:
        return None
    theta = system.thermal.temperature
    speeds = np.asarray(np.linalg.cholesky(coordinates.accelerations(theta * np.eye(size))), float)
    root = (shapes * np.sqrt(theta / values)) @ shapes.T  # symmetric: the signs of shapes are a processor's choice
    law = BoltzmannOfModes(theta, root, speeds, others)
    tried = np.random.Generator(np.random.Philox(0)).standard_normal((TRIED, size)) @ law.root.T
    return law if law.kept(tried).mean() > LEAST_KEPT else None
