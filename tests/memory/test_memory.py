"""The weights of the past and their exponential sums, against arithmetic in extended precision."""

import itertools

import mpmath as mp
import numpy as np
import pytest

from springpot.memory import ExponentialSum, direct, exponential_sum, power_law_sum
from springpot.memory.exponential_sum import _cells, mclean
from springpot.memory.minimax import fewest_terms, lag_grid
from springpot.memory.weights import at_lags
from tests.sizes import thinned, validation

FAMILIES = ("grunwald", "average")
TARGETS = ("grunwald", "average", "power")
ORDERS = (1e-9, 0.01, 0.25, 0.5, 0.75, 0.99, 1 - 1e-9)


def exact(target: str, order: float, lag: float) -> mp.mpf:
    a, t = mp.mpf(order), mp.mpf(lag)
    if target == "power":
        return t**-a
    if target == "grunwald":
        return mp.gamma(t + 1 - a) / (mp.gamma(1 - a) * mp.gamma(t + 1))
    return ((t + 1) ** (1 - a) - t ** (1 - a)) / mp.gamma(2 - a)


def extended_error(found: ExponentialSum, order: float, lags: np.ndarray) -> float:
    """Largest relative error against t^-alpha; 80-bit arithmetic where the machine has it."""
    t = lags.astype(np.longdouble)
    total = np.zeros(t.size, np.longdouble)
    for rate, weight in zip(found.rates.astype(np.longdouble), found.weights.astype(np.longdouble), strict=True):
        total += weight * np.exp(-rate * t)
    return float(np.abs(total * t ** np.longdouble(order) - 1).max())


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("order", ORDERS)
def test_weights_are_right_to_twelve_digits(target: str, order: float) -> None:
    lags = np.array([1.0, 1.3, 2.0, 3.0, 10.0, 28.7, 1000.0, 99_999.5, 1_000_000.0, 3e7, 1e8])
    with mp.workdps(60):
        wanted = [exact(target, order, float(j)) for j in lags]
        found = [mp.mpf(float(weight)) for weight in at_lags(target, order, lags)]
        errors = [abs(float(f / e - 1)) for f, e in zip(found, wanted, strict=True)]
    assert max(errors) < 1e-13


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("order", ORDERS)
def test_direct_weights_are_those_at_the_lags(family: str, order: float) -> None:
    weights = direct(family, order, 100_001)
    np.testing.assert_allclose(weights[1:], at_lags(family, order, np.arange(1.0, 100_001.0)), rtol=1e-13, atol=0.0)
    assert weights[0] == pytest.approx(float(exact(family, order, 0.0)), rel=1e-14)


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


@pytest.mark.parametrize(
    ("tolerance", "order", "family"), thinned(itertools.product([1e-3, 1e-6, 1e-10, 1e-12], ORDERS, FAMILIES), 3)
)
def test_the_sum_holds_at_lags_it_was_not_fitted_on(tolerance: float, order: float, family: str) -> None:
    steps = 50_000
    found = exponential_sum(family, order, steps, tolerance)
    assert (found.weights > 0.0).all()
    assert (found.rates > 0.0).all()
    assert found.relative_error <= tolerance
    lags = np.unique(np.r_[np.arange(1, 300), np.geomspace(300, steps, 700).astype(int)])
    errors = (np.exp(-np.outer(lags, found.rates)) @ found.weights) / direct(family, order, steps + 1)[lags] - 1.0
    assert np.abs(errors).max() <= 1.02 * found.relative_error + 1e-14


@pytest.mark.parametrize(
    ("order", "tolerance", "most"),
    [
        validation(0.25, 1e-6, 21), (0.5, 1e-6, 23), validation(0.75, 1e-6, 25),
        validation(0.25, 1e-10, 47), (0.5, 1e-10, 47), validation(0.75, 1e-10, 47),
    ],
)  # fmt: skip
def test_power_over_six_decades(order: float, tolerance: float, most: int) -> None:
    """The stored error is the error, at a hundred thousand lags in extended precision, and few terms do."""
    found = power_law_sum(order, 1e-3, 1e3, tolerance)
    assert found.rates.size <= most
    assert (found.rates > 0.0).all()
    assert (found.weights > 0.0).all()
    error = extended_error(found, order, np.geomspace(1e-3, 1e3, 100_000))
    assert error <= tolerance
    assert 0.98 * found.relative_error - 1e-14 <= error <= 1.02 * found.relative_error + 1e-14


def test_power_in_units() -> None:
    unit, scaled = power_law_sum(0.5, 1.0, 1e4), power_law_sum(0.5, 0.25, 2500.0)
    assert np.array_equal(scaled.rates, 4.0 * unit.rates)
    assert np.array_equal(scaled.weights, 2.0 * unit.weights)
    assert (scaled.shortest, scaled.longest) == (0.25, 2500.0)


@pytest.mark.parametrize("arguments", [(0.0, 1, 2), (1.0, 1, 2), (0.5, 0, 1), (0.5, 2, 1), (0.5, 1, 2, 1e-14)])
def test_numbers_out_of_range_are_refused(arguments: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="must be"):
        power_law_sum(*arguments)


@pytest.mark.parametrize(("tolerance", "most"), [(1e-3, 14), (1e-6, 24), validation(1e-8, 33)])
def test_number_of_terms(tolerance: float, most: int) -> None:
    for family in FAMILIES:
        for order in (0.25, 0.5, 0.75):
            assert exponential_sum(family, order, 1_000_000, tolerance).rates.size <= most


def test_the_known_counts_of_mcleans_sum() -> None:
    for order in (0.25, 0.5, 0.75):
        for tolerance, most in ((1e-6, 35), (1e-10, 54), (1e-12, 66)):
            rates, weights, error = mclean("grunwald", order, 1e6, tolerance)
            assert rates.size <= most
            assert min(rates.min(), weights.min()) > 0.0
            assert error <= tolerance


@pytest.mark.parametrize("target", TARGETS)
def test_the_error_alternates_so_no_shorter_sum_will_do(target: str) -> None:
    """With 2 n + 1 level extremes the sum is the best one with n terms; the best one with n - 1 is not enough."""
    order, longest, tolerance = 0.4, 1e5, 1e-6
    found = fewest_terms(
        lambda t: at_lags(target, order, t),
        lambda n, stretch: _cells(target, order, longest, n, stretch),
        longest,
        tolerance,
    )
    assert found is not None
    assert found.fewest
    lags = lag_grid(longest, 20_000)
    errors = (np.exp(-np.outer(lags, found.rates)) @ found.weights) / at_lags(target, order, lags) - 1.0
    runs = np.split(errors, np.flatnonzero(np.diff(np.sign(errors))) + 1)
    sizes = np.array([np.abs(run).max() for run in runs])
    assert sizes.size == 2 * found.rates.size + 1
    assert sizes.min() > 0.99 * sizes.max()


@pytest.mark.parametrize(
    ("steps", "tolerance"), thinned(itertools.product([1, 2, 3, 7, 100_000_000], [1e-2, 1e-7, 1e-13]), 4)
)
def test_every_length_and_tolerance_has_a_positive_sum(steps: int, tolerance: float) -> None:
    for family in FAMILIES:
        for order in (1e-9, 0.5, 1 - 1e-9):
            found = exponential_sum(family, order, steps, tolerance)
            assert found.relative_error <= tolerance
            assert (found.rates > 0.0).all()
            assert (found.weights > 0.0).all()
            lags = np.unique(np.geomspace(1, steps, 50).astype(int))
            errors = (np.exp(-np.outer(lags, found.rates)) @ found.weights) / at_lags(family, order, lags * 1.0) - 1.0
            assert np.abs(errors).max() <= 1.02 * tolerance + 1e-14


@pytest.mark.parametrize("order", [5e-324, 1e-310, 1e-200])
def test_an_order_next_to_0_has_a_memory_that_does_not_fade(order: float) -> None:
    memory = exponential_sum("average", order, 1000, 1e-6)
    kept = np.exp(-np.outer([1.0, 1000.0], memory.rates)) @ memory.weights
    np.testing.assert_allclose(kept, 1.0, rtol=1e-6)
