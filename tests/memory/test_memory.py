"""The weights of the past and their exponential sums, against arithmetic in extended precision."""

import mpmath as mp
import numpy as np
import pytest

from springpot.memory import direct, exponential_sum
from springpot.memory.weights import at_lags

FAMILIES = ("grunwald", "average")
ORDERS = (1e-9, 0.01, 0.25, 0.5, 0.75, 0.99, 1 - 1e-9)


def exact(family: str, order: float, lag: int) -> mp.mpf:
    a, j = mp.mpf(order), mp.mpf(lag)
    if family == "grunwald":
        return mp.gamma(j + 1 - a) / (mp.gamma(1 - a) * mp.gamma(j + 1))
    return ((j + 1) ** (1 - a) - j ** (1 - a)) / mp.gamma(2 - a)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("order", ORDERS)
def test_direct_weights_are_right_to_twelve_digits(family: str, order: float) -> None:
    lags = np.array([0, 1, 2, 3, 10, 1000, 99_999, 1_000_000, 30_000_000])
    with mp.workdps(50):
        wanted = [exact(family, order, int(j)) for j in lags]
        found = [mp.mpf(float(weight)) for weight in at_lags(family, order, lags)]
        errors = [abs(float(f / e - 1)) for f, e in zip(found, wanted, strict=True)]
    assert max(errors) < 1e-12
    assert np.array_equal(direct(family, order, 11)[lags[:5]], at_lags(family, order, lags)[:5])


def test_grunwald_weights_are_partial_sums_of_the_binomial_series() -> None:
    with mp.workdps(30):
        binomial = [(-1) ** j * mp.binomial(mp.mpf("0.3"), j) for j in range(50)]
        sums = [float(mp.fsum(binomial[: j + 1])) for j in range(50)]
    assert direct("grunwald", 0.3, 50) == pytest.approx(sums, rel=1e-13)


def test_ends_of_the_range_of_orders() -> None:
    for family in FAMILIES:
        assert direct(family, 1.0, 3) == pytest.approx([1.0, 0.0, 0.0], abs=1e-15)
        assert direct(family, 0.0, 3) == pytest.approx([1.0, 1.0, 1.0], rel=1e-15)
        assert exponential_sum(family, 1.0, 100).rates.size == 0
        spring = exponential_sum(family, 0.0, 100)
        assert (spring.rates.tolist(), spring.weights.tolist()) == ([0.0], [1.0])


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-10, 1e-12])
def test_the_sum_holds_at_lags_it_was_not_fitted_on(family: str, order: float, tolerance: float) -> None:
    steps = 50_000
    found = exponential_sum(family, order, steps, tolerance)
    assert (found.weights > 0.0).all()
    assert (found.rates >= 0.0).all()
    lags = np.unique(np.r_[np.arange(1, 300), np.geomspace(300, steps, 700).astype(int)])
    errors = (np.exp(-np.outer(lags, found.rates)) @ found.weights) / direct(family, order, steps + 1)[lags] - 1.0
    assert np.abs(errors).max() <= 1.3 * tolerance


def test_number_of_terms() -> None:
    """Grunwald-Letnikov weights of a million steps: the counts that this construction is known to need."""
    for order in (0.25, 0.5, 0.75):
        assert exponential_sum("grunwald", order, 1_000_000, 1e-6).rates.size <= 35
        assert exponential_sum("grunwald", order, 1_000_000, 1e-10).rates.size <= 54
        assert exponential_sum("grunwald", order, 1_000_000, 1e-12).rates.size <= 66
