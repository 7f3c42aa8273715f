"""The stationary start of several masses: their means in the memory of springpots, found by pilot runs.

The right values are those of one mass alone over thousands of seconds, or from E[x] by an independent program.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.designing.quantities import sampled_run
from springpot.simulation.estimate.stationary_start import adapt, pilot_paths
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import plan_of
from tests.sizes import validation

GROUND_A, GROUND_B, A_B, B_C = ("ground", "a"), ("ground", "b"), ("a", "b"), ("b", "c")
IDLE = sp.Mass(1.0, at="b"), sp.Spring(1.0, between=GROUND_B), sp.Dashpot(0.5, between=GROUND_B)


def beside_an_idle_mass(*parts: Any, **named: Any) -> sp.System:
    return sp.System(sp.Mass(1.0, at="a"), *IDLE, sp.WhiteNoise(1.0, on="a"), *parts, **named)


def stopped(stiffness: float, coefficient: float, restitution: float) -> sp.System:
    return beside_an_idle_mass(
        sp.Spring(stiffness, between=GROUND_A), sp.Springpot(0.2, coefficient, between=GROUND_A),
        stop=sp.Barrier(0.0, restitution, "above", between=GROUND_A),
    )  # fmt: skip


STRONG, LOSSY = stopped(0.3, 1.5, 1.0), stopped(1.0, 0.5, 0.9)
UNEVEN = beside_an_idle_mass(
    sp.PolynomialSpring((1.0, 0.6, 0.3), between=GROUND_A), sp.Springpot(0.3, 1.0, between=GROUND_A)
)
THREE = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Mass(0.7, at="c"),
    sp.Spring(0.3, between=GROUND_A), sp.Springpot(0.2, 1.5, between=GROUND_A),
    sp.Spring(1.0, between=A_B), sp.Springpot(0.35, 0.8, between=A_B),
    sp.Spring(0.5, between=B_C), sp.Springpot(0.2, 0.5, between=B_C),
    sp.WhiteNoise(1.0, on="a"), sp.WhiteNoise(0.3, on="c"),
    floor=sp.Barrier(-0.05, 0.8, "above", between=GROUND_A), gap=sp.Barrier(-0.2, 0.8, "above", between=A_B),
)  # fmt: skip
RIGHT: dict[str, tuple[sp.System, dict[str, tuple[float, float]]]] = {
    "strong": (STRONG, {
        "a_x_mean": (1.3763, 0.0004), "a_x_mean_square": (2.6324, 0.0016), "a_v_mean_square": (1.8435, 0.0013),
        "stop_impact_rate": (0.12829, 0.00007),
    }),
    "lossy": (LOSSY, {
        "a_x_mean": (1.4453, 0.0066), "a_x_mean_square": (3.229, 0.029), "a_v_mean_square": (3.746, 0.035),
        "stop_impact_rate": (0.3120, 0.0006),
    }),
    "uneven": (UNEVEN, {
        "a_x_mean": (-0.2603, 0.0024), "a_x_mean_square": (0.7751, 0.0054), "a_v_mean_square": (1.579, 0.013),
    }),
    "three": (THREE, {
        "a_x_mean": (0.9972, 0.0019), "a_x_mean_square": (1.470, 0.005), "c_x_mean_square": (4.255, 0.019),
        "a_v_mean_square": (0.812, 0.002), "floor_impact_rate": (0.1575, 0.0006), "gap_impact_rate": (0.4409, 0.0010),
    }),
}  # fmt: skip
SOON: dict[str, Any] = {"paths": 8000, "duration": 120.0, "window": (20.0, 120.0)}
SHORT: dict[str, Any] = {"paths": 64, "duration": 4.0, "step": 0.05}


@pytest.mark.parametrize("name", ["strong", "lossy", validation("uneven"), validation("three")])
@pytest.mark.parametrize("step", [0.06, validation(0.03)])
def test_from_the_means_a_run_is_right_from_its_beginning_on(name: str, step: float) -> None:
    """From rest <x^2> of the first is 28 % low after these times, and still 11 % after 400 s."""
    system, right = RIGHT[name]
    run = simulated(system, **SOON, step=step)
    assert run.settings.start == "stationary"
    for quantity, (value, error) in right.items():
        found = run[quantity]
        assert abs(found.value - value) < 3.0 * math.hypot(found.error, error), quantity
        assert found.error < 0.01 * abs(value), quantity
    assert not any(sentence.name == "start_was_off" for sentence in run.warnings)


@pytest.mark.parametrize("name", ["strong", *map(validation, ("lossy", "uneven", "three"))])
def test_the_total_error_of_a_run_to_a_tolerance_holds(name: str) -> None:
    """From rest the first gave 1.886 +- 0.035 for 2.632, and an impact rate of 0.2963 +- 0.0042 for 0.1283."""
    system, right = RIGHT[name]
    run = simulated(system, rtol=0.02, quantities=tuple(right))
    for quantity, (value, error) in right.items():
        found = run[quantity]
        assert found.budget is not None
        assert found.budget.total <= 0.02 * abs(found.value), quantity
        assert abs(found.value - value) < found.budget.total + 2.0 * error, quantity
        assert found.budget.transient > 0.0, quantity
    assert not run.warnings


@pytest.mark.parametrize("step", [0.07, validation(0.035)])
def test_levels_are_exceeded_as_often_as_by_the_mass_alone(step: float) -> None:
    """From rest it was 0.0947, and once in 108 s."""
    curve = sp.exceedance(STRONG, {"a_x": [3.5]}, duration=20.0, step=step, rtol=0.03)["a_x"]
    assert abs(curve.probability[0] - 0.295) < 3.0 * math.hypot(curve.error[0], 0.001)
    assert curve.error[0] < 0.01
    low, high = curve.return_interval
    assert low[0] * 0.98 < 64.0 < high[0] * 1.02


def test_masses_without_memory_have_settled_when_the_time_of_an_exceedance_begins() -> None:
    """In a short time it is what lies beyond the level at its beginning, and the crossings that Rice's rate adds."""
    pair = beside_an_idle_mass(sp.Spring(1.0, between=GROUND_A), sp.Dashpot(0.2, between=GROUND_A))
    found = sp.exceedance(pair, {"a_x": [3.0]}, duration=0.1, step=0.02, rtol=0.1)
    deviation = math.sqrt(1.0 / 0.4)
    beyond = 0.5 * math.erfc(3.0 / deviation / math.sqrt(2.0))
    rate = math.exp(-0.5 * (3.0 / deviation) ** 2) / (2.0 * math.pi)  # of upward crossings, by Rice
    assert found.settings.start == "stationary"
    curve = found["a_x"]
    assert abs(curve.probability[0] - (beyond + 0.1 * rate)) < 4.0 * curve.error[0]


def test_where_symmetry_makes_the_means_vanish_the_start_is_that_of_rest() -> None:
    """To the last bit, without pilots; and a mean that no memory keeps needs none either."""
    even = beside_an_idle_mass(sp.Spring(1.0, between=GROUND_A), sp.Springpot(0.2, 0.5, between=GROUND_A))
    forgets = beside_an_idle_mass(
        sp.Spring(1.0, between=GROUND_A), sp.Dashpot(0.5, between=GROUND_A),
        sp.Barrier(0.0, 1.0, "above", between=GROUND_A), sp.Springpot(0.2, 0.5, between=GROUND_B),
    )  # fmt: skip
    for system in (even, forgets):
        usual, rest, stationary = (simulated(system, **SHORT, **given) for given in
                                   ({}, {"start": "rest"}, {"start": "stationary"}))  # fmt: skip
        assert usual.settings.start == "stationary"
        assert stationary.diagnostics["pilot_runs"] == 0
        assert stationary.settings.initial_position == rest.settings.initial_position
        assert stationary.path_sums.tobytes() == rest.path_sums.tobytes() == usual.path_sums.tobytes()


def test_a_start_with_walls_and_a_weight_lies_before_every_wall() -> None:
    """A weight on a chain of springpots beside a stop that it is near to."""
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=GROUND_A), sp.Spring(1.0, between=A_B),
        sp.Springpot(0.2, 0.8, between=GROUND_A), sp.Springpot(0.2, 0.8, between=A_B), sp.Constant(1.0, on="b"),
        sp.WhiteNoise(0.1, on="b"), sp.Barrier(1.9, 0.8, "below", between=GROUND_B),
        sp.Barrier(-0.1, 0.8, "above", between=A_B),
    )  # fmt: skip
    plan = adapt(plan_of(system, paths=64, duration=10.0), paths=1024)
    place: Any = plan.settings.initial_position
    assert place["b"] < 1.9
    assert place["b"] - place["a"] > -0.1
    assert plan.adapted is not None
    assert plan.adapted.residual is not None and plan.adapted.residual < 0.03  # noqa: PT018  # about 1 standard error


def test_a_run_from_rest_says_how_far_its_means_are_off() -> None:
    """The mean is 0.22 m off, 16 % of the root mean square."""
    given: dict[str, Any] = {"paths": 500, "duration": 400.0, "window": (200.0, 400.0), "step": 0.07}
    said = [each for each in simulated(STRONG, **given, start="rest").warnings if each.name == "start_was_off"]
    assert len(said) == 1
    share = float(str(said[0]).split("is still about ")[1].split(" %")[0])
    assert 8.0 < share < 20.0
    assert not any(each.name == "start_was_off" for each in simulated(STRONG, **given).warnings)


def test_the_creep_of_a_mean_that_is_there_from_the_beginning_gives_no_warning() -> None:
    """The springpot alone creeps for 3000 s."""
    plan = plan_of(STRONG, **SOON)
    assert motion_of(STRONG).scales.creep_time > 3000.0
    assert plan.transient_left < 0.01 < plan_of(STRONG, **SOON, start="rest").transient_left


@pytest.mark.parametrize("suffix", [validation(".nc"), ".json"])
def test_the_start_is_saved_and_kept_by_more_paths(suffix: str, tmp_path: Path) -> None:
    given: dict[str, Any] = {"duration": 6.0, "step": 0.05}
    run = simulated(LOSSY, paths=640, **given)
    again = sp.load_run(run.save(tmp_path / f"run{suffix}", path_sums=True))
    assert again.adapted == run.adapted
    assert run.adapted is not None
    assert run.adapted.slopes["a_x_mean_square"] > 0.5
    longer, whole = sp.extend(again, paths=700), simulated(LOSSY, paths=700, **given)
    assert longer.path_sums.tobytes() == whole.path_sums.tobytes()
    assert longer.estimates == whole.estimates


@pytest.mark.validation  # every day: total errors hold, in this file
def test_the_error_of_the_start_is_in_the_errors() -> None:
    """<x^2> changes with x(0) by 0.7 of its root per metre; pilots of few paths leave a larger error."""
    many, few = (adapt(plan_of(LOSSY, **SOON, step=0.06), paths=paths) for paths in (16384, 1024))
    assert many.adapted is not None
    assert few.adapted is not None
    assert few.adapted.error is not None
    assert many.adapted.error is not None
    assert 2.0 < few.adapted.error / many.adapted.error < 8.0
    apart = abs(few.settings.initial_position["a"] - many.settings.initial_position["a"])  # type: ignore[index]
    assert apart < 4.0 * math.hypot(few.adapted.error, many.adapted.error) * 1.8


def test_pilots_of_a_run_with_few_paths_are_small() -> None:
    assert [pilot_paths(paths) for paths in (1, 100, 512, 5000, 20_000, 10**6)] == [
        1024, 1600, 8192, 8192, 20_000, 65_536,
    ]  # fmt: skip
    plan = plan_of(sp.Oscillator(), paths=64, duration=2.0)
    few, enough = adapt(plan), adapt(plan, paths=8192)
    assert few.settings.initial_position != enough.settings.initial_position
    # runs that are compared with others have the large ones
    assert sampled_run(plan).samples["x_mean"][0] == sampled_run(enough).samples["x_mean"][0]


def test_a_study_of_several_masses_starts_at_their_means() -> None:
    study = {
        "name": "stops", "system": LOSSY, "methods": ["monte_carlo"], "axes": {"parts.stop.restitution": [0.9]},
        "quantities": ["a_x_mean"], "monte_carlo": {"paths": 1000, "duration": 60.0, "window": [20.0, 60.0]},
    }  # fmt: skip
    found = sp.study(study)["simulation"].to_dataset()
    value, error = (float(found[name].values.ravel()[0]) for name in ("a_x_mean", "a_x_mean_se"))
    assert abs(value - 1.4453) < 4.0 * math.hypot(error, 0.0066)
    assert np.isfinite(error)


@pytest.mark.validation
@pytest.mark.parametrize("name", ["lossy", "uneven"])
def test_errors_of_runs_with_few_paths_hold_and_no_start_is_called_off(name: str) -> None:
    """Sixty seeds: their pilots have 1600 paths, and the standard errors include what these leave."""
    system, right = RIGHT[name]
    (value, its_error), given = right["a_x_mean"], {"duration": 120.0, "window": (40.0, 120.0), "step": 0.08}
    apart = []
    for seed in range(60):
        run = simulated(system, paths=100, **given, seed=seed)  # type: ignore[arg-type]
        assert not any(sentence.name == "start_was_off" for sentence in run.warnings)
        apart.append((run["a_x_mean"].value - value) / run["a_x_mean"].error)
    mean_error = its_error / run["a_x_mean"].error
    assert abs(np.mean(apart)) < 3.0 * math.hypot(1.0 / math.sqrt(60.0), mean_error)
    assert 0.75 < np.std(apart) < 1.3
