"""Impacts of the envelope of systems: losses of cycles at walls, short returns, and the correction for sudden losses.

Both corrections are those of the envelope of an oscillator.  After a slow impact under white noise the mass may come
back to the wall long before the springs bring it back: such short returns obey McKean's law near any wall
(`springpot.theory.methods.envelope.impacts`).  With one wall the loss of an impact, which cycles spread evenly, is
corrected by the table of `springpot.theory.methods.envelope.losses`, at the damping, restitution and place of the wall
in the units of the arcs.  Between two walls there is no such table; there a return counts as short up to 3/8 of the
flight to the next impact, which at order 1, r = 0.8 and c from 0.1 to 1 gives rates within 2 % of Monte Carlo.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts import Barrier
from springpot.problem.parts.walls import restitution_at, slow_restitution
from springpot.problem.system import System
from springpot.theory.mckean import COLLAPSE_BELOW, slow_impact_power
from springpot.theory.methods.envelope.balance import Labels, before_impact
from springpot.theory.methods.envelope.impacts import with_short_returns
from springpot.theory.methods.envelope.losses import is_tabulated, moments_from_wall, sudden_losses
from springpot.theory.methods.systems.cycles import Cycles, Problem

_REBOUNDS = 20  # iterations for the restitution of a law of the speed
_SHORT, _SHORT_UNCORRECTED = 0.5, 0.375  # of a flight: longer returns are due to springs, or end at the other wall


class Hits(NamedTuple):
    """Impacts on one wall or contact: their rate, and mean and mean square of the speed before them."""

    rate: float
    mean: float
    square: float


@dataclass(frozen=True)
class Spread:
    """Moments of the stationary law: mean and mean square of x - bottom, and mean square of v."""

    mean: float
    x_square: float
    v_square: float


def after_impact(
    problem: Problem, wall: Barrier, speed: Floats, damped: Floats, cycles: Cycles
) -> tuple[float | Floats, Floats]:
    """The restitution, and the energy before an impact over the mean energy between two impacts.

    They are as in the envelope of an oscillator.  With a law of the speed the squares of the speeds before and after an
    impact have that of ``speed`` as their mean.
    """
    if not callable(wall.restitution):
        damping = np.maximum(damped / np.maximum(cycles.v_square, 1e-300), 0.0)
        return wall.restitution, before_impact(np.nan_to_num(damping * cycles.period / problem.walls), wall.restitution)
    known = np.nan_to_num(speed)
    r = restitutions(wall, known)
    for _ in range(_REBOUNDS):
        r = restitutions(wall, known * np.sqrt(2.0 / (1.0 + r**2)))
    return r, np.asarray(2.0 / (1.0 + r**2))


def restitutions(wall: Barrier, speed: Floats) -> Floats:
    """The restitution of impacts with these speeds, from 0 to 1."""
    if not callable(wall.restitution):
        return np.full_like(speed, wall.restitution)
    return np.array([restitution_at(wall, v) for v in speed.tolist()])


def endless_walls(system: System, endless: Callable[[Barrier], bool]) -> Iterator[str]:
    """What is said of each wall that is struck infinitely often."""
    for name, wall in system.walls.items():
        if endless(wall):
            yield f"{name} is struck infinitely often by slow impacts: its impact rate and speeds do not exist."


def hits_on_walls(
    problem: Problem,
    cycles: Cycles,
    labels: Labels,
    weight: Floats,
    plane: Floats,
    struck: tuple[Floats, ...],
    damped: Floats,
) -> list[Hits]:
    """The impacts on each wall and contact, in the order of the parts.

    Parameters
    ----------
    problem, cycles, labels
        What was solved, and the cycles at the nodes of the labels.
    weight, plane : ndarray
        Probability of each cycle, per action and per area of the plane of x and v.  The wall takes momentum and energy
        by the former, and is crossed as often as by the latter.
    struck : tuple of ndarray
        The speed of each cycle at each wall and contact; NaN where it is not reached.
    damped : ndarray
        The power that is lost without impacts.
    """
    unit, found = problem.unit, []
    reached = np.sum([np.isfinite(speed) for speed in struck], axis=0)
    for name, speed in zip(unit.stops, struck, strict=True):
        wall, before = unit.walls.get(name), np.ones_like(speed)
        if wall:
            _, before = after_impact(problem, wall, speed, damped, cycles)
        fast = np.sqrt(before) * np.nan_to_num(speed)
        often = np.isfinite(speed) / cycles.period
        rate, first, second = (float(each @ (often * fast**n)) for n, each in enumerate((plane, weight, weight)))
        if not rate > 0.0:
            found.append(Hits(rate, math.nan, math.nan))
        elif wall and is_endless(unit, wall):
            found.append(Hits(math.nan, math.nan, math.nan))
        elif not wall or wall.is_elastic or not problem.white > 0.0:
            found.append(Hits(rate, first / rate, second / rate))
        else:
            part = _SHORT if len(struck) == 1 else _SHORT_UNCORRECTED
            short = part * cycles.period / np.maximum(reached, 1)
            flux = plane / labels.weights.ravel() * often, labels.derivative(fast)
            found.append(_with_short_returns(wall, speed, fast, flux, short, problem.white, (rate, first, second)))
    return found


def _with_short_returns(
    wall: Barrier,
    speed: Floats,
    fast: Floats,
    flux: tuple[Floats, Floats],
    short: Floats,
    intensity: float,
    regular: tuple[float, ...],
) -> Hits:
    """The impacts on one lossy wall; ``flux`` is that by label, and the slope of the speed by it."""
    by_label, slope = flux
    rising = np.isfinite(speed) & (slope > 0.0) & (by_label > 0.0)
    rising &= np.diff(np.maximum.accumulate(fast), prepend=0.0) > 0.0
    if np.count_nonzero(rising) < 4:
        return Hits(regular[0], regular[1] / regular[0], regular[2] / regular[0])

    def turning(v: Floats) -> Floats:
        """The time of the longest short return, in units in which the noise has the intensity 1."""
        return np.asarray(intensity * np.interp(v, speed[rising], short[rising]))

    def rebound(v: Floats) -> Floats:
        return restitutions(wall, v) * v

    power = slow_impact_power(slow_restitution(wall))
    made = with_short_returns(fast[rising], by_label[rising] / slope[rising], turning, rebound, power, regular)
    return Hits(made.rate, made.speed_mean, made.speed_mean_square)


def with_sudden_losses(
    problem: Problem,
    cycles: Cycles,
    weight: Floats,
    struck: tuple[Floats, ...],
    damped: Floats,
    spread: Spread,
    hits: list[Hits],
) -> tuple[Spread, list[Hits]]:
    """Moments and impacts with the correction for sudden losses: one lossy wall, and white noise.

    Parameters
    ----------
    problem, cycles, weight, struck, damped
        As in `hits_on_walls`.
    spread, hits
        What is corrected.
    """
    unit = problem.unit
    walls = tuple(unit.walls.values())
    colored = any(noise.correlated_for for noise in unit.excitations.values())
    other = colored or unit.temperature or problem.multiplied
    if len(unit.stops) != 1 or not walls or walls[0].is_elastic or other or is_smooth(unit):
        return spread, hits
    wall, speed = walls[0], np.nan_to_num(struck[0])
    often = weight * np.isfinite(struck[0]) / cycles.period
    if not often.sum() > 1e-15 / float(weight @ cycles.period):
        return spread, hits
    r, before = after_impact(problem, wall, speed, damped, cycles)
    fast = often * before * speed**2
    r = math.sqrt(float(np.sum(fast * r**2)) / float(np.sum(fast)))
    sign = wall.inwards
    place = sign * (wall.position - problem.origin)
    arc = np.maximum(cycles.arc, 1e-300)
    w = float(weight @ np.sqrt(arc))
    # the arc's centre: there the force on it vanishes, whose mean is that of the wall
    push = 2.0 * speed / cycles.period
    centre = float(often @ (sign * cycles.mean - push / arc)) / float(often.sum())
    damping, gap = float(weight @ damped) / (w * spread.v_square), w * (place - centre) / math.sqrt(spread.v_square)
    if not is_tabulated(damping, gap):
        return spread, hits
    fed = float(weight @ damped) + 0.5 * float(np.sum(fast)) * (1.0 - r * r)
    ratios = sudden_losses(damping, r, gap, float(weight @ damped) / fed)
    # what the wall adds to the mean is seen from the mean of the cycle that just reaches it
    origin = place if place >= 0.0 else sign * float(cycles.mean[np.argmax(np.isfinite(struck[0]))])
    own = max(float(problem.potential.curvature(np.zeros(1))[0]), 0.0)
    mean, square = sign * spread.mean, spread.x_square
    changed, changed_square = moments_from_wall(
        ratios,
        about_origin=(mean - origin, square - 2.0 * origin * mean + origin * origin),
        about_wall=(mean - place, square - 2.0 * place * mean + place * place),
        apart=place - origin,
        stiffening=w / math.sqrt(own) if own > 0.0 else math.inf,
    )
    better = Spread(
        mean=sign * (place + changed),
        x_square=place * place + 2.0 * place * changed + changed_square,
        v_square=ratios.v_square * spread.v_square,
    )
    (hit,) = hits
    if math.isnan(hit.rate):
        return better, hits
    rate = ratios.rate * hit.rate
    pushed = ratios.mean * float(weight @ (np.isfinite(struck[0]) * push))
    # the mean forces of springs and impacts cancel
    return better, [Hits(rate, pushed / ((1.0 + r) * rate), ratios.speed_square * hit.square)]


def is_endless(unit: System, wall: Barrier) -> bool:
    """Whether a wall is struck infinitely often: by slow impacts, or without white noise."""
    slow = slow_restitution(wall)
    return slow <= COLLAPSE_BELOW or (slow < 1.0 and is_smooth(unit))


def is_smooth(unit: System) -> bool:
    """Whether the excitation has no jumps in the momentum."""
    return unit.thermal is None and not any(noise.white_intensity > 0.0 for noise in unit.excitations.values())
