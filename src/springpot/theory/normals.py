"""The law of two independent normals, of a displacement that a wall may cut off and a velocity."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats
from springpot.theory.distributions import hoyt, normal, rayleigh
from springpot.theory.problem import Units

_FAR = 60.0  # standard deviations at which every density here is exactly 0 in double precision


@dataclass(frozen=True)
class Normals:
    """Densities of two independent normals, the first cut off at the wall (NaN for none); dimensionless."""

    units: Units
    x_spread: float
    v_spread: float
    wall: float

    def x(self, x: Floats) -> Floats:
        """Density of the displacement."""
        return normal(x, self.x_spread**2) if math.isnan(self.wall) else _cut_normal(x, self.x_spread, self.wall)

    def v(self, v: Floats) -> Floats:
        """Density of the velocity."""
        return normal(v, self.v_spread**2)

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Density of both."""
        return np.asarray(self.x(x) * self.v(v))

    def amplitude(self, amplitude: Floats) -> Floats:
        """Density of sqrt(x^2 + v^2)."""
        if math.isnan(self.wall) or self.wall == 0.0:  # which halves every circle
            return hoyt(amplitude, self.x_spread**2, self.v_spread**2)
        return _cut_rayleigh(amplitude, self.x_spread, self.wall)

    def impact_speed(self, speed: Floats) -> Floats:
        """Density of the speed just before an impact."""
        return rayleigh(speed, 2.0 * self.v_spread**2)


def hazard_of(k: float) -> float:
    """phi(k) / (1 - Phi(k)), the inverse of Mills' ratio; 0 where it is below double precision."""
    from scipy import special  # slow to import, and most runs need none of it

    return math.sqrt(2.0 / math.pi) / float(special.erfcx(k / math.sqrt(2.0)))


def _cut_normal(value: Floats, spread: float, wall: float) -> Floats:
    """Normal density on value >= wall, normalized there."""
    from scipy import special  # slow to import, and most runs need none of it

    k = wall / spread
    z = np.clip(value / spread - k, -1.0, _FAR + abs(k))
    if k > 0.0:  # k^2 is taken out by hand: under a deep preload it is huge
        shape = hazard_of(k) * np.exp(-z * (k + z / 2.0))
    else:
        shape = np.exp(-((z + k) ** 2) / 2.0) / (math.sqrt(2.0 * math.pi) * float(special.ndtr(-k)))
    return np.asarray(np.where(z >= 0.0, shape, 0.0) / spread)


def _cut_rayleigh(amplitude: Floats, spread: float, wall: float) -> Floats:
    """Rayleigh density of an amplitude whose phase is uniform on the arc beyond the wall."""
    from scipy import special  # slow to import, and most runs need none of it

    k = wall / spread
    a = np.clip(amplitude / spread, 0.0, _FAR + abs(k))
    with np.errstate(divide="ignore", invalid="ignore"):
        arc = np.arccos(np.clip(np.nan_to_num(k / a), -1.0, 1.0)) / math.pi
    if k > 0.0:  # 1 - Phi(k) = exp(-k^2 / 2) erfcx(k / sqrt 2) / 2
        shape = np.exp(-np.maximum(a - k, 0.0) * (a + k) / 2.0) * 2.0 / float(special.erfcx(k / math.sqrt(2.0)))
    else:
        shape = np.exp(-a * a / 2.0) / float(special.ndtr(-k))
    return np.asarray(a * arc * shape / spread)
