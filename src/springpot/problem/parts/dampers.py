"""Dampers: forces that depend on the present velocity."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any

from springpot.problem.parts.checks import coefficients, put, signed
from springpot.problem.parts.registration import Cycles, Element, Law, Number, Part

__all__ = ["Dashpot", "Friction", "PolynomialDashpot", "VanDerPol"]


@dataclass(frozen=True)
class Dashpot(Element):
    """A linear damper: the force c v.

    Parameters
    ----------
    coefficient : float
        c >= 0 in N s/m, or in 1/s in a system without a `Mass`.

    Raises
    ------
    TypeError, ValueError
        If it is not a number, not finite or negative.

    Examples
    --------
    >>> Dashpot(0.5).term()
    " + 0.5 x'"
    """

    said, glyph, powers = "dashpot", "dashpot", ("damping",)
    is_linear, remembers, is_thermal, is_odd = True, False, True, True
    has_equivalent, is_seen, is_of_paper = True, True, True

    coefficient: Annotated[
        float, Number("c", "coefficient", "N s m-1", "unsigned", "It is the damper's force per velocity.")
    ]

    @property
    def dissipates(self) -> bool:
        """Whether its coefficient is not 0."""
        return self.coefficient > 0.0

    def damping_coefficients(self) -> tuple[float, ...]:
        """c."""
        return (self.coefficient,)

    @property
    def slow_springpot(self) -> tuple[float, float]:
        """Itself: of order 1."""
        return 1.0, self.coefficient

    def slowed(self, factor: float) -> Dashpot:
        """A stronger one."""
        return replace(self, coefficient=self.coefficient * factor)

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """c <v^2>."""
        return self.coefficient, 0.0

    def fastest_rate(self, law: Law) -> float:
        """c."""
        return self.coefficient

    def strongest_damping(self, spread: float, speed: float) -> float:
        """c."""
        return float(self.coefficient)

    def measure(self, name: str, frequency: float, resonance: float, own: Part) -> str:
        """Its damping ratio."""
        return f"damping ratio of {name}: {self.coefficient / (2.0 * frequency):.6g}"

    def term(self) -> str:
        """Its force in the equation of motion."""
        return signed(self.coefficient, "x'")


@dataclass(frozen=True)
class PolynomialDashpot(Element):
    """A nonlinear damper: the force c1 v + c2 v abs(v) + c3 v^3.

    Parameters
    ----------
    coefficients : tuple of float
        (c1, c2, c3), or fewer, in N s/m, N s^2/m^2, N s^3/m^3.  The last one must not be negative: a damper that feeds
        the motion at high speed has no stationary state.

    Raises
    ------
    TypeError, ValueError
        If they are not finite numbers, too many, all 0, or the last one that is not 0 is negative.

    Examples
    --------
    >>> PolynomialDashpot((0.0, 2.0)).term()
    " + 2 x'|x'|"
    """

    said, glyph, powers = "polynomial dashpot", "dashpot", ("damping", "taken")
    remembers, dissipates, is_odd, has_equivalent = False, True, True, True

    coefficients: Annotated[tuple[float, ...], Number("c", "v", "N", "signed", per="m s-1")]

    def __post_init__(self) -> None:
        super().__post_init__()
        put(self, coefficients=coefficients(self.coefficients, 3, "They belong to v, v|v| and v^3."))
        last = [c for c in self.coefficients if c != 0.0][-1]
        if last < 0.0:
            raise ValueError(
                f"coefficients must not end with {last:g}, which adds energy to fast motion: nothing limits the speed."
            )

    @property
    def is_linear(self) -> bool:
        """Whether only the first coefficient is not 0."""
        return not any(self.coefficients[1:])

    @property
    def is_of_paper(self) -> bool:
        """As a linear damper."""
        return self.is_linear

    @property
    def is_seen(self) -> bool:
        """As a linear damper."""
        return self.is_linear

    @property
    def is_thermal(self) -> bool:
        """A temperature alone does not determine the noise of a nonlinear one."""
        return self.is_linear

    def damping_coefficients(self) -> tuple[float, ...]:
        """Its own."""
        return self.coefficients

    @property
    def is_rough(self) -> bool:
        """Whether it is not linear."""
        return not self.is_linear

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """Of a normal velocity: c1 <v^2>, and c2 <abs(v)^3> + c3 <v^4> beside."""
        c1, c2, c3 = (*self.coefficients, 0.0, 0.0)[:3]
        return c1, c2 * math.sqrt(8.0 / math.pi) * law.temperature**1.5 + 3.0 * c3 * law.temperature**2

    def fed_beside(self, law: Law) -> float:
        """Of the terms that are negative."""
        c1, c2, _ = (*self.coefficients, 0.0, 0.0)[:3]
        theta = law.temperature
        return float(max(-c1, 0.0) * theta + max(-c2, 0.0) * math.sqrt(8.0 / math.pi) * theta**1.5)

    def fastest_rate(self, law: Law) -> float:
        """That of all that it takes and feeds in."""
        return _strongest_rate(self, law)

    def damping_beside(self, spread: float, speed: float, reduced: float) -> float:
        """Of c2 and c3."""
        _, c2, c3 = (*self.coefficients, 0.0, 0.0)[:3]
        return math.sqrt(8.0 / math.pi) * c2 * speed + 3.0 * c3 * speed**2

    def strongest_damping(self, spread: float, speed: float) -> float:
        """With all terms positive."""
        positive = PolynomialDashpot(tuple(abs(c) for c in self.coefficients)) if self.is_rough else self
        return positive.linear_damping + (positive.damping_beside(spread, speed, 1.0) if self.is_rough else 0.0)

    def term(self) -> str:
        """Its force in the equation of motion."""
        powers = zip(self.coefficients, ("x'", "x'|x'|", "x'^3"), strict=False)
        return "".join(signed(c, symbol) for c, symbol in powers if c != 0.0)


@dataclass(frozen=True)
class VanDerPol(Element):
    """A damper that feeds small motions and damps large ones: the force mu (x^2 - l^2) v.

    Parameters
    ----------
    coefficient : float
        mu > 0 in N s/m^3.
    length : float
        l > 0 in m: the displacement at which the damping changes sign.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or not positive.

    Examples
    --------
    >>> VanDerPol(0.1).term()
    " + 0.1 (x^2 - 1) x'"
    """

    said, glyph, powers = "van der pol", "dashpot", ("taken",)
    is_linear, remembers, dissipates, is_thermal, is_odd = False, False, True, False, True
    has_equivalent, is_placed, feeds, is_rough = True, True, True, True

    coefficient: Annotated[
        float, Number("μ", "coefficient", "N s m-3", "positive", "It is mu of mu (x^2 - length^2) v.")
    ]
    length: Annotated[float, Number("l", "length", "m", "positive", "It is where the damping changes sign.")] = 1.0

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """mu (<x^2> - l^2) <v^2>."""
        return self.coefficient * (law.variance + law.mean**2 - self.length**2), 0.0

    def fed_beside(self, law: Law) -> float:
        """mu l^2 <v^2>."""
        return float(self.coefficient * self.length**2 * law.temperature)

    def fastest_rate(self, law: Law) -> float:
        """That of all that it takes and feeds in."""
        return _strongest_rate(self, law)

    def damping_beside(self, spread: float, speed: float, reduced: float) -> float:
        """mu (<x^2> - l^2)."""
        return float(self.coefficient * (spread**2 - self.length**2))

    def strongest_damping(self, spread: float, speed: float) -> float:
        """mu (<x^2> + l^2)."""
        return float(self.coefficient * (spread**2 + self.length**2))

    def equivalent_damping(self, mean: float, spread: float, speed: float) -> float:
        """mu (<x^2> - l^2)."""
        return self.coefficient * (mean * mean + spread**2 - self.length**2)

    def force_beside(self, x: Any, v: Any) -> Any:
        """All of it."""
        return self.coefficient * (x * x - self.length**2) * v

    def power_beside(self, cycles: Cycles) -> Any:
        """That of all of it."""
        return self.coefficient * (cycles.xv_square - self.length**2 * cycles.v_square)

    def term(self) -> str:
        """Its force in the equation of motion."""
        return f" + {self.coefficient:.6g} (x^2 - {self.length**2:.6g}) x'"


@dataclass(frozen=True)
class Friction(Element):
    """Dry (Coulomb) friction: a force of constant size against the velocity, which also holds the mass at rest.

    Parameters
    ----------
    force : float
        F >= 0 in N; per unit mass in m/s^2.

    Raises
    ------
    TypeError, ValueError
        If it is not a number, not finite or negative.

    Notes
    -----
    In a simulation of step h a mass that sticks still creeps, with a time constant of 2 / (Omega^2 h): the spring moves
    it between the kicks.

    Examples
    --------
    >>> Friction(0.2).term()
    " + 0.2 sgn(x')"
    """

    said, glyph, powers = "friction", "friction", ("taken",)
    is_linear, remembers, dissipates, is_thermal, is_odd, is_rough = False, False, True, False, True, True

    force: Annotated[float, Number("F", "force", "N", "unsigned", "It is the size of the friction.")]

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """F <abs(v)> of a normal velocity."""
        return 0.0, self.force * math.sqrt(2.0 * law.temperature / math.pi)

    def damping_beside(self, spread: float, speed: float, reduced: float) -> float:
        """F <abs(v)> over <v^2>."""
        return math.sqrt(2.0 / math.pi) * self.force / max(speed, 1e-300)

    def term(self) -> str:
        """Its force in the equation of motion."""
        return signed(self.force, "sgn(x')")


def _strongest_rate(damper: Element, law: Law) -> float:
    """Power taken and fed in, both counted, over the temperature."""
    rate, power = damper.taken_from(law, law.frequency)
    return (rate * law.temperature + power + 2.0 * damper.fed_beside(law)) / law.temperature
