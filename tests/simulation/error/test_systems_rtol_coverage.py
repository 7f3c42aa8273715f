"""Stated total errors of ``rtol`` for systems hold as often as they say: 30 random ones against much finer runs."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.plan.motions import motion_of

pytestmark = pytest.mark.validation

RTOL = 0.01
FINER, MORE = 4, 10  # of the reference: step and paths
MOST_PATH_STEPS = 3e9  # of the reference, whose own error is added to the width


def random_system(seed: int) -> sp.System:
    """White noise, a springpot or dashpot, and at random a cubic spring, one or two walls, and colored noise."""
    rng = np.random.default_rng(seed)
    frequency = math.exp(rng.uniform(-1.0, 1.0))
    parts: list[object] = [sp.Spring(frequency**2)]
    if rng.random() < 0.75:
        order = rng.uniform(0.1, 0.95)
        parts.append(sp.Springpot(order, math.exp(rng.uniform(-3.0, 0.0)) * frequency ** (2.0 - order)))
    if rng.random() < 0.4 or len(parts) == 1:
        parts.append(sp.Dashpot(math.exp(rng.uniform(-3.0, -0.5)) * frequency))
    intensity = math.exp(rng.uniform(-1.0, 1.0))
    size = math.sqrt(intensity / frequency**3)
    parts.append(sp.WhiteNoise(intensity))
    if rng.random() < 0.6:
        parts.append(sp.PolynomialSpring((0.0, 0.0, math.exp(rng.uniform(-3.0, 0.0)) * frequency**2 / size**2)))
    for side, sign in (("above", -1.0), ("below", 1.0)):
        if rng.random() < 0.6:
            restitution = 1.0 if rng.random() < 0.3 else rng.uniform(0.5, 1.0)
            parts.append(sp.Barrier(sign * rng.uniform(0.0, 1.5) * size, restitution, side))
    if rng.random() < 0.4:
        variance = math.exp(rng.uniform(-2.0, 0.0)) * intensity * frequency
        parts.append(sp.ColoredNoise(variance, math.exp(rng.uniform(-1.5, 1.0)) / frequency))
    return sp.System(*parts)


@cache
def judged(seed: int) -> dict[str, tuple[float, float, bool]]:
    """Distance from the reference over the stated width, the width over the value, whether it was reached."""
    system = random_system(seed)
    wanted = ["v_mean_square", "x_mean_square"]
    if system.of(sp.Barrier) and not motion_of(system).uncountable:
        wanted.append("impact_rate")
    run = sp.simulate(system, rtol=RTOL, quantities=wanted, seed=seed)
    end, steps = run.settings.duration, FINER * run.settings.steps
    paths = min(MORE * run.settings.paths, max(round(MOST_PATH_STEPS / steps), 1024))
    exact = sp.simulate(
        system, paths=paths, step=run.settings.step / FINER, duration=end, seed=1000 + seed,
        window=run.settings.window, start="stationary",
    )  # fmt: skip
    judged = {}
    for name in wanted:
        width = run[name].budget.total + 1.96 * exact[name].error
        off = abs(run[name].value - exact[name].value) / width
        judged[name] = off, run[name].budget.total / run[name].value, bool(run.diagnostics["reached"])
        print(f"{seed} {name}: {off:.2f} of the width, {100 * judged[name][1]:.2f} %, {run.diagnostics['reached']}")
    return judged


@pytest.mark.parametrize("seed", range(30))
def test_none_misses_by_twice_its_width_and_what_is_not_reached_is_said(seed: int) -> None:
    found = judged(seed)
    assert max(off for off, _, _ in found.values()) < 2.0
    assert all(reached or width > RTOL for _, width, reached in found.values()) or not all(
        reached for _, _, reached in found.values()
    )


def test_intervals_hold_as_often_as_they_say() -> None:
    offs = [off for seed in range(30) for off, _, _ in judged(seed).values()]
    assert len(offs) > 60
    assert np.mean([off <= 1.0 for off in offs]) >= 0.95
