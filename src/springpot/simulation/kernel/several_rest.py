"""Rest of several masses on walls and on each other: which rows a kick leaves at rest, and how a row comes to rest.

A row rests on its wall, at its place and without velocity.  Each kick leaves it so while something presses: of all
resting rows together the walls take the impulses that are not negative and leave no row closing.  A row that opens
leaves with half of what the kick gives, because by the middle of the step it has begun to move.  Which rows rest is
kept among the states of the forces, behind them: one number for each wall, and how many of them there are.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, LINKED, f64, greater, stack_array

MOST_WALLS = 12
HITS = 5  # sums of a wall: impacts, speeds, their squares, energy taken, momentum; beyond all, peaks of contacts
CLOSE = 1e-9  # of what a kick or an impact changes: the velocity of a row that rests

_of_walls = stack_array(MOST_WALLS)
_between = stack_array(MOST_WALLS * MOST_WALLS)


@njit(**INLINE)
def flag(size, wall, lane):
    """Where it is kept whether a row rests on a wall; after all walls, how many do."""
    return (size.states + wall) * LANES + lane


@njit(**INLINE)
def row_of(q, w, array):
    """The elongation of a wall, or its rate."""
    total, e = 0.0, q.wall_at[w]
    for p in range(q.row_begin[e], q.row_begin[e + 1]):
        total += q.row[p] * array[q.row_at[p]]
    return total


@njit(**INLINE)
def count_resting(size, state, lane):
    """Count the rows that rest."""
    count = 0.0
    for w in range(size.walls):
        count += f64(state[flag(size, w, lane)])
    state[flag(size, size.walls, lane)] = count
    return count


@njit(**INLINE)
def has_leant(size, leant, lane):
    """Whether a wall has given something to a row at rest in the last kick."""
    found = False
    for w in range(size.walls):
        found = found or leant[w * LANES + lane] != 0.0
    return found


@njit(**INLINE)
def lay_down(size, q, x, v, state, lane):
    """Rows that begin at their walls without velocity rest there."""
    for w in range(size.walls):
        lies = q.rests[w] > 0.0 and row_of(q, w, x) == q.place[w] and row_of(q, w, v) == 0.0
        state[flag(size, w, lane)] = 1.0 if lies else 0.0
    count_resting(size, state, lane)


@njit(**LINKED)
def _solve(size, a, active, right, c):
    """a c = right in the active rows, 0 in the others: elimination, which a matrix of masses needs no pivots for."""
    n, m, b = size.walls, _between(0.0), _of_walls(0.0)
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
def _press(size, a, live, w, c, top):
    """c >= 0 with w + a c >= 0 in the live rows, in each of them one of both 0; w becomes w + a c.

    Below ``CLOSE`` of ``top`` a velocity is 0.
    """
    n, active, right = size.walls, _of_walls(0.0), _of_walls(0.0)
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
        _solve(size, a, active, right, c)
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
def _begin(size, q, turned, v, state, lane, live, w, a):
    """Of the rows that rest: rates, and changes of rates by a unit of change of each other's."""
    n = size.walls
    for k in range(n):
        live[k] = f64(state[flag(size, k, lane)])
        w[k] = q.side[k] * row_of(q, k, v) if live[k] > 0.0 else 0.0
    for k in range(n):
        e = q.wall_at[k]
        for i in range(n):
            total = 0.0
            if live[k] * live[i] > 0.0:
                for p in range(q.row_begin[e], q.row_begin[e + 1]):
                    total += q.row[p] * turned[i * size.points + q.row_at[p]]
            a[k * n + i] = q.side[k] * q.side[i] * total


@njit(**INLINE)
def _turn(size, q, turned, c, v):
    for k in range(size.walls):
        if c[k] != 0.0:
            for i in range(size.points):
                v[i] += q.side[k] * c[k] * turned[k * size.points + i]


@njit(**LINKED)
def hold(size, q, now_x, now_v, s, hits, state, leant, x, v, lane, weight):
    """After a kick: the walls take what presses on resting rows; those that nothing presses on leave.

    To ``leant``: the impulses of the walls.  The drift after it has the rows that rest exactly at their places.
    """
    n, live, w, a, c, more = size.points, _of_walls(0.0), _of_walls(0.0), _between(0.0), _of_walls(0.0), _of_walls(0.0)
    for i in range(n):
        v[i] = now_v[i * LANES + lane] + f64(s.gained[i * LANES + lane])
    _begin(size, q, q.lean, v, state, lane, live, w, a)
    top = 0.0
    for k in range(size.walls):
        top = greater(top, abs(leant[k * LANES + lane]) / q.reduced[k])
    _press(size, a, live, w, c, top)
    opened = False
    for k in range(size.walls):
        opened = opened or w[k] > 0.0
        leant[k * LANES + lane] += c[k] * q.heavy[k]
    if opened:
        right = _of_walls(0.0)
        for k in range(size.walls):
            right[k] = -0.5 * w[k]
        _solve(size, a, live, right, more)
        for k in range(size.walls):
            c[k] += more[k]
            leant[k * LANES + lane] += more[k] * q.heavy[k]
            if w[k] > 0.0:
                state[flag(size, k, lane)] = 0.0
        count_resting(size, state, lane)
    _turn(size, q, q.lean, c, v)
    for k in range(size.walls):
        at = HITS * k * LANES + lane
        hits[at + 3 * LANES] -= weight * 0.25 * c[k] * q.heavy[k] * w[k]
        hits[at + 4 * LANES] += weight * c[k] * q.heavy[k]
    for i in range(n):
        at = i * LANES + lane
        s.gained[at] = v[i] - now_v[at]
        s.v[at] = v[i]
        x[i] = now_x[at] + f64(s.before[at])
    for k in range(size.walls):
        if state[flag(size, k, lane)] > 0.0:
            beside = q.place[k] - row_of(q, k, x)
            for i in range(n):
                x[i] += beside * q.jump[k * n + i]
    for i in range(n):
        at = i * LANES + lane
        s.seen[at] = x[i] - now_x[at] + 0.5 * q.step * v[i]
        s.moved[at] = x[i] - now_x[at] + q.step * v[i]


@njit(**LINKED)
def come_to_rest(size, q, v, struck, speed, closing, hits, state, lane, weight):
    """A row comes to rest from its speed, and no other resting row closes; the walls take the energy that was left.

    That of the true speed, ``closing``, which is not the one of the flight.
    """
    live, w, a, c, before = _of_walls(0.0), _of_walls(0.0), _between(0.0), _of_walls(0.0), _of_walls(0.0)
    state[flag(size, struck, lane)] = 1.0
    _begin(size, q, q.jump, v, state, lane, live, w, a)
    for k in range(size.walls):
        before[k] = w[k]
    _press(size, a, live, w, c, 0.0)
    _turn(size, q, q.jump, c, v)
    share = (closing / speed) ** 2
    for k in range(size.walls):
        at, momentum = HITS * k * LANES + lane, c[k] * q.reduced[k]
        hits[at + 3 * LANES] -= weight * 0.5 * momentum * (before[k] + w[k]) * share
        hits[at + 4 * LANES] += weight * momentum
        if w[k] > CLOSE * speed:
            state[flag(size, k, lane)] = 0.0
