"""Circuits that a moving mass drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from springpot.problem.parts.registration import Element, Number, Slopes

__all__ = ["PiezoelectricCircuit"]


@dataclass(frozen=True)
class PiezoelectricCircuit(Element):
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

    said, glyph, powers = "piezoelectric circuit", "circuit", ("damping",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, True, True, True, True

    coupling: Annotated[float, Number("θ", "coupling", "N V-1", "positive", "It is theta in N/V.", mass=0.5)]
    resistance: Annotated[float, Number("R", "resistance", "ohm", "positive", "It is R in ohm.")]
    capacitance: Annotated[float, Number("Cp", "capacitance", "F", "positive", "It is Cp in farad.")]

    @property
    def together(self) -> PiezoelectricCircuit:
        """In parallel, so that the voltage is that of each."""
        n = self.count
        return self if n == 1 else PiezoelectricCircuit(
            n * self.coupling, self.resistance / n, n * self.capacitance, between=self.between
        )  # fmt: skip

    @property
    def time(self) -> float:
        """R Cp, in s."""
        return self.resistance * self.capacitance

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p: of a number or an array."""
        return self.coupling**2 / self.capacitance * p / (p + 1.0 / self.time)

    def slopes(self, p: Any) -> Slopes:
        """The derivatives of the modulus by the three numbers."""
        rate, found = 1.0 / self.time, self.modulus(p)
        turn = found * rate / (p + rate)  # -rate d/d rate
        return [
            (self.coupling, 2.0 * found / self.coupling),
            (self.resistance, turn / self.resistance),
            (self.capacitance, (turn - found) / self.capacitance),
        ]

    def line(self, name: str) -> str:
        """The equation of its voltage."""
        return (
            f"V ({name}): {self.capacitance:.6g} V' + V / {self.resistance:.6g} = {self.coupling:.6g} x', "
            f"R Cp = {self.time:.6g} s"
        )

    def term(self) -> str:
        """Its force in the equation of motion."""
        return f" + {self.coupling:.6g} V"
