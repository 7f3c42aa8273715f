"""The kernel's units."""

from __future__ import annotations

import math
from dataclasses import dataclass

from springpot.simulation.kernel.block import COLUMNS


@dataclass(frozen=True)
class Units:
    """The kernel's units, and whether the motion is mirrored.

    Attributes
    ----------
    length, time : float
        In m and s.
    sign : float
        -1 if the motion is mirrored, otherwise 1.
    origin : float
        In m, from which the kernel measures x: the rest of the springs under a constant force.
    """

    length: float
    time: float
    sign: float
    origin: float = 0.0

    @classmethod
    def near(cls, length: float, fastest: float, sign: float = 1.0, origin: float = 0.0) -> Units:
        """Powers of two near a length and the time of a rate."""
        near = 2.0 ** round(math.log2(length)) if length > 0.0 else 1.0
        return cls(near, 2.0 ** round(-math.log2(fastest)), sign, origin)

    @property
    def speed(self) -> float:
        """In m/s."""
        return self.length / self.time

    def into(self, x: float, v: float) -> tuple[float, float]:
        """A state in the kernel's units, from one in m and m/s."""
        return self.sign * (x - self.origin) / self.length, self.sign * v / self.length * self.time

    @property
    def shift(self) -> float:
        """The origin in the kernel's units: added to its x it gives what observers see."""
        return self.sign * self.origin / self.length

    @property
    def state(self) -> tuple[float, float]:
        """Factors for x and v of the kernel."""
        return self.sign * self.length, self.sign * self.speed

    @property
    def columns(self) -> list[float]:
        """Factors for the COLUMNS of the kernel."""
        (x, v), square = self.state, self.speed**2
        force, power = v / self.time, square / self.time
        units = {
            "x": x, "x_square": self.length**2, "v_square": square, "force": force, "power": power, "virial": square,
            "impacts": 1.0, "impact_speeds": self.speed, "impact_speed_squares": square, "collapses": 1.0,
            "energy_first": square, "energy_last": square, "x_end": x, "v_end": v,
            "x_square_early": self.length**2, "v_square_early": square,
        }  # fmt: skip
        return [units[name] for name in COLUMNS]
