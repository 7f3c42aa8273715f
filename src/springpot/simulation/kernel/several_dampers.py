"""Nonlinear dampers, parts that yield, forces of the user and soft contacts between several masses.

A damper or force is followed alone for half a step before and half a step after the kick, as with one mass, by the same
laws: of its elongation and the reduced mass along its row.  Several are followed one after another, and after the kick
in reverse.  The elastic force of a contact is in the kick, its dissipation is a damper.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from springpot.simulation.kernel.forces import CoulombDamper, PowerDamper, VanDerPolDamper
from springpot.simulation.kernel.hysteresis import STATES, AnyPower, Hysteresis, Plastic, WholePower
from springpot.simulation.kernel.lanes import INLINE, LANES, f64, greater, typed
from springpot.simulation.kernel.questions import answers, damp
from springpot.simulation.kernel.several_laws import damp_by
from springpot.simulation.kernel.several_rest import HITS
from springpot.simulation.kernel.soft_contacts import force_of_contact
from springpot.simulation.kernel.watching import show_impact, show_peak

# kinds of dampers, WEN with whole exponents; from FORCE on forces of the user, in the order of the chain
COULOMB, POWERS, VAN_DER_POL, CONTACT, JENKINS, WEN, BOUC_WEN, FORCE = range(8)
FELT = 1  # the step in which parts that yield always are here: no lane is advanced again from the first
DAMPER = 6  # numbers of each: the last is its reduced mass


class ContactDamper(NamedTuple):
    """The dissipation k d^p chi d' of a contact for half a step, at the depth of the kick.

    As that of `VanDerPolDamper`, it never turns the velocity round: else a strong one would let the masses sink in.
    """

    rate: float  # impulse of its elastic force in half a step times chi, over the reduced mass


@answers(damp, ContactDamper)
def _damp_contact(force, slot, n, x, v, forcing, lane, weight, after):
    growth = force.rate + typed(0.5, v) * force.rate * force.rate
    change = -v * growth / (typed(1.0, v) + growth)
    forcing.works[slot * LANES + lane] += weight * change * (v + typed(0.5, v) * change)
    return change


@njit(**INLINE)
def _all(law, slot, n, s, e, forcing, weight, after):
    """The change of velocity in half of step n by one law, in all lanes; their elongations are in ``s.change``."""
    for lane in range(LANES):
        s.f[lane] = damp(law, slot, n, s.change[lane], s.w[e + lane], forcing, lane, weight, after)


@njit(**INLINE)
def _follow(size, q, k, n, s, forcing, weight, after):
    """What damper k changes of the elongation's velocity in half of step n, to ``s.f``.

    The kind is asked outside the loops over lanes: inside there would be no vector code.
    """
    at, kind, slot, e = DAMPER * k, q.damper_kind[k], size.sources + k, q.damper_at[k] * LANES
    a, b, place, step = q.damper[at], q.damper[at + 1], int(q.damper[at + 1]), q.step
    limit, beta, exponent = q.damper[at + 2], q.damper[at + 3], q.damper[at + 4]
    if kind >= FORCE:
        for lane in range(LANES):
            u, w = s.change[lane], s.w[e + lane]
            s.f[lane] = damp_by(q.forces, kind - FORCE, slot, n, u, w, forcing, lane, weight, after)
    elif kind == COULOMB:
        _all(CoulombDamper(a), slot, n, s, e, forcing, weight, after)
    elif kind == POWERS:
        _all(PowerDamper(a, b), slot, n, s, e, forcing, weight, after)
    elif kind == VAN_DER_POL:
        _all(VanDerPolDamper(a, b), slot, n, s, e, forcing, weight, after)
    elif kind == JENKINS:
        _all(Hysteresis(a, step, place, Plastic(limit)), slot, FELT, s, e, forcing, weight, after)
    elif kind == WEN:
        law = WholePower(limit, beta, exponent)
        _all(Hysteresis(a, step, place, law), slot, FELT, s, e, forcing, weight, after)
    elif kind == BOUC_WEN:
        power = AnyPower(limit, beta, exponent)
        _all(Hysteresis(a, step, place, power), slot, FELT, s, e, forcing, weight, after)
    else:
        for lane in range(LANES):
            u, w = s.change[lane], s.w[e + lane]
            _, force = force_of_contact(q.contact, int(a), u, typed(0.5, u) * step)
            s.f[lane] = damp(ContactDamper(typed(force * b, w)), slot, n, u, w, forcing, lane, weight, after)


@njit(**INLINE)
def wake_dampers(size, q, forcing):
    """The states of those that have some, at time 0."""
    for k in range(size.dampers):
        if JENKINS <= q.damper_kind[k] < FORCE:
            for i in range(STATES * LANES):
                forcing.state[int(q.damper[DAMPER * k + 1]) * LANES + i] = q.zero


@njit(**INLINE)
def damp_before(size, q, s, hits, forcing, n, weight, no):
    """Half of step n of all dampers before the kick."""
    for k in range(size.dampers):
        e = q.damper_at[k] * LANES
        for lane in range(LANES):
            s.change[lane] = s.u[e + lane]
        _follow(size, q, k, n, s, forcing, weight, no)
        _turn(size, q, s, hits, k, weight)


@njit(**INLINE)
def damp_later(size, q, s, d, j, hits, forcing, n, weight, yes):
    """Half of step n of all dampers after the kick; the drift, which is already taken, is with the new velocity."""
    half = typed(0.5, q.step) * q.step
    for k in range(size.dampers - 1, -1, -1):
        e, at = q.damper_at[k] * LANES, (6 * q.damper_at[k] + 2 + j) * LANES
        for lane in range(LANES):
            s.change[lane] = s.u[e + lane] - d[at + lane]  # that of the kick
        _follow(size, q, k, n, s, forcing, weight, yes)
        _turn(size, q, s, hits, k, weight)
        for i in range(size.points):
            share, at = q.turn[k * size.points + i], i * LANES
            for lane in range(LANES):
                s.seen[at + lane] += half * share * s.f[lane]
                s.moved[at + lane] += q.step * share * s.f[lane]
        for e in range(size.rows):
            share, at, new = q.cross[k * size.rows + e], e * LANES, (6 * e + 2 + j) * LANES
            for lane in range(LANES):
                s.seen_u[at + lane] += half * share * s.f[lane]
                s.u[at + lane] += q.step * share * s.f[lane]
                d[new + lane] += q.step * share * s.f[lane]


@njit(**INLINE)
def _turn(size, q, s, hits, k, weight):
    """Change all velocities by that of the elongation of damper k, which is in ``s.f``; add a contact's momentum."""
    if q.damper_kind[k] == CONTACT:
        c = int(q.damper[DAMPER * k])
        share, at = q.contact[5 * c + 1] * q.damper[DAMPER * k + DAMPER - 1], (HITS * (size.walls + c) + 4) * LANES
        for lane in range(LANES):
            hits[at + lane] += f64(weight * share * s.f[lane])
    for i in range(size.points):
        share, at = q.turn[k * size.points + i], i * LANES
        for lane in range(LANES):
            s.v[at + lane] += share * s.f[lane]
            s.gained[at + lane] += share * s.f[lane]
    for e in range(size.rows):
        share, at = q.cross[k * size.rows + e], e * LANES
        for lane in range(LANES):
            s.w[at + lane] += share * s.f[lane]


@njit(**INLINE)
def press(size, q, s, hits, peaks, weight):
    """The elastic impulses of contacts on the masses; the largest forces are kept from ``peaks`` on, if it is not 0."""
    for c in range(size.contacts):
        e, place = q.contact_at[c] * LANES, HITS * (size.walls + c) * LANES
        for lane in range(LANES):
            _, force = force_of_contact(q.contact, c, s.u[e + lane], q.step)
            hits[place + 4 * LANES + lane] += weight * force
            s.f[lane] = q.contact[5 * c + 1] * force
        if peaks > 0:
            loss = q.contact[5 * c + 1] * q.contact[5 * c + 4]
            for lane in range(LANES):
                whole = s.f[lane] * q.contact[5 * c + 1] * (typed(1.0, q.step) - loss * s.w[e + lane]) / q.step
                top = peaks + c * LANES + lane
                hits[top] = greater(hits[top], f64(whole))
        for p in range(q.row_begin[q.contact_at[c]], q.row_begin[q.contact_at[c] + 1]):
            value, i = q.row[p], q.row_at[p] * LANES
            for lane in range(LANES):
                s.impulse[i + lane] += value * s.f[lane]


@njit(**INLINE)
def touch(size, q, s, d, j, hits, peaks, weight, observers):
    """Count the contacts that a drift begins, and show the largest forces of those that it ends."""
    for c in range(size.contacts):
        e, new = q.contact_at[c] * LANES, (6 * q.contact_at[c] + 2 + j) * LANES
        at, place, away = HITS * (size.walls + c) * LANES, q.contact[5 * c], q.contact[5 * c + 1]
        for lane in range(LANES):
            u = s.u[e + lane]
            s.f[lane] = q.zero
            if away * (u - place) < q.zero and away * (u - d[new + lane] - place) >= q.zero:
                speed = abs(s.w[e + lane])
                s.f[lane] = speed
                hits[at + lane] += weight
                hits[at + LANES + lane] += weight * speed
                hits[at + 2 * LANES + lane] += weight * speed * speed
        for lane in range(LANES if peaks > 0 else 0):
            top = peaks + c * LANES + lane
            if hits[top] > 0.0 and away * (s.u[e + lane] - place) >= q.zero:
                if weight > 0.0:
                    show_peak(observers, c, hits[top], lane)
                hits[top] = 0.0
        if weight > 0.0 and observers.on_impacts.size > 0:
            for lane in range(LANES):
                if s.f[lane] > q.zero:
                    show_impact(observers, size.walls + c, weight, f64(s.f[lane]), lane)
