"""The rates and times of an oscillator, which set the step and the duration of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from springpot.problem.oscillator import Barrier, Oscillator
from springpot.theory import averaging

__all__ = ["Scales", "scales_of"]


@dataclass(frozen=True)
class Scales:
    """Rates and times of an oscillator.

    Attributes
    ----------
    fastest_rate : float
        The larger of Omega and the rate C^(1 / (2 - alpha)) of the springpot alone, in 1/s.
    energy_time : float
        1 / (2 beta) from averaging with the wall moved to the equilibrium, in s; infinite without any loss.
    creep_time : float
        (C / Omega^2)^(1 / alpha), in s, if the springpot is stronger than the spring, otherwise 0: the time of creep
        back to the equilibrium.
    forgetting_time : float
        The energy time, but at least 2 / Omega, in s.
    """

    fastest_rate: float
    energy_time: float
    creep_time: float
    forgetting_time: float

    @property
    def relaxation_time(self) -> float:
        """Relaxation time of the motion, in s: the larger of energy time and creep time."""
        return max(self.energy_time, self.creep_time)


@lru_cache(maxsize=16)
def scales_of(oscillator: Oscillator) -> Scales:
    """The rates and times of an oscillator.

    Examples
    --------
    >>> from springpot import Springpot
    >>> scales = scales_of(Oscillator(natural_frequency=2.0, springpot=Springpot(order=1.0, coefficient=0.1)))
    >>> scales.fastest_rate, round(scales.energy_time, 6), scales.creep_time
    (2.0, 10.0, 0.0)
    """
    spring, energy = oscillator.springpot, _energy_time(oscillator)
    return Scales(
        fastest_rate=max(oscillator.natural_frequency, float(spring.coefficient ** (1.0 / (2.0 - spring.order)))),
        energy_time=energy,
        creep_time=_creep_time(oscillator),
        forgetting_time=max(energy, 2.0 / oscillator.natural_frequency),
    )


def _energy_time(oscillator: Oscillator) -> float:
    """As in `Scales`.

    With a gap the part of beta due to lossy impacts is multiplied by the share of cycles that reach the wall, and the
    time to grow to that amplitude is added.
    """
    frequency, barrier = oscillator.natural_frequency, oscillator.barrier
    elastic = replace(oscillator, barrier=None if barrier is None else Barrier())
    rate = 2.0 * averaging(elastic).decay_rate / _slowing(oscillator)
    growth = 0.0
    if barrier is not None and oscillator.restitution < 1.0:
        gap = max(0.0, -oscillator.direction * barrier.position)
        intensity = oscillator.excitation.intensity
        # share of a Rayleigh amplitude with <A^2> = q / (rate Omega^2) beyond the gap
        struck = math.exp(-rate * (gap * frequency) ** 2 / intensity) if gap > 0.0 and intensity > 0.0 else 1.0
        lossy = replace(oscillator, barrier=Barrier(0.0, oscillator.restitution))
        impacts = 2.0 * (averaging(lossy).decay_rate - averaging(elastic).decay_rate)
        rate += struck * impacts
        growth = struck * (gap * frequency) ** 2 / intensity if intensity > 0.0 else 0.0
    return 1.0 / rate + growth if rate > 0.0 else math.inf


def _slowing(oscillator: Oscillator) -> float:
    """Ratio of the decay rate by averaging at Omega to the actual one: the springpot's stiffness raises the frequency.

    At the resonance w without a wall (with a wall the stiffness is smaller) the springpot's power is proportional to
    w^(alpha - 1), and it stores the part alpha (w^2 - Omega^2) / (2 w^2) of the energy.
    """
    order, ratio = oscillator.springpot.order, oscillator.resonance / oscillator.natural_frequency
    return math.pow(ratio, 1.0 - order) * (1.0 + 0.5 * order * (1.0 - ratio**-2))


def _creep_time(oscillator: Oscillator) -> float:
    spring = oscillator.springpot
    if oscillator.dimensionless_coefficient <= 1.0 or spring.order == 0.0:
        return 0.0
    logarithm = math.log(spring.coefficient / oscillator.natural_frequency**2) / spring.order
    return math.exp(logarithm) if logarithm < 700.0 else math.inf
