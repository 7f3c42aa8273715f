"""The slow displacements of the paper's springpot in closed form: a power of time.  Those of any other system: `creep`.

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
from dataclasses import dataclass, replace

import numpy as np

from springpot.problem.dimensionless import Dimensionless
from springpot.simulation.plan.scales import closed_form

LATE = math.log(1e6)  # log(time / creep time) above which the late power law is used


@dataclass(frozen=True)
class CreepOfPaper:
    """The slow displacements of one springpot or dashpot: those of the paper's problem without its wall."""

    paper: Dimensionless

    @property
    def times(self) -> tuple[float, float]:
        """Between which the end of the transient is sought."""
        return 1.0 / self.paper.natural_frequency, 100.0 * closed_form(self.paper).relaxation_time

    @property
    def free(self) -> dict[str, float]:
        """Mean squares without a wall; none where only the wall dissipates."""
        from springpot.theory.problem import free_mean_squares  # loaded for rtol only

        free = free_mean_squares(replace(self.paper, barrier=None))
        if isinstance(free, str):  # no springpot, or one of order 0
            return {}
        square = self.paper.length_scale**2
        return {"x_mean_square": free[0] * square, "amplitude_mean_square": sum(free) * square}

    def missing(self, time: float) -> dict[str, float]:
        """Bound on the variance that is missing at a time, in m^2."""
        return {"x_mean_square": missing_variance(self.paper, time)}

    def left(self, time: float) -> float:
        """The share of the variance that is missing at a time, about."""
        return missing_variance(self.paper, time) / self.paper.length_scale**2


def missing_variance(paper: Dimensionless, time: float) -> float:
    """Bound on the missing variance of x at a time much longer than a cycle, in m^2.

    Examples
    --------
    >>> from springpot import Springpot
    >>> strong = Dimensionless(springpot=Springpot(order=0.5, coefficient=50.0))
    >>> [round(1e6 * missing_variance(strong, time)) for time in (20.0, 1000.0, 1e5)]
    [590, 92, 0]
    """
    order, coefficient = paper.springpot.order, paper.springpot.coefficient
    if order == 0.0 or coefficient == 0.0:
        return 0.0
    intensity = paper.excitation.intensity
    if order <= 0.5:
        return intensity * _squared_powers(paper, time)
    return intensity * _squared_creep(paper, time)


def _squared_powers(paper: Dimensionless, time: float) -> float:
    """Integral of h^2 from a time on, with the smaller of the two power laws for h; logarithms avoid overflow."""
    order, now = paper.springpot.order, math.log(time)
    coefficient, stiffness = math.log(paper.springpot.coefficient), 2.0 * math.log(paper.natural_frequency)
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


def _squared_creep(paper: Dimensionless, time: float) -> float:
    """Integral of h^2 from a time on, above order 1/2."""
    order, stiffness = paper.springpot.order, paper.natural_frequency**2
    logarithm = math.log(stiffness / paper.springpot.coefficient) / order  # of the rate of creep
    scaled = logarithm + math.log(time)
    if order == 1.0:
        return 0.5 * math.exp(logarithm - 2.0 * math.exp(min(scaled, 7.0))) / stiffness**2 if scaled < 7.0 else 0.0
    if scaled > LATE:
        return _squared_powers(paper, time)
    small = math.log(math.pi * order / math.sin(math.pi * (1.0 - order)))
    y = np.arange(-20.0 - small - max(order * scaled, 0.0), 20.0 + small + max(-order * scaled, 0.0), 0.15)
    share, rest = 1.0 / (1.0 + np.exp(-y)), 1.0 / (1.0 + np.exp(y))
    u, other = math.pi * order * share, math.pi * order * rest
    rate = (np.sin(u) / np.sin(other)) ** (1.0 / order)  # over that of creep
    weight = 0.15 * u * rest * rate * np.exp(-rate * math.exp(scaled))
    pairs = float(np.sum(np.outer(weight, weight) / (rate[:, None] + rate)))
    return math.exp(logarithm) * pairs / (math.pi * order * stiffness) ** 2
