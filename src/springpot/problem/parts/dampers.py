"""Dampers: forces that depend on the present velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from springpot.problem.parts.checks import coefficients, put, signed
from springpot.problem.parts.registration import Element, Number, Part

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

    coefficient: Annotated[
        float, Number("c", "coefficient", "N s m-1", "unsigned", "It is the damper's force per velocity.")
    ]

    @property
    def dissipates(self) -> bool:
        """Whether its coefficient is not 0."""
        return self.coefficient > 0.0

    @property
    def linear_damping(self) -> float:
        """c."""
        return self.coefficient

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
    remembers, dissipates, is_odd = False, True, True

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
    def is_thermal(self) -> bool:
        """A temperature alone does not determine the noise of a nonlinear one."""
        return self.is_linear

    @property
    def linear_damping(self) -> float:
        """c1."""
        return self.coefficients[0]

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

    coefficient: Annotated[
        float, Number("μ", "coefficient", "N s m-3", "positive", "It is mu of mu (x^2 - length^2) v.")
    ]
    length: Annotated[float, Number("l", "length", "m", "positive", "It is where the damping changes sign.")] = 1.0

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
    is_linear, remembers, dissipates, is_thermal, is_odd = False, False, True, False, True

    force: Annotated[float, Number("F", "force", "N", "unsigned", "It is the size of the friction.")]

    def term(self) -> str:
        """Its force in the equation of motion."""
        return signed(self.force, "sgn(x')")
