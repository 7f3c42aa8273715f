"""Flights on a circle with impacts in lanes: single flights are exact, and so are laws at coarse steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.kernel.lanes import LANES
from springpot.theory import exact
from tests.simulation.kernel.flights import FAINT, in_lanes, one_after_another
from tests.simulation.problems import errors_of, values_of
from tests.simulation.systems import NEARLY_LINEAR

FREQUENCY = 1.7
BELOW, CLOSE, PRESSED = ((1.0, -0.4, 0.8),), ((1.0, -0.05, 0.9), (-1.0, 0.06, 1.0)), ((1.0, 0.3, 1.0),)


def _with(walls: Any, intensity: float = FAINT) -> sp.System:
    names = {1.0: "above", -1.0: "below"}
    made = (sp.Barrier(place, r, names[side]) for side, place, r in walls)
    return sp.System(sp.Spring(FREQUENCY**2), sp.WhiteNoise(intensity), *made)


def _starts(walls: Any) -> np.ndarray:
    """Near the first wall, on the side of the motion."""
    rng, (side, place, _) = np.random.default_rng(3), walls[0]
    wide = min((abs(other - place) for _, other, _ in walls[1:]), default=1.0)
    x = place + side * wide * rng.uniform(0.02, 0.98, LANES)
    return np.stack([x, FREQUENCY * rng.normal(size=LANES)], axis=1)


@pytest.mark.parametrize("walls", [BELOW, CLOSE, PRESSED], ids=["below", "close", "pressed"])
@pytest.mark.parametrize("step", [0.03, 0.29])
def test_flights_with_impacts_are_exact_at_any_step(walls: Any, step: float) -> None:
    """With up to eight impacts in half a step between two close walls; 64 paths, each from a start of its own."""
    steps, starts = round(9.0 / step), _starts(walls)
    seen, sums = in_lanes(_with(walls), starts, step, steps)
    impacts = np.sum([each for (quantity, _), each in sums.items() if quantity == "impacts"], axis=0)
    assert impacts.sum() > 100.0
    for path, (x, v) in enumerate(starts.tolist()):
        by_hand, speeds = one_after_another(walls, FREQUENCY, x, v, step * np.arange(1.0, steps + 1.0))
        np.testing.assert_allclose(seen[path, 1:, 0], by_hand, atol=1e-10)
        assert abs(impacts[path] - len(speeds)) <= np.ceil(0.5 * step * FREQUENCY)  # those of the last half step


@pytest.mark.parametrize("restitution", [0.5, 0.0])
def test_chattering_on_a_pressed_wall_ends(restitution: float) -> None:
    """Infinitely many hops, after which the mass lies on the wall; each of them took its share of the energy."""
    walls = ((1.0, 0.3, restitution),)
    seen, sums = in_lanes(_with(walls, 1.0), _starts(walls), 0.1, 400)
    np.testing.assert_allclose(seen[:, -1, 0], [[0.3, 0.0]] * LANES, atol=1e-6)
    assert (seen[:, :, 0, 0] > 0.3 - 1e-12).all()
    lost = sums["energy", "first"] - sums["energy", "last"]
    np.testing.assert_allclose(sums["loss", "barrier"], lost, rtol=1e-6)
    assert (sums["impacts", "barrier"] < 30.0).all()  # one that lies there does not strike
    assert restitution > 0.0 or (sums["impacts", "barrier"] == 1.0).all()


def test_a_wall_above_is_the_mirror_image_to_the_last_bit() -> None:
    starts = _starts(BELOW)
    low, sums = in_lanes(_with(BELOW), starts, 0.29, 60)
    high, mirrored = in_lanes(_with(((-1.0, 0.4, 0.8),)), -starts, 0.29, 60)
    np.testing.assert_array_equal(high, -low)
    np.testing.assert_array_equal(mirrored["speeds", "barrier"], sums["speeds", "barrier"])


@pytest.mark.parametrize(("position", "paths"), [(0.0, 30_000), (-0.5, 30_000), (0.3, 30_000)])
def test_coarse_steps_have_the_exact_law_at_order_1(position: float, paths: int) -> None:
    """The scheme is exact at any step then; at 0.4 / Omega some ten of a block's paths strike in four steps."""
    problem = sp.Oscillator(1.0, sp.Springpot(1.0, 1.0), sp.Barrier(position, free_side="above"))
    found = sp.simulate(
        problem, paths=paths, duration=60.0, step=0.4, window=(20.0, 60.0), start="rest", distributions=True
    )
    law = exact(problem)
    for name in ("x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean"):
        value, error = float(found[name].value), float(found[name].error)
        assert error < 0.005 * value, name
        assert abs(value - getattr(law, name)) < 4.0 * error, name


def _pair(restitution: float) -> sp.System:
    walls = sp.Barrier(-0.5, restitution), sp.Barrier(0.7, restitution, free_side="below")
    return sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0), NEARLY_LINEAR, *walls)


def test_coarse_steps_between_two_walls_have_the_exact_rates() -> None:
    """The density at each wall times the mean speed away from it, for x and v are independent."""
    found = sp.simulate(_pair(1.0), paths=20_000, duration=60.0, step=0.3, window=(20.0, 60.0), start="rest")
    x = np.linspace(-0.5, 0.7, 20_001)
    density = np.exp(-0.5 * x**2)  # kT = q / (2 c) = 1
    density /= np.trapezoid(density, x)
    rates = density[[0, -1]] / np.sqrt(2.0 * np.pi)
    names = ("barrier_1_impact_rate", "barrier_2_impact_rate")
    values, errors = (np.array([at[name] for name in names]) for at in (values_of(found), errors_of(found)))
    assert np.all(np.abs(values - rates) < 4.0 * errors)
    assert np.all(errors < 0.005 * rates)
    assert abs(float(found["v_mean_square"].value) - 1.0) < 4.0 * float(found["v_mean_square"].error)


@pytest.mark.parametrize("problem", [sp.Oscillator(barrier=sp.Barrier(-0.2, 0.5)), _pair(0.5)], ids=["one", "two"])
def test_each_impact_is_shown_to_the_observers(problem: Any) -> None:
    """And what they are shown has no effect on the run, of which most groups are advanced in one go."""
    given: dict[str, Any] = {
        "paths": 640, "duration": 80.0, "step": 0.2, "window": (20.1, 70.3), "start": "rest", "seed": 4,
    }  # fmt: skip
    alone = sp.simulate(problem, **given)
    seen = sp.simulate(
        problem, impact_observables={"count": lambda speed: 1.0, "dose": lambda speed: speed**3}, **given
    )
    for name in ("impact_rate", "x_mean_square", "impact_speed_mean"):
        assert float(seen[name].value) == float(alone[name].value)
    assert seen["count"].value == pytest.approx(float(alone["impact_rate"].value), rel=1e-12)
    assert float(seen["count"].value) > 0.05


@pytest.mark.parametrize(("position", "window"), [(0.33, (0.0, 0.4)), (0.33, (0.4, 0.8)), (0.26, (0.0, 0.3))])
def test_an_impact_near_an_end_of_the_window_is_counted_on_its_side(
    position: float, window: tuple[float, float]
) -> None:
    """The first impacts come at an end of the window; the half step of 0.05 s beside it has a tenth of them or more.

    Two windows end with a group of four coarse steps, the third within one.
    """
    problem = sp.Oscillator(springpot=sp.Springpot(1.0, 1.0), excitation=sp.WhiteNoise(0.1))
    begun: dict[str, Any] = {"initial_position": position, "initial_velocity": -1.0, "start": "rest"}
    coarse, fine = (
        sp.simulate(problem, paths=30_000, duration=1.2, step=step, window=window, seed=seed, **begun)
        for seed, step in ((1, 0.1), (2, 0.0125))
    )
    expected = float(fine["impact_rate"].value)
    error = np.hypot(float(coarse["impact_rate"].error), float(fine["impact_rate"].error))
    assert error < 0.012 * expected
    assert abs(float(coarse["impact_rate"].value) - expected) < 4.0 * error


def test_impacts_of_two_windows_are_those_of_both() -> None:
    problem = sp.Oscillator(barrier=sp.Barrier(-0.2, 0.5))
    given: dict[str, Any] = {"paths": 640, "duration": 160.0, "step": 0.2, "start": "rest", "seed": 4}
    counts = [
        round(float(sp.simulate(problem, window=window, **given)["impact_rate"].value) * 640 * (window[1] - window[0]))
        for window in ((0.0, 80.0), (80.0, 160.0), (0.0, 160.0))
    ]
    assert counts[0] + counts[1] == counts[2] > 1000
