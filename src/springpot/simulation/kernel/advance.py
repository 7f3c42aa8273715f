"""The kernel: blocks of paths outside, groups of four steps, vectors of lanes, steps, and parts inside.

A block is LANES paths.  Four steps make a group: one counter of the random numbers gives four normals, the memory modes
are updated once in a group, and the state is in double precision between groups, while changes within a group are in
the precision of the sweep.  The observation is in the middle of the drift.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from springpot.simulation.kernel.branches import ANY, bear, close_branches, keep, open_branches
from springpot.simulation.kernel.circles import begin_turning, hold_turning, turn_with_impacts
from springpot.simulation.kernel.contacts import NUMBERS_OF_CONTACT, drift_through_contacts, is_touched
from springpot.simulation.kernel.excitations import MOST_SOURCES, supply_sources, wake_sources
from springpot.simulation.kernel.lanes import (
    GROUP,
    INLINE,
    LANES,
    LINKED,
    MOST_MODES,
    WIDTH,
    beyond,
    f64,
    middle,
    no,
    stack_array,
    typed,
    u32,
    yes,
)
from springpot.simulation.kernel.motion import (
    Lanes,
    add,
    damp,
    drift,
    gather,
    kick,
    pull,
    rates,
    remember,
    shake,
    squares_beside_rest,
    stretch,
    sum_of,
    turn,
    work,
)
from springpot.simulation.kernel.outputs import MOST_OUTPUTS, output_of, record_outputs
from springpot.simulation.kernel.random import draw_for_steps, lane_numbers, number_lanes
from springpot.simulation.kernel.reading import by_lane, fixed, from_lane, of_lane, shared
from springpot.simulation.kernel.rest import MOST_POINTS, MOST_WALLS, begin, drift_beside_rest, elongation, hold
from springpot.simulation.kernel.striking import bounce, fly, is_behind, land, take_off
from springpot.simulation.kernel.tables import (
    BLOCKS,
    COLUMNS,
    CONSTANT,
    CONTACT,
    CONTACT_AT,
    CONTACTS,
    DAMPERS,
    DRIVE,
    DRIVE_STEPS,
    EARLY,
    EARLY_VV,
    EARLY_XX,
    ENERGY,
    GAUGED,
    GOES_ON,
    HITS,
    MASS,
    MODES,
    NOISES,
    OF_A_WALL,
    ORIGIN,
    PAPER,
    POINTS,
    POWER,
    RESTING,
    ROW,
    ROW_AT,
    ROW_BEGIN,
    ROWS,
    SHAKEN,
    SOURCES,
    SPRING,
    STATES,
    STEP,
    STRIDE,
    STRIDE_IN_DOUBLE,
    TAPPED,
    TAPPED_SQUARES,
    TAPS,
    TURNS,
    UU,
    V_END,
    VV,
    WALLS,
    X_END,
    XX,
    U,
    X,
)
from springpot.simulation.kernel.vectors import double, load, store
from springpot.simulation.kernel.watching import ON_STEPS_COUNT, OUTPUTS, OUTPUTS_COUNT, show_steps

MOST_ROWS, MOST_NOISES, MOST_DAMPERS, MOST_TAPS, MOST_SHAKEN = 16, 16, 12, 12, 16
MOST_STATES = 480  # of sources, of parts that yield, and of rows at rest
MOST_COLUMNS = (
    7 * MOST_POINTS + 3 * MOST_ROWS + MOST_SOURCES + MOST_DAMPERS + MOST_SHAKEN + 5 * MOST_WALLS + MOST_TAPS + 9
)
SUMMED = 4  # groups of which the sums are added in the precision of the sweep
STOP_EVERY = 256  # groups between two checks of the stop flag

_lane = stack_array(LANES)
_of_points, _of_rows = stack_array(MOST_POINTS * LANES), stack_array(MOST_ROWS * LANES)
_of_two_points = stack_array(2 * MOST_POINTS * LANES)
_by_step, _increments = stack_array(MOST_ROWS * GROUP * LANES), stack_array(MOST_ROWS * (GROUP + 2) * LANES)
_modes, _normals = stack_array(MOST_MODES * LANES), stack_array(MOST_NOISES * GROUP * LANES)
_four, _inputs = stack_array(GROUP * LANES), stack_array(MOST_SOURCES * GROUP * LANES)
_states, _columns = stack_array((MOST_STATES + 4) * LANES), stack_array(MOST_COLUMNS * LANES)
_of_walls, _of_two_walls = stack_array(MOST_WALLS * LANES), stack_array(2 * MOST_WALLS * LANES)
_few, _own = stack_array(3 * MOST_POINTS), stack_array(3 * WIDTH)
_shown = stack_array((MOST_POINTS + MOST_ROWS + MOST_OUTPUTS) * GROUP * LANES)


@njit(**INLINE)
def _fill(array, count, number):
    for i in range(count * LANES):
        array[i] = number


@njit(**INLINE)
def _clear(T, count, o):
    """Begin the sums of a group."""
    for k in range(count):
        store(T.terms, k * LANES + o, 0.0)


@njit(**INLINE)
def _gather_sums(T, count, o):
    """Add the sums of a group to those of the run."""
    for k in range(count):
        add(T.sums, k * LANES + o, double(load(T.terms, k * LANES + o)))


@njit(**LINKED)
def energy_of(K, D, x, v):
    """Kinetic energy, and that of the springs, contacts and constant forces, of one lane."""
    energy, n, step = 0.0, K[POINTS], D[K[STEP]]
    for i in range(n):
        momentum = 0.0
        for k in range(n):
            momentum += D[K[MASS] + i * n + k] * v[k]
        energy += 0.5 * momentum * v[i] - D[K[CONSTANT] + i] * x[i] / step
    for e in range(K[ROWS]):
        u, power = elongation(K, D, e, x), 1.0
        for k in range(10):
            power *= u
            energy += D[K[SPRING] + 10 * e + k] * power / ((k + 1.0) * step)
        for c in range(K[CONTACTS]):
            b = K[CONTACT] + NUMBERS_OF_CONTACT * c
            depth = D[b + 1] * (D[b] - u)
            if K[K[CONTACT_AT] + c] == e and depth > 0.0:
                energy += D[b + 2] * depth ** (D[b + 3] + 1.0) / (D[b + 3] + 1.0)
    return energy


@njit(**INLINE)
def _drive(K, F, T, t):
    """Add forces that are given for each step to those of the modes in the four steps from t on."""
    for e in range(K[ROWS]):
        begin, steps = K[K[DRIVE] + e], K[K[DRIVE_STEPS] + e]
        for j in range(GROUP if steps > 0 else 0):
            for lane in range(LANES):
                force = of_lane(F, lane)[begin + t + j] if t + j < steps else typed(0.0, shared(F, 0))
                T.h[(GROUP * e + j) * LANES + lane] += force


@njit(**INLINE)
def _see(K, T, o, one):
    """Add the observed displacements and elongations."""
    for i in range(1 if one else K[POINTS]):
        x = load(T.x0, i * LANES + o) + load(T.seen, i * LANES + o)
        add(T.terms, sum_of(K, X, i) + o, x)
        add(T.terms, sum_of(K, XX, i) + o, x * x)
        if one or K[TURNS] + K[PAPER] > 0:
            v = load(T.seen_v, i * LANES + o)
            add(T.terms, sum_of(K, VV, i) + o, v * v)
    for e in range(K[GAUGED]):
        u = load(T.seen_u, e * LANES + o)
        add(T.terms, sum_of(K, U, e) + o, u)
        add(T.terms, sum_of(K, UU, e) + o, u * u)


@njit(**INLINE)
def _show(K, D, F, T, j, x, v, o):
    """Write what observers see of step j: x and v of the coordinates, then the elongations and their rates."""
    n, origin = K[POINTS], from_lane(D, o)[K[ORIGIN]]
    for i in range(n):
        seen = load(T.now_x, i * LANES + o) + load(T.seen, i * LANES + o)
        store(x, (GROUP * i + j) * LANES + o, seen + origin)
        store(v, (GROUP * i + j) * LANES + o, load(T.seen_v, i * LANES + o))
    for e in range(K[ROWS]):
        store(x, (GROUP * (n + e) + j) * LANES + o, double(load(T.seen_u, e * LANES + o)) + origin)
        store(v, (GROUP * (n + e) + j) * LANES + o, stretch(K, F, e, T.seen_v, o, no()))


@njit(**LINKED)
def _mark(K, D, T, x, v, step, low, high, o):
    """Keep state and energy at the ends of the window and of the run."""
    n = K[POINTS]
    for lane in range(o, o + WIDTH):
        own = of_lane(D, lane)
        for i in range(n):
            x[i] = T.now_x[i * LANES + lane] + f64(T.seen[i * LANES + lane])
            v[i] = T.seen_v[i * LANES + lane]
            T.sums[sum_of(K, X_END, i) + lane], T.sums[sum_of(K, V_END, i) + lane] = x[i] + own[K[ORIGIN]], v[i]
        energy = energy_of(K, own, x, v)
        if step == low - 1:
            T.sums[sum_of(K, ENERGY, 0) + lane] = energy
        if step == high - 1:
            T.sums[sum_of(K, ENERGY, 1) + lane] = energy


@njit(**INLINE)
def _outputs(K, S, T, u, j, shown, o):
    """Show the forces and accelerations of step j that observers see; the elongations are those in its kick."""
    for k in range(S[OUTPUTS_COUNT]):
        which = S[S[OUTPUTS] + k]
        output_of(S, T, u, which, j, beyond(shown, (GROUP * (K[POINTS] + K[ROWS] + which) + j) * LANES), o)


@njit(**INLINE)
def _one_step(K, D, F, T, S, x, v, shown_x, j, step, in_window, next_in, with_outputs, o, one):
    """From one kick to the next; with ``one`` of a coordinate that turns and has no parts with code of their own."""
    if not one and K[TURNS] > 0 and K[RESTING] > 0:
        store(T.fx, o, 0.0)
    if not one and K[DAMPERS] > 0:
        damp(K, D, F, T, step, no(), in_window, o)
    gather(K, F, T, j, o, one)
    if not one and K[SHAKEN] > 0:
        shake(K, F, T, j, step, in_window, o)
    pull(K, F, T, j, o, one)
    if in_window:
        work(K, F, T, j, o, one)
    kick(K, F, T, in_window, o, one)
    weight, later = 1.0 if in_window else 0.0, 1.0 if next_in else 0.0
    if not one and K[RESTING] > 0:
        if K[TURNS] > 0:
            hold_turning(K, D, T, no(), weight, o)
        else:
            for k in range(K[WALLS]):
                store(T.leant, k * LANES + o, 0.0)
            hold(K, D, T, x, v, weight, o, WIDTH)
            if in_window:
                squares_beside_rest(K, T, o)
    if in_window:
        work(K, F, T, j, o, one)
    rates(K, F, T, in_window, with_outputs, o, one)
    if not one and with_outputs:
        _outputs(K, S, T, T.u, j, shown_x, o)
    if not one and K[DAMPERS] > 0:
        damp(K, D, F, T, step, yes(), in_window, o)
    if not one and K[RESTING] > 0 and K[DAMPERS] > 0:
        if K[TURNS] > 0:
            hold_turning(K, D, T, yes(), weight, o)
        else:
            hold(K, D, T, x, v, weight, o, WIDTH)
        for e in range(K[ROWS]):
            store(T.w, e * LANES + o, stretch(K, F, e, T.v, o, one))
    if one or K[TURNS] > 0:
        turn(K, F, T, j, o)
        if K[WALLS] > 0:
            turn_with_impacts(K, D, F, T, S, j, weight, later, o)
    else:
        drift(K, F, T, j, o)
        if K[PAPER] > 0:
            bounce(K, F, T, S, weight, o)
        elif K[CONTACTS] > 0 and (is_touched(K, F, T, o) or is_behind(K, F, T, o)):
            drift_through_contacts(K, F, T, S, j, weight, later, o)
        elif K[RESTING] > 0:
            drift_beside_rest(K, D, T, S, j, x, v, weight, later, o, WIDTH)
        elif K[WALLS] > 0 and is_behind(K, F, T, o):
            take_off(K, T, o)
            ever = fly(K, F, T, S, j, 0.0, shared(F, K[STEP]), weight, later, o)
            land(K, F, T, j, ever, o)
    if one and with_outputs:  # nothing has changed what it looks at, and the compiler knows more of the step without it
        _outputs(K, S, T, T.u0, j, shown_x, o)


@njit(**INLINE)
def _record(K, D, T, record, recorded, width, points, place, o):
    """Write x and v of recorded paths."""
    for lane in range(o, min(o + WIDTH, recorded)):
        for i in range(K[POINTS]):
            at = ((lane * points + place) * width + i) * 2
            record[at] = T.now_x[i * LANES + lane] + f64(T.seen[i * LANES + lane]) + of_lane(D, lane)[K[ORIGIN]]
            record[at + 1] = T.seen_v[i * LANES + lane]


def advance(
    integers, numbers, doubles, start, starts, first, blocks, steps, low, high, k0, k1, stream, halved, seen, B, record,
    recorded, width, every, points_in_time, stop, out,
):  # fmt: skip
    """As `_advance` says, of systems whose numbers all lanes of a block have in common."""
    _advance(
        fixed(integers), fixed(numbers), fixed(doubles), start, starts, first, blocks, steps, low, high, k0, k1, stream,
        halved, fixed(seen), B, record, recorded, width, every, points_in_time, stop, out,
    )  # fmt: skip


def advance_by_lane(
    integers, numbers, doubles, start, starts, first, blocks, steps, low, high, k0, k1, stream, halved, seen, B, record,
    recorded, width, every, points_in_time, stop, out,
):  # fmt: skip
    """The same of systems in neighbouring lanes: each lane has numbers of its own."""
    _advance(
        fixed(integers), by_lane(numbers), by_lane(doubles), start, starts, first, blocks, steps, low, high, k0, k1,
        stream, halved, fixed(seen), B, record, recorded, width, every, points_in_time, stop, out,
    )  # fmt: skip


@njit(**LINKED)
def _advance(
    K, F_all, D_all, start, starts, first, blocks, steps, low, high, k0, k1, stream, halved, S, B, record, recorded,
    width, every, points_in_time, stop, out,
):  # fmt: skip
    """Advance the paths from ``first`` on by ``steps`` steps: ``blocks`` times LANES of them, one block after another.

    Of several systems in a call each has as many of the blocks, and its paths are numbered from ``first`` on.

    Step n (from 0) ends with the observation at time (n + 1) h; sums run over low <= n < high.  K, F and D are the
    tables (`springpot.simulation.kernel.tables`): integers, numbers in the precision of the sweep and in double.
    ``start`` has x and v at time 0 of one path, or of ``starts`` paths.  ``halved``: white noise is that of a run with
    half the step.  S is the table of observers, B that of branches.  Written: ``record``, x and v of the first
    ``recorded`` paths after every ``every`` steps, (paths, points in time, ``width``, 2); and ``out``, a row of the
    SUMS of each path.  A block ends early when ``stop[0]`` is not 0.
    """
    zero = typed(0.0, shared(F_all, 0))
    n, m = K[POINTS], K[ROWS]
    T = Lanes(
        _of_points(zero), _of_points(zero), _of_points(zero), _of_points(zero), _of_points(zero), _of_points(zero),
        _of_points(zero), _of_points(zero), _of_points(zero),
        _of_rows(zero), _of_rows(zero), _of_rows(zero), _of_rows(zero), _of_rows(zero), _of_rows(zero),
        _increments(zero), _by_step(zero), _modes(zero), _normals(zero), _inputs(zero), _states(zero),
        _of_two_points(zero), _of_rows(zero), _of_two_walls(zero), _columns(zero),
        _of_points(0.0), _of_points(0.0), _columns(0.0), _of_walls(0.0), _own(0.0), _of_walls(0.0),
    )  # fmt: skip
    fine, x, v = _four(zero), _few(0.0), _few(0.0)
    shown_x, shown_v, told = _shown(0.0), _shown(0.0), _columns(0.0)
    who, risen, last = lane_numbers(u32(0)), _lane(0.0), _lane(0.0)
    works = K[SOURCES] + K[DAMPERS] + K[SHAKEN]
    terms = sum_of(K, HITS, 0) // LANES + (OF_A_WALL * K[WALLS] if K[TURNS] == 0 else 0)
    plain = K[TURNS] > 0 and K[DAMPERS] + K[SHAKEN] + K[RESTING] == 0
    for number in range(blocks):
        row, births, t_0 = number * LANES, steps, 0
        system = number // K[BLOCKS] if K[BLOCKS] > 0 else 0
        F, D = beyond(F_all, system * K[STRIDE]), beyond(D_all, system * K[STRIDE_IN_DOUBLE])
        before = 0 if K[GOES_ON] > 0 else system * K[BLOCKS] * LANES
        number_lanes(first + row - before, who)
        if B[ANY] > 0:
            births = t_0 = open_branches(B, row, who, risen, last)
        _fill(T.sums, K[COLUMNS], 0.0)
        _fill(told, works + 1, 0.0)
        _fill(T.z, K[MODES], zero)
        _fill(T.h, GROUP * m, zero)
        _fill(T.d, (GROUP + 2) * m, zero)
        _fill(T.state, K[STATES] + K[WALLS] + 1, zero)
        _fill(T.peaks, K[CONTACTS], 0.0)
        _fill(T.leant, K[WALLS], 0.0)
        for lane in range(LANES):
            path, own = (row + lane) % starts, of_lane(D, lane)
            for i in range(n):
                x[i], v[i] = start[2 * n * path + i], start[2 * n * path + n + i]
                T.now_x[i * LANES + lane], T.now_v[i * LANES + lane] = x[i], v[i]
                T.sums[sum_of(K, X_END, i) + lane] = T.sums[sum_of(K, V_END, i) + lane] = np.nan
            energy = energy_of(K, own, x, v)
            T.sums[sum_of(K, ENERGY, 0) + lane] = T.sums[sum_of(K, ENERGY, 1) + lane] = energy
            weight = 1.0 if low == 0 < high else 0.0
            if K[TURNS] > 0:
                begin_turning(K, own, T, S, x, v, weight, lane)
            elif K[PAPER] == 0:
                begin(K, own, T, S, start, path, x, v, lane, weight)
        for i in range(n * LANES):
            T.now_x[i] += of_lane(D, i % LANES)[K[EARLY] + i // LANES]
        for e in range(m):
            for lane in range(LANES):
                own = of_lane(D, lane)
                for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
                    T.d[((GROUP + 2) * e + 1) * LANES + lane] += own[K[ROW] + p] * own[K[EARLY] + K[K[ROW_AT] + p]]
        begins = True
        wake_sources(K, who, stream, k0, k1, F, T.state, fine)
        _drive(K, F, T, 0)
        for t in range(t_0, steps, GROUP):
            if t == births:
                births = bear(K, B, T, t, births, row, steps, risen, last)
            if t % (GROUP * STOP_EVERY) == 0 and stop[0] != 0:
                return
            for i in range(n * LANES if t == middle(low, high) else 0):
                T.sums[sum_of(K, EARLY_XX, 0) + i] = T.sums[sum_of(K, XX, 0) + i]
                T.sums[sum_of(K, EARLY_VV, 0) + i] = T.sums[sum_of(K, VV, 0) + i]
            for r in range(K[NOISES] + K[SHAKEN]):
                draw_for_steps(t // GROUP, who, stream, r, k0, k1, halved, beyond(T.g, r * GROUP * LANES), fine)
            if K[SOURCES] > 0:
                supply_sources(K, D, F, t // GROUP, who, stream, k0, k1, T.state, T.inputs, shown_x, fine)
            in_window = low < t + GROUP and t < high
            watched = in_window and S[ON_STEPS_COUNT] > 0
            # sums in the sweep's precision are short; the last half of a drift before the window belongs to it
            summed = terms if low <= t + GROUP and t < high else 0
            ends = t // GROUP % SUMMED == SUMMED - 1 or t + GROUP == middle(low, high) or t + GROUP >= min(high, steps)
            with_outputs = (watched or recorded > 0) and S[OUTPUTS_COUNT] > 0
            for o in range(0, LANES, WIDTH):
                F_o, D_o = from_lane(F, o), from_lane(D, o)
                for i in range(n):
                    at = i * LANES + o
                    store(T.x0, at, load(T.now_x, at))
                    store(T.v, at, load(T.now_v, at))
                    store(T.moved, at, zero)
                    store(T.gained, at, zero)
                for e in range(m):
                    store(T.u, e * LANES + o, stretch(K, D_o, e, T.now_x, o, no()))
                    store(T.w, e * LANES + o, stretch(K, D_o, e, T.now_v, o, no()))
                _clear(T, summed if begins else 0, o)
                for j in range(GROUP):
                    step = t + j
                    in_window, next_in = low <= step < high, low <= step + 1 < high
                    if plain:  # the same with a constant that the compiler knows
                        _one_step(K, D, F_o, T, S, x, v, shown_x, j, step, in_window, next_in, with_outputs, o, yes())
                    else:
                        _one_step(K, D, F_o, T, S, x, v, shown_x, j, step, in_window, next_in, with_outputs, o, no())
                    if watched:
                        _show(K, D, F_o, T, j, shown_x, shown_v, o)
                    if in_window:
                        _see(K, T, o, plain)
                    if step == low - 1 or step == high - 1 or step == steps - 1:
                        _mark(K, D, T, x, v, step, low, high, o)
                    if recorded > 0 and step < steps and (step + 1) % every == 0:
                        _record(K, D, T, record, recorded, width, points_in_time, (step + 1) // every, o)
                for i in range(n):
                    add(T.now_x, i * LANES + o, double(load(T.moved, i * LANES + o)))
                    add(T.now_v, i * LANES + o, double(load(T.gained, i * LANES + o)))
                remember(K, F_o, T, o)
                _gather_sums(T, summed if ends else 0, o)
                for k in range(K[TAPS] if low <= t + GROUP - 1 < high else 0):
                    mode = double(load(T.z, K[K[TAPPED] + k] * LANES + o))
                    add(T.sums, sum_of(K, TAPPED_SQUARES, k) + o, mode * mode)
            begins = ends or summed == 0
            _drive(K, F, T, t + GROUP)
            for lane in range(min(recorded, LANES) if with_outputs else 0):
                for j in range(GROUP):
                    if t + j < steps:
                        record_outputs(S, n + m, shown_x, t, j, every, lane)
            if watched:
                at = (n + m) * GROUP * LANES
                begun = sum_of(K, POWER, 0) // LANES
                for i in range((works + 1) * LANES):
                    whole = f64(T.terms[begun * LANES + i])
                    shown_v[at + i], told[i] = whole - told[i], 0.0 if ends else whole
                show_steps(S, shown_x, shown_v, shared(D, K[STEP]), t, low, high)
            if B[ANY] > 0:
                keep(K, B, T, t + GROUP, no(), row, steps, risen, last)
        if B[ANY] > 0:
            close_branches(B, row)
        columns = K[COLUMNS]
        for lane in range(LANES):
            for k in range(columns):
                out[(row + lane) * columns + k] = T.sums[k * LANES + lane]
