"""Soft contacts in the kernel, with or without rigid walls behind them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numba import njit

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.lanes import INLINE, LANES, MOST_CONTACTS, greater, lesser, stack_array
from springpot.simulation.kernel.no_wall import NoWall
from springpot.simulation.kernel.questions import Splitting, answers, begin, bounce, clearance, extras
from springpot.simulation.kernel.two_walls import (
    Pair,
    add_to,
    bounce_between,
    clearance_between,
    fly_between,
    half_step_between,
    strike,
)  # fmt: skip
from springpot.simulation.kernel.watching import CONTACTS, add_impacts, show_peak

_by_contact = stack_array(MOST_CONTACTS)


class Soft(NamedTuple):
    """Soft contacts, and perhaps rigid walls behind them; they are advanced in short steps of their own.

    The sums kept are those of the rigid walls, work done on the mass, time in contact, largest penetration, and of each
    contact impacts, speeds, squares, dissipated energy and momentum.  Beyond them is the largest force of its touch.
    """

    low: float  # what is touched first on either side, infinitely far where there is nothing
    high: float
    rigid: Any  # Pair or NoWall
    contacts: Floats  # five numbers of each: place, direction of its force, stiffness, exponent, dissipation
    substeps: int  # of half a step


@answers(extras, Soft)
def _extras_of_soft(wall):
    return extras(wall.rigid) + 3 + 5 * (wall.contacts.size // 5)


@answers(begin, Splitting, Soft)
def _begin_soft(scheme, wall, x, v, early, accumulators, lane, weight):
    x, v = half_step_between(scheme, wall, x, v, 0.0, 0.0, accumulators, lane, weight)
    return x + early, v


@answers(strike, Soft)
def _strike_soft(wall, scheme, x, v, push, since, accumulators, lane, weight):
    return _push_through(wall, scheme, x, v, 0.5 * scheme.step, accumulators, lane, weight)


def travel(rigid: Any, scheme: Any, x: Any, v: Any, c: Any, s: Any, accumulators: Any, lane: Any, weight: Any) -> Any:
    """Compiled code only: flight over a phase of cosine ``c`` and sine ``s`` behind soft contacts."""
    raise NotImplementedError


@answers(travel, NoWall)
def _travel_freely(rigid, scheme, x, v, c, s, accumulators, lane, weight):
    frequency = scheme.frequency
    return c * x + s / frequency * v, c * v - s * frequency * x


@answers(travel, Pair)
def _travel_between(rigid, scheme, x, v, c, s, accumulators, lane, weight):
    frequency = scheme.frequency
    xn, vn = c * x + s / frequency * v, c * v - s * frequency * x
    near = 2.0 * s * s  # a short flight leaves the line between its ends by less than this part of x
    if lesser(x, xn) > rigid.low + near * abs(rigid.low) and greater(x, xn) < rigid.high - near * abs(rigid.high):
        return xn, vn
    return fly_between(rigid, scheme, x, v, math.atan2(s, c), 0.0, 0.0, 0.0, 0.0, accumulators, lane, weight)


def behind(rigid: Any, away: Any) -> Any:
    """Compiled code only: the place of the rigid wall behind a contact that pushes in this direction."""
    raise NotImplementedError


@answers(behind, NoWall)
def _nothing_behind(rigid, away):
    return -1e30 * away


@answers(behind, Pair)
def _wall_behind(rigid, away):
    return rigid.low if away > 0.0 else rigid.high


@njit(**INLINE)
def _push_through(wall, scheme, x, v, time, accumulators, lane, weight):
    """Half a step: exact flights, and between them the contacts, ``substeps`` times."""
    frequency = scheme.frequency
    square, count, own = frequency * frequency, wall.contacts.size // 5, extras(wall.rigid)
    short = time / wall.substeps
    forces = _by_contact(0.0)
    c, s = math.cos(0.5 * frequency * short), math.sin(0.5 * frequency * short)
    whole_c, whole_s = c * c - s * s, 2.0 * c * s
    begun, before, arriving = v * v + square * x * x, x, v
    x, v = travel(wall.rigid, scheme, x, v, c, s, accumulators, lane, weight)
    for left in range(wall.substeps, 0, -1):
        _add_touches(wall, square, before, arriving, x, v, accumulators, lane, weight)
        pushed, damped, deepest = 0.0, 0.0, 0.0
        for n in range(count):
            depth, force = force_of_contact(wall.contacts, n, x, short)
            forces[n] = force
            pushed += wall.contacts[5 * n + 1] * force
            damped += 0.5 * force * wall.contacts[5 * n + 4]
            deepest = greater(deepest, depth)
        if deepest > 0.0:
            later = (v * (1.0 - damped) + pushed) / (1.0 + damped) if damped > 0.0 else v + pushed
            middle = 0.5 * (v + later)
            v = later
            for n in range(count):
                force = forces[n]
                place = (own + 6 + 5 * n) * LANES + lane
                viscous = force * wall.contacts[5 * n + 4] * middle
                accumulators.extras[place] += weight * viscous * middle
                momentum = force - wall.contacts[5 * n + 1] * viscous
                accumulators.extras[place + LANES] += weight * momentum
                top = (extras(wall) + n) * LANES + lane
                accumulators.extras[top] = greater(accumulators.extras[top], momentum / short)
            accumulators.extras[(own + 1) * LANES + lane] += weight * short
            if weight > 0.0:
                place = (own + 2) * LANES + lane
                accumulators.extras[place] = greater(accumulators.extras[place], deepest)
        before, arriving = x, v
        cosine, sine = (c, s) if left == 1 else (whole_c, whole_s)
        x, v = travel(wall.rigid, scheme, x, v, cosine, sine, accumulators, lane, weight)
    _add_touches(wall, square, before, arriving, x, v, accumulators, lane, weight)
    for n in range(count):
        top = (extras(wall) + n) * LANES + lane
        if accumulators.extras[top] > 0.0 and wall.contacts[5 * n + 1] * (x - wall.contacts[5 * n]) >= 0.0:
            if weight > 0.0:
                show_peak(accumulators.observers, n, accumulators.extras[top], lane)
            accumulators.extras[top] = 0.0
    accumulators.extras[own * LANES + lane] += weight * 0.5 * (v * v + square * x * x - begun)
    return x, v


@njit(**INLINE)
def _add_touches(wall, square, before, arriving, x, v, accumulators, lane, weight):
    """Impacts on contacts are first touches in a flight, from ``before`` and ``arriving`` to x and v.

    The flight ends in the contact, or is out of it again after an impact on the wall behind.  The speed is that of the
    flight: where another contact acts, half of its push in a short step may be missing.
    """
    for n in range(wall.contacts.size // 5):
        place, away = wall.contacts[5 * n], wall.contacts[5 * n + 1]
        if away * (before - place) >= 0.0:
            last = behind(wall.rigid, away)
            reached = arriving * arriving + square * (before - last) * (before + last) > 0.0
            if away * (x - place) < 0.0 or (reached and away * arriving < 0.0 < away * v):
                left = arriving * arriving + square * (before - place) * (before + place)
                speed = math.sqrt(greater(left, 0.0))
                add_impacts(accumulators, CONTACTS + n, lane, weight, 1.0, speed)
                add_to(accumulators, extras(wall.rigid) + 3 + 5 * n, lane, weight, 1.0, speed)


@njit(**INLINE)
def force_of_contact(contacts, n, x, short):
    """Depth of contact ``n``, and the impulse of its elastic force in a short step."""
    depth = contacts[5 * n + 1] * (contacts[5 * n] - x)
    if depth <= 0.0:
        return 0.0, 0.0
    exponent = contacts[5 * n + 3]
    force = depth if exponent == 1.0 else depth * math.sqrt(depth) if exponent == 1.5 else depth**exponent
    return depth, short * contacts[5 * n + 2] * force


answers(clearance, Splitting, Soft)(clearance_between)
answers(bounce, Splitting, Soft)(bounce_between)
