"""Impacts in vector code: the closed form of one impact, and runs at coarse steps in which most groups have them."""

from typing import Any

import numpy as np
import pytest
from numba import njit
from springpot.simulation.kernel.questions import splitting
from springpot.simulation.kernel.restitution import Fixed
from springpot.simulation.kernel.rigid_wall import fly
from springpot.simulation.kernel.single_impacts import flight

import springpot as sp
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.watching import NO_OBSERVERS, Accumulators
from springpot.theory import exact
from tests.simulation.problems import errors_of, values_of
from tests.simulation.systems import NEARLY_LINEAR

FREQUENCY = 1.7


@njit(_nrt=False)  # without counting of references, and number by number: a fifth of the time to compile
def _both(scheme, place, rule, states, phases, sums, found):  # type: ignore[no-untyped-def]
    """Of each state: x, v and speed by one flight, whether it is sure, and x, v, impacts and speed by the exact one."""
    for n in range(phases.size):
        x, v, phase = states[0, n], states[1, n], phases[n]
        c, s = np.cos(phase), np.sin(phase)
        moved, change = (c - 1.0) * x + s / FREQUENCY * v, (c - 1.0) * v - s * FREQUENCY * x
        dx, dv, speed, sure = flight(FREQUENCY, place, 1.0, rule.restitution, x, v, moved, change)
        above, up, again, certain = flight(FREQUENCY, -place, -1.0, rule.restitution, -x, -v, -moved, -change)
        sums.impacts[0] = sums.speeds[0] = 0.0
        xn, vn = fly(place, rule, scheme, x, v, phase, 0.0, 0.0, 0.0, sums, 0, 1.0)
        found[0, n], found[1, n], found[2, n], found[3, n] = x + dx, v + dv, speed, 1.0 if sure else 0.0
        found[4, n], found[5, n], found[6, n], found[7, n] = xn, vn, sums.impacts[0], sums.speeds[0]
        same = above == -dx and up == -dv and again == speed and certain == sure
        if not same:
            found[0, n] = np.nan


@pytest.mark.parametrize("restitution", [1.0, 0.6, 0.0])
@pytest.mark.parametrize("place", [0.0, -0.4, 0.3])
def test_one_impact_in_closed_form_is_the_exact_flight(place: float, restitution: float) -> None:
    """Starts near the wall, so that a fifth of them strike; above and below the motion alike, to the last bit."""
    rng = np.random.default_rng(1)
    count = 20_000
    states = np.stack([place + rng.exponential(0.5, count), FREQUENCY * rng.normal(size=count)])
    sums = Accumulators(*(np.zeros(LANES) for _ in range(4)), np.zeros(LANES), NO_OBSERVERS)
    found = np.empty((8, count))
    longest = 1.4 if place <= 0.0 else 0.5
    _both(
        splitting(FREQUENCY, 0.0, 0.1), place, Fixed(restitution), states, rng.uniform(0.0, longest, count), sums, found
    )
    sure = found[3] == 1.0
    assert np.mean(found[2] > 0.0) > 0.15
    assert sure.all() if place <= 0.0 else sure.mean() > 0.8  # a preload brings some back at once
    x, v, speed, _, x_exact, v_exact, impacts, speeds = found[:, sure]
    assert impacts.max() == (0.0 if place > 0.0 == restitution else 1.0)
    np.testing.assert_array_equal(impacts, speed > 0.0)
    np.testing.assert_allclose([x, v, speed], [x_exact, v_exact, speeds], atol=1e-9)


@pytest.mark.parametrize(("position", "paths"), [(0.0, 30_000), (-0.5, 30_000), (0.3, 30_000)])
def test_coarse_steps_have_the_exact_law_at_order_1(position: float, paths: int) -> None:
    """The scheme is exact at any step then; at 0.4 / Omega some ten of a block's paths strike in four steps."""
    problem = sp.Oscillator(1.0, sp.Springpot(1.0, 1.0), sp.Barrier(position, side="above"))
    found = sp.simulate(
        problem, paths=paths, duration=60.0, step=0.4, window=(20.0, 60.0), start="rest", distributions=True
    )
    law = exact(problem)
    for name in ("x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean"):
        value, error = float(found[name].value), float(found[name].error)
        assert error < 0.005 * value, name
        assert abs(value - getattr(law, name)) < 4.0 * error, name


def _pair(restitution: float) -> sp.System:
    walls = sp.Barrier(-0.5, restitution), sp.Barrier(0.7, restitution, side="below")
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
