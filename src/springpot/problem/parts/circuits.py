"""Circuits that a moving mass drives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from springpot.problem.parts.checks import Part, positive, put

__all__ = ["PiezoelectricCircuit"]


@dataclass(frozen=True)
class PiezoelectricCircuit(Part):
    """A piezoelectric element with a resistor across it.

    The element pulls on the mass with the force theta V, and Cp V' + V / R = theta x'.  The power V^2 / R is what a
    harvester delivers.

    Parameters
    ----------
    coupling : float
        theta > 0 in N/V, which is A s/m.
    resistance : float
        R > 0 in ohm.
    capacitance : float
        Cp > 0 in farad.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or not positive.

    Notes
    -----
    In a system without a `Mass` theta is that of the device over the root of its mass; powers are then per unit mass.

    Examples
    --------
    >>> PiezoelectricCircuit(coupling=1e-3, resistance=1e5, capacitance=1e-7).time
    0.01
    """

    coupling: float
    resistance: float
    capacitance: float

    def __post_init__(self) -> None:
        put(
            self,
            coupling=positive(self.coupling, "coupling", "It is theta in N/V."),
            resistance=positive(self.resistance, "resistance", "It is R in ohm."),
            capacitance=positive(self.capacitance, "capacitance", "It is Cp in farad."),
        )

    @property
    def time(self) -> float:
        """R Cp, in s."""
        return self.resistance * self.capacitance

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p: of a number or an array."""
        return self.coupling**2 / self.capacitance * p / (p + 1.0 / self.time)

    def per_mass(self, mass: float) -> PiezoelectricCircuit:
        """The same part of a system that is divided by its mass: the voltage is then over the root of the mass."""
        return replace(self, coupling=self.coupling / mass**0.5)

    def term(self) -> str:
        """Its force in the equation of motion."""
        return f" + {self.coupling:.6g} V"
