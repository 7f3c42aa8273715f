"""Probabilities that devices have of their own, from what some of them add to the mean."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy

from springpot.machine.arguments import Uncertain
from springpot.scattering.own_probability import own_probability

REPETITIONS, EACH, PATHS = 16, 64, 512


def found_of(logarithm: Any, seed: int) -> Any:
    """From paths of devices with one uncertain number, of which the logarithm of the probability is a function."""
    rng = np.random.default_rng(seed)
    scores = rng.standard_normal((REPETITIONS * EACH, 1))
    counts = rng.poisson(PATHS * np.exp(logarithm(scores[:, 0]))) / (PATHS * EACH)
    stage: Any = SimpleNamespace(
        of_repetitions=np.zeros((REPETITIONS, EACH, 1)), tally=SimpleNamespace(of_devices=counts[:, None]),
        weights=np.ones(len(scores)), scores=scores, splits=True,
    )  # fmt: skip
    number: Any = {"k": Uncertain(1.0, "k", 0.5, 2.0, law=scipy.stats.norm())}
    lot: Any = SimpleNamespace(
        plan=SimpleNamespace(settings=SimpleNamespace(seed=seed)), numbers=number,
        together=SimpleNamespace(inputs=lambda numbers: ("k",), groups=((0,),)),
    )  # fmt: skip
    return own_probability(stage, lot, None)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_median_far_below_the_mean_is_within_its_interval(seed: int) -> None:
    """ln p rises by a straight line to -1, and falls steeply below the mean: no parabola."""
    found = found_of(lambda z: -2.0 - 4.0 * np.exp(-1.2 * z), seed)
    median, top = found.quantiles[0.5], found.quantiles[0.95]
    true, true_top = -6.0, -2.0 - 4.0 * math.exp(-1.2 * scipy.stats.norm.ppf(0.95))
    assert math.log(median.low) < true < math.log(median.high)
    assert abs(math.log(top.value) - true_top) < 0.25
    own = np.exp(-2.0 - 4.0 * np.exp(-1.2 * scipy.stats.norm.ppf((np.arange(4000) + 0.5) / 4000)))
    times = found.times_within(50.0)
    ratio = float((1.0 - (1.0 - own) ** 50.0).mean() / own.mean())
    assert 0.97 * times.low < ratio < 1.03 * times.high
