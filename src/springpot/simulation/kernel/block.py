"""The block kernel: it advances blocks of paths.  The physics is in `springpot.simulation.kernel.questions`.

Four steps make a group.  In each group every lane is first advanced as if there were no wall, which compiles to vector
code: the sweep, which finds the changes of the state in single precision where the parts allow it.  The few lanes that
may have reached the wall are then advanced again in double precision, with impacts.  Then the changes are added to the
state, which is in double precision.  The memory modes are updated once per group; within the group the newest
increments have their exact weights.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.simulation.kernel.branches import birth, closed, keep, may_be_crowded, name_paths, opened
from springpot.simulation.kernel.cache import cached
from springpot.simulation.kernel.felt import MOST_FELT, feel, record_felt
from springpot.simulation.kernel.lanes import (
    ENTRY,
    GROUP,
    INLINE,
    LANES,
    MOST_EXTRAS,
    MOST_FORCES,
    MOST_MODES,
    MOST_STATES,
    SPARE,
    beyond,
    f32,
    f64,
    lesser,
    middle,
    no,
    stack_array,
    u32,
    yes,
)
from springpot.simulation.kernel.questions import Forcing, begin, extras, gather, in_lanes, limited, slots, supply, wake
from springpot.simulation.kernel.random import draw_for_steps, lane_numbers
from springpot.simulation.kernel.steps import Glimpse, State, Struck, Sums, replay, sweep_lanes
from springpot.simulation.kernel.turning import NUMBERS, turn
from springpot.simulation.kernel.watching import Accumulators, is_seen, show_steps

# Output of a block for every path: sums over the steps of the window, then values at instants.  After them come the
# works of the named forces and the sums that the wall keeps beside these.  The early ones are sums to the middle of the
# window.
COLUMNS = (
    "x", "x_square", "v_square", "force", "power", "virial",
    "impacts", "impact_speeds", "impact_speed_squares", "collapses",
    "energy_first", "energy_last", "x_end", "v_end", "x_square_early", "v_square_early",
)  # fmt: skip
STOP_EVERY = 256  # groups between two checks of the stop flag
# Lanes with impacts in a group from which on the next group has them in its sweep, and below which no longer.
MANY, FEW = 4, 2


class Memory(NamedTuple):
    """Weights of the springpot's memory, in units of force: of the modes and of the newest increments."""

    powers: npt.NDArray[np.floating]  # (4 * modes,) a, a^2, a^3, a^4 - 1 of each mode
    weights: npt.NDArray[np.floating]  # (4 * modes,) w a, w a^2, w a^3, w a^4
    newest: np.floating  # weight of the last increment
    older: np.floating  # extra weight of the one before it, which is in the modes already
    recent1: np.floating  # full weight of the one before the last, which is not in the modes yet; and so on
    recent2: np.floating
    recent3: np.floating
    turns: npt.NDArray[np.floating]  # (NUMBERS * modes,) of circuits with a coil, as `turning.turn` has them


def modes_of(memory: Memory) -> int:
    """How many numbers it keeps of a path."""
    return memory.powers.size // 4 + 2 * (memory.turns.size // NUMBERS)


_state = stack_array(LANES)
_four = stack_array(GROUP * LANES)
_shown = stack_array((1 + MOST_FELT) * GROUP * LANES)
_eight = stack_array(2 * GROUP * LANES)
_six = stack_array((GROUP + 2) * LANES)
_modes = stack_array(MOST_MODES * LANES)
_by_force = stack_array(MOST_FORCES * LANES)
_by_force_and_step = stack_array((SPARE + 1) * GROUP * LANES)
_states = stack_array(MOST_STATES * LANES)
_extras = stack_array(MOST_EXTRAS * LANES)


@njit(**INLINE)
def _remember(z, d, h, modes, powers, weights):
    """Add four increments to every mode, and write the force of the modes in the next four steps to ``h``."""
    for i in range(GROUP * LANES):
        h[i] = powers[0] * f32(0)
    for k in range(0, modes, 2):
        # a^4 - 1 is stored, not a^4: for slow modes a^4 rounds to 1
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
def _add(sums, terms, lane):
    """Add the sums of one group to those of the window, for one lane."""
    sums.x[lane] += terms.x[lane]
    sums.xx[lane] += terms.xx[lane]
    sums.vv[lane] += terms.vv[lane]
    sums.force[lane] += terms.force[lane]
    sums.power[lane] += terms.power[lane]
    sums.virial[lane] += terms.virial[lane]


@njit(**INLINE)
def _counts(n, low, high):
    """1.0 if step n lies in the window, otherwise 0.0."""
    return 1.0 if low <= n < high else 0.0


class Parts(NamedTuple):
    """The parts in double precision."""

    scheme: Any
    wall: Any
    load: Any


@cached
@njit(**ENTRY)
def block(
    parts, sweep, memory, drive, start, taps, stiffness, origin,
    first, blocks, steps, low, high, k0, k1, stream, halved, observers, record, every, stop, out, branches,
):  # fmt: skip
    """Advance the paths from ``first`` on by ``steps`` steps: ``blocks`` times LANES of them, one block after another.

    Step n (from 0) ends with the observation at time (n + 1) h; sums run over low <= n < high.  ``sweep`` is the parts
    in the precision of the sweep.  ``drive`` is the deterministic force of each step (may be empty).  ``taps`` are
    modes of the memory whose squares are summed, once in every group.  ``origin`` is what observers, record and x_end
    have added to x: the rest of the spring under a constant force.  ``halved``: the noise is that of a run with half
    the step.  Written: ``record``, x and v of the first paths after every ``every`` steps (may be empty), and ``out``,
    one row per path: COLUMNS, works of the named forces, sums of the wall, sums of the taps.  The block ends early when
    ``stop[0]`` is not 0.  ``branches`` is NO_BRANCHES, or says which paths these are, and from where they start.
    """
    scheme, wall, load = parts.scheme, parts.wall, parts.load
    zero = memory.newest * f32(0)  # in the precision of the memory
    quick = sweep.zero  # in that of the sweep
    turned, plain = memory.turns.size // NUMBERS, memory.powers.size // 4
    modes = plain + 2 * turned
    z = _modes(zero)
    h = _four(zero)
    d = _six(zero)  # the two increments before the group, then the group's four
    p = (zero, zero, zero, zero)
    g, fine = _four(f32(0)), _four(f32(0))
    now = State(_state(0.0), _state(0.0))
    begun, change = State(_state(quick), _state(quick)), State(_state(quick), _state(quick))
    glimpsed = Glimpse(_four(quick), _four(quick), _four(quick), _four(quick), _four(quick))
    clear = _state(quick)
    seen = Glimpse(_shown(0.0), _shown(0.0), _four(0.0), _four(0.0), _four(0.0))
    struck = Struck(
        _eight(quick), _eight(quick),
        _state(quick), _state(quick), _state(quick), _state(quick), _state(quick), _state(quick),
    )  # fmt: skip
    terms = Sums(_state(quick), _state(quick), _state(quick), _state(quick), _state(quick), _state(quick))
    sums = Sums(_state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0))
    accumulators = Accumulators(_state(0.0), _state(0.0), _state(0.0), _state(0.0), _extras(0.0), observers)
    forcing = Forcing(_by_force(quick), _by_force(quick), _by_force_and_step(quick), _states(quick), _four(f32(0)), g)
    works, tapped = _by_force(0.0), _by_force(0.0)
    energy_first, energy_last, x_end, v_end = _state(0.0), _state(0.0), _state(0.0), _state(0.0)
    early_xx, early_vv = _state(0.0), _state(0.0)
    who, risen, last = lane_numbers(u32(0)), _state(0.0), _state(0.0)
    lanes = (1, 1, now, begun, d, h, z, modes, forcing, risen, last)
    for number in range(blocks):
        crowded = in_lanes(scheme, wall) and may_be_crowded(branches)  # all may start at a wall
        row = number * LANES
        name_paths(branches, first, row, who)
        births = n_0 = opened(branches, row, lanes)
        for i in range(modes * LANES):
            z[i] = zero
        for i in range(GROUP * LANES):
            h[i] = zero
        for lane in range(LANES):
            accumulators.impacts[lane] = accumulators.speeds[lane] = 0.0
            accumulators.squares[lane] = accumulators.collapses[lane] = 0.0
            for k in range(MOST_EXTRAS):
                accumulators.extras[k * LANES + lane] = 0.0
            for k in range(slots(load)):
                works[k * LANES + lane] = 0.0
            for k in range(taps.size):
                tapped[k * LANES + lane] = 0.0
            path = (number * LANES + lane) % start.states.shape[0]
            x, v, energy = start.states[path, 0], start.states[path, 1], start.states[path, 2]
            now.x[lane], now.v[lane] = begin(scheme, wall, x, v, start.early, accumulators, lane, _counts(0, low, high))
            begun.x[lane], begun.v[lane] = now.x[lane], now.v[lane]
            d[lane], d[LANES + lane] = zero, now.x[lane] - x
            sums.x[lane] = sums.xx[lane] = sums.vv[lane] = early_xx[lane] = early_vv[lane] = 0.0
            sums.force[lane] = sums.power[lane] = sums.virial[lane] = 0.0
            energy_first[lane] = energy_last[lane] = energy
            x_end[lane] = v_end[lane] = np.nan
        wake(load, 0, who, stream, k0, k1, forcing)
        for group in range(n_0 // GROUP, (steps + GROUP - 1) // GROUP):
            n = GROUP * group  # which tells the compiler the number of a step in its group
            births = birth(branches, n, births, row, steps, lanes)
            if n % (GROUP * STOP_EVERY) == 0 and stop[0] != 0:
                return
            for lane in range(LANES if n == middle(low, high) else 0):
                early_xx[lane], early_vv[lane] = sums.xx[lane], sums.vv[lane]
            draw_for_steps(group, who, stream, 0, k0, k1, halved, g, fine)
            supply(load, 0, group, who, stream, k0, k1, forcing)
            if drive.size > 0:
                p = (drive[n], drive[n + 1], drive[n + 2], drive[n + 3])
            within = low <= n and n + GROUP <= high
            cut = not within and n < high and n + GROUP > low  # by an end of the window
            marked = n < low <= n + GROUP or n < high <= n + GROUP or n + GROUP >= steps  # a state is kept
            moving = marked or record.shape[0] > 0 or (within and is_seen(observers, n, low, 0))
            shown = moving or (within and is_seen(observers, n, low, (1 + MOST_FELT) * GROUP * LANES))
            direct = crowded and not cut
            if direct:
                sweep_lanes(
                    sweep, memory, p, n, begun, change, clear, g, forcing, h, d, glimpsed, struck, terms, yes(), yes()
                )
            elif within or shown:
                sweep_lanes(
                    sweep, memory, p, n, begun, change, clear, g, forcing, h, d, glimpsed, struck, terms, yes(), no()
                )
            else:
                sweep_lanes(
                    sweep, memory, p, n, begun, change, clear, g, forcing, h, d, glimpsed, struck, terms, no(), no()
                )
            if moving:
                for i in range(GROUP * LANES):
                    seen.x[i], seen.v[i] = limited(wall, f64(glimpsed.x[i])), glimpsed.v[i]
            if shown:
                for i in range(GROUP * LANES if observers.feels.size > 0 else 0):
                    seen.at[i], seen.pull[i], seen.middle[i] = glimpsed.at[i], glimpsed.pull[i], glimpsed.middle[i]
            least, near = clear[0], 0
            for lane in range(LANES):
                least = lesser(least, clear[lane])
            if direct:
                near = gather(wall, struck, accumulators, clear, within, low <= n + GROUP < high)
            elif least <= quick:
                for lane in range(LANES):
                    near += 1 if clear[lane] <= quick else 0
            crowded = in_lanes(scheme, wall) and may_be_crowded(branches) and near >= (FEW if crowded else MANY)
            if cut or least <= quick:
                c = (
                    _counts(n, low, high), _counts(n + 1, low, high), _counts(n + 2, low, high),
                    _counts(n + 3, low, high), _counts(n + 4, low, high),
                )  # fmt: skip
                for lane in range(LANES):
                    if cut or clear[lane] <= quick:
                        replay(parts, memory, p, n, now, g, forcing, h, d, seen, c, accumulators, terms, lane)
                        change.x[lane] = change.v[lane] = quick
            if shown and origin != 0.0:
                for i in range(GROUP * LANES):
                    seen.x[i] += origin
                for i in range(GROUP * LANES if observers.feels.size > 0 else 0):
                    seen.at[i] += origin
            for lane in range(LANES):
                now.x[lane] += change.x[lane]
                begun.x[lane] = now.x[lane]
            for lane in range(LANES):
                now.v[lane] += change.v[lane]
                begun.v[lane] = now.v[lane]
            if modes > 0:
                _remember(z, d, h, plain, memory.powers, memory.weights)
                turn(z, plain * LANES, d, 0, h, 0, turned, memory.turns, 0)
            if low <= n + GROUP - 1 < high:
                for k in range(taps.size):
                    for lane in range(LANES):
                        mode = f64(z[taps[k] * LANES + lane])
                        tapped[k * LANES + lane] += mode * mode
            for lane in range(LANES):
                d[lane], d[LANES + lane] = d[GROUP * LANES + lane], d[(GROUP + 1) * LANES + lane]
            for k in range(observers.feels.size if shown else 0):
                which = observers.feels[k]
                to = beyond(seen.x, (1 + which) * GROUP * LANES)
                feel(
                    observers, which, GROUP * LANES, seen.at, seen.pull, seen.middle, forcing.given, forcing.state, to
                )  # fmt: skip
            if within or cut:
                for lane in range(LANES):
                    _add(sums, terms, lane)
                    for k in range(slots(load)):
                        works[k * LANES + lane] += forcing.works[k * LANES + lane]
                if shown:
                    for lane in range(LANES):
                        seen.v[GROUP * LANES + lane] = terms.power[lane]
                    for i in range(slots(load) * LANES):
                        seen.v[(GROUP + 1) * LANES + i] = forcing.works[i]
                    show_steps(observers, seen.x, seen.v, scheme.step, n, low, high)
            for j in range(GROUP if marked else 0):
                if n + j == low - 1 or n + j == high - 1 or n + j == steps - 1:
                    for lane in range(LANES):
                        x_end[lane], v_end[lane] = seen.x[j * LANES + lane], seen.v[j * LANES + lane]
                        stretched = x_end[lane] - origin
                        energy = 0.5 * (v_end[lane] * v_end[lane] + stiffness * stretched * stretched)
                        energy_first[lane] = energy if n + j == low - 1 else energy_first[lane]
                        energy_last[lane] = energy if n + j == high - 1 else energy_last[lane]
            for lane in range(record.shape[0]):
                for j in range(GROUP):
                    if n + j < steps and (n + j + 1) % every == 0:
                        record[lane, (n + j + 1) // every, 0] = seen.x[j * LANES + lane]
                        record[lane, (n + j + 1) // every, 1] = seen.v[j * LANES + lane]
                    if n + j < steps:
                        record_felt(observers, 1, seen.x, n, j, every, lane)
            keep(branches, n + GROUP, no(), row, steps, lanes)
        closed(branches, row)
        for lane in range(LANES):
            row = number * LANES + lane
            out[row, 0], out[row, 1], out[row, 2] = sums.x[lane], sums.xx[lane], sums.vv[lane]
            out[row, 3], out[row, 4], out[row, 5] = sums.force[lane], sums.power[lane], sums.virial[lane]
            out[row, 6], out[row, 7] = accumulators.impacts[lane], accumulators.speeds[lane]
            out[row, 8] = accumulators.squares[lane]
            out[row, 9], out[row, 10], out[row, 11] = (
                accumulators.collapses[lane],
                energy_first[lane],
                energy_last[lane],
            )
            out[row, 12], out[row, 13] = x_end[lane], v_end[lane]
            out[row, 14], out[row, 15] = early_xx[lane], early_vv[lane]
            column = 16
            for k in range(slots(load)):
                out[row, column] = works[k * LANES + lane]
                column += 1
            for k in range(extras(wall)):
                out[row, column] = accumulators.extras[k * LANES + lane]
                column += 1
            for k in range(taps.size):
                out[row, column] = tapped[k * LANES + lane]
                column += 1
