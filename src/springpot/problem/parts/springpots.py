"""Elements with memory: the springpot, and springs in series with a springpot or a dashpot."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Any

from springpot.machine.arguments import Free, check_plain, finite_number, positive_number
from springpot.machine.faults import shown
from springpot.problem.parts.checks import signed
from springpot.problem.parts.registration import Element, Law, Number, Part, Slopes
from springpot.problem.parts.springs import Spring

__all__ = ["FractionalMaxwell", "Maxwell", "Springpot", "resonance"]

_ROUNDS, _SETTLED = 500, 1e-14  # of the resonance


@dataclass(frozen=True)
class Springpot(Element):
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

    said, glyph, powers = "springpot", "springpot", ("damping",)
    is_linear, is_thermal, is_odd, has_modulus = True, True, True, True
    is_seen, is_of_paper = True, True

    order: Annotated[float, Number("α", "order", "1", "order", "It runs from 0 (a spring) to 1 (a dashpot).")]
    coefficient: Annotated[
        float,
        Number("C", "coefficient", "N s^alpha m-1", "unsigned", "It is the springpot's force per unit of D^alpha x."),
    ]

    @classmethod
    def from_loss_factor(
        cls, order: float, loss_factor: float, stiffness: float, frequency_hz: float
    ) -> tuple[Spring, Springpot]:
        """A spring and a springpot side by side with a measured dynamic stiffness and loss factor at one frequency.

        Parameters
        ----------
        order : float
            Greater than 0: how fast both change with frequency; 0.1 to 0.3 for rubber whose loss factor hardly does.
        loss_factor : float
            eta, the loss stiffness over the storage stiffness; near a resonance there 1 / Q, twice the damping ratio.
        stiffness : float
            Storage stiffness K' in N/m; of a mass m with this resonance m (2 pi frequency_hz)^2.
        frequency_hz : float
            In Hz.

        Returns
        -------
        (Spring, Springpot)

        Raises
        ------
        TypeError, ValueError
            If a number is none or out of its range, or the order so small that the springpot alone is stiffer; or if
            the order is free or uncertain, or two of the other numbers are.

        Notes
        -----
        From K' + i eta K' = k + C (i w)^alpha.  One of ``loss_factor``, ``stiffness`` and ``frequency_hz`` may be free
        or uncertain: both parts follow it.  No expression follows an order in that way.

        Examples
        --------
        >>> spring, springpot = Springpot.from_loss_factor(0.25, 0.15, 136_000.0, 38.0)
        >>> round(spring.stiffness), round(springpot.coefficient)
        (86750, 13561)
        >>> k = spring.stiffness + springpot.modulus(2j * math.pi * 38.0)
        >>> round(k.real), round(k.imag / k.real, 9)
        (136000, 0.15)
        """
        check_plain(
            order, "order", "the stiffness and the coefficient cannot follow it, so mark numbers of the parts "
            "themselves, or make the parts of each order and run them with springpot.simulate_many",
        )  # fmt: skip
        given = {"loss_factor": loss_factor, "stiffness": stiffness, "frequency_hz": frequency_hz}
        for name in [name for name, value in given.items() if isinstance(value, Free)][1:]:
            check_plain(given[name], name, "only one of the three may be marked")
        loss = positive_number(loss_factor, "loss_factor")
        whole = positive_number(stiffness, "stiffness", "It is in N/m.")
        hertz = positive_number(frequency_hz, "frequency_hz", "It is in Hz.")
        least = 2.0 / math.pi * math.atan(loss)
        hint = f"Below {least:.3g} a springpot of loss factor {loss:g} is stiffer than stiffness."
        own = finite_number(order, "order", low=least, high=1.0, hint=hint)
        turn = 0.5 * math.pi * own
        springpot = cls(own, loss * whole / (math.sin(turn) * (2.0 * math.pi * hertz) ** own))
        return Spring(max(whole * (1.0 - loss / math.tan(turn)), 0.0)), springpot

    @property
    def dissipates(self) -> bool:
        """Whether it takes energy from the motion: not as a spring, and not with a coefficient of 0."""
        return self.order > 0.0 and self.coefficient > 0.0

    @property
    def remembers(self) -> bool:
        """Whether its force depends on the past motion: neither as a spring nor as a dashpot."""
        return self.dissipates and self.order < 1.0

    def force_coefficients(self) -> tuple[float, ...]:
        """Those of a spring, if it is one."""
        return (0.0, self.coefficient) if self.order == 0.0 else ()

    @property
    def has_equivalent(self) -> bool:
        """Whether it is a spring."""
        return self.order == 0.0

    @property
    def dashpot(self) -> float:
        """C of order 1."""
        return self.coefficient if self.order == 1.0 else 0.0

    @property
    def slow_springpot(self) -> tuple[float, float]:
        """Itself."""
        return self.order, self.coefficient

    @property
    def creeps(self) -> bool:
        """Where it has a memory."""
        return self.remembers

    def slowed(self, factor: float) -> Springpot:
        """C times the power of the factor."""
        check_plain(self.order, "order", "C a^order cannot follow it, mark numbers of the shifted parts instead")
        return replace(self, coefficient=self.coefficient * factor**self.order)

    def fastest_rate(self, law: Law) -> float:
        """C^(1 / (2 - alpha))."""
        return self.coefficient ** (1.0 / (2.0 - self.order)) if self.coefficient > 0.0 else 0.0

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """Where it holds as much as the mass, and as the springs."""
        if not self.coefficient > 0.0:
            return []
        c = self.coefficient * share
        crossing = _power_of(stiffness / c, 1.0 / self.order)
        return [c ** (1.0 / (2.0 - self.order)), min(crossing, math.sqrt(stiffness))]

    def measure(self, name: str, frequency: float, resonance: float, own: Part) -> str:
        """Its dimensionless coefficient."""
        strength = self.coefficient * frequency ** (self.order - 2.0)
        return f"strength of {name}: c = C Omega^(order - 2) / m = {strength:.6g}"

    def term(self) -> str:
        """Its force in the equation of motion."""
        return signed(self.coefficient, f"D^{self.order:.6g} x")

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p, C p^alpha: of a number or an array."""
        return self.coefficient * p**self.order

    def slopes(self, p: Any) -> Slopes:
        """The derivatives of the modulus by the order and the coefficient."""
        import numpy as np  # here, so that the command starts quickly

        unit = p**self.order
        return [(self.order, self.coefficient * unit * np.log(p)), (self.coefficient, unit)]


def _power_of(base: float, power: float) -> float:
    """A frequency, kept within what matters: so far off, an element is nothing or a spring."""
    return math.exp(min(max(power * math.log(base), -140.0), 140.0)) if base > 0.0 else 0.0


_IN_SERIES = {
    "order": Number("α", "springpot's order", range="share"),
    "coefficient": Number("C", "springpot", "N s^alpha m-1"),
}


@dataclass(frozen=True)
class FractionalMaxwell(Element):
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

    said, glyph, powers = "fractional maxwell", "springpot arm", ("damping",)
    is_linear, remembers, dissipates, is_thermal, is_odd, has_modulus = True, True, True, True, True, True
    is_seen, creeps = True, True

    springpot: Annotated[Springpot, _IN_SERIES]
    spring: Annotated[Spring, {"stiffness": Number("k", "spring", "N m-1")}]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.springpot, Springpot):
            raise TypeError(f"springpot must be a Springpot, not {shown(self.springpot)}.")
        if not isinstance(self.spring, Spring):
            raise TypeError(f"spring must be a Spring, not {shown(self.spring)}.")
        if not self.springpot.order > 0.0 or not self.springpot.coefficient > 0.0:
            raise ValueError(f"springpot must have an order and a coefficient above 0, not {shown(self.springpot)}.")
        if not self.spring.stiffness > 0.0:
            raise ValueError(f"spring must have a positive stiffness in a series, not {self.spring.stiffness:g}.")
        for name, part in (("springpot", self.springpot), ("spring", self.spring)):
            for own in ("between", "count", "group"):
                if getattr(part, own) != getattr(Element, own):
                    whole = f"FractionalMaxwell(..., {own}=...)"
                    raise ValueError(f"{name} must be without {own} in a series: {whole} has it.")

    def term(self) -> str:
        """Its force in the equation of motion."""
        springpot = self.springpot
        return f" + F[{self.spring.stiffness:.6g} in series with {springpot.coefficient:.6g} D^{springpot.order:.6g}]"

    @property
    def stiffness_at_once(self) -> float:
        """That of the spring."""
        return self.spring.stiffness

    @property
    def slow_springpot(self) -> tuple[float, float]:
        """That of the springpot."""
        return self.springpot.slow_springpot

    @property
    def relaxation(self) -> tuple[float, float]:
        """That of a Maxwell element, where the springpot is a dashpot."""
        if self.springpot.order < 1.0:
            return 0.0, 0.0
        return self.spring.stiffness, self.spring.stiffness / self.springpot.coefficient

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """Where its spring, its springpot, and the one as much as the other hold."""
        springpot, k = self.springpot, self.spring.stiffness
        return [
            math.sqrt(stiffness + k * share),
            (springpot.coefficient * share) ** (1.0 / (2.0 - springpot.order)),
            _power_of(k / springpot.coefficient, 1.0 / springpot.order),
        ]

    def slowed(self, factor: float) -> FractionalMaxwell:
        """With a slower springpot."""
        return replace(self, springpot=self.springpot.slowed(factor))

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p."""
        springpot, k = self.springpot.modulus(p), self.spring.stiffness
        return k * springpot / (k + springpot)

    def slopes(self, p: Any) -> Slopes:
        """The derivatives of the modulus by the springpot's numbers and the stiffness."""
        return _in_series(self.springpot.modulus(p), self.springpot.slopes(p), self.spring.stiffness)


def springpot_in(part: Any) -> Springpot | None:
    """The springpot that an element is, or has in series with a spring, whose force is that of slow motion."""
    own = part.springpot if isinstance(part, FractionalMaxwell) else part
    return own if isinstance(own, Springpot) and own.coefficient > 0.0 else None


def order_at_rest(part: Any) -> float:
    """The power of a slow displacement that the force of an element follows; 1 of one without a springpot.

    Examples
    --------
    >>> order_at_rest(FractionalMaxwell(Springpot(0.3, 1.0), Spring(2.0))), order_at_rest(Maxwell(1.0, 1.0))
    (0.3, 1.0)
    """
    springpot = springpot_in(part)
    return 1.0 if springpot is None else float(springpot.order)


@dataclass(frozen=True)
class Maxwell(Element):
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

    said, glyph, powers = "maxwell", "dashpot arm", ("damping",)
    is_linear, remembers, dissipates, is_thermal, is_odd, has_modulus = True, True, True, True, True, True
    is_seen = True

    stiffness: Annotated[
        float, Number("k", "stiffness", "N m-1", "positive", "It is the spring's force per displacement.")
    ]
    coefficient: Annotated[
        float, Number("c", "coefficient", "N s m-1", "positive", "It is the damper's force per velocity.")
    ]

    def term(self) -> str:
        """Its force in the equation of motion."""
        return f" + F[{self.stiffness:.6g} in series with {self.coefficient:.6g} D]"

    @property
    def stiffness_at_once(self) -> float:
        """That of the spring."""
        return self.stiffness

    @property
    def slow_springpot(self) -> tuple[float, float]:
        """The dashpot."""
        return 1.0, self.coefficient

    @property
    def relaxation(self) -> tuple[float, float]:
        """k and k / c."""
        return self.stiffness, self.stiffness / self.coefficient

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """Where its spring holds, and where it begins to."""
        return [math.sqrt(stiffness + self.stiffness * share), self.stiffness / self.coefficient]

    def slowed(self, factor: float) -> Maxwell:
        """With a stronger dashpot."""
        return replace(self, coefficient=self.coefficient * factor)

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p."""
        return self.stiffness * self.coefficient * p / (self.stiffness + self.coefficient * p)

    def slopes(self, p: Any) -> Slopes:
        """The derivatives of the modulus by the coefficient and the stiffness."""
        return _in_series(self.coefficient * p, [(self.coefficient, p)], self.stiffness)


def _in_series(soft: Any, own: Slopes, stiffness: float) -> Slopes:
    share = stiffness / (stiffness + soft)
    return [*((number, slope * share**2) for number, slope in own), (stiffness, (1.0 - share) ** 2)]


def resonance(square: float, elements: Iterable[Part]) -> float:
    """Frequency at which springs and elements with memory together swing a unit mass, in rad/s.

    The root w of w^2 = square + Re K(iw), with K the modulus of all elements.  ``square`` is the stiffness of the
    springs over the mass, and must be positive.

    Examples
    --------
    >>> round(resonance(1.0, [Springpot(0.5, 1.0)]), 4)
    1.3496
    """
    elements, found = tuple(elements), square

    def held(own: float) -> float:
        p = 1j * math.sqrt(own)
        return square + math.fsum(element.modulus(p).real for element in elements)

    for _ in range(_ROUNDS):  # from below: of several roots that nearest to the springs' own; contracts by order / 2
        before, found = found, held(found)
        if found <= 0.0:
            break
        if abs(found - before) <= _SETTLED * found:
            return math.sqrt(found)
    return math.sqrt(_bisected(held, square))


def _bisected(held: Callable[[float], float], near: float) -> float:
    """The root of held(s) = s nearest to a number, where no iteration contracts: above the frequency of a coil."""
    low = high = near
    while held(low) < low:
        low *= 0.5
    while held(high) > high:
        high *= 2.0
    while high - low > _SETTLED * high and low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if held(middle) > middle else (low, middle)
    return high
