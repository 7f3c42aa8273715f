"""The standard errors of a round are those between rounds."""

from dataclasses import replace

import numpy as np
import pytest

from springpot.simulation.error.budget import combine
from springpot.simulation.error.levels import FEWEST_PAIRS, Level, Levels, levels_of
from springpot.simulation.plan.plan import plan_of
from tests.simulation.problems import oscillator
from tests.sizes import validation

ROUNDS = 600
QUANTITIES = "x_mean", "x_mean_square", "v_mean_square", "impact_rate"


def part(level: Level, number: int) -> Level:
    """The paths of one round of all."""
    own = slice(number * level.paths // ROUNDS, (number + 1) * level.paths // ROUNDS)
    return replace(level, rows=level.rows[own], counted=level.counted[own])


@pytest.mark.validation  # every day: intervals cover, in test_accuracy.py
@pytest.mark.parametrize("paths", [validation(0), 4 * FEWEST_PAIRS])
def test_the_errors_of_a_round_are_the_spread_between_rounds(paths: int) -> None:
    """With the fewest pairs, where regression on eight control variates takes out 7 % of the spread by chance.

    The ratio of the two is known to 1.5 %.
    """
    plan = plan_of(oscillator(1.0, 0.8, 1.3, 2.0, 0.3), paths=64, duration=40.0, step=0.2, start="rest")
    whole = levels_of(plan).extended(ROUNDS * paths, ROUNDS * FEWEST_PAIRS, None)
    rounds = [
        combine(Levels(*(part(level, n) for level in (whole.many, whole.pair_coarse, whole.pair_fine))))
        for n in range(ROUNDS)
    ]
    values, errors = (
        np.array([[getattr(found, of)[name] for name in QUANTITIES] for found in rounds]) for of in ("values", "errors")
    )
    off = (values - np.median(values, axis=0)) / errors
    assert 0.96 < np.sqrt(np.mean(off**2)) < 1.06
