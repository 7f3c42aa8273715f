"""Springs: forces that depend on the displacement alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from springpot.problem.parts.checks import coefficients, put, signed
from springpot.problem.parts.registration import Element, Number

__all__ = ["PolynomialSpring", "Spring"]

_POWERS = "They belong to x, x^2, x^3 and so on."
_MOST_POWERS = 9


@dataclass(frozen=True)
class Spring(Element):
    """A linear spring: the restoring force k x.

    Parameters
    ----------
    stiffness : float
        k in N/m, or k/m = Omega^2 in s^-2 in a system without a `Mass`.  A negative one pushes away from x = 0: a
        buckled beam or a magnet, which needs a stiffening spring or two walls beside it.

    Raises
    ------
    TypeError, ValueError
        If it is not a finite number.

    Examples
    --------
    >>> Spring(80.0)
    Spring(stiffness=80.0)
    """

    said, glyph, powers = "spring", "spring", ("stored",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True
    has_equivalent = True
    is_seen, is_of_paper = True, True

    stiffness: Annotated[
        float, Number("k", "stiffness", "N m-1", "signed", "It is the spring's force per displacement.")
    ]

    def force_coefficients(self) -> tuple[float, ...]:
        """0 and k."""
        return 0.0, self.stiffness

    def term(self) -> str:
        """Its force in the equation of motion."""
        return signed(self.stiffness, "x")


@dataclass(frozen=True)
class PolynomialSpring(Element):
    """A nonlinear spring: the restoring force k1 x + k2 x^2 + k3 x^3 + ...

    Parameters
    ----------
    coefficients : tuple of float
        (k1, k2, k3, ...), at most nine of them, in N/m, N/m^2, N/m^3 ..., beside those of any linear spring.  A Duffing
        oscillator has (0, 0, k3).

    Raises
    ------
    TypeError, ValueError
        If they are not finite numbers, too many, or all 0.

    Examples
    --------
    >>> PolynomialSpring((0.0, 0.0, 4e5)).term()
    ' + 400000 x^3'
    """

    said, glyph, powers = "polynomial spring", "spring", ("stored",)
    remembers, dissipates, is_thermal, has_equivalent = False, False, True, True
    is_seen = True

    coefficients: Annotated[tuple[float, ...], Number("k", "x", "N", "signed", per="m")]

    def __post_init__(self) -> None:
        super().__post_init__()
        put(self, coefficients=coefficients(self.coefficients, _MOST_POWERS, _POWERS))

    @property
    def is_linear(self) -> bool:
        """Whether only the first coefficient is not 0."""
        return not any(self.coefficients[1:])

    @property
    def is_of_paper(self) -> bool:
        """As a linear spring."""
        return self.is_linear

    @property
    def is_odd(self) -> bool:
        """Whether it has no even powers."""
        return not any(self.coefficients[1::2])

    def force_coefficients(self) -> tuple[float, ...]:
        """0 and its coefficients."""
        return 0.0, *self.coefficients

    def term(self) -> str:
        """Its force in the equation of motion."""
        powers = enumerate(self.coefficients, start=1)
        return "".join(signed(k, "x" if n == 1 else f"x^{n}") for n, k in powers if k != 0.0)
