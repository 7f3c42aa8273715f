"""Correction of the envelope for sudden losses in impacts: computed at order 1, used at every order.

The envelope spreads the loss of an impact over the cycle and assumes that the noise changes the energy little between
impacts.  With a restitution of 0.5 neither is true, least of all with a preload, where flights are short: at order 1
the impact rate has an error of 20 %.  There the Fokker-Planck equation gives the exact result.  An impact and the
flight after it are short compared with the springpot's memory, so the correction is nearly the same at every order for
equal damping d and position u of the wall in the units of the arcs

    d = (power the springpot dissipates) / (w <v^2>),    u = w (b - x_e) / sqrt(<v^2>),

with w the mean frequency of the arcs and x_e their mean centre, averaged over impacts.  `tabulate` writes the ratios of
the moments of the Fokker-Planck equation to those of the envelope into a file, for d, r and u; `changed` multiplies by
them.  The mean impact speed then follows from <x> = (1 + r) rate <u>, which holds at every order.  The ratio
<y^2> / <y>^2, y the distance from the wall, is reduced by a power w^-3 fitted to Monte Carlo.

Densities are those of the cycles with displacements stretched by a power of the distance from the wall, and velocities
skewed (`Stretch`), so that they have the corrected moments: outgoing velocities are smaller than incoming ones.  The
skew, 2/3 of (1 - r)/(1 + r) times the share of the power that impacts dissipate, and its softness were chosen at
order 1.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy import optimize
from scipy.interpolate import RegularGridInterpolator

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import Barrier, Dashpot, Spring, WhiteNoise
from springpot.problem.system import System
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.methods.envelope.balance import Balance, Stretch, balance
from springpot.theory.methods.envelope.impacts import Impacts, impacts
from springpot.theory.methods.fokker_planck.method import fokker_planck
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.problem import Problem

FILE = Path(__file__).with_name("losses.npz")
DAMPINGS = np.array([0.003, 0.01, 0.03, 0.08, 0.2, 0.45, 1.0, 2.0, 4.0])
RESTITUTIONS = np.array([0.175, 0.2, 0.225, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
GAPS = np.arcsinh([-4.0, -3.0, -2.2, -1.6, -1.1, -0.7, -0.35, 0.0])
PRELOADS = np.array([0.0, 0.3, 0.6, 0.9, 1.2, 1.6, 2.0, 2.5, 3.0, 3.5, 4.0])
"""Nodes of the tables: d, r and asinh u; <y> and <y^2> have a kink at u = 0, so each side has a table."""

_CANCELLED = 1e-3  # largest relative error of a moment that is used
_STEEPEST = 4.0  # largest power of the tilt of impact speeds
_PHASES = 24
_SOFT = 0.6  # width of the transition between outgoing and incoming velocities, in standard deviations of v
_V_SKEW = 2.0 / 3.0
_NEAR = 0.03  # distance from the wall, over its root mean square, below which the stretch is linear
_POWERS = (0.5, 2.5)  # of the stretch
_NARROWER = -3.0
_NONE = np.zeros(5)


@dataclass(frozen=True)
class Ratios:
    """Moments of the Fokker-Planck equation over those of the plain envelope.

    Parameters
    ----------
    mean, square : float
        Of the displacement from the equilibrium, or with a preload from the wall, and of its square.
    v_square : float
    rate, speed_square : float
        Of impacts, and of their mean square speed.
    """

    mean: float
    square: float
    v_square: float
    rate: float
    speed_square: float


_SAME = Ratios(1.0, 1.0, 1.0, 1.0, 1.0)


def changed(settled: Balance, struck: Impacts | None) -> tuple[Balance, Impacts | None]:
    """The balance, per area of the plane, and the impacts of an envelope, with means of x per action and sudden losses.

    Examples
    --------
    >>> plain = balance(Problem(order=1.0, coefficient=0.2, position=0.0, restitution=0.8))
    >>> better, struck = changed(plain, impacts(plain))
    >>> parts = Spring(1.0), Dashpot(0.2), WhiteNoise(1.0), Barrier(restitution=0.8)
    >>> lossy = fokker_planck(System(*parts))
    >>> bool(abs(struck.rate / lossy.impact_rate - 1.0) < 0.002)
    True
    """
    r, order = settled.problem.restitution, settled.problem.order
    if settled.average(settled.rate) <= 1e-15 or (r == 1.0 and order == 1.0):
        return settled, struck
    ratios = _SAME if r == 1.0 else sudden_losses(*_coordinates(settled), settled.taken)
    better = _balance(settled, ratios)
    if struck is None:
        return better, None
    # the wall takes momentum and energy from each cycle; at every order it takes the momentum that the spring gives
    pushed = settled.rate * np.sqrt(settled.before) * settled.speed
    lost = settled.rate * settled.before * settled.speed**2
    speed = settled.average(pushed) / settled.per_area.average(pushed)
    if r < 1.0:
        speed = better.average(better.mean) / ((1.0 + r) * ratios.rate * struck.rate * struck.speed_mean)
    speeds = ratios.speed_square * settled.average(lost) / settled.per_area.average(lost)
    return better, _impacts(struck, ratios.rate, speed, speeds)


def sudden_losses(damping: float, restitution: float, place: float, taken: float) -> Ratios:
    """The ratios of the table.

    Parameters
    ----------
    damping, restitution, place : float
        d, r and u.
    taken : float
        Share of the power that is not lost in impacts.
    """
    y, yy, vv, rate, speeds = np.exp(_logarithms(damping, restitution, math.asinh(place))).tolist()
    if taken * max(vv, 1.0) < 1.0:  # the smaller it is, the better it determines the power lost in impacts
        speeds *= ((1.0 - taken * vv) / (1.0 - taken) / (rate * speeds)) ** (1.0 - taken)
    return Ratios(y, yy, vv, rate, speeds)


def is_tabulated(damping: float, place: float) -> bool:
    """Whether the table has this damping and place, or a smaller damping or a wall farther away, which change less."""
    return damping <= float(DAMPINGS[-1]) and math.asinh(place) <= float(PRELOADS[-1])


def moments_from_wall(
    ratios: Ratios,
    about_origin: tuple[float, float],
    about_wall: tuple[float, float],
    apart: float,
    stiffening: float,
) -> tuple[float, float]:
    """Corrected mean and mean square of the distance from the wall.

    Parameters
    ----------
    ratios : Ratios
    about_origin, about_wall : tuple of float
        Mean and mean square of the displacement from the origin, to which the ratios apply, and from the wall.
    apart : float
        Place of the wall seen from the origin.
    stiffening : float
        Frequency of the arcs over that of the spring alone.
    """
    mean, square = about_origin
    wanted, wanted_square = _from_origin(ratios.mean * mean, ratios.square * square, apart)
    mean, square = about_wall
    wider = (wanted_square / wanted**2) / (square / mean**2)
    return wanted, wanted**2 * square / mean**2 * wider ** (stiffening**_NARROWER)


def _balance(settled: Balance, ratios: Ratios) -> Balance:
    """Per area of the plane, with the corrected means of the displacement, its square, and v^2."""
    wall, vv = settled.problem.position, ratios.v_square
    origin = max(wall, 0.0)
    wanted, wanted_square = moments_from_wall(
        ratios, settled.from_origin(origin), settled.from_origin(wall), wall - origin,
        settled.average(settled.frequency),
    )  # fmt: skip
    settled = settled.per_area
    part, weights = panel_rule([0.0, 1.0], _PHASES)
    s = settled.phase[:, None] * part
    near = _NEAR * math.sqrt(wanted_square)
    above = np.maximum(settled.centre[:, None] + settled.amplitude[:, None] * np.cos(s) - wall, 0.0) + near

    def displaced(power: float) -> Floats:
        return np.asarray(above**power - near**power)

    def moments(power: float) -> tuple[float, float]:
        there = displaced(power)
        return settled.average(there @ weights), settled.average(there**2 @ weights)

    power = _matched(moments, wanted_square / wanted**2, *_POWERS)
    factor = wanted / moments(power)[0]
    there = factor * displaced(power)
    above_wall = there @ weights
    v_square = settled.average(settled.v_square)
    soft = _SOFT * math.sqrt(v_square)
    speed = settled.frequency[:, None] * settled.amplitude[:, None] * np.sin(s)
    length = settled.average(np.hypot(speed, soft) @ weights)
    r = settled.problem.restitution
    skew = _V_SKEW * max(1.0 - settled.taken * vv, 0.0) * (1.0 - r) / (1.0 + r)
    v_factor = math.sqrt(vv * v_square / (v_square + skew**2 * (v_square + soft**2 - length**2)))
    return replace(
        settled,
        mean=wall + above_wall,
        x_square=wall * wall + 2.0 * wall * above_wall + there**2 @ weights,
        v_square=vv * settled.v_square,
        stretch=Stretch(wall, near, factor, power, soft, skew, skew * length, v_factor),
    )


def _impacts(struck: Impacts, rate: float, speed: float, speeds: float) -> Impacts:
    """With the rate and the mean and mean square of the speed changed by these factors."""
    u = struck.speeds
    mass = struck.density * np.gradient(u)
    size = u / struck.speed_mean

    def moments(power: float) -> tuple[float, float]:
        weight = mass * (1.0 + size) ** power
        return float(weight @ u / weight.sum()), float(weight @ u**2 / weight.sum())

    mean, square = moments(0.0)  # where cycles cross, these differ slightly from those of the cycles
    power = _matched(moments, square / mean**2 * speeds / speed**2, -_STEEPEST, _STEEPEST)
    stretch = speed * mean / moments(power)[0]
    tilt = (1.0 + size) ** power
    return Impacts(
        rate=rate * struck.rate,
        speed_mean=speed * struck.speed_mean,
        speed_mean_square=speeds * struck.speed_mean_square,
        speeds=u * stretch,
        density=struck.density * tilt * mass.sum() / (mass @ tilt) / stretch,
    )


def _matched(moments: Callable[[float], tuple[float, float]], ratio: float, low: float, high: float) -> float:
    """Power at which the mean square over the square of the mean is this ratio; the nearest, if none does that."""

    def excess(power: float) -> float:
        mean, square = moments(power)
        return square / mean**2 - ratio

    ends = excess(low), excess(high)
    if ends[0] * ends[1] > 0.0:
        return low if abs(ends[0]) < abs(ends[1]) else high
    return float(optimize.brentq(excess, low, high, xtol=1e-10))


def _from_origin(mean: float, square: float, origin: float) -> tuple[float, float]:
    """Mean and mean square relative to another origin."""
    return mean - origin, square - 2.0 * origin * mean + origin * origin


def _logarithms(damping: float, restitution: float, place: float) -> Floats:
    below, above = _tables()
    table, low, high = (below, GAPS[0], 0.0) if place < 0.0 else (above, 0.0, PRELOADS[-1])
    damping = min(max(damping, DAMPINGS[0]), DAMPINGS[-1])
    crowding = float(_crowding(max(restitution, RESTITUTIONS[0])))
    return np.ravel(table((math.log(damping), crowding, min(max(place, low), high))))


def _coordinates(settled: Balance) -> tuple[float, float, float]:
    """d, r and u."""
    w, v_square = settled.average(settled.frequency), settled.average(settled.v_square)
    struck = settled.weight * settled.rate
    centre = float(struck @ settled.centre / struck.sum())
    place = w * (settled.problem.position - centre) / math.sqrt(v_square)
    return settled.average(settled.dissipation) / (w * v_square), settled.problem.restitution, place


def _crowding(restitution: float | Floats) -> Floats:
    """Coordinate of the table for r: the moments change fast near the restitution with infinitely many impacts."""
    return np.log(np.asarray(restitution) - COLLAPSE_BELOW)


@lru_cache(maxsize=1)
def _tables() -> tuple[RegularGridInterpolator, RegularGridInterpolator]:
    with np.load(FILE) as kept:
        sides = kept["gaps"], kept["preloads"]
    axes = np.log(DAMPINGS), _crowding(RESTITUTIONS)
    return tuple(  # type: ignore[return-value]
        RegularGridInterpolator((*axes, places), side, method="cubic")
        for places, side in zip((GAPS, PRELOADS), sides, strict=True)
    )


def tabulate(path: Path = FILE) -> None:
    """Compute and write the tables: 2000 Fokker-Planck equations, some minutes.

    ``python -c "from springpot.theory.methods.envelope.losses import tabulate; tabulate()"``
    """
    from concurrent.futures import ProcessPoolExecutor  # used only here

    points = list(itertools.product(DAMPINGS, RESTITUTIONS))
    with ProcessPoolExecutor() as pool:
        rows = np.array(list(pool.map(_rows, points))).reshape(DAMPINGS.size, RESTITUTIONS.size, -1, _NONE.size)
    # both tables contain the node at 0
    np.savez_compressed(path, gaps=rows[:, :, : GAPS.size], preloads=rows[:, :, GAPS.size - 1 :])


def _rows(point: tuple[float, float]) -> list[Floats]:
    """Logarithms of the ratios at all positions of the wall; an unknown one is that of the position before."""
    rows = [_NONE]
    for place in (*GAPS, *PRELOADS[1:]):
        row = _NONE if point[1] == 1.0 else _row(*point, place)
        rows.append(np.where(np.isnan(row), rows[-1], row))
    return rows[1:]


def _row(damping: float, restitution: float, place: float) -> Floats:
    """At one position; NaN where the Fokker-Planck equation has no or no accurate result."""

    def light(position: float) -> Balance:
        return balance(Problem(1.0, damping, position, restitution))

    def miss(position: float) -> float:
        light_balance = light(position)
        return position / math.sqrt(light_balance.average(light_balance.v_square)) - math.sinh(place)

    try:
        far = 1.5 * math.sinh(place) * math.sqrt(0.5 / damping)
        position = 0.0 if place == 0.0 else optimize.brentq(miss, min(far, 0.0), max(far, 0.0), rtol=1e-9)
        wall = Barrier(position, restitution, free_side="above")
        truth = fokker_planck(System(Spring(1.0), Dashpot(damping), WhiteNoise(1.0), wall))
    except (ValueError, NotCoveredError):
        return np.full(_NONE.size, np.nan)
    light_balance, origin = light(position), max(position, 0.0)
    struck = impacts(light_balance)
    assert struck is not None
    plain = light_balance.from_origin(origin)
    real = _from_origin(truth.x_mean, truth.x_mean_square, origin)
    changes = [
        real[0] / plain[0],
        real[1] / plain[1],
        truth.v_mean_square / light_balance.average(light_balance.v_square),
        truth.impact_rate / struck.rate,
        truth.impact_speed_mean_square / struck.speed_mean_square,
    ]
    error = truth.error_estimate
    errors = [
        error * truth.x_mean / real[0], error * truth.x_mean_square / real[1], error, truth.impact_rate_error, error,
    ]  # fmt: skip
    known = (np.abs(errors) < _CANCELLED) & (np.array(changes) > 0.0)
    return np.where(known, np.log(np.where(known, changes, 1.0)), math.nan)
