"""Masses that springpots alone hold: which do, and the stiffness that they have for fast motion.

With the impulse response h, a power t^(alpha - 1) / (C Gamma(alpha)) of late times, a path from an empty memory lacks
at time t the part q times the integral of h^2 from t on of its mean square, a power t^(2 alpha - 1): that is finite
below order 1/2, and nearly all of it at orders near that.
"""

from __future__ import annotations

from dataclasses import replace

from springpot.problem.parts import Springpot
from springpot.problem.parts.springpots import resonance, springpot_in
from springpot.problem.potential import Potential
from springpot.problem.system import System

_NOTHING = 1e-200  # of a stiffness, from which the search for one begins


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
    pots = {name: springpot_in(part) for name, part in system.elements.items()}
    return {name: pot for name, pot in pots.items() if pot and 0.0 < pot.order < 0.5}


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
    alone = holding_alone(unit)
    return min(alone.values(), key=lambda pot: pot.order) if alone and not any(unit.potential.coefficients) else None


def held_by_springpots(unit: System) -> Potential:
    """The potential of a mass that springpots alone hold, with the stiffness that they have for its fast motion."""
    frequency = resonance(_NOTHING, [part for part in unit.parts if part.remembers])
    return replace(unit.potential, coefficients=(0.0, frequency**2))
