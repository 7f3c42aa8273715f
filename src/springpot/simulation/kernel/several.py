"""The block kernel of several masses: steps outside, coordinates in the middle, lanes inside.

Straight drift from kick to kick; each kick has all springs, dampers, memory and excitation, with the answer of dampers
and memory to their own impulse in one small matrix.  Every spring, damper, springpot and wall lies on a row g, its
elongation g.x, so there is no matrix of stiffness or memory.  As in `springpot.simulation.kernel.block` four steps make
a group, the state is in double precision between groups, and changes within a group are in the precision of the sweep;
the observation is in the middle of the drift.  The lanes that one drift takes behind a wall have this drift again, with
its impacts (`springpot.simulation.kernel.several_impacts`), and go on with all others: a straight line whose ends lie
before a wall does not cross it.

How many coordinates, rows, walls and sources there are is known at run time only, and every innermost loop is one over
lanes, which is vector code whatever the sizes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from springpot.simulation.kernel.branches import birth, closed, keep, name_paths, opened
from springpot.simulation.kernel.cache import cached
from springpot.simulation.kernel.felt import MOST_FELT, feel, record_felt
from springpot.simulation.kernel.forces import Parametric, cubic, nonic
from springpot.simulation.kernel.lanes import (
    ENTRY,
    GROUP,
    INLINE,
    LANES,
    SPARE,
    beyond,
    f64,
    lesser,
    middle,
    no,
    stack_array,
    typed,
    u32,
    yes,
)
from springpot.simulation.kernel.questions import Forcing, push, supply, wake
from springpot.simulation.kernel.random import draw_for_steps, lane_numbers
from springpot.simulation.kernel.several_dampers import FELT, damp_before, damp_later, press, touch, wake_dampers
from springpot.simulation.kernel.several_impacts import (
    CUBIC,
    MOST_POINTS,
    NINTH,
    cubic_of,
    energy_of,
    fly,
    nonic_of,
    put_in,
    repair,
)
from springpot.simulation.kernel.several_rest import HITS, MOST_WALLS, count_resting, flag, has_leant, hold, lay_down
from springpot.simulation.kernel.several_resting import fly_or_rest, repair_or_rest
from springpot.simulation.kernel.sources import Filtered, Harmonic, Modulated, Poisson, Table
from springpot.simulation.kernel.steps import State
from springpot.simulation.kernel.turning import turn
from springpot.simulation.kernel.watching import show_steps

MOST_ROWS, MOST_NOISES, MOST_SOURCES, MOST_DAMPERS = 16, 16, SPARE, 12
MOST_TAPS = 12
MOST_MODES = 24 * MOST_ROWS
MOST_STATES = 480  # of sources, and of parts that yield
FILTERED, HARMONIC, TABLE, POISSON, MODULATED = 0, 1, 2, 3, 4  # kinds of sources
STOP_EVERY = 256  # groups between two checks of the stop flag

_lane = stack_array(LANES)
_two_lanes = stack_array(2 * LANES)
_of_points = stack_array(MOST_POINTS * LANES)
_of_rows = stack_array(MOST_ROWS * LANES)
_by_step = stack_array(MOST_ROWS * GROUP * LANES)
_increments = stack_array(MOST_ROWS * (GROUP + 2) * LANES)
_modes = stack_array(MOST_MODES * LANES)
_normals = stack_array(MOST_NOISES * GROUP * LANES)
_four = stack_array(GROUP * LANES)
_given = stack_array((MOST_SOURCES + 1) * GROUP * LANES)
_states = stack_array(MOST_STATES * LANES)
_of_sources = stack_array((MOST_SOURCES + MOST_DAMPERS + MOST_NOISES) * LANES)
_of_taps = stack_array(MOST_TAPS * LANES)
_hits = stack_array((HITS + 1) * MOST_WALLS * LANES)
_few = stack_array(3 * MOST_POINTS)
_of_walls = stack_array(MOST_WALLS * LANES)
_shown = stack_array((MOST_POINTS + MOST_ROWS + MOST_FELT) * GROUP * LANES)


class Memories(NamedTuple):
    """The modes of the springpots and arms of each elongation; elongations with the same parts share a table."""

    begin: Any  # (rows,) first mode
    count: Any  # (rows,) how many; even
    table: Any  # (rows,) where its powers and weights begin
    powers: Any  # as in `springpot.simulation.kernel.block.Memory`
    weights: Any
    turned: Any  # (rows,) how many modes of circuits with a coil follow
    turned_table: Any  # (rows,) where their numbers begin
    turns: Any  # as in `springpot.simulation.kernel.turning.turn`
    tapped: Any  # (taps,) modes whose squares are summed, once in every group


class Sources(NamedTuple):
    """Excitation that is not white, as `springpot.simulation.kernel.sources` has it, one after another."""

    parts: int  # of a step: with 2 the impulses are sums of two of a run with half the step
    kind: Any  # (sources,)
    word: Any  # (sources,) first counter word
    place: Any  # (sources,) of its state
    pair_begin: Any  # (sources + 1,)
    pairs: Any  # (all, 20)
    newest: Any  # (4 sources,)
    start_begin: Any  # (sources + 1,)
    start: Any  # (all, most)
    wave: Any  # (2 sources,) impulse and turn, or rate and size, or states and steps, or records and whether drawn
    table_begin: Any  # (sources + 1,)
    # of modulated noise roots, gains, changes and what is seen; of other noise its envelope, or nothing
    table: Any


class _Lanes(NamedTuple):
    """Lane arrays of the sweep."""

    x0: Any
    v: Any
    before: Any  # x before the drift, less x0
    moved: Any
    gained: Any
    seen: Any
    seen_v: Any
    u: Any
    w: Any
    seen_u: Any
    f: Any
    pull: Any
    impulse: Any
    change: Any
    clear: Any
    middle: Any
    kicked: Any  # elongations at the kick


class _Sums(NamedTuple):
    """Lane arrays of sums."""

    x: Any
    xx: Any
    vv: Any
    u: Any
    uu: Any
    ww: Any
    power: Any
    works: Any


@njit(**INLINE)
def _set(array, count, number):
    for i in range(count * LANES):
        array[i] = number


@njit(**INLINE)
def _clear(size, sums, zero):
    _set(sums.x, size.points, zero)
    _set(sums.xx, size.points, zero)
    _set(sums.vv, size.points, zero)
    _set(sums.u, size.gauged, zero)
    _set(sums.uu, size.gauged, zero)
    _set(sums.ww, size.shown, zero)
    _set(sums.power, 1, zero)
    _set(sums.works, size.sources + size.dampers + size.shaken, zero)


@njit(**INLINE)
def _add(array, more, count):
    for i in range(count * LANES):
        array[i] += more[i]


@njit(**INLINE)
def _along(q, e, source, total, to):
    """One elongation of all lanes, in double precision and then in that of the sweep."""
    for lane in range(LANES):
        total[lane] = 0.0
    for p in range(q.row_begin[e], q.row_begin[e + 1]):  # inside a loop over lanes this would be no vector code
        value, i = q.row[p], q.row_at[p] * LANES
        for lane in range(LANES):
            total[lane] += value * source[i + lane]
    for lane in range(LANES):
        to[lane] = total[lane]


@njit(**INLINE)
def _remember(z, z0, d, d0, h, h0, modes, powers, weights, t0):
    """Add four increments to every mode of one elongation, and write its force in the next four steps."""
    for i in range(GROUP * LANES):
        h[h0 + i] = typed(0.0, powers[t0])
    for k in range(0, modes, 2):
        t = t0 + 4 * k
        # a^4 - 1 is stored, not a^4: for slow modes a^4 rounds to 1
        a1, a2, a3, a_loss = powers[t], powers[t + 1], powers[t + 2], powers[t + 3]
        b1, b2, b3, b_loss = powers[t + 4], powers[t + 5], powers[t + 6], powers[t + 7]
        u1, u2, u3, u4 = weights[t], weights[t + 1], weights[t + 2], weights[t + 3]
        w1, w2, w3, w4 = weights[t + 4], weights[t + 5], weights[t + 6], weights[t + 7]
        i, j = z0 + k * LANES, z0 + (k + 1) * LANES
        for lane in range(LANES):
            e0, e1 = d[d0 + LANES + lane], d[d0 + 2 * LANES + lane]
            e2, e3 = d[d0 + 3 * LANES + lane], d[d0 + 4 * LANES + lane]
            y, q = z[i + lane], z[j + lane]
            y += a_loss * y + a3 * e0 + a2 * e1 + a1 * e2 + e3
            q += b_loss * q + b3 * e0 + b2 * e1 + b1 * e2 + e3
            z[i + lane] = y
            z[j + lane] = q
            h[h0 + lane] += u1 * y + w1 * q
            h[h0 + LANES + lane] += u2 * y + w2 * q
            h[h0 + 2 * LANES + lane] += u3 * y + w3 * q
            h[h0 + 3 * LANES + lane] += u4 * y + w4 * q


@njit(**INLINE)
def _filtered(f, i):
    return Filtered(
        f.word[i], f.parts, f.place[i], f.pairs[f.pair_begin[i] : f.pair_begin[i + 1]], f.newest[4 * i : 4 * i + 4],
        f.start[f.start_begin[i] : f.start_begin[i + 1]], f.table[f.table_begin[i] : f.table_begin[i + 1]],
    )  # fmt: skip


@njit(**INLINE)
def _harmonic(f, i):
    return Harmonic(f.word[i], f.place[i], f64(f.wave[2 * i]), f64(f.wave[2 * i + 1]))


@njit(**INLINE)
def _poisson(f, i):
    envelope = f.table[f.table_begin[i] : f.table_begin[i + 1]]
    return Poisson(f.word[i], f.parts, f64(f.wave[2 * i]), f64(f.wave[2 * i + 1]), envelope)


@njit(**INLINE)
def _modulated(f, i):
    begin, end, size, steps = f.table_begin[i], f.table_begin[i + 1], int(f.wave[2 * i]), int(f.wave[2 * i + 1])
    gains = begin + steps
    changes = gains + steps * size
    laws = (end - changes) // max(size * (size + 1), 1)  # 1 of a filter that does not change
    seen = end - laws * size
    return Modulated(
        f.word[i], f.place[i], f.table[changes:seen].reshape((laws, size, size)),
        f.table[seen:end].reshape((laws, size)), f.table[begin:gains], f.table[gains:changes].reshape((steps, size)),
    )  # fmt: skip


@njit(**INLINE)
def _table(f, i):
    begin, end, records = f.table_begin[i], f.table_begin[i + 1], int(f.wave[2 * i])
    impulses = f.table[begin:end].reshape((records, (end - begin) // records))
    return Table(f.word[i], f.place[i], f.wave[2 * i + 1] > 0.0, impulses)


@njit(**INLINE)
def _wake_sources(size, f, who, stream, k0, k1, forcing):
    for i in range(size.sources):
        if f.kind[i] == FILTERED:
            wake(_filtered(f, i), i, who, stream, k0, k1, forcing)
        elif f.kind[i] == HARMONIC:
            wake(_harmonic(f, i), i, who, stream, k0, k1, forcing)
        elif f.kind[i] == MODULATED:
            wake(_modulated(f, i), i, who, stream, k0, k1, forcing)
        elif f.kind[i] == TABLE:
            wake(_table(f, i), i, who, stream, k0, k1, forcing)


@njit(**INLINE)
def _supply_sources(size, f, group, who, stream, k0, k1, forcing):
    """The impulses of four steps."""
    for i in range(size.sources):
        if f.kind[i] == FILTERED:
            supply(_filtered(f, i), i, group, who, stream, k0, k1, forcing)
        elif f.kind[i] == HARMONIC:
            supply(_harmonic(f, i), i, group, who, stream, k0, k1, forcing)
        elif f.kind[i] == POISSON:
            supply(_poisson(f, i), i, group, who, stream, k0, k1, forcing)
        elif f.kind[i] == MODULATED:
            supply(_modulated(f, i), i, group, who, stream, k0, k1, forcing)
        else:
            supply(_table(f, i), i, group, who, stream, k0, k1, forcing)


@njit(**INLINE)
def _gather(size, q, j, g, given, s):
    """The impulses of constant forces, noise and other excitation on the masses in step j of the group."""
    padded = (size.points + 3) // 4 * 4
    for i in range(size.points):
        constant = q.constant[i]
        for lane in range(LANES):
            s.impulse[i * LANES + lane] = constant
    for i in range(size.points * LANES, padded * LANES):
        s.impulse[i] = q.zero
    for r in range(size.noises):
        for p in range(q.noise_begin[r], q.noise_begin[r + 1]):
            value, i, b = q.noise[p], q.noise_at[p] * LANES, (GROUP * r + j) * LANES
            for lane in range(LANES):
                s.impulse[i + lane] += value * g[b + lane]
    for r in range(size.sources):
        for p in range(q.source_begin[r], q.source_begin[r + 1]):
            value, i, b = q.source[p], q.source_at[p] * LANES, (GROUP * r + j) * LANES
            for lane in range(LANES):
                s.impulse[i + lane] += value * given[b + lane]


@njit(**INLINE)
def _shake(size, q, j, step, g, forcing, s, weight):
    """The impulses of noise that multiplies elongations, and its expected works."""
    for r in range(size.shaken):
        e, b, slot = q.shaken_at[r] * LANES, (GROUP * (size.noises + r) + j) * LANES, size.sources + size.dampers + r
        square, feed, begin, end = q.shaken[2 * r], q.shaken[2 * r + 1], q.shaken_begin[r], q.shaken_begin[r + 1]
        if end > begin:
            factor = q.shaken_square[min(begin + step, end - 1)]
            square, feed = square * factor, feed * factor
        law = Parametric(q.zero, square, feed)
        for lane in range(LANES):
            s.f[lane], _ = push(law, slot, 0, s.u[e + lane], s.w[e + lane], g[b + lane], forcing, 0, lane, weight)
        for p in range(q.row_begin[q.shaken_at[r]], q.row_begin[q.shaken_at[r] + 1]):
            value, i = q.row[p], q.row_at[p] * LANES
            for lane in range(LANES):
                s.impulse[i + lane] += value * s.f[lane]


@njit(**INLINE)
def _pull(size, q, m, j, h, d, s):
    """The impulses of springs, dampers and memory on the masses."""
    minus = -q.step
    for e in range(size.rows):
        c, i = q.damping[e], e * LANES
        if m.count[e] > 0:
            b, o, t = 20 * e + 5 * j, 6 * e * LANES, (GROUP * e + j) * LANES
            n0, n1, n2, n3, n4 = q.near[b], q.near[b + 1], q.near[b + 2], q.near[b + 3], q.near[b + 4]
            for lane in range(LANES):
                pull = h[t + lane] + n0 * d[o + lane] + n1 * d[o + LANES + lane] + c * s.w[i + lane]
                pull += n2 * d[o + 2 * LANES + lane] + n3 * d[o + 3 * LANES + lane] + n4 * d[o + 4 * LANES + lane]
                s.pull[i + lane] = pull
        else:
            for lane in range(LANES):
                s.pull[i + lane] = c * s.w[i + lane]
        if q.spring_kind[e] == CUBIC:
            third = cubic_of(q, e)
            for lane in range(LANES):
                s.f[lane] = cubic(third, s.u[i + lane]) + minus * s.pull[i + lane]
        elif q.spring_kind[e] == NINTH:
            ninth = nonic_of(q, e)
            for lane in range(LANES):
                s.f[lane] = nonic(ninth, s.u[i + lane]) + minus * s.pull[i + lane]
        else:
            for lane in range(LANES):
                s.f[lane] = minus * s.pull[i + lane]
        for p in range(q.row_begin[e], q.row_begin[e + 1]):
            value, i = q.row[p], q.row_at[p] * LANES
            for lane in range(LANES):
                s.impulse[i + lane] += value * s.f[lane]


@njit(**INLINE)
def _kick(size, q, s, weight, sums):
    """The change of all velocities, and the drift after it as if there were no wall."""
    n = size.points
    padded = (n + 3) // 4 * 4
    part = typed(0.5, q.step)
    half = part * q.step
    for i in range(n):
        b, at = i * padded, i * LANES
        s0, s1, s2, s3 = q.solve[b], q.solve[b + 1], q.solve[b + 2], q.solve[b + 3]
        for lane in range(LANES):
            s.change[lane] = (
                s0 * s.impulse[lane] + s1 * s.impulse[LANES + lane]
                + s2 * s.impulse[2 * LANES + lane] + s3 * s.impulse[3 * LANES + lane]
            )  # fmt: skip
        for k in range(4, padded, 4):
            s0, s1, s2, s3, o = q.solve[b + k], q.solve[b + k + 1], q.solve[b + k + 2], q.solve[b + k + 3], k * LANES
            for lane in range(LANES):
                s.change[lane] += (
                    s0 * s.impulse[o + lane] + s1 * s.impulse[o + LANES + lane]
                    + s2 * s.impulse[o + 2 * LANES + lane] + s3 * s.impulse[o + 3 * LANES + lane]
                )  # fmt: skip
        for lane in range(LANES):
            dv, v = s.change[lane], s.v[at + lane]
            middle = v + part * dv
            v += dv
            s.v[at + lane] = v
            s.gained[at + lane] += dv
            x = s.moved[at + lane]
            s.before[at + lane] = x
            s.seen[at + lane] = x + half * v
            s.moved[at + lane] = x + q.step * v
            sums.vv[at + lane] += weight * middle * middle


@njit(**INLINE)
def _speeds(size, q, s, weight, sums):
    """The mean of the velocities before and after the kick, squared, of points that are no coordinates."""
    part = typed(0.5, q.step)
    for e in range(size.shown):
        i = e * LANES
        for lane in range(LANES):
            s.f[lane] = s.w[i + lane]
        for p in range(q.row_begin[e], q.row_begin[e + 1]):
            value, b = q.row[p], q.row_at[p] * LANES
            for lane in range(LANES):
                s.f[lane] += value * s.v[b + lane]
        for lane in range(LANES):
            middle = part * s.f[lane]
            sums.ww[i + lane] += weight * middle * middle


@njit(**INLINE)
def _stretch(size, q, s, d, j, weight, sums):
    """The elongations after the drift, and the power of dampers and memory."""
    part = typed(0.5, q.step)
    half = part * q.step
    for e in range(size.rows):
        i, first, last = e * LANES, q.row_begin[e], q.row_begin[e + 1]
        a, o = q.answer[e], (6 * e + 2 + j) * LANES
        value, b = q.row[first], q.row_at[first] * LANES
        for lane in range(LANES):
            s.f[lane] = value * s.v[b + lane]
        for p in range(first + 1, last):
            value, b = q.row[p], q.row_at[p] * LANES
            for lane in range(LANES):
                s.f[lane] += value * s.v[b + lane]
        for lane in range(LANES):
            new, old, u = s.f[lane], s.w[i + lane], s.u[i + lane]
            sums.power[lane] += weight * (s.pull[i + lane] + a * (new - old)) * (part * (new + old))
            s.w[i + lane] = new
            d[o + lane] = q.step * new
            s.seen_u[i + lane] = u + half * new
            s.u[i + lane] = u + q.step * new


@njit(**INLINE)
def _feel(size, q, s, j, observers, given, state, shown):
    """Write what observers feel of the kick, of which ``kicked`` and ``middle`` have the elongations and their rates
    before it.
    """
    part = typed(0.5, q.step)
    for e in range(size.rows):
        a, i = q.answer[e], e * LANES
        for lane in range(LANES):
            new, old = s.w[i + lane], s.middle[i + lane]
            s.pull[i + lane] += a * (new - old)
            s.middle[i + lane] = part * (new + old)
    for k in range(observers.feels.size):
        which = observers.feels[k]
        to = beyond(shown, (GROUP * (size.points + size.rows + which) + j) * LANES)
        feel(
            observers, which, LANES, s.kicked, s.pull, s.middle, beyond(given, j * LANES),
            beyond(state, FELT * LANES), to,
        )  # fmt: skip


@njit(**INLINE)
def _work(size, q, j, given, s, weight, sums):
    """Half of the work of the sources: that with the velocities before the kick, or that with those after it."""
    share = typed(0.5, q.step) * weight
    for r in range(size.sources):
        b = (GROUP * r + j) * LANES
        for p in range(q.source_begin[r], q.source_begin[r + 1]):
            value, i = share * q.source[p], q.source_at[p] * LANES
            for lane in range(LANES):
                sums.works[r * LANES + lane] += value * given[b + lane] * s.v[i + lane]


@njit(**INLINE)
def _clear_of_others(size, q, s, state, leant):
    """The clearance of lanes with rows that rest, from all other walls.

    Nonlinear dampers act on a row after its drift, which is then made again.
    """
    margin = typed(1e-6, q.step)
    for lane in range(LANES):
        if size.dampers > 0 and has_leant(size, leant, lane):
            s.clear[lane] = q.zero
        elif state[flag(size, size.walls, lane)] > q.zero:
            clear = q.step
            for w in range(size.walls):
                if state[flag(size, w, lane)] == q.zero:
                    u, place = s.u[q.wall_at[w] * LANES + lane], q.place[w]
                    clear = lesser(clear, q.side[w] * (u - place) - margin * (abs(place) + abs(u)))
            s.clear[lane] = clear


@njit(**INLINE)
def _clearance(size, q, s, state, leant):
    """In how many lanes the end of the drift is not clear of every wall, with a margin for rounding.

    A row that rests is clear of its own.
    """
    margin = typed(1e-6, q.step)
    for w in range(size.walls):
        i, place, side = q.wall_at[w] * LANES, q.place[w], q.side[w]
        least = margin * abs(place)
        for lane in range(LANES):
            u = s.u[i + lane]
            near = side * (u - place) - (least + margin * abs(u))
            s.clear[lane] = near if w == 0 else lesser(s.clear[lane], near)
    if size.resting > 0:
        _clear_of_others(size, q, s, state, leant)
    close = 0
    for lane in range(LANES):  # a sum is vector code, a minimum with regard to NaN is not
        close += 1 if s.clear[lane] <= q.zero else 0
    return close


@njit(**INLINE)
def _hold(size, q, now_x, now_v, s, hits, state, leant, x, v, weight):
    """Hold the resting rows of all lanes that have some."""
    for lane in range(LANES):
        if state[flag(size, size.walls, lane)] > 0.0:
            hold(size, q, now_x, now_v, s, hits, state, leant, x, v, lane, weight)


@njit(**INLINE)
def _move(size, s, old, weight, sums):
    """The squares of the means of the velocities before and after a kick, where walls may have taken some of it."""
    part = typed(0.5, weight)
    for i in range(size.points * LANES):
        middle = part * (old[i] + s.v[i])
        sums.vv[i] += weight * middle * middle


@njit(**INLINE)
def _see(size, s, sums):
    """Add the observed displacements and elongations."""
    for i in range(size.points * LANES):
        seen = s.x0[i] + s.seen[i]
        sums.x[i] += seen
        sums.xx[i] += seen * seen
    for i in range(size.gauged * LANES):
        seen = s.seen_u[i]
        sums.u[i] += seen
        sums.uu[i] += seen * seen


@njit(**INLINE)
def _show(size, q, j, now_x, s, x, v):
    """Write what observers see of step j: x and v of the masses, then the elongations and their rates."""
    for i in range(size.points):
        at, to = i * LANES, (GROUP * i + j) * LANES
        for lane in range(LANES):
            x[to + lane] = now_x[at + lane] + s.seen[at + lane]
            v[to + lane] = s.seen_v[at + lane]
    for e in range(size.rows):
        at, to = e * LANES, (GROUP * (size.points + e) + j) * LANES
        for lane in range(LANES):
            x[to + lane] = s.seen_u[at + lane]
            v[to + lane] = 0.0
        for p in range(q.row_begin[e], q.row_begin[e + 1]):
            value, i = q.row[p], q.row_at[p] * LANES
            for lane in range(LANES):
                v[to + lane] += value * s.seen_v[i + lane]


@njit(**INLINE)
def _begin(size, q, start, path, now_x, now_v, s, d, hits, limits, x, v, lane, weight, observers, state, leant):
    """From the state at time 0 to the first kick."""
    n = size.points
    for i in range(n):
        x[i], v[i] = start[path, i], start[path, n + i]
        x[MOST_POINTS + i] = x[2 * MOST_POINTS + i] = x[i]
        v[2 * MOST_POINTS + i] = q.constant[i]
    if size.resting > 0:
        lay_down(size, q, x, v, state, lane)
        fly_or_rest(size, q, x, v, 0.5 * q.step, 0.0, hits, limits, lane, weight, observers, state, leant)
        count_resting(size, state, lane)
    else:
        fly(size, q, x, v, 0.5 * q.step, 0.0, hits, limits, lane, weight, observers)
    put_in(size, q, s, d, -1, x, v, lane)
    for i in range(n):
        now_x[i * LANES + lane], now_v[i * LANES + lane] = x[i], v[i]


@cached
@njit(**ENTRY)
def several(
    size, q, exact, memories, sources, start,
    first, blocks, steps, low, high, k0, k1, stream, halved, observers, record, every, stop, out, branches,
):  # fmt: skip
    """Advance the paths from ``first`` on by ``steps`` steps: ``blocks`` times LANES of them, one block after another.

    ``q`` and ``exact`` are the numbers in the precision of the sweep and in double precision.  ``start`` has x and v at
    time 0 of one path, or of each.  The other arguments are those of `springpot.simulation.kernel.block.block`; written
    are ``record``, (paths, points in time, coordinates, 2), and ``out``, a row for each path: sums of x, x^2, v^2 of
    the coordinates; of u and u^2 of the gauged elongations, and w^2 of the shown; of the power of linear dampers and
    memory, and of the works of sources, nonlinear dampers and noise that multiplies elongations; HITS sums of each wall
    and contact; the squares of tapped modes; energies at the ends of the window; x and v at the end; twice the limits
    on events; and the sums of x^2 and v^2 to the middle of the window.
    """
    n, zero = size.points, q.zero
    z, h, d = _modes(zero), _by_step(zero), _increments(zero)
    g, given = _normals(zero), _given(zero)
    now_x, now_v = _of_points(0.0), _of_points(0.0)
    s = _Lanes(
        _of_points(zero), _of_points(zero), _of_points(zero), _of_points(zero), _of_points(zero), _of_points(zero),
        _of_points(zero), _of_rows(zero), _of_rows(zero), _of_rows(zero), _lane(zero), _of_rows(zero),
        _of_points(zero), _lane(zero), _lane(zero), _of_rows(zero), _of_rows(zero),
    )  # fmt: skip
    terms = _Sums(
        _of_points(zero), _of_points(zero), _of_points(zero), _of_rows(zero), _of_rows(zero), _of_rows(zero),
        _lane(zero), _of_sources(zero),
    )  # fmt: skip
    sums = _Sums(
        _of_points(0.0), _of_points(0.0), _of_points(0.0), _of_rows(0.0), _of_rows(0.0), _of_rows(0.0), _lane(0.0),
        _of_sources(0.0),
    )  # fmt: skip
    early_xx, early_vv = _of_points(0.0), _of_points(0.0)
    peaks = HITS * MOST_WALLS * LANES if observers.on_impacts.size > 0 else 0  # where they begin in the hits
    hits, limits, total = _hits(0.0), _two_lanes(0.0), _lane(0.0)
    energy_first, energy_last, x_end, v_end = _lane(0.0), _lane(0.0), _of_points(0.0), _of_points(0.0)
    x, v = _few(0.0), _few(0.0)
    shown_x, shown_v, tapped = _shown(0.0), _shown(0.0), _of_taps(0.0)
    who, risen, last = lane_numbers(u32(0)), _lane(0.0), _lane(0.0)
    forcing = Forcing(_of_sources(zero), terms.works, given, _states(zero), _four(zero), g)
    one, old, leant = typed(1.0, zero), _of_points(zero), _of_walls(0.0)
    now = State(now_x, now_v)
    lanes = (n, size.rows, now, now, d, h, z, size.modes, forcing, risen, last)
    for number in range(blocks):
        row = number * LANES
        name_paths(branches, first, row, who)
        births = t_0 = opened(branches, row, lanes)
        _clear(size, sums, 0.0)
        _set(hits, (HITS + 1) * MOST_WALLS, 0.0)
        _set(limits, 2, 0.0)
        _set(leant, size.walls, 0.0)
        _set(tapped, size.taps, 0.0)
        _set(z, size.modes, zero)
        _set(h, GROUP * size.rows, zero)
        _set(d, (GROUP + 2) * size.rows, zero)
        for lane in range(LANES):
            path = (number * LANES + lane) % start.shape[0]
            _begin(
                size, exact, start, path, now_x, now_v, s, d, hits, limits, x, v, lane, 1.0 if low == 0 < high else 0.0,
                observers, forcing.state, leant,
            )  # fmt: skip
            for i in range(n):
                x[i], v[i] = start[path, i], start[path, n + i]
            energy_first[lane] = energy_last[lane] = energy_of(size, exact, x, v)
        _set(early_xx, n, 0.0)
        _set(early_vv, n, 0.0)
        _set(x_end, n, np.nan)
        _set(v_end, n, np.nan)
        _wake_sources(size, sources, who, stream, k0, k1, forcing)
        wake_dampers(size, q, forcing)
        for t in range(t_0, steps, GROUP):
            births = birth(branches, t, births, row, steps, lanes)
            if t % (GROUP * STOP_EVERY) == 0 and stop[0] != 0:
                return
            for i in range(n * LANES if t == middle(low, high) else 0):
                early_xx[i], early_vv[i] = sums.xx[i], sums.vv[i]
            for r in range(size.noises + size.shaken):
                own = beyond(g, r * GROUP * LANES)
                draw_for_steps(t // GROUP, who, stream, r, k0, k1, halved, own, forcing.normals)
            _supply_sources(size, sources, t // GROUP, who, stream, k0, k1, forcing)
            for i in range(n * LANES):
                s.x0[i], s.v[i] = now_x[i], now_v[i]
                s.moved[i] = s.gained[i] = zero
            for e in range(size.rows):
                _along(exact, e, now_x, total, beyond(s.u, e * LANES))
                _along(exact, e, now_v, total, beyond(s.w, e * LANES))
            _clear(size, terms, zero)
            in_window = low < t + GROUP and t < high
            watched = in_window and observers.on_steps.size > 0
            for j in range(GROUP):
                step = t + j
                within, next_within = low <= step < high, low <= step + 1 < high
                marked = step == low - 1 or step == high - 1 or step == steps - 1
                shown = marked or watched or record.shape[0] > 0
                weight = one if within else zero
                damp_before(size, q, s, hits, forcing, step, weight, no())
                _gather(size, q, j, g, given, s)
                _shake(size, q, j, step, g, forcing, s, weight)
                _work(size, q, j, given, s, weight, terms)
                _pull(size, q, memories, j, h, d, s)
                press(size, q, s, hits, peaks, f64(weight))
                if size.resting > 0:
                    _set(leant, size.walls, 0.0)
                    for i in range(n * LANES):
                        old[i] = s.v[i]
                _kick(size, q, s, weight if size.resting == 0 else zero, terms)
                if size.resting > 0:
                    _hold(size, exact, now_x, now_v, s, hits, forcing.state, leant, x, v, f64(weight))
                    _move(size, s, old, weight, terms)
                _work(size, q, j, given, s, weight, terms)
                _speeds(size, q, s, weight, terms)
                felt = (watched or record.shape[0] > 0) and observers.feels.size > 0
                for i in range(size.rows * LANES if felt else 0):
                    s.kicked[i], s.middle[i] = s.u[i], s.w[i]
                _stretch(size, q, s, d, j, weight, terms)
                if felt:
                    _feel(size, q, s, j, observers, given, forcing.state, shown_x)
                damp_later(size, q, s, d, j, hits, forcing, step, weight, yes())
                if size.resting > 0 and size.dampers > 0:
                    _hold(size, exact, now_x, now_v, s, hits, forcing.state, leant, x, v, f64(weight))
                if shown:
                    for i in range(n * LANES):
                        s.seen_v[i] = s.v[i]
                if size.walls > 0 and _clearance(size, q, s, forcing.state, leant) > 0:
                    for lane in range(LANES):
                        if s.clear[lane] <= zero and size.resting > 0:
                            repair_or_rest(
                                size, exact, now_x, now_v, s, d, j, given, hits, limits, x, v, lane,
                                1.0 if within else 0.0, 1.0 if next_within else 0.0, observers, forcing.state, leant,
                            )  # fmt: skip
                        elif s.clear[lane] <= zero:
                            repair(
                                size, exact, now_x, now_v, s, d, j, given, hits, limits, x, v, lane,
                                1.0 if within else 0.0, 1.0 if next_within else 0.0, observers,
                            )  # fmt: skip
                touch(size, q, s, d, j, hits, peaks, f64(weight), observers)
                if watched:
                    _show(size, exact, j, now_x, s, shown_x, shown_v)
                if within:
                    _see(size, s, terms)
                if marked:
                    for lane in range(LANES):
                        for i in range(n):
                            x[i] = now_x[i * LANES + lane] + f64(s.seen[i * LANES + lane])
                            v[i] = s.seen_v[i * LANES + lane]
                            x_end[i * LANES + lane], v_end[i * LANES + lane] = x[i], v[i]
                        energy = energy_of(size, exact, x, v)
                        energy_first[lane] = energy if step == low - 1 else energy_first[lane]
                        energy_last[lane] = energy if step == high - 1 else energy_last[lane]
                if record.shape[0] > 0 and step < steps and (step + 1) % every == 0:
                    for lane in range(record.shape[0]):
                        for i in range(n):
                            record[lane, (step + 1) // every, i, 0] = now_x[i * LANES + lane] + f64(
                                s.seen[i * LANES + lane]
                            )
                            record[lane, (step + 1) // every, i, 1] = s.seen_v[i * LANES + lane]
                for lane in range(record.shape[0] if step < steps else 0):
                    record_felt(observers, n + size.rows, shown_x, t, j, every, lane)
            for i in range(n * LANES):
                now_x[i] += s.moved[i]
            for i in range(n * LANES):
                now_v[i] += s.gained[i]
            for e in range(size.rows):
                if memories.count[e] > 0:
                    _remember(
                        z, memories.begin[e] * LANES, d, 6 * e * LANES, h, GROUP * e * LANES, memories.count[e],
                        memories.powers, memories.weights, memories.table[e],
                    )  # fmt: skip
                    turn(
                        z, (memories.begin[e] + memories.count[e]) * LANES, d, 6 * e * LANES, h, GROUP * e * LANES,
                        memories.turned[e], memories.turns, memories.turned_table[e],
                    )  # fmt: skip
                for i in range(6 * e * LANES, (6 * e + 2) * LANES):
                    d[i] = d[i + GROUP * LANES]
            if low <= t + GROUP - 1 < high:
                for k in range(size.taps):
                    for lane in range(LANES):
                        mode = f64(z[memories.tapped[k] * LANES + lane])
                        tapped[k * LANES + lane] += mode * mode
            if watched:
                at = (size.points + size.rows) * GROUP * LANES
                for lane in range(LANES):
                    shown_v[at + lane] = terms.power[lane]
                for i in range((size.sources + size.dampers + size.shaken) * LANES):
                    shown_v[at + LANES + i] = terms.works[i]
                show_steps(observers, shown_x, shown_v, exact.step, t, low, high)
            if in_window:
                _add(sums.x, terms.x, n)
                _add(sums.xx, terms.xx, n)
                _add(sums.vv, terms.vv, n)
                _add(sums.u, terms.u, size.gauged)
                _add(sums.uu, terms.uu, size.gauged)
                _add(sums.ww, terms.ww, size.shown)
                _add(sums.power, terms.power, 1)
                _add(sums.works, terms.works, size.sources + size.dampers + size.shaken)
            keep(branches, t + GROUP, no(), row, steps, lanes)
        closed(branches, row)
        for lane in range(LANES):
            row, column = number * LANES + lane, 0
            column = _write(out, row, column, sums.x, n, lane)
            column = _write(out, row, column, sums.xx, n, lane)
            column = _write(out, row, column, sums.vv, n, lane)
            column = _write(out, row, column, sums.u, size.gauged, lane)
            column = _write(out, row, column, sums.uu, size.gauged, lane)
            column = _write(out, row, column, sums.ww, size.shown, lane)
            column = _write(out, row, column, sums.power, 1, lane)
            column = _write(out, row, column, sums.works, size.sources + size.dampers + size.shaken, lane)
            column = _write(out, row, column, hits, HITS * (size.walls + size.contacts), lane)
            column = _write(out, row, column, tapped, size.taps, lane)
            column = _write(out, row, column, energy_first, 1, lane)
            column = _write(out, row, column, energy_last, 1, lane)
            column = _write(out, row, column, x_end, n, lane)
            column = _write(out, row, column, v_end, n, lane)
            column = _write(out, row, column, limits, 2, lane)
            column = _write(out, row, column, early_xx, n, lane)
            column = _write(out, row, column, early_vv, n, lane)


@njit(**INLINE)
def _write(out, row, column, array, count, lane):
    for i in range(count):
        out[row, column + i] = array[i * LANES + lane]
    return column + count
