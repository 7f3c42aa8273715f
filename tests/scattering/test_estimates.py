"""Mean, scatter, quantiles and indices of devices, against exact ones: the paths are made here, with a known spread."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy
from scipy.special import ndtri

from springpot.machine.arrays import Floats
from springpot.problem.free_numbers import uncertain_numbers
from springpot.problem.uncertain import LEAST_CHANCE
from springpot.scattering.devices import correlated, drawn
from springpot.scattering.estimates import SCRAMBLINGS, Estimates, Means, estimated
from springpot.scattering.surface import SETS, polynomials, powers_of
from tests.scattering.problems import (
    ALONE,
    DEVIATION,
    MEAN,
    NAMES,
    OSCILLATOR,
    PRODUCT,
    QUANTILES,
    SUM,
    TOGETHER,
    Exact,
    device,
    mean_square,
)
from tests.sizes import validation

NUMBERS = uncertain_numbers(device())
NORMAL = tuple(number.law.is_gaussian for number in NUMBERS.values())


def made(trial: int, *, devices: int, paths: int, spread: float, of: Exact = OSCILLATOR) -> Means:
    """Gamma variates about the result of each device; ``spread`` is the ratio of both variances."""
    numbers = uncertain_numbers(of.system)
    normal = tuple(number.law.is_gaussian for number in numbers.values())
    draws = drawn(numbers, devices, trial)
    exact = of.result(dict(zip(numbers, draws.values.T, strict=True)))[:, None]
    shape = (1.0 + (of.mean / of.deviation) ** 2) / spread
    values = exact * np.random.default_rng(trial).gamma(shape, 1.0 / shape, (devices, paths))
    new = (
        scipy.stats.qmc.Sobol(len(numbers) + 1, scramble=True, rng=np.random.default_rng(7)).random(4096) + LEAST_CHANCE
    )
    return Means(
        scored(draws.chances, normal), normal, values, scored(new[:, : len(normal)], normal), ndtri(new[:, -1])
    )  # fmt: skip


def scored(chances: Floats, normal: tuple[bool, ...] = NORMAL) -> Floats:
    return np.where(normal, ndtri(chances), chances)


def found(means: Means, *limits: float, of: Exact = OSCILLATOR) -> Estimates:
    names = [*uncertain_numbers(of.system)]
    return estimated(means, names, [[n] for n in range(len(names))], limits)


@pytest.mark.parametrize(("devices", "paths"), [(512, 8), validation(1024, 4), validation(64, 64)])
def test_intervals_hold_what_is_exact(devices: int, paths: int) -> None:
    """With paths that differ six times as much as the devices."""
    estimates = found(made(1, devices=devices, paths=paths, spread=6.4), 2.5)
    wide = 1.6  # of a few trials some lie beyond 95 %; a wrong formula is farther off
    pairs = [
        (estimates.mean, MEAN), (estimates.scatter, DEVIATION), (estimates.above[2.5], 0.029),
        *((estimates.quantiles[share], exact) for share, exact in QUANTILES.items()),
        *((estimates.alone[name], ALONE[name]) for name in NAMES),
        *((estimates.together[name], TOGETHER[name]) for name in NAMES),
    ]  # fmt: skip
    for interval, exact in pairs:
        middle, half = 0.5 * (interval.low + interval.high), 0.5 * (interval.high - interval.low)
        assert abs(exact - middle) < wide * half + 5e-3
    assert estimates.path_scatter == pytest.approx(math.sqrt(6.4) * DEVIATION, rel=0.1)
    assert estimates.quantiles[0.95].value < estimates.tolerance


@pytest.mark.validation
@pytest.mark.parametrize("spread", [1.4, 6.4])
@pytest.mark.parametrize("of", [OSCILLATOR, SUM, PRODUCT], ids=["oscillator", "sum", "product"])
def test_intervals_cover_as_they_say(of: Exact, spread: float) -> None:
    """Of 100 trials 90 to 100 for each number: a coverage of 95 % is known to 2 %."""
    covered: dict[str, int] = {}
    for trial in range(100):
        estimates = found(made(trial, devices=512, paths=8, spread=spread, of=of), of=of)
        pairs = {
            "mean": (estimates.mean, of.mean), "scatter": (estimates.scatter, of.deviation),
            **{f"{share}": (estimates.quantiles[share], exact) for share, exact in of.quantiles.items()},
            **{f"alone {name}": (estimates.alone[name], exact) for name, exact in of.alone.items()},
            **{f"together {name}": (estimates.together[name], exact) for name, exact in of.together.items()},
        }  # fmt: skip
        for name, (interval, exact) in pairs.items():
            covered[name] = covered.get(name, 0) + (interval.low <= exact <= interval.high)
    assert min(covered.values()) >= 88, covered
    assert np.mean([*covered.values()]) > 92.0, covered


@pytest.mark.validation  # every day: devices that are exactly alike, below
def test_without_scatter_there_is_none() -> None:
    """All devices alike: in one of 20 runs it seems to be seen."""
    means, seen = made(3, devices=256, paths=8, spread=1.4), 0
    for seed in range(20):
        alike = replace(means, values=np.random.default_rng(seed).gamma(4.0, 0.25, (256, 8)))
        estimates = found(alike)
        seen += estimates.scatter.value > 0.0
        assert estimates.mean.low < 1.03
        assert (not estimates.alone) == (estimates.scatter.value == 0.0)
        assert estimates.scatter.high < 0.2
    assert seen <= 3


def test_exactly_without_scatter_there_is_none() -> None:
    means = made(3, devices=256, paths=8, spread=1.4)
    for rounded in (0.0, 1e-15):
        exactly = found(replace(means, values=2.0 + rounded * np.random.default_rng(1).normal(size=(256, 8))))
        assert (exactly.scatter.value, exactly.alone) == (0.0, {})


def test_quantiles_of_a_curved_result() -> None:
    """A rate that falls like exp(-gap^2 / 2): the polynomial of its logarithm holds it."""
    means = made(3, devices=512, paths=8, spread=1.4)
    gap = means.scores[:, 1]  # a normal score
    values = np.random.default_rng(4).poisson(60.0 * np.exp(-0.5 * (gap[:, None] + 1.5) ** 2), (512, 8)) / 20.0
    new = means.new[:, 1]
    exact = 3.0 * np.exp(-0.5 * (new + 1.5) ** 2)
    estimates = found(replace(means, values=values), 2.0)
    for share, quantile in estimates.quantiles.items():
        assert quantile.value == pytest.approx(float(np.quantile(exact, share)), rel=0.15, abs=0.02)
        assert quantile.low >= 0.0
    assert estimates.above[2.0].value == pytest.approx(float((exact > 2.0).mean()), abs=0.03)


def test_polynomials_are_orthonormal() -> None:
    """By Gauss's rules, of both families."""
    for rule, normal in ((np.polynomial.legendre.leggauss, False), (np.polynomial.hermite_e.hermegauss, True)):
        at, weight = rule(12)
        places = at if normal else 0.5 * (at + 1.0)
        x, y = (each.ravel() for each in np.meshgrid(places, places))
        share = np.outer(weight, weight).ravel() / weight.sum() ** 2
        terms = polynomials(np.column_stack([x, y]), (normal, normal), powers_of(2, 4, 1.0))
        np.testing.assert_allclose(terms.T @ (share[:, None] * terms), np.eye(terms.shape[1]), atol=1e-12)
    assert [len(powers_of(5, *own)) for own in SETS] == [6, 11, 21, 26, 56, 31]


def test_numbers_that_vary_together() -> None:
    """A Gaussian copula: with laws of their own, and one index for both."""
    together = correlated({("k", "c"): 0.8, ("f", "m"): -0.3}, NUMBERS)
    draws = drawn(NUMBERS, 4096, 1, together)
    k, c, f, m, q = (draws.values[:, [*NUMBERS].index(name)] for name in "kcfmq")
    assert scipy.stats.spearmanr(k, c)[0] == pytest.approx(6.0 / math.pi * math.asin(0.4), abs=0.02)
    assert scipy.stats.spearmanr(f, m)[0] == pytest.approx(-6.0 / math.pi * math.asin(0.15), abs=0.02)
    assert abs(scipy.stats.spearmanr(k, q)[0]) < 0.05
    assert c.mean() == pytest.approx(0.1, rel=2e-3)
    names = [*NUMBERS]
    assert [[names[n] for n in group] for group in together.groups] == [["m", "f"], ["k", "c"], ["q"]]
    exact = mean_square(dict(zip(NUMBERS, draws.values.T, strict=True)))
    values = exact[:, None] * np.random.default_rng(1).gamma(20.0, 0.05, (4096, 4))
    scores = np.where(
        [each or tied for each, tied in zip(NORMAL, together.tied, strict=True)], ndtri(draws.chances), draws.chances
    )
    normal = tuple(each or tied for each, tied in zip(NORMAL, together.tied, strict=True))
    means = Means(scores, normal, values, scores, scores[:, 0])
    own = estimated(means, ["mf", "kc", "q"], together.groups, [])
    assert own.scatter.value == pytest.approx(float(exact.std()), rel=0.03)
    assert sum(each.value for each in own.together.values()) == pytest.approx(1.0, abs=0.05)
    assert own.alone["kc"].value > 0.35 > own.alone["q"].value


def test_draws_are_of_the_laws_and_of_the_seed() -> None:
    one, other = drawn(NUMBERS, 1024, 1), drawn(NUMBERS, 1024, 2)
    assert not np.array_equal(one.values, other.values)
    np.testing.assert_array_equal(one.values, drawn(NUMBERS, 1024, 1).values)
    assert SCRAMBLINGS == 16
    k, c, m = (one.values[:, [*NUMBERS].index(name)] for name in "kcm")
    assert k.mean() == pytest.approx(1.0, abs=1e-3)
    assert k.std() == pytest.approx(0.05, rel=0.02)
    assert c.mean() == pytest.approx(0.1, rel=1e-3)
    assert 0.9 <= m.min() < m.max() <= 1.1
