"""Walls as slow impacts see them, where only noise and what presses on the wall matter, and hops on pressed walls."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.coordinates import product_of
from springpot.problem.parts import Barrier, ParametricNoise, WhiteNoise
from springpot.problem.parts.walls import restitution_of_missed
from springpot.problem.system import System
from springpot.theory.mckean import COLLAPSE_BELOW, slow_impact_power

_COUNTABLE = 1.0001 * COLLAPSE_BELOW
MOST_TURNED = 0.1  # h a / v_rms up to which a run does not warn, at restitutions of at least `_SLOW`
_AIMED = 0.8  # of the most, for default steps: v_rms is a guess there
_SLOW = 0.3  # restitution below which the error is larger
_LARGER = 0.3  # there, of the most
_SHARE = 0.13  # of h a / v_rms that is lacking in the mean square of the velocity
_SHARE_SLOW, _POWER_SLOW = 0.11, 0.45


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

        In units of sqrt(q h); see `springpot.simulation.estimate.slow_impacts`.
        """
        return (0.47 + 0.43 * self.restitution) * math.sqrt(self.intensity * step)


@dataclass(frozen=True)
class Pressed:
    """A lossy wall, and what presses a mass on it: how finely a step must follow the hops there, under white noise.

    A hop lasts about its speed over the acceleration a that presses.  With a step h too few kicks share in a hop, and
    the mean square of the velocity is too low by 12 to 14 % of h a / v_rms (at restitutions of 0.2 by 11 % of its root,
    about).  The power that the wall takes is right at any step: it is what noise feeds in.  Compared with the
    Fokker-Planck equation at order 1, restitutions from 0.2 to 0.8.

    Attributes
    ----------
    acceleration : float
        With which springs and constant forces press the mass on the wall, in m/s^2.
    restitution : float
    """

    acceleration: float
    restitution: float

    @property
    def most_turned(self) -> float:
        """The largest h a / v_rms that gives no warning."""
        return MOST_TURNED if self.restitution >= _SLOW else _LARGER * MOST_TURNED

    def turned(self, step: float, speed: float) -> float:
        """h a / v_rms."""
        return step * self.acceleration / speed

    def lacking(self, step: float, speed: float) -> float:
        """Share of the mean square of the velocity that a step loses.

        Examples
        --------
        >>> round(Pressed(9.81, 0.5).lacking(0.005, 0.0624), 3)
        0.102
        """
        turned = self.turned(step, speed)
        return _SHARE * turned if self.restitution >= _SLOW else _SHARE_SLOW * math.pow(turned, _POWER_SLOW)

    def speed(self, fed: float, damping: float) -> float:
        """v_rms, about, at which walls and dampers together take a power per unit mass.

        The wall takes (1 - r^2) a v_rms / 2, within a tenth for restitutions from 0.2 to 0.8.

        Examples
        --------
        >>> round(Pressed(9.81, 0.5).speed(0.25, 0.1), 3)  # it is 0.0624
        0.068
        """
        taken = 0.5 * (1.0 - self.restitution**2) * self.acceleration
        return 2.0 * fed / (taken + math.sqrt(taken * taken + 4.0 * damping * fed))

    def rate(self, speed: float, default_step: float) -> float:
        """The rate, in 1/s, of which a default step is this part, where v_rms is a guess."""
        return default_step * self.acceleration / (_AIMED * self.most_turned * speed)


def slow_impact_order(restitution: float) -> float:
    """Order in the step of the impact rate's bias, between 0 and 1.

    Near a lossy wall under white noise the rate of impacts slower than v is proportional to v^m, with m of
    `springpot.theory.mckean.slow_impact_power`, and a step h misses speeds below about sqrt(h): the bias is
    proportional to h^(m/2).  At and below r = 0.163 there is no such m and the rate is infinite.

    Examples
    --------
    >>> [round(slow_impact_order(r), 3) for r in (1.0, 0.5, 0.25, 0.1)]
    [1.0, 0.5, 0.125, 0.0]
    """
    return 0.5 * slow_impact_power(restitution)


def missed_impacts(walls: StruckWalls, step: float, impact_speed_mean_square: float) -> float:
    """Share of the impacts on a lossy wall that a run with this step misses, from its mean square impact speed.

    A step h misses speeds below about sqrt(q h), and the rate of impacts slower than u is proportional to u^m: the
    share is B (q h / <u^2>)^(m/2).  Compared with the Fokker-Planck equation at order 1, for r from 0.2 to 0.9, c from
    0.1 to 2 and b = 0 and -0.5, B = exp(-3.41 (r - 0.163)^(3/4)) to 10 % at b = 0 and to 20 % at b = -0.5.  The rate is
    too low by this share, and the mean speed too high by it.

    Examples
    --------
    >>> round(missed_impacts(StruckWalls(0.5, 1.0), 0.01, 1.0), 3)
    0.022
    """
    restitution = walls.restitution
    if restitution == 1.0 or not impact_speed_mean_square > 0.0:
        return 0.0
    blur = walls.intensity * step / impact_speed_mean_square
    front, order, missed = _front(restitution), slow_impact_order(restitution), 0.0
    for _ in range(50):  # the measured mean square is too high, because slow impacts are missing in it
        missed = min(front * (blur / (1.0 - missed)) ** order, 0.95)
    return missed


def step_that_misses(walls: StruckWalls, share: float, impact_speed_mean_square: float) -> float:
    """The step with which a run misses a small share of the impacts, by the law of `missed_impacts`; 0 where every step
    misses more.

    Examples
    --------
    >>> walls = StruckWalls(0.8, 1.0)
    >>> round(missed_impacts(walls, step_that_misses(walls, 0.003, 1.0), 1.0), 4)
    0.003
    """
    order = slow_impact_order(walls.restitution)
    if order == 0.0:
        return 0.0
    blur = math.pow(share / _front(walls.restitution), 1.0 / order)
    return blur * impact_speed_mean_square / walls.intensity


def _front(restitution: float) -> float:
    """B of `missed_impacts`."""
    return math.exp(-3.41 * max(restitution - COLLAPSE_BELOW, 0.0) ** 0.75)


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
    >>> from springpot.problem.parts import Dashpot, Mass, Spring, ThermalNoise
    >>> warm = System(Mass(2.0), Spring(1.0), Dashpot(0.5), ThermalNoise(3.0))
    >>> intensity_along(warm, lambda row: 1.0, np.ones(1))
    0.75
    """
    at, parts, turned = system.coordinates, dict(system.named()), system.coordinates.accelerations(row)
    temperature = system.temperature

    def over(part: WhiteNoise | ParametricNoise) -> Any:
        return 1.0 if time is None else part.square_at(time)

    white = sum(
        over(parts[name]) * parts[name].intensity * product_of(turned, force) ** 2
        for name, force in at.forces.items()
        if parts[name].noise == "white"
    )
    warm = sum(
        2.0 * temperature * parts[name].linear_damping * product_of(turned, own) ** 2
        for name, own in (at.elongations.items() if temperature else ())
    )
    shaken = 0.0
    for name, part in system.multiplied.items():
        own = at.elongations[name]
        alike = np.array_equal(own, row) or np.array_equal(own, -row)
        size = place if alike and place is not None else spread(own)
        shaken += over(part) * part.intensity * (size * product_of(turned, own)) ** 2
    return white + warm + shaken
