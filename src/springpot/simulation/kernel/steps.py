"""Four steps of the lanes of a block: of all lanes at once, and of one lane again with every impact.

The sweep over all lanes compiles to vector code, in single precision where the parts allow it.  It goes as if there
were no wall, or, where impacts are many, with those that vector code can find.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, LINKED, f64, greater, lesser, no, typed, yes
from springpot.simulation.kernel.questions import (
    bounce,
    clearance,
    damp,
    drift,
    held_by,
    kick,
    meet,
    push,
    slots,
    stay,
)  # fmt: skip


class State(NamedTuple):
    """Lane arrays of a state, or of its changes."""

    x: Any
    v: Any


class Glimpse(NamedTuple):
    """Lane arrays of what is seen in four steps: the state after each, and in its kick x, the damping force, and the
    mean velocity.
    """

    x: Any
    v: Any
    at: Any
    pull: Any
    middle: Any


class Struck(NamedTuple):
    """The impacts of a group: speeds by half step and lane, 0 for none, and sums by lane, at the two walls."""

    low: Any
    high: Any
    low_count: Any
    low_speeds: Any
    low_squares: Any
    high_count: Any
    high_speeds: Any
    high_squares: Any


class Sums(NamedTuple):
    """Lane arrays of sums over steps."""

    x: Any
    xx: Any
    vv: Any
    force: Any
    power: Any
    virial: Any


@njit(**INLINE)
def _known_forces(m, p, h, d, lane):
    """The memory force in four steps, without what the steps' own increments add to it."""
    d1 = d[LANES + lane]
    return (
        h[lane] + m.newest * d1 + m.older * d[lane] + p[0],
        h[LANES + lane] + m.recent1 * d1 + p[1],
        h[2 * LANES + lane] + m.recent2 * d1 + p[2],
        h[3 * LANES + lane] + m.recent3 * d1 + p[3],
    )


@njit(**INLINE)
def _kick(scheme, load, n, x, v, memory_force, g, forcing, at, lane, weight, watched):
    """The kick of one step of one lane: change of the velocity, force of springpots and dashpots, mean velocity."""
    before = damp(load, 0, n, x, v, forcing, lane, weight, no())
    damped = v + before
    noise, force = push(load, 0, n, x, damped, typed(g[at], x), forcing, at, lane, weight)
    impulse, pull = kick(scheme, x, damped, typed(memory_force, x), noise + force)
    middle = damped + typed(0.5, x) * impulse
    if watched:
        for slot in range(slots(load)):
            forcing.works[slot * LANES + lane] += weight * middle * forcing.impulses[slot * LANES + lane]
    after = damp(load, 0, n, x, damped + impulse, forcing, lane, weight, yes())
    return before + impulse + after, pull, middle


@njit(**INLINE)
def _quick_step(
    parts, n, x0, v0, moved, gained, memory_force, g, forcing, at, d, struck, sums, hits, lane, watched, crowded
):
    """One step of one lane in vector code, from x0 + moved, v0 + gained; with impacts if ``crowded``.

    The increment is written to ``d``.  Returns the changes since the beginning of the group, the increment in the
    precision of the memory, the observed state, whether no impact is missed, and the sums of the group, over steps and
    over impacts.
    """
    x, v = x0 + moved, v0 + gained
    change, pull, middle = _kick(
        parts.scheme, parts.load, n, x, v, memory_force, g, forcing, at, lane, typed(1.0, x), watched
    )
    leaving, sure = v + change, True
    if crowded:
        xm, vm, dx, dv, early, late, sure = meet(parts.scheme, parts.wall, x, leaving)
        place = 2 * at - lane  # two half steps for every step
        struck.low[place], struck.high[place] = early
        struck.low[place + LANES], struck.high[place + LANES] = late
        hits = _with_impacts(_with_impacts(hits, early), late)
    else:
        xm, vm, dx, dv = drift(parts.scheme, x, leaving)
    x_seen, v_seen = x + xm, leaving + vm
    increment = typed(dx, memory_force)
    d[2 * LANES + at] = increment
    if watched:
        sums = (
            sums[0] + x_seen, sums[1] + x_seen * x_seen, sums[2] + v_seen * v_seen,
            sums[3] + pull, sums[4] + pull * middle, sums[5] + pull * x,
        )  # fmt: skip
    seen = x_seen, v_seen, x, pull, middle
    return moved + dx, gained + (change + dv), increment, seen, sure, sums, hits


@njit(**INLINE)
def _with_impacts(hits, speeds):
    """Count, sum of speeds and of their squares, with one more speed (or 0) at either wall."""
    low, high = speeds
    nothing, one = typed(0.0, low), typed(1.0, low)
    return (
        hits[0] + (one if low > nothing else nothing), hits[1] + low, hits[2] + low * low,
        hits[3] + (one if high > nothing else nothing), hits[4] + high, hits[5] + high * high,
    )  # fmt: skip


@njit(**INLINE)
def sweep_lanes(parts, m, p, n, start, change, clear, g, forcing, h, d, seen, struck, terms, watched, crowded):
    """Four steps of every lane: vector code.  The newest increments have their exact weights.

    The memory force is summed in the precision of the memory.  If ``watched``, all steps are taken to be in the window.
    Lanes whose ``clear`` is not above 0 must be advanced again: those that may have struck, or, if ``crowded``, those
    whose impacts vector code cannot find; the speeds of the others are written to ``struck``.
    """
    for lane in range(LANES):
        for slot in range(slots(parts.load)):
            forcing.works[slot * LANES + lane] = parts.zero
        x0, v0 = start.x[lane], start.v[lane]
        f0, f1, f2, f3 = _known_forces(m, p, h, d, lane)
        nothing = parts.zero
        sums = hits = nothing, nothing, nothing, nothing, nothing, nothing
        moved, gained, d0, seen0, sure0, sums, hits = _quick_step(
            parts, n, x0, v0, nothing, nothing, f0,
            g, forcing, lane, d, struck, sums, hits, lane, watched, crowded,
        )  # fmt: skip
        x1 = x0 + moved
        moved, gained, d1, seen1, sure1, sums, hits = _quick_step(
            parts, n + 1, x0, v0, moved, gained, f1 + m.newest * d0,
            g, forcing, LANES + lane, d, struck, sums, hits, lane, watched, crowded,
        )  # fmt: skip
        x2 = x0 + moved
        moved, gained, d2, seen2, sure2, sums, hits = _quick_step(
            parts, n + 2, x0, v0, moved, gained, f2 + m.recent1 * d0 + m.newest * d1,
            g, forcing, 2 * LANES + lane, d, struck, sums, hits, lane, watched, crowded,
        )  # fmt: skip
        x3 = x0 + moved
        moved, gained, _, seen3, sure3, sums, hits = _quick_step(
            parts, n + 3, x0, v0, moved, gained, f3 + m.recent2 * d0 + m.recent1 * d1 + m.newest * d2,
            g, forcing, 3 * LANES + lane, d, struck, sums, hits, lane, watched, crowded,
        )  # fmt: skip
        change.x[lane], change.v[lane] = moved, gained
        if crowded:
            struck.low_count[lane], struck.low_speeds[lane], struck.low_squares[lane] = hits[0], hits[1], hits[2]
            struck.high_count[lane], struck.high_speeds[lane], struck.high_squares[lane] = hits[3], hits[4], hits[5]
            clear[lane] = typed(1.0, moved) if sure0 & sure1 & sure2 & sure3 else parts.zero
        else:
            x4 = x0 + moved
            least = lesser(
                lesser(lesser(x0, seen0[0]), lesser(x1, seen1[0])),
                lesser(lesser(x2, seen2[0]), lesser(x3, lesser(seen3[0], x4))),
            )
            most = greater(
                greater(greater(x0, seen0[0]), greater(x1, seen1[0])),
                greater(greater(x2, seen2[0]), greater(x3, greater(seen3[0], x4))),
            )
            clear[lane] = clearance(parts.scheme, parts.wall, least, most)
        if watched:
            _show(seen, lane, seen0)
            _show(seen, LANES + lane, seen1)
            _show(seen, 2 * LANES + lane, seen2)
            _show(seen, 3 * LANES + lane, seen3)
            _put(terms, lane, sums)


@njit(**INLINE)
def _show(seen, at, values):
    """Write what is seen of one step of a lane."""
    seen.x[at], seen.v[at], seen.at[at], seen.pull[at], seen.middle[at] = values


@njit(**INLINE)
def _put(terms, lane, sums):
    """Write what four steps of a lane add to the sums."""
    terms.x[lane], terms.xx[lane], terms.vv[lane] = sums[0], sums[1], sums[2]
    terms.force[lane], terms.power[lane], terms.virial[lane] = sums[3], sums[4], sums[5]


@njit(**LINKED)
def _kick_at_rest(scheme, wall, load, n, x, side, memory_force, g, forcing, at, lane, weight, accumulators):
    """The kick of a mass that rests on a wall, which is on the ``side`` as `held_by` has it.

    Returns the impulse, the velocity after it, the force of springpots and dashpots, and the mean velocity at which
    forces work.
    """
    before = damp(load, 0, n, x, 0.0, forcing, lane, 0.0, no())
    noise, force = push(load, 0, n, x, 0.0, f64(g[at]), forcing, at, lane, weight)
    impulse, pull = kick(scheme, x, 0.0, f64(memory_force), noise + force)
    moving = before + impulse + damp(load, 0, n, x, before + impulse, forcing, lane, 0.0, yes())
    others = before + damp(load, 0, n, x, 0.0, forcing, lane, 0.0, yes())
    given, left, pull, middle = stay(scheme, wall, side, x, moving, impulse, others, pull, accumulators, lane, weight)
    for slot in range(slots(load)):
        forcing.works[slot * LANES + lane] += weight * middle * forcing.impulses[slot * LANES + lane]
    return given, left, pull, middle


@njit(**INLINE)
def _step(parts, n, x, v, memory_force, g, forcing, at, d, seen, counts, accumulators, sums, lane):
    """One step of one lane with the walls.  Terms of the sums are 0 if ``counts[0]`` is 0."""
    scheme, load, weight = parts.scheme, parts.load, counts[0]
    side = held_by(scheme, parts.wall, x, v)
    if side != 0.0:
        given, left, pull, middle = _kick_at_rest(
            scheme, parts.wall, load, n, x, side, memory_force, g, forcing, at, lane, weight, accumulators
        )
    else:
        given, pull, middle = _kick(scheme, load, n, x, v, memory_force, g, forcing, at, lane, weight, yes())
        left = v + given
    x_seen, v_seen, x_next, v_next = bounce(
        scheme, parts.wall, x, left, given / scheme.step, accumulators, lane, counts[0], counts[1]
    )
    d[2 * LANES + at] = x_next - x
    _show(seen, at, (x_seen, v_seen, x, pull, middle))
    x_counted, pulled = counts[0] * x_seen, counts[0] * pull
    sums = (
        sums[0] + x_counted, sums[1] + x_counted * x_seen, sums[2] + counts[0] * v_seen * v_seen,
        sums[3] + pulled, sums[4] + pulled * middle, sums[5] + pulled * x,
    )  # fmt: skip
    return x_next, v_next, sums


@njit(**INLINE)
def replay(parts, m, p, n, now, g, forcing, h, d, seen, c, accumulators, terms, lane):
    """Four steps of one lane with the walls, in double precision.

    ``c`` is 1 for each step in the window and 0 for the others; its last entry is for the half step after the group.
    """
    for slot in range(slots(parts.load)):
        forcing.works[slot * LANES + lane] = 0.0
    f0, f1, f2, f3 = _known_forces(m, p, h, d, lane)
    sums = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, v, sums = _step(
        parts, n, now.x[lane], now.v[lane], f0, g, forcing, lane, d, seen, (c[0], c[1]), accumulators, sums, lane
    )
    f1 += m.newest * d[2 * LANES + lane]
    x, v, sums = _step(
        parts, n + 1, x, v, f1, g, forcing, LANES + lane, d, seen, (c[1], c[2]), accumulators, sums, lane
    )
    f2 += m.recent1 * d[2 * LANES + lane] + m.newest * d[3 * LANES + lane]
    x, v, sums = _step(
        parts, n + 2, x, v, f2, g, forcing, 2 * LANES + lane, d, seen, (c[2], c[3]), accumulators, sums, lane
    )
    f3 += m.recent2 * d[2 * LANES + lane] + m.recent1 * d[3 * LANES + lane] + m.newest * d[4 * LANES + lane]
    x, v, sums = _step(
        parts, n + 3, x, v, f3, g, forcing, 3 * LANES + lane, d, seen, (c[3], c[4]), accumulators, sums, lane
    )
    now.x[lane], now.v[lane] = x, v
    _put(terms, lane, sums)
