"""The potential of a system's springs, soft contacts and constant forces, and the walls it is cut off at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.without_scipy import root_between
from springpot.problem.parts import Contact


def _sum_of_powers(x: float | Floats, coefficients: Sequence[float]) -> Floats:
    """c0 + c1 x + c2 x^2 + ..., to the bit as NumPy's `polyval`, which takes longer for a few numbers.

    Examples
    --------
    >>> float(_sum_of_powers(2.0, (1.0, 0.0, 3.0)))
    13.0
    """
    x = np.asarray(x, float)
    found = coefficients[-1] + x * 0.0
    for coefficient in reversed(coefficients[:-1]):
        found = coefficient + found * x
    return np.asarray(found)


@dataclass(frozen=True)
class Potential:
    """The potential energy U(x) per unit mass, between the walls.

    Parameters
    ----------
    coefficients : tuple of float
        Those of the force U'(x) = c0 + c1 x + c2 x^2 + ...; c0 is minus the constant force.
    contacts : tuple of Contact
        Per unit mass.
    low, high : float
        Places of the walls, in m; infinite where there is none.

    Examples
    --------
    >>> duffing = Potential((0.0, 1.0, 0.0, 4.0))
    >>> float(duffing.energy(1.0)), float(duffing.force(1.0)), float(duffing.curvature(1.0))
    (1.5, 5.0, 13.0)
    """

    coefficients: tuple[float, ...]
    contacts: tuple[Contact, ...] = ()
    low: float = -math.inf
    high: float = math.inf

    def energy(self, x: float | Floats) -> Floats:
        """U(x), in m^2/s^2, 0 at x = 0 but for contacts that reach there."""
        powers = [0.0, *(c / (n + 1) for n, c in enumerate(self.coefficients))]
        energy = _sum_of_powers(x, powers)
        for contact in self.contacts:
            energy = energy + contact.stiffness * _depth(contact, x) ** (contact.exponent + 1) / (contact.exponent + 1)
        return np.asarray(energy, float)

    def size(self, x: float | Floats) -> Floats:
        """The terms of U(x) without their signs: rounding of U is some 1e-16 of it."""
        powers = [0.0, *(abs(c) / (n + 1) for n, c in enumerate(self.coefficients))]
        return np.asarray(_sum_of_powers(np.abs(x), powers), float) + replace(self, coefficients=(0.0,)).energy(x)

    def seen_from(self, origin: float) -> Potential:
        """The same potential as a function of x - origin; it differs by a constant.

        Far from x = 0 the terms of U cancel.  The new coefficients are found in exact arithmetic.
        """
        place = Fraction(origin)
        exact = [Fraction(c) for c in self.coefficients]
        moved = [
            float(sum(math.comb(n, k) * exact[n] * place ** (n - k) for n in range(k, len(exact))))
            for k in range(len(exact))
        ]
        return Potential(
            tuple(moved),
            tuple(replace(contact, position=contact.position - origin) for contact in self.contacts),
            self.low - origin,
            self.high - origin,
        )

    def force(self, x: float | Floats) -> Floats:
        """U'(x), in m/s^2: what pulls towards smaller x."""
        force = _sum_of_powers(x, self.coefficients)
        for contact in self.contacts:
            force = force - contact.inwards * contact.stiffness * _depth(contact, x) ** contact.exponent
        return np.asarray(force, float)

    def curvature(self, x: float | Floats) -> Floats:
        """U''(x), in 1/s^2."""
        curvature = _sum_of_powers(x, [n * c for n, c in enumerate(self.coefficients)][1:] or [0.0])
        for contact in self.contacts:
            power = contact.exponent
            depth = _depth(contact, x)
            slope = np.where(depth > 0.0, power * contact.stiffness * np.maximum(depth, 1e-300) ** (power - 1.0), 0.0)
            curvature = curvature + slope
        return np.asarray(curvature, float)

    def edge(self, start: float, sign: float, energy: float) -> float:
        """The farthest place on one side with less than this energy, or the wall.

        Examples
        --------
        >>> round(Potential((0.0, 1.0)).edge(0.0, -1.0, 8.0), 12), Potential((0.0, 1.0), high=3.0).edge(0.0, 1.0, 8.0)
        (-4.0, 3.0)
        """
        end = self.low if sign < 0.0 else self.high
        reaches = max(abs(start) * 1e-12, 1e-30) * 2.0 ** np.arange(400.0)
        places = start + sign * reaches
        places = np.concatenate([[start], places[sign * (end - places) > 0.0], [end]])
        with np.errstate(all="ignore"):  # the farthest may overflow
            beyond = self.energy(places) > energy
        if not beyond.any():
            return end
        first = int(np.argmax(beyond))
        between = places[first - 1], places[first]
        return float(root_between(lambda x: float(self.energy(x)) - energy, *between, xtol=1e-300, rtol=1e-14))

    def open_ends(self) -> tuple[str, ...]:
        """The sides, "left" or "right", to which the mass can escape: no wall, and a potential that falls for ever."""
        ends = {"left": (self.low, -1.0), "right": (self.high, 1.0)}
        return tuple(side for side, (end, sign) in ends.items() if math.isinf(end) and self._leading(sign)[1] < 0.0)

    def holds(self) -> bool:
        """Whether the potential rises without end on both sides, or a wall is there."""
        ends = (self.low, -1.0), (self.high, 1.0)
        return all(math.isfinite(end) or self._leading(sign)[1] > 0.0 for end, sign in ends)

    def _leading(self, sign: float) -> tuple[float, float]:
        """Power and size of the force towards ``sign`` infinity that grows fastest there; positive if it pulls back."""
        terms = {float(n): c * sign ** (n + 1) for n, c in enumerate(self.coefficients) if c != 0.0}
        for contact in self.contacts:
            if contact.inwards == -sign:
                terms[contact.exponent] = terms.get(contact.exponent, 0.0) + contact.stiffness
        terms = {power: size for power, size in terms.items() if size != 0.0}
        return max(terms.items(), default=(0.0, 0.0))


def _depth(contact: Contact, x: float | Floats) -> Floats:
    return np.maximum(0.0, contact.inwards * (contact.position - x))
