"""Vectors of lanes are numbers of NumPy, lane by lane, in single and in double precision."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from springpot.simulation.kernel import vectors
from springpot.simulation.kernel.lanes import WIDTH, stack_array
from springpot.simulation.kernel.vectors import (
    choose,
    double,
    filled,
    larger,
    like,
    load,
    opposite,
    power,
    root,
    size,
    smaller,
    some,
    store,
)

OF_NUMBERS = {
    "sum": lambda a, b: a + b, "difference": lambda a, b: a - b, "product": lambda a, b: a * b,
    "quotient": lambda a, b: a / b, "a number before": lambda a, b: 0.75 - b, "one behind": lambda a, b: a * 0.75,
    "smaller": np.minimum, "larger": np.maximum, "root": lambda a, b: np.sqrt(np.abs(b)),
    "power": lambda a, b: np.abs(b) ** 1.5, "chosen": lambda a, b: np.where((a < b) & ~(b >= 1.0) | (a == 0.5), a, b),
    "a number chosen": lambda a, b: np.where((b > 0.0) | (a <= 0.0), a, 2.0), "filled": lambda a, b: 0.0 * a + 0.3,
}  # fmt: skip
_own = stack_array(3 * WIDTH)


@njit(_nrt=False)
def _all(like_it, first, second, found):  # type: ignore[no-untyped-def]
    """All of OF_NUMBERS of two vectors, one after another; whether any lane is larger; and the sum in double."""
    own = _own(like_it)
    for i in range(WIDTH):
        own[i], own[WIDTH + i] = first[i], second[i]
    a, b, to = load(own, 0), load(own, WIDTH), 2 * WIDTH
    both = (
        a + b, a - b, a * b, a / b, 0.75 - b, a * 0.75, smaller(a, b), larger(a, b), root(size(b)),
        power(size(b), filled(b, 1.5)), choose((a < b) & opposite(b >= 1.0) | (a == 0.5), a, b),
        choose((b > 0.0) | (a <= 0.0), a, 2.0), like(own, 0.3),
    )  # fmt: skip
    for k in range(len(both)):
        store(own, to, both[k])
        for i in range(WIDTH):
            found[k, i] = own[to + i]
    wide = _own(0.0)
    store(wide, 0, double(a) + b)
    for i in range(WIDTH):
        found[len(both), i] = wide[i]
    return some(a > b)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_vectors_are_numbers_lane_by_lane(kind: type) -> None:
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, WIDTH)).astype(kind)
    a[3], a[5], b[5] = 0.5, -2.0, 3.0
    found = np.empty((len(OF_NUMBERS) + 1, WIDTH))
    assert _all(kind(0), a, b, found)
    for row, (name, made) in zip(found, OF_NUMBERS.items(), strict=False):
        # a power and a quotient may differ in the last digit from those of the C library
        np.testing.assert_allclose(row, made(a, b), rtol=4.0 * np.finfo(kind).eps, err_msg=name)
    np.testing.assert_array_equal(found[-1], a.astype(float) + b.astype(float))
    assert not _all(kind(0), np.minimum(a, b), b, found)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_no_number_is_neither_smaller_nor_larger(kind: type) -> None:
    """So a path that diverged has no events, and the loops over them end."""
    a, b = np.full((2, WIDTH), np.nan).astype(kind)
    b[:] = 1.0
    found = np.empty((len(OF_NUMBERS) + 1, WIDTH))
    assert not _all(kind(0), a, b, found)
    chosen = found[list(OF_NUMBERS).index("chosen")]
    np.testing.assert_array_equal(chosen, b)


def test_a_vector_has_the_lanes_of_the_registers() -> None:
    assert WIDTH in (32, 64)
    assert vectors.v32.llvm.count == vectors.v64.llvm.count == vectors.mask.llvm.count == WIDTH
