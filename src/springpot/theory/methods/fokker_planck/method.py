"""Inelastic impacts: the stationary Fokker-Planck equation with a dashpot, as one integral equation.

Dimensionless (time 1 / Omega, length sqrt(q / Omega^3)), with b the wall and r its restitution, the density of (x, v)
obeys L p = 0 beyond the wall, and what leaves the wall at speed r u is what struck it at speed u.  Let p be 0 behind
the wall.  Then on the whole plane L p = (flux taken at (b, -u)) - (flux given back at (b, r u)), so that

    p(z) = p_free(z) + int_0^inf du f(u) int_0^inf dt [P_t(z | b, r u) - P_t(z | b, -u)],

with P_t the normal transition density of the oscillator without a wall, p_free its stationary density, and f(u) du the
rate of impacts with speed u.  That p is indeed 0 behind the wall is a Fredholm equation of the second kind for f alone,

    f(u) / u = p_free(b, -u) + int_0^inf du' f(u') int_0^inf dt [P_t(b, -u | b, r u') - P_t(b, -u | b, -u')],

where the instant t = 0 has been taken out (it is the left-hand side).  Towards u = 0 its kernel is
sqrt(3) / (2 pi Q) with Q = u^2 + u v + v^2, whatever the oscillator; the power law of slow impacts follows from it by
itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray
from scipy import interpolate, special

from springpot.oscillator import Oscillator
from springpot.theory.distributions import normal, numbers_only, real_array
from springpot.theory.linear import dashpot_mean_squares
from springpot.theory.mckean import COLLAPSE_BELOW, slow_impact_power
from springpot.theory.numerics.tabulated import Tabulated
from springpot.theory.result import Moments, NotCovered, Result

__all__ = ["FokkerPlanck", "fokker_planck"]

FloatArray = NDArray[np.float64]

"""Restitution at and below which infinitely many impacts follow in finite time (McKean)."""

_LIGHTEST = 3e-3  # of c; the time integral is 36/c long
_STRONGEST = 50.0
_DEEPEST = 4.0  # b over the free standard deviation of x, beyond which the equation loses too many digits
_FAR_BEHIND = -6.0  # where impacts are too rare to be told from rounding
_LOWEST = 0.18  # of the restitution: slow impacts then count down to 1e-200 of the typical speed

_REACH = (
    f"The Fokker-Planck solution covers order 1 with a wall of restitution above exp(-pi/sqrt 3) = {COLLAPSE_BELOW:.3f}"
)
_SMALL = math.exp(-10.0)  # of a speed: below it the kernel is its own small-speed limit
_SMALLEST = math.exp(-13.0)  # below it the kernel is linear in the speed of departure
_NEAREST = 0.02  # distance to the wall, over the speed unit, down to which the joint density is computed
_NEAREST_X = 0.001  # the same for the density of x
_PLACES = np.array(
    [0.0, 0.02, 0.2, 0.7, 1.4, 2.2, 3.2, 4.5, 6.0, 8.0, 11.0, 15.0, 20.0]
)  # ends of panels, typical ones
_ON_PANEL, _KNOTS = 10, 40  # of a table: values computed on a panel, and knots of the cubics
_SHARP, _PANELS = 0.16, 32  # panels of time to a factor e: needed for a path known to 1, and at most
_FALL = np.array(
    [0.0, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 15.0, 27.0, 51.0, 99.0, 195.0, 387.0]
)  # of ln speed
_GAUSS = np.polynomial.legendre.leggauss(16)
_KEEPING_UP = 20.0  # speed up to which the longest panels of time see an impact
_REFUSED = 1e-2  # estimated error at which an answer is none
_EXPONENTIALS = 2_000_000  # evaluated at once


@dataclass(frozen=True)
class _Grid:
    """How fine: spacing of the speeds, Gauss nodes and longest panel in time, free decay kept, range of speeds."""

    spacing: float
    nodes: int
    panel: float
    decay: float
    reach: float


_COARSE = _Grid(spacing=0.32, nodes=6, panel=0.4, decay=14.0, reach=6.0)
_FINE = _Grid(spacing=0.25, nodes=8, panel=0.45, decay=18.0, reach=6.8)


@dataclass(frozen=True)
class _Problem:
    """Dimensionless damping, wall and restitution."""

    c: float
    wall: float
    r: float

    @property
    def spread(self) -> float:
        """Standard deviation of x and of v without the wall."""
        return math.sqrt(0.5 / self.c)

    @property
    def farthest(self) -> float:
        """Where every density is below rounding."""
        return 8.5 * self.spread + abs(self.wall)


@dataclass(frozen=True)
class _Impacts:
    """Rate of impacts by speed: ``weight[i]`` of them per unit time have a speed near ``speed[i]``."""

    position: FloatArray  # y, with speed = scale * log(1 + e^y)
    speed: FloatArray
    weight: FloatArray
    spacing: float
    power: float  # with which slower ones get rarer

    @cached_property
    def log_weight(self) -> interpolate.CubicSpline:
        """ln weight between the nodes, a function of y."""
        return interpolate.CubicSpline(self.position, np.log(self.weight))

    @cached_property
    def mass(self) -> float:
        """Rate, as the integral of what is interpolated and, below the nodes, continued by the power."""
        half = self.spacing / 2.0
        y = self.position[:-1, None] + half * (_GAUSS[0] + 1.0)
        total = float(np.sum(np.exp(self.log_weight(y)) @ _GAUSS[1])) * half
        return (total + float(self.weight[0]) / self.power) / self.spacing

    def moment(self, power: int) -> float:
        """Rate times the mean of speed^power."""
        return float(self.weight @ self.speed**power)


@dataclass(frozen=True)
class FokkerPlanck(Result):
    """The stationary density of (x, v) with impacts that lose energy.

    Parameters
    ----------
    error_estimate : float
        Largest relative difference of a moment (an x_mean near 0 against the root mean square) between the answer and
        one on a coarser grid; the answer's own error is smaller.
    impact_rate_error : float
        The same for the impact rate alone: slow impacts, as frequent as speed^g with g falling to -1 at the
        restitution of inelastic collapse, count there and hardly anywhere else.

    Notes
    -----
    The other parameters are those of `springpot.theory.result.Result`.
    """

    error_estimate: float
    impact_rate_error: float

    @numbers_only
    def impact_speed_density(self, speed: ArrayLike) -> FloatArray:
        """Density of the speed just before an impact, in s/m.

        Parameters
        ----------
        speed : array_like
            In m/s.

        Raises
        ------
        NoStationaryState
            If there is no stationary state.
        TypeError
            If an argument is not a number.
        ValueError
            If there is no noise: the mass rests, and has no density.

        Examples
        --------
        >>> from springpot.oscillator import Barrier, Springpot
        >>> lossy = Oscillator(springpot=Springpot(1.0, 0.2), barrier=Barrier(restitution=0.8))
        >>> fokker_planck(lossy).impact_speed_density([0.0, 1.0]).round(3)
        array([0.   , 0.432])
        """
        scale = self._scale().speed_scale
        u = real_array(speed, "speed") / scale
        return np.asarray(self._flux(u) / (self._impacts.mass * scale))

    @numbers_only
    def x_density(self, displacement: ArrayLike) -> FloatArray:
        """Density of x, in 1/m.

        Parameters and errors are those of `impact_speed_density`, with x in m.  Within 0.001 sqrt(q / Omega^3) of the
        wall, where slow impacts may raise a sharp maximum (infinite for r at most 0.5), it is continued by the power
        law of that maximum.  The first call tabulates it, which takes a few tenths of a second.

        Examples
        --------
        >>> from springpot.oscillator import Barrier, Springpot
        >>> lossy = Oscillator(springpot=Springpot(1.0, 0.2), barrier=Barrier(restitution=0.8))
        >>> fokker_planck(lossy).x_density([-0.1, 1.0]).round(3)
        array([0.   , 0.451])
        """
        length = self._scale().length_scale
        gap = self._mirrored(displacement, "displacement") / length - self._problem.wall
        return np.asarray(self._x_law.density(gap) / length)

    @numbers_only
    def v_density(self, velocity: ArrayLike) -> FloatArray:
        """Density of the velocity, in s/m.

        Parameters and errors are those of `impact_speed_density`, with v in m/s.  The first call tabulates it, which
        takes a few tenths of a second; between the knots it is interpolated to 1e-7 of its maximum.

        Examples
        --------
        >>> from springpot.oscillator import Barrier, Springpot
        >>> lossy = Oscillator(springpot=Springpot(1.0, 0.2), barrier=Barrier(restitution=0.8))
        >>> fokker_planck(lossy).v_density([-0.5, 0.0, 0.5]).round(3)
        array([0.281, 0.325, 0.321])
        """
        scale = self._scale().speed_scale
        return np.asarray(self._v_law.density(self._mirrored(velocity, "velocity") / scale) / scale)

    @numbers_only
    def joint_density(self, displacement: ArrayLike, velocity: ArrayLike) -> FloatArray:
        """Density of (x, v), in s/m^2; the arguments are broadcast.

        Parameters and errors are those of `impact_speed_density`, with x in m and v in m/s.  It takes 0.1 to 0.6 s for
        each different displacement: its law of v is tabulated, so that its integral over v is the density of x.  Very
        near the wall (0.02 sqrt(q / Omega^3), more where speeds are high) the slow speeds follow the law of that
        distance, scaled as (distance)^(1/3).  Good to 1e-3 of its maximum near the wall, 1e-4 elsewhere.

        Examples
        --------
        >>> from springpot.oscillator import Barrier, Springpot
        >>> lossy = Oscillator(springpot=Springpot(1.0, 0.2), barrier=Barrier(restitution=0.8))
        >>> fokker_planck(lossy).joint_density(0.5, [-1.0, 1.0]).round(3)
        array([0.127, 0.157])
        """
        length, speed = self._scale().length_scale, self._scale().speed_scale
        problem = self._problem
        x, v = np.broadcast_arrays(
            self._mirrored(displacement, "displacement") / length, self._mirrored(velocity, "velocity") / speed
        )
        gap = x - problem.wall
        inside = (gap >= 0.0) & (gap <= problem.farthest) & (np.abs(v) <= problem.farthest)
        density = np.zeros(x.shape)
        for distance in np.unique(gap[inside]):
            row = inside & (gap == distance)
            if distance == 0.0:
                density[row] = self._at_wall(v[row])
            else:
                law = self._law_of_v(float(distance))
                density[row] = law.density(v[row]) * self._x_law.density(np.asarray(distance))
        return density / (length * speed)

    def _law_of_v(self, gap: float) -> Tabulated:
        """Density of v, given a distance from the wall."""
        problem = self._problem
        # a path from the wall to (x, v) takes a time known to sqrt(gap / v^3) of itself
        nearest = max(_NEAREST * _speed_unit(problem), (_SHARP / _PANELS) ** 2 * (4.0 * problem.spread) ** 3)
        edges = self._v_edges
        if gap >= nearest:
            return _tabulated(lambda v: self._slice(gap, v), edges)
        # nearer, the slow are those of this distance, in units of a speed ~ gap^(1/3); the fast hardly change
        share, stretch = gap / nearest, (nearest / gap) ** (1.0 / 3.0)
        there, height = self._nearest_law(nearest), float(self._x_law.density(np.asarray(nearest)))

        border = 4.0 * nearest ** (1.0 / 3.0)
        sides = np.array([-border, border])
        change = self._at_wall(sides) / (height * there.density(sides)) - 1.0  # with the distance, of no speed

        def scaled(v: FloatArray) -> FloatArray:
            wall, far = self._at_wall(v), self._at_wall(stretch * v)
            slow = np.exp(-((stretch * v / border) ** 4))
            known = (slow > 1e-9) & (far > 0.0)
            alike = np.divide(wall * height * there.density(stretch * v), far, out=np.zeros_like(v), where=known)
            alike *= 1.0 + (1.0 - share) * np.where(v < 0.0, change[0], change[1])
            fast = share * height * there.density(v) + (1.0 - share) * wall
            return np.asarray(slow * alike + (1.0 - slow) * fast)

        slow = edges[edges > 0.0][0] * np.geomspace(min(1.0 / stretch, 0.5), 0.5, max(2, math.ceil(math.log2(stretch))))
        return _tabulated(scaled, np.unique(np.concatenate([edges, -slow, slow])))

    @cache  # noqa: B019
    def _nearest_law(self, gap: float) -> Tabulated:
        return self._law_of_v(gap)

    def _slice(self, gap: float, v: FloatArray) -> FloatArray:
        """Dimensionless joint density at one distance from the wall."""
        problem = self._problem
        swift = min(float(np.max(np.abs(v))), 4.0 * problem.spread)

        def form(problem: _Problem, time: FloatArray) -> _QuadraticForm:
            return _QuadraticForm.at(problem, time, gap)

        x = np.asarray(problem.wall + gap)
        free = normal(x, problem.spread**2) * normal(v, problem.spread**2)
        panels = max(4, math.ceil(_SHARP * math.sqrt(swift**3 / gap)))
        return np.maximum(free + _response(problem, self._impacts, form, v, self._first(gap), 4, panels), 0.0)

    def _first(self, gap: float) -> float:
        """Logarithm of the time before which nothing gets this far from the wall."""
        return math.log(min((gap * gap / 60.0) ** (1.0 / 3.0), gap / float(self._impacts.speed[-1]) / 3.0))

    def _at_wall(self, v: FloatArray) -> FloatArray:
        """Dimensionless joint density at the wall: what arrives at u leaves at r u."""
        struck = np.where(v < 0.0, -v, v / self._problem.r)
        flux = self._flux(struck) * (self._impacts.moment(0) / self._impacts.mass)
        return np.asarray(flux / np.maximum(struck, 1e-300) / np.where(v < 0.0, 1.0, self._problem.r**2))

    def _flux(self, u: FloatArray) -> FloatArray:
        """Impacts per unit time and speed, dimensionless."""
        impacts, unit = self._impacts, _speed_unit(self._problem)
        y = np.log(np.expm1(np.clip(u, 1e-300, impacts.speed[-1]) / unit))
        first = impacts.position[0]
        log_weight = impacts.log_weight(np.maximum(y, first)) + impacts.power * np.minimum(y - first, 0.0)
        density = np.exp(log_weight) / (impacts.spacing * unit * special.expit(y))
        return np.asarray(np.where((u >= 0.0) & (u <= impacts.speed[-1]), density, 0.0))

    @cached_property
    def _v_edges(self) -> FloatArray:
        """Panels of the velocity."""
        typical = math.sqrt(self.v_mean_square) / self.oscillator.speed_scale
        farthest = min(self._problem.farthest, 1.5 * float(self._impacts.speed[-1]) + abs(self._problem.wall))
        edges = typical * _PLACES
        edges = np.append(edges[edges < 0.9 * farthest], farthest)
        return np.concatenate([-edges[:0:-1], edges])

    @cached_property
    def _v_law(self) -> Tabulated:
        problem = self._problem

        # before this time the laws of v are narrower than the spacing of the speeds that the response sums over
        first = (_speed_unit(problem) * self._impacts.spacing / 8.0) ** 2

        def density(v: FloatArray) -> FloatArray:
            later = _response(problem, self._impacts, _v_form, v, math.log(first), 8, 4)
            return normal(v, problem.spread**2) + self._just_after(v, first) + later

        return _tabulated(density, self._v_edges)

    def _just_after(self, v: FloatArray, end: float) -> FloatArray:
        """What the impacts add to the density of v until this short time after each.

        Fast speeds are averaged over the noise; next to 0, where the flux may be a root, the slow ones are summed up.
        """
        nodes, weights = np.polynomial.hermite_e.hermegauss(16)
        half = np.diff(_FALL)[:, None] / 2.0
        slow = 14.0 * np.exp(-(_FALL[:-1, None] + half * (_GAUSS[0] + 1.0)).ravel())
        measure = (half * _GAUSS[1]).ravel() * slow
        total = np.zeros(v.size)
        r = self._problem.r
        for log, share in zip(5.0 * (_GAUSS[0] - 1.0), 5.0 * _GAUSS[1], strict=True):  # ln t, from e^-10 of the end
            time = end * math.exp(log)
            flow = _Flow.at(self._problem.c, np.array([time]))
            spread, kept = math.sqrt(float(flow.v_v[0])), float(flow.kick_rate[0])
            place = v + self._problem.wall * float(flow.kick[0])
            near = np.abs(place) < 7.0 * spread
            left = (place[~near, None] + spread * nodes) / kept
            found = np.zeros(v.size)
            found[~near] = (self._flux(left / r) / r - self._flux(-left)) @ weights / (weights.sum() * kept)
            u = spread * slow
            given, taken = self._flux(u / r) / r, self._flux(u)
            arrived = [normal(place[near, None] - sign * kept * u, spread**2) for sign in (1.0, -1.0)]
            found[near] = (arrived[0] * given - arrived[1] * taken) @ (measure * spread)
            total += share * time * found
        return total

    @cached_property
    def _x_law(self) -> _NearWall:
        problem, length = self._problem, self.oscillator.length_scale
        nearest = _NEAREST_X * _speed_unit(problem)
        typical = math.sqrt(self.x_mean_square) / length + abs(problem.wall)
        edges = np.append(nearest * np.array([1.0, 4.0, 20.0, 100.0]), typical * _PLACES)
        farthest = min(problem.farthest, 1.5 * float(self._impacts.speed[-1]) + 2.0 * abs(problem.wall))
        edges = np.append(np.unique(edges[(edges >= nearest) & (edges < 0.9 * farthest)]), farthest)

        def density(gap: FloatArray) -> FloatArray:
            free = normal(problem.wall + gap, problem.spread**2)
            return free + _response(problem, self._impacts, _x_form, problem.wall + gap, self._first(nearest), 16, 2)

        return _NearWall.make(_tabulated(density, edges), nearest, slow_impact_power(problem.r))

    def _mirrored(self, value: ArrayLike, name: str) -> FloatArray:
        """The argument, mirrored where the mass moves below the wall."""
        array, wall = real_array(value, name), self.oscillator.barrier
        return -array if wall is not None and wall.side == "below" else array

    def to_dict(self) -> dict[str, object]:
        """The common dictionary of `Result.to_dict`, and both error estimates."""
        common = super().to_dict()
        tail = {name: common.pop(name) for name in ("assumptions", "warnings")}
        errors = {"error_estimate": self.error_estimate, "impact_rate_error": self.impact_rate_error}
        return {**common, **errors, **tail}

    @cached_property
    def _problem(self) -> _Problem:
        return _problem(self.oscillator)

    @cached_property
    def _impacts(self) -> _Impacts:
        return _solve(self._problem, _FINE)

    def _scale(self) -> Oscillator:
        _ = self.moments
        if self.oscillator.length_scale == 0.0:
            raise ValueError("there is no density: without noise the mass rests.")
        return self.oscillator


@dataclass(frozen=True)
class _NearWall:
    """A density of the distance from the wall: a table, and nearer than it a + D s^3 + C s^(m-1), s^3 being it; mass 1.

    Slow impacts as rare as u^m leave speeds ~ (distance)^(1/3) of a density ~ (distance)^((m-2)/3).
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

    def density(self, gap: FloatArray) -> FloatArray:
        """The density; 0 behind the wall."""
        first = float(self.table.density(np.asarray(self.nearest)))
        inside = np.clip(gap, 0.0, self.nearest)
        near = first + self.singular * self._rise(inside) + self.regular * (inside - self.nearest)
        found = np.where(gap < self.nearest, near, self.table.density(gap))
        return np.asarray(np.where(gap < 0.0, 0.0, self.share * found))

    def _rise(self, gap: FloatArray) -> FloatArray:
        """(s^(m-1) - nearest^((m-1)/3)) / (m-1); at the wall it is that of a distance that is next to nothing."""
        power = (self.power - 1.0) / 3.0
        log = np.log(np.maximum(gap / self.nearest, 1e-15))
        return np.asarray(self.nearest**power * special.exprel(power * log) * log / 3.0)


def _tabulated(density: Callable[[FloatArray], FloatArray], edges: FloatArray) -> Tabulated:
    """Polynomials of the cube root of the argument on panels, then a table on many more knots."""
    root = np.cbrt(edges)
    # places chosen in different units may all but meet; the last edge stays
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


def fokker_planck(oscillator: Oscillator) -> FokkerPlanck:
    """Solve the stationary Fokker-Planck equation of an oscillator with a dashpot and a wall that takes energy.

    Parameters
    ----------
    oscillator : Oscillator
        Of order 1 with a wall of restitution above 0.163; elastic walls are solved the same way (`exact` is faster).

    Returns
    -------
    FokkerPlanck
        Moments to about 1e-6, and an estimate of their error from two grids.

    Raises
    ------
    NotCovered
        If the order is not 1, there is no wall, the restitution is too low, or the damping or the wall's position is so
        extreme that the equation would lose its digits.
    TypeError
        If ``oscillator`` is not an Oscillator.

    Notes
    -----
    See the module's first lines.  From f follow <x> = (1+r) N <u>, the energy balance
    c <v^2> = 1/2 - (1-r^2) N <u^2> / 2 and <x^2> = <v^2> + b <x>, with N the rate and u the speed of the impacts.

    Examples
    --------
    >>> from springpot.oscillator import Barrier, Springpot
    >>> lossy = Oscillator(springpot=Springpot(order=1.0, coefficient=0.2), barrier=Barrier(restitution=0.8))
    >>> result = fokker_planck(lossy)
    >>> round(result.x_mean_square, 4), round(result.impact_rate, 4), result.error_estimate < 1e-4
    (1.4917, 0.3346, True)
    """
    if not isinstance(oscillator, Oscillator):
        raise TypeError(f"oscillator must be an Oscillator, not {oscillator!r}.")
    statement = _check_covered(oscillator)
    if isinstance(statement, str):
        return _result(oscillator, statement)
    if oscillator.length_scale == 0.0:
        wall = oscillator.barrier
        place = wall.position if wall is not None and oscillator.dimensionless_position > 0.0 else 0.0
        return _result(oscillator, Moments(place**2, place, place**2, 0.0, 0.0, math.nan, math.nan))
    problem = _problem(oscillator)
    fine, coarse = (_moments(problem, _solve(problem, grid)) for grid in (_FINE, _COARSE))
    error, rate_error = _difference(fine, coarse)
    if not max(error, rate_error) < _REFUSED:
        raise NotCovered(
            f"{_REACH} where its equation keeps its digits, which it does not here: two grids differ by {error:.1g}."
        )
    length, speed = oscillator.length_scale, oscillator.speed_scale
    side = -1.0 if oscillator.barrier is not None and oscillator.barrier.side == "below" else 1.0
    moments = Moments(
        amplitude_mean_square=fine.amplitude_mean_square * length**2,
        x_mean=side * fine.x_mean * length,
        x_mean_square=fine.x_mean_square * length**2,
        v_mean_square=fine.v_mean_square * speed**2,
        impact_rate=fine.impact_rate * oscillator.natural_frequency,
        impact_speed_mean=fine.impact_speed_mean * speed,
        impact_speed_mean_square=fine.impact_speed_mean_square * speed**2,
    )
    return _result(oscillator, moments, error, rate_error)


def _result(
    oscillator: Oscillator, stationary: Moments | str, error: float = 0.0, rate_error: float = 0.0
) -> FokkerPlanck:
    return FokkerPlanck(
        method="fokker_planck",
        oscillator=oscillator,
        stationary=stationary,
        assumptions=("None but the numerical solution: its error is estimated from two grids.",),
        warnings=_warnings(error, rate_error),
        error_estimate=error,
        impact_rate_error=rate_error,
    )


def _warnings(error: float, rate_error: float) -> tuple[str, ...]:
    if max(error, rate_error) < 1e-4:
        return ()
    return (f"Two grids differ by {error:.1g} of a moment and {rate_error:.1g} of the impact rate.",)


def _check_covered(oscillator: Oscillator) -> str | None:
    """The sentence of an oscillator without a stationary state, None for one to be solved; the others are refused."""
    wall, alpha, c = oscillator.barrier, oscillator.springpot.order, oscillator.dimensionless_coefficient
    if wall is None:
        raise NotCovered(f"{_REACH}, not an oscillator without a wall.")
    if alpha != 1.0:
        raise NotCovered(f"{_REACH}, not order {alpha:g}.")
    if c == 0.0 and wall.restitution == 1.0:
        return (
            "There is no stationary state: nothing dissipates energy (C is 0, the wall is elastic), so the energy "
            "grows as q t / 2."
        )
    if wall.restitution < _LOWEST:
        raise NotCovered(f"{_REACH} (in practice {_LOWEST:g}), not restitution {wall.restitution:g}.")
    if not _LIGHTEST <= c <= _STRONGEST:
        raise NotCovered(f"{_REACH} and C/Omega in [{_LIGHTEST:g}, {_STRONGEST:g}], not {c:.3g}.")
    k = oscillator.dimensionless_position * math.sqrt(2.0 * c)
    if oscillator.length_scale > 0.0 and not _FAR_BEHIND <= k <= _DEEPEST:
        raise NotCovered(
            f"{_REACH} at {_FAR_BEHIND:g} to {_DEEPEST:g} standard deviations sqrt(q / 2 C Omega^2), not at {k:.3g}."
        )
    return None


def _problem(oscillator: Oscillator) -> _Problem:
    return _Problem(oscillator.dimensionless_coefficient, oscillator.dimensionless_position, oscillator.restitution)


def _moments(problem: _Problem, impacts: _Impacts) -> Moments:
    rate, first, second = (max(impacts.moment(power), 1e-300) for power in range(3))
    x_mean = (1.0 + problem.r) * first
    v_mean_square = (0.5 - (1.0 - problem.r**2) / 2.0 * second) / problem.c
    x_mean_square = v_mean_square + problem.wall * x_mean
    return Moments(
        amplitude_mean_square=x_mean_square + v_mean_square,
        x_mean=x_mean,
        x_mean_square=x_mean_square,
        v_mean_square=v_mean_square,
        impact_rate=rate,
        impact_speed_mean=first / rate,
        impact_speed_mean_square=second / rate,
    )


def _difference(fine: Moments, coarse: Moments) -> tuple[float, float]:
    changes = {
        field.name: abs(getattr(coarse, field.name) / getattr(fine, field.name) - 1.0) for field in fields(Moments)
    }
    changes["x_mean"] = abs(coarse.x_mean - fine.x_mean) / math.sqrt(fine.x_mean_square)
    return max(changes.values()), changes["impact_rate"]


def _speed_unit(problem: _Problem) -> float:
    """Speed below which the grid is logarithmic and above which it is uniform."""
    unit = min(1.0, problem.spread)
    if problem.wall > 0.0 and problem.r < 1.0:
        # a preload b bounces b / 2u times per unit time, and the noise makes up for losses of (1 - r^2) u^2 / 2
        unit = min(unit, 2.0 / ((1.0 - problem.r**2) * problem.wall))
    return unit


def _fastest(problem: _Problem, grid: _Grid) -> float:
    """Speed of impact beyond which there is nothing: the free spread bounds it, and so do the losses."""
    free = grid.reach * problem.spread
    if problem.r == 1.0:
        return free
    # an impact keeps r; half a period adds at most pi/2 of variance, to a free swing that has to reach the wall
    added = grid.reach * math.sqrt(1.6 / (1.0 - problem.r**2))
    gap = max(0.0, -problem.wall)
    return min(free, math.sqrt(added * (added + 2.0 * gap)))


def _solve(problem: _Problem, grid: _Grid) -> _Impacts:
    """Nystrom's method with the trapezoid rule in y, speed = unit * log(1 + e^y)."""
    r, unit, h = problem.r, _speed_unit(problem), grid.spacing
    fastest = _fastest(problem, grid)
    low = -math.log(1e10) / slow_impact_power(r)
    y = np.arange(low, fastest / unit + h, h)
    u = unit * np.logaddexp(0.0, y)
    measure = h * unit * special.expit(y) / u  # du / u
    source = u * u * np.exp(-(problem.wall**2 + u * u) * problem.c) * problem.c / math.pi
    kernel = _kernel(problem, grid, u)
    weight = np.linalg.solve(np.eye(u.size) - measure[:, None] * kernel, measure * source)
    peak = int(np.argmax(weight))
    lost = np.flatnonzero(weight[peak:] < 1e-13 * weight[peak])  # from there on rounding rules
    end = peak + int(lost[0]) if lost.size else u.size
    return _Impacts(y[:end], u[:end], weight[:end], h, slow_impact_power(r))


def _kernel(problem: _Problem, grid: _Grid, u: FloatArray) -> FloatArray:
    """u^2 int_0^inf [P_t(b, -u | b, r u') - P_t(b, -u | b, -u')] dt, a row for each u, a column for each u'."""
    r, unit = problem.r, _speed_unit(problem)
    first = min(int(np.searchsorted(u, _SMALLEST * unit)), u.size - 1)
    some = u[first:]
    total = np.zeros((some.size, 2 * some.size))
    depart = np.concatenate([r * some, -some])
    start = math.log((_SMALL * unit) ** 2 / 60.0)
    turn = math.log(min(0.3, 0.3 / problem.c))
    for time, weight in _panels(problem, grid, start, turn, 1):
        form = _QuadraticForm.at(problem, time)
        arrive_grid, depart_grid = -some, depart
        back = ahead = None
        if time[0] > 2.0:  # smooth by now: fewer speeds do, on which polynomials are interpolated
            arrive_grid, back = _interpolation(-some[-1], 0.0, form.arrival_width, -some)
            depart_grid, ahead = _interpolation(-some[-1], some[-1], form.departure_width, depart)
            if arrive_grid.size * depart_grid.size > total.size // 2:
                arrive_grid, depart_grid, back, ahead = -some, depart, None, None
        part = form.integrate(weight, arrive_grid, depart_grid)
        total += part if back is None or ahead is None else back @ part @ ahead.T
    difference = total[:, : some.size] - total[:, some.size :]
    index = np.maximum(np.arange(u.size) - first, 0)
    difference = difference[np.ix_(index, index)] * (u / some[index])
    ratio = np.exp(np.minimum(np.subtract.outer(-np.log(u), -np.log(u)), 300.0))  # u' / u
    limit = 1.0 / (1.0 - r * ratio + (r * ratio) ** 2) - 1.0 / (1.0 + ratio + ratio**2)
    small = np.maximum.outer(u, u) < _SMALL * unit
    return np.asarray(np.where(small, math.sqrt(3.0) / (2.0 * math.pi) * limit, (u * u)[:, None] * difference))


def _panels(
    problem: _Problem, grid: _Grid, start: float, turn: float, refine: int
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Nodes and weights of the integral over time: one block of early times, then blocks of times of like size.

    The early panels, between the logarithms ``start`` and ``turn``, have length 1 / ``refine`` in ln t.
    """
    c = problem.c
    x, w = np.polynomial.legendre.leggauss(grid.nodes)
    edges = np.exp(np.linspace(start, turn, math.ceil((turn - start) * refine) + 1))
    slowest = c / 2.0 if c < 2.0 else 1.0 / (c / 2.0 + math.sqrt((c / 2.0 - 1.0) * (c / 2.0 + 1.0)))
    last = grid.decay / slowest
    # the faster the impacts the sharper their times; without oscillation there is nothing to follow
    longest = grid.panel * min(1.0, _KEEPING_UP / _fastest(problem, grid)) if c < 2.0 else last
    later = [float(edges[-1])]
    while later[-1] < last:
        later.append(later[-1] + min(longest, 0.8 * later[-1]))
    # within one panel the early times are smooth in ln t, the later ones in t
    half = np.diff(np.log(edges)) / 2.0
    early = np.exp((np.log(edges[:-1]) + half)[:, None] + half[:, None] * x)
    yield early.reshape(-1), (half[:, None] * w * early).reshape(-1)
    ends = np.array(later)
    half = np.diff(ends) / 2.0
    time = (ends[:-1] + half)[:, None] + half[:, None] * x
    weight = half[:, None] * w
    block = np.floor(np.log2(np.maximum(time[:, 0], 1.0)) * 1.5)
    for number in np.unique(block):
        yield time[block == number].reshape(-1), weight[block == number].reshape(-1)


@dataclass(frozen=True)
class _QuadraticForm:
    """A density of arrival = height exp(-z' form z) with z = (arrival, departure, 1), for many times."""

    form: FloatArray  # of shape (times, 3, 3)
    height: FloatArray

    @classmethod
    def at(cls, problem: _Problem, time: FloatArray, gap: float = 0.0) -> _QuadraticForm:
        """Of P_t(b + gap, v | b, v')."""
        flow = _Flow.at(problem.c, time)
        dx = _row(0.0 * time, -flow.kick, gap + problem.wall * flow.slip)
        dv = _row(1.0 + 0.0 * time, -flow.kick_rate, problem.wall * flow.kick)
        mixed = _product(dx, dv, flow.x_v)
        form = _product(dx, dx, flow.v_v) + _product(dv, dv, flow.x_x) - mixed - mixed.transpose(0, 2, 1)
        height = 1.0 / (2.0 * math.pi * np.sqrt(flow.determinant))
        return cls(form / (2.0 * flow.determinant)[:, None, None], height)

    @classmethod
    def of_one(cls, line: FloatArray, variance: FloatArray) -> _QuadraticForm:
        """Of one normal variable: the line is zero at its mean."""
        return cls(_product(line, line, 0.5 / variance), 1.0 / np.sqrt(2.0 * math.pi * variance))

    @property
    def arrival_width(self) -> float:
        """Smallest standard deviation in the arrival."""
        return 1.0 / math.sqrt(2.0 * float(np.max(self.form[:, 0, 0])))

    @property
    def departure_width(self) -> float:
        """Smallest standard deviation in the departure."""
        return 1.0 / math.sqrt(2.0 * float(np.max(self.form[:, 1, 1])))

    def integrate(self, weight: FloatArray, arrive: FloatArray, depart: FloatArray) -> FloatArray:
        """Sum over the times of weight times the density, a row for each arrival, a column for each departure."""
        total = np.zeros((arrive.size, depart.size))
        features = np.stack([arrive**2, arrive, np.ones_like(arrive)])
        chunk = max(1, _EXPONENTIALS // total.size)
        for start in range(0, weight.size, chunk):
            m = self.form[start : start + chunk]
            size = weight[start : start + chunk] * self.height[start : start + chunk]
            slope = 2.0 * (m[:, 0, 1, None] * depart + m[:, 0, 2, None])
            rest = depart * (m[:, 1, 1, None] * depart + 2.0 * m[:, 1, 2, None]) + m[:, 2, 2, None]
            factors = np.stack([np.broadcast_to(m[:, 0, 0, None], slope.shape), slope, rest], axis=2)
            exponent = factors @ features  # times, departures, arrivals
            np.exp(np.negative(exponent, out=exponent), out=exponent)
            total += np.tensordot(size, exponent, axes=1).T
        return total


def _x_form(problem: _Problem, time: FloatArray) -> _QuadraticForm:
    """Density of x at a time after leaving the wall, behind it included."""
    flow = _Flow.at(problem.c, time)
    return _QuadraticForm.of_one(_row(1.0 + 0.0 * time, -flow.kick, problem.wall * (flow.slip - 1.0)), flow.x_x)


def _v_form(problem: _Problem, time: FloatArray) -> _QuadraticForm:
    """Density of v at a time after leaving the wall."""
    flow = _Flow.at(problem.c, time)
    return _QuadraticForm.of_one(_row(1.0 + 0.0 * time, -flow.kick_rate, problem.wall * flow.kick), flow.v_v)


def _row(arrival: FloatArray, departure: FloatArray, constant: FloatArray) -> FloatArray:
    return np.stack([arrival, departure, constant], axis=1)


def _product(a: FloatArray, b: FloatArray, factor: FloatArray) -> FloatArray:
    return np.asarray(factor[:, None, None] * a[:, :, None] * b[:, None, :])


def _response(
    problem: _Problem,
    impacts: _Impacts,
    form: Callable[[_Problem, FloatArray], _QuadraticForm],
    arrive: FloatArray,
    first: float,
    speeds: int,
    panels: int,
) -> FloatArray:
    """What the impacts add to the free density: int dt of what they give back minus what they take, from e^first on.

    Soon after an impact the mass is still near its straight path, and the grid must be dense enough to see it:
    ``speeds`` times as dense as that of the impacts, with ``panels`` of times to a factor e.
    """
    unit, r = _speed_unit(problem), problem.r
    fine = np.arange(max(-9.0, impacts.position[0]), impacts.position[-1], impacts.spacing / speeds)
    speed, flux = unit * np.logaddexp(0.0, fine), np.exp(impacts.log_weight(fine)) / speeds
    turn = math.log(min(2.0, 2.0 / problem.c))
    total = np.zeros(arrive.size)
    early = True
    for time, weight in _panels(problem, _FINE, min(first, turn - 1.0), turn, panels):
        if not early:
            speed, flux = impacts.speed, impacts.weight
        depart, signed = np.concatenate([r * speed, -speed]), np.concatenate([flux, -flux])
        at_time, grid, back = form(problem, time), arrive, None
        if not early:
            few, ahead = _interpolation(-speed[-1], speed[-1], at_time.departure_width, depart)
            if few.size < depart.size:
                depart, signed = few, ahead.T @ signed
            low, high = float(arrive.min()), float(arrive.max())
            if high > low and (high - low) / at_time.arrival_width < arrive.size / 3.0:
                grid, back = _interpolation(low, high, at_time.arrival_width, arrive)
        part = at_time.integrate(weight, grid, depart) @ signed
        total += part if back is None else back @ part
        early = False
    return total


@dataclass(frozen=True)
class _Flow:
    """Mean and covariance of the free motion after some times, exact at small times too."""

    kick: FloatArray  # displacement after a unit speed
    kick_rate: FloatArray  # its derivative
    slip: FloatArray  # what a unit displacement has lost
    x_x: FloatArray
    x_v: FloatArray
    v_v: FloatArray
    determinant: FloatArray

    @classmethod
    def at(cls, c: float, time: FloatArray) -> _Flow:
        """Closed forms; at small times, integrals that do not cancel."""
        kick, kick_rate, hold = _free(c, time)
        x_x, v_v = dashpot_mean_squares(c, time)
        x_v = kick**2 / 2.0
        determinant = x_x * v_v - x_v**2
        slip = 1.0 - hold
        early = time < 0.5 / max(c, 1.0)
        if np.any(early):
            nodes, weights = (_GAUSS[0] + 1.0) / 2.0, _GAUSS[1] / 2.0
            t = time[early, None]
            h, h_rate, _ = _free(c, t * nodes)
            w = t * weights
            x_x[early], v_v[early], slip[early] = (np.sum(w * f, axis=1) for f in (h * h, h_rate * h_rate, h))
            # of a Gram matrix: half the double integral of (h(s) h'(s') - h'(s) h(s'))^2
            cross = h[:, :, None] * h_rate[:, None, :]
            cross = (cross - cross.transpose(0, 2, 1)) ** 2
            determinant[early] = np.einsum("ti,tj,tij->t", w, w, cross) / 2.0
        return cls(kick, kick_rate, slip, x_x, x_v, v_v, determinant)


def _free(c: float, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Displacement and speed after a unit kick, and displacement after a unit displacement, without noise."""
    half = c / 2.0
    if half < 1.0:
        frequency = math.sqrt((1.0 - half) * (1.0 + half))
        decay = np.exp(-half * time)
        cosine, sine = decay * np.cos(frequency * time), decay * time * np.sinc(frequency * time / math.pi)
    else:
        split = math.sqrt((half - 1.0) * (half + 1.0))
        slow, gap = np.exp(-time / (half + split)), -2.0 * split * time
        cosine = slow * (1.0 + np.exp(gap)) / 2.0
        sine = slow * (-np.expm1(gap) / (2.0 * split) if split > 0.0 else time)
    return sine, cosine - half * sine, cosine + half * sine


def _interpolation(low: float, high: float, width: float, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Chebyshev nodes enough for a normal density of this width, and the matrix from them to the points."""
    half = (high - low) / 2.0
    n = math.ceil(4.0 * half / width) + 10
    nodes = chebyshev.chebpts1(n)
    to_coefficients = 2.0 / n * chebyshev.chebvander(nodes, n - 1).T
    to_coefficients[0] /= 2.0
    at_points = chebyshev.chebvander((points - low) / half - 1.0, n - 1)
    return low + half * (nodes + 1.0), at_points @ to_coefficients
