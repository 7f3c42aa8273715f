"""Stationary densities of a solved equation, dimensionless; each is tabulated at first use."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from scipy import special

from springpot.machine.arrays import Floats
from springpot.theory.distributions import normal
from springpot.theory.mckean import slow_impact_power
from springpot.theory.methods.fokker_planck.equation import Impacts, response, speed_unit
from springpot.theory.methods.fokker_planck.transition import (
    Flow,
    QuadraticForm,
    free_spread,
    nothing_beyond,
    v_form,
    x_form,
)
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.numerics.tabulated import Tabulated
from springpot.theory.problem import Problem, Units

_NEAREST = 0.02  # distance to the wall, over the speed unit, down to which the joint density is computed
_NEAREST_X = 0.001  # the same for the density of x
_PLACES = np.array(
    [0.0, 0.02, 0.2, 0.7, 1.4, 2.2, 3.2, 4.5, 6.0, 8.0, 11.0, 15.0, 20.0]
)  # ends of panels, typical ones
_ON_PANEL, _KNOTS = 10, 40  # of a table: values computed on a panel, and knots of the cubics
_SHARP, _PANELS = 0.16, 32  # panels of time per factor e: for a path of unit relative width, and at most
_FALL = np.array(
    [0.0, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 15.0, 27.0, 51.0, 99.0, 195.0, 387.0]
)  # of ln speed


@dataclass(frozen=True)
class Laws:
    """The densities of the displacement, the velocity, both, and the speed of impacts.

    Parameters
    ----------
    problem : Problem
    impacts : Impacts
        The solution of the equation.
    units : Units
    x_root, v_root : float
        Root mean squares of x and v.
    """

    problem: Problem
    impacts: Impacts
    units: Units
    x_root: float
    v_root: float

    def x(self, displacement: Floats) -> Floats:
        """Density of x."""
        return self._x_law.density(displacement - self.problem.position)

    def v(self, velocity: Floats) -> Floats:
        """Density of v."""
        return self._v_law.density(velocity)

    def joint(self, displacement: Floats, velocity: Floats) -> Floats:
        """Density of (x, v), for arrays of one shape."""
        problem, v = self.problem, velocity
        gap = displacement - problem.position
        inside = (gap >= 0.0) & (gap <= nothing_beyond(problem)) & (np.abs(v) <= nothing_beyond(problem))
        density = np.zeros(gap.shape)
        for distance in np.unique(gap[inside]):
            row = inside & (gap == distance)
            if distance == 0.0:
                density[row] = self._at_wall(v[row])
            else:
                law = self._law_of_v(float(distance))
                density[row] = law.density(v[row]) * self._x_law.density(np.asarray(distance))
        return density

    def impact_speed(self, speed: Floats) -> Floats:
        """Density of the speed of impacts."""
        return np.asarray(self.flux(speed) / self.impacts.mass)

    def _law_of_v(self, gap: float) -> Tabulated:
        """Density of v, given a distance from the wall."""
        nearest, edges = self._nearest, self._v_edges
        if gap >= nearest:
            return _tabulated(lambda v: self._slice(gap, v), edges)
        # nearer to the wall, slow speeds scale as gap^(1/3), and the density of fast ones hardly changes
        share, stretch = gap / nearest, (nearest / gap) ** (1.0 / 3.0)
        there, height = self._nearest_law, float(self._x_law.density(np.asarray(nearest)))

        border = 4.0 * nearest ** (1.0 / 3.0)
        sides = np.array([-border, border])
        change = self._at_wall(sides) / (height * there.density(sides)) - 1.0  # from the distance to the wall

        def scaled(v: Floats) -> Floats:
            wall, far = self._at_wall(v), self._at_wall(stretch * v)
            slow = np.exp(-((stretch * v / border) ** 4))
            known = (slow > 1e-9) & (far > 0.0)
            alike = np.divide(wall * height * there.density(stretch * v), far, out=np.zeros_like(v), where=known)
            alike *= 1.0 + (1.0 - share) * np.where(v < 0.0, change[0], change[1])
            fast = share * height * there.density(v) + (1.0 - share) * wall
            return np.asarray(slow * alike + (1.0 - slow) * fast)

        slow = edges[edges > 0.0][0] * np.geomspace(min(1.0 / stretch, 0.5), 0.5, max(2, math.ceil(math.log2(stretch))))
        return _tabulated(scaled, np.unique(np.concatenate([edges, -slow, slow])))

    @cached_property
    def _nearest(self) -> float:
        """Smallest distance at which densities of v are computed; times of flight to it vary by sqrt(s / v^3)."""
        return max(
            _NEAREST * speed_unit(self.problem), (_SHARP / _PANELS) ** 2 * (4.0 * free_spread(self.problem)) ** 3
        )

    @cached_property
    def _nearest_law(self) -> Tabulated:
        return self._law_of_v(self._nearest)

    def _slice(self, gap: float, v: Floats) -> Floats:
        """Dimensionless joint density at one distance from the wall."""
        problem = self.problem
        swift = min(float(np.max(np.abs(v))), 4.0 * free_spread(problem))

        def form(problem: Problem, time: Floats) -> QuadraticForm:
            return QuadraticForm.at(problem, time, gap)

        x = np.asarray(problem.position + gap)
        free = normal(x, free_spread(problem) ** 2) * normal(v, free_spread(problem) ** 2)
        panels = max(4, math.ceil(_SHARP * math.sqrt(swift**3 / gap)))
        return np.maximum(free + response(problem, self.impacts, form, v, self._first(gap), 4, panels), 0.0)

    def _first(self, gap: float) -> float:
        """Logarithm of the shortest time of flight to this distance from the wall."""
        return math.log(min((gap * gap / 60.0) ** (1.0 / 3.0), gap / float(self.impacts.speed[-1]) / 3.0))

    def _at_wall(self, v: Floats) -> Floats:
        """Dimensionless joint density at the wall: impact speed u, rebound speed r u."""
        struck = np.where(v < 0.0, -v, v / self.problem.restitution)
        flux = self.flux(struck) * (self.impacts.moment(0) / self.impacts.mass)
        return np.asarray(flux / np.maximum(struck, 1e-300) / np.where(v < 0.0, 1.0, self.problem.restitution**2))

    def flux(self, u: Floats) -> Floats:
        """Impacts per unit time and speed, dimensionless."""
        impacts, unit = self.impacts, speed_unit(self.problem)
        y = np.log(np.expm1(np.clip(u, 1e-300, impacts.speed[-1]) / unit))
        first = impacts.position[0]
        log_weight = impacts.log_weight(np.maximum(y, first)) + impacts.power * np.minimum(y - first, 0.0)
        density = np.exp(log_weight) / (impacts.spacing * unit * special.expit(y))
        return np.asarray(np.where((u >= 0.0) & (u <= impacts.speed[-1]), density, 0.0))

    @cached_property
    def _v_edges(self) -> Floats:
        """Panels of the velocity."""
        farthest = min(nothing_beyond(self.problem), 1.5 * float(self.impacts.speed[-1]) + abs(self.problem.position))
        edges = self.v_root * _PLACES
        edges = np.append(edges[edges < 0.9 * farthest], farthest)
        return np.concatenate([-edges[:0:-1], edges])

    @cached_property
    def _v_law(self) -> Tabulated:
        problem = self.problem

        # before this time the densities of v are narrower than the spacing of the speeds in the response's sum
        first = (speed_unit(problem) * self.impacts.spacing / 8.0) ** 2

        def density(v: Floats) -> Floats:
            later = response(problem, self.impacts, v_form, v, math.log(first), 8, 4)
            return normal(v, free_spread(problem) ** 2) + self._just_after(v, first) + later

        return _tabulated(density, self._v_edges)

    def _just_after(self, v: Floats, end: float) -> Floats:
        """Contribution of impacts to the density of v until this short time after each.

        Fast speeds are averaged over the noise; near 0, where the flux may vary like a root, slow speeds are summed.
        """
        nodes, weights = np.polynomial.hermite_e.hermegauss(16)
        fall, measure = panel_rule(_FALL, 16)
        slow = 14.0 * np.exp(-fall)
        measure = measure * slow
        total = np.zeros(v.size)
        r = self.problem.restitution
        for log, share in zip(*panel_rule([-10.0, 0.0], 16), strict=True):  # ln t, from e^-10 of the end
            time = end * math.exp(log)
            flow = Flow.at(self.problem.coefficient, np.array([time]))
            spread, kept = math.sqrt(float(flow.v_v[0])), float(flow.kick_rate[0])
            place = v + self.problem.position * float(flow.kick[0])
            near = np.abs(place) < 7.0 * spread
            left = (place[~near, None] + spread * nodes) / kept
            density = np.zeros(v.size)
            density[~near] = (self.flux(left / r) / r - self.flux(-left)) @ weights / (weights.sum() * kept)
            u = spread * slow
            given, taken = self.flux(u / r) / r, self.flux(u)
            arrived = [normal(place[near, None] - sign * kept * u, spread**2) for sign in (1.0, -1.0)]
            density[near] = (arrived[0] * given - arrived[1] * taken) @ (measure * spread)
            total += share * time * density
        return total

    @cached_property
    def _x_law(self) -> _NearWall:
        problem = self.problem
        nearest = _NEAREST_X * speed_unit(problem)
        typical = self.x_root + abs(problem.position)
        edges = np.append(nearest * np.array([1.0, 4.0, 20.0, 100.0]), typical * _PLACES)
        farthest = min(nothing_beyond(problem), 1.5 * float(self.impacts.speed[-1]) + 2.0 * abs(problem.position))
        edges = np.append(np.unique(edges[(edges >= nearest) & (edges < 0.9 * farthest)]), farthest)

        def density(gap: Floats) -> Floats:
            free = normal(problem.position + gap, free_spread(problem) ** 2)
            return free + response(problem, self.impacts, x_form, problem.position + gap, self._first(nearest), 16, 2)

        return _NearWall.make(_tabulated(density, edges), nearest, slow_impact_power(problem.restitution))


@dataclass(frozen=True)
class _NearWall:
    """A density of the distance from the wall: a table, and below it a + D s^3 + C s^(m-1), s = distance^(1/3).

    Normalized to 1.  Slow impacts with a rate ~ u^m give speeds ~ distance^(1/3), of density ~ distance^((m-2)/3).
    """

    table: Tabulated
    nearest: float
    power: float
    share: float  # of the table in the whole
    singular: float  # C, times 1 / (m-1)
    regular: float  # slope by the distance

    @classmethod
    def make(cls, table: Tabulated, nearest: float, power: float) -> _NearWall:
        """Continue a table of mass 1 that begins at the nearest distance."""
        bare = cls(table, nearest, power, 1.0, 0.0, 0.0)
        first, *others = table.density(nearest * np.array([1.0, 8.0, 27.0]))
        rises = bare._rise(nearest * np.array([8.0, 27.0]))
        singular, regular = np.linalg.solve(np.stack([rises, nearest * np.array([7.0, 26.0])], axis=1), others - first)
        # never negative
        most = 0.0 if power <= 1.0 else (regular * nearest - first) / float(bare._rise(np.zeros(1))[0])
        singular = min(float(singular), max(float(most), 0.0))
        inside = (
            first * nearest - regular * nearest**2 / 2.0 - singular * nearest ** ((power + 2.0) / 3.0) / (power + 2.0)
        )
        return cls(table, nearest, power, 1.0 / (1.0 + float(inside)), singular, float(regular))

    def density(self, gap: Floats) -> Floats:
        """The density; 0 behind the wall."""
        first = float(self.table.density(np.asarray(self.nearest)))
        inside = np.clip(gap, 0.0, self.nearest)
        near = first + self.singular * self._rise(inside) + self.regular * (inside - self.nearest)
        density = np.where(gap < self.nearest, near, self.table.density(gap))
        return np.asarray(np.where(gap < 0.0, 0.0, self.share * density))

    def _rise(self, gap: Floats) -> Floats:
        """(s^(m-1) - nearest^((m-1)/3)) / (m-1); at the wall that of a very small distance."""
        power = (self.power - 1.0) / 3.0
        log = np.log(np.maximum(gap / self.nearest, 1e-15))
        return np.asarray(self.nearest**power * special.exprel(power * log) * log / 3.0)


def _tabulated(density: Callable[[Floats], Floats], edges: Floats) -> Tabulated:
    """Polynomials of the cube root of the argument on panels, then a table on many more knots."""
    root = np.cbrt(edges)
    # edges chosen in different units may nearly coincide; the last edge stays
    apart = np.diff(root) > 1e-6 * np.ptp(root)
    edges = edges[np.append(apart, True)]
    root = np.cbrt(edges)
    half, middle = np.diff(root)[:, None] / 2.0, (root[1:, None] + root[:-1, None]) / 2.0
    nodes = chebyshev.chebpts1(_ON_PANEL)
    sampled = density(((middle + half * nodes) ** 3).ravel()).reshape(half.size, _ON_PANEL)
    series = 2.0 / _ON_PANEL * sampled @ chebyshev.chebvander(nodes, _ON_PANEL - 1)
    series[:, 0] /= 2.0
    fine = np.linspace(-1.0, 1.0, _KNOTS + 1)[:-1]
    values = series @ chebyshev.chebvander(fine, _ON_PANEL - 1).T
    place = np.append(((middle + half * fine) ** 3).ravel(), edges[-1])
    place[:: fine.size] = edges
    return Tabulated.make(place, np.maximum(np.append(values.ravel(), series[-1].sum()), 0.0))
