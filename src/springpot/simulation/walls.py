"""Walls in the kernel: none, a rigid one below the motion, one on either side, soft contacts before either.

The module's text of `springpot.simulation.parts` says what the kernel asks a wall.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.simulation.lanes import INLINE, LANES, LINKED, MOST_CONTACTS, stack_array, typed
from springpot.simulation.observers import add_impacts, show_impacts
from springpot.simulation.parts import (
    Euler,
    Splitting,
    answers,
    begin,
    bounce,
    clearance,
    drift,
    extras,
    gather,
    in_lanes,
    limited,
    meet,
)
from springpot.simulation.restitution import Fixed, lossless, number_of, rebound, takings
from springpot.simulation.single_impacts import LONGEST, flight

__all__ = ["NoWall", "Pair", "Rigid", "Soft", "fly", "fly_between", "is_near", "sums_of"]

Floats = npt.NDArray[np.float64]

# Chattering against a preload ends when a flight between two impacts is shorter than this fraction of a half step.
SHORTEST_HOP = 1e-4
_TAKEN = "loss", "momentum"
_NEAR = 4.0
SHORTEST_ELASTIC_HOP = 1e-12  # elastic flights are counted in one go, down to rounding

_by_contact = stack_array(MOST_CONTACTS)


class NoWall(NamedTuple):
    """No wall (with an unused field, because Numba cannot type an empty tuple)."""

    unused: float


class Rigid(NamedTuple):
    """A rigid wall under x >= position."""

    position: float
    rule: Any  # of restitution
    near: bool = True  # as `is_near`


class Pair(NamedTuple):
    """Two rigid walls, low <= x <= high; the sums kept are impacts, speeds and squares at the upper one.

    After them come loss and momentum, first of the lower wall, for rules of restitution that need these sums.
    """

    low: float
    high: float
    low_rule: Any
    high_rule: Any
    near: bool = True  # both of them, as `is_near`


class Soft(NamedTuple):
    """Soft contacts, and perhaps rigid walls behind them; they are advanced in short steps of their own.

    The sums kept are those of the rigid walls, work done on the mass, time in contact, largest penetration, and of each
    contact impacts, speeds, squares, dissipated energy and momentum.
    """

    low: float  # what is touched first on either side, infinitely far where there is nothing
    high: float
    rigid: Any  # Pair or NoWall
    contacts: Floats  # five numbers of each: place, direction of its force, stiffness, exponent, dissipation
    substeps: int  # of half a step


def is_near(place: float, spread: float) -> bool:
    """Whether vector code may find impacts on a wall at ``place``, which it does in single precision.

    Not if the motion, of the standard deviation ``spread``, is small beside the wall's distance from the spring's rest.

    Examples
    --------
    >>> is_near(0.0, 0.0), is_near(-3.0, 1.0), is_near(1.0, 0.01)
    (True, True, False)
    """
    return abs(place) <= _NEAR * spread


def sums_of(wall: NoWall | Rigid | Pair | Soft) -> tuple[str, ...]:
    """The names of the sums that a wall keeps, in their order.

    Examples
    --------
    >>> sums_of(Rigid(0.0, Fixed(0.5))), sums_of(Pair(0.0, 1.0, Fixed(0.5), Fixed(0.5)))
    ((), ('upper impacts', 'upper speeds', 'upper squares'))
    """
    each = "impacts", "speeds", "squares"
    match wall:
        case Rigid():
            return () if isinstance(wall.rule, Fixed) else ("lower loss", "lower momentum")
        case Pair():
            rules = ("lower", wall.low_rule), ("upper", wall.high_rule)
            own = (f"{where} {name}" for where, rule in rules if not isinstance(rule, Fixed) for name in _TAKEN)
            return *(f"upper {name}" for name in each), *own
        case Soft():
            own = (f"contact {n} {name}" for n in range(wall.contacts.size // 5) for name in (*each, *_TAKEN))
            return *sums_of(wall.rigid), "contacts' work", "contacts' time", "contacts' depth", *own
        case _:
            return ()


@answers(extras, NoWall)
def _no_extras(wall):
    return 0


@answers(extras, Rigid)
def _extras_of_rigid(wall):
    return takings(wall.rule)


@answers(clearance, Euler, NoWall)
@answers(clearance, Splitting, NoWall)
def _clear_of_nothing(scheme, wall, least, greatest):
    return typed(1.0, least)


@answers(bounce, Euler, NoWall)
@answers(bounce, Splitting, NoWall)
def _bounce_never(scheme, wall, x, v, accumulators, lane, before, after):
    xm, vm, xn, vn = drift(scheme, x, v)
    return x + xm, v + vm, x + xn, v + vn


@answers(in_lanes, object, object)
def _not_in_lanes(scheme, wall):
    return False


@answers(meet, object, object)
def _meet_nothing(scheme, wall, x, v):
    xm, vm, dx, dv = drift(scheme, x, v)
    nothing = typed(0.0, x)
    return xm, vm, dx, dv, (nothing, nothing), (nothing, nothing), False


@answers(limited, object)
def _not_limited(wall, x):
    return x


@answers(limited, Rigid)
def _limited_below(wall, x):
    return max(x, wall.position)


@answers(limited, Pair)
def _limited_between(wall, x):
    return min(max(x, wall.low), wall.high)


@answers(gather, object)
def _gather_nothing(wall, struck, accumulators, clear, within):
    return 0


@answers(gather, Rigid)
def _gather_below(wall, struck, accumulators, clear, within):
    found = 0
    for lane in range(LANES):
        share = clear[lane] if within else typed(0.0, clear[lane])
        found += 1 if struck.low_count[lane] > typed(0.0, clear[lane]) else 0
        accumulators.impacts[lane] += share * struck.low_count[lane]
        accumulators.speeds[lane] += share * struck.low_speeds[lane]
        accumulators.squares[lane] += share * struck.low_squares[lane]
    if within:
        show_impacts(accumulators.observers, struck.low, clear)
    return found


@answers(gather, Pair)
def _gather_between(wall, struck, accumulators, clear, within):
    found = 0
    for lane in range(LANES):
        share = clear[lane] if within else typed(0.0, clear[lane])
        count = struck.low_count[lane] + struck.high_count[lane]
        found += 1 if count > typed(0.0, count) else 0
        accumulators.impacts[lane] += share * count
        accumulators.speeds[lane] += share * (struck.low_speeds[lane] + struck.high_speeds[lane])
        accumulators.squares[lane] += share * (struck.low_squares[lane] + struck.high_squares[lane])
        accumulators.extras[lane] += share * struck.high_count[lane]
        accumulators.extras[LANES + lane] += share * struck.high_speeds[lane]
        accumulators.extras[2 * LANES + lane] += share * struck.high_squares[lane]
    if within:
        show_impacts(accumulators.observers, struck.low, clear)
        show_impacts(accumulators.observers, struck.high, clear)
    return found


@answers(begin, Splitting, NoWall)
def _begin_free(scheme, wall, x, v, early, accumulators, lane, weight):
    moved, change, _, _ = drift(scheme, x, v)
    return x + moved + early, v + change


@answers(begin, Splitting, Rigid)
def _begin_splitting(scheme, wall, x, v, early, accumulators, lane, weight):
    phase = 0.5 * scheme.frequency * scheme.step
    x, v = fly(wall.position, wall.rule, scheme.frequency, x, v, phase, accumulators, lane, weight)
    return max(x + early, wall.position), v


@answers(begin, Euler, NoWall)
@answers(begin, Euler, Rigid)
def _begin_euler(scheme, wall, x, v, early, accumulators, lane, weight):
    return x, v


@answers(clearance, Splitting, Rigid)
def _clearance_splitting(scheme, wall, least, greatest):
    return least - _reach(scheme, wall) - _margin(least, least, greatest)


@njit(**INLINE)
def _margin(near, least, greatest):
    """More than the rounding of single numbers near a wall."""
    return typed(1e-6, least) * (abs(near) + (greatest - least))


@njit(**INLINE)
def _reach(scheme, wall):
    """Position above which both ends of a half step must lie so that it has no impact.

    With a gap the spring pulls away from the wall, and a path may go below the lower of the two ends in between: by at
    most (acceleration at the wall) (half step)^2 / 8.
    """
    return wall.position + max(typed(0.0, wall.position), -wall.position) * _dip(scheme)


@njit(**INLINE)
def _dip(scheme):
    turn = scheme.frequency * scheme.step
    return turn * turn * typed(1.01 / 32.0, turn)


@njit(**INLINE)
def _single(scheme, rule):
    """Whether there is at most one impact in half a step, but where a preload presses."""
    return number_of(rule) >= 0.0 and scheme.frequency * scheme.step < LONGEST


@answers(in_lanes, Splitting, Rigid)
def _in_lanes_rigid(scheme, wall):
    return wall.near and _single(scheme, wall.rule)


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


@njit(**INLINE)
def _half_step(scheme, wall, x, v, accumulators, lane, weight):
    """Half a step with the wall; what takes longer is called only near the wall."""
    moved, change, _, _ = drift(scheme, x, v)
    xh, vh = x + moved, v + change
    if min(x, xh) > _reach(scheme, wall):
        return xh, vh
    if _single(scheme, wall.rule):
        moved, change, speed, sure = flight(
            scheme.frequency, wall.position, 1.0, number_of(wall.rule), x, v, moved, change
        )
        if sure:
            if speed > 0.0:
                add_impacts(accumulators, lane, weight, 1.0, speed)
            return x + moved, v + change
    phase = 0.5 * scheme.frequency * scheme.step
    return fly(wall.position, wall.rule, scheme.frequency, x, v, phase, accumulators, lane, weight)


@answers(bounce, Splitting, Rigid)
def _bounce_splitting(scheme, wall, x, v, accumulators, lane, before, after):
    xm, vm = _half_step(scheme, wall, x, v, accumulators, lane, before)
    xn, vn = _half_step(scheme, wall, xm, vm, accumulators, lane, after)
    return xm, vm, xn, vn


@njit(**INLINE)
def _leaves(away, gap, left):
    """Whether a flight over the phase ``left`` cannot reach a wall, because the mass moves away from it.

    ``away`` is the velocity away from the wall.  Where the spring does not press on it (``gap`` from the spring's
    rest to the wall at least 0), the mass must first turn round, which takes a quarter of a cycle (1.57).
    """
    return away >= 0.0 and gap >= 0.0 and left < 1.5


@njit(**LINKED)
def fly(position, rule, frequency, x, v, phase, accumulators, lane, weight):
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
            u = rebound(rule, arriving, frequency, accumulators, 0, lane, weight)
        if position > 0.0 and x == position and u >= 0.0:  # a preload brings the mass back to the wall
            hop = 2.0 * math.atan2(u, position)
            if lossless(rule) and hop > SHORTEST_ELASTIC_HOP * phase:
                whole = np.floor(left / hop)
                if whole > 0.0:
                    add_impacts(accumulators, lane, weight, whole, frequency * u)
                left -= whole * hop
            elif hop < SHORTEST_HOP * phase and hop < left:
                accumulators.collapses[lane] += 1.0 if struck else 0.0
                return position, 0.0
        if _leaves(u, -position, left):
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
    return max(c * x + s * u, position), frequency * (c * u - s * x)


@answers(clearance, Euler, Rigid)
def _clearance_euler(scheme, wall, least, greatest):
    # `bounce` is called also for a path behind the wall that moves away; it changes nothing then
    return least - (wall.position + scheme.contact)


@answers(bounce, Euler, Rigid)
def _bounce_euler(scheme, wall, x, v, accumulators, lane, before, after):
    xn = x + scheme.step * v
    if clearance(scheme, wall, xn, xn) <= 0.0 and v < 0.0:
        add_impacts(accumulators, lane, before, 1.0, -v)
        v = rebound(wall.rule, -v, 1.0, accumulators, 0, lane, before)
    return xn, v, xn, v


@answers(extras, Pair)
def _extras_of_pair(wall):
    return 3 + takings(wall.low_rule) + takings(wall.high_rule)


@answers(clearance, Splitting, Pair)
@answers(clearance, Splitting, Soft)
def _clearance_between(scheme, wall, least, greatest):
    low, high = _reaches(scheme, wall.low, wall.high)
    below = least - low - _margin(least, least, greatest)
    return min(below, high - greatest - _margin(greatest, least, greatest))


@njit(**INLINE)
def _reaches(scheme, low, high):
    """As `_reach`, of both walls."""
    dip, nothing = _dip(scheme), typed(0.0, low)
    return low + max(nothing, -low) * dip, high - max(nothing, high) * dip


@answers(begin, Splitting, Pair)
def _begin_pair(scheme, wall, x, v, early, accumulators, lane, weight):
    x, v = _half_step_between(scheme, wall, x, v, accumulators, lane, weight)
    return min(max(x + early, wall.low), wall.high), v


@answers(bounce, Splitting, Pair)
@answers(bounce, Splitting, Soft)
def _bounce_between(scheme, wall, x, v, accumulators, lane, before, after):
    xm, vm = _half_step_between(scheme, wall, x, v, accumulators, lane, before)
    xn, vn = _half_step_between(scheme, wall, xm, vm, accumulators, lane, after)
    return xm, vm, xn, vn


@answers(in_lanes, Splitting, Pair)
def _in_lanes_pair(scheme, wall):
    return wall.near and _between(scheme, wall)


@njit(**INLINE)
def _between(scheme, wall):
    return _single(scheme, wall.low_rule) and _single(scheme, wall.high_rule)


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


@njit(**INLINE)
def _half_step_between(scheme, wall, x, v, accumulators, lane, weight):
    moved, change, _, _ = drift(scheme, x, v)
    xh, vh = x + moved, v + change
    low, high = _reaches(scheme, wall.low, wall.high)
    if min(x, xh) > low and max(x, xh) < high:
        return xh, vh
    return strike(wall, scheme, x, v, accumulators, lane, weight)


def strike(wall: Any, scheme: Any, x: Any, v: Any, accumulators: Any, lane: Any, weight: Any) -> Any:
    """Compiled code only: half a step that may reach a wall on either side."""
    raise NotImplementedError


@answers(strike, Pair)
def _strike_pair(wall, scheme, x, v, accumulators, lane, weight):
    if _between(scheme, wall):
        moved, change, _, _ = drift(scheme, x, v)
        moved, change, down, up, sure = _flight_between(scheme, wall, x, v, moved, change)
        if sure:
            if down + up > 0.0:
                add_impacts(accumulators, lane, weight, 1.0, down + up)
                if up > 0.0:
                    _add_to(accumulators, 0, lane, weight, 1.0, up)
            return x + moved, v + change
    return fly_between(wall, scheme.frequency, x, v, 0.5 * scheme.frequency * scheme.step, accumulators, lane, weight)


@answers(strike, Soft)
def _strike_soft(wall, scheme, x, v, accumulators, lane, weight):
    return _push_through(wall, scheme.frequency, x, v, 0.5 * scheme.step, accumulators, lane, weight)


@njit(**INLINE)
def _add_to(accumulators, first, lane, weight, count, speed):
    """Add impacts at one wall, whose sums are the three from number ``first`` on."""
    accumulators.extras[first * LANES + lane] += weight * count
    accumulators.extras[(first + 1) * LANES + lane] += weight * count * speed
    accumulators.extras[(first + 2) * LANES + lane] += weight * count * speed * speed


@njit(**LINKED)
def fly_between(wall, frequency, x, v, phase, accumulators, lane, weight):
    """As `fly`, between two walls.

    The phase angle of the state, atan2(-u, x), grows by the phase: the lower wall is reached at an angle above 0,
    moving down, the upper one below 0.  Against the wall that the linear spring presses on, impacts end as in `fly`.
    """
    u = v / frequency
    left = phase
    struck, arriving = 0, 0.0  # -1: at the lower wall, 1: at the upper one
    if x <= wall.low and u < 0.0:
        struck, arriving = -1, -u
    elif x >= wall.high and u > 0.0:
        struck, arriving = 1, u
    x = min(max(x, wall.low), wall.high)
    while True:
        if struck != 0:
            add_impacts(accumulators, lane, weight, 1.0, frequency * arriving)
            if struck > 0:
                _add_to(accumulators, 0, lane, weight, 1.0, frequency * arriving)
            x = wall.low if struck < 0 else wall.high
            if struck < 0:
                u = rebound(wall.low_rule, arriving, frequency, accumulators, 3, lane, weight)
            else:
                place = 3 + takings(wall.low_rule)
                u = -rebound(wall.high_rule, arriving, frequency, accumulators, place, lane, weight)
        pressed_down = wall.low > 0.0 and x == wall.low and u >= 0.0
        if pressed_down or (wall.high < 0.0 and x == wall.high and u <= 0.0):
            elastic = lossless(wall.low_rule) if pressed_down else lossless(wall.high_rule)
            hop = 2.0 * math.atan2(abs(u), abs(x))
            if elastic and hop > SHORTEST_ELASTIC_HOP * phase:
                # hops that stay clear of the other wall are counted in one go
                whole = np.floor(left / hop) if u * u + x * x < (wall.high if pressed_down else wall.low) ** 2 else 0.0
                if whole > 0.0:
                    add_impacts(accumulators, lane, weight, whole, frequency * abs(u))
                    if not pressed_down:
                        _add_to(accumulators, 0, lane, weight, whole, frequency * abs(u))
                left -= whole * hop
            elif hop < SHORTEST_HOP * phase and hop < left:
                accumulators.collapses[lane] += 1.0 if struck != 0 else 0.0
                return x, 0.0
        struck = 0
        reach = (u * u + x * x) * left * left  # square of a distance longer than the flight
        if (x - wall.low) * (x - wall.low) <= reach and not _leaves(u, -wall.low, left):
            square = u * u + (x - wall.low) * (x + wall.low)
            if square > 0.0:
                height = math.sqrt(square)
                until = math.atan2(height, wall.low) - math.atan2(-u, x)
                if until < left:
                    struck, arriving, soonest = -1, height, until
        if (x - wall.high) * (x - wall.high) <= reach and not _leaves(-u, wall.high, left):
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
    return min(max(c * x + s * u, wall.low), wall.high), frequency * (c * u - s * x)


@answers(extras, Soft)
def _extras_of_soft(wall):
    return extras(wall.rigid) + 3 + 5 * (wall.contacts.size // 5)


@answers(begin, Splitting, Soft)
def _begin_soft(scheme, wall, x, v, early, accumulators, lane, weight):
    x, v = _half_step_between(scheme, wall, x, v, accumulators, lane, weight)
    return x + early, v


def travel(
    rigid: Any, frequency: Any, x: Any, v: Any, c: Any, s: Any, accumulators: Any, lane: Any, weight: Any
) -> Any:
    """Compiled code only: flight over a phase of cosine ``c`` and sine ``s`` behind soft contacts."""
    raise NotImplementedError


@answers(travel, NoWall)
def _travel_freely(rigid, frequency, x, v, c, s, accumulators, lane, weight):
    return c * x + s / frequency * v, c * v - s * frequency * x


@answers(travel, Pair)
def _travel_between(rigid, frequency, x, v, c, s, accumulators, lane, weight):
    xn, vn = c * x + s / frequency * v, c * v - s * frequency * x
    near = 2.0 * s * s  # a short flight leaves the line between its ends by less than this part of x
    if min(x, xn) > rigid.low + near * abs(rigid.low) and max(x, xn) < rigid.high - near * abs(rigid.high):
        return xn, vn
    return fly_between(rigid, frequency, x, v, math.atan2(s, c), accumulators, lane, weight)


@njit(**LINKED)
def _push_through(wall, frequency, x, v, time, accumulators, lane, weight):
    """Half a step in ``substeps`` of exact flight, contacts, exact flight.  An impact is the first touch."""
    square, count, own = frequency * frequency, wall.contacts.size // 5, extras(wall.rigid)
    energy = v * v + square * x * x
    short = time / wall.substeps
    forces = _by_contact(0.0)
    c, s = math.cos(0.5 * frequency * short), math.sin(0.5 * frequency * short)
    for _ in range(wall.substeps):
        before, first = x, v * v + square * x * x
        x, v = travel(wall.rigid, frequency, x, v, c, s, accumulators, lane, weight)
        pushed, damped, deepest = 0.0, 0.0, 0.0
        for n in range(count):
            depth, force = _force_of_contact(wall.contacts, n, x, short)
            forces[n] = force
            pushed += wall.contacts[5 * n + 1] * force
            damped += 0.5 * force * wall.contacts[5 * n + 4]
            deepest = max(deepest, depth)
        if deepest > 0.0:
            later = (v * (1.0 - damped) + pushed) / (1.0 + damped)
            middle = 0.5 * (v + later)
            v = later
            for n in range(count):
                force = forces[n]
                place = (own + 6 + 5 * n) * LANES + lane
                viscous = force * wall.contacts[5 * n + 4] * middle
                accumulators.extras[place] += weight * viscous * middle
                accumulators.extras[place + LANES] += weight * (force - wall.contacts[5 * n + 1] * viscous)
            accumulators.extras[(own + 1) * LANES + lane] += weight * short
            if weight > 0.0:
                place = (own + 2) * LANES + lane
                accumulators.extras[place] = max(accumulators.extras[place], deepest)
        x, v = travel(wall.rigid, frequency, x, v, c, s, accumulators, lane, weight)
        last = v * v + square * x * x
        for n in range(count):
            place, away = wall.contacts[5 * n], wall.contacts[5 * n + 1]
            if away * (x - place) < 0.0 <= away * (before - place):
                # the speed there by the energy of the flight towards it, in which another contact may take part
                joint = deepest > away * (place - x)
                there = first + (last - first) * (place - before) / (x - before) if joint else first
                speed = math.sqrt(max(there - square * place * place, 0.0))
                add_impacts(accumulators, lane, weight, 1.0, speed)
                _add_to(accumulators, own + 3 + 5 * n, lane, weight, 1.0, speed)
    accumulators.extras[own * LANES + lane] += weight * 0.5 * (v * v + square * x * x - energy)
    return x, v


@njit(**INLINE)
def _force_of_contact(contacts, n, x, short):
    """Depth of contact ``n``, and the impulse of its elastic force in a short step."""
    depth = contacts[5 * n + 1] * (contacts[5 * n] - x)
    if depth <= 0.0:
        return 0.0, 0.0
    exponent = contacts[5 * n + 3]
    force = depth if exponent == 1.0 else depth * math.sqrt(depth) if exponent == 1.5 else depth**exponent
    return depth, short * contacts[5 * n + 2] * force
