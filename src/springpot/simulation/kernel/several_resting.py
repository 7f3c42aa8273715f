"""Impacts between several masses of which some rows can rest.

A kernel of its own beside that of impacts alone, which most systems have and which this would slow down by a fifth.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, LINKED, f64, greater
from springpot.simulation.kernel.several_impacts import (
    MOST_EVENTS,
    MOST_POINTS,
    given_along,
    pushed,
    put_in,
    restitution_of,
    strike,
)
from springpot.simulation.kernel.several_rest import CLOSE, come_to_rest, count_resting, flag, has_leant, row_of
from springpot.simulation.kernel.watching import show_impact


@njit(**LINKED)
def fly_or_rest(size, q, x, v, left, since, hits, limits, lane, weight, observers, state, leant):
    """As `springpot.simulation.kernel.several_impacts.fly`, where some rows can rest.

    A row comes to rest where something presses on its wall and its next hop would be shorter than a step.  One that
    rests stays until an impact drives or opens it.  The walls that lean on resting rows press, too, as what they gave
    in the last kick.
    """
    events, end, n, most = 0, since + left, size.points, 0.0  # the largest change of a velocity by an impact
    while True:
        struck, soonest, speed, deep = -1, left, 0.0, 0.0
        for w in range(size.walls):
            e = q.wall_at[w]
            distance, rate = -q.place[w], 0.0
            for p in range(q.row_begin[e], q.row_begin[e + 1]):
                distance += q.row[p] * x[q.row_at[p]]
                rate += q.row[p] * v[q.row_at[p]]
            distance, rate = distance * q.side[w], rate * q.side[w]
            if rate < 0.0 and distance < -rate * soonest and not _stays(size, w, rate, most, state, lane):
                struck, speed, deep = w, -rate, distance
                soonest = distance / -rate if distance > 0.0 else 0.0
        if struck < 0:
            break
        left -= soonest
        deep -= speed * soonest  # where it lies behind the wall (by rounding, or as it began): put back onto it
        for i in range(n):
            x[i] += soonest * v[i] - q.side[struck] * deep * q.jump[struck * n + i]
        gain = -q.side[struck] * given_along(size, q, x, v, struck) / q.reduced[struck]  # of closing speed per time
        can_rest, leans = False, False
        if q.rests[struck] > 0.0:  # it does not lean on itself
            own = leant[struck * LANES + lane]
            gain += own / (q.reduced[struck] * q.step)
            can_rest, leans = gain > 0.0, own != 0.0 or state[flag(size, struck, lane)] > 0.0
        closing = speed + gain * (end - left)
        if can_rest:
            closing = speed if leans else greater(closing, 0.0)
        elif closing <= 0.0:
            closing = speed
        r = restitution_of(q, struck, closing) if events < MOST_EVENTS else 0.0
        most = greater(most, greater(speed, closing + r * closing))
        if can_rest and r * closing <= 0.5 * gain * q.step:
            come_to_rest(size, q, v, struck, speed, closing, hits, state, lane, weight)
            if weight > 0.0 and closing > 0.0:  # observers choose which impacts count
                show_impact(observers, struck, weight, closing, lane)
            events += 1
            if events >= 2 * MOST_EVENTS:
                limits[LANES + lane] += 1.0
                return events
            continue
        strike(size, q, v, struck, speed, closing, r, gain, hits, lane, weight, observers)
        for w in range(size.walls):
            if state[flag(size, w, lane)] > 0.0:
                opens = q.side[w] * row_of(q, w, v) > CLOSE * most
                state[flag(size, w, lane)] = 0.0 if opens or w == struck else 1.0
        events += 1
        if events == MOST_EVENTS:
            limits[lane] += 1.0
        if events >= 2 * MOST_EVENTS:
            limits[LANES + lane] += 1.0
            return events
    for i in range(n):
        x[i] += left * v[i]
    for w in range(size.walls):
        if state[flag(size, w, lane)] > 0.0:  # exactly onto its place
            beside = q.place[w] - row_of(q, w, x)
            for i in range(n):
                x[i] += beside * q.jump[w * n + i]
    return events


@njit(**INLINE)
def _stays(size, w, rate, most, state, lane):
    """Whether a row rests, and no impact has made it close."""
    return state[flag(size, w, lane)] > 0.0 and (most == 0.0 or rate >= -CLOSE * most)


@njit(**LINKED)
def repair_or_rest(
    size, q, now_x, now_v, s, d, j, given, hits, limits, x, v, lane, before, after, observers, state, leant
):
    """As `springpot.simulation.kernel.several_impacts.repair`; where a row rests, all is written."""
    n = size.points
    rested = state[flag(size, size.walls, lane)] > 0.0 or has_leant(size, leant, lane)
    for i in range(n):
        x[i] = now_x[i * LANES + lane] + f64(s.before[i * LANES + lane])
        v[i] = now_v[i * LANES + lane] + f64(s.gained[i * LANES + lane])
        x[MOST_POINTS + i] = x[i]
    pushed(size, q, given, j, lane, v)
    for w in range(size.walls):
        for p in range(q.row_begin[q.wall_at[w]], q.row_begin[q.wall_at[w] + 1]):
            v[2 * MOST_POINTS + q.row_at[p]] += q.side[w] * q.row[p] * leant[w * LANES + lane]
    events = fly_or_rest(
        size, q, x, v, 0.5 * q.step, -0.5 * q.step, hits, limits, lane, before, observers, state, leant
    )
    for i in range(n):
        x[2 * MOST_POINTS + i], v[MOST_POINTS + i] = x[i], v[i]
    events += fly_or_rest(size, q, x, v, 0.5 * q.step, 0.0, hits, limits, lane, after, observers, state, leant)
    if events == 0 and not rested:
        return 0
    count_resting(size, state, lane)
    for i in range(n):
        at = i * LANES + lane
        s.seen[at] = x[2 * MOST_POINTS + i] - now_x[at]
        s.seen_v[at] = v[MOST_POINTS + i]
        s.moved[at] = x[i] - now_x[at]
        s.gained[at] = v[i] - now_v[at]
        s.v[at] = v[i]
    put_in(size, q, s, d, j, x, v, lane)
    return events
