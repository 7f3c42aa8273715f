"""Basquin's curve: how many cycles of a stress a part survives."""

from __future__ import annotations

import math
from dataclasses import dataclass

from springpot.machine.arguments import finite_number, positive_number

HOUR = 3600.0  # seconds


@dataclass(frozen=True)
class Basquin:
    """Basquin's curve of a part, N = cycles (strength / S)^exponent, for Miner's sum: a cycle does the damage 1 / N.

    S is the amplitude of the stress in a cycle, half of its range.  The mean of the stress is not counted, and no
    amplitude is so small that it does no damage.

    Parameters
    ----------
    exponent : float
        Slope k of the curve, from 1 to 50.
    strength : float
        Amplitude of the stress that the part survives for ``cycles``, in the unit of the stress; of what is counted
        itself, in m or N, with a ``stress`` of 1.
    cycles : float
        Number of cycles to failure at an amplitude of ``strength``.
    stress : float
        Stress per unit of what is counted: in Pa per m of a displacement, or in Pa per N of a force.

    Raises
    ------
    TypeError, ValueError
        If a number is out of its range.

    Examples
    --------
    A weld that survives 2 million cycles of 36 MPa amplitude, at 50 MPa per kN of a force:

    >>> weld = Basquin(3.0, strength=36e6, cycles=2e6, stress=5e4)
    >>> round(weld.cycles_at(1440.0))
    250000
    """

    exponent: float
    strength: float = 1.0
    cycles: float = 1.0
    stress: float = 1.0

    def __post_init__(self) -> None:
        exponent = finite_number(self.exponent, "exponent", low=1.0, high=50.0, hint="Of metals it is 3 to 15.")
        object.__setattr__(self, "exponent", exponent)
        for name in ("strength", "cycles", "stress"):
            number = positive_number(getattr(self, name), name)
            object.__setattr__(self, name, number)

    def cycles_at(self, amplitude: float) -> float:
        """Cycles to failure at an amplitude of what is counted."""
        return self.cycles * math.exp(self.exponent * math.log(self.strength / (self.stress * amplitude)))

    def damage_per_hour(self, rate: float, unit: float) -> float:
        """Damage per hour, from the sum of (amplitude / unit)^exponent per second."""
        return HOUR * rate / self.cycles_at(unit)
