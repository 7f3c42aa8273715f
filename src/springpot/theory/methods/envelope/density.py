"""Densities of the envelope: the joint one, exact for the cycles of the balance, and its integrals.

A cycle is x = top - A (1 - cos s), v = -w A sin s for phases s between -p and p; its label l and s are coordinates of
the plane.  The probability of a label, ~ exp(-fall) J' with J' the mean of the Jacobian d(x, v)/d(l, s) over s, is
spread evenly over the phases, so that

    p(x, v) = exp(-fall(l)) / (2 pi Z) * (mean Jacobian of the cycle through (x, v)) / (Jacobian at (x, v)),

whose integral over the plane is 1 for any continuous and nested shapes A(l), w(l).  These are interpolated between the
ends of panels; everything else, also the phase p at the wall, follows from the interpolants.  The densities of x, v and
the amplitude are integrals of it by Gauss-Legendre rules, tabulated, interpolated by a non-negative cubic and
normalized: their mass is 1 to rounding.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.theory.methods.envelope.arcs import Arcs, Heights, arcs_at, missing_sinc
from springpot.theory.methods.envelope.balance import Balance
from springpot.theory.methods.envelope.cycles import CyclesInWell
from springpot.theory.numerics.panels import on_panels, panel_rule
from springpot.theory.numerics.tabulated import Tabulated, signed_root

_GRID = 160
_CROSS = 24  # nodes of each half of a cross-section
_DEGREE = 12  # of the shapes on a panel
_FINER = 6  # panels added towards the first striking cycle, where A and w vary like a power behind a preload
_NODES = 24  # on a panel, of the integral that normalizes
_STEPS = 80
_CONVERGED = 3e-15
_ON_PANEL = 24  # labels on a panel among which that of a point in the plane is found
_WIDER = np.array([0.0, 0.03, 0.12, 0.4, 1.0])
_UNLIKELY = 35.0  # the tables end where the density per label has fallen by e^-35


@dataclass(frozen=True)
class Shapes:
    """Cycles x = top - A (1 - cos s), v = -w A sin s; one entry per cycle for every array.

    Parameters
    ----------
    top, a, w : ndarray
        Largest displacement, amplitude and frequency of the arcs.
    top_slope, a_slope, w_slope : ndarray
        Their derivatives by the label.
    phase : ndarray
        Phase p at the impact, pi without impacts.
    """

    top: Floats
    a: Floats
    w: Floats
    top_slope: Floats
    a_slope: Floats
    w_slope: Floats
    phase: Floats

    def excess(self, x: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Negative where (x, v) is outside the cycle, positive inside, and its derivative by the label."""
        depth, square = self.top - x, (v / self.w) ** 2
        slope = (
            self.top_slope * 2.0 * (self.a - depth) + 2.0 * depth * self.a_slope + 2.0 * square * self.w_slope / self.w
        )
        return depth * (2.0 * self.a - depth) - square, slope

    def jacobian(self, x: Floats) -> Floats:
        """d(x, v) / d(label, phase) of the cycles at these displacements."""
        a, w = self.a, self.w
        missing = np.clip((self.top - x) / a, 0.0, 2.0)  # 1 - cos s
        across = w * a * (1.0 - missing) * (self.top_slope - self.a_slope * missing)
        return np.asarray(across + a * (self.w_slope * a + w * self.a_slope) * missing * (2.0 - missing))

    @property
    def mean_jacobian(self) -> Floats:
        """Mean of the Jacobian over the phases of each cycle."""
        a, w = self.a, self.w
        once, twice = missing_sinc(self.phase), missing_sinc(2.0 * self.phase)
        across = w * a * (self.top_slope * (1.0 - once) + self.a_slope * (once - twice / 2.0))
        return np.asarray(across + a * (self.w_slope * a + w * self.a_slope) * twice / 2.0)


@dataclass(frozen=True)
class Portrait:
    """The cycles in the plane of x and v; dimensionless.

    Parameters
    ----------
    balance : Balance
    labels : Heights
        Those of the balance.
    wall, origin : float
        The place of the wall, -inf without one; that of rest without impacts, or the wall if every cycle has impacts.
    edges : ndarray
        Ends of the panels of the label, from rest to the last label of interest.
    clear : int
        Number of panels without impacts.
    series : ndarray, shape (panels, degree + 1, 2)
        Chebyshev series, on each panel, of w and of F in A = base + e F, where e is the square of the label of a cycle
        with impacts, and its top less the largest top without them.
    base : float
        A of the first cycle with impacts.
    ratio : callable
        Probability of a label over the stationary one.
    total : float
        Normalization, so that the mass is 1.
    """

    balance: Balance
    labels: Heights
    wall: float
    origin: float
    edges: Floats
    clear: int
    series: Floats
    base: float
    ratio: Callable[[Floats], Floats]
    total: float

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Density of displacement and velocity."""
        x, v = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(v, dtype=float))
        if (stretch := self.balance.stretch) is None:
            return self._on_cycles(x, v)
        place, speed, wider = stretch.origin(x, v)
        return np.asarray(self._on_cycles(place, speed) / wider)

    def _on_cycles(self, x: Floats, v: Floats) -> Floats:
        """The same without the correction for a lossy wall."""
        place, speed = x.ravel(), v.ravel()
        left, right, top = self._ends_of_cycles
        inside = (place >= left) & (place <= right) & (np.abs(speed) <= top)
        place, speed = place[inside], speed[inside]
        label = self._label(place, speed)
        cycles = self.shapes(label)
        density = np.zeros(x.size)
        density[inside] = self._height(label) * cycles.mean_jacobian / cycles.jacobian(place)
        density[inside] *= label < self.edges[-1]
        return density.reshape(x.shape)

    def x_density(self, x: Floats) -> Floats:
        return self.x.density(x)

    def v_density(self, v: Floats) -> Floats:
        return self.v.density(v)

    def weight(self, label: Floats) -> Floats:
        """Probability per label."""
        cycles = self.shapes(label)
        return np.asarray(2.0 * cycles.phase * self._height(label) * cycles.mean_jacobian)

    @property
    def nested(self) -> bool:
        """Whether every cycle lies inside the larger ones, and (label, phase) are coordinates of the plane."""
        cycles = self.shapes(panel_rule(self.edges, _NODES)[0])
        part = np.linspace(0.0, 1.0, _NODES)[:, None]
        missing = 2.0 * np.sin(cycles.phase * part / 2.0) ** 2
        return bool(np.all(cycles.jacobian(cycles.top - cycles.a * missing) > 0.0))

    def normalized(self) -> Portrait:
        """With mass 1."""
        label, weights = panel_rule(self.edges, _NODES)
        return replace(self, total=float(weights @ self.weight(label)))

    @cached_property
    def x(self) -> Tabulated:
        """Density of the displacement."""
        left, right, back, out = self.ends
        wall = self.wall
        corner = 0.0 if math.isinf(wall) else wall
        grid = _grid(left, right, corner)
        v, weight = _cross(0.0, out)
        density = self.joint(grid[:, None], v) @ weight
        if self.balance.stretch is not None:
            v, weight = _cross(0.0, back)
            density += self.joint(grid[:, None], v) @ weight
        return Tabulated.make(grid, density, corner)

    @cached_property
    def v(self) -> Tabulated:
        """Density of the velocity; symmetric unless the wall is lossy."""
        left, right, top = self._ends_of_cycles
        half = _grid(0.0, top, 0.0)
        middle = max(left, min(0.0, right))
        low, weight_low = _cross(middle, left) if middle > left else (np.zeros(0), np.zeros(0))
        high, weight_high = _cross(middle, right)
        x, weight = np.r_[low, high], np.r_[weight_low, weight_high]
        density = self._on_cycles(*np.broadcast_arrays(x, half[:, None])) @ weight
        v, density = np.r_[-half[:0:-1], half], np.r_[density[:0:-1], density]
        if (stretch := self.balance.stretch) is None:
            return Tabulated.make(v, density)
        return Tabulated.make(stretch.v(v), density / stretch.v_slope(v), float(stretch.v(np.zeros(1))[0]))

    def energy(self, kappa: float) -> Tabulated:
        """Density of (x^2 + kappa v^2) / 2, as a function of the root of x^2 + kappa v^2."""
        wall = self.wall
        left, right, back, out = self.ends
        farthest = math.hypot(max(abs(left), abs(right)), math.sqrt(kappa) * max(-back, out))
        # where the circle first meets the wall
        corner = abs(wall) if abs(wall) < farthest else 0.0
        grid = _grid(max(wall, 0.0), farthest, corner)
        # half the plane: angles from the positive x axis to the wall
        ratio = np.divide(wall, grid, out=np.full(grid.size, -1.0 if wall < 0.0 else 0.0), where=grid > 0.0)
        last = np.arccos(np.clip(ratio, -1.0, 1.0))
        angle, weights = on_panels(np.zeros_like(last), last, 2 * _CROSS)
        x, v = grid[:, None] * np.cos(angle) + 0.0, grid[:, None] * np.sin(angle) / math.sqrt(kappa)
        values = self.joint(x, v)
        if self.balance.stretch is not None:
            values += self.joint(x, -v)
        return Tabulated.make(grid, 2.0 * np.sum(values * weights, axis=1), corner, power=1)

    def shapes(self, label: Floats) -> Shapes:
        """The cycles with these labels."""
        return self._on_panels(label, np.searchsorted(self.edges, label, side="right") - 1)

    @property
    def ends(self) -> tuple[float, float, float, float]:
        """Ends of the displacement and of the velocity."""
        left, right, top = self._ends_of_cycles
        if (stretch := self.balance.stretch) is None:
            return left, right, -top, top
        (left, right), (back, out) = stretch.x(np.array([left, right])), stretch.v(np.array([-top, top]))
        return float(left), float(right), float(back), float(out)

    @cached_property
    def _ends_of_cycles(self) -> tuple[float, float, float]:
        """Ends of the displacement, and the largest velocity, before the stretch."""
        label = np.concatenate([np.linspace(*pair, 8) for pair in itertools.pairwise(self.edges)])
        cycles = self.shapes(label)
        return (
            max(self.wall, float(np.min(cycles.top - 2.0 * cycles.a))),
            float(np.max(cycles.top)),
            float(np.max(cycles.w * cycles.a * np.sin(np.minimum(cycles.phase, math.pi / 2.0)))),
        )

    def _height(self, label: Floats) -> Floats:
        """Density in the plane on the cycle, without the Jacobian."""
        fall = self.labels.interpolate(self.balance.fall[:, None], label)[..., 0]
        return np.asarray(np.exp(-fall) * self.ratio(label) / self.total)

    @cached_property
    def _slopes(self) -> Floats:
        """The derivative of each series."""
        return np.asarray(chebyshev.chebder(self.series, axis=1))

    def _on_panels(self, label: Floats, panel: NDArray[np.intp]) -> Shapes:
        panel = np.clip(panel, 0, self.edges.size - 2)
        half = (self.edges[panel + 1] - self.edges[panel]) / 2.0
        place = (label - self.edges[panel]) / half - 1.0
        series, slopes = (np.moveaxis(each[panel], 0, -1) for each in (self.series, self._slopes))
        w, share = chebyshev.chebval(place, series, tensor=False)
        w_slope, share_slope = chebyshev.chebval(place, slopes, tensor=False) / half
        least, strikes = self.labels.clear_amplitude, panel >= self.clear
        above = np.where(strikes, label * label, least * label)
        slope = np.where(strikes, 2.0 * label, least)
        height = np.sqrt(np.maximum(least + above / 2.0, 0.0))
        beyond = np.sqrt(np.maximum(self.base - least + above * (share - 0.5), 0.0))
        return Shapes(
            top=self.origin + least + above,
            a=np.where(strikes, self.base, least) + above * share,
            w=w,
            top_slope=slope,
            a_slope=slope * share + above * share_slope,
            w_slope=w_slope,
            phase=np.where(strikes, 2.0 * np.arctan2(height, beyond), math.pi),
        )

    def _label(self, x: Floats, v: Floats) -> Floats:
        """Label of the cycle through each point: first its panel, then Newton's method within brackets."""
        panel = np.zeros(x.size, dtype=np.intp)
        for edge in range(1, self.edges.size - 1):
            panel += self._on_panels(self.edges[edge : edge + 1], np.array([edge])).excess(x, v)[0] < 0.0
        low, high = self.edges[panel], self.edges[panel + 1]
        label, last = (low + high) / 2.0, high - low
        open_ = np.arange(x.size)
        for _ in range(_STEPS):
            here = label[open_]
            value, slope = self._on_panels(here, panel[open_]).excess(x[open_], v[open_])
            low[open_], high[open_] = np.where(value < 0.0, here, low[open_]), np.where(value < 0.0, high[open_], here)
            newton = here - value / np.where(slope > 0.0, slope, np.inf)
            good = (newton >= low[open_]) & (newton <= high[open_]) & (np.abs(newton - here) < 0.6 * last[open_])
            following = np.where(good, newton, (low[open_] + high[open_]) / 2.0)
            label[open_], last[open_] = following, np.abs(following - here)
            open_ = open_[np.abs(following - here) > _CONVERGED * float(np.ptp(self.edges))]
            if open_.size == 0:
                break
        return label


def portrait(balance: Balance, ratio: Callable[[Floats], Floats] = np.ones_like) -> Portrait:
    """The cycles of a balance, with its stationary density or another one.

    Parameters
    ----------
    balance : Balance
    ratio : callable, optional
        Probability of a label over the stationary one.

    Examples
    --------
    >>> from springpot.theory.methods.envelope.balance import balance
    >>> from springpot.theory.problem import Problem
    >>> half_normal = portrait(balance(Problem(order=1.0, coefficient=0.5, position=0.0, restitution=1.0))).x
    >>> float(half_normal.density(np.array(1.0)).round(4))  # sqrt(2 / pi) e^(-1/2)
    0.4839
    """
    labels, wall = balance.labels, balance.problem.potential.low
    assert isinstance(labels, Heights)
    assert isinstance(balance.cycles, Arcs)
    origin = float(balance.cycles.centre[0]) if labels.clear_amplitude > 0.0 else wall
    empty = Portrait(balance, labels, wall, origin, labels.edges, labels.clear, np.zeros(0), 0.0, ratio, 1.0)
    likely = np.flatnonzero(balance.density > math.exp(-_UNLIKELY) * balance.density.max())
    last = float(labels.nodes.ravel()[likely[-1]])
    strikes = labels.edges[labels.clear + 1 :]
    finer = float(np.min(strikes, initial=last)) * 0.25 ** np.arange(_FINER, 0.0, -1.0)
    for first in (*finer, *strikes[:-1]):
        edges = np.unique(np.r_[labels.edges[: labels.clear + 1], finer, strikes])
        edges = edges[(edges <= 0.0) | (edges >= first)]
        edges = np.r_[edges[edges < last], last]
        candidate = _outlines(empty, edges)
        if candidate.nested:
            return candidate.normalized()
    raise NotCoveredError("The envelope has densities only if cycles of different size do not cross; here they cross.")


def _outlines(empty: Portrait, edges: Floats) -> Portrait:
    """The cycles on these panels, continuous at their ends; on the first panel with impacts A - base is const. e."""
    labels, problem = empty.labels, empty.balance.problem
    clear = min(labels.clear, edges.size - 1)
    places = chebyshev.chebpts2(_DEGREE + 1)
    label = edges[:-1, None] + np.diff(edges)[:, None] * (places + 1.0) / 2.0
    base = labels.clear_amplitude
    w, share = np.empty(label.shape), np.ones(label.shape)
    if clear:
        w[:clear] = arcs_at(problem, labels, np.array([-1.0]), 1)[2]
    if clear < edges.size - 1:
        strike = np.r_[edges[clear + 1], label[clear + 1 :].ravel()]
        _, a, frequency = arcs_at(problem, labels, strike, 0)
        if clear == 0 and a[0] > 2.0 * strike[0] ** 2:  # a preload: the shorter the flight, the nearer to a parabola
            base = float(a[0])
        excess = (a - base) / strike**2
        share[clear], share[clear + 1 :] = excess[0], excess[1:].reshape(-1, places.size)
        start = w[0, 0] if clear else frequency[0]
        w[clear] = start + (frequency[0] - start) * ((places + 1.0) / 2.0) ** 2
        w[clear + 1 :] = frequency[1:].reshape(-1, places.size)
    to_series = np.linalg.inv(chebyshev.chebvander(places, _DEGREE)).T
    series = np.stack([w @ to_series, share @ to_series], axis=-1)
    return replace(empty, edges=edges, clear=clear, series=series, base=base)


class Densities(Protocol):
    """Densities of displacement and velocity, seen from the origin of the problem."""

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Of both."""

    def x_density(self, x: Floats) -> Floats:
        """Of the displacement."""

    def v_density(self, v: Floats) -> Floats:
        """Of the velocity."""


@dataclass(frozen=True)
class DensityInWell:
    """Densities of cycles in any well, by their probabilities per action, each spread evenly over the time of a cycle.

    The cycle through (x, v) is that on which F = A + B x - k x^2 / 2 - U(x) - v^2 / 2 is 0, where A, B and k, its own
    stiffness, depend on the label l.  The flow along cycles keeps areas, so d(x, v) / d(l, t) is dF / dl.
    """

    balance: Balance

    @cached_property
    def _table(self) -> tuple[Floats, Floats, Floats]:
        """A, B and k, a row each; their slopes; and -ln of the density in the plane, with the mean of dF / dl."""
        law, cycles = self.balance, self.balance.cycles
        assert isinstance(cycles, CyclesInWell)
        k, least, centre = cycles.stiffness, cycles.least, cycles.centre
        height = cycles.energy + law.problem.potential.energy(least) + 0.5 * k * least * (least - 2.0 * centre)
        columns = np.stack([height, k * centre, k], axis=1)
        slopes = np.stack([law.labels.derivative(column) for column in columns.T], axis=1)
        mean_slope = np.sum(slopes * np.stack([np.ones_like(k), cycles.mean, -0.5 * cycles.x_square], axis=1), axis=1)
        area = cycles.period * mean_slope
        fall = law.fall - np.log(np.maximum(law.measure / area, 1e-300)) if law.problem.remembers else law.fall
        total = float(np.sum(law.labels.weights.ravel() * np.exp(-fall) * area))
        columns = np.concatenate([columns, slopes, np.stack([fall + math.log(total), mean_slope], axis=1)], axis=1)
        found = law.labels.interpolate(columns, panel_rule(law.labels.edges, _ON_PANEL)[0]).T
        return found[:3], found[3:6], found[6:]

    def joint(self, x: Floats, v: Floats) -> Floats:
        x, v = np.broadcast_arrays(x, v)
        potential = self.balance.problem.potential
        inside = (x >= potential.low) & (x <= potential.high)
        x = np.where(inside, x, 0.0)
        levels, slopes, (fall, mean_slope) = self._table
        powers = np.stack([np.ones_like(x), x, -0.5 * x * x])
        energy = potential.energy(x) + 0.5 * v * v

        def at(rows: Floats, node: NDArray[np.intp]) -> Floats:
            return np.asarray(np.sum(rows[:, node] * powers, axis=0))

        last = fall.size - 1
        low, high = np.zeros(x.shape, dtype=np.intp), np.full(x.shape, last)
        for _ in range(last.bit_length()):
            middle = (low + high) // 2
            beyond = at(levels, middle) > energy
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        low = np.minimum(low, last - 1)
        high = low + 1
        lower, upper = at(levels, low) - energy, at(levels, high) - energy
        part = np.clip(-lower / (upper - lower), 0.0, 1.0)

        def between(first: Floats, second: Floats) -> Floats:
            return first + (second - first) * part

        slope = between(at(slopes, low), at(slopes, high))
        density = np.exp(-between(fall[low], fall[high])) * between(mean_slope[low], mean_slope[high]) / slope
        return np.where(inside & (at(levels, np.full(x.shape, last)) > energy), density, 0.0)

    def x_density(self, x: Floats) -> Floats:
        levels, _, _ = self._table
        potential = self.balance.problem.potential
        inside = np.clip(x, potential.low, potential.high)
        room = levels[0, -1] + levels[1, -1] * inside - 0.5 * levels[2, -1] * inside**2 - potential.energy(inside)
        unit, weights = panel_rule(_WIDER, _CROSS)
        top = np.sqrt(2.0 * np.maximum(room, 0.0))[..., None]
        return np.asarray(2.0 * np.sum(self.joint(x[..., None], top * unit) * top * weights, axis=-1))

    def v_density(self, v: Floats) -> Floats:
        cycles = self.balance.cycles
        assert isinstance(cycles, CyclesInWell)
        left, right = float(cycles.left.min()), float(cycles.right.max())
        rest = float(cycles.least[0])
        sides = [rest + (end - rest) * _WIDER for end in (left, right) if end != rest]
        x, weights = (
            np.concatenate(each) for each in zip(*(panel_rule(side, 2 * _CROSS) for side in sides), strict=True)
        )
        return np.asarray(np.sum(self.joint(x, v[..., None]) * np.abs(weights), axis=-1))


def _grid(low: float, high: float, corner: float) -> Floats:
    """From low to high through the corner, denser near it: even in the root of the distance from it."""
    ends = signed_root(np.array([low, high]) - corner)
    if ends[0] >= 0.0:
        below, above = np.zeros(0), np.linspace(ends[0], ends[1], _GRID)
    else:
        count = max(int(_GRID * -ends[0] / (ends[1] - ends[0])), 20)
        below, above = np.linspace(ends[0], 0.0, count + 1)[:-1], np.linspace(0.0, ends[1], _GRID)
    grid = np.r_[corner - below**2, corner + above**2]
    grid[0], grid[-1] = low, high
    return np.asarray(grid)


def _cross(start: float, end: float) -> tuple[Floats, Floats]:
    """Gauss-Legendre rule between two points in three panels that widen away from the start (positive weights)."""
    nodes, weights = panel_rule(start + (end - start) * np.array([0.0, 0.12, 0.4, 1.0]), _CROSS)
    return nodes, np.abs(weights)
