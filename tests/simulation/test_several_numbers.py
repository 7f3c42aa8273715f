"""Numbers of systems of several masses to a third of a per cent and better, nearly all in ``make validate``."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.motions import motion_of
from tests.simulation.test_several import A_B, BOLTZMANN, GROUND_A, GROUND_B, masses, thermal_pair
from tests.sizes import validation

pytestmark = pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")

B_C, GROUND_C = ("b", "c"), ("ground", "c")
PRECISE = 0.003  # the most that a standard error may be of its value


def far(run: Any, exact: dict[str, float], precise: float = PRECISE) -> dict[str, float]:
    """Deviations in standard errors; means that may be 0 are as precise as their root mean square is large."""
    for name, value in exact.items():
        size = np.sqrt(exact[f"{name}_square"]) if name.endswith("x_mean") else abs(value)
        assert run[name].error < precise * size, name
    return {name: (run[name].value - value) / run[name].error for name, value in exact.items()}


def everything(points: str, temperature: float = 0.6) -> sp.System:
    """Springpots of different orders, cubic springs, walls between the masses and to the ground, at a temperature."""
    of_two = (
        *masses(a=1.0, b=0.5), *(sp.Spring(k, between=e) for k, e in zip((2.0, 1.0), (GROUND_A, A_B), strict=True)),
        sp.Springpot(0.6, 0.3, between=GROUND_A), sp.Springpot(0.8, 0.3, between=A_B),
        sp.Dashpot(0.1, between=GROUND_B),
        sp.PolynomialSpring((0.0, 0.0, 0.8), between=GROUND_A), sp.PolynomialSpring((0.0, 0.3, 0.6), between=A_B),
    )  # fmt: skip
    walls = {"gap": sp.Barrier(-0.3, between=A_B), "floor": sp.Barrier(-0.6, between=GROUND_A)}
    of_three = (
        *masses(c=0.8), sp.Spring(1.5, between=B_C), sp.Spring(0.5, between=GROUND_C),
        sp.Springpot(0.5, 0.2, between=B_C), sp.PolynomialSpring((0.0, 0.0, 0.5), between=B_C),
    )  # fmt: skip
    more = {"roof": sp.Barrier(0.9, free_side="below", between=GROUND_C), "other": sp.Barrier(-0.2, between=B_C)}
    noise = sp.ThermalNoise(temperature)
    if len(points) == 2:
        return sp.System(*of_two, noise, **walls)
    return sp.System(*of_two, *of_three, noise, **walls, **more)


@pytest.mark.validation  # every day: thermal pairs, in test_several.py
@pytest.mark.parametrize(
    ("points", "paths", "precise"),
    [("ab", 640, 0.02), validation("ab", 16384, PRECISE), validation("abc", 16384, PRECISE)],
)
def test_everything_at_a_temperature_obeys_the_exact_law(points: str, paths: int, precise: float) -> None:
    """Moments, pounding rates, mean closing speeds and forces, at a step whose own error is less than chance's."""
    system = everything(points)
    found = sp.theory.exact(system)
    step = 0.06 / motion_of(system).scales.fastest_rate
    run = sp.simulate(system, paths=paths, duration=400.0, window=(200.0, 400.0), step=step)
    wanted = "x_mean", "mean_square", "impact_rate", "impact_speed_mean", "force_mean"
    exact = {name: value for name, value in found.numbers.items() if name in run and name.endswith(wanted)}
    assert len(exact) >= 12
    off = far(run, exact, precise)
    assert max(map(abs, off.values())) < 3.5, off  # of more than a dozen
    assert abs(np.mean([*off.values()])) < 2.0, off


def row_of(size: int) -> sp.System:
    """Masses in a row with springpots of different orders and dashpots, white noise on all and of the ground."""
    points = [f"m{n}" for n in range(size)]
    ends = [*itertools.pairwise(("ground", *points)), ("ground", points[-1])]
    return sp.System(
        *(sp.Mass(1.0 - 0.05 * n, at=point) for n, point in enumerate(points)),
        *(sp.Spring(3.0 - 0.1 * n, between=e) for n, e in enumerate(ends)),
        *(sp.Springpot(0.3 + 0.08 * n, 0.5, between=e) if n % 2 else sp.Dashpot(0.4, between=e)
          for n, e in enumerate(ends)),
        *(sp.WhiteNoise(0.5 + 0.1 * n, on=point) for n, point in enumerate(points)), sp.WhiteNoise(0.1, on="ground"),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("size", "paths", "precise"), [(8, 256, 0.03), *(validation(n, 20480, PRECISE) for n in (2, 4, 8))]
)
def test_rows_of_masses_have_the_moments_of_the_linear_theory(size: int, paths: int, precise: float) -> None:
    """Every coordinate and elongation."""
    system = row_of(size)
    found = sp.theory.linear(system)
    exact = {name: value for name, value in found.numbers.items() if name.endswith("mean_square")}
    assert len(exact) == 3 * size - 1
    step = 0.06 / motion_of(system).scales.fastest_rate
    run = simulated(system, paths=paths, duration=300.0, window=(100.0, 300.0), step=step)
    off = far(run, exact, precise)
    assert max(map(abs, off.values())) < 3.5, off
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.02


@pytest.mark.validation
def test_pounding_has_the_weak_order_2_of_one_mass() -> None:
    """Rate and closing speed of an elastic wall between two masses at two steps, against Boltzmann's law."""
    names = "gap_impact_rate", "gap_impact_speed_mean"
    biases = []
    for coarse in (0.48, 0.24):
        step = coarse / motion_of(thermal_pair()).scales.fastest_rate
        run = simulated(thermal_pair(), paths=65536, duration=200.0, window=(0.0, 200.0), step=step)
        biases.append([(run[name].value / BOLTZMANN[name] - 1.0, run[name].error / BOLTZMANN[name]) for name in names])
    for (one, error), (other, own) in zip(*biases, strict=True):
        order = np.log2(one / other)
        assert abs(order - 2.0) < 0.2 + 3.0 * np.hypot(error / one, own / other) / np.log(2.0)


@pytest.mark.validation
def test_at_the_default_step_rates_are_within_half_a_per_cent() -> None:
    run = sp.simulate(thermal_pair(), paths=65536, duration=200.0, window=(0.0, 200.0))
    off = run["gap_impact_rate"].value / BOLTZMANN["gap_impact_rate"] - 1.0
    assert abs(off) < 0.005
    assert run["gap_impact_rate"].error < 0.0005 * BOLTZMANN["gap_impact_rate"]


def test_the_default_step_resolves_hops_on_a_wall_that_a_weight_presses_on() -> None:
    """Of one of two masses, against the Fokker-Planck equation of it alone; a step that is too long is doubted."""
    weighed = sp.System(
        sp.Mass(1.0, at="a"), sp.Spring(4.0, between=("ground", "a")), sp.Dashpot(0.1, between=("ground", "a")),
        sp.WhiteNoise(0.5, on="a"), sp.Constant(-9.81, on="a"), sp.Mass(1.0, at="b"),
        sp.Spring(1.0, between=("ground", "b")), sp.Dashpot(0.1, between=("ground", "b")),
        floor=sp.Barrier(0.0, 0.5, between=("ground", "a"), free_side="above"),
    )  # fmt: skip
    given: dict[str, Any] = {"paths": 64, "duration": 12.0, "window": (2.0, 12.0), "start": "rest"}
    found = simulated(weighed, **given)["a_v_mean_square"]
    assert found.error < 0.02 * 0.0038977
    assert abs(found.value - 0.0038977) < 0.02 * 0.0038977 + 3.0 * found.error
    coarse = simulated(weighed, step=0.01, **given)
    assert coarse["a_v_mean_square"].value > 1.2 * 0.0038977
    assert "coarse_step" in [message.name for message in coarse.warnings]
