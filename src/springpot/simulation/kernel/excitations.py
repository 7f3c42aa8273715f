"""Excitation that does not depend on the motion, from the tables: drawn once for every group of four steps.

Of each source the tables have eight integers: its kind, its first counter word, the place of its state, two counts,
nothing, and where its long list begins and how long it is; and a ``wave`` of two numbers.

========== ===================================== ======================================== =============================
kind       counts                                wave                                     long list
========== ===================================== ======================================== =============================
FILTERED   pairs of states, states at the start                                           newest (4), pairs (20 each),
                                                                                          start (square), envelope
HARMONIC                                         impulse and radians per step
TABLE      records, whether one is drawn                                                  impulses of each record
POISSON                                          rate in a part of a step, size           envelope
MODULATED  states, steps                                                                  roots, gains, changes, seen
========== ===================================== ======================================== =============================
"""

from __future__ import annotations

import math

from numba import njit

from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, beyond, f64, typed, u32, u64
from springpot.simulation.kernel.random import draw, philox
from springpot.simulation.kernel.tables import OF_A_SOURCE, PARTS, SOURCE, SOURCES, WAVE

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
                state[place * LANES + k] = typed(0.0, F[0])
        elif kind == TABLE:
            records, drawn = u64(_of(K, i, ONE)), _of(K, i, OTHER)
            for lane in range(LANES if records > u64(1) else 0):
                taken = u64(who[lane]) % records
                if drawn > 0:
                    word, _a, _b, _c = philox(u32(0), who[lane], u32(stream), u32(_of(K, i, WORD)), k0, k1)
                    taken = (u64(word) * records) >> u64(32)
                state[place * LANES + lane] = taken


@njit(**LINKED)
def _wake_filtered(start, size, word, who, stream, k0, k1, state, normals):
    """Stationary states from normals, by a lower triangle."""
    for i in range(size * LANES):
        state[i] = typed(0.0, start[0])
    for j in range(size):
        if j % GROUP == 0:
            draw(0, who, stream, word + WORDS // 2 + j // GROUP, k0, k1, normals)
        for i in range(j, size):
            share, own = start[i * size + j], (j % GROUP) * LANES
            for lane in range(LANES):
                state[i * LANES + lane] += share * normals[own + lane]


@njit(**LINKED)
def supply_sources(K, D, F, group, who, stream, k0, k1, state, given, spare, normals):
    """The impulses of four steps of all sources, one after another in ``given``."""
    for i in range(K[SOURCES]):
        kind, long, own = _of(K, i, KIND), _of(K, i, LONG), beyond(given, i * GROUP * LANES)
        begun, word, place = beyond(state, _of(K, i, PLACE) * LANES), _of(K, i, WORD), D[K[WAVE] + 2 * i]
        if kind == FILTERED or kind == POISSON:  # noqa: SIM109  (a tuple would be compiled as one)
            parts = K[PARTS]
            for part in range(parts):
                if kind == FILTERED:
                    draw(parts * group + part, who, stream, word, k0, k1, normals)
                    _next_impulses(beyond(F, long), _of(K, i, ONE), begun, own, normals)
                else:
                    _next_shots(
                        D[K[WAVE] + 2 * i], D[K[WAVE] + 2 * i + 1], parts * group + part, who, stream, word, k0, k1,
                        own, normals,
                    )  # fmt: skip
                if parts > 1:
                    _sum_pairs(own, spare, 2 * part)
            shape = 4 + 20 * _of(K, i, ONE) + _of(K, i, OTHER) * _of(K, i, OTHER) if kind == FILTERED else 0
            if _of(K, i, LENGTH) > shape:
                _follow_envelope(beyond(F, long + shape), _of(K, i, LENGTH) - shape, group, own)
        elif kind == HARMONIC:
            for j in range(GROUP):
                angle = D[K[WAVE] + 2 * i + 1] * (GROUP * group + j + 0.5)
                cosine, sine = typed(place * math.cos(angle), F[0]), typed(place * math.sin(angle), F[0])
                for lane in range(LANES):
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
                    record = int(begun[lane]) if records > 1 else 0
                    own[j * LANES + lane] = F[long + record * steps + n] if n < steps else typed(0.0, F[0])


@njit(**INLINE)
def _follow_envelope(envelope, steps, group, own):
    for j in range(GROUP):
        n = GROUP * group + j
        factor = envelope[n] if n < steps else typed(0.0, envelope[0])
        for lane in range(LANES):
            own[j * LANES + lane] *= factor


@njit(**INLINE)
def _sum_pairs(given, spare, to):
    """Four impulses of half steps become two of steps, which are put at step ``to`` of the group.

    The first two steps are kept until the second pair is known.
    """
    for lane in range(LANES):
        one, two = given[lane] + given[LANES + lane], given[2 * LANES + lane] + given[3 * LANES + lane]
        if to == 0:
            spare[lane], spare[LANES + lane] = one, two
        else:
            given[lane], given[LANES + lane] = spare[lane], spare[LANES + lane]
            given[2 * LANES + lane], given[3 * LANES + lane] = one, two


@njit(**LINKED)
def _next_impulses(numbers, pairs, state, given, g):
    w0, w1, w2, w3 = numbers[0], numbers[1], numbers[2], numbers[3]
    for lane in range(LANES):
        g0, g1, g2, g3 = g[lane], g[LANES + lane], g[2 * LANES + lane], g[3 * LANES + lane]
        given[lane] = w0 * g0
        given[LANES + lane] = w0 * g1 + w1 * g0
        given[2 * LANES + lane] = w0 * g2 + w1 * g1 + w2 * g0
        given[3 * LANES + lane] = w0 * g3 + w1 * g2 + w2 * g1 + w3 * g0
    for k in range(pairs):
        p, at = beyond(numbers, 4 + 20 * k), 2 * k * LANES
        p0, p1, p2, p3, p4, p5, p6, p7 = p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]
        p8, p9, p10, p11, p12, p13, p14, p15 = p[8], p[9], p[10], p[11], p[12], p[13], p[14], p[15]
        p16, p17, p18, p19 = p[16], p[17], p[18], p[19]
        for lane in range(LANES):
            y, z = state[at + lane], state[at + LANES + lane]
            g0, g1, g2, g3 = g[lane], g[LANES + lane], g[2 * LANES + lane], g[3 * LANES + lane]
            given[lane] += p4 * y + p5 * z
            given[LANES + lane] += p6 * y + p7 * z
            given[2 * LANES + lane] += p8 * y + p9 * z
            given[3 * LANES + lane] += p10 * y + p11 * z
            state[at + lane] = y + (p0 * y + p1 * z + p12 * g0 + p14 * g1 + p16 * g2 + p18 * g3)
            state[at + LANES + lane] = z + (p2 * y + p3 * z + p13 * g0 + p15 * g1 + p17 * g2 + p19 * g3)


@njit(**LINKED)
def _next_shots(rate, scale, group, who, stream, word, k0, k1, given, normals):
    none = math.exp(-rate)
    for lane in range(LANES):
        a, b, c, d = philox(u32(group), who[lane], u32(stream), u32(word), k0, k1)
        for j in range(GROUP):
            own = a if j == 0 else b if j == 1 else c if j == 2 else d
            left = (f64(own) + 0.5) / 4294967296.0
            chance, count = none, 0
            while left > chance and chance > 0.0:
                left -= chance
                count += 1
                chance *= rate / count
            given[j * LANES + lane] = math.sqrt(float(count))
    draw(group, who, stream, word + 1, k0, k1, normals)
    for i in range(GROUP * LANES):
        given[i] *= scale * f64(normals[i])


@njit(**LINKED)
def _next_modulated(numbers, size, steps, length, group, state, given, g):
    """Of white noise (no states), or of a filter that it drives: the best guess of the states, and what is seen."""
    changes = steps * (1 + size)
    laws = (length - changes) // max(size * (size + 1), 1)  # 1 of a filter that does not change
    for j in range(GROUP):
        n, to = GROUP * group + j, j * LANES
        inside, law = n < steps, min(n, laws - 1)
        root = numbers[n] if inside else typed(0.0, numbers[0])
        for lane in range(LANES):
            given[to + lane] = root * g[to + lane]
        for i in range(size):
            seen = numbers[changes + laws * size * size + law * size + i]
            gain = numbers[steps + n * size + i] if inside else typed(0.0, numbers[0])
            for lane in range(LANES):
                given[to + lane] += seen * state[i * LANES + lane]
                state[(size + i) * LANES + lane] = gain * g[to + lane]
            for k in range(size):
                factor = numbers[changes + (law * size + i) * size + k]
                for lane in range(LANES):
                    state[(size + i) * LANES + lane] += factor * state[k * LANES + lane]
        for i in range(size * LANES):
            state[i] += state[size * LANES + i]
