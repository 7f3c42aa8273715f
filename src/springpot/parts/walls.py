"""Walls: rigid barriers and soft contacts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from springpot.arguments import finite_number
from springpot.parts.checks import positive, put, real, unsigned

__all__ = ["Barrier", "Contact", "Side"]

Side = Literal["above", "below"]


@dataclass(frozen=True)
class Barrier:
    """A rigid, motionless wall and its impact law x'(+) = -r x'(-).

    Parameters
    ----------
    position : float
        Place b of the wall, in m, measured from the spring's equilibrium.
    restitution : float
        Coefficient r in (0, 1]: 1 for an elastic wall.
    side : {"above", "below"}
        The side on which the mass moves: ``"above"`` keeps x >= b (the paper's x = \\|y\\|), ``"below"`` keeps x <= b
        (the paper's Eq. 1 as printed).  The two are mirror images: x -> -x, b -> -b.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range, or ``side`` is another word.

    Examples
    --------
    >>> Barrier(position=-0.5, restitution=0.9)
    Barrier(position=-0.5, restitution=0.9, side='above')
    """

    position: float = 0.0
    restitution: float = 1.0
    side: Side = "above"

    def __post_init__(self) -> None:
        position = real(self.position, "position", "It is the position of the wall.")
        restitution = finite_number(
            self.restitution, "restitution", low=0.0, high=1.0, open_low=True, hint="An elastic wall has 1."
        )
        put(self, position=position, restitution=restitution)
        _check_side(self.side)

    def per_mass(self, mass: float) -> Barrier:
        """The same part of a system that is divided by its mass."""
        return self


@dataclass(frozen=True)
class Contact:
    """A soft stop: beyond its position it pushes back with k d^p (1 + chi d'), where d is the penetration.

    Parameters
    ----------
    position : float
        Where the mass first touches it, in m.
    stiffness : float
        k > 0, in N/m^p.
    exponent : float
        p from 1 (a linear stop) to 3; 1.5 is Hertz's contact of two spheres.
    dissipation : float
        chi >= 0 of Hunt and Crossley, in s/m.
    side : {"above", "below"}
        The side on which the mass moves while it is free.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range, or ``side`` is another word.

    Notes
    -----
    The force is not cut off at 0: where an outside force pulls the mass out faster than 1 / chi, the contact pulls.

    References
    ----------
    K. H. Hunt and F. R. E. Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", Journal of
    Applied Mechanics 42 (1975).

    Examples
    --------
    >>> Contact(position=-0.2, stiffness=50.0).exponent
    1.5
    """

    position: float
    stiffness: float
    exponent: float = 1.5
    dissipation: float = 0.0
    side: Side = "above"

    def __post_init__(self) -> None:
        put(
            self,
            position=real(self.position, "position", "It is where the mass first touches."),
            stiffness=positive(self.stiffness, "stiffness", "It is k of k d^exponent."),
            exponent=finite_number(
                self.exponent, "exponent", low=1.0, high=3.0, hint="A linear stop has 1, Hertz's contact 1.5."
            ),
            dissipation=unsigned(self.dissipation, "dissipation", "It is chi of k d^exponent (1 + chi d')."),
        )
        _check_side(self.side)

    def per_mass(self, mass: float) -> Contact:
        """The same part of a system that is divided by its mass."""
        return replace(self, stiffness=self.stiffness / mass)

    def term(self) -> str:
        """Its force in the equation of motion."""
        power = "" if self.exponent == 1.0 else f"^{self.exponent:g}"
        damping = f" (1 + {self.dissipation:.6g} d')" if self.dissipation else ""
        sign, depth = ("-", "b - x") if self.side == "above" else ("+", "x - b")
        return f" {sign} {self.stiffness:.6g} d{power}{damping} [d = {depth} > 0, b = {self.position:.6g}]"


def _check_side(side: object) -> None:
    if not isinstance(side, str) or side not in ("above", "below"):
        raise ValueError(f"side must be 'above' (the mass moves at x >= position) or 'below', not {side!r}.")
