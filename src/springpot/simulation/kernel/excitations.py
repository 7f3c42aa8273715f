"""Excitation that does not depend on the motion, from the tables: drawn once for every group of four steps.

Of each source the tables have eight integers: its kind, its first counter word, the place of its state, two counts,
nothing, and where its long list begins and how long it is; and a ``wave`` of two numbers.

========== ===================================== ======================================== =============================
kind       counts                                wave                                     long list
========== ===================================== ======================================== =============================
FILTERED   pairs of states, states at the start                                           newest (4), pairs (20 each),
                                                                                          start (square), envelope
HARMONIC                                         impulse and radians per step
TABLE      records, which one a path has                                                  impulses of each record
POISSON                                          rate in a part of a step, size           envelope
MODULATED  states, steps                                                                  roots, gains, changes, seen
========== ===================================== ======================================== =============================
"""

from __future__ import annotations

import math

from numba import njit

from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, beyond, f64, typed, u32, u64
from springpot.simulation.kernel.random import draw, philox
from springpot.simulation.kernel.reading import alike, of_lane, shared
from springpot.simulation.kernel.tables import AT_RANDOM, COMMON, OF_A_SOURCE, PARTS, SOURCE, SOURCES, WAVE

WORDS = 128  # counter words of one source; the second half of them is for its state at time 0
MOST_SOURCES = 12
FILTERED, HARMONIC, TABLE, POISSON, MODULATED = range(5)
KIND, WORD, PLACE, ONE, OTHER, _, LONG, LENGTH = range(OF_A_SOURCE)


@njit(**INLINE)
def _of(K, i, what):
    return K[K[SOURCE] + OF_A_SOURCE * i + what]


@njit(**LINKED)
def wake_sources(K, who, stream, k0, k1, F, state, normals):
    """The states of all sources at time 0."""
    for i in range(K[SOURCES]):
        kind, place = _of(K, i, KIND), _of(K, i, PLACE)
        if kind == FILTERED:
            _wake_filtered(
                beyond(F, _of(K, i, LONG) + 4 + 20 * _of(K, i, ONE)), _of(K, i, OTHER), _of(K, i, WORD), who, stream,
                k0, k1, beyond(state, place * LANES), normals,
            )  # fmt: skip
        elif kind == HARMONIC:
            for lane in range(LANES):
                word, _a, _b, _c = philox(u32(0), who[lane], u32(stream), u32(_of(K, i, WORD)), k0, k1)
                phase = 2.0 * math.pi * (f64(word) + 0.5) / 4294967296.0
                state[place * LANES + lane] = math.cos(phase)
                state[(place + 1) * LANES + lane] = math.sin(phase)
        elif kind == MODULATED:
            for k in range(2 * _of(K, i, ONE) * LANES):
                state[place * LANES + k] = typed(0.0, shared(F, 0))
        elif kind == TABLE:
            records, taken_by = u64(_of(K, i, ONE)), _of(K, i, OTHER)
            for lane in range(LANES if records > u64(1) else 0):
                taken = u64(who[lane]) % records
                if taken_by == AT_RANDOM:
                    word, _a, _b, _c = philox(u32(0), who[lane], u32(stream), u32(_of(K, i, WORD)), k0, k1)
                    taken = (u64(word) * records) >> u64(32)
                state[place * LANES + lane] = taken


@njit(**LINKED)
def _wake_filtered(start, size, word, who, stream, k0, k1, state, normals):
    """Stationary states from normals, by a lower triangle."""
    for i in range(size * LANES):
        state[i] = typed(0.0, shared(start, 0))
    for j in range(size):
        if j % GROUP == 0:
            draw(0, who, stream, word + WORDS // 2 + j // GROUP, k0, k1, normals)
        for i in range(j, size):
            own = (j % GROUP) * LANES
            for lane in range(LANES):
                state[i * LANES + lane] += of_lane(start, lane)[i * size + j] * normals[own + lane]


@njit(**LINKED)
def supply_sources(K, D, F, group, who, stream, k0, k1, state, inputs, spare, normals):
    """The impulses of four steps of all sources, one after another in ``inputs``."""
    for i in range(K[SOURCES]):
        kind, long, own = _of(K, i, KIND), _of(K, i, LONG), beyond(inputs, i * GROUP * LANES)
        begun, word, wave = beyond(state, _of(K, i, PLACE) * LANES), _of(K, i, WORD), K[WAVE] + 2 * i
        if kind == FILTERED or kind == POISSON:  # noqa: SIM109  (a tuple would be compiled as one)
            parts = K[PARTS]
            for part in range(parts):
                if kind == FILTERED:
                    draw(parts * group + part, who, stream, word, k0, k1, normals)
                    _next_impulses(beyond(F, long), _of(K, i, ONE), begun, own, normals)
                else:
                    _next_shots(
                        beyond(D, wave), parts * group + part, who, stream, word, k0, k1, own, normals,
                    )  # fmt: skip
                if parts > 1:
                    _sum_pairs(own, spare, 2 * part)
            shape = 4 + 20 * _of(K, i, ONE) + _of(K, i, OTHER) * _of(K, i, OTHER) if kind == FILTERED else 0
            if _of(K, i, LENGTH) > shape:
                _follow_envelope(beyond(F, long + shape), _of(K, i, LENGTH) - shape, group, own)
        elif kind == HARMONIC:
            zero = shared(F, 0)
            for j in range(GROUP):
                for lane in range(LANES):
                    size, angle = of_lane(D, lane)[wave], of_lane(D, lane)[wave + 1] * (GROUP * group + j + 0.5)
                    cosine, sine = typed(size * math.cos(angle), zero), typed(size * math.sin(angle), zero)
                    own[j * LANES + lane] = cosine * begun[lane] - sine * begun[LANES + lane]
        elif kind == MODULATED:
            draw(group, who, stream, word, k0, k1, normals)
            _next_modulated(
                beyond(F, long), _of(K, i, ONE), _of(K, i, OTHER), _of(K, i, LENGTH), group, begun, own, normals
            )
        else:
            records, steps = _of(K, i, ONE), _of(K, i, LENGTH) // _of(K, i, ONE)
            for j in range(GROUP):
                n = GROUP * group + j
                for lane in range(LANES):
                    at = (int(begun[lane]) if records > 1 else 0) * steps + n
                    if n >= steps:
                        own[j * LANES + lane] = typed(0.0, shared(F, 0))
                    elif not alike(F) and _of(K, i, OTHER) == COMMON:
                        own[j * LANES + lane] = of_lane(F, at % LANES)[long + at // LANES]
                    else:
                        own[j * LANES + lane] = of_lane(F, lane)[long + at]


@njit(**INLINE)
def _follow_envelope(envelope, steps, group, own):
    for j in range(GROUP):
        n = GROUP * group + j
        for lane in range(LANES):
            own[j * LANES + lane] *= of_lane(envelope, lane)[n] if n < steps else typed(0.0, shared(envelope, 0))


@njit(**INLINE)
def _sum_pairs(inputs, spare, to):
    """Four impulses of half steps become two of steps, which are put at step ``to`` of the group.

    The first two steps are kept until the second pair is known.
    """
    for lane in range(LANES):
        one, two = inputs[lane] + inputs[LANES + lane], inputs[2 * LANES + lane] + inputs[3 * LANES + lane]
        if to == 0:
            spare[lane], spare[LANES + lane] = one, two
        else:
            inputs[lane], inputs[LANES + lane] = spare[lane], spare[LANES + lane]
            inputs[2 * LANES + lane], inputs[3 * LANES + lane] = one, two


@njit(**LINKED)
def _next_impulses(numbers, pairs, state, inputs, g):
    for lane in range(LANES):
        w = of_lane(numbers, lane)
        w0, w1, w2, w3 = w[0], w[1], w[2], w[3]
        g0, g1, g2, g3 = g[lane], g[LANES + lane], g[2 * LANES + lane], g[3 * LANES + lane]
        inputs[lane] = w0 * g0
        inputs[LANES + lane] = w0 * g1 + w1 * g0
        inputs[2 * LANES + lane] = w0 * g2 + w1 * g1 + w2 * g0
        inputs[3 * LANES + lane] = w0 * g3 + w1 * g2 + w2 * g1 + w3 * g0
    for k in range(pairs):
        at = 2 * k * LANES
        for lane in range(LANES):
            p = of_lane(beyond(numbers, 4 + 20 * k), lane)
            y, z = state[at + lane], state[at + LANES + lane]
            g0, g1, g2, g3 = g[lane], g[LANES + lane], g[2 * LANES + lane], g[3 * LANES + lane]
            inputs[lane] += p[4] * y + p[5] * z
            inputs[LANES + lane] += p[6] * y + p[7] * z
            inputs[2 * LANES + lane] += p[8] * y + p[9] * z
            inputs[3 * LANES + lane] += p[10] * y + p[11] * z
            state[at + lane] = y + (p[0] * y + p[1] * z + p[12] * g0 + p[14] * g1 + p[16] * g2 + p[18] * g3)
            state[at + LANES + lane] = z + (p[2] * y + p[3] * z + p[13] * g0 + p[15] * g1 + p[17] * g2 + p[19] * g3)


@njit(**LINKED)
def _next_shots(wave, group, who, stream, word, k0, k1, inputs, normals):
    for lane in range(LANES):
        rate = of_lane(wave, lane)[0]
        none = math.exp(-rate)
        a, b, c, d = philox(u32(group), who[lane], u32(stream), u32(word), k0, k1)
        for j in range(GROUP):
            own = a if j == 0 else b if j == 1 else c if j == 2 else d
            left = (f64(own) + 0.5) / 4294967296.0
            chance, count = none, 0
            while left > chance and chance > 0.0:
                left -= chance
                count += 1
                chance *= rate / count
            inputs[j * LANES + lane] = math.sqrt(float(count))
    draw(group, who, stream, word + 1, k0, k1, normals)
    for i in range(GROUP * LANES):
        inputs[i] *= of_lane(wave, i % LANES)[1] * f64(normals[i])


@njit(**LINKED)
def _next_modulated(numbers, size, steps, length, group, state, inputs, g):
    """Of white noise (no states), or of a filter that it drives: the best guess of the states, and what is seen."""
    changes = steps * (1 + size)
    laws = (length - changes) // max(size * (size + 1), 1)  # 1 of a filter that does not change
    for j in range(GROUP):
        n, to = GROUP * group + j, j * LANES
        inside, law = n < steps, min(n, laws - 1)
        none = typed(0.0, shared(numbers, 0))
        for lane in range(LANES):
            inputs[to + lane] = (of_lane(numbers, lane)[n] if inside else none) * g[to + lane]
        for i in range(size):
            seen = changes + laws * size * size + law * size + i
            for lane in range(LANES):
                gain = of_lane(numbers, lane)[steps + n * size + i] if inside else none
                inputs[to + lane] += of_lane(numbers, lane)[seen] * state[i * LANES + lane]
                state[(size + i) * LANES + lane] = gain * g[to + lane]
            for k in range(size):
                factor = changes + (law * size + i) * size + k
                for lane in range(LANES):
                    state[(size + i) * LANES + lane] += of_lane(numbers, lane)[factor] * state[k * LANES + lane]
        for i in range(size * LANES):
            state[i] += state[size * LANES + i]
