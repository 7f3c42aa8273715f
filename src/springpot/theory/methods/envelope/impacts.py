"""Impacts of the envelope: the flux of impact speeds, with short returns, which a lossy wall makes frequent.

The envelope has one impact in each cycle.  But after a slow impact the noise alone may drive the mass back to the wall
long before the spring does.  During such a short flight the mass is free, and McKean's law holds: the density of the
return speed u and time t after leaving at v0 is

    (sqrt(3) u / (pi q^2 t^2)) exp(-2 (u^2 - u v0 + v0^2) / (q t)) erf(sqrt(6 u v0 / (q t))),

whose integral over t < t_c is elementary.  With K_r the law from r v and t_c the time to the turning point (later
returns are due to the spring), the flux N of the impact speeds is  N = N_long + K_r N.  With an elastic wall the
envelope's flux N_1 is complete, so N_long = N_1 - K_1 N_1.  N_long is taken to be the same for r < 1:
N = (1 - K_r)^-1 (1 - K_1) N_1, scaled so that the energy loss per unit of time is unchanged.

The limit t_c is a choice: at c = 0.01, r = 0.5, one third of the half period, the turning point and the half period
give 18, 24 and 31 % more impacts than the cycles; simulations 21 % (and a few slow ones that their step misses).
Between two walls a return counts as short up to 3/8 of the flight to the next impact, which at order 1, r = 0.8 and c
from 0.1 to 1 gives rates within 2 % of Monte Carlo.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy import optimize, special
from scipy.interpolate import PchipInterpolator

from springpot.machine.arrays import Floats
from springpot.problem.parts import Barrier
from springpot.problem.parts.walls import slow_restitution
from springpot.theory.mckean import slow_impact_power
from springpot.theory.methods.envelope.balance import Balance
from springpot.theory.methods.envelope.walls import is_endless, restitutions

_POINTS_PER_DECADE = 15
_DECADES = 14  # range of speeds: very slow impacts matter with a lossy wall
_CUT = 1  # decades at the slow end of the grid that are replaced by the power law
_RETURN, _RETURN_UNCORRECTED = 0.5, 0.375  # of a flight: longer returns are due to springs, or end at the other wall
_STEEPEST = 4.0  # largest power of the tilt of impact speeds
_TABLE = 240  # equidistant speeds at which the density is tabulated, in addition to the grid


@dataclass(frozen=True)
class Impacts:
    """The flux of impacts on one wall or contact; NaN where they are infinitely many.

    Parameters
    ----------
    rate : float
        Impacts per unit of time.
    speed_mean, speed_mean_square : float
        Of the speed just before an impact.
    speeds, density : ndarray
        Density of these speeds on a grid from 0; empty where it is not known.
    """

    rate: float
    speed_mean: float
    speed_mean_square: float
    speeds: Floats = field(default_factory=partial(np.zeros, 0))
    density: Floats = field(default_factory=partial(np.zeros, 0))


def impacts(law: Balance) -> list[Impacts]:
    """The impacts of a law on each wall and contact, in the order of the parts.

    A wall takes momentum and energy by the probability of cycles per action, and is crossed as often as by that per
    area of the plane of x and v.

    Examples
    --------
    >>> from springpot.theory.methods.envelope.balance import balance
    >>> from springpot.theory.problem import Problem
    >>> (flux,) = impacts(balance(Problem(order=1.0, coefficient=0.5, position=0.0, restitution=1.0)))
    >>> round(flux.rate * math.pi, 4), round(flux.speed_mean_square, 3)
    (1.0, 2.0)
    """
    unit, period, found = law.problem.unit, law.cycles.period, []
    reached = np.sum([np.isfinite(stop.speed) for stop in law.rates.struck], axis=0)
    for name, (speed, _, before) in zip(unit.stops, law.rates.struck, strict=True):
        wall, fast = unit.walls.get(name), np.sqrt(before) * np.nan_to_num(speed)
        often = np.isfinite(speed) / period
        rate, *per_area = (float(law.plane @ (often * fast**power)) for power in (0, 1, 2))
        if not rate > 0.0:
            found.append(Impacts(rate, math.nan, math.nan))
            continue
        if wall and is_endless(unit, wall):
            found.append(Impacts(math.nan, math.nan, math.nan))
            continue
        first, second = (law.average(often * fast**power) for power in (1, 2))
        flux, slope = law.plane / law.labels.weights.ravel() * often, law.labels.derivative(fast)
        rising = np.isfinite(speed) & (slope > 0.0) & (flux > 0.0) & (law.measure > 1e-9 * law.rates.action)
        rising &= np.diff(np.maximum.accumulate(fast), prepend=0.0) > 0.0
        if not wall or not law.problem.white > 0.0 or np.count_nonzero(rising) < 4:
            found.append(Impacts(rate, first / rate, second / rate))
            continue
        part = _RETURN if len(law.rates.struck) == 1 else _RETURN_UNCORRECTED
        # the time of the longest short return, in units in which the noise has the intensity 1
        short = law.problem.white * part * period / np.maximum(reached, 1)
        made = with_short_returns(
            fast[rising],
            flux[rising] / slope[rising],
            partial(_interpolated, speed[rising], short[rising]),
            partial(_rebound, wall),
            slow_impact_power(slow_restitution(wall)),
            (rate, *per_area),
        )
        per_action = made.speed_mean * first / per_area[0], made.speed_mean_square * second / per_area[1]
        found.append(with_moments(made, made.rate, *per_action))
    return found


def _interpolated(known: Floats, values: Floats, place: Floats) -> Floats:
    return np.asarray(np.interp(place, known, values))


def _rebound(wall: Barrier, speed: Floats) -> Floats:
    return restitutions(wall, speed) * speed


def with_short_returns(
    known: Floats,
    flux: Floats,
    turning: Callable[[Floats], Floats],
    rebound: Callable[[Floats], Floats],
    power: float,
    regular: tuple[float, ...],
) -> Impacts:
    """The impacts of cycles on one wall, with short returns.

    Parameters
    ----------
    known : ndarray
        Rising speeds before an impact, in units in which the noise has the intensity 1.
    flux : ndarray
        Impacts per unit of time and of this speed.
    turning : callable
        Time from the wall to the turning point of the cycle with this speed.
    rebound : callable
        Speed after an impact of this speed.
    power : float
        The rate of impacts slower than u is proportional to u^power; 2 with an elastic wall.
    regular : tuple of float
        Impacts of the cycles per unit of time, and the same times their mean and their mean square speed.
    """
    told = flux / known > np.finfo(float).tiny  # so rare are the fastest that their flux is 0 in double precision
    known, flux = known[told], flux[told]
    log_share = np.log(flux / known)
    # a straight line in the square of the speed (exact at order 1 with an elastic wall), plus the remainder
    fall = np.polyfit(known**2, log_share, 1, w=flux)[0]
    left = PchipInterpolator(np.log(known), log_share - fall * known**2)
    v = known[-1] * np.geomspace(10.0**-_DECADES, 1.0, _POINTS_PER_DECADE * _DECADES)
    step = math.log(v[1] / v[0])

    def elastic_flux_at(v: Floats) -> Floats:
        """The flux without losses; proportional to the speed below the known speeds."""
        held = np.maximum(v, known[0])
        return np.asarray(v * np.exp(fall * held**2 + left(np.log(held))))

    elastic_flux = elastic_flux_at(v)
    n = elastic_flux
    after = rebound(v)
    lossy_wall = bool(np.any(after < v))
    if lossy_wall:
        limit = turning(v)
        elastic = _short_returns(v[:, None], v, limit) * (v * step)
        lossy = _short_returns(v[:, None], after, np.interp(after, v, limit)) * (v * step)
        n = np.maximum(np.linalg.solve(np.eye(v.size) - lossy, n - elastic @ n), 0.0)
        cut = _CUT * _POINTS_PER_DECADE
        n[:cut] = n[cut] * (v[:cut] / v[cut]) ** (power - 1.0)

    def moment(flux: Floats, power: float, k: int) -> float:
        """Sum over the grid plus slower impacts: those below u are proportional to u^power."""
        return float(flux @ v ** (k + 1)) * step + float(flux[0] * v[0] ** (k + 1)) / (power + k)

    # the sums over the grid give ratios of both fluxes; moments of the elastic one are more accurate from the cycles
    gain = [moment(n, power, k) / moment(elastic_flux, 2.0, k) for k in (0, 1, 2)]
    per_rate, mean, square = (factor * each for factor, each in zip(gain, regular, strict=True))
    table = np.union1d(v, v[-1] * np.linspace(0.0, 1.0, _TABLE + 1)[1:-1])
    ratio = n / elastic_flux
    # the fastest hardly come from short returns; without a spring slow flights are long, and a free mass gets too fast
    fast = int(np.argmin(ratio))
    ratio[fast:] = np.minimum(ratio[fast:], max(float(ratio[fast]), 1.0))
    gained = PchipInterpolator(np.log(v), ratio)(np.log(table))
    # the energy loss per unit of time, proportional to the second moment of the flux, is that of the envelope
    return Impacts(
        rate=per_rate / gain[2],
        speed_mean=mean / per_rate,
        speed_mean_square=square / per_rate,
        speeds=np.r_[0.0, table],
        density=np.r_[n[0] if lossy_wall else 0.0, gained * elastic_flux_at(table)] / moment(n, power, 0),
    )


def _short_returns(u: Floats, v0: Floats, limit: Floats) -> Floats:
    """Density of the return speed u after leaving at v0, of a free mass and for returns before ``limit``; q = 1."""
    a = 2.0 * (v0 * v0 - v0 * u + u * u)
    b = 6.0 * v0 * u
    late = np.exp(-a / limit) * special.erf(np.sqrt(b / limit))
    early = np.sqrt(b / (a + b)) * special.erfc(np.sqrt((a + b) / limit))
    return np.asarray(math.sqrt(3.0) * u / (math.pi * a) * (late + early))


def with_moments(struck: Impacts, rate: float, mean: float, square: float) -> Impacts:
    """With another rate, and another mean and mean square of the speed."""
    if not struck.speeds.size:
        return Impacts(rate, mean, square)
    u = struck.speeds
    mass = struck.density * np.gradient(u)
    size = u / struck.speed_mean

    def moments(power: float) -> tuple[float, float]:
        weight = mass * (1.0 + size) ** power
        return float(weight @ u / weight.sum()), float(weight @ u**2 / weight.sum())

    first, second = moments(0.0)  # where cycles cross, these differ slightly from those of the cycles
    wider = square / struck.speed_mean_square / (mean / struck.speed_mean) ** 2
    power = matched(moments, second / first**2 * wider, -_STEEPEST, _STEEPEST)
    stretch, tilt = mean / struck.speed_mean * first / moments(power)[0], (1.0 + size) ** power
    density = struck.density * tilt * mass.sum() / (mass @ tilt) / stretch
    return Impacts(rate, mean, square, u * stretch, density)


def matched(moments: Callable[[float], tuple[float, float]], ratio: float, low: float, high: float) -> float:
    """Power at which the mean square over the square of the mean is this ratio; the nearest, if none does that."""

    def excess(power: float) -> float:
        mean, square = moments(power)
        return square / mean**2 - ratio

    ends = excess(low), excess(high)
    if ends[0] * ends[1] > 0.0:
        return low if abs(ends[0]) < abs(ends[1]) else high
    return float(optimize.brentq(excess, low, high, xtol=1e-10))
