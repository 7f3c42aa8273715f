"""Walls in the kernel: none, a rigid one below the motion.

The module's text of `springpot.simulation.parts` says what the kernel asks a wall.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from springpot.simulation.lanes import FAST, INLINE
from springpot.simulation.observers import add_impacts
from springpot.simulation.parts import Euler, Splitting, answers, begin, bounce, clearance, drift, extras

__all__ = ["NoWall", "Rigid", "fly"]

# Chattering against a preload ends when a flight between two impacts is shorter than this fraction of a half step.
SHORTEST_HOP = 1e-4
SHORTEST_ELASTIC_HOP = 1e-12  # elastic flights are counted in one go, down to rounding


class NoWall(NamedTuple):
    """No wall (with an unused field, because Numba cannot type an empty tuple)."""

    unused: float


class Rigid(NamedTuple):
    """A rigid wall under x >= position."""

    position: float
    restitution: float


@answers(extras, NoWall)
@answers(extras, Rigid)
def _no_extras(wall):
    return 0


@answers(clearance, Euler, NoWall)
@answers(clearance, Splitting, NoWall)
def _clear_of_nothing(scheme, wall, x0, xm, x):
    return 1.0


@answers(bounce, Euler, NoWall)
@answers(bounce, Splitting, NoWall)
def _bounce_never(scheme, wall, x, v, accumulators, lane, before, after):
    return drift(scheme, x, v)


@answers(begin, Splitting, NoWall)
def _begin_free(scheme, wall, x, v, early, accumulators, lane, weight):
    x, v, _, _ = drift(scheme, x, v)
    return x + early, v


@answers(begin, Splitting, Rigid)
def _begin_splitting(scheme, wall, x, v, early, accumulators, lane, weight):
    phase = 0.5 * scheme.frequency * scheme.step
    x, v = fly(wall.position, wall.restitution, scheme.frequency, x, v, phase, accumulators, lane, weight)
    return max(x + early, wall.position), v


@answers(begin, Euler, NoWall)
@answers(begin, Euler, Rigid)
def _begin_euler(scheme, wall, x, v, early, accumulators, lane, weight):
    return x, v


@answers(clearance, Splitting, Rigid)
def _clearance_splitting(scheme, wall, x0, xm, x):
    return min(x0, min(xm, x)) - _reach(scheme, wall)


@njit(**INLINE)
def _reach(scheme, wall):
    """Position above which both ends of a half step must lie so that it has no impact.

    With a gap the spring pulls away from the wall, and a path may go below the lower of the two ends in between: by at
    most (acceleration at the wall) (half step)^2 / 8.
    """
    dip = max(0.0, -wall.position) * (scheme.frequency * scheme.step) ** 2 * (1.01 / 32.0)
    return wall.position + dip


@njit(**INLINE)
def _half_step(scheme, wall, x, v, accumulators, lane, weight):
    """Half a step with the wall; trigonometric functions are called only near the wall."""
    xh = scheme.cosine * x + scheme.sine_over_frequency * v
    vh = scheme.cosine * v - scheme.sine_times_frequency * x
    if min(x, xh) > _reach(scheme, wall):
        return xh, vh
    phase = 0.5 * scheme.frequency * scheme.step
    return fly(wall.position, wall.restitution, scheme.frequency, x, v, phase, accumulators, lane, weight)


@answers(bounce, Splitting, Rigid)
def _bounce_splitting(scheme, wall, x, v, accumulators, lane, before, after):
    xm, vm = _half_step(scheme, wall, x, v, accumulators, lane, before)
    xn, vn = _half_step(scheme, wall, xm, vm, accumulators, lane, after)
    return xm, vm, xn, vn


@njit(**FAST)
def fly(position, restitution, frequency, x, v, phase, accumulators, lane, weight):
    """Exact flight of the bare oscillator over ``phase`` = frequency * time above a wall, impacts included.

    Returns x and v; impacts are added to the accumulators.  When the flights of a chattering sequence are shorter than
    ``SHORTEST_HOP`` of ``phase``, the mass rests on the wall until the end.
    """
    u = v / frequency
    left = phase
    arriving = -u if x <= position and u < 0.0 else 0.0  # already there and moving in: an impact at once
    struck = False
    x = max(x, position)
    while True:
        if arriving > 0.0:
            add_impacts(accumulators, lane, weight, 1.0, frequency * arriving)
            struck = True
            x = position
            u = restitution * arriving
        if position > 0.0 and x == position and u >= 0.0:  # a preload brings the mass back to the wall
            hop = 2.0 * math.atan2(u, position)
            if restitution == 1.0 and hop > SHORTEST_ELASTIC_HOP * phase:
                whole = np.floor(left / hop)
                if whole > 0.0:
                    add_impacts(accumulators, lane, weight, whole, frequency * u)
                left -= whole * hop
            elif hop < SHORTEST_HOP * phase and hop < left:
                accumulators.collapses[lane] += 1.0 if struck else 0.0
                return position, 0.0
        square = u * u + (x - position) * (x + position)
        if not square > 0.0:  # the gap is never closed (or the state is NaN)
            break
        height = math.sqrt(square)  # u at the wall
        until = math.atan2(height, position) - math.atan2(-u, x)
        if not until < left:
            break
        left -= until
        arriving = height
    c = math.cos(left)
    s = math.sin(left)
    return max(c * x + s * u, position), frequency * (c * u - s * x)


@answers(clearance, Euler, Rigid)
def _clearance_euler(scheme, wall, x0, xm, x):
    # `bounce` is called also for a path behind the wall that moves away; it changes nothing then
    return x - (wall.position + scheme.contact)


@answers(bounce, Euler, Rigid)
def _bounce_euler(scheme, wall, x, v, accumulators, lane, before, after):
    xm, _, xn, vn = drift(scheme, x, v)
    if clearance(scheme, wall, x, xm, xn) <= 0.0 and vn < 0.0:
        add_impacts(accumulators, lane, before, 1.0, -vn)
        vn = -wall.restitution * vn
    return xn, vn, xn, vn
