"""Impacts between several masses: straight flight with the earliest impact first, and the repair of a drift.

An impact changes the velocities along the row of its wall only, by the inverse of the mass matrix: the momentum of all
masses is unchanged, and so is what the row does not see.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import njit

from springpot.simulation.kernel.forces import Cubic, Nonic, cubic, nonic
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, f64
from springpot.simulation.kernel.restitution import Power, share_left
from springpot.simulation.kernel.several_laws import share_by
from springpot.simulation.kernel.several_rest import HITS
from springpot.simulation.kernel.soft_contacts import force_of_contact
from springpot.simulation.kernel.watching import show_impact

MOST_POINTS = 8  # coordinates
MOST_EVENTS = 32  # in half a drift, after which impacts are plastic; after twice as many the masses stay until its end
ROUNDING = 1e-14  # of a closing speed, relative to the speeds that it is the difference of
CUBIC, NINTH = 1, 2  # kinds of springs; 0 is none
FIXED, POWER, RULE = 0, 1, 2  # kinds of restitution; from RULE on the user's, in the order of the chain


class Size(NamedTuple):
    """How many there are; numbers at run time, so that one compilation serves all."""

    points: int  # coordinates
    rows: int  # elongations
    gauged: int  # the first of them, whose mean and mean square are summed
    shown: int  # the first of these, whose velocity's mean square is summed too: points that are no coordinates
    walls: int
    noises: int  # white
    sources: int  # other excitation
    dampers: int  # nonlinear ones
    contacts: int
    shaken: int  # elongations that a noise multiplies
    taps: int  # modes of memories whose mean square is kept
    modes: int  # of all memories
    resting: int  # walls on which rows can rest
    states: int  # of sources and dampers; behind them is which rows rest


class Numbers(NamedTuple):
    """Everything that a step multiplies with, in the precision of the sweep or in double."""

    step: Any
    zero: Any
    # sparse rows: nonzeros from ``begin[i]`` to ``begin[i + 1]``, each with its coordinate ``at`` and its value
    row_begin: Any  # of the elongations
    row_at: Any
    row: Any
    noise_begin: Any  # of white noise, with sqrt(q h)
    noise_at: Any
    noise: Any
    source_begin: Any  # of other excitation
    source_at: Any
    source: Any
    is_smooth: Any  # (sources,) 1 of a force that changes little within a step, otherwise 0
    constant: Any  # (points,) impulse of constant forces in a step
    spring_kind: Any  # (rows,) 0, CUBIC or NINTH
    spring: Any  # (10 rows,) coefficients of the springs, times the step
    damping: Any  # (rows,) weight of the present velocity in the force of springpots and dashpots
    answer: Any  # (rows,) their mean force within a step per unit of impulse in that step
    near: Any  # (20 rows,) weights of the two increments before the group and of its first three, in each of four steps
    solve: Any  # (points * padded points,) inverse of mass + step * answers
    wall_at: Any  # (walls,) number of the elongation
    side: Any  # 1: the elongation stays above the place, -1: below
    place: Any
    restitution_kind: Any  # (walls,)
    restitution: Any  # (3 walls,) a number, or those of `springpot.simulation.kernel.restitution.Power`
    jump: Any  # (walls * points,) change of the velocities per unit of change of the elongation's velocity
    along: Any  # (walls * rows,) change of the elongations' velocities per unit of change of the wall's
    reduced: Any  # (walls,) reduced mass
    rests: Any  # (walls,) 1 of a lossy wall along whose row only smooth forces act, otherwise 0
    lean: Any  # (walls * points,) as jump, with the answers of dampers and memory
    heavy: Any  # (walls,) as reduced, with these
    mass: Any  # (points * points,)
    damper_at: Any  # (dampers,) number of the elongation
    damper_kind: Any
    damper: Any  # (6 dampers,) numbers of its law, per unit of reduced mass, and that; of a contact its number, chi
    turn: Any  # (dampers * points,) as jump
    cross: Any  # (dampers * rows,) change of the elongations' velocities per unit of change of its own
    contact_at: Any  # (contacts,) number of the elongation
    contact: Any  # (5 contacts,) as of `springpot.simulation.kernel.soft_contacts.Soft`
    shaken_at: Any  # (shaken,) number of the elongation
    shaken: Any  # (2 shaken,) as of `springpot.simulation.kernel.forces.Parametric`
    shaken_begin: Any  # (shaken + 1,)
    shaken_square: Any  # the squares of their envelopes in each step, or nothing, one after another
    # chains of `springpot.simulation.kernel.several_laws`
    rules: Any  # of restitution
    forces: Any


@njit(**INLINE)
def cubic_of(q, e):
    """The springs of an elongation, if they are cubic at most."""
    b = 10 * e
    return Cubic(q.spring[b], q.spring[b + 1], q.spring[b + 2], q.spring[b + 3])


@njit(**INLINE)
def nonic_of(q, e):
    """The springs of an elongation."""
    b = 10 * e
    return Nonic(
        q.spring[b], q.spring[b + 1], q.spring[b + 2], q.spring[b + 3], q.spring[b + 4],
        q.spring[b + 5], q.spring[b + 6], q.spring[b + 7], q.spring[b + 8], q.spring[b + 9],
    )  # fmt: skip


@njit(**LINKED)
def energy_of(size, q, x, v):
    """Kinetic energy, and that of the springs and constant forces, of one lane."""
    energy = 0.0
    for i in range(size.points):
        momentum = 0.0
        for k in range(size.points):
            momentum += q.mass[i * size.points + k] * v[k]
        energy += 0.5 * momentum * v[i] - q.constant[i] * x[i] / q.step
    for e in range(size.rows):
        u, power = 0.0, 1.0
        for p in range(q.row_begin[e], q.row_begin[e + 1]):
            u += q.row[p] * x[q.row_at[p]]
        for k in range(10):
            power *= u
            energy += q.spring[10 * e + k] * power / ((k + 1.0) * q.step)
    for c in range(size.contacts):
        u, e = 0.0, q.contact_at[c]
        for p in range(q.row_begin[e], q.row_begin[e + 1]):
            u += q.row[p] * x[q.row_at[p]]
        depth, force = force_of_contact(q.contact, c, u, 1.0)
        energy += force * depth / (q.contact[5 * c + 3] + 1.0)
    return energy


@njit(**INLINE)
def pushed(size, q, given, j, lane, v):
    """Put the impulses of constant forces and of smooth excitation in step j behind the velocities."""
    for i in range(size.points):
        v[2 * MOST_POINTS + i] = q.constant[i]
    for r in range(size.sources):
        for p in range(q.source_begin[r], q.source_begin[r + 1]):
            impulse = f64(given[(GROUP * r + j) * LANES + lane])
            v[2 * MOST_POINTS + q.source_at[p]] += q.is_smooth[r] * q.source[p] * impulse


@njit(**INLINE)
def given_along(size, q, x, v, struck):
    """What springs and smooth forces change of a struck elongation's velocity per time, times its reduced mass."""
    given = 0.0
    for i in range(size.points):
        given += v[2 * MOST_POINTS + i] * q.jump[struck * size.points + i]
    for e in range(size.rows):
        along = q.along[struck * size.rows + e]
        if q.spring_kind[e] == 0 or along == 0.0:
            continue
        u = 0.0
        for p in range(q.row_begin[e], q.row_begin[e + 1]):
            u += q.row[p] * x[q.row_at[p]]
        if q.spring_kind[e] == CUBIC:
            given += cubic(cubic_of(q, e), u) * along
        else:
            given += nonic(nonic_of(q, e), u) * along
    return given / q.step


@njit(**INLINE)
def restitution_of(q, w, speed):
    """Of wall w at a speed."""
    if q.restitution_kind[w] == FIXED:
        return q.restitution[3 * w]
    if q.restitution_kind[w] == POWER:
        return share_left(Power(q.restitution[3 * w], q.restitution[3 * w + 1], q.restitution[3 * w + 2]), speed)
    return share_by(q.rules, q.restitution_kind[w] - RULE, speed)


@njit(**INLINE)
def strike(size, q, v, struck, speed, closing, r, gain, hits, lane, weight, observers):
    """One impact at the true speed ``closing``, which is not ``speed``, that of the flight: velocities and sums.

    ``gain`` is what the closing speed gains per time.  Observers do not see a rest, as `fly` says.
    """
    change = closing + r * closing
    rests = change <= speed and closing <= gain * q.step
    if change <= speed:  # nothing still closes, nor by rounding: that would be struck again and again
        size_of_rate = 0.0
        for p in range(q.row_begin[q.wall_at[struck]], q.row_begin[q.wall_at[struck] + 1]):
            size_of_rate += abs(q.row[p] * v[q.row_at[p]])
        change = speed + ROUNDING * size_of_rate
    for i in range(size.points):
        v[i] += q.side[struck] * change * q.jump[struck * size.points + i]
    at = HITS * struck * LANES + lane
    hits[at] += weight
    hits[at + LANES] += weight * closing
    hits[at + 2 * LANES] += weight * closing * closing
    hits[at + 3 * LANES] += weight * 0.5 * q.reduced[struck] * (1.0 - r * r) * closing * closing
    hits[at + 4 * LANES] += weight * q.reduced[struck] * change
    if weight > 0.0 and not rests:
        show_impact(observers, struck, weight, closing, lane)


@njit(**LINKED)
def fly(size, q, x, v, left, since, hits, limits, lane, weight, observers):
    """Straight flight of one lane over the time ``left`` with the earliest impact first; how many impacts there were.

    It begins at the time ``since`` after the middle between two kicks.  Before that middle the kick has given the
    masses more of the impulse of springs and smooth forces than they have by then, after it less: an impact takes the
    velocity without this, else each changes the energy at random, which heats a motion with little damping.  An impact
    after which the masses would not part in spite of the restitution, no faster than what presses on them makes them
    within a step, is their rest on each other: the sums have it, observers do not see it.
    """
    events, end, n = 0, since + left, size.points
    while True:
        struck, soonest, speed, deep = -1, left, 0.0, 0.0
        for w in range(size.walls):
            e = q.wall_at[w]
            distance, rate = -q.place[w], 0.0
            for p in range(q.row_begin[e], q.row_begin[e + 1]):
                distance += q.row[p] * x[q.row_at[p]]
                rate += q.row[p] * v[q.row_at[p]]
            distance, rate = distance * q.side[w], rate * q.side[w]
            if rate < 0.0 and distance < -rate * soonest:
                struck, speed, deep = w, -rate, distance
                soonest = distance / -rate if distance > 0.0 else 0.0
        if struck < 0:
            break
        left -= soonest
        deep -= speed * soonest  # where it lies behind the wall (by rounding, or as it began): put back onto it
        for i in range(n):
            x[i] += soonest * v[i] - q.side[struck] * deep * q.jump[struck * n + i]
        gain = -q.side[struck] * given_along(size, q, x, v, struck) / q.reduced[struck]  # of closing speed per time
        closing = speed + gain * (end - left)
        if closing <= 0.0:
            closing = speed
        r = restitution_of(q, struck, closing) if events < MOST_EVENTS else 0.0
        strike(size, q, v, struck, speed, closing, r, gain, hits, lane, weight, observers)
        events += 1
        if events == MOST_EVENTS:
            limits[lane] += 1.0
        if events >= 2 * MOST_EVENTS:
            limits[LANES + lane] += 1.0
            return events
    for i in range(n):
        x[i] += left * v[i]
    return events


@njit(**LINKED)
def repair(size, q, now_x, now_v, s, d, j, given, hits, limits, x, v, lane, before, after, observers):
    """The drift of one lane again, in double precision and with impacts; how many there were.

    ``before`` and ``after`` the observation are the weights of its two halves.  Nothing is written where there was no
    impact, else the rounding of near misses would change the state.
    """
    n = size.points
    for i in range(n):
        x[i] = now_x[i * LANES + lane] + f64(s.before[i * LANES + lane])
        v[i] = now_v[i * LANES + lane] + f64(s.gained[i * LANES + lane])
        x[MOST_POINTS + i] = x[i]
    pushed(size, q, given, j, lane, v)
    events = fly(size, q, x, v, 0.5 * q.step, -0.5 * q.step, hits, limits, lane, before, observers)
    for i in range(n):
        x[2 * MOST_POINTS + i], v[MOST_POINTS + i] = x[i], v[i]
    events += fly(size, q, x, v, 0.5 * q.step, 0.0, hits, limits, lane, after, observers)
    if events == 0:
        return 0
    for i in range(n):
        at = i * LANES + lane
        s.seen[at] = x[2 * MOST_POINTS + i] - now_x[at]
        s.seen_v[at] = v[MOST_POINTS + i]
        s.moved[at] = x[i] - now_x[at]
        s.gained[at] = v[i] - now_v[at]
        s.v[at] = v[i]
    put_in(size, q, s, d, j, x, v, lane)
    return events


@njit(**INLINE)
def put_in(size, q, s, d, j, x, v, lane):
    """The elongations of one lane after a drift, from the states before it, at the observation and after it."""
    for e in range(size.rows):
        before, seen, u, w = 0.0, 0.0, 0.0, 0.0
        for p in range(q.row_begin[e], q.row_begin[e + 1]):
            i = q.row_at[p]
            before += q.row[p] * x[MOST_POINTS + i]
            seen += q.row[p] * x[2 * MOST_POINTS + i]
            u += q.row[p] * x[i]
            w += q.row[p] * v[i]
        s.u[e * LANES + lane], s.w[e * LANES + lane], s.seen_u[e * LANES + lane] = u, w, seen
        d[(6 * e + 2 + j) * LANES + lane] = u - before
