"""One root between two places, without SciPy."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from scipy import optimize

from springpot.machine.roots import root_between


@pytest.mark.parametrize(
    ("function", "low", "high"),
    [
        (lambda x: x * x - 2.0, 0.0, 2.0),
        (lambda x: math.tanh(1e5 * (x - 0.1)), -3.0, 5.0),
        (lambda x: math.exp(50.0 * x) - 1e-8, -4.0, 3.0),
        (lambda x: x**3 - 1e-30, -1.0, 1e6),
        (lambda x: (x - 3.0) ** 5, -1e3, 8.0),
        (lambda x: math.inf if x > 1.0 else x - 0.3, -1.0, 2.0),
    ],
)
def test_roots_are_those_of_scipy(function: Callable[[float], float], low: float, high: float) -> None:
    close = {"xtol": 1e-300, "rtol": 1e-14}
    theirs = optimize.brentq(function, low, high, maxiter=5000, **close)
    assert root_between(function, low, high, **close) == pytest.approx(theirs, rel=1e-13)
    assert root_between(function, high, low, **close) == pytest.approx(theirs, rel=1e-13)


def test_an_end_that_is_a_root_is_it() -> None:
    assert root_between(lambda x: x, 0.0, 1.0) == root_between(lambda x: x, -1.0, 0.0) == 0.0


def test_equal_signs_are_refused() -> None:
    with pytest.raises(ValueError, match="function must have different signs"):
        root_between(lambda x: x + 2.0, 0.0, 1.0)
