"""Impacts of a coordinate that turns on a circle of its own: the exact flight of an oscillator, without angles.

The flight over less than a quarter of a cycle needs only its start and the end that it has without a wall.  Let this
end at X, V.  The energy, which it keeps, gives the speed H at the wall, and with this the cosine and the sine of the
phase that is left there; the rebound adds a flight from the wall's place with velocity (1 + r) H.  After an impact both
the start and the end without a further one are known again, so second and third impacts are found in the same way.
"""

from __future__ import annotations

import math

from numba import njit

from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, WIDTH, f64
from springpot.simulation.kernel.motion import TURN_NUMBERS, add, carry, stretch, sum_of
from springpot.simulation.kernel.striking import FIXED, MOST_EVENTS, count_impacts, count_taken, restitution
from springpot.simulation.kernel.tables import (
    LIMITS,
    PLACE,
    POINTS,
    RESTITUTION,
    ROUNDING,
    ROW_AT,
    ROW_BEGIN,
    ROWS,
    SIDE,
    STEP,
    TURN,
    WALL_AT,
    WALL_KIND,
    WALLS,
)
from springpot.simulation.kernel.vectors import (
    choose,
    double,
    filled,
    larger,
    like,
    load,
    opposite,
    root,
    size,
    some,
    store,
)
from springpot.simulation.kernel.watching import ON_IMPACTS_COUNT, show_impact, show_impacts

TINY = 5e-5  # hops of a chattering sequence, over a half step, from which on the mass stays on the wall until its end


@njit(**INLINE)
def _point(K, k):
    """The coordinate of a wall."""
    return K[K[ROW_AT] + K[K[ROW_BEGIN] + K[K[WALL_AT] + k]]]


@njit(**INLINE)
def is_near(K, F, T, o):
    """Whether a half step may have an impact in some lane: an end is behind the wall, or it dips between both ends.

    With a gap the spring pulls away from the wall, and a path may go below the lower of the two ends in between: by at
    most (acceleration at the wall) (half step)^2 / 8.
    """
    found = load(T.v, o) < load(T.v, o)
    for k in range(K[WALLS]):
        at, side, b = K[K[WALL_AT] + k] * LANES + o, F[K[SIDE] + k], K[TURN] + TURN_NUMBERS * _point(K, k)
        place = F[K[PLACE] + k]
        p, turned = side * (place - F[b + 7]), F[b + 6] * F[K[STEP]]
        dip = abs(p) * (turned * turned * (1.01 / 32.0) if p < 0.0 else 0.0) + 1e-6 * abs(place)
        for u in (load(T.u0, at), load(T.seen_u, at), load(T.u, at)):
            found = found | (side * u <= side * place + dip)
    return some(found)


@njit(**INLINE)
def _may_strike(K, F, k, b, x, v, moved, change):
    """Where a flight ends behind wall k, or may have turned round behind it, as it can with a gap."""
    side = F[K[SIDE] + k]
    p, found = side * (F[K[PLACE] + k] - F[b + 7]), side * (x + moved) < side * (F[K[PLACE] + k] - F[b + 7])
    if p < 0.0:
        found = found | ((side * v < 0.0) & (side * (v + change) > 0.0))
    return found


@njit(**INLINE)
def _flight(K, F, T, k, b, x, v, moved, change, where):
    """Of a flight with the changes ``moved`` and ``change`` without a wall: those with wall k, and where it is struck.

    x is measured from the centre of the circle.  Returns the speed and the restitution of the impact, too.
    """
    frequency, side = F[b + 6], F[K[SIDE] + k]
    p, start, leaving = side * (F[K[PLACE] + k] - F[b + 7]), side * x, side * v
    x1, v1 = start + side * moved, leaving + side * change
    square = frequency * frequency
    total = leaving * leaving + square * (start * start)
    at_wall = leaving * leaving + square * ((start - p) * (start + p))
    struck = where & (at_wall > 0.0)
    speed = root(larger(at_wall, 0.0))
    r = restitution(K, F, k, speed, struck, T.own)
    share = (1.0 + r) * speed / total
    x2 = x1 - share * (speed * x1 + p * v1)
    v2 = v1 + share * (square * p * x1 - speed * v1)
    return side * (x2 - start), side * (v2 - leaving), struck, speed, r


@njit(**INLINE)
def _count_limit(K, T, where, o):
    add(T.sums, sum_of(K, LIMITS, 0) + o, choose(where, filled(double(load(T.v, o)), 1.0), 0.0))


@njit(**LINKED)
def _count_hops(K, F, T, S, k, place, frequency, speed, x, v, where, weight, o):
    """Elastic hops that are left on a wall against which the spring presses: all alike, they are counted in one go.

    The mass leaves the wall at ``place`` with ``speed``; x and v are where it would be at the end without the wall.
    """
    turned = (speed * x - place * v) / frequency  # by this angle about the centre, sine and cosine of which are these
    store(T.own, 0, choose(where, double(turned), -1.0))
    store(T.own, WIDTH, double(place * x + speed * v / (frequency * frequency)))
    store(T.own, 2 * WIDTH, double(speed))
    for lane in range(WIDTH):
        left, fast, hops = f64(T.own[lane]), f64(T.own[2 * WIDTH + lane]), 0.0
        if left > 0.0 and fast > 0.0:
            hop = 2.0 * math.atan2(fast, f64(frequency) * f64(place))
            hops = math.floor(math.atan2(left, f64(T.own[WIDTH + lane])) / hop)
        if hops > 0.0 and weight > 0.0 and S[ON_IMPACTS_COUNT] > 0:
            show_impact(S, k, fast, o + lane, hops)
        T.own[lane] = hops
    count_impacts(K, F, T, k, where, filled(speed, weight) * filled(speed, load(T.own, 0)), speed, o)


@njit(**INLINE)
def _half_turn(K, F, T, S, i, b, x, v, weight, o):
    """Half a step of coordinate i with all impacts at its walls, one after another; changes of x and v, and where.

    Of two walls that both seem to be struck, in less than a quarter of a cycle, the one towards which it moves comes
    first.
    """
    from_x, from_v, lies = x, v, x < x
    for k in range(K[WALLS]):  # never from behind a wall, where rounding may have left it
        if _point(K, k) == i:
            p, side = F[K[PLACE] + k] - F[b + 7], F[K[SIDE] + k]
            from_x = choose(side * from_x < side * p, p, from_x)
            if side * p > 0.0:  # one that lies still on a wall against which its spring presses stays there
                rounded = F[K[ROUNDING]] * (abs(p) + abs(F[K[PLACE] + k]))
                here = (side * from_x <= side * p + rounded) & (size(v) <= F[b + 6] * rounded)
                lies, from_x = lies | here, choose(here, p, from_x)
    moved = choose(lies, 0.0, F[b] * from_x + F[b + 1] * v)
    change = choose(lies, 0.0 - v, F[b] * v - F[b + 2] * from_x)
    goes_on = (x == x) & opposite(lies)  # lanes that may have another impact
    ever = lies
    hit = goes_on
    for _ in range(MOST_EVENTS):
        hit, rests = x < x, x < x
        new_x, new_v, at_x, at_v = from_x, from_v, from_x, from_v
        which, fast, left_over = filled(x, -1.0), filled(x, 0.0), filled(x, 0.0)
        for k in range(K[WALLS]):
            if _point(K, k) == i:
                where = goes_on & _may_strike(K, F, k, b, from_x, from_v, moved, change)
                if not some(where):
                    continue
                m2, c2, struck, speed, r = _flight(K, F, T, k, b, from_x, from_v, moved, change, where)
                side, place = F[K[SIDE] + k], F[K[PLACE] + k] - F[b + 7]
                mine = struck & (opposite(hit) | (side * from_v < 0.0))
                new_x, new_v = choose(mine, from_x + m2, new_x), choose(mine, from_v + c2, new_v)
                at_x, at_v = choose(mine, filled(x, place), at_x), choose(mine, side * r * speed, at_v)
                which, fast, left_over = (
                    choose(mine, filled(x, k), which),
                    choose(mine, speed, fast),
                    choose(mine, r, left_over),
                )
                hit = hit | mine
                # lossy hops on a wall against which it is pressed
                hop = TINY * 0.5 * F[K[STEP]] * F[b + 6] * F[b + 6] * side * place
                rests = rests | (mine & (r * speed < hop) & (r < 1.0))
        if not some(hit):
            break
        for k in range(K[WALLS] if weight > 0.0 else 0):
            if _point(K, k) == i:
                here = which == filled(x, k)
                count_impacts(K, F, T, k, here, filled(x, weight), fast, o)
                if K[K[WALL_KIND] + k] != FIXED:
                    count_taken(K, F, T, k, here, filled(x, weight), fast, left_over, fast + left_over * fast, o)
                show_impacts(S, k, here, fast, o, T.own)
        ever = ever | hit
        moved, change = choose(hit, new_x - at_x, moved), choose(hit, new_v - at_v, change)
        from_x, from_v = choose(hit, at_x, from_x), choose(hit, at_v, from_v)
        moved, change = choose(rests, 0.0, moved), choose(rests, 0.0 - from_v, change)
        if some(rests):
            _count_limit(K, T, rests, o)
        goes_on = hit & opposite(rests)
    if some(hit & goes_on):  # tiny hops on a wall against which it is pressed: it stays there
        for k in range(K[WALLS]):
            if _point(K, k) == i:
                p, side = F[K[PLACE] + k] - F[b + 7], F[K[SIDE] + k]
                behind = goes_on & (side * (from_x + moved) < side * p)
                if K[K[WALL_KIND] + k] == FIXED and F[K[RESTITUTION] + 3 * k] == 1.0 and side * p > 0.0:
                    x1, v1 = side * (from_x + moved), side * (from_v + change)
                    _count_hops(K, F, T, S, k, side * p, F[b + 6], side * from_v, x1, v1, behind, weight, o)
                else:
                    _count_limit(K, T, behind, o)
                moved, change = choose(behind, p - from_x, moved), choose(behind, 0.0, change)
    return from_x + moved - x, from_v + change - v, ever


@njit(**INLINE)
def turn_with_impacts(K, F, T, S, j, within, beyond_it, o):
    """The drift of coordinates that turn again, with impacts; each wall's row has one coordinate."""
    for i in range(K[POINTS]):
        b, at = K[TURN] + TURN_NUMBERS * i, i * LANES + o
        start = load(T.before, at)
        x, v = load(T.x0, at) + start - F[b + 7], load(T.leaving, at)
        way, gain, ever = filled(x, 0.0), filled(x, 0.0), x < x
        for half in range(2):
            xm, vm, struck = _half_turn(K, F, T, S, i, b, x + way, v + gain, within if half == 0 else beyond_it, o)
            way, gain, ever = way + xm, gain + vm, ever | struck
            if half == 0:
                store(T.fx, at, start + way)
                store(T.fx, (K[POINTS] + i) * LANES + o, v + gain)
        store(T.seen, at, choose(ever, load(T.fx, at), load(T.seen, at)))
        store(T.seen_v, at, choose(ever, load(T.fx, (K[POINTS] + i) * LANES + o), load(T.seen_v, at)))
        store(T.moved, at, choose(ever, start + way, load(T.moved, at)))
        old = load(T.v, at)
        new = v + gain
        add(T.gained, at, choose(ever, new - old, 0.0))
        store(T.v, at, choose(ever, new, old))
    carry(K, F, T, j, o)


@njit(**LINKED)
def begin_turning(K, F, T, S, weight, o):
    """From the state at time 0, which ``now_x`` and ``now_v`` have, to the first kick, half a drift later."""
    for i in range(K[POINTS]):
        b, at = K[TURN] + TURN_NUMBERS * i, i * LANES + o
        x, v = like(T.v, load(T.now_x, at)), like(T.v, load(T.now_v, at))
        moved, change, _ever = _half_turn(K, F, T, S, i, b, x - F[b + 7], v, weight, o)
        store(T.impulse, at, moved)
        add(T.now_x, at, double(moved))
        add(T.now_v, at, double(change))
    for e in range(K[ROWS]):
        store(T.d, ((GROUP + 2) * e + 1) * LANES + o, stretch(K, F, e, T.impulse, o))
