"""Walls: rigid barriers and their laws of restitution."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, cast

from springpot.machine.arguments import finite_number
from springpot.machine.faults import shown
from springpot.problem.parts.checks import put
from springpot.problem.parts.registration import Element, Form, Law, Number

if TYPE_CHECKING:
    from springpot.machine.arrays import Floats

__all__ = [
    "Barrier", "PowerRestitution", "Restitution", "RestitutionLaw", "Side", "Stop",
    "restitution_at", "restitution_of_missed", "slow_restitution",
]  # fmt: skip

_SLOW = 1e-9  # m/s

Side = Literal["above", "below"]
RestitutionLaw = Callable[[float], float]
"""A function of the speed before an impact, in m/s, that Numba can compile."""


class Restitution(Form):
    """A law of restitution with numbers, with a ``law`` in files; its `words` have the speed v."""

    key, called, needed, known = "law", "law of restitution", ("formula", "words"), {}

    @staticmethod
    def formula(speed: float, *numbers: float) -> float:
        """r at a speed in m/s, of the fields in their order: a function that Numba can compile."""
        raise NotImplementedError

    def __call__(self, speed: float) -> float:
        """r at a speed in m/s."""
        return self.formula(speed, *self.values)

    @property
    def values(self) -> tuple[float, ...]:
        """Its numbers, in the order of its fields."""
        return tuple(getattr(self, name) for name in self.numbers)


@dataclass(frozen=True)
class PowerRestitution(Restitution):
    """A restitution that falls with the speed of the impact: r(v) = min(1, restitution (v / speed)^-exponent).

    Parameters
    ----------
    restitution : float
        r at ``speed``, in (0, 1].
    speed : float
        Of an impact, in m/s.
    exponent : float
        In (0, 1]; 1/4 is that of metals that yield.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    References
    ----------
    K. L. Johnson, *Contact Mechanics* (Cambridge, 1985), section 11.5.

    Examples
    --------
    >>> round(PowerRestitution(0.7, speed=0.1)(1.6), 12)
    0.35
    """

    restitution: Annotated[
        float, Number("r", "restitution at", "1", "share", "It is that of an impact at the speed given.")
    ]
    speed: Annotated[
        float, Number("v", "this speed", "m s-1", "positive", "It is the speed at which the restitution is that.")
    ]
    exponent: Annotated[float, Number("p", "falls with power", "1", "share", "Metals that yield have 1/4.")] = 0.25

    @staticmethod
    def formula(v: float, restitution: float, speed: float, exponent: float) -> float:  # type: ignore[override]
        """r at a speed v."""
        return min(1.0, restitution * (v / speed) ** -exponent) if v > 0.0 else 1.0

    def words(self) -> str:
        """The formula with its numbers."""
        return f"min(1, {self.restitution:.6g} (v / {self.speed:.6g})^-{self.exponent:g})"


class Stop(Element, abstract=True):
    """A wall or a contact.

    Attributes
    ----------
    position : float
    free_side : {"above", "below"}
    """

    if TYPE_CHECKING:
        position: float
        free_side: Side

    def __post_init__(self) -> None:
        super().__post_init__()
        put(self, free_side=_side_of(self.free_side, self.position))

    @property
    def inwards(self) -> float:
        """The sign of its force on the mass."""
        return 1.0 if self.free_side == "above" else -1.0

    def seen_from(self, origin: float) -> Self:
        """It is at its distance from there."""
        return replace(self, position=self.position - origin)  # type: ignore[call-arg]

    def mirrored(self) -> Self:
        """The same in the mirror, x -> -x."""
        other: Side = "below" if self.free_side == "above" else "above"
        return replace(self, position=-self.position, free_side=other)  # type: ignore[call-arg]


@dataclass(frozen=True)
class Barrier(Stop):
    """A rigid, motionless wall and its impact law x'(+) = -r x'(-).

    Parameters
    ----------
    position : float
        Place b of the wall, in m, measured from the spring's equilibrium.
    restitution : float, PowerRestitution or callable
        Coefficient r from 0, a plastic impact, to 1, an elastic wall.  In a `springpot.System` also a law r(v) of the
        speed v before the impact, in m/s: a function that Numba can compile; what it returns is cut off at 0 and 1.
    free_side : {"above", "below"}, optional
        The side of the wall on which the mass is free to move: ``"above"`` keeps x >= b (the paper's x = \\|y\\|),
        ``"below"`` keeps x <= b (the paper's Eq. 1 as printed).  The two are mirror images: x -> -x, b -> -b.  If it
        is not given, it is the side of x = 0, so that a gap is left: above a wall at b <= 0, below one at b > 0.  A
        preload needs it.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range, or ``free_side`` is another word.

    Examples
    --------
    >>> Barrier(position=-0.5, restitution=0.9), Barrier(0.5).free_side
    (Barrier(position=-0.5, restitution=0.9, free_side='above'), 'below')
    """

    said, glyph, powers = "wall", "stop", ("stop",)
    is_linear, remembers, is_thermal, is_odd, is_of_paper = False, False, True, False, True

    position: Annotated[float, Number("b", "position", "m", "signed", "It is the position of the wall.")] = 0.0
    restitution: Annotated[
        float | Restitution | RestitutionLaw, Number("r", "restitution", range="fraction", own=True)
    ] = 1.0
    free_side: Side = None  # type: ignore[assignment]  # not given, that of x = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if callable(self.restitution):
            _check_law(self.restitution)
        else:
            hint = "An elastic wall has 1, a plastic impact 0."
            put(self, restitution=finite_number(self.restitution, "restitution", low=0.0, high=1.0, hint=hint))

    @property
    def dissipates(self) -> bool:
        """Whether impacts take energy."""
        return not self.is_elastic

    @property
    def has_function(self) -> bool:
        """Whether its restitution is a function of the user."""
        return callable(self.restitution) and not isinstance(self.restitution, Restitution)

    @property
    def has_law(self) -> bool:
        """Whether its restitution depends on the speed."""
        return callable(self.restitution)

    @property
    def is_elastic(self) -> bool:
        """Whether no impact takes energy."""
        return self.restitution == 1.0

    def energy_beside(self, elongation: Floats) -> Any:
        """Infinite behind it."""
        import numpy as np  # here, so that the command starts quickly

        return np.where(self.inwards * (elongation - self.position) < 0.0, math.inf, 0.0)

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """What impacts at the usual speed take, of the flux of a normal velocity."""
        theta = law.temperature
        flux = law.density_at(self.position) * math.sqrt(theta / (2.0 * math.pi))
        return 0.0, flux * (1.0 - restitution_at(self, math.sqrt(2.0 * theta)) ** 2) * theta

    def line(self, name: str) -> str:
        """Where it stands and what it does."""
        relation = ">=" if self.free_side == "above" else "<="
        return f"wall ({name}): x {relation} {self.position:.6g} m, restitution {self.law()}"

    def law(self) -> str:
        """The restitution in words."""
        if isinstance(self.restitution, Restitution):
            return f"{self.restitution.words()} of the speed v"
        if callable(self.restitution):
            return f"{getattr(self.restitution, '__name__', 'a function')}(v) of the speed v"
        return f"{self.restitution:.6g}"


def restitution_at(wall: Barrier, speed: float) -> float:
    """The restitution of an impact at a speed in m/s, cut off at 0 and 1 as that of the kernel.

    Raises
    ------
    ValueError
        If a law returns no number there.

    Examples
    --------
    >>> restitution_at(Barrier(0.0, 0.8), 2.0), restitution_at(Barrier(0.0, PowerRestitution(0.5, 1.0)), 0.0)
    (0.8, 1.0)
    >>> restitution_at(Barrier(0.0, lambda speed: 1.0 - 0.5 * speed), 4.0)
    0.0
    """
    if not callable(wall.restitution):
        return wall.restitution
    value = float(wall.restitution(speed))
    if math.isnan(value):
        raise ValueError(f"restitution must be a number at every speed, but {wall.law()} is NaN at {speed:.6g} m/s.")
    return min(1.0, max(0.0, value))


def slow_restitution(wall: Barrier) -> float:
    """The restitution of impacts that are much slower than any that matter for the energy.

    Examples
    --------
    >>> slow_restitution(Barrier(0.0, lambda speed: 1.0 - 0.1 * speed**0.2)) > 0.99
    True
    """
    return restitution_at(wall, _SLOW)


def restitution_of_missed(wall: Barrier, intensity: float, step: float) -> float:
    """The restitution at the speed sqrt(q h) below which a step h misses impacts, for noise of intensity q in m^2/s^3.

    Examples
    --------
    >>> round(restitution_of_missed(Barrier(0.0, PowerRestitution(0.5, speed=0.1)), 1.0, 0.01), 12)
    0.5
    """
    return restitution_at(wall, math.sqrt(intensity * step))


def _check_law(law: RestitutionLaw) -> None:
    if isinstance(law, type):
        raise TypeError(f"restitution must be a number or a function of the speed, not the type {law.__name__}.")
    try:
        value = law(1.0)
    except Exception as fault:
        raise ValueError(
            f"restitution must be a function of the speed, but at 1 m/s it failed: {shown(fault)}."
        ) from fault
    finite_number(value, "restitution of an impact at 1 m/s", hint="A law of restitution returns r.")


def _side_of(given: object, position: float) -> Side:
    """The side on which the mass is free; not given, that of x = 0."""
    if given is None:
        return "below" if position > 0.0 else "above"
    if not isinstance(given, str) or given not in ("above", "below"):
        raise ValueError(f"free_side must be 'above' (the mass moves at x >= position) or 'below', not {shown(given)}.")
    return cast(Side, given)
