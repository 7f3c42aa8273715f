"""``rtol`` for systems: against exact numbers, and what cannot be promised is refused or said.

Two kernels serve the everyday tests: parts that a test does not need are there with hardly any strength.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from tests.simulation.systems import AWAY, NEARLY_LINEAR
from tests.sizes import validation
from tests.struck import rates_of

COLORED = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.6), sp.ColoredNoise(1.0, 0.5))
SLOT = sp.System(
    sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.1, 1.0)), sp.Dashpot(0.4), sp.Barrier(-0.5),
    sp.Barrier(1.2, 1.0, "below"), sp.WhiteNoise(1.0),
)  # fmt: skip


@pytest.mark.parametrize(
    ("system", "quantities", "theory"),
    [
        (
            SLOT,
            ("x_mean_square", "v_mean_square", "impact_rate", "barrier_2_impact_rate", "barrier_2_force_mean"),
            sp.theory.exact,
        ),
        (COLORED, ("x_mean_square", "v_mean_square"), sp.theory.linear),
    ],
)
def test_stated_errors_hold_against_theory(system: sp.System, quantities: tuple[str, ...], theory) -> None:
    run = sp.simulate(
        system if system is SLOT else sp.System(*system.parts, NEARLY_LINEAR, *AWAY), rtol=0.02, quantities=quantities
    )
    exact = theory(system)
    known = {**vars(exact.moments), "barrier_2_impact_rate": (*rates_of(exact), 0.0, 0.0)[1]}
    known["barrier_2_force_mean"] = known["barrier_2_impact_rate"] * np.sqrt(2.0 * np.pi * exact.v_mean_square)
    assert run.diagnostics["reached"]
    for name in quantities:
        total = run[name].budget.total
        assert total <= 0.02 * run[name].value
        assert abs(run[name].value - known[name]) < total


def test_the_wall_of_a_system_is_that_of_an_oscillator() -> None:
    """Slow impacts behind a lossy wall are added: the rate agrees with the Fokker-Planck equation's."""
    wall = sp.Barrier(-0.2, 0.5)
    oscillator = sp.Oscillator(1.0, sp.Springpot(1.0, 0.3), wall, sp.WhiteNoise(1.0))
    nearly = sp.System(
        sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1e-12)), sp.Dashpot(0.3), wall,
        sp.Barrier(100.0, 0.5, "below"), sp.WhiteNoise(1.0),
    )  # fmt: skip
    run = sp.simulate(nearly, rtol=0.03, quantities=("impact_rate",))
    exact = sp.theory.fokker_planck(oscillator).impact_rate
    assert abs(run["impact_rate"].value - exact) < run["impact_rate"].budget.total < 0.03 * exact
    assert run["barrier_2_impact_rate"].value == 0.0


@pytest.mark.parametrize(
    "excitation",
    [
        (sp.ColoredNoise(1.0, 0.3),),
        (sp.ColoredNoise(1.0, 0.3), sp.WhiteNoise(0.3)),
        validation((sp.KanaiTajimiNoise(3.0, 0.4, 1.0), sp.ColoredNoise(1.0, 0.3))),
        validation((sp.PoissonImpulses(2.0, 0.5),)),
        (sp.SpectralExcitation((0.05, 10.0), (1.0, 1.0), on="mass"),),
    ],
)
def test_the_coarse_paths_of_a_pair_have_the_excitation_of_the_fine_ones(excitation: tuple[Any, ...]) -> None:
    """Impulses of half steps are summed in pairs: at a short step the two paths are nearly the same."""
    system = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.6), *excitation, NEARLY_LINEAR, *AWAY)
    plan = plan_of(system, paths=64, duration=4.0, step=0.02, window=(0.0, 4.0), start="rest")
    fine = simulation_of(plan.but(step=0.01)).advance(stream=3).rows[:, 0] / 400
    coarse = simulation_of(plan, halved=True).advance(stream=3, halved=True).rows[:, 0] / 200
    other = simulation_of(plan).advance(stream=3).rows[:, 0] / 200
    assert np.abs(fine - coarse).max() < 0.02 * np.abs(fine).max()
    assert np.abs(fine - other).max() > 0.2 * np.abs(fine).max()


@pytest.mark.parametrize(
    ("system", "quantity"),
    [
        (COLORED, "x_mean"),  # 0 by symmetry
        (COLORED, "impact_rate"),
        (SLOT, "harvested_power"),
        (SLOT, "damping_force_mean"),
    ],
)
def test_a_quantity_that_cannot_be_promised_is_refused(system: sp.System, quantity: str) -> None:
    with pytest.raises(ValueError, match=f"quantities must be among .*v_mean_square.*, not {quantity}"):
        sp.simulate(system, rtol=0.1, quantities=(quantity,))


def test_without_a_linear_spring_the_default_is_the_mean_square_velocity() -> None:
    parts = sp.Spring(-1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Dashpot(0.5), sp.WhiteNoise(0.5)
    well = sp.System(*parts, sp.Barrier(-20.0), sp.Barrier(20.0, free_side="below"))  # walls that are never reached
    run = sp.simulate(well, rtol=0.05)
    assert abs(run["v_mean_square"].value - 0.5) < run["v_mean_square"].budget.total < 0.025
    assert "amplitude_mean_square" not in run.estimates


def test_a_record_has_no_stationary_state() -> None:
    shaken = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.RecordedExcitation((0.0, 1.0), (0.0, 1.0)))
    with pytest.raises(ValueError, match="a record has a beginning and an end"):
        sp.simulate(shaken, rtol=0.1)
