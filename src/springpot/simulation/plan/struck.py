"""Walls as slow impacts see them: near a wall only noise and what presses on it matter."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.coordinates import product_of
from springpot.problem.parts import Barrier, ParametricNoise, ThermalNoise, WhiteNoise
from springpot.problem.parts.walls import restitution_of_missed
from springpot.problem.system import System
from springpot.theory.mckean import COLLAPSE_BELOW

_COUNTABLE = 1.0001 * COLLAPSE_BELOW


@dataclass(frozen=True)
class StruckWalls:
    """Walls as slow impacts see them.

    Attributes
    ----------
    restitution : float
        1 also where there is no wall, or walls of different restitutions.
    intensity : float
        Of the white noise in the acceleration along their rows, in m^2 s^-3.
    press : float
        Acceleration with which the springs press the mass on a wall, in m/s^2; not positive without a preload.
    """

    restitution: float = 1.0
    intensity: float = 0.0
    press: float = 0.0

    @property
    def crowded(self) -> bool:
        """Whether slow impacts are frequent and can be added: the walls are lossy, and the impact rate is finite."""
        return COLLAPSE_BELOW < self.restitution < 1.0 and self.intensity > 0.0

    def resolved_speed(self, step: float) -> float:
        """The lower of the two speeds in m/s at which impacts are counted so that the errors of a step cancel.

        In units of sqrt(q h); see `springpot.simulation.estimate.completed_rate`.
        """
        return (0.47 + 0.43 * self.restitution) * math.sqrt(self.intensity * step)


def countable_restitution(wall: Barrier, intensity: float, step: float) -> float:
    """The restitution of the impacts that a step misses; of a law at least one with which impacts have a rate.

    A law may be below that limit for them and above it for slower ones.

    Examples
    --------
    >>> countable_restitution(Barrier(-1.0, 0.5), 1.0, 0.01)
    0.5
    """
    return max(restitution_of_missed(wall, intensity, step), _COUNTABLE)


def intensity_along(
    system: System, spread: Callable[[Floats], float], row: Floats, place: float | None = None, time: Any = None
) -> Any:
    """Of the acceleration of an elongation, where it is at a place, by white noise and by that of warm dashpots.

    Noise that multiplies another elongation counts with its usual size, ``spread``; at times in s, with envelopes.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Mass, Spring
    >>> warm = System(Mass(2.0), Spring(1.0), Dashpot(0.5), ThermalNoise(3.0))
    >>> intensity_along(warm, lambda row: 1.0, np.ones(1))
    0.75
    """
    at, parts, thermal = system.coordinates, dict(system.named()), system.of(ThermalNoise)
    turned = at.accelerations(row)

    def over(part: WhiteNoise | ParametricNoise) -> Any:
        return 1.0 if time is None else part.square_at(time)

    white = sum(
        over(parts[name]) * parts[name].intensity * product_of(turned, force) ** 2
        for name, force in at.forces.items()
        if isinstance(parts[name], WhiteNoise)
    )
    warm = sum(
        2.0 * thermal[0].temperature * parts[name].linear_damping * product_of(turned, own) ** 2
        for name, own in (at.elongations.items() if thermal else ())
    )
    shaken = 0.0
    for name, part in parts.items():
        if isinstance(part, ParametricNoise):
            own = at.elongations[name]
            alike = np.array_equal(own, row) or np.array_equal(own, -row)
            size = place if alike and place is not None else spread(own)
            shaken += over(part) * part.intensity * (size * product_of(turned, own)) ** 2
    return white + warm + shaken
