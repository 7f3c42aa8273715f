"""One rigid wall in the kernel, below the motion: the exact flight of the bare oscillator with all its impacts."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, LINKED, greater, lesser, typed
from springpot.simulation.kernel.no_wall import begin_euler
from springpot.simulation.kernel.questions import (
    Euler,
    Splitting,
    answers,
    begin,
    bounce,
    clearance,
    drift,
    extras,
    gather,
    held_by,
    in_lanes,
    limited,
    meet,
    stay,
)  # fmt: skip
from springpot.simulation.kernel.restitution import lossless, number_of, rebound, share_left, takings
from springpot.simulation.kernel.single_impacts import LONGEST, flight
from springpot.simulation.kernel.watching import LOWER, add_impacts, in_window, show_impact, show_impacts

# Chattering against a preload ends when a flight between two impacts is shorter than this fraction of a half step.
SHORTEST_HOP = 1e-4
SHORTEST_ELASTIC_HOP = 1e-12  # elastic flights are counted in one go, down to rounding
AT_REST, LEFT_AT_REST, RULE = 0, 1, 2  # places of the sums: impulses at rest, energies there, what a rule needs


class Rigid(NamedTuple):
    """A rigid wall under x >= position.

    The first sums kept are its impulse beside that of impacts, on a mass at rest, and the energy that was left where
    the mass came to rest.  After them come loss and momentum of the impacts, for rules of restitution that need these
    sums.  A mass that rests on it is at its place with the velocity 0, exactly: the state itself tells.
    """

    position: float
    rule: Any  # of restitution
    near: bool = True  # as `is_near`
    rests: bool = False  # whether it is lossy, and only smooth forces act on the mass


@answers(extras, Rigid)
def _extras_of_rigid(wall):
    return RULE + takings(wall.rule)


@answers(begin, Splitting, Rigid)
def _begin_splitting(scheme, wall, x, v, early, accumulators, lane, weight):
    phase = 0.5 * scheme.frequency * scheme.step
    press = pressing(scheme, wall.rests, wall.position, 0.0)
    x, v = fly(wall.position, wall.rule, scheme, x, v, phase, press, 0.0, 0.0, accumulators, lane, weight)
    return greater(x + early, wall.position), v


answers(begin, Euler, Rigid)(begin_euler)


@answers(clearance, Splitting, Rigid)
def _clearance_splitting(scheme, wall, least, greatest):
    return least - _reach(scheme, wall) - margin(least, least, greatest)


@njit(**INLINE)
def margin(near, least, greatest):
    """More than the rounding of single numbers near a wall."""
    return typed(1e-6, least) * (abs(near) + (greatest - least))


@njit(**INLINE)
def _reach(scheme, wall):
    """Position above which both ends of a half step must lie so that it has no impact.

    With a gap the spring pulls away from the wall, and a path may go below the lower of the two ends in between: by at
    most (acceleration at the wall) (half step)^2 / 8.
    """
    return wall.position + greater(typed(0.0, wall.position), -wall.position) * dip(scheme)


@njit(**INLINE)
def dip(scheme):
    """How far below both ends of a half step a path may go, over the wall's distance; see `_reach`."""
    turn = scheme.frequency * scheme.step
    return turn * turn * typed(1.01 / 32.0, turn)


@njit(**INLINE)
def is_single(scheme, rule):
    """Whether there is at most one impact in half a step, but where a preload presses."""
    return number_of(rule) >= 0.0 and scheme.frequency * scheme.step < LONGEST


@answers(in_lanes, Splitting, Rigid)
def _in_lanes_rigid(scheme, wall):
    return wall.near and is_single(scheme, wall.rule) and not wall.rests


@answers(meet, Splitting, Rigid)
def _meet_rigid(scheme, wall, x, v):
    xm, vm, first, early = _meet_in_half(scheme, wall, x, v)
    xn, vn, second, late = _meet_in_half(scheme, wall, x + xm, v + vm)
    nothing = typed(0.0, x)
    return xm, vm, xm + xn, vm + vn, (first, nothing), (second, nothing), early & late


@njit(**INLINE)
def _meet_in_half(scheme, wall, x, v):
    moved, change, _, _ = drift(scheme, x, v)
    number = typed(number_of(wall.rule), x)
    return flight(scheme.frequency, wall.position, typed(1.0, x), number, x, v, moved, change)


@answers(limited, Rigid)
def _limited_below(wall, x):
    return greater(x, wall.position)


@answers(gather, Rigid)
def _gather_below(wall, struck, accumulators, clear, within, beyond):
    found = 0
    for lane in range(LANES):
        found += 1 if struck.low_count[lane] > typed(0.0, clear[lane]) else 0
        count, speed, square = in_window(
            struck.low_count, struck.low_speeds, struck.low_squares, struck.low, clear, lane, within, beyond
        )
        accumulators.impacts[lane] += count
        accumulators.speeds[lane] += speed
        accumulators.squares[lane] += square
    show_impacts(accumulators.observers, LOWER, struck.low, struck.low_speeds, clear, within, beyond)
    return found


@njit(**INLINE)
def _half_step(scheme, wall, x, v, push, since, accumulators, lane, weight):
    """Half a step with the wall; what takes longer is called only near the wall."""
    moved, change, _, _ = drift(scheme, x, v)
    xh, vh = x + moved, v + change
    if lesser(x, xh) > _reach(scheme, wall):
        return xh, vh
    press = pressing(scheme, wall.rests, wall.position, push)
    if is_single(scheme, wall.rule) and not press > 0.0:
        moved, change, speed, sure = flight(
            scheme.frequency, wall.position, 1.0, number_of(wall.rule), x, v, moved, change
        )
        if sure:
            if speed > 0.0:
                add_impacts(accumulators, LOWER, lane, weight, 1.0, speed)
            return x + moved, v + change
    phase = 0.5 * scheme.frequency * scheme.step
    return fly(wall.position, wall.rule, scheme, x, v, phase, press, push, since, accumulators, lane, weight)


@answers(held_by, Splitting, Rigid)
def _held_below(scheme, wall, x, v):
    return 1.0 if wall.rests and x == wall.position and v == 0.0 else 0.0


@answers(stay, Splitting, Rigid)
def _stay_below(scheme, wall, side, x, moving, impulse, others, pull, accumulators, lane, weight):
    given, left, pull, middle, taken = stay_or_leave(scheme, side, x, moving, impulse, others, pull)
    accumulators.extras[AT_REST * LANES + lane] += weight * taken
    return given, left, pull, middle


@njit(**INLINE)
def stay_or_leave(scheme, side, x, moving, impulse, others, pull):
    """What `stay` returns, and what the wall takes.

    While kick and spring together press, the mass stays.  Else it leaves with half of the impulse: by the middle of the
    step it has begun to move.  Only this half works on it, and at half of the velocity.
    """
    given = others + impulse / scheme.share  # without the answer of springpots and dashpots to it
    if side * given > side * x * (scheme.frequency * scheme.frequency * scheme.step) and side * moving > 0.0:
        return given, 0.5 * moving, pull, 0.125 * moving, -0.5 * side * moving
    return given, 0.0, pull - scheme.answer * impulse, 0.0, -side * given


@answers(bounce, Splitting, Rigid)
def _bounce_splitting(scheme, wall, x, v, push, accumulators, lane, before, after):
    xm, vm = _half_step(scheme, wall, x, v, push, -0.5 * scheme.step, accumulators, lane, before)
    xn, vn = _half_step(scheme, wall, xm, vm, push, 0.0, accumulators, lane, after)
    return xm, vm, xn, vn


@njit(**INLINE)
def leaves(away, gap, left):
    """Whether a flight over the phase ``left`` cannot reach a wall, because the mass moves away from it.

    ``away`` is the velocity away from the wall.  Where the spring does not press on it (``gap`` from the spring's
    rest to the wall at least 0), the mass must first turn round, which takes a quarter of a cycle (1.57).
    """
    return away >= 0.0 and gap >= 0.0 and left < 1.5


@njit(**INLINE)
def bear(place, frequency, left, accumulators, number, lane, weight):
    """Add the impulse of a wall at ``place`` on a mass that rests there over the phase ``left``, to a sum of its own.

    It is that of the spring, which presses the mass against the wall or, where ``place`` is below 0, pulls.
    """
    accumulators.extras[number * LANES + lane] += weight * frequency * place * left


@njit(**INLINE)
def pressing(scheme, rests, place, push):
    """The acceleration with which the spring and the last kick press a mass on a wall below it where it can rest.

    0 where they do not, and on walls on which it cannot.
    """
    return greater(scheme.frequency * scheme.frequency * place - push, 0.0) if rests else 0.0


@njit(**INLINE)
def closing_speed(arriving, push, since):
    """The true speed of an impact ``since`` the middle between two kicks, of which the last one pushes away.

    Before that middle it has given more of its impulse than the mass has by then, after it less.
    """
    return greater(arriving - push * since, 0.0)


@njit(**INLINE)
def settles(scheme, rule, speed, press):
    """Whether the hop after an impact at this speed would be shorter than a step: then the mass comes to rest."""
    return share_left(rule, speed) * speed <= 0.5 * press * scheme.step


@njit(**INLINE)
def settle(stop, place, frequency, arriving, speed, left, accumulators, momentum, loss, lane, weight):
    """The wall takes all that is left of the velocity, and bears the spring over the phase ``left``.

    It is added to the sums of number ``momentum`` and ``loss``, and not to those of impacts; observers choose which
    impacts count, and see it.
    """
    if weight > 0.0 and speed > 0.0:
        show_impact(accumulators.observers, stop, 1.0, speed, lane)
    accumulators.extras[momentum * LANES + lane] += weight * arriving
    bear(place, frequency, left, accumulators, momentum, lane, weight)
    accumulators.extras[loss * LANES + lane] += weight * 0.5 * speed * speed


@njit(**LINKED)
def fly(position, rule, scheme, x, v, phase, press, push, since, accumulators, lane, weight):
    """Exact flight of the bare oscillator over ``phase`` = frequency * time above a wall, impacts included.

    Returns x and v; impacts are added to the accumulators.  When the flights of a chattering sequence are shorter than
    ``SHORTEST_HOP`` of ``phase``, the mass rests on the wall until the end, which then bears the force of the spring.
    It begins at the time ``since`` after the middle between two kicks, of which the last one gave the acceleration
    ``push``.  Where that and the spring ``press`` on a wall on which the mass can rest, impacts have their true speeds,
    and the mass rests when its hops become shorter than a step.
    """
    frequency = scheme.frequency
    if press > 0.0 and x == position and v == 0.0:
        bear(position, frequency, phase, accumulators, AT_REST, lane, weight)
        return x, v
    u = v / frequency
    left = phase
    arriving = -u if x <= position and u < 0.0 else 0.0  # already there and moving in: an impact at once
    struck = False
    x = greater(x, position)
    while True:
        if arriving > 0.0:
            x, true = position, arriving
            if press > 0.0:
                true = closing_speed(frequency * arriving, push, since + (phase - left) / frequency) / frequency
                if settles(scheme, rule, frequency * true, press):
                    settle(
                        LOWER, position, frequency, frequency * arriving, frequency * true, left, accumulators, AT_REST,
                        LEFT_AT_REST, lane, weight,
                    )  # fmt: skip
                    return x, 0.0
            add_impacts(accumulators, LOWER, lane, weight, 1.0, frequency * true)
            struck = True
            u = rebound(rule, true, frequency, accumulators, RULE, lane, weight)
            if press > 0.0:
                taken = u + true
                u = greater(taken - arriving, 0.0)
                accumulators.extras[AT_REST * LANES + lane] += weight * frequency * (u + arriving - taken)
        if position > 0.0 and x == position and u >= 0.0:  # a preload brings the mass back to the wall
            hop = 2.0 * math.atan2(u, position)
            if lossless(rule) and hop > SHORTEST_ELASTIC_HOP * phase:
                whole = np.floor(left / hop)
                if whole > 0.0:
                    add_impacts(accumulators, LOWER, lane, weight, whole, frequency * u)
                left -= whole * hop
            elif hop < SHORTEST_HOP * phase and hop < left:
                accumulators.collapses[lane] += 1.0 if struck else 0.0
                bear(position, frequency, left, accumulators, AT_REST, lane, weight)
                return position, 0.0
        if leaves(u, -position, left):
            break
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
    return greater(c * x + s * u, position), frequency * (c * u - s * x)


@answers(clearance, Euler, Rigid)
def _clearance_euler(scheme, wall, least, greatest):
    # `bounce` is called also for a path behind the wall that moves away; it changes nothing then
    return least - (wall.position + scheme.contact)


@answers(bounce, Euler, Rigid)
def _bounce_euler(scheme, wall, x, v, push, accumulators, lane, before, after):
    xn = x + scheme.step * v
    if clearance(scheme, wall, xn, xn) <= 0.0 and v < 0.0:
        add_impacts(accumulators, LOWER, lane, before, 1.0, -v)
        v = rebound(wall.rule, -v, 1.0, accumulators, RULE, lane, before)
    return xn, v, xn, v
