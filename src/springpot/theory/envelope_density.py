"""Densities of the envelope: the joint one, exact for the cycles of the balance, and its integrals.

A point (x, v) lies on one cycle, whose label follows from (x - x_e)^2 + v^2 / w^2 = A^2; the probability of the
cycle's cell, spread evenly over the cycle's time, divided by the area that the cell covers, is the joint density.
The densities of x, of v and of the amplitude are its integrals by Gauss-Legendre rules, tabulated, interpolated by a
cubic that stays between the tabulated values (never negative) and normalised: their mass is 1 to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from springpot.theory.envelope_balance import Balance, Labels

__all__ = ["Portrait", "Tabulated", "portrait"]

FloatArray = NDArray[np.float64]

_GRID = 160
_CROSS = 24  # nodes of each half of a cross-section
_BISECTIONS = 6
_NEWTON_STEPS = 6
_UNLIKELY = 35.0  # the tables end where the density per label has fallen by e^-35


@dataclass(frozen=True)
class Tabulated:
    """A density on an interval, 0 outside.

    Parameters
    ----------
    spline : PchipInterpolator
        The density, with integral 1.
    """

    spline: PchipInterpolator

    @classmethod
    def make(cls, place: FloatArray, density: FloatArray) -> Tabulated:
        """From values on a rising grid, normalised.

        Examples
        --------
        >>> float(Tabulated.make(np.array([0.0, 1.0, 2.0]), np.array([3.0, 3.0, 3.0])).density(np.array(0.3)))
        0.5
        """
        total = float(PchipInterpolator(place, density).integrate(place[0], place[-1]))
        return cls(PchipInterpolator(place, density / total))

    def density(self, value: FloatArray) -> FloatArray:
        """The density; NaN where the value is NaN."""
        low, high = self.spline.x[0], self.spline.x[-1]
        found = np.where((value >= low) & (value <= high), self.spline(np.clip(value, low, high)), 0.0)
        return np.where(np.isnan(value), np.nan, np.maximum(found, 0.0))


@dataclass(frozen=True)
class Portrait:
    """The cycles in the plane of x and v; dimensionless.

    Parameters
    ----------
    wall : float
        b, -inf without.
    labels : Labels
        Panels of the label.
    columns : ndarray, shape (nodes, 8)
        Density per label, phase p, A, w, x_e and the slopes of the last three, at the panels' nodes.
    last : float
        Largest label of interest.
    left, right, top : float
        Ends of the displacement, and the largest velocity.
    """

    wall: float
    labels: Labels
    columns: FloatArray
    last: float
    left: float
    right: float
    top: float

    def joint(self, x: FloatArray, v: FloatArray) -> FloatArray:
        """Density of displacement and velocity."""
        x, v = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(v, dtype=float))
        label = self._label(x.ravel(), v.ravel())
        density, p, a, w, centre, slope_a, slope_w, slope_centre = self._at(label, 0)
        cosine = np.clip((x.ravel() - centre) / a, -1.0, 1.0)
        # area per label and phase
        area = w * a * (slope_centre + slope_a * cosine) * cosine + a * (slope_w * a + w * slope_a) * (1.0 - cosine**2)
        found = np.maximum(density, 0.0) / (2.0 * np.maximum(p, 1e-12) * np.maximum(area, 1e-300))
        inside = (x.ravel() >= self.wall) & (label < self.last)
        return np.where(inside, found, 0.0).reshape(x.shape)

    def x(self) -> Tabulated:
        """Density of the displacement."""
        grid = _grid(self.left, self.right, 0.0 if math.isinf(self.wall) else 1.0)
        v, weight = _cross(0.0, self.top)
        return Tabulated.make(grid, self.joint(grid[:, None], v) @ weight)

    def v(self) -> Tabulated:
        """Density of the velocity, which is symmetric."""
        half = _grid(0.0, self.top, 1.0)
        middle = max(self.left, min(0.0, self.right))
        low, weight_low = _cross(middle, self.left) if middle > self.left else (np.zeros(0), np.zeros(0))
        high, weight_high = _cross(middle, self.right)
        x, weight = np.r_[low, high], np.r_[weight_low, weight_high]
        density = self.joint(x, half[:, None]) @ weight
        return Tabulated.make(np.r_[-half[:0:-1], half], np.r_[density[:0:-1], density])

    def amplitude(self, kappa: float) -> Tabulated:
        """Density of the root of x^2 + kappa v^2."""
        farthest = math.hypot(max(abs(self.left), abs(self.right)), math.sqrt(kappa) * self.top)
        nearest = max(self.wall, 0.0)
        grid = _grid(nearest, farthest, 1.0)
        # half the plane: angles from the positive x axis to where the circle meets the wall
        ratio = np.divide(self.wall, grid, out=np.full(grid.size, -1.0), where=grid > 0.0)
        last = np.arccos(np.clip(ratio, -1.0, 1.0))
        nodes, weights = legendre.leggauss(2 * _CROSS)
        angle = last[:, None] * (nodes + 1.0) / 2.0
        values = self.joint(grid[:, None] * np.cos(angle) + 0.0, grid[:, None] * np.sin(angle) / math.sqrt(kappa))
        return Tabulated.make(grid, grid * last * (values @ weights))

    def _label(self, x: FloatArray, v: FloatArray) -> FloatArray:
        """Label of the cycle through each point, by Newton's method between brackets."""
        low, high = np.full(x.size, self.labels.edges[0]), np.full(x.size, self.labels.edges[-1])
        label = (low + high) / 2.0
        for step in range(_BISECTIONS + _NEWTON_STEPS):
            a, w, centre, slope_a, slope_w, slope_centre = self._at(label, 2)
            excess = a * a - (x - centre) ** 2 - (v / w) ** 2
            low, high = np.where(excess < 0.0, label, low), np.where(excess < 0.0, high, label)
            slope = 2.0 * (a * slope_a + (x - centre) * slope_centre + (v / w) ** 2 * slope_w / w)
            newton = label - excess / np.where(slope > 0.0, slope, np.inf)
            middle = (low + high) / 2.0
            use = (step >= _BISECTIONS) & (newton >= low) & (newton <= high)
            label = np.where(use, newton, middle)
        return np.asarray(label)

    def _at(self, label: FloatArray, first: int) -> FloatArray:
        return np.asarray(self.labels.interpolate(self.columns[:, first:], label).T)


def portrait(balance: Balance, ratio: FloatArray | None = None) -> Portrait:
    """The cycles of a balance, weighted by its stationary law or by another law over it.

    Parameters
    ----------
    balance : Balance
    ratio : ndarray, optional
        Probabilities of the nodes over the stationary ones.

    Examples
    --------
    >>> from springpot.theory.envelope_balance import Problem, balance
    >>> half_normal = portrait(balance(Problem(order=1.0, coefficient=0.5, position=0.0, restitution=1.0))).x()
    >>> float(half_normal.density(np.array(1.0)).round(4))  # sqrt(2 / pi) e^(-1/2)
    0.4839
    """
    labels = balance.labels
    density = balance.density if ratio is None else balance.density * ratio
    shapes = [balance.amplitude, balance.frequency, balance.centre]
    columns = np.stack([density, balance.phase, *shapes, *(labels.derivative(shape) for shape in shapes)], axis=1)
    likely = np.flatnonzero(balance.density > math.exp(-_UNLIKELY) * balance.density.max())
    last = int(likely[-1])
    a, w, centre = (shape[: last + 1] for shape in shapes)
    wall = balance.problem.position
    return Portrait(
        wall=wall,
        labels=labels,
        columns=columns,
        last=float(labels.nodes.ravel()[last]),
        left=max(wall, float(np.min(centre - a))),
        right=float(np.max(centre + a)),
        top=float(np.max(w * a * np.sin(np.minimum(balance.phase[: last + 1], math.pi / 2.0)))),
    )


def _grid(low: float, high: float, crowding: float) -> FloatArray:
    """From low to high, denser near low."""
    even = np.linspace(0.0, 1.0, _GRID)
    return np.asarray(low + (high - low) * (even + crowding * even**2) / (1.0 + crowding))


def _cross(start: float, end: float) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre rule between two points in three panels that widen away from the start (positive weights)."""
    nodes, weights = legendre.leggauss(_CROSS)
    edges = start + (end - start) * np.array([0.0, 0.12, 0.4, 1.0])
    width = np.diff(edges)[:, None]
    return (edges[:-1, None] + width * (nodes + 1.0) / 2.0).ravel(), np.abs(width * weights / 2.0).ravel()
