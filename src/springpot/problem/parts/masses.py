"""The mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from springpot.problem.parts.registration import Number, Part

__all__ = ["Mass"]


@dataclass(frozen=True)
class Mass(Part):
    """The mass on the coordinate x.

    Without it, every other number of a system is per unit mass, as in `springpot.Oscillator`.

    Parameters
    ----------
    value : float
        m > 0, in kg.

    Raises
    ------
    TypeError, ValueError
        If it is not a positive finite number.

    Examples
    --------
    >>> Mass(0.2)
    Mass(value=0.2)
    """

    said, glyph, powers = "mass", "mass", ("inertia",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    value: Annotated[float, Number("m", "mass", "kg", "positive", "It is the mass in kg.")]

    @property
    def inertia(self) -> float:
        """The mass."""
        return self.value
