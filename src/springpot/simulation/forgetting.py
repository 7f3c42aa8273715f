"""How long a run takes to forget its start: the energy exponentially, slow displacements by a power of the time.

A path starts with an empty memory, so after a time t its displacement lacks the part of the variance that the response
to older noise would have, q times the integral of h^2 from t on, h being the response to an impulse without a wall.
Slowly, h follows the creep under spring and springpot, C D^alpha x + Omega^2 x = delta:
t^(alpha - 1) / (C Gamma(alpha)) at first, and alpha C t^(-1 - alpha) / (Omega^4 Gamma(1 - alpha)) after the time of
creep (Podlubny, "Fractional Differential Equations", 1999, sections 1.2 and 5); each is a bound at all times.
"""

from __future__ import annotations

import math

from springpot.oscillator import Oscillator
from springpot.simulation.settings import energy_time

__all__ = ["forgetting_time", "missing_variance", "shares_missing"]

WALL = 2.0  # a wall changes the slow displacements by less than this factor
SLOW = {"x_mean": 0.5, "x_mean_square": 1.0, "impact_rate": 0.5, "impact_speed_mean": 0.5,
        "impact_speed_mean_square": 0.5}  # fmt: skip
"""Relative change of a quantity over that of the displacement's variance; energies of the motion are not in it."""


def forgetting_time(oscillator: Oscillator) -> float:
    """Time in which the energy forgets its start, in s, at least two over Omega."""
    return max(energy_time(oscillator), 2.0 / oscillator.natural_frequency)


def missing_variance(oscillator: Oscillator, time: float) -> float:
    """Bound on the variance of x that a run lacks at a time long against the cycle, in m^2.

    Examples
    --------
    >>> from springpot import Springpot
    >>> strong = Oscillator(springpot=Springpot(order=0.5, coefficient=50.0))
    >>> [round(1e6 * missing_variance(strong, time)) for time in (20.0, 1000.0, 1e5)]
    [590, 92, 0]
    """
    order, coefficient = oscillator.springpot.order, oscillator.springpot.coefficient
    if not 0.0 < order < 1.0 or coefficient == 0.0:
        return 0.0
    stiffness = oscillator.natural_frequency**2
    early = 1.0 / (coefficient * math.gamma(order))  # times t^(order - 1)
    late = order * coefficient / (stiffness**2 * math.gamma(1.0 - order))  # times t^(-1 - order)
    crossing = (late / early) ** (0.5 / order)
    power = 2.0 * order - 1.0
    if time >= crossing:
        before = 0.0
    elif abs(power) < 1e-9:
        before = math.log(crossing / time)
    else:
        before = (crossing**power - time**power) / power
    after = max(time, crossing) ** (-1.0 - 2.0 * order) / (1.0 + 2.0 * order)
    return float(oscillator.excitation.intensity * (early**2 * before + late**2 * after))


def shares_missing(oscillator: Oscillator, time: float, x_mean_square: float, amplitude: float) -> dict[str, float]:
    """Bound on the share of each quantity that slow displacements lack at a time, given <x^2> and <A^2>."""
    factor = 1.0 if oscillator.barrier is None else WALL
    missing = factor * missing_variance(oscillator, time)
    shares = {name: min(1.0, weight * missing / x_mean_square) for name, weight in SLOW.items()}
    return shares | {"amplitude_mean_square": min(1.0, missing / amplitude), "v_mean_square": 0.0}
