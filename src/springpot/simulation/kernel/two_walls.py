"""Two rigid walls in the kernel, one on either side; soft contacts share what needs both sides."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, LINKED, greater, lesser, typed
from springpot.simulation.kernel.questions import (
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
from springpot.simulation.kernel.restitution import lossless, number_of, rebound, takings
from springpot.simulation.kernel.rigid_wall import (
    SHORTEST_ELASTIC_HOP,
    SHORTEST_HOP,
    bear,
    closing_speed,
    dip,
    is_single,
    leaves,
    margin,
    pressing,
    settle,
    settles,
    stay_or_leave,
)  # fmt: skip
from springpot.simulation.kernel.single_impacts import flight
from springpot.simulation.kernel.watching import LOWER, UPPER, add_impacts, in_window, show_impacts

AT_REST, LEFT_AT_REST, RULES = 3, 5, 7  # places of the sums of a pair, as of one wall


class Pair(NamedTuple):
    """Two rigid walls, low <= x <= high; the sums kept are impacts, speeds and squares at the upper one.

    After them come the impulses of the lower and of the upper wall beside those of impacts, the energies that were left
    where the mass came to rest, and then loss and momentum of the impacts, first of the lower wall, for rules of
    restitution that need these sums.
    """

    low: float
    high: float
    low_rule: Any
    high_rule: Any
    near: bool = True  # both of them, as `is_near`
    low_rests: bool = False  # as of one wall
    high_rests: bool = False


@answers(extras, Pair)
def _extras_of_pair(wall):
    return RULES + takings(wall.low_rule) + takings(wall.high_rule)


@answers(clearance, Splitting, Pair)
def clearance_between(scheme, wall, least, greatest):
    low, high = _reaches(scheme, wall.low, wall.high)
    below = least - low - margin(least, least, greatest)
    return lesser(below, high - greatest - margin(greatest, least, greatest))


@njit(**INLINE)
def _reaches(scheme, low, high):
    """As `_reach` of one wall, of both."""
    deep, nothing = dip(scheme), typed(0.0, low)
    return low + greater(nothing, -low) * deep, high - greater(nothing, high) * deep


@answers(begin, Splitting, Pair)
def _begin_pair(scheme, wall, x, v, early, accumulators, lane, weight):
    x, v = half_step_between(scheme, wall, x, v, 0.0, 0.0, accumulators, lane, weight)
    return lesser(greater(x + early, wall.low), wall.high), v


@answers(held_by, Splitting, Pair)
def _held_between(scheme, wall, x, v):
    if v == 0.0 and wall.low_rests and x == wall.low:
        return 1.0
    return -1.0 if v == 0.0 and wall.high_rests and x == wall.high else 0.0


@answers(stay, Splitting, Pair)
def _stay_between(scheme, wall, side, x, moving, impulse, others, pull, accumulators, lane, weight):
    given, left, pull, middle, taken = stay_or_leave(scheme, side, x, moving, impulse, others, pull)
    accumulators.extras[(AT_REST if side > 0.0 else AT_REST + 1) * LANES + lane] += weight * taken
    return given, left, pull, middle


@answers(bounce, Splitting, Pair)
def bounce_between(scheme, wall, x, v, push, accumulators, lane, before, after):
    """Both halves of a step."""
    xm, vm = half_step_between(scheme, wall, x, v, push, -0.5 * scheme.step, accumulators, lane, before)
    xn, vn = half_step_between(scheme, wall, xm, vm, push, 0.0, accumulators, lane, after)
    return xm, vm, xn, vn


@answers(in_lanes, Splitting, Pair)
def _in_lanes_pair(scheme, wall):
    return wall.near and _between(scheme, wall) and not (wall.low_rests or wall.high_rests)


@njit(**INLINE)
def _between(scheme, wall):
    return is_single(scheme, wall.low_rule) and is_single(scheme, wall.high_rule)


@answers(meet, Splitting, Pair)
def _meet_pair(scheme, wall, x, v):
    xm, vm, low, high, early = _meet_in_half_between(scheme, wall, x, v)
    xn, vn, lower, higher, late = _meet_in_half_between(scheme, wall, x + xm, v + vm)
    return xm, vm, xm + xn, vm + vn, (low, high), (lower, higher), early & late


@njit(**INLINE)
def _meet_in_half_between(scheme, wall, x, v):
    moved, change, _, _ = drift(scheme, x, v)
    return _flight_between(scheme, wall, x, v, moved, change)


@njit(**INLINE)
def _flight_between(scheme, wall, x, v, moved, change):
    """As `flight`, with the speeds at both walls; sure if the flight is too short to go from one wall to the other."""
    nothing, one = typed(0.0, x), typed(1.0, x)
    turn = scheme.frequency * x
    down, slower, low, sure_low = flight(
        scheme.frequency, wall.low, one, typed(number_of(wall.low_rule), x), x, v, moved, change
    )
    up, faster, high, sure_high = flight(
        scheme.frequency, wall.high, -one, typed(number_of(wall.high_rule), x), x, v, moved, change
    )
    far = typed(0.5, x) * scheme.step
    gap = wall.high - wall.low
    close = far * far * (v * v + turn * turn) > gap * gap
    both = (low > nothing) & (high > nothing)
    sure = sure_low & sure_high & (not (both | close))
    moved = down if low > nothing else up if high > nothing else moved
    change = slower if low > nothing else faster if high > nothing else change
    return moved, change, low, high, sure


@answers(limited, Pair)
def _limited_between(wall, x):
    return lesser(greater(x, wall.low), wall.high)


@answers(gather, Pair)
def _gather_between(wall, struck, accumulators, clear, within, beyond):
    found = 0
    for lane in range(LANES):
        found += 1 if struck.low_count[lane] + struck.high_count[lane] > typed(0.0, clear[lane]) else 0
        low_count, low_speed, low_square = in_window(
            struck.low_count, struck.low_speeds, struck.low_squares, struck.low, clear, lane, within, beyond
        )
        high_count, high_speed, high_square = in_window(
            struck.high_count, struck.high_speeds, struck.high_squares, struck.high, clear, lane, within, beyond
        )
        accumulators.impacts[lane] += low_count + high_count
        accumulators.speeds[lane] += low_speed + high_speed
        accumulators.squares[lane] += low_square + high_square
        accumulators.extras[lane] += high_count
        accumulators.extras[LANES + lane] += high_speed
        accumulators.extras[2 * LANES + lane] += high_square
    show_impacts(accumulators.observers, LOWER, struck.low, struck.low_speeds, clear, within, beyond)
    show_impacts(accumulators.observers, UPPER, struck.high, struck.high_speeds, clear, within, beyond)
    return found


@njit(**INLINE)
def half_step_between(scheme, wall, x, v, push, since, accumulators, lane, weight):
    """Half a step with what is on either side; what takes longer is called only near it."""
    moved, change, _, _ = drift(scheme, x, v)
    xh, vh = x + moved, v + change
    low, high = _reaches(scheme, wall.low, wall.high)
    if lesser(x, xh) > low and greater(x, xh) < high:
        return xh, vh
    return strike(wall, scheme, x, v, push, since, accumulators, lane, weight)


def strike(
    wall: Any, scheme: Any, x: Any, v: Any, push: Any, since: Any, accumulators: Any, lane: Any, weight: Any
) -> Any:
    """Compiled code only: half a step that may reach a wall on either side."""
    raise NotImplementedError


@answers(strike, Pair)
def _strike_pair(wall, scheme, x, v, push, since, accumulators, lane, weight):
    press_low = pressing(scheme, wall.low_rests, wall.low, push)
    press_high = pressing(scheme, wall.high_rests, -wall.high, -push)
    if _between(scheme, wall) and not (press_low > 0.0 or press_high > 0.0):
        moved, change, down, up, sure = _meet_in_half_between(scheme, wall, x, v)
        if sure:
            if down + up > 0.0:
                add_impacts(accumulators, UPPER if up > 0.0 else LOWER, lane, weight, 1.0, down + up)
                if up > 0.0:
                    add_to(accumulators, 0, lane, weight, 1.0, up)
            return x + moved, v + change
    phase = 0.5 * scheme.frequency * scheme.step
    return fly_between(wall, scheme, x, v, phase, press_low, press_high, push, since, accumulators, lane, weight)


@njit(**INLINE)
def add_to(accumulators, first, lane, weight, count, speed):
    """Add impacts at one wall, whose sums are the three from number ``first`` on."""
    accumulators.extras[first * LANES + lane] += weight * count
    accumulators.extras[(first + 1) * LANES + lane] += weight * count * speed
    accumulators.extras[(first + 2) * LANES + lane] += weight * count * speed * speed


@njit(**LINKED)
def fly_between(wall, scheme, x, v, phase, press_low, press_high, push, since, accumulators, lane, weight):
    """As `fly`, between two walls.

    The phase angle of the state, atan2(-u, x), grows by the phase: the lower wall is reached at an angle above 0,
    moving down, the upper one below 0.  Against the wall that the linear spring presses on, impacts end as in `fly`.
    """
    frequency = scheme.frequency
    if v == 0.0 and press_low > 0.0 and x == wall.low:
        bear(wall.low, frequency, phase, accumulators, AT_REST, lane, weight)
        return x, v
    if v == 0.0 and press_high > 0.0 and x == wall.high:
        bear(-wall.high, frequency, phase, accumulators, AT_REST + 1, lane, weight)
        return x, v
    u = v / frequency
    left = phase
    struck, arriving = 0, 0.0  # -1: at the lower wall, 1: at the upper one
    if x <= wall.low and u < 0.0:
        struck, arriving = -1, -u
    elif x >= wall.high and u > 0.0:
        struck, arriving = 1, u
    x = lesser(greater(x, wall.low), wall.high)
    while True:
        if struck != 0:
            x = wall.low if struck < 0 else wall.high
            true, press, own = arriving, press_low if struck < 0 else press_high, 0 if struck < 0 else 1
            if press > 0.0:
                away, time = -struck * push, since + (phase - left) / frequency
                true = closing_speed(frequency * arriving, away, time) / frequency
                low_settles = struck < 0 and settles(scheme, wall.low_rule, frequency * true, press)
                if low_settles or (struck > 0 and settles(scheme, wall.high_rule, frequency * true, press)):
                    settle(
                        UPPER if struck > 0 else LOWER, -struck * x, frequency, frequency * arriving, frequency * true,
                        left, accumulators, AT_REST + own, LEFT_AT_REST + own, lane, weight,
                    )  # fmt: skip
                    return x, 0.0
            add_impacts(accumulators, UPPER if struck > 0 else LOWER, lane, weight, 1.0, frequency * true)
            if struck > 0:
                add_to(accumulators, 0, lane, weight, 1.0, frequency * true)
            if struck < 0:
                u = rebound(wall.low_rule, true, frequency, accumulators, RULES, lane, weight)
            else:
                u = rebound(
                    wall.high_rule, true, frequency, accumulators, RULES + takings(wall.low_rule), lane, weight
                )  # fmt: skip
            if press > 0.0:
                taken = u + true
                u = greater(taken - arriving, 0.0)
                accumulators.extras[(AT_REST + own) * LANES + lane] += weight * frequency * (u + arriving - taken)
            u *= -struck
        pressed_down = wall.low > 0.0 and x == wall.low and u >= 0.0
        if pressed_down or (wall.high < 0.0 and x == wall.high and u <= 0.0):
            elastic = lossless(wall.low_rule) if pressed_down else lossless(wall.high_rule)
            hop = 2.0 * math.atan2(abs(u), abs(x))
            if elastic and hop > SHORTEST_ELASTIC_HOP * phase:
                # hops that stay clear of the other wall are counted in one go
                other = wall.high if pressed_down else wall.low
                whole = np.floor(left / hop) if u * u + x * x < other * other else 0.0
                if whole > 0.0:
                    add_impacts(accumulators, LOWER if pressed_down else UPPER, lane, weight, whole, frequency * abs(u))
                    if not pressed_down:
                        add_to(accumulators, 0, lane, weight, whole, frequency * abs(u))
                left -= whole * hop
            elif hop < SHORTEST_HOP * phase and hop < left:
                accumulators.collapses[lane] += 1.0 if struck != 0 else 0.0
                bear(abs(x), frequency, left, accumulators, AT_REST if pressed_down else AT_REST + 1, lane, weight)
                return x, 0.0
        struck = 0
        reach = (u * u + x * x) * left * left  # square of a distance longer than the flight
        if (x - wall.low) * (x - wall.low) <= reach and not leaves(u, -wall.low, left):
            square = u * u + (x - wall.low) * (x + wall.low)
            if square > 0.0:
                height = math.sqrt(square)
                until = math.atan2(height, wall.low) - math.atan2(-u, x)
                if until < left:
                    struck, arriving, soonest = -1, height, until
        if (x - wall.high) * (x - wall.high) <= reach and not leaves(-u, wall.high, left):
            square = u * u + (x - wall.high) * (x + wall.high)
            if square > 0.0:
                height = math.sqrt(square)
                until = math.atan2(-height, wall.high) - math.atan2(-u, x)
                if until < 0.0:  # past it on the way down: a cycle later
                    until += 2.0 * math.pi
                if until < left and (struck == 0 or until < soonest):
                    struck, arriving, soonest = 1, height, until
        if struck == 0:
            break
        left -= soonest
    c = math.cos(left)
    s = math.sin(left)
    return lesser(greater(c * x + s * u, wall.low), wall.high), frequency * (c * u - s * x)
