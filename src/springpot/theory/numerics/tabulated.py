"""Tabulated densities: cubics between knots, never negative, with an integral of 1 to rounding."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline, PPoly

from springpot.machine.arrays import Floats
from springpot.theory.numerics.panels import panel_rule


@dataclass(frozen=True)
class Tabulated:
    """A density on an interval, 0 outside: a cubic between knots that is never negative.

    Parameters
    ----------
    corner : float
        Position where the density may vary like a root.
    spline : PPoly
        The density as a function of the root of the distance from the corner, with the sign of the distance.
    """

    corner: float
    spline: PPoly

    @classmethod
    def make(cls, place: Floats, density: Floats, corner: float = 0.0, power: int = 0) -> Tabulated:
        """From values on a rising grid, so that the integral of density * place^power is 1, to rounding.

        The corner is a place of the grid, or outside it.

        Examples
        --------
        >>> float(Tabulated.make(np.array([0.0, 1.0, 2.0]), np.array([3.0, 3.0, 3.0])).density(np.array(0.3)).round(12))
        0.5
        """
        table = cls(corner, _never_negative(signed_root(place - corner), density))
        return cls(corner, PPoly(table.spline.c / table.moment(power), table.spline.x))

    def moment(self, power: int) -> float:
        """Integral of density * value^power, exactly for a power up to 1."""
        at, weights = panel_rule(self.spline.x, 4)
        measure = weights * 2.0 * np.abs(at) * (self.corner + at * np.abs(at)) ** power
        return float(np.sum(measure * self.spline(at)))

    @property
    def end(self) -> float:
        """The largest value with a density."""
        return float(self.corner + self.spline.x[-1] * abs(self.spline.x[-1]))

    def density(self, value: Floats) -> Floats:
        """The density; NaN where the value is NaN."""
        low, high = self.spline.x[0], self.spline.x[-1]
        root = signed_root(value - self.corner)
        inside = np.where((root >= low) & (root <= high), self.spline(np.clip(root, low, high)), 0.0)
        return np.where(np.isnan(value), np.nan, np.maximum(inside, 0.0))


def _never_negative(place: Floats, value: Floats) -> PPoly:
    """Cubic splines on either side of 0, their slopes limited so that between values >= 0 they stay there.

    The limit is that of J. W. Schmidt and W. Hess, "Positivity of cubic polynomials on intervals and positive spline
    interpolation", BIT 28, 1988.
    """
    corner = int(np.searchsorted(place, 0.0))
    cuts = [0, corner, place.size - 1] if 0 < corner < place.size - 1 else [0, place.size - 1]
    sides = []
    for first, last in itertools.pairwise(cuts):
        x, y = place[first : last + 1], value[first : last + 1]
        slope, step = CubicSpline(x, y)(x, 1), np.diff(x)
        slope[:-1] = np.maximum(slope[:-1], -3.0 * y[:-1] / step)
        slope[1:] = np.minimum(slope[1:], 3.0 * y[1:] / step)
        sides.append(CubicHermiteSpline(x, y, slope).c)
    return PPoly(np.concatenate(sides, axis=1), place)


def signed_root(distance: Floats) -> Floats:
    """Root of the absolute value, with the sign.

    Examples
    --------
    >>> signed_root(np.array([-4.0, 0.0, 9.0]))
    array([-2.,  0.,  3.])
    """
    return np.asarray(np.copysign(np.sqrt(np.abs(distance)), distance))
