"""Soft contacts: where one is touched, the drift is taken again in short steps with the force of the contacts between.

In the middle of each short step stands a kick by the contacts alone; before and after it the masses fly freely, with
impacts on rigid walls.  The dissipation k d^p chi d' is solved with the mean of the velocities before and after the
kick, so it never turns them round.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, LINKED
from springpot.simulation.kernel.motion import add, sum_of
from springpot.simulation.kernel.reading import shared
from springpot.simulation.kernel.striking import advance, fly, land, push_all, take_off
from springpot.simulation.kernel.tables import (
    CONTACT,
    CONTACT_ALONG,
    CONTACT_AT,
    CONTACT_JUMP,
    CONTACTS,
    HITS,
    OF_A_WALL,
    POINTS,
    ROWS,
    SOFT,
    STEP,
    SUBSTEPS,
    WALLS,
)
from springpot.simulation.kernel.vectors import (
    choose,
    double,
    filled,
    larger,
    load,
    opposite,
    power,
    root,
    size,
    some,
    store,
)
from springpot.simulation.kernel.watching import ON_IMPACTS_COUNT, show_impacts, show_peaks

NUMBERS_OF_CONTACT = 6
"""Place, direction of the force, stiffness, exponent, dissipation, reduced mass along the row."""


@njit(**INLINE)
def is_touched(K, F, T, o):
    """Whether a drift begins, ends or is seen behind a contact in some lane."""
    inside = load(T.v, o) < load(T.v, o)
    for c in range(K[CONTACTS]):
        at, b = K[K[CONTACT_AT] + c] * LANES + o, K[CONTACT] + NUMBERS_OF_CONTACT * c
        away, place = F[b + 1], F[b]
        for u in (load(T.u0, at), load(T.seen_u, at), load(T.u, at)):
            inside = inside | (away * (place - u) > 0.0)
    return some(inside)


@njit(**INLINE)
def elastic(F, b, u):
    """The depth of a contact, and its elastic force."""
    depth = larger(F[b + 1] * (F[b] - u), 0.0)
    exponent = shared(F, b + 3)
    if exponent == 1.0:
        return depth, F[b + 2] * depth
    if exponent == 1.5:
        return depth, F[b + 2] * depth * root(depth)
    return depth, F[b + 2] * choose(depth > 0.0, power(depth, filled(depth, exponent)), 0.0)


@njit(**INLINE)
def pressed(F, b, u, w):
    """The force of a contact at an elongation and its rate."""
    _depth, force = elastic(F, b, u)
    return force * (1.0 - F[b + 1] * F[b + 4] * w)


@njit(**LINKED)
def _touches(K, F, T, S, hit, span, weight, o):
    """Count the touches of the last flight, which ``hit`` a rigid wall in some lanes; those that end show their peaks.

    The flight ends in the contact, or is out of it again after an impact on the wall behind: it would have been in it
    after the time ``span`` without the impact.
    """
    for c in range(K[CONTACTS]):
        e, b, to = K[K[CONTACT_AT] + c] * LANES + o, K[CONTACT] + NUMBERS_OF_CONTACT * c, c * LANES + o
        away, place, u = F[b + 1], F[b], load(T.fu, e)
        outside, inside = away * (load(T.touched, to) - place) >= 0.0, away * (u - place) < 0.0
        closing = 0.0 - away * load(T.touched, to + K[CONTACTS] * LANES)
        through = hit & (away * (load(T.touched, to) - place) < closing * span) & (away * load(T.w, e) > 0.0)
        new = outside & (inside | through)
        if some(new):
            speed = size(choose(hit, closing, load(T.w, e)))
            one, at = choose(new, weight, 0.0), sum_of(K, HITS, OF_A_WALL * (K[WALLS] + c)) + o
            add(T.sums, at, double(one))
            add(T.sums, at + LANES, double(one * speed))
            add(T.sums, at + 2 * LANES, double(one * speed * speed))
            show_impacts(S, K[WALLS] + c, new & (weight > 0.0), speed, o, T.own)
        store(T.touched, to, u)
        if S[ON_IMPACTS_COUNT] > 0:
            ends = opposite(inside) & (load(T.peaks, to) > 0.0)
            if some(ends):
                show_peaks(S, c, ends & (double(weight) > 0.0), load(T.peaks, to), o, T.own)
                store(T.peaks, to, choose(ends, 0.0, load(T.peaks, to)))


@njit(**LINKED)
def _push(K, F, T, S, short, weight, o):
    """A kick by the contacts alone; where there was one."""
    pushed = load(T.v, o) < load(T.v, o)
    deepest = filled(load(T.v, o), 0.0)
    for c in range(K[CONTACTS]):
        e, b = K[K[CONTACT_AT] + c] * LANES + o, K[CONTACT] + NUMBERS_OF_CONTACT * c
        depth, force = elastic(F, b, load(T.fu, e))
        inside = depth > 0.0
        if some(inside):
            pushed, deepest = pushed | inside, larger(deepest, depth)
            w, impulse, away, mass = load(T.w, e), force * short, F[b + 1], F[b + 5]
            share = (0.5 * F[b + 4] / mass) * impulse
            change = ((away / mass) * impulse - 2.0 * share * w) / (1.0 + share)
            middle = w + 0.5 * change
            viscous = F[b + 4] * impulse * middle
            momentum, at = impulse - away * viscous, sum_of(K, HITS, OF_A_WALL * (K[WALLS] + c)) + o
            add(T.sums, at + 3 * LANES, double(weight * viscous * middle))
            add(T.sums, at + 4 * LANES, double(weight * momentum))
            if S[ON_IMPACTS_COUNT] > 0:
                store(T.peaks, c * LANES + o, larger(load(T.peaks, c * LANES + o), double(momentum / short)))
            push_all(K, F, T, K[CONTACT_JUMP] + c * K[POINTS], K[CONTACT_ALONG] + c * K[ROWS], change, o)
    at = sum_of(K, SOFT, 0) + o
    add(T.sums, at, double(choose(pushed, short * weight, 0.0)))
    store(T.sums, at + LANES, larger(load(T.sums, at + LANES), double(weight * deepest)))
    return pushed


@njit(**INLINE)
def _to(K, F, T, S, j, begin, span, in_window, after_middle, o):
    """A part of the flight; where it struck a wall.  The rates at its beginning are kept for the contacts."""
    for c in range(K[CONTACTS]):
        at = K[K[CONTACT_AT] + c] * LANES + o
        store(T.touched, (K[CONTACTS] + c) * LANES + o, load(T.w, at))
    if K[WALLS] > 0:
        return fly(K, F, T, S, j, begin, span, in_window, after_middle, o)
    advance(K, T, span, o)
    return load(T.v, o) < load(T.v, o)


@njit(**LINKED)
def drift_through_contacts(K, F, T, S, j, in_window, after_middle, o):
    """The drift again, in short steps."""
    count = 2 * K[SUBSTEPS]
    short = shared(F, K[STEP]) / count
    take_off(K, T, o)
    for c in range(K[CONTACTS]):
        store(T.touched, c * LANES + o, load(T.fu, K[K[CONTACT_AT] + c] * LANES + o))
    ever = load(T.v, o) < load(T.v, o)
    for s in range(count):
        weight = filled(load(T.v, o), in_window if 2 * s < count else after_middle)
        hit = _to(K, F, T, S, j, s * short, 0.5 * short, in_window, after_middle, o)
        _touches(K, F, T, S, hit, 0.5 * short, weight, o)
        pushed = _push(K, F, T, S, short, weight, o)
        again = _to(K, F, T, S, j, (s + 0.5) * short, 0.5 * short, in_window, after_middle, o)
        _touches(K, F, T, S, again, 0.5 * short, weight, o)
        ever = ever | hit | pushed | again
        if 2 * s + 2 == count:  # the observation
            for i in range(K[POINTS]):
                at = i * LANES + o
                store(T.seen, at, choose(ever, load(T.fx, at), load(T.seen, at)))
                store(T.seen_v, at, choose(ever, load(T.v, at), load(T.seen_v, at)))
            for e in range(K[ROWS]):
                store(T.seen_u, e * LANES + o, choose(ever, load(T.fu, e * LANES + o), load(T.seen_u, e * LANES + o)))
    land(K, F, T, j, ever, o)
