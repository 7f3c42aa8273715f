"""Soft contacts: stops with a force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from springpot.machine.arguments import check_plain, finite_number, positive_number
from springpot.machine.without_scipy import root_between
from springpot.problem.parts.registration import Law, Number
from springpot.problem.parts.walls import Side, Stop

if TYPE_CHECKING:
    from springpot.machine.arrays import Floats

__all__ = ["Contact", "SoftStop"]

_WEAK = 1e-3  # chi v, to which the series of the restitution is right to 1e-12


class SoftStop(Stop, abstract=True):
    """A stop with a force, which its `soft_stop` has without what it dissipates."""

    beside = ("soft_stop",)


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
        v = positive_number(speed, "speed", "It is in m/s.")
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
        v = positive_number(speed, "speed", "It is in m/s.")
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
