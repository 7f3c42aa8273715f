"""The kernel's units."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """The kernel's units.

    Attributes
    ----------
    length, time : float
        In m and s.
    """

    length: float
    time: float

    @classmethod
    def near(cls, length: float, fastest: float) -> Units:
        """Powers of two near a length and the time of a rate."""
        near = 2.0 ** round(math.log2(length)) if length > 0.0 else 1.0
        return cls(near, 2.0 ** round(-math.log2(fastest)))

    @property
    def speed(self) -> float:
        """In m/s."""
        return self.length / self.time

    @property
    def state(self) -> tuple[float, float]:
        """Factors for x and v of the kernel."""
        return self.length, self.speed
