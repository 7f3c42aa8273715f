"""The block kernel: lanes of paths, memory, walls and sums.  It knows no law of physics; the parts do.

Four steps make a group.  In each group every lane is first advanced as if there were no wall, which the compiler turns
into vector code; the few lanes that may have met the wall are then advanced again from the saved state with the impacts
in it.  The memory modes take all four increments in one pass, and inside the group the newest increments count with
their exact weights.
"""

from __future__ import annotations

from typing import NamedTuple

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
    i32,
    stack_array,
)
from springpot.simulation.parts import bounce, drift, kick, struck
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

    powers: npt.NDArray[np.floating]  # (4 * modes,) a, a^2, a^3, a^4 of each mode
    weights: npt.NDArray[np.floating]  # (4 * modes,) w a, w a^2, w a^3, w a^4
    newest: float  # weight of the last increment
    recent1: float  # of the one before, and so on
    recent2: float
    recent3: float


class Start(NamedTuple):
    """State of every path at the first kick, and what happened before it."""

    x: float
    v: float
    increment: float  # displacement since time 0
    energy: float  # at time 0
    x0: float  # displacement at time 0, the factor of ``drive``
    impacts: float
    impact_speeds: float
    impact_speed_squares: float


_state = stack_array(LANES)
_flags = stack_array(LANES)
_four = stack_array(GROUP * LANES)
_modes = stack_array(MOST_MODES * LANES)


@njit(**INLINE)
def _remember(z, d, h, modes, powers, weights):
    """Take four increments into every mode, and leave in ``h`` what the modes exert on the next four steps."""
    for i in range(GROUP * LANES):
        h[i] = powers[0] * f32(0)
    for k in range(0, modes, 2):
        a1, a2, a3, a4 = powers[4 * k], powers[4 * k + 1], powers[4 * k + 2], powers[4 * k + 3]
        b1, b2, b3, b4 = powers[4 * k + 4], powers[4 * k + 5], powers[4 * k + 6], powers[4 * k + 7]
        u1, u2, u3, u4 = weights[4 * k], weights[4 * k + 1], weights[4 * k + 2], weights[4 * k + 3]
        w1, w2, w3, w4 = weights[4 * k + 4], weights[4 * k + 5], weights[4 * k + 6], weights[4 * k + 7]
        i, j = k * LANES, (k + 1) * LANES
        for lane in range(LANES):
            d0, d1, d2, d3 = d[lane], d[LANES + lane], d[2 * LANES + lane], d[3 * LANES + lane]
            y = a4 * z[i + lane] + a3 * d0 + a2 * d1 + a1 * d2 + d3
            q = b4 * z[j + lane] + b3 * d0 + b2 * d1 + b1 * d2 + d3
            z[i + lane] = y
            z[j + lane] = q
            h[lane] += u1 * y + w1 * q
            h[LANES + lane] += u2 * y + w2 * q
            h[2 * LANES + lane] += u3 * y + w3 * q
            h[3 * LANES + lane] += u4 * y + w4 * q


@njit(**INLINE)
def _step(scheme, wall, x, v, past, g, walled, at, xm, vm, xk, force, speed):
    """One step of one lane; leaves what observers look at in place ``at`` of the five lane arrays."""
    after_kick, pull = kick(scheme, x, v, past, g)
    if walled:
        x_seen, v_seen, x_next, v_next, before, after = bounce(scheme, wall, x, after_kick)
    else:
        x_seen, v_seen, x_next, v_next = drift(scheme, x, after_kick)
        before = after = (0.0, 0.0, 0.0, 0.0)
    xm[at] = x_seen
    vm[at] = v_seen
    xk[at] = x
    force[at] = pull
    speed[at] = 0.5 * (v + after_kick)
    return x_next, v_next, x_next - x, struck(scheme, wall, x_seen, x_next, v_next), before, after


@njit(**INLINE)
def _four_steps(scheme, wall, m, x, v, e, h, g, p0, p1, p2, p3, lane, walled, xm, vm, xk, force, speed):
    """Four steps of one lane: -> x, v, the four increments, was it struck, impacts before/after each observation."""
    at = lane
    past = f64(h[at]) + m.newest * e + p0
    x, v, d0, s0, b0, f0 = _step(scheme, wall, x, v, past, f64(g[at]), walled, at, xm, vm, xk, force, speed)
    at = LANES + lane
    past = f64(h[at]) + m.newest * d0 + m.recent1 * e + p1
    x, v, d1, s1, b1, f1 = _step(scheme, wall, x, v, past, f64(g[at]), walled, at, xm, vm, xk, force, speed)
    at = 2 * LANES + lane
    past = f64(h[at]) + m.newest * d1 + m.recent1 * d0 + m.recent2 * e + p2
    x, v, d2, s2, b2, f2 = _step(scheme, wall, x, v, past, f64(g[at]), walled, at, xm, vm, xk, force, speed)
    at = 3 * LANES + lane
    past = f64(h[at]) + m.newest * d2 + m.recent1 * d1 + m.recent2 * d0 + m.recent3 * e + p3
    x, v, d3, s3, b3, f3 = _step(scheme, wall, x, v, past, f64(g[at]), walled, at, xm, vm, xk, force, speed)
    return x, v, d0, d1, d2, d3, s0 | s1 | s2 | s3, b0, f0, b1, f1, b2, f2, b3, f3


@njit(**INLINE)
def _count(n, low, high, happened, impacts, speeds, squares, collapses, lane):
    """Add impacts that belong to step ``n`` to the sums of the window; collapses count over the whole run."""
    collapses[lane] += happened[3]
    if happened[0] > 0.0 and low <= n < high:
        impacts[lane] += happened[0]
        speeds[lane] += happened[1]
        squares[lane] += happened[2]


@cached
@njit(nogil=True, **FAST)
def block(scheme, wall, memory, drive, start, stiffness, first, steps, low, high, k0, k1, stream, record, stop, out):
    """Advance the paths ``first`` .. ``first + LANES`` by ``steps`` steps.

    Step n (from 0) ends with the observation at time (n + 1) h; sums run over low <= n < high.  ``drive`` holds the
    deterministic force of each step per unit of the initial displacement (empty: none), ``record`` takes x and v of the
    first paths at every observation (empty: none), ``stop`` holds a flag that ends the block early, ``out`` takes one
    row of COLUMNS per lane.
    """
    zero = memory.powers[0] * f32(0)  # of the type in which memory is kept
    modes = memory.powers.size // 4
    z = _modes(zero)
    h = _four(zero)
    d = _four(zero)
    g = _four(f32(0))
    flag = _flags(i32(0))
    x, v, e = _state(0.0), _state(0.0), _state(0.0)
    x_saved, v_saved, e_saved = _state(0.0), _state(0.0), _state(0.0)
    xm, vm, xk, force, speed = _four(0.0), _four(0.0), _four(0.0), _four(0.0), _four(0.0)
    sx, sxx, svv, sf, sp, sw = _state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0)
    impacts, speeds, squares, collapses = _state(0.0), _state(0.0), _state(0.0), _state(0.0)
    energy_first, energy_last, x_end, v_end = _state(0.0), _state(0.0), _state(0.0), _state(0.0)
    for i in range(modes * LANES):
        z[i] = zero
    for i in range(GROUP * LANES):
        h[i] = zero
    for lane in range(LANES):
        x[lane], v[lane], e[lane] = start.x, start.v, start.increment
        sx[lane] = sxx[lane] = svv[lane] = sf[lane] = sp[lane] = sw[lane] = 0.0
        early = 1.0 if low == 0 else 0.0
        impacts[lane] = early * start.impacts
        speeds[lane] = early * start.impact_speeds
        squares[lane] = early * start.impact_speed_squares
        collapses[lane] = 0.0
        energy_first[lane] = energy_last[lane] = start.energy
        x_end[lane] = v_end[lane] = np.nan
    p0 = p1 = p2 = p3 = 0.0
    for n in range(0, steps, GROUP):
        if n % (GROUP * STOP_EVERY) == 0 and stop[0] != 0:
            return
        draw(n // GROUP, first, stream, k0, k1, g)
        if drive.size > 0:
            p0, p1 = start.x0 * drive[n], start.x0 * drive[n + 1]
            p2, p3 = start.x0 * drive[n + 2], start.x0 * drive[n + 3]
        any_struck = i32(0)
        for lane in range(LANES):
            xn, vn, d0, d1, d2, d3, s, b0, f0, b1, f1, b2, f2, b3, f3 = _four_steps(
                scheme, wall, memory, x[lane], v[lane], e[lane], h, g, p0, p1, p2, p3, lane, False,
                xm, vm, xk, force, speed,
            )  # fmt: skip
            x_saved[lane], v_saved[lane], e_saved[lane] = x[lane], v[lane], e[lane]
            d[lane], d[LANES + lane], d[2 * LANES + lane], d[3 * LANES + lane] = e[lane], d0, d1, d2
            x[lane], v[lane], e[lane] = xn, vn, d3
            flag[lane] = i32(1) if s else i32(0)
            any_struck |= flag[lane]
        if any_struck != 0:
            for lane in range(LANES):
                if flag[lane] != 0:
                    xn, vn, d0, d1, d2, d3, s, b0, f0, b1, f1, b2, f2, b3, f3 = _four_steps(
                        scheme, wall, memory, x_saved[lane], v_saved[lane], e_saved[lane], h, g, p0, p1, p2, p3, lane,
                        True, xm, vm, xk, force, speed,
                    )  # fmt: skip
                    x[lane], v[lane], e[lane] = xn, vn, d3
                    d[LANES + lane], d[2 * LANES + lane], d[3 * LANES + lane] = d0, d1, d2
                    _count(n, low, high, b0, impacts, speeds, squares, collapses, lane)
                    _count(n + 1, low, high, f0, impacts, speeds, squares, collapses, lane)
                    _count(n + 1, low, high, b1, impacts, speeds, squares, collapses, lane)
                    _count(n + 2, low, high, f1, impacts, speeds, squares, collapses, lane)
                    _count(n + 2, low, high, b2, impacts, speeds, squares, collapses, lane)
                    _count(n + 3, low, high, f2, impacts, speeds, squares, collapses, lane)
                    _count(n + 3, low, high, b3, impacts, speeds, squares, collapses, lane)
                    _count(n + 4, low, high, f3, impacts, speeds, squares, collapses, lane)
        if modes > 0:
            _remember(z, d, h, modes, memory.powers, memory.weights)
        if low <= n and n + GROUP <= high:
            for lane in range(LANES):
                for j in range(GROUP):
                    at = j * LANES + lane
                    sx[lane] += xm[at]
                    sxx[lane] += xm[at] * xm[at]
                    svv[lane] += vm[at] * vm[at]
                    sf[lane] += force[at]
                    sp[lane] += force[at] * speed[at]
                    sw[lane] += force[at] * xk[at]
        elif n + GROUP > low and n < high:
            for j in range(max(low - n, 0), min(high - n, GROUP)):
                for lane in range(LANES):
                    at = j * LANES + lane
                    sx[lane] += xm[at]
                    sxx[lane] += xm[at] * xm[at]
                    svv[lane] += vm[at] * vm[at]
                    sf[lane] += force[at]
                    sp[lane] += force[at] * speed[at]
                    sw[lane] += force[at] * xk[at]
        for j in range(GROUP):
            if n + j == low - 1 or n + j == high - 1 or n + j == steps - 1:
                for lane in range(LANES):
                    at = j * LANES + lane
                    energy = 0.5 * (vm[at] * vm[at] + stiffness * xm[at] * xm[at])
                    energy_first[lane] = energy if n + j == low - 1 else energy_first[lane]
                    energy_last[lane] = energy if n + j == high - 1 else energy_last[lane]
                    x_end[lane] = xm[at]
                    v_end[lane] = vm[at]
        for lane in range(record.shape[0]):
            for j in range(min(GROUP, steps - n)):
                record[lane, n + j + 1, 0] = xm[j * LANES + lane]
                record[lane, n + j + 1, 1] = vm[j * LANES + lane]
    for lane in range(LANES):
        out[lane, 0], out[lane, 1], out[lane, 2] = sx[lane], sxx[lane], svv[lane]
        out[lane, 3], out[lane, 4], out[lane, 5] = sf[lane], sp[lane], sw[lane]
        out[lane, 6], out[lane, 7], out[lane, 8] = impacts[lane], speeds[lane], squares[lane]
        out[lane, 9], out[lane, 10], out[lane, 11] = collapses[lane], energy_first[lane], energy_last[lane]
        out[lane, 12], out[lane, 13] = x_end[lane], v_end[lane]
