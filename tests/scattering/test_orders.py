"""Devices whose order scatters, behind walls, against a run of each alone: differences in standard errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

import springpot as sp
from springpot.machine.arrays import Floats
from springpot.problem.free_numbers import with_values
from tests.sizes import validation

ORDERS = 20
NAMES = "x_mean", "x_mean_square", "v_mean_square", "impact_rate", "damping_power"


def walled(low: float, high: float) -> sp.System:
    """A springpot between a lossy wall and an elastic one."""
    return sp.System(
        sp.Mass(0.8), sp.Spring(3200.0), sp.Springpot(sp.uncertain("order", bounds=(low, high)), 60.0),
        sp.Barrier(-0.006, 0.7), sp.Barrier(0.009, free_side="below"), sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
    )  # fmt: skip


def differences(low: float, high: float, *, paths: int, alone: int, duration: float, seed: int) -> Floats:
    """Of 20 of 64 devices with orders of their own, spread over the whole range, shape (orders, results).

    Both have the same step and the same start, so what is left is the memory: common rates, and weights of each lane,
    against the rates and weights of one order.
    """
    system, given = walled(low, high), {"duration": duration, "window": (0.2 * duration, duration), "step": 5e-4}
    found = sp.scatter(system, [*NAMES], devices=64, paths=paths, seed=seed, **given)
    rows = np.argsort(found.draws[:, 0])[np.linspace(0, 63, ORDERS).round().astype(int)]
    assert found.settings is not None
    away = []
    for number, row in enumerate(rows.tolist()):
        own = with_values(system, {"order": float(found.draws[row, 0])})
        run = sp.simulate(
            own, paths=alone, start="rest", seed=seed + 1 + number,
            initial_position=found.settings.initial_position, **given,
        )  # fmt: skip
        both = math.sqrt(1.0 + alone / paths)
        away.append([(found.means[name][row] - run[name].value) / (both * run[name].error) for name in NAMES])
    return np.array(away)


@pytest.mark.validation  # every day: devices are the runs of each alone, in test_scatter.py
@pytest.mark.filterwarnings("ignore::springpot.problem.messages.StationarityWarning")
@pytest.mark.parametrize(
    ("paths", "alone", "duration"), [(64, 1024, 0.5), validation(512, 8192, 2.0), validation(8, 8192, 2.0)]
)
def test_differences_are_those_of_chance(paths: int, alone: int, duration: float) -> None:
    """20 orders from 0.2 to 0.5, five results each: their root mean square is 1."""
    away = differences(0.2, 0.5, paths=paths, alone=alone, duration=duration, seed=3)
    assert 0.75 < math.sqrt(float((away**2).mean())) < 1.25
    assert np.abs(away).max() < 4.5
    assert np.abs(away.mean(axis=0)).max() < 4.0 / math.sqrt(ORDERS)
