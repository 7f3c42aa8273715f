"""Counter-based normals: the four steps of group ``g`` on path ``p`` of stream ``s`` are a function of (seed, s, p, g).

Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11) gives four 32-bit words,
and the transform of Box and Muller two pairs of normals.  Nothing depends on the order of evaluation, so the same seed
gives the same path for any number of threads or blocks.

The radius uses 31 bits of its word, so the largest normal is 6.66, which a Gaussian exceeds once in 4e10 draws.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from springpot.simulation.kernel.lanes import (
    GROUP,
    INLINE,
    LANES,
    bits_of,
    f32,
    float_of,
    i32,
    stack_array,
    u32,
    u64,
)

_WORD = u64(0xFFFFFFFF)
_ROOT_HALF = i32(0x3F3504F3)  # bits of sqrt(1/2)
_four_lanes = stack_array(GROUP * LANES)
lane_numbers = stack_array(LANES)


@njit(**INLINE)
def philox(c0, c1, c2, c3, k0, k1):
    """Philox4x32-10 of a counter of four words and a key of two, in 64-bit lanes (no narrowing between rounds)."""
    c0, c1, c2, c3, k0, k1 = u64(c0), u64(c1), u64(c2), u64(c3), u64(k0), u64(k1)
    for _ in range(10):
        p0 = u64(0xD2511F53) * c0
        p1 = u64(0xCD9E8D57) * c2
        c0, c1, c2, c3 = (p1 >> u64(32)) ^ c1 ^ k0, p1 & _WORD, (p0 >> u64(32)) ^ c3 ^ k1, p0 & _WORD
        k0 = (k0 + u64(0x9E3779B9)) & _WORD
        k1 = (k1 + u64(0xBB67AE85)) & _WORD
    return u32(c0), u32(c1), u32(c2), u32(c3)


@njit(**INLINE)
def _minus_two_log(x):
    """-2 log(x) of a positive normal float32 that is at most 1, not below 0.

    x = 2^e (1 + m) with 1 + m from sqrt(1/2) to sqrt(2); -2 log(1 + m) / m is a polynomial of degree 7, the best one in
    the relative maximum norm, whose error of 1.7e-7 is that of rounding.
    """
    shifted = i32(bits_of(x) - _ROOT_HALF)
    e = f32(i32(shifted >> i32(23)))
    m = float_of(i32((shifted & i32(0x007FFFFF)) + _ROOT_HALF)) - f32(1)
    y = f32(0.2021367996931076) * m - f32(0.3244527280330658)
    y = y * m + f32(0.3450174331665039)
    y = y * m - f32(0.39800316095352173)
    y = y * m + f32(0.4993980824947357)
    y = y * m - f32(0.6667011976242065)
    y = y * m + f32(1.0000072717666626)
    y = y * m - f32(1.9999998807907104)
    return y * m - f32(1.3862943611198906) * e


@njit(**INLINE)
def _sine_cosine(word):
    """Sine and cosine of an angle that is uniform on the circle: minimax polynomials on [-pi/4, pi/4].

    The last 30 bits of the word are the angle from the nearest axis; of the other two, one exchanges sine and cosine,
    and one is the sign of that on the axis.
    """
    f = f32(i32(u32(word << u32(2)))) * f32(3.657295198167899e-10)  # pi / 4 / 2^31
    z = f * f
    s = ((f32(-1.9515295891e-4) * z + f32(8.3321608736e-3)) * z - f32(1.6666654611e-1)) * z * f + f
    c = (
        ((f32(2.443315711809948e-5) * z - f32(1.388731625493765e-3)) * z + f32(4.166664568298827e-2)) * z * z
        - f32(0.5) * z
        + f32(1)
    )
    c = float_of(i32(bits_of(c) ^ i32(u32(word & u32(0x80000000)))))
    swap = i32(u32(word << u32(1))) < i32(0)
    return c if swap else s, s if swap else c


@njit(**INLINE)
def box_muller(radius_word, angle_word):
    """Two independent normals from two 32-bit words; finite for every word."""
    uniform = (f32(i32(radius_word >> u32(1))) + f32(0.5)) * f32(4.656612873077393e-10)
    radius = np.sqrt(_minus_two_log(uniform))
    s, c = _sine_cosine(angle_word)
    return radius * s, radius * c


@njit(**INLINE)
def number_lanes(first, who):
    """Give the lanes the numbers of the paths from ``first`` on."""
    for lane in range(LANES):
        who[lane] = u32(first + lane)


@njit(**INLINE)
def draw(group, who, stream, word, k0, k1, g):
    """Fill ``g[step * LANES + lane]`` with the normals of four steps on the paths ``who[lane]``.

    ``word`` is 0 for white noise; other noise has numbers of its own.
    """
    for lane in range(LANES):
        c0, c1, c2, c3 = philox(u32(group), who[lane], u32(stream), u32(word), k0, k1)
        a, b = box_muller(c0, c1)
        c, d = box_muller(c2, c3)
        g[lane] = a
        g[LANES + lane] = b
        g[2 * LANES + lane] = c
        g[3 * LANES + lane] = d


@njit(**INLINE)
def draw_for_steps(group, who, stream, word, k0, k1, halved, g, fine):
    """As `draw`; with ``halved``, each normal combines two of a run with half the step, which are in ``fine``."""
    for half in range(2 if halved else 1):
        draw(2 * group + half if halved else group, who, stream, word, k0, k1, fine if halved else g)
        for i in range(2 * LANES if halved else 0):
            pair = i // LANES * 2 * LANES + i % LANES
            g[2 * half * LANES + i] = f32(0.7071067811865476) * (fine[pair] + fine[pair + LANES])


def fill_normals(first, stream, word, k0, k1, paths, steps, out):
    """Compiled code only: the normals of up to LANES paths, one path after another."""
    g, who = _four_lanes(f32(0)), lane_numbers(u32(0))
    number_lanes(first, who)
    for group in range((steps + GROUP - 1) // GROUP):
        draw(group, who, stream, word, k0, k1, g)
        for lane in range(min(LANES, paths)):
            for j in range(min(GROUP, steps - GROUP * group)):
                out[lane * steps + GROUP * group + j] = g[j * LANES + lane]
