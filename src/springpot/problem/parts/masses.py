"""The mass."""

from __future__ import annotations

from dataclasses import dataclass

from springpot.problem.parts.checks import Part, positive, put

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

    value: float

    def __post_init__(self) -> None:
        put(self, value=positive(self.value, "value", "It is the mass in kg."))

    def per_mass(self, mass: float) -> Mass:
        """The same part of a system that is divided by its mass."""
        return Mass(self.value / mass)
