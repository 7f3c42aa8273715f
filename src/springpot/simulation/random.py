"""Counter-based normals: the four steps of group ``g`` on path ``p`` of stream ``s`` are a function of (seed, s, p, g).

Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11) gives four 32-bit words,
and the transform of Box and Muller two pairs of normals.  Nothing depends on the order of evaluation, so the same seed
gives the same path for any number of threads or blocks.

The logarithm is the single-precision polynomial of the Cephes library; the radius uses 31 bits of its word, so the
largest normal is 6.66, which a Gaussian exceeds once in 4e10 draws.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.simulation.lanes import (
    FAST,
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

__all__ = ["box_muller", "draw", "normals", "philox", "start_normals"]

_WORD = u64(0xFFFFFFFF)
_START = 0x40000000  # counter word of the normals of the start
_four_lanes = stack_array(GROUP * LANES)


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
def _log(x):
    """Natural logarithm of a positive normal float32 (Cephes ``logf``)."""
    i = bits_of(x)
    exponent = i32(((i >> i32(23)) & i32(255)) - i32(126))
    m = float_of(i32((i & i32(0x007FFFFF)) | i32(0x3F000000)))
    low = m < f32(0.70710678)
    exponent = i32(exponent - (i32(1) if low else i32(0)))
    m = (m + m if low else m) - f32(1)
    z = m * m
    y = f32(7.0376836292e-2)
    y = y * m - f32(1.1514610310e-1)
    y = y * m + f32(1.1676998740e-1)
    y = y * m - f32(1.2420140846e-1)
    y = y * m + f32(1.4249322787e-1)
    y = y * m - f32(1.6668057665e-1)
    y = y * m + f32(2.0000714765e-1)
    y = y * m - f32(2.4999993993e-1)
    y = y * m + f32(3.3333331174e-1)
    e = f32(exponent)
    return m + y * m * z - f32(2.12194440e-4) * e - f32(0.5) * z + f32(0.693359375) * e


@njit(**INLINE)
def _sine_cosine_of_turn(word):
    """Sine and cosine of 2 pi word / 2^32, by quadrant and minimax polynomials on [-pi/4, pi/4]."""
    quadrant = i32(u32(word + u32(0x20000000)) >> u32(30))
    f = f32(i32(u32(word - u32(u32(quadrant) << u32(30))))) * f32(1.4629180792671596e-09)
    z = f * f
    s = ((f32(-1.9515295891e-4) * z + f32(8.3321608736e-3)) * z - f32(1.6666654611e-1)) * z * f + f
    c = (
        ((f32(2.443315711809948e-5) * z - f32(1.388731625493765e-3)) * z + f32(4.166664568298827e-2)) * z * z
        - f32(0.5) * z
        + f32(1)
    )
    swap = (quadrant & i32(1)) != i32(0)
    sine = c if swap else s
    cosine = s if swap else c
    return (
        -sine if (quadrant & i32(2)) != i32(0) else sine,
        -cosine if ((quadrant + i32(1)) & i32(2)) != i32(0) else cosine,
    )


@njit(**INLINE)
def box_muller(radius_word, angle_word):
    """Two independent normals from two 32-bit words; finite for every word."""
    uniform = (f32(i32(radius_word >> u32(1))) + f32(0.5)) * f32(4.656612873077393e-10)
    # the largest words round to uniform = 1, whose computed logarithm may be slightly positive
    radius = np.sqrt(max(f32(-2) * _log(uniform), f32(0)))
    s, c = _sine_cosine_of_turn(angle_word)
    return radius * s, radius * c


@njit(**INLINE)
def draw(group, first, stream, word, k0, k1, g):
    """Fill ``g[step * LANES + lane]`` with the normals of four steps on the paths ``first + lane``.

    ``word`` is 0 for white noise; other noise has numbers of its own.
    """
    for lane in range(LANES):
        c0, c1, c2, c3 = philox(u32(group), u32(first + lane), u32(stream), u32(word), k0, k1)
        a, b = box_muller(c0, c1)
        c, d = box_muller(c2, c3)
        g[lane] = a
        g[LANES + lane] = b
        g[2 * LANES + lane] = c
        g[3 * LANES + lane] = d


@njit(nogil=True, **FAST)
def _fill(first, stream, word, k0, k1, out):
    g = _four_lanes(f32(0))
    paths, steps = out.shape
    for group in range((steps + GROUP - 1) // GROUP):
        draw(group, first, stream, word, k0, k1, g)
        for lane in range(min(LANES, paths)):
            for j in range(min(GROUP, steps - GROUP * group)):
                out[lane, GROUP * group + j] = g[j * LANES + lane]


def normals(seed: int, paths: int, steps: int, *, stream: int = 0) -> npt.NDArray[np.float32]:
    """The normals of a run: element [p, n] is that of step n of path p.

    Parameters
    ----------
    seed : int
        0 <= seed < 2^64.
    paths, steps : int
    stream : int
        0 for the run itself; the pilot runs of an adapted start use the ones after it.

    Returns
    -------
    ndarray of float32, shape (paths, steps)

    Examples
    --------
    >>> normals(seed=1, paths=2, steps=5).shape
    (2, 5)
    """
    out = np.empty((paths, steps), np.float32)
    k0, k1 = key_words(seed)
    for first in range(0, paths, LANES):
        _fill(first, stream, 0, k0, k1, out[first : first + LANES])
    return out


def start_normals(seed: int, first: int, paths: int, *, stream: int = 0) -> npt.NDArray[np.float32]:
    """Four normals for the start of each of the paths ``first`` ..., independent of those of the run.

    Parameters
    ----------
    seed, first, paths, stream : int
        ``first`` is a multiple of LANES.

    Returns
    -------
    ndarray of float32, shape (paths, 4)

    Examples
    --------
    >>> bool((start_normals(1, 64, 64) == start_normals(1, 0, 128)[64:]).all())
    True
    """
    out = np.empty((paths, GROUP), np.float32)
    k0, k1 = key_words(seed)
    for begin in range(0, paths, LANES):
        _fill(first + begin, stream, _START, k0, k1, out[begin : begin + LANES])
    return out


def key_words(seed: int) -> tuple[np.uint32, np.uint32]:
    """The two 32-bit words of a 64-bit seed, low word first."""
    return u32(seed & 0xFFFFFFFF), u32(seed >> 32)
