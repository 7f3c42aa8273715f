"""Stated total errors of ``rtol`` for several masses hold as often as they say: 20 random systems against finer runs.

Two to four masses, walls between any two of them and to the ground, restitution from 0.5 to 1, springpots and dashpots,
white noise on all masses.  About three minutes of one processor.
"""

from __future__ import annotations

import math
from contextlib import suppress
from functools import cache

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.struck import slow_impact_order

pytestmark = pytest.mark.validation

RTOL, SYSTEMS = 0.02, 20
FINER, MORE = 4, 10  # of the reference: than the default step, and paths
MOST_PATH_STEPS = 3e8  # of the reference, whose own error widens the interval, as independent errors do


def random_system(seed: int) -> sp.System:
    """A tree of springs with a damper beside each, and some walls at about the deviation of their elongation."""
    rng = np.random.default_rng(seed)
    points = "abcd"[: rng.integers(2, 5)]
    parts: list[object] = []
    for n, point in enumerate(points):
        parts.append(sp.Mass(math.exp(rng.uniform(-0.7, 0.7)), at=point))
        ends = (["ground", *points[:n]][rng.integers(0, n + 1)], point)
        parts.append(sp.Spring(math.exp(rng.uniform(0.0, 1.5)), between=ends))
        if rng.random() < 0.5:
            parts.append(sp.Springpot(rng.uniform(0.3, 0.9), rng.uniform(0.2, 0.6), between=ends))
        else:
            parts.append(sp.Dashpot(rng.uniform(0.1, 0.4), between=ends))
        parts.append(sp.WhiteNoise(rng.uniform(0.2, 1.0), on=point))
    spreads = motion_of(sp.System(*parts)).modes
    for _ in range(rng.integers(1, 4)):
        first, second = rng.choice(["ground", *points], 2, replace=False)
        ends = (str(first), str(second)) if second != "ground" else (str(second), str(first))
        spread = spreads.spread(sp.System(*parts).coordinates.row(ends))
        place, side = rng.uniform(0.0, 1.2) * spread, rng.choice(["above", "below"])
        restitution = 1.0 if rng.random() < 0.3 else rng.uniform(0.5, 1.0)
        wall = sp.Barrier(-place if side == "above" else place, restitution, str(side), between=ends)
        with suppress(ValueError):  # behind another one
            parts = [*sp.System(*parts, wall).parts]
    return sp.System(*parts)


@cache
def judged(seed: int) -> dict[str, tuple[float, float, bool]]:
    """Distance from the reference over the stated width, the width over the value, whether it was reached."""
    system = random_system(seed)
    walls = {name: wall for name, wall in system.named() if isinstance(wall, sp.Barrier)}
    wanted = [*motion_of(system).usual_quantities, *(f"{name}_impact_rate" for name in walls)]
    run = simulated(system, rtol=RTOL, quantities=wanted, seed=seed)
    step = 0.1 / motion_of(system).scales.fastest_rate
    steps = FINER * run.settings.duration / step
    given = {
        "duration": run.settings.duration, "window": run.settings.window,
        "paths": min(MORE * run.settings.paths, max(round(MOST_PATH_STEPS / steps), 1024)),
    }  # fmt: skip
    fine = simulated(system, step=step / FINER, seed=1000 + seed, **given)
    coarse = simulated(system, step=step, seed=2000 + seed, **given)
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error
    found = {}
    for name in wanted:
        true, error = fine[name].value, fine[name].error
        wall = walls.get(name.removesuffix("_impact_rate"))
        if wall is not None and wall.restitution < 1.0:  # of known order in the step
            more = 1.0 / (FINER ** slow_impact_order(float(wall.restitution)) - 1.0)
            true += more * (fine[name].value - coarse[name].value)
            error = math.hypot((1.0 + more) * fine[name].error, more * coarse[name].error)
        width = math.hypot(run[name].budget.total, 1.96 * error)
        off = (run[name].value - true) / width
        found[name] = off, run[name].budget.total / run[name].value, bool(run.diagnostics["reached"])
        print(f"{seed} {name}: {off:+.2f} of {100 * found[name][1]:.2f} % (reference {196 * error / true:.2f} %)")
    print(f"{seed}: {run.diagnostics['path_steps']:.1e} path-steps, {run.diagnostics['held_up_by']}, {run.warnings}")
    return found


@pytest.mark.parametrize("seed", range(SYSTEMS))
def test_none_misses_by_twice_its_width_and_what_is_not_reached_is_said(seed: int) -> None:
    found = judged(seed)
    assert max(abs(off) for off, _, _ in found.values()) < 2.0
    assert all(reached == (max(width for _, width, _ in found.values()) <= RTOL) for _, _, reached in found.values())


def test_intervals_hold_as_often_as_they_say() -> None:
    offs = [off for seed in range(SYSTEMS) for off, width, _ in judged(seed).values() if width <= RTOL]  # that claim it
    assert len(offs) > 100
    assert np.mean([abs(off) <= 1.0 for off in offs]) >= 0.95
    assert abs(np.mean(offs)) < 0.2  # a bias of a fifth of the stated half-width in all would fail
