"""Elements with memory: the springpot, and springs in series with a springpot or a dashpot."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Protocol

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.faults import shown
from springpot.problem.parts.checks import Part, positive, put, signed
from springpot.problem.parts.springs import Spring

__all__ = ["FractionalMaxwell", "Maxwell", "Springpot", "resonance"]

_ROUNDS, _SETTLED = 500, 1e-14  # of the resonance


@dataclass(frozen=True)
class Springpot(Part):
    """The element with power-law memory: a force C D^alpha x.

    Parameters
    ----------
    order : float
        Order alpha of the derivative, in [0, 1]: a spring at 0, a dashpot at 1.
    coefficient : float
        C >= 0, in N s^alpha/m; per unit mass, as in an `springpot.Oscillator`, in s^(alpha - 2).

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    Examples
    --------
    >>> Springpot(order=0.5, coefficient=1.0)
    Springpot(order=0.5, coefficient=1.0)
    """

    order: float
    coefficient: float

    def __post_init__(self) -> None:
        order = finite_number(
            self.order, "order", low=0.0, high=1.0, hint="It runs from 0 (a spring) to 1 (a dashpot)."
        )
        coefficient = finite_number(
            self.coefficient,
            "coefficient",
            low=0.0,
            high=LARGEST,
            hint="It is the springpot's force per unit of D^alpha x.",
        )
        put(self, order=order, coefficient=coefficient)

    @property
    def dissipates(self) -> bool:
        """Whether it takes energy from the motion: not as a spring, and not with a coefficient of 0."""
        return self.order > 0.0 and self.coefficient > 0.0

    @property
    def remembers(self) -> bool:
        """Whether its force depends on the past motion: neither as a spring nor as a dashpot."""
        return self.dissipates and self.order < 1.0

    def per_mass(self, mass: float) -> Springpot:
        """The same part of a system that is divided by its mass."""
        return Springpot(self.order, self.coefficient / mass)

    def term(self) -> str:
        """Its force in the equation of motion."""
        return signed(self.coefficient, f"D^{self.order:.6g} x")

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p, C p^alpha: of a number or an array."""
        return self.coefficient * p**self.order


@dataclass(frozen=True)
class FractionalMaxwell(Part):
    """A springpot and a spring in series: the arm of the fractional Zener model.

    Parameters
    ----------
    springpot : Springpot
        Of an order and a coefficient above 0.
    spring : Spring
        Of positive stiffness.

    Raises
    ------
    TypeError, ValueError
        If a part is of another kind, or one of its numbers is 0 or negative.

    Notes
    -----
    Its modulus is k C p^alpha / (k + C p^alpha); the force of a jump in displacement relaxes like the Mittag-Leffler
    function k E_alpha(-(k/C) t^alpha).

    Examples
    --------
    >>> FractionalMaxwell(Springpot(0.5, 1.0), Spring(2.0)).modulus(1.0)
    0.6666666666666666
    """

    springpot: Springpot
    spring: Spring

    def __post_init__(self) -> None:
        if not isinstance(self.springpot, Springpot):
            raise TypeError(f"springpot must be a Springpot, not {shown(self.springpot)}.")
        if not isinstance(self.spring, Spring):
            raise TypeError(f"spring must be a Spring, not {shown(self.spring)}.")
        if not self.springpot.order > 0.0 or not self.springpot.coefficient > 0.0:
            raise ValueError(f"springpot must have an order and a coefficient above 0, not {shown(self.springpot)}.")
        if not self.spring.stiffness > 0.0:
            raise ValueError(f"spring must have a positive stiffness in a series, not {self.spring.stiffness:g}.")

    def per_mass(self, mass: float) -> FractionalMaxwell:
        """The same part of a system that is divided by its mass."""
        return FractionalMaxwell(self.springpot.per_mass(mass), self.spring.per_mass(mass))

    def term(self) -> str:
        """Its force in the equation of motion."""
        pot = self.springpot
        return f" + F[{self.spring.stiffness:.6g} in series with {pot.coefficient:.6g} D^{pot.order:.6g}]"

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p."""
        pot, k = self.springpot.modulus(p), self.spring.stiffness
        return k * pot / (k + pot)


@dataclass(frozen=True)
class Maxwell(Part):
    """A spring and a dashpot in series.

    Parameters
    ----------
    stiffness : float
        k > 0 in N/m.
    coefficient : float
        c > 0 in N s/m.  The force of a jump in displacement relaxes like k exp(-k t / c).

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or not positive.

    Examples
    --------
    >>> Maxwell(stiffness=2.0, coefficient=1.0).modulus(2.0)
    1.0
    """

    stiffness: float
    coefficient: float

    def __post_init__(self) -> None:
        put(
            self,
            stiffness=positive(self.stiffness, "stiffness", "It is the spring's force per displacement."),
            coefficient=positive(self.coefficient, "coefficient", "It is the damper's force per velocity."),
        )

    def per_mass(self, mass: float) -> Maxwell:
        """The same part of a system that is divided by its mass."""
        return Maxwell(self.stiffness / mass, self.coefficient / mass)

    def term(self) -> str:
        """Its force in the equation of motion."""
        return f" + F[{self.stiffness:.6g} in series with {self.coefficient:.6g} D]"

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p."""
        return self.stiffness * self.coefficient * p / (self.stiffness + self.coefficient * p)


class _Element(Protocol):
    def modulus(self, p: Any) -> Any: ...


def resonance(square: float, elements: Iterable[_Element]) -> float:
    """Frequency at which springs and elements with memory together swing a unit mass, in rad/s.

    The root w of w^2 = square + Re K(iw), with K the modulus of all elements.  ``square`` is the stiffness of the
    springs over the mass, and must be positive.

    Examples
    --------
    >>> round(resonance(1.0, [Springpot(0.5, 1.0)]), 4)
    1.3496
    """
    elements, found = tuple(elements), square
    for _ in range(_ROUNDS):  # from below: of several roots that nearest to the springs' own; contracts by order / 2
        before, p = found, 1j * math.sqrt(found)
        found = square + math.fsum(element.modulus(p).real for element in elements)
        if abs(found - before) <= _SETTLED * found:
            break
    return math.sqrt(found)
