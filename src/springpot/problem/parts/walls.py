"""Walls: rigid barriers and soft contacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, cast

from springpot.machine.arguments import LARGEST, check_plain, finite_number
from springpot.machine.faults import listed, shown
from springpot.machine.without_scipy import root_between
from springpot.problem.parts.checks import Checked, put
from springpot.problem.parts.registration import Element, Law, Number, check, kind_of, stated_numbers

if TYPE_CHECKING:
    from springpot.machine.arrays import Floats

__all__ = [
    "Barrier", "Contact", "PowerRestitution", "Restitution", "RestitutionLaw", "Side", "SoftStop", "Stop",
    "restitution_at", "restitution_of_missed", "slow_restitution",
]  # fmt: skip

_SLOW = 1e-9  # m/s
_WEAK = 1e-3  # chi v, to which the series of the restitution is right to 1e-12

Side = Literal["above", "below"]
RestitutionLaw = Callable[[float], float]
"""A function of the speed before an impact, in m/s, that Numba can compile."""


class Restitution(Checked):
    """A law of restitution with numbers: what it states beside its fields, as a `Part` does.

    In a file it is a table of its numbers with a ``law``, its name.
    """

    laws: ClassVar[dict[str, type[Restitution]]] = {}
    numbers: ClassVar[dict[str, Any]]

    def __init_subclass__(cls) -> None:
        if missing := [name for name in ("formula", "words") if getattr(cls, name) is getattr(Restitution, name)]:
            raise TypeError(f"{cls.__name__} must state {listed(missing)}, as every law of restitution does.")
        cls.numbers = stated_numbers(cls)
        name = kind_of(cls).removesuffix("_restitution")
        cls.tag, Restitution.laws[name] = {"law": name}, cls

    @staticmethod
    def formula(speed: float, *numbers: float) -> float:
        """r at a speed in m/s, of the fields in their order: a function that Numba can compile."""
        raise NotImplementedError

    def __post_init__(self) -> None:
        check(self)

    def __call__(self, speed: float) -> float:
        """r at a speed in m/s."""
        return self.formula(speed, *self.values)

    @property
    def values(self) -> tuple[float, ...]:
        """Its numbers, in the order of its fields."""
        return tuple(getattr(self, name) for name in self.numbers)

    def words(self) -> str:
        """The formula with its numbers, of the speed v."""
        raise NotImplementedError


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


class SoftStop(Stop, abstract=True):
    """A stop with a force, which its `soft_stop` has without what it dissipates."""

    beside = ("soft_stop",)


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


@dataclass(frozen=True)
class Contact(SoftStop):
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
    free_side : {"above", "below"}, optional
        The side on which the mass moves without touching it; that of x = 0 if it is not given, as of a `Barrier`.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range, or ``free_side`` is another word.

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
    >>> Contact.linear(position=-0.2, stiffness=50.0).exponent
    1.0
    """

    said, glyph, powers = "soft contact", "stop", ("stop",)
    is_linear, remembers, is_odd, is_seen = False, False, False, True

    position: Annotated[float, Number("b", "position", "m", "signed", "It is where the mass first touches.")]
    stiffness: Annotated[float, Number("k", "stiffness", "N m^-exponent", "positive", "It is k of k d^exponent.")]
    exponent: Annotated[
        float, Number("p", "exponent", "1", "exponent", "A linear stop has 1, Hertz's contact 1.5.")
    ] = 1.5
    dissipation: Annotated[
        float, Number("χ", "dissipation", "s m-1", "unsigned", "It is chi of k d^exponent (1 + chi d').")
    ] = 0.0
    free_side: Side = None  # type: ignore[assignment]  # not given, that of x = 0

    def energy_beside(self, elongation: Floats) -> Any:
        """k d^(p + 1) / (p + 1)."""
        import numpy as np  # here, so that the command starts quickly

        depth = np.maximum(self.inwards * (self.position - elongation), 0.0)
        return self.stiffness * depth ** (self.exponent + 1.0) / (self.exponent + 1.0)

    def fastest_touch(self, reduced: float, speed: float) -> float:
        """Rate of the linear spring as stiff as it is where a mass is deepest in it that touches it at a speed."""
        power = self.exponent + 1.0
        depth = (0.5 * power * reduced * speed**2 / self.stiffness) ** (1.0 / power)
        return math.sqrt(self.exponent * self.stiffness * depth ** (self.exponent - 1.0) / reduced)

    def stop_rate(self, reduced: float, speed: float) -> float:
        """At which its dissipation alone stops a mass that touches it at a speed, m v dv/dd = -k d^p chi v.

        A longer step is stable, but off.
        """
        power = self.exponent + 1.0
        stop = (self.stiffness * self.dissipation / (power * reduced)) ** (1.0 / power)
        return float(stop * speed ** (1.0 - 1.0 / power))

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """k <d^p> chi <v^2>."""

        def pushed(x: Any) -> Any:
            depth = self.inwards * (self.position - x)
            return (0.5 * (abs(depth) + depth)) ** self.exponent

        return self.dissipation * self.stiffness * law.mean_of(pushed), 0.0

    @classmethod
    def linear(cls, position: float, stiffness: float, **others: Any) -> Contact:
        """A linear stop, as of finite element programs: of exponent 1.

        Parameters
        ----------
        position : float
            Where the mass first touches it, in m.
        stiffness : float
            k > 0, in N/m.
        **others
            ``dissipation`` and ``free_side``, and what every part takes: ``between``, ``count``, ``group``.

        Returns
        -------
        Contact

        Raises
        ------
        TypeError, ValueError
            As `Contact`.

        Examples
        --------
        >>> Contact.linear(0.004, 1e6)
        Contact(position=0.004, stiffness=1000000.0, exponent=1.0, dissipation=0.0, free_side='below')
        """
        return cls(position, stiffness, exponent=1.0, **others)

    @staticmethod
    def dissipation_of(restitution: float, speed: float) -> float:
        """The dissipation chi, in s/m, with which an impact at a speed has a measured restitution.

        Parameters
        ----------
        restitution : float
            Speed after the impact over that before, in (0, 1].
        speed : float
            Before the impact, in m/s.

        Raises
        ------
        TypeError, ValueError
            If a number is none or out of its range.

        Notes
        -----
        The inverse of `restitution_at`; a fast impact loses more than a slow one.

        Examples
        --------
        >>> chi = Contact.dissipation_of(0.8, speed=0.5)
        >>> round(chi, 4), round(Contact(0.0, 1e6, dissipation=chi).restitution_at(0.5), 9)
        (0.7463, 0.8)
        """
        check_plain(restitution, "restitution", "mark the dissipation of the contact instead")
        r = finite_number(restitution, "restitution", low=0.0, high=1.0, open_low=True, hint="Elastic is 1.")
        v = finite_number(speed, "speed", low=0.0, high=LARGEST, open_low=True, hint="It is in m/s.")
        if r == 1.0:
            return 0.0
        return root_between(lambda strength: _restitution_of(strength) - r, 0.0, 1.0 / r) / v

    def restitution_at(self, speed: float) -> float:
        """The restitution of an impact at a speed, while the contact alone acts.

        Parameters
        ----------
        speed : float
            Before the impact, in m/s.

        Returns
        -------
        float
            Speed after the impact over that before.

        Raises
        ------
        TypeError, ValueError
            If the speed is no number above 0.

        Notes
        -----
        From m d'' = -k d^p (1 + chi d') follows m v dv / (1 + chi v) = -k d^p dd, of which the integrals on the way in
        and out are equal:

            (1 + r) chi v = ln[(1 + chi v) / (1 - r chi v)].

        Neither mass nor stiffness nor exponent matter.  Of slow impacts r = 1 - 2 chi v / 3, which Hunt and Crossley
        state.  A spring or a force that acts beside the contact must be much weaker than it.

        Examples
        --------
        >>> stop = Contact(0.0, 1e6, dissipation=0.5)
        >>> round(stop.restitution_at(0.01), 5), round(stop.restitution_at(2.0), 5)
        (0.99668, 0.59362)
        """
        v = finite_number(speed, "speed", low=0.0, high=LARGEST, open_low=True, hint="It is in m/s.")
        return _restitution_of(self.dissipation * v)

    @property
    def dissipates(self) -> bool:
        """Whether chi is not 0."""
        return self.dissipation > 0.0

    @property
    def is_thermal(self) -> bool:
        """There is no matching noise for its dissipation."""
        return not self.dissipates

    @property
    def soft_stop(self) -> Contact:
        """Itself."""
        return self

    def line(self, name: str) -> str:
        """Its exponent: that of Hertz is assumed, while the stops of other programs are linear."""
        kind = {1.0: " (a linear stop)", 1.5: " (Hertz's contact)"}.get(self.exponent, "")
        return f"soft contact ({name}): exponent {self.exponent:g}{kind}"

    def term(self) -> str:
        """Its force in the equation of motion."""
        power = "" if self.exponent == 1.0 else f"^{self.exponent:g}"
        damping = f" (1 + {self.dissipation:.6g} d')" if self.dissipation else ""
        sign, depth = ("-", "b - x") if self.free_side == "above" else ("+", "x - b")
        return f" {sign} {self.stiffness:.6g} d{power}{damping} [d = {depth} > 0, b = {self.position:.6g}]"


def _restitution_of(strength: float) -> float:
    """The restitution r of Hunt and Crossley's contact by s = chi v.

    u = 1 - r s solves ln u - u = ln(1 + s) - (1 + s).
    """
    s = strength
    if s < _WEAK:  # the series, since the equation has a double root at 0
        return 1.0 - s * (2.0 / 3.0 - s * (4.0 / 9.0 - s * 44.0 / 135.0))
    last = math.log1p(s) - (1.0 + s)
    return -math.expm1(root_between(lambda log: log - math.exp(log) - last, last, 0.0)) / s


def restitution_at(wall: Barrier, speed: float) -> float:
    """The restitution of an impact at a speed in m/s.

    Raises
    ------
    ValueError
        If a law returns no number there.

    Examples
    --------
    >>> restitution_at(Barrier(0.0, 0.8), 2.0), restitution_at(Barrier(0.0, PowerRestitution(0.5, 1.0)), 0.0)
    (0.8, 1.0)
    """
    if not callable(wall.restitution):
        return wall.restitution
    value = float(wall.restitution(speed))
    if math.isnan(value):
        raise ValueError(f"restitution must be a number at every speed, but {wall.law()} is NaN at {speed:.6g} m/s.")
    return value


def slow_restitution(wall: Barrier) -> float:
    """The restitution of impacts that are much slower than any that matter for the energy.

    Examples
    --------
    >>> slow_restitution(Barrier(0.0, lambda speed: 1.0 - 0.1 * speed**0.2)) > 0.99
    True
    """
    return min(1.0, max(0.0, restitution_at(wall, _SLOW)))


def restitution_of_missed(wall: Barrier, intensity: float, step: float) -> float:
    """The restitution at the speed sqrt(q h) below which a step h misses impacts, for noise of intensity q in m^2/s^3.

    Examples
    --------
    >>> round(restitution_of_missed(Barrier(0.0, PowerRestitution(0.5, speed=0.1)), 1.0, 0.01), 12)
    0.5
    """
    return min(1.0, max(0.0, restitution_at(wall, math.sqrt(intensity * step))))


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
