"""The transient of a run: exponential for the energy, a power of time for slow displacements.

A path starts with an empty memory, so at time t a part of the variance of x is missing: the response to earlier noise,
q times the integral of h^2 from t on, where h is the impulse response without a wall.  For large t, h follows the creep
of spring and springpot, C D^alpha x + Omega^2 x = delta: t^(alpha - 1) / (C Gamma(alpha)) before the creep time, and
alpha C t^(-1 - alpha) / (Omega^4 Gamma(1 - alpha)) after it (Podlubny, "Fractional Differential Equations", 1999,
sections 1.2 and 5).  Up to order 1/2 each is a bound at all times.  Above order 1/2 the second is not: near order 1 the
creep ends almost like exp(-Omega^2 t / C), and the power law is late and small.  There h is integrated as a sum of
exponentials,

    h(t) = (1 / (pi alpha Omega^2)) int_0^(pi alpha) s exp(-s t) du,   C s^alpha / Omega^2 = sin u / sin(pi alpha - u).
"""

from __future__ import annotations

import math

import numpy as np

from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Springpot, ThermalNoise, WhiteNoise
from springpot.problem.system import System
from springpot.simulation.plan.scales import scales_of
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.system_scales import dissipated, system_scales

__all__ = [
    "is_stationary", "missing_variance", "oscillators_alike", "shares_missing", "system_shares_missing",
    "transient_left",
]  # fmt: skip

MOST_TRANSIENT = 0.01  # share left at the start of the window
LATE = math.log(1e6)  # log(time / creep time) above which the late power law is used
WALL = 2.0  # a wall changes the slow displacements by less than this factor
SLOW = {"x_mean": 0.5, "x_mean_square": 1.0, "impact_rate": 0.5, "impact_speed_mean": 0.5,
        "impact_speed_mean_square": 0.5}  # fmt: skip
"""Relative change of a quantity over that of the variance of x; v^2 and A^2 are treated separately."""


def missing_variance(oscillator: Oscillator, time: float) -> float:
    """Bound on the missing variance of x at a time much longer than a cycle, in m^2.

    Examples
    --------
    >>> from springpot import Springpot
    >>> strong = Oscillator(springpot=Springpot(order=0.5, coefficient=50.0))
    >>> [round(1e6 * missing_variance(strong, time)) for time in (20.0, 1000.0, 1e5)]
    [590, 92, 0]
    """
    order, coefficient = oscillator.springpot.order, oscillator.springpot.coefficient
    if order == 0.0 or coefficient == 0.0:
        return 0.0
    intensity = oscillator.excitation.intensity
    if order <= 0.5:
        return intensity * _squared_powers(oscillator, time)
    return intensity * _squared_creep(oscillator, time)


def _squared_powers(oscillator: Oscillator, time: float) -> float:
    """Integral of h^2 from a time on, with the smaller of the two power laws for h; logarithms avoid overflow."""
    order, now = oscillator.springpot.order, math.log(time)
    coefficient, stiffness = math.log(oscillator.springpot.coefficient), 2.0 * math.log(oscillator.natural_frequency)
    early = -coefficient - math.lgamma(order)  # times t^(order - 1)
    late = math.log(order) + coefficient - 2.0 * stiffness - math.lgamma(1.0 - order)  # times t^(-1 - order)
    crossing = 0.5 * (late - early) / order
    after = math.exp(2.0 * late - (1.0 + 2.0 * order) * max(now, crossing)) / (1.0 + 2.0 * order)
    if now >= crossing:
        return after
    power = 1.0 - 2.0 * order
    before = (crossing - now) * math.exp(2.0 * early - power * now)
    if power > 1e-9:
        before *= -math.expm1(-power * (crossing - now)) / (power * (crossing - now))
    return after + before


def _squared_creep(oscillator: Oscillator, time: float) -> float:
    """Integral of h^2 from a time on, above order 1/2."""
    order, stiffness = oscillator.springpot.order, oscillator.natural_frequency**2
    logarithm = math.log(stiffness / oscillator.springpot.coefficient) / order  # of the rate of creep
    scaled = logarithm + math.log(time)
    if order == 1.0:
        return 0.5 * math.exp(logarithm - 2.0 * math.exp(min(scaled, 7.0))) / stiffness**2 if scaled < 7.0 else 0.0
    if scaled > LATE:
        return _squared_powers(oscillator, time)
    small = math.log(math.pi * order / math.sin(math.pi * (1.0 - order)))
    y = np.arange(-20.0 - small - max(order * scaled, 0.0), 20.0 + small + max(-order * scaled, 0.0), 0.15)
    share, rest = 1.0 / (1.0 + np.exp(-y)), 1.0 / (1.0 + np.exp(y))
    u, other = math.pi * order * share, math.pi * order * rest
    rate = (np.sin(u) / np.sin(other)) ** (1.0 / order)  # over that of creep
    weight = 0.15 * u * rest * rate * np.exp(-rate * math.exp(scaled))
    pairs = float(np.sum(np.outer(weight, weight) / (rate[:, None] + rate)))
    return math.exp(logarithm) * pairs / (math.pi * order * stiffness) ** 2


def shares_missing(oscillator: Oscillator, time: float, x_mean_square: float, amplitude: float) -> dict[str, float]:
    """Bound on the missing share of each quantity at a time due to slow displacements, given <x^2> and <A^2>.

    With a gap b the impact rate is proportional to exp(-b^2 / (2 <x^2>)), which adds b^2 / (2 <x^2>) to its relative
    change.
    """
    factor = 1.0 if oscillator.barrier is None else WALL
    missing = factor * missing_variance(oscillator, time)
    wall = oscillator.barrier
    gap = 0.0 if wall is None else min(oscillator.direction * wall.position, 0.0)
    rarer = dict.fromkeys(("x_mean", "impact_rate"), 0.5 * gap * gap / x_mean_square)
    shares = {
        name: min(1.0, (weight + rarer.get(name, 0.0)) * missing / x_mean_square) for name, weight in SLOW.items()
    }
    return shares | {"amplitude_mean_square": min(1.0, missing / amplitude), "v_mean_square": 0.0}


def oscillators_alike(system: System) -> list[Oscillator]:
    """For each springpot of a system, an oscillator with its slow displacements: of the frequency and power guessed.

    A thermal system has none: it starts from its stationary law.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring
    >>> [alike.springpot.order for alike in oscillators_alike(System(Spring(1.0), Springpot(0.5, 0.1), Dashpot(0.2)))]
    [0.5]
    """
    if system.of(ThermalNoise):
        return []
    scales, unit = system_scales(system), system.per_unit_mass
    taken = max(dissipated(unit, scales.law), 0.0)
    return [
        Oscillator(scales.law.frequency, pot, None, WhiteNoise(2.0 * taken))
        for pot in unit.of(Springpot)
        if pot.remembers
    ]


def system_shares_missing(system: System, time: float, x_mean_square: float) -> float:
    """Bound on the missing share of the variance of x at a time, due to slow displacements."""
    missing = sum(missing_variance(alike, time) for alike in oscillators_alike(system))
    return min(1.0, WALL * missing / x_mean_square)


def transient_left(oscillator: Oscillator, settings: Settings) -> float:
    """Share of the transient that is left at the start of the window."""
    return math.exp(-settings.window[0] / scales_of(oscillator).relaxation_time)


def is_stationary(oscillator: Oscillator, settings: Settings) -> bool:
    """Whether the settings make averages over the window stationary.

    Not with a wall, memory and a start from rest, whose transient decays only like t^-alpha.
    """
    remembered = settings.start == "rest" and oscillator.barrier is not None and 0.0 < oscillator.springpot.order < 1.0
    settled = transient_left(oscillator, settings) <= MOST_TRANSIENT
    return oscillator.excitation.intensity > 0.0 and settled and not remembered
