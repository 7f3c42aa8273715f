"""The block kernel: lanes of paths, memory, walls and sums.  It knows no law of physics; the parts do.

Four steps make a group.  In each group every lane is first advanced as if there were no wall, which the compiler turns
into vector code; the few lanes that may have met the wall are then advanced again from the saved state with the impacts
in it.  The memory modes take all four increments in one pass, and inside the group the newest increments count with
their exact weights.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.simulation.cache import cached
from springpot.simulation.lanes import (
    FAST,
    GROUP,
    INLINE,
    LANES,
    MOST_MODES,
    f32,
    f64,
    stack_array,
)
from springpot.simulation.parts import bounce, clearance, drift, kick
from springpot.simulation.random import draw

__all__ = ["COLUMNS", "Memory", "Start", "block"]

# What a block leaves for every path: sums over the steps of the window, then values at instants.
COLUMNS = (
    "x", "x_square", "v_square", "force", "power", "virial",
    "impacts", "impact_speeds", "impact_speed_squares", "collapses",
    "energy_first", "energy_last", "x_end", "v_end",
)  # fmt: skip
STOP_EVERY = 256  # groups between two looks at the stop flag


class Memory(NamedTuple):
    """The springpot's past, in units of force: modes (their powers and weights) and the newest increments."""

    powers: npt.NDArray[np.floating]  # (4 * modes,) a, a^2, a^3, a^4 - 1 of each mode
    weights: npt.NDArray[np.floating]  # (4 * modes,) w a, w a^2, w a^3, w a^4
    newest: np.floating  # weight of the last increment
    older: np.floating  # what the one before weighs beyond its part in the modes
    recent1: np.floating  # weight of the one before without the modes, and so on
    recent2: np.floating
    recent3: np.floating


class Start(NamedTuple):
    """State of every path at the first kick, and what happened before it."""

    x: float
    v: float
    increment: float  # displacement since time 0
    energy: float  # at time 0
    impacts: float
    impact_speeds: float
    impact_speed_squares: float


_state = stack_array(LANES)
_four = stack_array(GROUP * LANES)
_six = stack_array((GROUP + 2) * LANES)
_modes = stack_array(MOST_MODES * LANES)


@njit(**INLINE)
def _remember(z, d, h, modes, powers, weights):
    """Take four increments into every mode, and leave in ``h`` what the modes exert on the next four steps."""
    for i in range(GROUP * LANES):
        h[i] = powers[0] * f32(0)
    for k in range(0, modes, 2):
        # the loss a^4 - 1 instead of a^4: slow modes would lose their rate to the rounding of a number so close to 1
        a1, a2, a3, a_loss = powers[4 * k], powers[4 * k + 1], powers[4 * k + 2], powers[4 * k + 3]
        b1, b2, b3, b_loss = powers[4 * k + 4], powers[4 * k + 5], powers[4 * k + 6], powers[4 * k + 7]
        u1, u2, u3, u4 = weights[4 * k], weights[4 * k + 1], weights[4 * k + 2], weights[4 * k + 3]
        w1, w2, w3, w4 = weights[4 * k + 4], weights[4 * k + 5], weights[4 * k + 6], weights[4 * k + 7]
        i, j = k * LANES, (k + 1) * LANES
        for lane in range(LANES):
            d0, d1, d2, d3 = d[LANES + lane], d[2 * LANES + lane], d[3 * LANES + lane], d[4 * LANES + lane]
            y, q = z[i + lane], z[j + lane]
            y += a_loss * y + a3 * d0 + a2 * d1 + a1 * d2 + d3
            q += b_loss * q + b3 * d0 + b2 * d1 + b1 * d2 + d3
            z[i + lane] = y
            z[j + lane] = q
            h[lane] += u1 * y + w1 * q
            h[LANES + lane] += u2 * y + w2 * q
            h[2 * LANES + lane] += u3 * y + w3 * q
            h[3 * LANES + lane] += u4 * y + w4 * q


@njit(**INLINE)
def _step(scheme, wall, x, v, past, g, at, d, seen, walled, watched):
    """One step of one lane; the increment goes to ``d``, what observers look at to place ``at`` of ``seen``."""
    kicked, pull = kick(scheme, x, v, f64(past), f64(g[at]))
    if walled:
        x_seen, v_seen, x_next, v_next, before, after = bounce(scheme, wall, x, kicked)
    else:
        x_seen, v_seen, x_next, v_next = drift(scheme, x, kicked)
        before = after = (0.0, 0.0, 0.0, 0.0)
    d[2 * LANES + at] = x_next - x
    if watched:
        seen.x[at] = x_seen
        seen.v[at] = v_seen
        seen.x_kick[at] = x
        seen.force[at] = pull
        seen.speed[at] = 0.5 * (v + kicked)
    return x_next, v_next, clearance(scheme, wall, x, x_seen, x_next), before, after


@njit(**INLINE)
def _four_steps(scheme, wall, m, p, x, v, g, h, d, seen, lane, walled, watched):
    """Four steps of one lane: -> x, v, least clearance, impacts before and after each observation.

    The newest increments count with their exact weights; sums of the past are of the type in which memory is kept.
    """
    at = lane
    past = h[at] + m.newest * d[LANES + lane] + m.older * d[lane] + p[0]
    x, v, c0, b0, f0 = _step(scheme, wall, x, v, past, g, at, d, seen, walled, watched)
    at = LANES + lane
    past = h[at] + m.newest * d[2 * LANES + lane] + m.recent1 * d[LANES + lane] + p[1]
    x, v, c1, b1, f1 = _step(scheme, wall, x, v, past, g, at, d, seen, walled, watched)
    at = 2 * LANES + lane
    past = h[at] + m.newest * d[3 * LANES + lane] + m.recent1 * d[2 * LANES + lane]
    past += m.recent2 * d[LANES + lane] + p[2]
    x, v, c2, b2, f2 = _step(scheme, wall, x, v, past, g, at, d, seen, walled, watched)
    at = 3 * LANES + lane
    past = h[at] + m.newest * d[4 * LANES + lane] + m.recent1 * d[3 * LANES + lane]
    past += m.recent2 * d[2 * LANES + lane] + m.recent3 * d[LANES + lane] + p[3]
    x, v, c3, b3, f3 = _step(scheme, wall, x, v, past, g, at, d, seen, walled, watched)
    return x, v, min(min(c0, c1), min(c2, c3)), (b0, b1, b2, b3), (f0, f1, f2, f3)


@njit(**INLINE)
def _sweep(scheme, wall, memory, p, x, v, x_saved, v_saved, clear, g, h, d, seen, watched):
    """Four steps of every lane as if there were no wall: vector code."""
    for lane in range(LANES):
        x_saved[lane], v_saved[lane] = x[lane], v[lane]
        x[lane], v[lane], clear[lane], _, _ = _four_steps(
            scheme, wall, memory, p, x[lane], v[lane], g, h, d, seen, lane, False, watched
        )


@njit(**INLINE)
def _count(n, low, high, happened, hits, lane):
    """Add impacts that belong to step ``n`` to the sums of the window; collapses count over the whole run."""
    hits.collapses[lane] += happened[3]
    if happened[0] > 0.0 and low <= n < high:
        hits.impacts[lane] += happened[0]
        hits.speeds[lane] += happened[1]
        hits.squares[lane] += happened[2]


@njit(**INLINE)
def _draw(group, first, stream, k0, k1, halved, g, fine):
    """The normals of four steps; if ``halved``, of steps that are pairs of the steps of a run twice as fine."""
    if not halved:
        draw(group, first, stream, k0, k1, g)
        return
    for half in range(2):
        draw(2 * group + half, first, stream, k0, k1, fine)
        for i in range(2 * LANES):
            pair = i // LANES * 2 * LANES + i % LANES
            g[2 * half * LANES + i] = f32(0.7071067811865476) * (fine[pair] + fine[pair + LANES])


class Seen(NamedTuple):
    """Lane arrays of what observers look at."""

    x: Any
    v: Any
    x_kick: Any
    force: Any
    speed: Any


class Sums(NamedTuple):
    """Lane arrays of the sums over the window."""

    x: Any
    xx: Any
    vv: Any
    force: Any
    power: Any
    virial: Any


class Hits(NamedTuple):
    """Lane arrays of impacts in the window."""

    impacts: Any
    speeds: Any
    squares: Any
    collapses: Any


@njit(**INLINE)
def _add(sums, seen, lane, at):
    """Add one observation to the sums of the window."""
    x, v, force = seen.x[at], seen.v[at], seen.force[at]
    sums.x[lane] += x
    sums.xx[lane] += x * x
    sums.vv[lane] += v * v
    sums.force[lane] += force
    sums.power[lane] += force * seen.speed[at]
    sums.virial[lane] += force * seen.x_kick[at]


@cached
@njit(nogil=True, **FAST)
def block(
    scheme, wall, memory, drive, start, stiffness, first, steps, low, high, k0, k1, stream, halved, record, stop, out
):
    """Advance the paths ``first`` .. ``first + LANES`` by ``steps`` steps.

    Step n (from 0) ends with the observation at time (n + 1) h; sums run over low <= n < high.  ``drive`` holds the
    deterministic force of each step (empty: none), ``halved`` says that the noise
    is that of a run twice as fine, ``record`` takes x and v of the first paths at every observation (empty: none),
    ``stop`` holds a flag that ends the block early, ``out`` takes one row of COLUMNS per lane.
    """
    zero = memory.newest * f32(0)  # of the type in which memory is kept
    modes = memory.powers.size // 4
    z = _modes(zero)
    h = _four(zero)
    d = _six(zero)  # the two increments before the group, then the group's four
    p = (zero, zero, zero, zero)
    g, fine = _four(f32(0)), _four(f32(0))
    x, v, x_saved, v_saved, clear = _state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0)
    seen = Seen(_four(0.0), _four(0.0), _four(0.0), _four(0.0), _four(0.0))
    sums = Sums(_state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0))
    hits = Hits(_state(0.0), _state(0.0), _state(0.0), _state(0.0))
    energy_first, energy_last, x_end, v_end = _state(0.0), _state(0.0), _state(0.0), _state(0.0)
    for i in range(modes * LANES):
        z[i] = zero
    for i in range(GROUP * LANES):
        h[i] = zero
    early = 1.0 if low == 0 else 0.0
    for lane in range(LANES):
        x[lane], v[lane], d[lane], d[LANES + lane] = start.x, start.v, zero, start.increment
        sums.x[lane] = sums.xx[lane] = sums.vv[lane] = 0.0
        sums.force[lane] = sums.power[lane] = sums.virial[lane] = 0.0
        hits.impacts[lane] = early * start.impacts
        hits.speeds[lane] = early * start.impact_speeds
        hits.squares[lane] = early * start.impact_speed_squares
        hits.collapses[lane] = 0.0
        energy_first[lane] = energy_last[lane] = start.energy
        x_end[lane] = v_end[lane] = np.nan
    for n in range(0, steps, GROUP):
        if n % (GROUP * STOP_EVERY) == 0 and stop[0] != 0:
            return
        _draw(n // GROUP, first, stream, k0, k1, halved, g, fine)
        if drive.size > 0:
            p = (drive[n], drive[n + 1], drive[n + 2], drive[n + 3])
        if (n + GROUP >= low and n < high) or n + GROUP >= steps or record.shape[0] > 0:
            _sweep(scheme, wall, memory, p, x, v, x_saved, v_saved, clear, g, h, d, seen, True)
        else:
            _sweep(scheme, wall, memory, p, x, v, x_saved, v_saved, clear, g, h, d, seen, False)
        least = clear[0]
        for lane in range(LANES):
            least = min(least, clear[lane])
        if least <= 0.0:
            for lane in range(LANES):
                if clear[lane] <= 0.0:
                    x[lane], v[lane], _, before, after = _four_steps(
                        scheme, wall, memory, p, x_saved[lane], v_saved[lane], g, h, d, seen, lane, True, True
                    )
                    for j in range(GROUP):
                        _count(n + j, low, high, before[j], hits, lane)
                        _count(n + j + 1, low, high, after[j], hits, lane)
        if modes > 0:
            _remember(z, d, h, modes, memory.powers, memory.weights)
        for lane in range(LANES):
            d[lane], d[LANES + lane] = d[GROUP * LANES + lane], d[(GROUP + 1) * LANES + lane]
        if low <= n and n + GROUP <= high:
            for lane in range(LANES):
                for j in range(GROUP):
                    _add(sums, seen, lane, j * LANES + lane)
        elif n + GROUP > low and n < high:
            for j in range(max(low - n, 0), min(high - n, GROUP)):
                for lane in range(LANES):
                    _add(sums, seen, lane, j * LANES + lane)
        for j in range(GROUP):
            if n + j == low - 1 or n + j == high - 1 or n + j == steps - 1:
                for lane in range(LANES):
                    x_end[lane], v_end[lane] = seen.x[j * LANES + lane], seen.v[j * LANES + lane]
                    energy = 0.5 * (v_end[lane] * v_end[lane] + stiffness * x_end[lane] * x_end[lane])
                    energy_first[lane] = energy if n + j == low - 1 else energy_first[lane]
                    energy_last[lane] = energy if n + j == high - 1 else energy_last[lane]
        for lane in range(record.shape[0]):
            for j in range(min(GROUP, steps - n)):
                record[lane, n + j + 1, 0] = seen.x[j * LANES + lane]
                record[lane, n + j + 1, 1] = seen.v[j * LANES + lane]
    for lane in range(LANES):
        out[lane, 0], out[lane, 1], out[lane, 2] = sums.x[lane], sums.xx[lane], sums.vv[lane]
        out[lane, 3], out[lane, 4], out[lane, 5] = sums.force[lane], sums.power[lane], sums.virial[lane]
        out[lane, 6], out[lane, 7], out[lane, 8] = hits.impacts[lane], hits.speeds[lane], hits.squares[lane]
        out[lane, 9], out[lane, 10], out[lane, 11] = hits.collapses[lane], energy_first[lane], energy_last[lane]
        out[lane, 12], out[lane, 13] = x_end[lane], v_end[lane]
