"""One step of all lanes of a vector: the kick of everything that acts at once, and the drift to the next kick.

Everything that a part knows of the masses is its elongation, a row times the coordinates.  All forces act in the kick,
with the answer of dampers and memory to their own impulse in one small matrix.  Between two kicks lies a drift:
straight, or on a circle of the coordinate's own.  ``o`` is the first lane of the vector in the block.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import llvmlite.ir as ir
from numba import njit, types
from numba.extending import intrinsic

from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, WIDTH, beyond, no, stack_array
from springpot.simulation.kernel.laws import (
    ANY,
    COULOMB,
    NUMBERS_OF_DAMPER,
    POLYNOMIAL,
    VAN_DER_POL,
    coulomb,
    powers,
    van_der_pol,
    yielding,
)
from springpot.simulation.kernel.reading import alike, of_lane, plain, shared
from springpot.simulation.kernel.tables import (
    ANSWER,
    AT,
    CONSTANT,
    DAMPER,
    DAMPER_ALONG,
    DAMPER_AT,
    DAMPER_JUMP,
    DAMPER_KIND,
    DAMPER_PLACE,
    DAMPERS,
    DAMPING,
    FORCE,
    FORCED,
    KICK,
    MODE_BEGIN,
    MODE_COUNT,
    MODE_TABLE,
    NEAR,
    NOISE,
    NOISE_AT,
    NOISE_BEGIN,
    NOISES,
    PAPER,
    POINTS,
    POWER,
    RESTING,
    ROW,
    ROW_AT,
    ROW_BEGIN,
    ROWS,
    SHAKEN,
    SHAKEN_AT,
    SHAKEN_BEGIN,
    SHAKEN_STEPS,
    SHAKING,
    SHOWN,
    SOLVE,
    SOURCE_AT,
    SOURCE_BEGIN,
    SOURCE_ROW,
    SOURCES,
    SPRING_KIND,
    STEP,
    TURN,
    TURNED,
    TURNED_TABLE,
    TURNS,
    VIRIAL,
    VV,
    WORKS,
    WW,
)
from springpot.simulation.kernel.vectors import call_force, filled, load, root, store

NO_SPRING, LINEAR, CUBIC, NINTH = range(4)  # kinds of springs
NUMBERS_OF_MODE, NUMBERS_OF_TURN = 8, 20

_of_a_damper = stack_array(NUMBERS_OF_DAMPER)


class Lanes(NamedTuple):
    """Arrays of the block, LANES numbers of each thing; in the precision of the sweep but for the last ones.

    Beside them functions take K, the table of integers, F and D, those of numbers in the precision of the sweep and in
    double, and ``o``, the first lane of a vector.  F begins with the numbers of that lane, D with those of lane 0.
    """

    x0: Any  # of coordinates: displacement at the beginning of the group
    moved: Any  # since then
    v: Any
    gained: Any  # since then
    before: Any  # ``moved`` before the drift
    leaving: Any  # v before the kick, then before the drift
    seen: Any  # ``moved`` at the observation
    seen_v: Any
    impulse: Any
    u: Any  # of rows: elongation, in the present group
    w: Any  # its rate
    u0: Any  # before the drift
    seen_u: Any
    pull: Any  # of dampers and memory
    middle: Any  # mean of the rates before and after the kick
    d: Any  # GROUP + 2 increments of each row: the two before the group first
    h: Any  # GROUP forces of the modes of each row
    z: Any  # modes
    g: Any  # GROUP normals of each noise
    inputs: Any  # GROUP impulses of each source
    state: Any  # of sources, of what yields, and of rows at rest
    fx: Any  # of coordinates and rows in flight; of one that turns and rests, before it what kicks change of v
    fu: Any
    touched: Any  # of contacts: the elongation when it was last looked at
    terms: Any  # sums of some groups, as in a row of results
    now_x: Any  # double: at the beginning of the group
    now_v: Any
    sums: Any
    leant: Any  # impulses of walls on rows at rest
    own: Any  # three vectors, for functions of the user and for observers
    peaks: Any  # of contacts: the largest force of the present touch


@njit(**INLINE)
def add(array, at, value):
    """Add a vector to what is there."""
    store(array, at, load(array, at) + value)


@intrinsic
def sum_of(typing_context, table, what, number):
    """Where a sum is among the lane arrays of sums.

    As an intrinsic: a function would be compiled for each of them.
    """

    def codegen(context, builder, signature, args):
        own, what, number = (
            value if kind == table else context.cast(builder, value, kind, types.int64)
            for value, kind in zip(args, signature.args, strict=True)
        )

        def read(at):
            loaded = builder.load(builder.gep(own, [at]))
            loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
            return loaded

        kind = ir.IntType(64)
        return builder.mul(builder.add(read(builder.add(read(kind(AT)), what)), number), kind(LANES))

    return types.int64(table, what, number), codegen


@njit(**INLINE)
def stretch(K, F, e, source, o, one):
    """A row of numbers of coordinates; with ``one`` there is one coordinate, which is its row."""
    if one:
        return load(source, o)
    first, last = K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]
    total = F[K[ROW] + first] * load(source, K[K[ROW_AT] + first] * LANES + o)
    for p in range(first + 1, last):
        total = total + F[K[ROW] + p] * load(source, K[K[ROW_AT] + p] * LANES + o)
    return total


@njit(**INLINE)
def push_row(K, F, T, e, f, o, one):
    """Add the impulse of a row to those of the coordinates."""
    if one:
        add(T.impulse, o, f)
        return
    for p in range(K[K[ROW_BEGIN] + e], K[K[ROW_BEGIN] + e + 1]):
        add(T.impulse, K[K[ROW_AT] + p] * LANES + o, F[K[ROW] + p] * f)


@njit(**INLINE)
def springs(F, kind, b, u):
    """The impulse of springs whose numbers begin at b, towards smaller u where they are positive."""
    f = F[b] + F[b + 1] * u
    if kind == CUBIC:
        f = f + u * u * (F[b + 2] + F[b + 3] * u)
    elif kind == NINTH:
        high = F[b + 5] + u * (F[b + 6] + u * (F[b + 7] + u * (F[b + 8] + u * F[b + 9])))
        f = f + u * u * (F[b + 2] + u * (F[b + 3] + u * (F[b + 4] + u * high)))
    return f


@njit(**INLINE)
def gather(K, F, T, j, o, one):
    """The impulses of constant forces, noise and other excitation on the coordinates in step j of the group."""
    if one:
        whole = filled(load(T.v, o), F[K[CONSTANT]])
        for r in range(K[NOISES]):
            whole = whole + F[K[NOISE] + r] * load(T.g, (GROUP * r + j) * LANES + o)
        for r in range(K[SOURCES]):
            whole = whole + F[K[SOURCE_ROW] + r] * load(T.inputs, (GROUP * r + j) * LANES + o)
        store(T.impulse, o, whole)
        return
    for i in range(K[POINTS]):
        store(T.impulse, i * LANES + o, F[K[CONSTANT] + i])
    for r in range(K[NOISES]):
        normal = load(T.g, (GROUP * r + j) * LANES + o)
        for p in range(K[K[NOISE_BEGIN] + r], K[K[NOISE_BEGIN] + r + 1]):
            add(T.impulse, K[K[NOISE_AT] + p] * LANES + o, F[K[NOISE] + p] * normal)
    for r in range(K[SOURCES]):
        inputs = load(T.inputs, (GROUP * r + j) * LANES + o)
        for p in range(K[K[SOURCE_BEGIN] + r], K[K[SOURCE_BEGIN] + r + 1]):
            add(T.impulse, K[K[SOURCE_AT] + p] * LANES + o, F[K[SOURCE_ROW] + p] * inputs)


@njit(**LINKED)
def shake(K, F, T, j, step, in_window, o):
    """The impulses of noise that multiplies elongations, and its expected works."""
    for r in range(K[SHAKEN]):
        e, normal = K[K[SHAKEN_AT] + r], load(T.g, (GROUP * (K[NOISES] + r) + j) * LANES + o)
        square, feed = F[K[SHAKING] + 2 * r], F[K[SHAKING] + 2 * r + 1]
        begin, steps = K[K[SHAKEN_BEGIN] + r], K[K[SHAKEN_STEPS] + r]
        if steps > 0:
            factor = F[begin + min(step, steps - 1)]
            square, feed = square * factor, feed * factor
        u = load(T.u, e * LANES + o)
        if in_window:
            add(T.terms, sum_of(K, WORKS, K[SOURCES] + K[DAMPERS] + r) + o, feed * u * u)
        push_row(K, F, T, e, root(square * u * u) * normal, o, no())


@njit(**INLINE)
def pull(K, F, T, j, o, one):
    """The impulses of springs, dampers and memory on the coordinates."""
    step = shared(F, K[STEP])
    for e in range(1 if one else K[ROWS]):
        u = load(T.u, e * LANES + o)
        force = F[K[DAMPING] + e] * load(T.w, e * LANES + o)
        if K[K[MODE_COUNT] + e] > 0:
            b, q = K[NEAR] + 20 * e + 5 * j, (GROUP + 2) * e * LANES + o
            force = force + load(T.h, (GROUP * e + j) * LANES + o)
            force = force + F[b] * load(T.d, q) + F[b + 1] * load(T.d, q + LANES)
            force = force + F[b + 2] * load(T.d, q + 2 * LANES)
            force = force + F[b + 3] * load(T.d, q + 3 * LANES)
            force = force + F[b + 4] * load(T.d, q + 4 * LANES)
        store(T.pull, e * LANES + o, force)
        f, kind = 0.0 - step * force, K[K[SPRING_KIND] + e]
        if kind != NO_SPRING:
            f = f - springs(F, kind, K[KICK] + 10 * e, u)
        push_row(K, F, T, e, f, o, one)


@njit(**INLINE)
def work(K, F, T, j, o, one):
    """Half of the work of the sources: that with the velocities before the kick, or that with those after it."""
    for r in range(K[SOURCES]):
        inputs = load(T.inputs, (GROUP * r + j) * LANES + o)
        if one:
            add(T.terms, sum_of(K, WORKS, r) + o, 0.5 * F[K[SOURCE_ROW] + r] * inputs * load(T.v, o))
            continue
        for p in range(K[K[SOURCE_BEGIN] + r], K[K[SOURCE_BEGIN] + r + 1]):
            v = load(T.v, K[K[SOURCE_AT] + p] * LANES + o)
            add(T.terms, sum_of(K, WORKS, r) + o, 0.5 * F[K[SOURCE_ROW] + p] * inputs * v)


@njit(**INLINE)
def kick(K, F, T, in_window, o, one):
    """The change of all velocities; the squares of their means before and after it, unless walls still take of it."""
    n, sums = 1 if one else K[POINTS], in_window and not one and K[TURNS] + K[PAPER] + K[RESTING] == 0
    for i in range(n):
        change = F[K[SOLVE] + i * n] * load(T.impulse, o)
        for k in range(1, n):
            change = change + F[K[SOLVE] + i * n + k] * load(T.impulse, k * LANES + o)
        at = i * LANES + o
        v = load(T.v, at)
        if sums:
            middle = v + 0.5 * change
            add(T.terms, sum_of(K, VV, i) + o, middle * middle)
        if not one and K[RESTING] > 0:
            store(T.leaving, at, v)
            add(T.fx, at, change)
        store(T.v, at, v + change)
        add(T.gained, at, change)


@njit(**INLINE)
def rates(K, F, T, in_window, with_outputs, o, one):
    """The rates of all rows after the kick, and the power of dampers and memory, by the means before and after it."""
    for e in range(1 if one else K[ROWS]):
        at = e * LANES + o
        new, old = stretch(K, F, e, T.v, o, one), load(T.w, at)
        store(T.w, at, new)
        if in_window or with_outputs:
            middle, pulled = 0.5 * (new + old), load(T.pull, at) + F[K[ANSWER] + e] * (new - old)
            if with_outputs:
                store(T.pull, at, pulled)
                store(T.middle, at, middle)
            if in_window:
                add(T.terms, sum_of(K, POWER, 0) + o, pulled * middle)
                if e < K[FORCED]:
                    add(T.terms, sum_of(K, FORCE, e) + o, pulled)
                    add(T.terms, sum_of(K, VIRIAL, e) + o, pulled * load(T.u, at))
                if e < K[SHOWN]:
                    add(T.terms, sum_of(K, WW, e) + o, middle * middle)


@njit(**INLINE)
def squares_beside_rest(K, T, o):
    """The squares of the means of the velocities before and after a kick, of which walls may have taken some."""
    for i in range(K[POINTS]):
        middle = 0.5 * (load(T.leaving, i * LANES + o) + load(T.v, i * LANES + o))
        add(T.terms, sum_of(K, VV, i) + o, middle * middle)


@njit(**INLINE)
def _change(K, D, F, T, k, n, after, o):
    """What damper k changes of its elongation's velocity in half of step n."""
    e, kind, b = K[K[DAMPER_AT] + k] * LANES + o, K[K[DAMPER_KIND] + k], K[DAMPER] + NUMBERS_OF_DAMPER * k
    u, w, state = load(T.u, e), load(T.w, e), beyond(T.state, K[K[DAMPER_PLACE] + k] * LANES)
    if kind == COULOMB:
        return coulomb(F[b], w)
    if kind == POLYNOMIAL:
        return powers(F[b], F[b + 1], w, after)
    if kind == VAN_DER_POL:
        return van_der_pol(F[b], F[b + 1], u, w)
    if kind <= ANY:
        exponent, step = shared(F, b + 3), shared(F, K[STEP])
        return yielding(kind, F[b], F[b + 1], F[b + 2], exponent, step, u, w, state, o, after)
    own = T.own  # of the user: always in double precision
    store(own, 0, u)
    store(own, WIDTH, w)
    time, change = shared(D, K[STEP]) * (n + 0.5), beyond(own, 2 * WIDTH)
    if alike(D):
        call_force(kind, (time, plain(beyond(D, b)), own, beyond(own, WIDTH), change, WIDTH))
    for lane in range(0 if alike(D) else WIDTH):
        numbers = _of_a_damper(0.0)
        for i in range(NUMBERS_OF_DAMPER):
            numbers[i] = of_lane(D, o + lane)[b + i]
        call_force(kind, (time, numbers, beyond(own, lane), beyond(own, WIDTH + lane), beyond(change, lane), 1))
    return filled(u, load(own, 2 * WIDTH))


@njit(**LINKED)
def damp(K, D, F, T, n, after, in_window, o):
    """Half of step n of all dampers, one after another; after the kick in reverse."""
    count = K[DAMPERS]
    for number in range(count):
        k = count - 1 - number if after else number
        e = K[K[DAMPER_AT] + k]
        change = _change(K, D, F, T, k, n, after, o)
        if in_window:
            w = load(T.w, e * LANES + o)
            add(T.terms, sum_of(K, WORKS, K[SOURCES] + k) + o, change * (w + 0.5 * change))
        for i in range(K[POINTS]):
            more, at = F[K[DAMPER_JUMP] + k * K[POINTS] + i] * change, i * LANES + o
            add(T.v, at, more)
            add(T.gained, at, more)
            if K[RESTING] > 0 and K[K[DAMPER_KIND] + k] != COULOMB:  # which does not press
                add(T.fx, at, more)
        for r in range(K[ROWS]):
            add(T.w, r * LANES + o, F[K[DAMPER_ALONG] + k * K[ROWS] + r] * change)


@njit(**INLINE)
def drift(K, F, T, j, o):
    """Straight; the paper's scheme sees its end."""
    step = shared(F, K[STEP])
    half = step if K[PAPER] > 0 else 0.5 * step
    for i in range(K[POINTS]):
        at = i * LANES + o
        x, v = load(T.moved, at), load(T.v, at)
        store(T.before, at, x)
        store(T.seen, at, x + half * v)
        store(T.seen_v, at, v)
        store(T.moved, at, x + step * v)
    for e in range(K[ROWS]):
        at = e * LANES + o
        u, w = load(T.u, at), load(T.w, at)
        store(T.d, ((GROUP + 2) * e + 2 + j) * LANES + o, step * w)
        store(T.u0, at, u)
        store(T.seen_u, at, u + half * w)
        store(T.u, at, u + step * w)


@njit(**INLINE)
def turn(K, F, T, j, o):
    """A lone coordinate, which is its row, on a circle."""
    b, x, moved, v = K[TURN], load(T.u, o), load(T.moved, o), load(T.v, o)
    way, change = F[b] * x + F[b + 1] * v, F[b] * v - F[b + 2] * x
    store(T.u0, o, x)
    store(T.seen, o, moved + way)
    store(T.seen_u, o, x + way)
    store(T.seen_v, o, v + change)
    way, change = F[b + 3] * x + F[b + 4] * v, F[b + 3] * v - F[b + 5] * x
    store(T.d, (2 + j) * LANES + o, way)
    store(T.moved, o, moved + way)
    store(T.u, o, x + way)
    store(T.v, o, v + change)
    store(T.w, o, v + change)
    add(T.gained, o, change)


@njit(**INLINE)
def remember(K, F, T, o):
    """Add four increments to every mode; the force of the modes in the next four steps."""
    for e in range(K[ROWS]):
        q, count = (GROUP + 2) * e * LANES + o, K[K[MODE_COUNT] + e]
        if count > 0:
            e0, e1 = load(T.d, q + LANES), load(T.d, q + 2 * LANES)  # the newest has a weight of its own until later
            e2, e3 = load(T.d, q + 3 * LANES), load(T.d, q + 4 * LANES)
            h0 = h1 = h2 = h3 = filled(e0, 0.0)
            t, b = K[K[MODE_TABLE] + e], K[K[MODE_BEGIN] + e] * LANES + o
            for k in range(count):  # a^4 - 1 is stored, not a^4: for slow modes a^4 rounds to 1
                y = load(T.z, b + k * LANES)
                y = y + (shared(F, t + 3) * y + shared(F, t + 2) * e0 + shared(F, t + 1) * e1 + shared(F, t) * e2 + e3)
                store(T.z, b + k * LANES, y)
                h0 = h0 + F[t + 4] * y
                h1 = h1 + F[t + 5] * y
                h2 = h2 + F[t + 6] * y
                h3 = h3 + F[t + 7] * y
                t += NUMBERS_OF_MODE
            t, b = K[K[TURNED_TABLE] + e], b + count * LANES
            for _ in range(K[K[TURNED] + e]):  # of circuits with a coil: two states, which a step turns into each other
                y, r = load(T.z, b), load(T.z, b + LANES)
                y1 = y + (
                    F[t] * y + F[t + 1] * r + F[t + 4] * e0 + F[t + 6] * e1 + F[t + 8] * e2 + F[t + 10] * e3
                )  # fmt: skip
                r1 = r + (
                    F[t + 2] * y + F[t + 3] * r + F[t + 5] * e0 + F[t + 7] * e1 + F[t + 9] * e2 + F[t + 11] * e3
                )  # fmt: skip
                store(T.z, b, y1)
                store(T.z, b + LANES, r1)
                h0 = h0 + (F[t + 12] * y1 + F[t + 13] * r1)
                h1 = h1 + (F[t + 14] * y1 + F[t + 15] * r1)
                h2 = h2 + (F[t + 16] * y1 + F[t + 17] * r1)
                h3 = h3 + (F[t + 18] * y1 + F[t + 19] * r1)
                t, b = t + NUMBERS_OF_TURN, b + 2 * LANES
            b = GROUP * e * LANES + o
            store(T.h, b, h0)
            store(T.h, b + LANES, h1)
            store(T.h, b + 2 * LANES, h2)
            store(T.h, b + 3 * LANES, h3)
        store(T.d, q, load(T.d, q + GROUP * LANES))
        store(T.d, q + LANES, load(T.d, q + (GROUP + 1) * LANES))
