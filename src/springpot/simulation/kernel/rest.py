"""Rest on walls: which rows a kick leaves at rest, how a row comes to rest, and impacts beside rows that rest.

A row rests on its wall, at its place and without velocity.  Each kick leaves it so while something presses: of all
resting rows together the walls take the impulses that are not negative and leave no row closing.  A row that opens
leaves with half of what the kick gives, because by the middle of the step it has begun to move.  Which rows rest is
kept among the states of the forces, behind them: one number for each wall, and how many of them there are.

These are scalar loops, in double precision, over the lanes that have to do with rest.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, f64, greater, stack_array
from springpot.simulation.kernel.motion import NO_SPRING, sum_of
from springpot.simulation.kernel.reading import of_lane
from springpot.simulation.kernel.striking import FIXED, POWER_LAW
from springpot.simulation.kernel.tables import (
    ALONG,
    CONSTANT,
    DAMPERS,
    HEAVY,
    HITS,
    JUMP,
    LEAN,
    LIMITS,
    OF_A_WALL,
    PLACE,
    POINTS,
    REDUCED,
    RESTITUTION,
    RESTS,
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
    STATES,
    STEP,
    WALL_AT,
    WALL_KIND,
    WALLS,
)
from springpot.simulation.kernel.vectors import call_share
from springpot.simulation.kernel.watching import show_impact

MOST_POINTS, MOST_WALLS = 8, 12
MOST_HOPS = (
    32  # impacts in half a drift, after which they are plastic; after twice as many the masses stay until its end
)
CLOSE = 1e-9  # of what a kick or an impact changes: the velocity of a row that rests
ROUNDING = 1e-14  # of a closing speed, relative to the speeds that it is the difference of

_of_walls = stack_array(MOST_WALLS)
_between = stack_array(MOST_WALLS * MOST_WALLS)
_one = stack_array(1)


@njit(**INLINE)
def flag(K, wall, lane):
    """Where it is kept whether a row rests on a wall; after all walls, how many do."""
    return (K[STATES] + wall) * LANES + lane


@njit(**INLINE)
def elongation(K, D, e, array):
    """An elongation of the coordinates of one lane, or its rate of their velocities."""
    total = 0.0
    for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
        total += D[K[ROW] + p] * array[K[K[ROW_AT] + p]]
    return total


@njit(**INLINE)
def row_of(K, D, k, array):
    """The elongation of a wall, or its rate."""
    return elongation(K, D, K[K[WALL_AT] + k], array)


@njit(**INLINE)
def count_resting(K, state, lane):
    """Count the rows that rest."""
    count = 0.0
    for k in range(K[WALLS]):
        count += f64(state[flag(K, k, lane)])
    state[flag(K, K[WALLS], lane)] = count
    return count


@njit(**INLINE)
def has_leant(K, leant, lane):
    """Whether a wall has given something to a row at rest in the last kick."""
    found = False
    for k in range(K[WALLS]):
        found = found or leant[k * LANES + lane] != 0.0
    return found


@njit(**INLINE)
def lay_down(K, D, x, v, state, lane):
    """Rows that begin at their walls without velocity rest there."""
    for k in range(K[WALLS]):
        lies = D[K[RESTS] + k] > 0.0 and row_of(K, D, k, x) == D[K[PLACE] + k] and row_of(K, D, k, v) == 0.0
        state[flag(K, k, lane)] = 1.0 if lies else 0.0
    count_resting(K, state, lane)


@njit(**LINKED)
def _solve(n, a, active, right, c):
    """a c = right in the active rows, 0 in the others: elimination, which a matrix of masses needs no pivots for."""
    m, b = _between(0.0), _of_walls(0.0)
    for k in range(n):
        b[k], c[k] = right[k], 0.0
        for i in range(n):
            m[k * n + i] = a[k * n + i]
    for k in range(n):
        if active[k] == 0.0 or not m[k * n + k] > CLOSE:  # a row that others determine
            continue
        for i in range(k + 1, n):
            share = m[i * n + k] / m[k * n + k] * active[i]
            b[i] -= share * b[k]
            for j in range(k, n):
                m[i * n + j] -= share * m[k * n + j]
    for back in range(n):
        k = n - 1 - back
        if active[k] == 0.0 or not m[k * n + k] > CLOSE:
            continue
        total = b[k]
        for j in range(k + 1, n):
            total -= m[k * n + j] * c[j] * active[j]
        c[k] = total / m[k * n + k]


@njit(**LINKED)
def _press(n, a, live, w, c, top):
    """c >= 0 with w + a c >= 0 in the live rows, in each of them one of both 0; w becomes w + a c.

    Below ``CLOSE`` of ``top`` a velocity is 0.
    """
    active, right = _of_walls(0.0), _of_walls(0.0)
    count = 0.0
    for k in range(n):
        active[k], right[k], c[k] = live[k], -w[k], 0.0
        top = greater(top, abs(w[k]) * live[k])
        count += live[k]
    if count == 1.0:  # most often
        for k in range(n):
            c[k] = greater(-w[k], 0.0)
            w[k] = w[k] if w[k] > CLOSE * top else 0.0
        return
    for _ in range(4 * n + 4):
        _solve(n, a, active, right, c)
        worst, which = 0.0, -1
        for k in range(n):
            if active[k] > 0.0 and c[k] < worst:
                worst, which = c[k], k
        if which < 0:
            worst = -CLOSE * top
            for k in range(n):
                if live[k] > active[k]:
                    rate = w[k]
                    for i in range(n):
                        rate += a[k * n + i] * c[i]
                    if rate < worst:
                        worst, which = rate, k
            if which < 0:
                break
        active[which] = 1.0 - active[which]
    for k in range(n):
        c[k] = greater(c[k], 0.0)
    for k in range(n):
        rate = w[k]
        for i in range(n):
            rate += a[k * n + i] * c[i]
        w[k] = 0.0 if active[k] > 0.0 or live[k] == 0.0 or not rate > CLOSE * top else rate


@njit(**INLINE)
def _begin(K, D, turned, v, state, lane, live, w, a):
    """Of the rows that rest: rates, and changes of rates by a unit of change of each other's."""
    n, points = K[WALLS], K[POINTS]
    for k in range(n):
        live[k] = f64(state[flag(K, k, lane)])
        w[k] = D[K[SIDE] + k] * row_of(K, D, k, v) if live[k] > 0.0 else 0.0
    for k in range(n):
        e = K[K[WALL_AT] + k]
        for i in range(n):
            total = 0.0
            if live[k] * live[i] > 0.0:
                for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
                    total += D[K[ROW] + p] * D[turned + i * points + K[K[ROW_AT] + p]]
            a[k * n + i] = D[K[SIDE] + k] * D[K[SIDE] + i] * total


@njit(**INLINE)
def _turn(K, D, turned, c, v):
    for k in range(K[WALLS]):
        if c[k] != 0.0:
            for i in range(K[POINTS]):
                v[i] += D[K[SIDE] + k] * c[k] * D[turned + k * K[POINTS] + i]


@njit(**INLINE)
def hits_of(K, k, what, lane):
    """Where a sum of wall k is of one lane."""
    return sum_of(K, HITS, OF_A_WALL * k + what) + lane


@njit(**LINKED)
def _hold_lane(K, D, T, x, v, lane, weight):
    n, walls, live, w, a = K[POINTS], K[WALLS], _of_walls(0.0), _of_walls(0.0), _between(0.0)
    c, more, state, leant, lean = _of_walls(0.0), _of_walls(0.0), T.state, T.leant, K[LEAN]
    for i in range(n):
        v[i] = T.now_v[i * LANES + lane] + f64(T.gained[i * LANES + lane])
    _begin(K, D, lean, v, state, lane, live, w, a)
    top = 0.0
    for k in range(walls):
        top = greater(top, abs(leant[k * LANES + lane]) / D[K[REDUCED] + k])
    _press(walls, a, live, w, c, top)
    opened = False
    for k in range(walls):
        opened = opened or w[k] > 0.0
        leant[k * LANES + lane] += c[k] * D[K[HEAVY] + k]
    if opened:
        right = _of_walls(0.0)
        for k in range(walls):
            right[k] = -0.5 * w[k]
        _solve(walls, a, live, right, more)
        for k in range(walls):
            c[k] += more[k]
            leant[k * LANES + lane] += more[k] * D[K[HEAVY] + k]
            if w[k] > 0.0:
                state[flag(K, k, lane)] = 0.0
        count_resting(K, state, lane)
    _turn(K, D, lean, c, v)
    for k in range(walls):
        heavy = c[k] * D[K[HEAVY] + k]
        T.sums[hits_of(K, k, 3, lane)] -= weight * 0.25 * heavy * w[k]
        T.sums[hits_of(K, k, 4, lane)] += weight * heavy
    for i in range(n):
        at = i * LANES + lane
        T.gained[at] = v[i] - T.now_v[at]
        T.v[at] = v[i]
        x[i] = T.now_x[at] + f64(T.moved[at])
    _onto_places(K, D, x, state, lane)
    for i in range(n):
        T.moved[i * LANES + lane] = x[i] - T.now_x[i * LANES + lane]


@njit(**INLINE)
def hold(K, D, T, x, v, weight, o, width):
    """After a kick: the walls take what presses on resting rows; those that nothing presses on leave.

    To ``leant``: the impulses of the walls.  The rows that rest lie exactly at their places.
    """
    for lane in range(o, o + width):
        if T.state[flag(K, K[WALLS], lane)] > 0.0:
            _hold_lane(K, of_lane(D, lane), T, x, v, lane, weight)


@njit(**INLINE)
def _onto_places(K, D, x, state, lane):
    for k in range(K[WALLS]):
        if state[flag(K, k, lane)] > 0.0:
            beside = D[K[PLACE] + k] - row_of(K, D, k, x)
            for i in range(K[POINTS]):
                x[i] += beside * D[K[JUMP] + k * K[POINTS] + i]


@njit(**LINKED)
def _come_to_rest(K, D, T, v, struck, speed, closing, lane, weight):
    """A row comes to rest from its speed, and no other resting row closes; the walls take the energy that was left.

    That of the true speed, ``closing``, which is not the one of the flight.
    """
    live, w, a, c, before = _of_walls(0.0), _of_walls(0.0), _between(0.0), _of_walls(0.0), _of_walls(0.0)
    T.state[flag(K, struck, lane)] = 1.0
    _begin(K, D, K[JUMP], v, T.state, lane, live, w, a)
    for k in range(K[WALLS]):
        before[k] = w[k]
    _press(K[WALLS], a, live, w, c, 0.0)
    _turn(K, D, K[JUMP], c, v)
    share = (closing / speed) ** 2
    for k in range(K[WALLS]):
        momentum = c[k] * D[K[REDUCED] + k]
        T.sums[hits_of(K, k, 3, lane)] -= weight * 0.5 * momentum * (before[k] + w[k]) * share
        T.sums[hits_of(K, k, 4, lane)] += weight * momentum
        if w[k] > CLOSE * speed:
            T.state[flag(K, k, lane)] = 0.0


@njit(**INLINE)
def _pushed(K, D, T, j, lane, v):
    """Put the impulses of constant forces, smooth excitation in step j and leaning walls behind the velocities."""
    for i in range(K[POINTS]):
        v[MOST_POINTS + i] = D[K[CONSTANT] + i]
    for r in range(K[SOURCES]):
        for p in range(K[K[SOURCE_BEGIN] + r], K[K[SOURCE_BEGIN] + r + 1]):
            impulse = f64(T.inputs[(GROUP * r + j) * LANES + lane])
            v[MOST_POINTS + K[K[SOURCE_AT] + p]] += D[K[SMOOTH] + r] * D[K[SOURCE_ROW] + p] * impulse
    for k in range(K[WALLS]):
        e = K[K[WALL_AT] + k]
        for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
            v[MOST_POINTS + K[K[ROW_AT] + p]] += D[K[SIDE] + k] * D[K[ROW] + p] * T.leant[k * LANES + lane]


@njit(**INLINE)
def _given_along(K, D, x, v, struck):
    """What springs and smooth forces change of a struck elongation's velocity per time, times its reduced mass."""
    given, n = 0.0, K[POINTS]
    for i in range(n):
        given += v[MOST_POINTS + i] * D[K[JUMP] + struck * n + i]
    for e in range(K[ROWS]):
        along, b = D[K[ALONG] + struck * K[ROWS] + e], K[SPRING] + 10 * e
        if K[K[SPRING_KIND] + e] == NO_SPRING or along == 0.0:
            continue
        u, force = elongation(K, D, e, x), 0.0
        for power in range(10):
            force = force * u + D[b + 9 - power]
        given -= force * along
    return given / D[K[STEP]]


@njit(**INLINE)
def count_in_lane(K, D, T, k, weight, speed, r, change, lane):
    """Add impacts of one lane to the sums of a wall: as many as their weight."""
    mass = weight * D[K[REDUCED] + k]
    T.sums[hits_of(K, k, 0, lane)] += weight
    T.sums[hits_of(K, k, 1, lane)] += weight * speed
    T.sums[hits_of(K, k, 2, lane)] += weight * speed * speed
    T.sums[hits_of(K, k, 3, lane)] += 0.5 * mass * (1.0 - r * r) * speed * speed
    T.sums[hits_of(K, k, 4, lane)] += mass * change


@njit(**INLINE)
def restitution_of(K, D, k, speed):
    """Of wall k at a speed."""
    kind, b = K[K[WALL_KIND] + k], K[RESTITUTION] + 3 * k
    if kind == FIXED:
        return D[b]
    if kind == POWER_LAW:
        return min(D[b] * (speed / D[b + 1]) ** -D[b + 2], 1.0) if speed > 0.0 else 1.0
    found = _one(0.0)
    call_share(kind, (D[b] * speed, found))
    return found[0]


@njit(**LINKED)
def _fly(K, D, T, S, x, v, left, since, lane, weight):
    """Straight flight of one lane over the time ``left`` with the earliest impact first; how many there were.

    It begins at the time ``since`` after the middle between two kicks, as
    `springpot.simulation.kernel.striking.fly` says.  A row comes to rest where something presses on its wall and its
    next hop would be shorter than a step.  One that rests stays until an impact drives or opens it.  The walls that
    lean on resting rows press, too, as what they gave in the last kick.
    """
    events, end, n, most = 0, since + left, K[POINTS], 0.0  # most: the largest change of a velocity by an impact
    step, state = D[K[STEP]], T.state
    while True:
        struck, soonest, speed, deep = -1, left, 0.0, 0.0
        for k in range(K[WALLS]):
            side = D[K[SIDE] + k]
            distance, rate = side * (row_of(K, D, k, x) - D[K[PLACE] + k]), side * row_of(K, D, k, v)
            if rate < 0.0 and distance < -rate * soonest:
                rested = state[flag(K, k, lane)] > 0.0
                if not (rested and (most == 0.0 or rate >= -CLOSE * most)):
                    struck, speed, deep = k, -rate, distance
                    soonest = distance / -rate if distance > 0.0 else 0.0
        if struck < 0:
            break
        left -= soonest
        deep -= speed * soonest  # where it lies behind the wall (by rounding, or as it began): put back onto it
        side, reduced = D[K[SIDE] + struck], D[K[REDUCED] + struck]
        for i in range(n):
            x[i] += soonest * v[i] - side * deep * D[K[JUMP] + struck * n + i]
        gain = -side * _given_along(K, D, x, v, struck) / reduced  # of closing speed per time
        can_rest, leans = False, False
        if D[K[RESTS] + struck] > 0.0:  # it does not lean on itself
            own = T.leant[struck * LANES + lane]
            gain += own / (reduced * step)
            can_rest, leans = gain > 0.0, own != 0.0 or state[flag(K, struck, lane)] > 0.0
        closing = speed + gain * (end - left)
        if can_rest:
            closing = speed if leans else greater(closing, 0.0)
        elif closing <= 0.0:
            closing = speed
        r = restitution_of(K, D, struck, closing) if events < MOST_HOPS else 0.0
        most = greater(most, greater(speed, closing + r * closing))
        shown = weight > 0.0
        if can_rest and r * closing <= 0.5 * gain * step:
            _come_to_rest(K, D, T, v, struck, speed, closing, lane, weight)
            shown = shown and closing > 0.0  # observers choose which impacts count
        else:
            change = closing + r * closing
            shown = shown and not (change <= speed and closing <= gain * step)
            if change <= speed:  # nothing still closes, nor by rounding: that would be struck again and again
                of_rate, e = 0.0, K[K[WALL_AT] + struck]
                for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
                    of_rate += abs(D[K[ROW] + p] * v[K[K[ROW_AT] + p]])
                change = speed + ROUNDING * of_rate
            for i in range(n):
                v[i] += side * change * D[K[JUMP] + struck * n + i]
            count_in_lane(K, D, T, struck, weight, closing, r, change, lane)
            for k in range(K[WALLS]):
                if state[flag(K, k, lane)] > 0.0:
                    opens = D[K[SIDE] + k] * row_of(K, D, k, v) > CLOSE * most
                    state[flag(K, k, lane)] = 0.0 if opens or k == struck else 1.0
        if shown:
            show_impact(S, struck, closing, lane)
        events += 1
        if events == MOST_HOPS:
            T.sums[sum_of(K, LIMITS, 0) + lane] += 1.0
        if events >= 2 * MOST_HOPS:
            T.sums[sum_of(K, LIMITS, 1) + lane] += 1.0
            return events
    for i in range(n):
        x[i] += left * v[i]
    _onto_places(K, D, x, state, lane)
    return events


@njit(**LINKED)
def _repair(K, D, T, S, j, x, v, lane, before, after):
    n = K[POINTS]
    rested = T.state[flag(K, K[WALLS], lane)] > 0.0 or has_leant(K, T.leant, lane)
    for i in range(n):
        at = i * LANES + lane
        x[i] = T.now_x[at] + f64(T.before[at])
        v[i] = T.now_v[at] + f64(T.gained[at])
        x[MOST_POINTS + i] = x[i]
    _pushed(K, D, T, j, lane, v)
    half = 0.5 * D[K[STEP]]
    events = _fly(K, D, T, S, x, v, half, -half, lane, before)
    for i in range(n):
        x[2 * MOST_POINTS + i], v[2 * MOST_POINTS + i] = x[i], v[i]
    events += _fly(K, D, T, S, x, v, half, 0.0, lane, after)
    if events == 0 and not rested:  # else the rounding of near misses would change the state
        return
    count_resting(K, T.state, lane)
    for i in range(n):
        at = i * LANES + lane
        T.seen[at] = x[2 * MOST_POINTS + i] - T.now_x[at]
        T.seen_v[at] = v[2 * MOST_POINTS + i]
        T.moved[at] = x[i] - T.now_x[at]
        T.gained[at] = v[i] - T.now_v[at]
        T.v[at] = v[i]
    put_in(K, D, T, j, x, v, lane)


@njit(**INLINE)
def put_in(K, D, T, j, x, v, lane):
    """The elongations of one lane after a drift, from the states before it, at the observation and after it."""
    for e in range(K[ROWS]):
        before, seen, u, w = 0.0, 0.0, 0.0, 0.0
        for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
            i, share = K[K[ROW_AT] + p], D[K[ROW] + p]
            before += share * x[MOST_POINTS + i]
            seen += share * x[2 * MOST_POINTS + i]
            u += share * x[i]
            w += share * v[i]
        at = e * LANES + lane
        T.u[at], T.w[at], T.seen_u[at] = u, w, seen
        T.d[((GROUP + 2) * e + 2 + j) * LANES + lane] = u - before


@njit(**INLINE)
def _is_clear(K, D, T, lane):
    """Whether the end of a drift lies before all walls, with a margin for rounding.

    A row that rests is clear of its own.  Nonlinear dampers act on a row that leans on a wall after the kick.
    """
    resting = T.state[flag(K, K[WALLS], lane)] > 0.0
    if K[DAMPERS] > 0 and has_leant(K, T.leant, lane):
        return False
    for k in range(K[WALLS]):
        if not (resting and T.state[flag(K, k, lane)] > 0.0):
            u, place = f64(T.u[K[K[WALL_AT] + k] * LANES + lane]), D[K[PLACE] + k]
            if not D[K[SIDE] + k] * (u - place) > 1e-6 * (abs(place) + abs(u)):
                return False
    return True


@njit(**INLINE)
def drift_beside_rest(K, D, T, S, j, x, v, before, after, o, width):
    """The drift of lanes that may have struck a wall again, where rows can rest."""
    for lane in range(o, o + width):
        if not _is_clear(K, of_lane(D, lane), T, lane):
            _repair(K, of_lane(D, lane), T, S, j, x, v, lane, before, after)


@njit(**LINKED)
def begin(K, D, T, S, start, path, x, v, lane, weight):
    """From the state at time 0 to the first kick, half a drift later."""
    n = K[POINTS]
    for i in range(n):
        x[i], v[i] = start[2 * n * path + i], start[2 * n * path + n + i]
        x[MOST_POINTS + i] = x[2 * MOST_POINTS + i] = x[i]
        v[MOST_POINTS + i] = D[K[CONSTANT] + i]
    if K[WALLS] > 0:
        lay_down(K, D, x, v, T.state, lane)
        _fly(K, D, T, S, x, v, 0.5 * D[K[STEP]], 0.0, lane, weight)
        count_resting(K, T.state, lane)
    else:
        for i in range(n):
            x[i] += 0.5 * D[K[STEP]] * v[i]
    put_in(K, D, T, -1, x, v, lane)
    for i in range(n):
        T.now_x[i * LANES + lane], T.now_v[i * LANES + lane] = x[i], v[i]
