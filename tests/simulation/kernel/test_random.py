"""The generator: published known answers, the law of the normals, and the ends of the range of words."""

import math

import numpy as np
import pytest
import scipy
from numba import njit
from scipy import special

from springpot.simulation.kernel import random as source
from springpot.simulation.kernel.native import normals
from tests.sizes import validation


@njit
def _philox(c, k):  # type: ignore[no-untyped-def]
    return source.philox(c[0], c[1], c[2], c[3], k[0], k[1])


@njit
def _box_muller(radius, angle):  # type: ignore[no-untyped-def]
    return source.box_muller(radius, angle)


# Random123 1.14, tests/kat_vectors, philox4x32 with 10 rounds
KNOWN = [
    ([0] * 4, [0] * 2, [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8]),
    ([0xFFFFFFFF] * 4, [0xFFFFFFFF] * 2, [0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD]),
    (
        [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344],
        [0xA4093822, 0x299F31D0],
        [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1],
    ),
]


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN)
def test_philox_known_answers(counter: list[int], key: list[int], answer: list[int]) -> None:
    words = _philox(np.array(counter, np.uint32), np.array(key, np.uint32))
    assert [int(w) for w in words] == answer


def test_every_extreme_word_gives_a_finite_normal() -> None:
    ends = [np.uint32(w) for w in (0, 1, 2, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1)]
    for radius in ends:
        for angle in ends:
            assert all(math.isfinite(g) for g in _box_muller(radius, angle))
    assert math.hypot(*_box_muller(np.uint32(0), np.uint32(0))) > 6.6


def test_box_muller_against_double_precision() -> None:
    rng = np.random.default_rng(5)
    for radius, angle in rng.integers(0, 2**32, (2000, 2), dtype=np.uint32):
        r = math.sqrt(-2.0 * math.log(((int(radius) >> 1) + 0.5) / 2**31))
        from_axis = math.pi / 4.0 * ((int(angle) << 2) % 2**32 / 2**31 - 2.0 * (int(angle) >> 29 & 1))
        on_axis = -math.cos(from_axis) if int(angle) >> 31 else math.cos(from_axis)
        pair = (math.sin(from_axis), on_axis)[:: -1 if int(angle) >> 30 & 1 else 1]
        assert _box_muller(radius, angle) == pytest.approx((r * pair[0], r * pair[1]), abs=1e-6)


@pytest.mark.parametrize("count", [6_400_000, validation(100_000_000)])
def test_the_law_of_millions_of_normals(count: int) -> None:
    chunk = 6_400_000
    edges = np.linspace(-4.0, 4.0, 2001)
    sums, tails, histogram, total = np.zeros(8), np.zeros(3), np.zeros(edges.size + 1), 0
    for seed in range(-(-count // chunk)):
        g = normals(seed=seed, paths=64, steps=chunk // 64).ravel()[: count - total]
        total += g.size
        power = np.ones(g.size)
        for k in range(8):
            power *= g
            sums[k] += power.sum()
        size = np.abs(g)
        tails += [(size > 3).sum(), (size > 4).sum(), (size > 5).sum()]
        histogram += np.bincount(np.searchsorted(edges, g, side="right"), minlength=edges.size + 1)
    assert total == count

    moments = [float(special.factorial2(k - 1)) if k % 2 == 0 else 0.0 for k in range(1, 17)]
    for k in range(1, 9):
        error = math.sqrt((moments[2 * k - 1] - moments[k - 1] ** 2) / count)
        assert abs(sums[k - 1] / count - moments[k - 1]) < 4 * error, f"moment {k}"
    for level, found in zip((3, 4, 5), tails, strict=True):
        expected = count * 2.0 * scipy.stats.norm.sf(level)
        assert abs(found - expected) < 4 * math.sqrt(expected), f"beyond {level}"
    # Kolmogorov-Smirnov on 2001 points of the distribution function: 4 standard errors of a two-sided normal
    distance = np.abs(np.cumsum(histogram)[:-1] / count - scipy.stats.norm.cdf(edges)).max()
    assert scipy.stats.kstwobign.sf(distance * math.sqrt(count)) > 6.3e-5


def test_paths_do_not_depend_on_how_many_there_are() -> None:
    few, many = normals(7, 3, 50), normals(7, 200, 70)
    assert np.array_equal(few, many[:3, :50])
    assert not np.array_equal(normals(8, 3, 50), few)
    assert not np.array_equal(normals(7, 3, 50, stream=1), few)
