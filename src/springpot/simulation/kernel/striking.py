"""Impacts in all lanes of a vector at once, the earliest of each lane first.

An impact changes the velocities along the row of its wall only, by the inverse of the mass matrix: the momentum of all
masses is unchanged, and so is what the row does not see.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, WIDTH, beyond, f64
from springpot.simulation.kernel.motion import NO_SPRING, add, springs, sum_of
from springpot.simulation.kernel.reading import alike, of_lane, shared
from springpot.simulation.kernel.tables import (
    ALONG,
    CONSTANT,
    HITS,
    JUMP,
    LIMITS,
    OF_A_WALL,
    PLACE,
    POINTS,
    REDUCED,
    RESTITUTION,
    ROUNDING,
    ROW,
    ROW_AT,
    ROW_BEGIN,
    ROWS,
    SIDE,
    SMOOTH,
    SOURCE_AT,
    SOURCE_BEGIN,
    SOURCE_ROW,
    SOURCES,
    SPRING,
    SPRING_KIND,
    STEP,
    WALL_AT,
    WALL_KIND,
    WALLS,
)
from springpot.simulation.kernel.vectors import (
    call_share,
    choose,
    double,
    filled,
    larger,
    load,
    opposite,
    power,
    size,
    smaller,
    some,
    store,
)
from springpot.simulation.kernel.watching import show_impacts

MOST_EVENTS = 64  # of a lane in a drift, after which impacts are plastic; after twice as many it stays until the end
FIXED, POWER_LAW = 0, 1  # kinds of restitution; larger numbers are addresses of functions


@njit(**INLINE)
def restitution(K, F, k, speed, where, room):
    """Of wall k at the speeds of some lanes."""
    b, kind = K[RESTITUTION] + 3 * k, K[K[WALL_KIND] + k]
    if kind == FIXED:
        return filled(speed, F[b])
    if kind == POWER_LAW:
        share = F[b] * power(speed / F[b + 1], filled(speed, 0.0) - F[b + 2])
        return choose(speed > 0.0, smaller(share, 1.0), 1.0)
    store(room, 0, choose(where, double(speed), -1.0))
    for lane in range(WIDTH):
        if room[lane] >= 0.0:
            call_share(kind, (of_lane(F, lane)[b] * f64(room[lane]), beyond(room, WIDTH + lane)))
    return choose(where, filled(speed, load(room, WIDTH)), 0.0)


@njit(**INLINE)
def count_impacts(K, F, T, k, where, in_window, closing, o):
    """Add impacts of some lanes to the sums of a wall; ``in_window`` is 1 in lanes in the window, otherwise 0."""
    to = sum_of(K, HITS, OF_A_WALL * k) + o
    one = choose(where, in_window, 0.0)
    more = one * closing
    add(T.terms, to, one)
    add(T.terms, to + LANES, more)
    add(T.terms, to + 2 * LANES, more * closing)


@njit(**INLINE)
def count_taken(K, F, T, k, where, in_window, closing, r, change, o):
    """Add what a wall takes in these impacts: energy and momentum."""
    to, one = sum_of(K, HITS, OF_A_WALL * k) + o, choose(where, in_window * F[K[REDUCED] + k], 0.0)
    add(T.terms, to + 3 * LANES, 0.5 * one * (1.0 - r * r) * closing * closing)
    add(T.terms, to + 4 * LANES, one * change)


@njit(**INLINE)
def _given_along(K, F, T, k, j, o):
    """What springs and smooth forces change of the rate of wall k's elongation in a step, times its reduced mass."""
    n, m = K[POINTS], K[ROWS]
    given = filled(load(T.fx, o), 0.0)
    for i in range(n):
        given = given + F[K[CONSTANT] + i] * F[K[JUMP] + k * n + i]
    for r in range(K[SOURCES]):
        if shared(F, K[SMOOTH] + r) > 0.0:
            impulse = load(T.inputs, (GROUP * r + j) * LANES + o)
            for p in range(K[K[SOURCE_BEGIN] + r], K[K[SOURCE_BEGIN] + r + 1]):
                given = given + F[K[SOURCE_ROW] + p] * F[K[JUMP] + k * n + K[K[SOURCE_AT] + p]] * impulse
    for e in range(m):
        kind, along = K[K[SPRING_KIND] + e], K[ALONG] + k * m + e
        if kind != NO_SPRING and not (alike(F) and shared(F, along) == 0.0):
            given = given - springs(F, kind, K[SPRING] + 10 * e, load(T.fu, e * LANES + o)) * F[along]
    return given


@njit(**INLINE)
def take_off(K, T, o):
    """Begin a flight where the drift begins."""
    for i in range(K[POINTS]):
        store(T.fx, i * LANES + o, load(T.before, i * LANES + o))
        store(T.leaving, i * LANES + o, load(T.v, i * LANES + o))
    for e in range(K[ROWS]):
        store(T.fu, e * LANES + o, load(T.u0, e * LANES + o))


@njit(**INLINE)
def land(K, F, T, j, ever, o):
    """The end of a flight becomes that of the drift, in lanes where something happened.

    Else the lanes beside a path would decide its last bits.
    """
    for i in range(K[POINTS]):
        at = i * LANES + o
        store(T.moved, at, choose(ever, load(T.fx, at), load(T.moved, at)))
        v, before = load(T.v, at), load(T.leaving, at)
        add(T.gained, at, choose(ever, v - before, 0.0))
        store(T.v, at, choose(ever, v, before))
    for e in range(K[ROWS]):
        at, to = e * LANES + o, ((GROUP + 2) * e + 2 + j) * LANES + o
        now = load(T.fu, at)
        store(T.u, at, choose(ever, now, load(T.u, at)))
        store(T.d, to, choose(ever, now - load(T.u0, at), load(T.d, to)))


@njit(**INLINE)
def advance(K, T, time, o):
    """All coordinates and rows over some time, which may differ from lane to lane."""
    for i in range(K[POINTS]):
        add(T.fx, i * LANES + o, time * load(T.v, i * LANES + o))
    for e in range(K[ROWS]):
        add(T.fu, e * LANES + o, time * load(T.w, e * LANES + o))


@njit(**INLINE)
def push_all(K, F, T, jump, along, change, o):
    """Change the velocities along one row; ``jump`` and ``along`` are where its numbers begin."""
    for i in range(K[POINTS]):
        add(T.v, i * LANES + o, F[jump + i] * change)
    for e in range(K[ROWS]):
        add(T.w, e * LANES + o, F[along + e] * change)


@njit(**LINKED)
def fly(K, F, T, S, j, begin, span, in_window, after_middle, o):
    """Straight flight of all lanes over a part of a drift with its impacts; in which lanes there were some.

    It begins at the time ``begin`` after the kick.  Before the middle between two kicks the last one has given the
    masses more of the impulse of springs and smooth forces than they have by then, after it less: an impact takes the
    velocity without this, else each changes the energy at random, which heats a motion with little damping.  An impact
    after which the masses would not part in spite of the restitution, no faster than what presses on them makes them
    within a step, is their rest on each other: the sums have it, observers do not see it.
    """
    step, n, m = shared(F, K[STEP]), K[POINTS], K[ROWS]
    left = filled(load(T.fx, o), span)
    ever = left < 0.0
    hit, late = ever, left
    for event in range(2 * MOST_EVENTS):
        soonest, speed, struck = left, filled(left, 0.0), filled(left, -1.0)
        for k in range(K[WALLS]):
            at, side = K[K[WALL_AT] + k] * LANES + o, F[K[SIDE] + k]
            distance, rate = side * (load(T.fu, at) - F[K[PLACE] + k]), 0.0 - side * load(T.w, at)
            until = larger(distance / rate, 0.0)
            first = (rate > 0.0) & (distance < rate * soonest) & ((until < soonest) | (struck < 0.0))
            soonest, speed = choose(first, until, soonest), choose(first, rate, speed)
            struck = choose(first, filled(struck, k), struck)
        hit = struck >= 0.0
        if not some(hit):
            break
        if event == MOST_EVENTS:
            add(T.sums, sum_of(K, LIMITS, 0) + o, choose(hit, filled(double(left), 1.0), 0.0))
        ever = ever | hit
        soonest = choose(hit, soonest, 0.0)
        left = left - soonest
        late = (begin + span) - left - 0.5 * step  # after the middle between two kicks
        advance(K, T, soonest, o)
        weight = choose(late <= 0.0, filled(late, in_window), after_middle)
        for k in range(K[WALLS]):
            here = struck == filled(struck, k)
            if not some(here):
                continue
            e, side, reduced = K[K[WALL_AT] + k], F[K[SIDE] + k], F[K[REDUCED] + k]
            gain = 0.0 - side * _given_along(K, F, T, k, j, o) / (reduced * step)  # of closing speed per time
            closing = speed + gain * late
            closing = choose(closing > 0.0, closing, speed)
            r = restitution(K, F, k, closing, here, T.own)
            if event >= MOST_EVENTS:
                r = filled(r, 0.0)
            change = closing + r * closing
            rests = (change <= speed) & (closing <= gain * step)
            rate = filled(closing, 0.0)  # nothing still closes, nor by rounding: that would be struck again and again
            for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
                rate = rate + size(F[K[ROW] + p] * load(T.v, K[K[ROW_AT] + p] * LANES + o))
            change = larger(change, speed + shared(F, K[ROUNDING]) * rate)
            count_impacts(K, F, T, k, here, weight, closing, o)
            count_taken(K, F, T, k, here, weight, closing, r, change, o)
            show_impacts(S, k, here & (weight > 0.0) & opposite(rests), closing, o, T.own)
            off = choose(here, F[K[PLACE] + k] - load(T.fu, e * LANES + o), 0.0)  # rounding, or as it began
            for i in range(n):
                add(T.fx, i * LANES + o, F[K[JUMP] + k * n + i] * off)
            for r_ in range(m):
                add(T.fu, r_ * LANES + o, F[K[ALONG] + k * m + r_] * off)
            push_all(K, F, T, K[JUMP] + k * n, K[ALONG] + k * m, choose(here, side * change, 0.0), o)
        seen = hit & (late <= 0.0)
        for i in range(n):
            at = i * LANES + o
            v = load(T.v, at)
            store(T.seen, at, choose(seen, load(T.fx, at) - late * v, load(T.seen, at)))
            store(T.seen_v, at, choose(seen, v, load(T.seen_v, at)))
        for e in range(m):
            at = e * LANES + o
            store(T.seen_u, at, choose(seen, load(T.fu, at) - late * load(T.w, at), load(T.seen_u, at)))
    if some(hit):  # lanes without an end stay where they are
        add(T.sums, sum_of(K, LIMITS, 1) + o, choose(hit, filled(double(left), 1.0), 0.0))
        left = choose(hit, 0.0, left)
        there = hit & (late <= 0.0)  # in the middle, too
        for i in range(n):
            at = i * LANES + o
            store(T.seen, at, choose(there, load(T.fx, at), load(T.seen, at)))
        for e in range(m):
            at = e * LANES + o
            store(T.seen_u, at, choose(there, load(T.fu, at), load(T.seen_u, at)))
    advance(K, T, left, o)
    return ever


@njit(**INLINE)
def is_behind(K, F, T, o):
    """Whether the end of a straight drift lies behind a wall in some lane."""
    behind = load(T.v, o) < load(T.v, o)
    for k in range(K[WALLS]):
        side = F[K[SIDE] + k]
        behind = behind | (side * load(T.u, K[K[WALL_AT] + k] * LANES + o) < side * F[K[PLACE] + k])
    return some(behind)


@njit(**LINKED)
def bounce(K, F, T, S, in_window, o):
    """As the paper prints it: the velocity is reversed where x is at the wall or beyond it and moves towards it."""
    for k in range(K[WALLS]):
        e, side = K[K[WALL_AT] + k], F[K[SIDE] + k]
        speed = 0.0 - side * load(T.w, e * LANES + o)
        here = (side * (load(T.u, e * LANES + o) - F[K[PLACE] + k]) <= 0.0) & (speed > 0.0)
        if some(here):
            r = restitution(K, F, k, speed, here, T.own)
            change = speed + r * speed
            weight = filled(speed, in_window)
            count_impacts(K, F, T, k, here, weight, speed, o)
            count_taken(K, F, T, k, here, weight, speed, r, change, o)
            show_impacts(S, k, here & (weight > 0.0), speed, o, T.own)
            change = choose(here, side * change, 0.0)
            push_all(K, F, T, K[JUMP] + k * K[POINTS], K[ALONG] + k * K[ROWS], change, o)
            for i in range(K[POINTS]):
                more = F[K[JUMP] + k * K[POINTS] + i] * change
                add(T.gained, i * LANES + o, more)
                store(T.seen_v, i * LANES + o, load(T.v, i * LANES + o))
