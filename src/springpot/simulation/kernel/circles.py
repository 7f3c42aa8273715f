"""Impacts of a lone coordinate that turns on a circle: the exact flight of an oscillator, without angles.

A drift is known by its place a and its velocity m in the middle.  In t = tan(w time) / w, with the time counted from
there, it is a straight line: x = (a + m t) cos(w time).  The energy E = (m^2 + w^2 a^2) / 2, which it keeps, gives the
speed H with which it meets a wall at q, and the line gives t = N / D with N = H a + q m and D = w^2 q a - H m.  A
rebound that changes the velocity by c adds the flight that has c at the wall, again a line: a becomes
a - c N / (2 E), and m becomes m + c D / (2 E).

What can come to rest does so by the rules of `springpot.simulation.kernel.rest`; its spring presses in the flight, all
else in the kick.  Scalar code in double precision, for the few lanes that are near a wall.
"""

from __future__ import annotations

import math

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, LINKED, WIDTH, f64, greater, lowest_bit, u64
from springpot.simulation.kernel.motion import sum_of
from springpot.simulation.kernel.reading import of_lane, shared
from springpot.simulation.kernel.rest import count_in_lane, count_resting, flag, hits_of, lay_down, restitution_of
from springpot.simulation.kernel.tables import (
    DAMPERS,
    HEAVY,
    LIMITS,
    PLACE,
    REDUCED,
    RESTING,
    RESTS,
    ROUNDING,
    SIDE,
    STEP,
    TURN,
    WALLS,
)
from springpot.simulation.kernel.vectors import lanes_of, larger, load, size, some
from springpot.simulation.kernel.watching import ON_IMPACTS_COUNT, show_impact

# impacts in a drift, after which the mass stays on the wall until its end: at one wall, and between several
MOST_EVENTS, MOST_BETWEEN = 64, 4096
STILL = 1e-7  # of the speed of a turn there: with which a mass on a wall on which the spring presses lies still
TINY = 5e-5  # hops on a wall on which the spring presses, over a half step, from which on it does so, too


@njit(**INLINE)
def _near(K, F, T, j, o):
    """Where a drift may have an impact: an end or the middle is behind the wall, or it dips between them.

    With a gap the spring pulls away from the wall, and a path may go below the lower of the two ends in between: by at
    most (acceleration at the wall) (half step)^2 / 8.
    """
    found, turned, end = load(T.v, o) < load(T.v, o), F[K[TURN] + 6] * shared(F, K[STEP]), load(T.u, o)
    for k in range(K[WALLS]):
        side, place = F[K[SIDE] + k], F[K[PLACE] + k]
        gap = larger(0.0 - side * place, 0.0)
        dip = gap * turned * turned * (1.01 / 32.0) + 1e-6 * size(place)
        for u in (end - load(T.d, (2 + j) * LANES + o), load(T.seen_u, o), end):
            found = found | (side * u <= side * place + dip)
    return found


@njit(**INLINE)
def _given(K, D, T, lane, side):
    """The acceleration away from a wall that the last kick has given, spread over its step."""
    return side * f64(T.fx[lane]) / D[K[STEP]] if K[RESTING] > 0 else 0.0


@njit(**INLINE)
def _time(D, b, t):
    """The time after the middle, of the t of a line."""
    return math.atan2(D[b + 6] * t, 1.0) / D[b + 6]


@njit(**INLINE)
def _bear(K, D, T, k, since, before, after, lane):
    """The wall takes the force of the spring on a mass that stays there from a time on until the end of the drift."""
    half, along = 0.5 * D[K[STEP]], D[K[SIDE] + k] * D[K[PLACE] + k] * D[K[TURN] + 6] ** 2
    lasts = before * greater(-since, 0.0) + after * (half - greater(since, 0.0))
    T.sums[hits_of(K, k, 4, lane)] += D[K[REDUCED] + k] * along * lasts


@njit(**INLINE)
def _count_hops(K, D, T, S, k, speed, since, before, after, lane):
    """Elastic hops that are left on a wall on which the spring presses: all alike, they are counted in one go."""
    frequency, place = D[K[TURN] + 6], abs(D[K[PLACE] + k])
    hop = 2.0 * math.atan2(speed, frequency * place) / frequency
    until_middle = math.floor(greater(-since, 0.0) / hop) if hop > 0.0 else 0.0
    until_end = math.floor((0.5 * D[K[STEP]] - since) / hop) if hop > 0.0 else 0.0
    hops = before * until_middle + after * (until_end - until_middle)
    if hops > 0.0:
        count_in_lane(K, D, T, k, hops, speed, 1.0, 2.0 * speed, lane)
        if S[ON_IMPACTS_COUNT] > 0:
            show_impact(S, k, speed, lane, hops)


@njit(**INLINE)
def _held(K, D, T, x, v, lane):
    """The wall on which a mass rests or lies still at the beginning of a drift; -1 of none."""
    b, found = K[TURN], -1
    for k in range(K[WALLS]):
        side, place = D[K[SIDE] + k], D[K[PLACE] + k]
        pressed = side * place > 0.0
        if K[RESTING] > 0 and T.state[flag(K, k, lane)] > 0.0:
            if pressed or D[b + 6] ** 2 * side * place > _given(K, D, T, lane, side):
                found = k
            else:
                T.state[flag(K, k, lane)] = 0.0
                count_resting(K, T.state, lane)
        elif pressed:
            rounded = 2.0 * D[K[ROUNDING]] * abs(place)
            found = k if side * (x - place) <= rounded and abs(v) <= STILL * D[b + 6] * abs(place) else found
    return found


@njit(**LINKED)
def _turn(K, D, T, S, a, m, velocity, last, held, before, after, lane):
    """A drift, or what is left of it after ``last``, with all its impacts.

    It has a and m in its middle, and ``velocity`` now; ``held`` is the wall on which the mass is, or -1.  Returns where
    it is in the middle and at the end, the velocities there, and how many impacts there were.
    """
    b, step = K[TURN], D[K[STEP]]
    square, reach, events = D[b + 6] * D[b + 6], D[b + 1] / (1.0 + D[b]), 0
    seen, seen_v, bears, goes_on, just = a, m, True, 0.0, -1
    most = MOST_EVENTS if K[WALLS] == 1 else MOST_BETWEEN
    while held < 0:
        energy, struck, soonest, speed, up, down = m * m + square * a * a, -1, reach, 0.0, 0.0, 1.0
        for k in range(K[WALLS]):
            side = D[K[SIDE] + k]
            q, along, rate = side * D[K[PLACE] + k], side * a, side * m
            fast = energy - square * q * q
            if fast > 0.0 and (q > 0.0 or k != just):  # one that no spring presses on is not met again
                fast = math.sqrt(fast)
                over, under = fast * along + q * rate, square * q * along - fast * rate
                # below 0 it is met half a turn later; what is behind a wall by rounding meets it now
                comes = q > 0.0 or side * velocity < 0.0 or over > last * under
                if comes and under > 0.0 and over < soonest * under:
                    struck, speed, up, down = k, fast, over, under
                    soonest = greater(over / under, last)
        if struck < 0:
            break
        last, just, side = soonest, struck, D[K[SIDE] + struck]
        bent = side * D[K[PLACE] + struck] * square  # with which the spring presses on the wall
        weight, closing, press = before if last <= 0.0 else after, speed, 0.0
        if D[K[RESTS] + struck] > 0.0:
            given = _given(K, D, T, lane, side)
            press = bent - given
            closing = greater(speed - given * _time(D, b, last), 0.0) if press > 0.0 else speed
        r = restitution_of(K, D, struck, closing)
        if press > 0.0 and r * closing <= 0.5 * press * step:
            mass, held = weight * D[K[REDUCED] + struck], struck
            T.sums[hits_of(K, struck, 3, lane)] += 0.5 * mass * closing * closing
            T.sums[hits_of(K, struck, 4, lane)] += mass * speed
            T.state[flag(K, struck, lane)] = 1.0
            count_resting(K, T.state, lane)
        else:
            change = greater(closing + r * closing, speed)
            a -= side * change * up / energy
            m += side * change * down / energy
            velocity = side * (change - speed)
            if weight > 0.0:
                count_in_lane(K, D, T, struck, weight, closing, r, change, lane)
            if (bent > 0.0 and change - speed < TINY * 0.5 * step * bent) or events == most - 1:
                held, bears = struck, bent > 0.0 and r < 1.0
                if bears or bent <= 0.0:
                    T.sums[sum_of(K, LIMITS, 0) + lane] += 1.0
                else:  # elastic hops, which go on in the next drift
                    goes_on = velocity
                    _count_hops(K, D, T, S, struck, change - speed, _time(D, b, last), before, after, lane)
                if D[K[RESTS] + struck] > 0.0 and change == speed:
                    T.state[flag(K, struck, lane)] = 1.0
                    count_resting(K, T.state, lane)
        if weight > 0.0 and closing > 0.0 and S[ON_IMPACTS_COUNT] > 0:
            show_impact(S, struck, closing, lane)
        events += 1
        if last <= 0.0:
            seen, seen_v = a, m
    if held < 0:
        return seen, seen_v, a + (D[b] * a + D[b + 1] * m), m + (D[b] * m - D[b + 2] * a), events
    place = D[K[PLACE] + held]
    if bears:
        _bear(K, D, T, held, _time(D, b, last), before, after, lane)
    if last <= 0.0:
        seen, seen_v = place, goes_on
    return seen, seen_v, place, goes_on, events + 1


@njit(**LINKED)
def _turn_again(K, D, T, S, j, before, after, lane):
    """The drift of one lane that may have impacts."""
    b, behind, a, m = K[TURN], 0, T.now_x[lane] + f64(T.seen[lane]), f64(T.seen_v[lane])
    begin = from_x = a + (D[b] * a - D[b + 1] * m)
    from_v = m + (D[b] * m + D[b + 2] * a)
    for k in range(K[WALLS]):  # never from behind a wall, where rounding may have left it
        side = D[K[SIDE] + k]
        if side * from_x < side * D[K[PLACE] + k]:
            from_x, behind = D[K[PLACE] + k], 1
            a, m = from_x + (D[b] * from_x + D[b + 1] * from_v), from_v + (D[b] * from_v - D[b + 2] * from_x)
    held = _held(K, D, T, from_x, from_v, lane)
    start = -D[b + 1] / (1.0 + D[b])
    seen, seen_v, x, v, events = _turn(K, D, T, S, a, m, from_v, start, held, before, after, lane)
    if events + behind > 0:  # else the lanes beside a path would decide its last bits
        T.seen[lane], T.moved[lane], T.gained[lane] = seen - T.now_x[lane], x - T.now_x[lane], v - T.now_v[lane]
        T.seen_v[lane], T.v[lane] = seen_v, v
        _put_in(T, j, begin, seen, x, v, lane)


@njit(**INLINE)
def _put_in(T, j, begin, seen, x, v, lane):
    """The same as the elongation of its row."""
    T.u[lane], T.w[lane], T.seen_u[lane], T.d[(2 + j) * LANES + lane] = x, v, seen, x - begin


@njit(**INLINE)
def turn_with_impacts(K, D, F, T, S, j, before, after, o):
    """The drift again of all lanes that are near a wall."""
    near = _near(K, F, T, j, o)
    if some(near):
        lanes = lanes_of(near)
        while lanes != u64(0):
            lane = o + lowest_bit(lanes)
            _turn_again(K, of_lane(D, lane), T, S, j, before, after, lane)
            lanes &= lanes - u64(1)


@njit(**LINKED)
def begin_turning(K, D, T, S, x, v, weight, lane):
    """From the state at time 0 to the first kick, half a drift later."""
    if K[WALLS] > 0:
        lay_down(K, D, x, v, T.state, lane)
    T.fx[lane] = 0.0
    held = _held(K, D, T, x[0], v[0], lane)
    _seen, _v, end, speed, _events = _turn(K, D, T, S, x[0], v[0], v[0], 0.0, held, weight, weight, lane)
    T.now_x[lane], T.now_v[lane] = end, speed
    _put_in(T, -1, x[0], end, end, speed, lane)


@njit(**INLINE)
def _leaving(bent, given, moving):
    """The speed with which a mass leaves its wall; 0 where it is pressed."""
    return 0.5 * moving if moving > 0.0 and bent < given else 0.0


@njit(**LINKED)
def hold_turning(K, D, T, again, weight, o):
    """After a kick: the wall takes what presses on a mass at rest; if nothing does, it leaves with half of the kick.

    Nonlinear dampers act after the kick, too: with some, all is settled ``again``, when they have.
    """
    for lane in range(o, o + WIDTH):
        for k in range(K[WALLS] if T.state[flag(K, K[WALLS], lane)] > 0.0 else 0):
            if T.state[flag(K, k, lane)] > 0.0:
                own = of_lane(D, lane)
                side, mass, share = own[K[SIDE] + k], own[K[REDUCED] + k], own[K[HEAVY] + k] / own[K[REDUCED] + k]
                bent = own[K[TURN] + 6] ** 2 * side * own[K[PLACE] + k] * own[K[STEP]]
                moving = side * f64(T.v[lane])
                given = moving * share  # without the answer of springpots and dashpots
                if again:
                    before = side * f64(T.leaving[lane])
                    more = moving - _leaving(bent, before, before / share)  # what dampers have given after the kick
                    given, moving = before + more, before / share + more
                later = _leaving(bent, given, moving)
                T.fx[lane] = T.leaving[lane] = side * given
                T.v[lane], T.gained[lane] = side * later, side * later - T.now_v[lane]
                if again or K[DAMPERS] == 0:
                    T.sums[hits_of(K, k, 4, lane)] -= weight * mass * (later if later > 0.0 else given)
                    if bent < given:
                        T.state[flag(K, k, lane)] = 0.0
                        count_resting(K, T.state, lane)
