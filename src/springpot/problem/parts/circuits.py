"""Circuits that a moving mass drives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Self

from springpot.problem.parts.registration import Element, Law, Number, Slopes

__all__ = ["PiezoelectricCircuit", "ResonantCircuit"]


@dataclass(frozen=True)
class Circuit(Element, abstract=True):
    """A piezoelectric element, across which a load draws a current.

    Attributes
    ----------
    of_load : {"voltage", "current"}
        Whose mean square over ``load`` is the power of the load.
    """

    is_linear, remembers, dissipates, is_thermal, is_odd, has_modulus = True, True, True, True, True, True
    is_seen = True

    coupling: Annotated[float, Number("θ", "coupling", "N V-1", "positive", "It is theta in N/V.", mass=0.5)]
    resistance: Annotated[float, Number("R", "resistance", "ohm", "positive", "It is R in ohm.")]
    capacitance: Annotated[float, Number("Cp", "capacitance", "F", "positive", "It is Cp in farad.")]

    @property
    def load(self) -> float:
        """By which that mean square is divided."""
        raise NotImplementedError

    def load_square(self, w: float) -> float:
        """That square over the one of x, at a frequency."""
        raise NotImplementedError

    @property
    def stiffness_at_once(self) -> float:
        """theta^2 / Cp."""
        return self.coupling**2 / self.capacitance

    @property
    def slow_springpot(self) -> tuple[float, float]:
        """The dashpot theta^2 R."""
        return 1.0, self.coupling**2 * self.resistance

    @property
    def together(self) -> Self:
        """In parallel, so that the voltage is that of each."""
        n = self.count
        if n == 1:
            return self
        numbers = {name: getattr(self, name) for name, number in self.numbers.items() if number}
        larger = "coupling", "capacitance"
        return type(self)(
            **{name: n * value if name in larger else value / n for name, value in numbers.items()},
            between=self.between,
        )

    def term(self) -> str:
        """Its force in the equation of motion."""
        return f" + {self.coupling:.6g} V"


@dataclass(frozen=True)
class PiezoelectricCircuit(Circuit):
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
    of_load = "voltage"

    @property
    def time(self) -> float:
        """R Cp, in s."""
        return self.resistance * self.capacitance

    @property
    def relaxation(self) -> tuple[float, float]:
        """Those of theta^2 / Cp and R Cp."""
        return self.coupling**2 / self.capacitance, 1.0 / self.time

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """Where it begins to hold, and where it does."""
        return [1.0 / self.time, math.sqrt(stiffness + self.coupling**2 / self.capacitance * share)]

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

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """Im k(i w) / w."""
        return self.coupling**2 / self.capacitance * self.time / (1.0 + (frequency * self.time) ** 2), 0.0

    def load_square(self, w: float) -> float:
        """The square of V / x, at a frequency."""
        return (self.coupling / self.capacitance * w) ** 2 / (w * w + 1.0 / self.time**2)

    @property
    def load(self) -> float:
        """R: the power is V^2 / R."""
        return self.resistance


@dataclass(frozen=True)
class ResonantCircuit(Circuit):
    """A piezoelectric element with a coil and a resistor in series across it.

    The element pulls on the mass with the force theta V.  Cp V' = theta x' - I and L I' + R I = V; the power R I^2 is
    what a harvester delivers, or what a resonant shunt takes.

    Parameters
    ----------
    coupling : float
        theta > 0 in N/V, which is A s/m.
    resistance : float
        R > 0 in ohm, that of the coil included.
    capacitance : float
        Cp > 0 in farad.
    inductance : float
        L > 0 in henry.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or not positive.

    Notes
    -----
    For a mass it is a second mass theta^2 L behind a spring theta^2 / Cp, with a dashpot theta^2 R to the ground, which
    moves by the charge of the coil over theta.  The coil of an electromagnetic harvester, K x' = L I' + R I with the
    force K I, is a `PiezoelectricCircuit` with the coupling K, the resistance 1 / R and the capacitance L.

    References
    ----------
    N. W. Hagood and A. von Flotow, "Damping of structural vibrations with piezoelectric materials and passive
    electrical networks", Journal of Sound and Vibration 146 (1991).

    Examples
    --------
    >>> round(ResonantCircuit(coupling=1e-3, resistance=1e3, capacitance=1e-7, inductance=10.0).frequency, 6)
    1000.0
    """

    said, glyph, powers = "resonant circuit", "circuit", ("damping",)
    of_load = "current"

    inductance: Annotated[float, Number("L", "inductance", "H", "positive", "It is L in henry.")]

    @property
    def frequency(self) -> float:
        """1 / sqrt(L Cp), in rad/s."""
        return 1.0 / math.sqrt(self.inductance * self.capacitance)

    @property
    def rate(self) -> float:
        """R / L, in 1/s, at which the energy of the free circuit decays."""
        return self.resistance / self.inductance

    @property
    def rate_of_its_own(self) -> float:
        """Its frequency."""
        return self.frequency

    @property
    def time_of_its_own(self) -> float:
        """That of the slower of its two motions.

        Examples
        --------
        >>> ResonantCircuit(1.0, 0.1, 0.5, 0.5).time_of_its_own
        5.0
        """
        half = 0.5 * self.rate
        slower = self.frequency**2 / (half + math.sqrt(max(half**2 - self.frequency**2, 0.0)))
        return 0.5 / min(half, slower)

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """Its own, and those of the mass while the circuit is open and closed."""
        w, stiffened = self.frequency, stiffness + self.coupling**2 / self.capacitance * share
        return [w, self.rate, w * w / self.rate, math.sqrt(stiffened), math.sqrt(stiffened + w * w)]

    def _closed(self, p: Any) -> Any:
        """theta p over the current that x drives."""
        return 1.0 + self.capacitance * p * (self.resistance + self.inductance * p)

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p: of a number or an array."""
        return self.coupling**2 * p * (self.resistance + self.inductance * p) / self._closed(p)

    def slopes(self, p: Any) -> Slopes:
        """The derivatives of the modulus by the four numbers."""
        found, by_resistance = self.modulus(p), self.coupling**2 * p / self._closed(p) ** 2
        return [
            (self.coupling, 2.0 * found / self.coupling),
            (self.resistance, by_resistance),
            (self.capacitance, -((found / self.coupling) ** 2)),
            (self.inductance, by_resistance * p),
        ]

    def load_square(self, w: float) -> float:
        """The square of I / x, at a frequency."""
        return float(abs(self.coupling * w / self._closed(1j * w)) ** 2)

    @property
    def load(self) -> float:
        """1 / R: the power is R I^2."""
        return 1.0 / self.resistance

    def line(self, name: str) -> str:
        """The equations of its voltage and current."""
        return (
            f"V ({name}): {self.capacitance:.6g} V' = {self.coupling:.6g} x' - I, {self.inductance:.6g} I' + "
            f"{self.resistance:.6g} I = V, 1/sqrt(L Cp) = {self.frequency:.6g} rad/s"
        )
