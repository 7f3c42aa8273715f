"""Slow displacements of systems with springpots: how much of their variance a run from rest lacks.

Without springpots a linear system forgets exponentially.  With them its transfer functions G have a cut along the
negative axis, and each impulse response ends like the sum over this cut,

    h(t) = (1 / pi) int_0^inf Im G(s exp(-i pi)) exp(-s t) ds,

which decays like a power of time.  Walls are left out, and nonlinear springs count with their mean stiffness.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.system import System
from springpot.simulation.plan.loose import holding_alone

_SLOWEST, _FASTEST, _SPACING = 1e-13, 1e3, 0.05  # rates on the cut over the fastest of the motion; their logarithm
_BELOW = 1e-12  # the cut, over the rate
_HELD = 1e-10  # least eigenvalue of the stiffness over the largest


@dataclass(frozen=True, eq=False)
class Creep:
    """The slow displacements of a system.

    Attributes
    ----------
    system : System
    stiffness : ndarray, shape (coordinates, coordinates)
        The mean one, of springs.
    fastest_rate : float
    rows : dict
        What is displaced: an elongation's row by the name of its mean square.
    free : dict
        Their mean squares without walls, about.
    shaken : dict
        The root mean square elongations that noise multiplies, about, by the names of these parts.
    """

    system: System
    stiffness: Floats
    fastest_rate: float
    rows: Mapping[str, Floats]
    free: dict[str, float]
    shaken: Mapping[str, float]

    @property
    def times(self) -> tuple[float, float]:
        """Between which the end of the transient is sought."""
        return 1.0 / self.fastest_rate, 0.01 / (_SLOWEST * self.fastest_rate)

    @cached_property
    def _rates(self) -> Floats:
        low, high = (math.log(end * self.fastest_rate) for end in (_SLOWEST, _FASTEST))
        return np.asarray(np.exp(np.arange(low, high, _SPACING)))

    @cached_property
    def _shares(self) -> tuple[Floats, Floats]:
        """Of each rate: in the displacements per unit of white noise, and in those that are left of a thermal start."""
        system, coordinates, s = self.system, self.system.coordinates, self._rates
        none = np.zeros((len(self.rows), 0, len(s)))
        k = self.stiffness
        alone = {} if system.thermal else holding_alone(system)
        values = np.linalg.eigvalsh(
            k + coordinates.sum_of({name: springpot.coefficient for name, springpot in alone.items()})
        )
        if not values[0] > _HELD * values[-1]:
            return none, none
        p = -s * (1.0 + 1j * _BELOW)
        matrix = k + (p**2)[:, None, None] * coordinates.mass
        for name, part in system.elements.items():
            row, beside = coordinates.elongations[name], np.asarray(part.modulus(p) - part.static_stiffness)
            matrix = matrix + beside[..., None, None] * np.outer(row, row)
        cut = np.linalg.inv(matrix).imag / math.pi * (_SPACING * s)[:, None, None]
        g, noises = np.array([*self.rows.values()]), system.excitations
        pushes = [math.sqrt(noises[name].slow_intensity) * force for name, force in coordinates.forces.items()]
        for name, size in self.shaken.items():
            pushes.append(math.sqrt(system.multiplied[name].intensity) * size * coordinates.elongations[name])
        shares = np.einsum("ri,nij,kj->rkn", g, cut, np.array(pushes).reshape(-1, len(k)))
        if not system.thermal:
            return shares, none
        root = math.sqrt(system.thermal.temperature) * np.linalg.cholesky(k)
        return shares, np.einsum("ri,nij,jk->rkn", g, cut / s[:, None, None], root)

    @cached_property
    def _pairs(self) -> Floats:
        return 1.0 / np.add.outer(self._rates, self._rates)

    def missing(self, time: float) -> dict[str, float]:
        """Variance that is missing at a time, in m^2."""
        noise, start = self._shares
        left = np.exp(-self._rates * time)
        noise = noise * left
        found = ((noise @ self._pairs) * noise).sum(axis=(1, 2)) + ((start @ left) ** 2).sum(axis=1)
        return {name: float(value) for name, value in zip(self.rows, found, strict=True)}

    def left(self, time: float) -> float:
        """The largest share of a variance that is missing at a time, about."""
        missing = self.missing(time)
        return max((value / self.free[name] for name, value in missing.items() if self.free[name] > 0.0), default=0.0)
