"""Inelastic impacts: the stationary Fokker-Planck equation with a dashpot, as one integral equation.

Dimensionless (time 1 / Omega, length sqrt(q / Omega^3)), with b the wall and r its restitution, the density of (x, v)
obeys L p = 0 beyond the wall, and the flux that leaves the wall at speed r u is that which struck it at speed u.  Let p
be 0 behind the wall.  Then on the whole plane L p = (flux removed at (b, -u)) - (flux added at (b, r u)), so that

    p(z) = p_free(z) + int_0^inf du f(u) int_0^inf dt [P_t(z | b, r u) - P_t(z | b, -u)],

with P_t the normal transition density of the oscillator without a wall, p_free its stationary density, and f(u) du the
rate of impacts with speed u.  That p is indeed 0 behind the wall is a Fredholm equation of the second kind for f alone,

    f(u) / u = p_free(b, -u) + int_0^inf du' f(u') int_0^inf dt [P_t(b, -u | b, r u') - P_t(b, -u | b, -u')],

where the instant t = 0 has been taken out (it is the left-hand side).  Towards u = 0 its kernel is
sqrt(3) / (2 pi Q) with Q = u^2 + u v + v^2 for every oscillator, which gives the power law of slow impacts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import interpolate, special

from springpot.machine.arrays import Floats
from springpot.theory.mckean import slow_impact_power
from springpot.theory.methods.fokker_planck.transition import QuadraticForm, free_spread, interpolation
from springpot.theory.numerics.panels import on_panels, panel_rule
from springpot.theory.problem import Problem
from springpot.theory.result import MOMENTS, Moments

_SMALL = math.exp(-10.0)  # of a speed: below it the kernel is its own small-speed limit
_SMALLEST = math.exp(-13.0)  # below it the kernel is linear in the speed of departure
_KEEPING_UP = 20.0  # speed up to which the longest panels of time resolve an impact


@dataclass(frozen=True)
class Grid:
    """Resolution: spacing of the speeds, Gauss nodes and longest panel in time, free decay kept, range of speeds."""

    spacing: float
    nodes: int
    panel: float
    decay: float
    reach: float


COARSE = Grid(spacing=0.32, nodes=6, panel=0.4, decay=14.0, reach=6.0)
FINE = Grid(spacing=0.25, nodes=8, panel=0.45, decay=18.0, reach=6.8)


@dataclass(frozen=True)
class Impacts:
    """Rate of impacts by speed: ``weight[i]`` of them per unit time have a speed near ``speed[i]``."""

    position: Floats  # y, with speed = scale * log(1 + e^y)
    speed: Floats
    weight: Floats
    spacing: float
    power: float  # of the speed, in the rate of slower impacts

    @cached_property
    def log_weight(self) -> interpolate.CubicSpline:
        """ln weight between the nodes, a function of y."""
        return interpolate.CubicSpline(self.position, np.log(self.weight))

    @cached_property
    def mass(self) -> float:
        """Rate, as the integral of the interpolant and, below the nodes, of the power law."""
        y, measure = panel_rule(self.position, 16)
        total = float(measure @ np.exp(self.log_weight(y)))
        return (total + float(self.weight[0]) / self.power) / self.spacing

    def moment(self, power: int) -> float:
        """Rate times the mean of speed^power."""
        return float(self.weight @ self.speed**power)


def solve(problem: Problem, grid: Grid) -> Impacts:
    """Nystrom's method with the trapezoid rule in y, speed = unit * log(1 + e^y)."""
    r, unit, h = problem.restitution, speed_unit(problem), grid.spacing
    fastest = _fastest(problem, grid)
    low = -math.log(1e10) / slow_impact_power(r)
    y = np.arange(low, fastest / unit + h, h)
    u = unit * np.logaddexp(0.0, y)
    measure = h * unit * special.expit(y) / u  # du / u
    source = u * u * np.exp(-(problem.position**2 + u * u) * problem.coefficient) * problem.coefficient / math.pi
    kernel = _kernel(problem, grid, u)
    weight = np.linalg.solve(np.eye(u.size) - measure[:, None] * kernel, measure * source)
    peak = int(np.argmax(weight))
    lost = np.flatnonzero(weight[peak:] < 1e-13 * weight[peak])  # from there on only rounding errors
    end = peak + int(lost[0]) if lost.size else u.size
    return Impacts(y[:end], u[:end], weight[:end], h, slow_impact_power(r))


def _kernel(problem: Problem, grid: Grid, u: Floats) -> Floats:
    """u^2 int_0^inf [P_t(b, -u | b, r u') - P_t(b, -u | b, -u')] dt, a row for each u, a column for each u'."""
    r, unit = problem.restitution, speed_unit(problem)
    first = min(int(np.searchsorted(u, _SMALLEST * unit)), u.size - 1)
    some = u[first:]
    total = np.zeros((some.size, 2 * some.size))
    depart = np.concatenate([r * some, -some])
    start = math.log((_SMALL * unit) ** 2 / 60.0)
    turn = math.log(min(0.3, 0.3 / problem.coefficient))
    for time, weight in _panels(problem, grid, start, turn, 1):
        form = QuadraticForm.at(problem, time)
        arrive_grid, depart_grid = -some, depart
        back = ahead = None
        if time[0] > 2.0:  # smooth by now: polynomial interpolation between fewer speeds is enough
            arrive_grid, back = interpolation(-some[-1], 0.0, form.arrival_width, -some)
            depart_grid, ahead = interpolation(-some[-1], some[-1], form.departure_width, depart)
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


def moments(problem: Problem, impacts: Impacts) -> tuple[float, float, float, tuple[float, float, float]]:
    """<x>, <x^2>, <v^2>, and rate, mean and mean square speed of the impacts."""
    rate, first, second = (max(impacts.moment(power), 1e-300) for power in range(3))
    x_mean = (1.0 + problem.restitution) * first
    v_mean_square = (0.5 - (1.0 - problem.restitution**2) / 2.0 * second) / problem.coefficient
    return x_mean, v_mean_square + problem.position * x_mean, v_mean_square, (rate, first / rate, second / rate)


def difference(fine: Moments, coarse: Moments) -> tuple[float, float]:
    changes = {name: abs(coarse[name] / fine[name] - 1.0) for name in MOMENTS}
    changes["x_mean"] = abs(coarse.x_mean - fine.x_mean) / math.sqrt(fine.x_mean_square)
    return max(changes.values()), changes["impact_rate"]


def speed_unit(problem: Problem) -> float:
    """Speed below which the grid is logarithmic and above which it is uniform."""
    unit = min(1.0, free_spread(problem))
    if problem.position > 0.0 and problem.restitution < 1.0:
        # a preload b gives b / 2u impacts per unit time, and the noise replaces the losses of (1 - r^2) u^2 / 2
        unit = min(unit, 2.0 / ((1.0 - problem.restitution**2) * problem.position))
    return unit


def _fastest(problem: Problem, grid: Grid) -> float:
    """Largest impact speed of interest, bounded by the free spread and by the losses."""
    free = grid.reach * free_spread(problem)
    if problem.restitution == 1.0:
        return free
    # an impact keeps r; half a period adds at most pi/2 of variance, to a free swing that has to reach the wall
    added = grid.reach * math.sqrt(1.6 / (1.0 - problem.restitution**2))
    gap = max(0.0, -problem.position)
    return min(free, math.sqrt(added * (added + 2.0 * gap)))


def _panels(problem: Problem, grid: Grid, start: float, turn: float, refine: int) -> Iterator[tuple[Floats, Floats]]:
    """Nodes and weights of the integral over time: one block of early times, then blocks of times of like size.

    The early panels, between the logarithms ``start`` and ``turn``, have length 1 / ``refine`` in ln t.
    """
    c = problem.coefficient
    edges = np.exp(np.linspace(start, turn, math.ceil((turn - start) * refine) + 1))
    slowest = c / 2.0 if c < 2.0 else 1.0 / (c / 2.0 + math.sqrt((c / 2.0 - 1.0) * (c / 2.0 + 1.0)))
    last = grid.decay / slowest
    # the faster the impacts, the shorter the panels; without oscillation one panel is enough
    longest = grid.panel * min(1.0, _KEEPING_UP / _fastest(problem, grid)) if c < 2.0 else last
    later = [float(edges[-1])]
    while later[-1] < last:
        later.append(later[-1] + min(longest, 0.8 * later[-1]))
    # within one panel the early times are smooth in ln t, the later ones in t
    log, weight = panel_rule(np.log(edges), grid.nodes)
    yield np.exp(log), weight * np.exp(log)
    time, weight = on_panels(later[:-1], later[1:], grid.nodes)
    block = np.floor(np.log2(np.maximum(time[:, 0], 1.0)) * 1.5)
    for number in np.unique(block):
        yield time[block == number].reshape(-1), weight[block == number].reshape(-1)


def response(
    problem: Problem,
    impacts: Impacts,
    form: Callable[[Problem, Floats], QuadraticForm],
    arrive: Floats,
    first: float,
    speeds: int,
    panels: int,
) -> Floats:
    """Contribution of impacts to the free density: int dt of the flux added less that removed, from e^first on.

    Soon after an impact the density is narrow, and the grid must resolve it: it is ``speeds`` times as dense as that of
    the impacts, with ``panels`` panels of time per factor e.
    """
    unit, r = speed_unit(problem), problem.restitution
    fine = np.arange(max(-9.0, impacts.position[0]), impacts.position[-1], impacts.spacing / speeds)
    speed, flux = unit * np.logaddexp(0.0, fine), np.exp(impacts.log_weight(fine)) / speeds
    turn = math.log(min(2.0, 2.0 / problem.coefficient))
    total = np.zeros(arrive.size)
    early = True
    for time, weight in _panels(problem, FINE, min(first, turn - 1.0), turn, panels):
        if not early:
            speed, flux = impacts.speed, impacts.weight
        depart, signed = np.concatenate([r * speed, -speed]), np.concatenate([flux, -flux])
        at_time, grid, back = form(problem, time), arrive, None
        if not early:
            few, ahead = interpolation(-speed[-1], speed[-1], at_time.departure_width, depart)
            if few.size < depart.size:
                depart, signed = few, ahead.T @ signed
            low, high = float(arrive.min()), float(arrive.max())
            if high > low and (high - low) / at_time.arrival_width < arrive.size / 3.0:
                grid, back = interpolation(low, high, at_time.arrival_width, arrive)
        part = at_time.integrate(weight, grid, depart) @ signed
        total += part if back is None else back @ part
        early = False
    return total
