"""A mass that springpots alone hold: the stiffness that they have for fast motion, and how slowly a start is forgotten.

With the impulse response h, a power t^(alpha - 1) / (C Gamma(alpha)) of late times, a path from an empty memory lacks
at time t the part q times the integral of h^2 from t on of its mean square, a power t^(2 alpha - 1): that is finite
below order 1/2, and nearly all of it at orders near that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from springpot.problem.parts import Springpot
from springpot.problem.parts.springpots import order_at_rest, resonance, springpot_in
from springpot.problem.potential import Potential
from springpot.problem.system import System

_NOTHING = 1e-200  # of a stiffness, from which the search for one begins
_FARTHEST = 1e12  # cycles, beyond which no run goes


@dataclass(frozen=True)
class CreepAlone:
    """The slow displacements of a mass that springpots alone hold, of which the one of the lowest order is the last.

    Attributes
    ----------
    springpot : Springpot
        Per unit mass.
    intensity : float
        Of the noise at frequency 0, that of white noise.
    frequency : float
        Of its fast motion, in rad/s.
    variance : float
        Of x, about, in m^2.
    """

    springpot: Springpot
    intensity: float
    frequency: float
    variance: float

    @property
    def times(self) -> tuple[float, float]:
        """Between which the end of the transient is sought."""
        return 1.0 / self.frequency, _FARTHEST / self.frequency

    @property
    def free(self) -> dict[str, float]:
        """Mean squares, about."""
        return {"x_mean_square": self.variance}

    def missing(self, time: float) -> dict[str, float]:
        """The variance that is missing at a time, in m^2."""
        return {"x_mean_square": self._missing_at_once * time ** (2.0 * self.springpot.order - 1.0)}

    def left(self, time: float) -> float:
        """The share of the variance that is missing at a time, about."""
        return self.missing(time)["x_mean_square"] / self.variance

    def time_of(self, share: float, square: float) -> float:
        """The time in s at which a share of a mean square is missing."""
        ratio = self._missing_at_once / (share * square)
        return float(ratio ** (1.0 / (1.0 - 2.0 * self.springpot.order))) if ratio > 0.0 else 0.0

    @property
    def _missing_at_once(self) -> float:
        order = self.springpot.order
        slow = self.springpot.coefficient * math.gamma(order)
        return self.intensity / (slow * slow * (1.0 - 2.0 * order))


def springpot_alone(unit: System) -> Springpot | None:
    """The springpot that holds a mass in the end, where springpots of an order below 1/2 alone do; else None.

    A wall or a constant force on one side pushes such a mass away without end.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, WhiteNoise
    >>> springpot_alone(System(Springpot(0.3, 1.0), Springpot(0.6, 1.0), WhiteNoise(1.0)))
    Springpot(order=0.3, coefficient=1.0)
    >>> springpot_alone(System(Springpot(0.3, 1.0), Spring(1.0))) is None
    True
    """
    own = unit.potential
    if any(own.coefficients) or own.contacts or math.isfinite(own.low) or math.isfinite(own.high):
        return None
    slowest = min(unit.elements.values(), key=order_at_rest, default=None)
    return springpot_in(slowest) if 0.0 < order_at_rest(slowest) < 0.5 else None


def held_by_springpots(unit: System) -> Potential:
    """The potential of a mass that springpots alone hold, with the stiffness that they have for its fast motion."""
    frequency = resonance(_NOTHING, [part for part in unit.parts if part.remembers])
    return replace(unit.potential, coefficients=(0.0, frequency**2))


def creep_of(unit: System, frequency: float, variance: float) -> tuple[CreepAlone, ...]:
    """The slow displacements of a mass that springpots alone hold; empty of any other."""
    if (pot := springpot_alone(unit)) is None:
        return ()
    densities = (part.density(0.0) for part in unit.parts if hasattr(part, "density"))
    return (CreepAlone(pot, 2.0 * math.pi * sum(densities), frequency, variance),)
