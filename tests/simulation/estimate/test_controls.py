"""Control variates have mean zero at any step, and take out most of the spread."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.estimate.controls import controls_of
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.paths.simulation import Simulation, simulation_of
from springpot.simulation.paths.statistics import controlled, standard_error
from springpot.simulation.plan.plan import plan_of
from tests.simulation.problems import oscillator
from tests.sizes import validation

SLOT = sp.System(
    sp.Mass(2.0), sp.Spring(3.0), sp.Springpot(0.5, 0.7), sp.Dashpot(0.2), sp.Barrier(-0.3, 0.6),
    sp.Barrier(0.5, 0.8, free_side="below"), sp.WhiteNoise(1.0),
)  # fmt: skip
PROBLEMS = {
    "elastic": oscillator(0.5, 1.0, position=0.4),
    "lossy, from below": oscillator(0.5, 1.0, 0.9, 2.0, 0.2, 0.6, free_side="below"),
    "no wall": oscillator(0.3, 1.0, position=None),
    "two walls": SLOT,
}
STEP = 0.4


@cache
def sampled(name: str) -> tuple[Simulation, np.ndarray, dict[str, np.ndarray]]:
    """A simulation at a coarse step, its sums, and its samples."""
    problem = PROBLEMS[name]
    plan = plan_of(problem, paths=60_000, duration=60.0, step=STEP, window=(30.0, 60.0), start="rest")
    simulation = simulation_of(plan)
    rows = simulation.advance().rows
    return simulation, rows, {key: samples for key, (_, samples) in samples_of(simulation, rows).items()}


@pytest.mark.parametrize("name", ["elastic", *map(validation, [*PROBLEMS][1:])])
def test_the_means_are_zero_at_any_step(name: str) -> None:
    simulation, rows, samples = sampled(name)
    controls = controls_of(simulation, rows, samples["energy_residual"])
    assert controls.shape == (60_000, 4)
    for control in controls.T:
        assert abs(control.mean()) < 4.0 * standard_error(control)


def test_without_the_terms_of_the_step_that_of_the_virial_would_not_be() -> None:
    """What the sums in the middle of the flights lack of the means, seven standard errors at this step."""
    _, rows, samples = sampled("elastic")
    pushed = 0.4 * 2.0 * rows[:, 7] / 30.0
    virial = samples["v_mean_square"] - samples["x_mean_square"] + pushed - samples["damping_virial"]
    assert abs(virial.mean()) > 5.0 * standard_error(virial)


@pytest.mark.parametrize(("quantity", "most"), [("amplitude_mean_square", 0.35), ("x_mean", 0.4), ("impact_rate", 0.6)])
def test_they_take_out_more_than_the_balance_of_energy_alone(quantity: str, most: float) -> None:
    simulation, rows, samples = sampled("elastic")
    controls = controls_of(simulation, rows, samples["energy_residual"])
    all_four, energy = (controlled(samples[quantity], c).var() for c in (controls, controls[:, 1:2]))
    assert all_four < most * energy


def test_forces_that_the_kernel_does_not_sum_leave_energy_and_its_gain() -> None:
    system = sp.System(sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Springpot(0.5, 0.6), sp.WhiteNoise(1.0))
    simulation = simulation_of(plan_of(system, paths=64, duration=4.0, step=0.1, window=(2.0, 4.0), start="rest"))
    assert controls_of(simulation, np.ones((64, len(simulation.parts.columns))), np.ones(64)).shape == (64, 2)


def test_a_control_that_does_not_vary_is_left_out() -> None:
    draw = np.random.default_rng(1)
    noise = draw.normal(size=(1000, 2))
    samples = 1.0 + noise @ [1.0, 0.1]
    both = controlled(samples, np.stack([noise[:, 0], np.zeros(1000)], axis=1))
    assert both == pytest.approx(controlled(samples, noise[:, :1]))
    assert controlled(samples, np.zeros((1000, 2))) is samples


def test_regression_on_many_controls_is_paid_for_in_the_standard_error() -> None:
    """Forty values and eight controls that say nothing: z has the spread of a standard normal."""
    draw = np.random.default_rng(2)
    z = []
    for _ in range(2000):
        kept = controlled(draw.normal(size=40), draw.normal(size=(40, 8)))
        z.append(kept.mean() / standard_error(kept, 8))
    assert 0.9 < np.std(z) < 1.05


@pytest.mark.parametrize(("noise", "count"), [((), 0), ((sp.WhiteNoise(0.1),), 2)])
def test_without_noise_the_gain_of_energy_is_no_control(noise: tuple[sp.WhiteNoise, ...], count: int) -> None:
    """Its scatter is then that of the transient alone."""
    shaken = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.Harmonic(1.0, 1.0), *noise)
    plan = plan_of(shaken, paths=100, duration=60.0, window=(30.0, 60.0), start="rest")
    simulation = simulation_of(plan)
    rows = simulation.advance().rows
    residual = samples_of(simulation, rows).get("energy_residual")
    assert controls_of(simulation, rows, None if residual is None else residual[1]).shape == (100, count)
