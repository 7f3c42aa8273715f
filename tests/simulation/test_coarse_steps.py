"""Coarse steps are good enough: at 0.02 / Omega every stationary number is within 1 % of what a step of 1e-3 gives.

Impact rate and speeds only where restitution is high: the flux of slow impacts makes their bias go like h^p with p = 1
at r = 1, 0.86 at r = 0.8 and 0.5 at r = 0.5 (`slow_impact_order`), where a step of 0.02 misses a per cent or two of the
impacts and the energies are as good as elsewhere.
"""

import math

import numpy as np
import pytest

import springpot as sp
from springpot.simulation import simulate
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.paths.statistics import standard_error
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.struck import slow_impact_order
from springpot.theory.result import MOMENTS

from ..sizes import validation
from .problems import oscillator
from .systems import AWAY, NEARLY_LINEAR

ENERGIES = ("x_mean", "x_mean_square", "v_mean_square", "amplitude_mean_square")
NEAR = 0.01


def halved(
    problem: sp.Oscillator, position: float, *, step: float, paths: int, window: tuple[float, float]
) -> dict[str, tuple[float, float]]:
    """Relative change of every number when the step is halved, and its standard error: both runs share their noise."""
    coarse = plan_of(
        problem, paths=paths, duration=window[1], window=window, step=step, threads=1, initial_position=position
    )
    found = []
    for plan, pairs in ((coarse, True), (coarse.but(step=0.5 * coarse.settings.step), False)):
        simulation = simulation_of(plan)
        found.append(samples_of(simulation, simulation.advance(halved=pairs).rows))
    before, after = found
    changes = {name: after[name][1] - before[name][1] for name in MOMENTS}
    return {name: (d.mean() / after[name][0], standard_error(d) / after[name][0]) for name, d in changes.items()}


@pytest.mark.parametrize(
    ("order", "coefficient", "restitution", "position", "start"),
    [
        validation(0.5, 1.0, 1.0, 0.0, 0.785), validation(0.3, 1.0, 0.8, -0.5, 0.54),
        validation(0.7, 0.5, 1.0, 0.3, 1.0), (0.5, 1.0, 0.5, 0.0, 0.577),
    ],
)  # fmt: skip
def test_halving_a_step_of_0_04_changes_little(
    order: float, coefficient: float, restitution: float, position: float, start: float
) -> None:
    """What h = 0.04 and 0.02 differ by bounds what 0.02 is still off by, if the bias has order 1 or more."""
    problem = oscillator(order, coefficient, 1.0, 1.0, position, restitution)
    found = halved(problem, start, step=0.04, paths=12_288, window=(10.0, 60.0))
    for name in MOMENTS if restitution > 0.5 else ENERGIES:
        change, error = found[name]
        still = 1.0 / (2.0 ** (1.0 if name in ENERGIES else slow_impact_order(restitution)) - 1.0)
        assert error < NEAR / 3.0, name
        assert (abs(change) + 2.0 * error) * still < NEAR, f"{name}: {change} +- {error}"


@pytest.mark.validation
@pytest.mark.parametrize(
    ("order", "coefficient", "restitution", "position"),
    [
        (0.5, 1.0, 1.0, 0.0), (0.3, 0.8, 0.8, -0.5), (0.3, 1.0, 0.8, 0.0), (0.7, 0.5, 1.0, 0.3), (0.8, 2.0, 0.9, -0.3),
        (0.5, 1.0, 0.5, 0.0), (0.5, 1.0, 1.0, None),
    ],
)  # fmt: skip
def test_a_step_of_0_02_is_within_1_per_cent_of_a_step_of_0_001(
    order: float, coefficient: float, restitution: float, position: float | None
) -> None:
    problem = oscillator(order, coefficient, 1.0, 1.0, position, restitution)
    coarse, fine = (
        simulate(
            problem, paths=40_960, duration=120.0, window=(20.0, 120.0), step=step, start="stationary", seed=seed
        )
        for seed, step in ((1, 0.02), (2, 0.001))
    )  # fmt: skip
    names = set(MOMENTS if position is not None and restitution > 0.5 else ENERGIES)
    for name in sorted(names - ({"x_mean"} if position is None else set())):
        scale = fine[name].value
        change = (coarse[name].value - scale) / scale
        error = math.hypot(coarse[name].error, fine[name].error) / scale
        print(f"{name:<25} {100 * change:+.2f} +- {100 * error:.2f} %")
        assert error < NEAR / 3.0, name
        assert abs(change) + 2.0 * error < NEAR, f"{name}: {change} +- {error}"
    assert np.isfinite([fine[name].value for name in names]).all()


@pytest.mark.parametrize(
    ("frequency", "coefficient", "position"),
    [(1.0, 1.0, 0.0), (2.0, 0.3, -0.4), validation(1.0, 0.5, 0.3), validation(0.5, 1.0, -1.0), (1.0, 1.0, None)],
)
def test_with_a_dashpot_the_longest_step_has_no_error(
    frequency: float, coefficient: float, position: float | None
) -> None:
    """Flights and elastic impacts keep the energy, kicks keep the velocity normal: the law is exact at every step."""
    problem = oscillator(1.0, coefficient, frequency, 1.0, position, 1.0)
    step = 2.5 / max(frequency, coefficient)
    settings = {"paths": 40_960, "duration": 200.0 * step, "window": (50.0 * step, 200.0 * step), "seed": 3}
    found = sp.simulate(problem, step=step, start="rest", **settings)
    assert any("no error of the step at order 1, but transients" in sentence for sentence in found.warnings)
    law = sp.theory.exact(problem)
    names = ["x_mean_square", "v_mean_square", "amplitude_mean_square"]
    names += [] if position is None else ["x_mean", "impact_rate", "impact_speed_mean"]
    for name in names:
        value, error, exact = found[name].value, found[name].error, getattr(law, name)
        assert error < 0.003 * abs(exact), name
        assert abs(value - exact) < 4.0 * error, name
    assert not any("slow impacts" in sentence for sentence in found.warnings)
    assert found.to_dict().get("impact_rate_step_bias", 0.0) == 0.0


@pytest.mark.parametrize("device", [False, True])
def test_the_power_of_a_dashpot_is_exact_at_any_step(device: bool) -> None:
    """It has what is taken of the noise within a kick, C h / (2 + C h) of all; the mean velocity does not show that."""
    problem = oscillator(1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
    step, name = 0.4 if device else 2.5, "damping_power"
    if device:
        problem = sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.WhiteNoise(1.0), NEARLY_LINEAR, *AWAY)
    found = sp.simulate(problem, paths=10_240, duration=250.0, window=(50.0, 250.0), step=step, start="rest", seed=3)
    assert found[name].error < 0.001
    assert abs(found[name].value - 0.5) < 4.0 * found[name].error
    assert abs(found["energy_residual"].value) < 4.0 * found["energy_residual"].error


def test_only_what_has_no_error_may_have_such_a_step() -> None:
    for problem in (sp.Oscillator(), oscillator(1.0, 1.0, 1.0, 1.0, 0.0, 0.9)):
        with pytest.raises(ValueError, match=r"too coarse .* use at most 0\.5 s"):
            sp.simulate(problem, step=1.0, duration=100.0)
    with pytest.raises(ValueError, match=r"too coarse .* use at most 2.5 s"):
        sp.simulate(oscillator(1.0, 1.0, 1.0, 1.0, 0.0, 1.0), step=2.6, duration=100.0)
