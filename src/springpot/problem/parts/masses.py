"""Inertia: masses, inerters, and points that move as combinations of masses do."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

from springpot.machine.arguments import checked_name, items_of
from springpot.machine.faults import shown
from springpot.problem.parts.checks import put, real, signed
from springpot.problem.parts.registration import Element, Names, Number, Part, PointName

__all__ = ["Inerter", "Mass", "Point"]


@dataclass(frozen=True)
class Mass(Part):
    """The mass on the coordinate x, or one of several masses.

    Without one, every other number of a system is per unit mass, as in `springpot.Oscillator`.

    Parameters
    ----------
    value : float
        m > 0, in kg.
    at : str, optional
        The name of the point that it is, which parts are `between` and excitations are `on`.  Needed where there are
        several masses.
    participation : float, optional
        Of a mode, where a `Point` says how it moves: how far it moves where everything moves by 1, as on the ground.
        An acceleration of the ground acts on it as a force of -participation times the mass.

    Raises
    ------
    TypeError, ValueError
        If it is not a positive finite number.

    Examples
    --------
    >>> Mass(0.2)
    Mass(value=0.2)
    >>> Mass(0.2, at="box").at
    'box'
    """

    said, glyph, powers = "mass", "mass", ("inertia",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    value: Annotated[float, Number("m", "mass", "kg", "positive", "It is the mass in kg.")]
    at: PointName = field(default="", repr=False, kw_only=True)
    participation: Annotated[float, Number("p", "participation", "1", "signed")] = field(
        default=1.0, repr=False, kw_only=True
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.at, str) or self.at:
            _check_name(self.at, "mass")

    @property
    def inertia(self) -> float:
        """The mass."""
        return self.value


@dataclass(frozen=True)
class Inerter(Element):
    """A force of inertia between two ends: b times the second derivative of the elongation.

    The ground accelerates the masses alone: an inerter sees what its ends do relative to each other.

    Parameters
    ----------
    inertance : float
        b >= 0, in kg, or over the mass in a system without a `Mass`.

    Raises
    ------
    TypeError, ValueError
        If it is negative or not a finite number.

    Examples
    --------
    >>> Inerter(0.3).term()
    " + 0.3 x''"
    """

    said, glyph, powers = "inerter", "inerter", ("inertia",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    inertance: Annotated[float, Number("b", "inertance", "kg", "unsigned", "It is the force per acceleration, in kg.")]

    @property
    def inertia(self) -> float:
        """The inertance."""
        return self.inertance

    def term(self) -> str:
        """Its force in the equation of motion."""
        return signed(self.inertance, "x''")


@dataclass(frozen=True)
class Point(Part):
    """A point that moves as a combination of masses does: parts act there, and its motion is a result.

    Parameters
    ----------
    at : str
        Its name, which parts are `between` and excitations are `on`.
    of : tuple of str
        The names of masses, or of the modes that are masses.
    shares : tuple of float
        Its displacement where one of them moves by 1 alone; of a mode the value of its shape there.

    Raises
    ------
    TypeError, ValueError
        If a name or a number is none, or there is not one share for each mass.

    Examples
    --------
    The middle of a rigid bar between two masses:

    >>> Point("middle", ("left", "right"), (0.5, 0.5))
    Point(at='middle', of=('left', 'right'), shares=(0.5, 0.5))
    """

    said, glyph, powers = "point", "mass", ("inertia",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    at: PointName
    of: Names
    shares: Annotated[tuple[float, ...], Number("s", "share of a mass", "1", "signed", per="1")]

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_name(self.at, "point")
        of, shares = _all("of", self.of, "names of masses"), _all("shares", self.shares, "numbers")
        for name in of:
            if not isinstance(name, str) or of.count(name) > 1:
                raise ValueError(f"of must be the names of different masses, not {shown(self.of)}.")
        if len(shares) != len(of):
            raise ValueError(f"shares must be a number for each of the {len(of)} masses in of, not {len(shares)}.")
        put(self, of=of, shares=tuple(real(s, f"shares[{n}]", "It is a displacement.") for n, s in enumerate(shares)))
        if not any(self.shares):
            raise ValueError("shares must not all be 0: the point would never move.")

    @property
    def inertia(self) -> float:
        """None."""
        return 0.0

    def line(self, name: str) -> str:
        """How its displacement is made of those of masses."""
        sum_of = "".join(signed(s, f"x_{mass}") for s, mass in zip(self.shares, self.of, strict=True))
        return f"point ({name}): x_{self.at} = {sum_of.strip().removeprefix('+ ')}"


def _check_name(at: object, kind: str) -> None:
    wanted = f"be a name for the {kind}, of letters, digits and _, other than 'ground' and 'mass'"
    if checked_name(at, "at", wanted) in ("ground", "mass"):
        raise ValueError(f"at must {wanted}, not {at!r}.")


def _all(name: str, given: Any, words: str) -> tuple[Any, ...]:
    if not (items := items_of(given, f"{name} must be a tuple of {words}")):
        raise ValueError(f"{name} must be a tuple of {words}, at least one.")
    return items
