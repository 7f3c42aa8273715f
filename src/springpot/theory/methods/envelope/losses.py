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
from springpot.theory.methods.envelope.arcs import Arcs
from springpot.theory.methods.envelope.balance import Balance, Stretch, balance
from springpot.theory.methods.envelope.impacts import Impacts, impacts, matched, with_moments
from springpot.theory.methods.envelope.walls import is_smooth
from springpot.theory.methods.fokker_planck.method import fokker_planck
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.problem import Problem as PaperProblem

FILE = Path(__file__).with_name("losses.npz")
DAMPINGS = np.array([0.003, 0.01, 0.03, 0.08, 0.2, 0.45, 1.0, 2.0, 4.0])
RESTITUTIONS = np.array([0.175, 0.2, 0.225, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
GAPS = np.arcsinh([-4.0, -3.0, -2.2, -1.6, -1.1, -0.7, -0.35, 0.0])
PRELOADS = np.array([0.0, 0.3, 0.6, 0.9, 1.2, 1.6, 2.0, 2.5, 3.0, 3.5, 4.0])
"""Nodes of the tables: d, r and asinh u; <y> and <y^2> have a kink at u = 0, so each side has a table."""

_CANCELLED = 1e-3  # largest relative error of a moment that is used
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


def changed(law: Balance, struck: list[Impacts]) -> tuple[Balance, tuple[float, float, float], list[Impacts]]:
    """The law, its moments and its impacts with the correction for sudden losses: one lossy wall, and white noise.

    The moments are mean and mean square of x - origin, and mean square of v.  Of the paper's problem the cycles get the
    corrected means too.

    Examples
    --------
    >>> from springpot.theory.methods.envelope.impacts import impacts
    >>> plain = balance(PaperProblem(order=1.0, coefficient=0.2, position=0.0, restitution=0.8))
    >>> _, _, (hit,) = changed(plain, impacts(plain))
    >>> lossy = fokker_planck(System(Spring(1.0), Dashpot(0.2), WhiteNoise(1.0), Barrier(restitution=0.8)))
    >>> bool(abs(hit.rate / lossy.impact_rate - 1.0) < 0.002)
    True
    """
    unit, problem, cycles, moments = law.problem.unit, law.problem, law.cycles, law.moments
    walls, (mean, square, v_square) = tuple(unit.walls.values()), moments
    if len(unit.stops) != 1 or not walls or not law.is_struck:
        return law, moments, struck
    wall, (speed, _, before) = walls[0], law.rates.struck[0]
    hit, sign, ratios, r = np.isfinite(speed), wall.inwards, _SAME, 1.0
    place = sign * (wall.position - problem.origin)
    often, arc = law.weight * hit / cycles.period, np.maximum(cycles.arc, 1e-300)
    push, w = 2.0 * np.nan_to_num(speed) / cycles.period, law.average(np.sqrt(arc))
    colored = any(noise.correlated_for for noise in unit.excitations.values())
    if not (wall.is_elastic or colored or unit.temperature or problem.multiplied or is_smooth(unit)):
        fast = often * before * np.nan_to_num(speed) ** 2
        r = math.sqrt(float(np.sum(fast * law.rates.struck[0].restitution ** 2)) / float(np.sum(fast)))
        # the arc's centre: there the force on it vanishes, whose mean is that of the wall
        centre = float(often @ (sign * cycles.mean - push / arc)) / float(often.sum())
        inside = law.average(cycles.v_square)
        damping, gap = law.average(law.rates.damped) / (w * inside), w * (place - centre) / math.sqrt(inside)
        if problem.closed or is_tabulated(damping, gap):
            ratios = sudden_losses(damping, r, gap, law.taken)
    if ratios is _SAME and not (problem.closed and problem.springpots):
        return law, moments, struck
    # what the wall adds to the mean is seen from that of the cycle that just reaches it, which is 0 of a linear spring
    reached = 0.0 if problem.closed else sign * float(cycles.mean[np.argmax(hit)])
    origin = place if place >= 0.0 else reached
    own = max(float(problem.potential.curvature(np.zeros(1))[0]), 0.0)
    away, away_square = _moments_from_wall(
        ratios,
        about_origin=_from_origin(sign * mean, square, origin),
        about_wall=_from_origin(sign * mean, square, place),
        apart=place - origin,
        stiffening=w / math.sqrt(own) if own > 0.0 else math.inf,
    )
    better = sign * (place + away), place * place + 2.0 * place * away + away_square, ratios.v_square * v_square
    if isinstance(cycles, Arcs):
        law = _stretched(law, cycles, place, r, (away, away_square), ratios.v_square)
    (one,) = struck
    rate, speed_mean, speed_square = one.rate, one.speed_mean, one.speed_mean_square
    if math.isnan(rate):
        return law, better, struck
    if ratios is not _SAME:
        # the mean forces of springs and impacts cancel; a preload is there without impacts
        preload = (
            max(sign * float(problem.potential.force(wall.position - problem.origin)), 0.0) if place >= 0.0 else 0.0
        )
        rate, speed_square = ratios.rate * rate, ratios.speed_square * speed_square
        speed_mean = (preload + ratios.mean * (law.average(hit * push) - preload)) / ((1.0 + r) * rate)
    return law, better, [with_moments(one, rate, speed_mean, speed_square)]


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


def _moments_from_wall(
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


def _stretched(law: Balance, cycles: Arcs, wall: float, r: float, wanted: tuple[float, float], vv: float) -> Balance:
    """Arcs with the wanted mean and mean square of the distance from the wall, and <v^2> changed by a factor."""
    part, weights = panel_rule([0.0, 1.0], _PHASES)
    x, speed = cycles.path(law.problem, part)
    near = _NEAR * math.sqrt(wanted[1])
    above = np.maximum(x - wall, 0.0) + near

    def displaced(power: float) -> Floats:
        return np.asarray(above**power - near**power)

    def moments(power: float) -> tuple[float, float]:
        there = displaced(power)
        return float(law.plane @ (there @ weights)), float(law.plane @ (there**2 @ weights))

    power = matched(moments, wanted[1] / wanted[0] ** 2, *_POWERS)
    factor = wanted[0] / moments(power)[0]
    there = factor * displaced(power)
    above_wall = there @ weights
    v_square = float(law.plane @ cycles.v_square)
    soft = _SOFT * math.sqrt(v_square)
    length = float(law.plane @ (np.hypot(speed, soft) @ weights))
    skew = _V_SKEW * max(1.0 - law.taken * vv, 0.0) * (1.0 - r) / (1.0 + r)
    v_factor = math.sqrt(vv * v_square / (v_square + skew**2 * (v_square + soft**2 - length**2)))
    better = replace(
        cycles,
        mean=wall + above_wall,
        x_square=wall * wall + 2.0 * wall * above_wall + there**2 @ weights,
        v_square=vv * cycles.v_square,
    )
    return replace(law, cycles=better, stretch=Stretch(wall, near, factor, power, soft, skew, skew * length, v_factor))


def _from_origin(mean: float, square: float, origin: float) -> tuple[float, float]:
    """Mean and mean square relative to another origin."""
    return mean - origin, square - 2.0 * origin * mean + origin * origin


def _logarithms(damping: float, restitution: float, place: float) -> Floats:
    below, above = _tables()
    table, low, high = (below, GAPS[0], 0.0) if place < 0.0 else (above, 0.0, PRELOADS[-1])
    damping = min(max(damping, DAMPINGS[0]), DAMPINGS[-1])
    crowding = float(_crowding(max(restitution, RESTITUTIONS[0])))
    return np.ravel(table((math.log(damping), crowding, min(max(place, low), high))))


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
        found = balance(PaperProblem(1.0, damping, position, restitution))
        assert isinstance(found, Balance)
        return found

    def miss(position: float) -> float:
        return position / math.sqrt(light(position).moments[2]) - math.sinh(place)

    try:
        far = 1.5 * math.sinh(place) * math.sqrt(0.5 / damping)
        position = 0.0 if place == 0.0 else optimize.brentq(miss, min(far, 0.0), max(far, 0.0), rtol=1e-9)
        wall = Barrier(position, restitution, free_side="above")
        truth = fokker_planck(System(Spring(1.0), Dashpot(damping), WhiteNoise(1.0), wall))
    except (ValueError, NotCoveredError):
        return np.full(_NONE.size, np.nan)
    law, origin = light(position), max(position, 0.0)
    (struck,) = impacts(law)
    mean, square, v_square = law.moments
    plain, real = (_from_origin(*each, origin) for each in ((mean, square), (truth.x_mean, truth.x_mean_square)))
    changes = [
        real[0] / plain[0],
        real[1] / plain[1],
        truth.v_mean_square / v_square,
        truth.impact_rate / struck.rate,
        truth.impact_speed_mean_square / struck.speed_mean_square,
    ]
    error = truth.error_estimate
    errors = [
        error * truth.x_mean / real[0], error * truth.x_mean_square / real[1], error, truth.impact_rate_error, error,
    ]  # fmt: skip
    known = (np.abs(errors) < _CANCELLED) & (np.array(changes) > 0.0)
    return np.where(known, np.log(np.where(known, changes, 1.0)), math.nan)
