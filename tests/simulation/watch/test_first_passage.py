"""First passages: against recorded paths, exact laws, Rice's rate, finer steps and samples that are cut off."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.simulation import PassageTimes, simulate
from tests.simulation.problems import oscillator, values_of
from tests.simulation.systems import NEARLY_LINEAR
from tests.simulation.test_modulated import of_pair
from tests.sizes import validation

Floats = np.ndarray[Any, np.dtype[np.float64]]
BRIEF = sp.JenningsHousnerEnvelope(rise=2.0, fall=3.0, decay=1.0)


def through(kind: str, path: Floats, step: float, level: float, intensity: float) -> float:
    """What the observer does, in plain Python on a recorded path: time of the first passage upwards."""
    root = 0.5826 * math.sqrt(intensity * step)
    for n in range(1, len(path)):
        (x0, v0), (x1, v1) = path[n - 1], path[n]
        if kind == "x":
            g0, g1 = x0 - level, x1 - level
        elif kind == "speed":
            g0, g1 = abs(v0) - level + root, abs(v1) - level + root
        else:
            g0 = 0.5 * (x0**2 + v0**2) - level + abs(v0) * root
            g1 = 0.5 * (x1**2 + v1**2) - level + abs(v1) * root
        if g1 >= 0.0:
            return step * (n - 1) + step * (-g0 / (g1 - g0) if g0 < 0.0 else 0.0)
        if kind == "x" and v0 > 0.0 > v1:
            s = v0 / (v0 - v1)
            top = g0 + 0.5 * step * v0 * s + (g1 - g0 - 0.5 * step * (v0 + v1)) * s * s * (3.0 - 2.0 * s)
            if top >= 0.0:
                return step * (n - 1) + step * s * (1.0 - math.sqrt(top / (top - g0)))
    return math.inf


@pytest.mark.parametrize("side", ["above", "below"])
def test_times_are_those_of_the_recorded_paths(side: str) -> None:
    """The same interpolation of the same path in NumPy; a wall above is the mirror image."""
    sign = 1.0 if side == "above" else -1.0
    problem = sp.Oscillator(springpot=sp.Springpot(0.5, 0.2), barrier=sp.Barrier(-0.5 * sign, 1.0, side))
    levels = {"x": 2.0 * sign, "energy": 4.0}
    found = simulate(problem, paths=70, record=70, duration=20.0, step=0.05, start="rest", first_passage=levels)
    for kind, level in (("x", 2.0), ("energy", 4.0)):
        times = found.first_passages[kind].times
        wanted = np.array([through(kind, sign * path, 0.05, level, 1.0) for path in found.record])
        assert 0.2 < np.isfinite(times).mean() < 1.0
        np.testing.assert_array_equal(np.isfinite(times), np.isfinite(wanted))
        passed = np.isfinite(times)
        np.testing.assert_allclose(times[passed], wanted[passed], rtol=1e-9, atol=1e-9)


def test_the_same_bits_for_any_number_of_threads() -> None:
    given: dict[str, Any] = {"paths": 300, "duration": 20.0, "step": 0.05, "first_passage": {"x": 1.5, "v": 1.5}}
    one, other = (simulate(oscillator(), **given, threads=threads) for threads in (1, 3))
    for name in ("x", "v"):
        np.testing.assert_array_equal(one.first_passages[name].times, other.first_passages[name].times)
    alone = simulate(oscillator(), **{**given, "first_passage": None})
    assert values_of(alone) == values_of(one)


def test_a_velocity_without_spring_is_an_ornstein_uhlenbeck_process() -> None:
    """Order 1, Omega so small that v is Ornstein-Uhlenbeck: the mean time to |v| = a is known exactly, and a step of a
    twentieth of the relaxation time is within a per cent of it (without the correction it is 25 % too long)."""
    damping, level = 1.0, 1.0
    problem = sp.Oscillator(1e-3, sp.Springpot(1.0, damping), None, sp.WhiteNoise(1.0))
    # T(0) = (2 / q) int_0^a exp(c y^2 / q) int_0^y exp(-c z^2 / q) dz dy
    y = np.linspace(0.0, level, 4001)
    dy = y[1] - y[0]

    def integrated(f: Floats) -> Floats:
        return np.concatenate([[0.0], np.cumsum(0.5 * dy * (f[1:] + f[:-1]))])

    exact = 2.0 * float(integrated(np.exp(damping * y**2) * integrated(np.exp(-damping * y**2)))[-1])
    found = simulate(problem, paths=20_000, duration=15.0, step=0.05, start="rest", first_passage={"speed": level})
    mean, error, _ = found.first_passages["speed"].mean
    assert error < 0.008 * exact
    assert abs(mean - exact) < 3.0 * error + 0.01 * exact


def test_rare_passages_of_x_come_at_rices_rate() -> None:
    """No wall, order 1: above 3.5 standard deviations the mean time is one over the rate of upcrossings, with the few
    per cent that they come in clumps at this damping."""
    damping = 1.0
    problem = sp.Oscillator(1.0, sp.Springpot(1.0, damping), None, sp.WhiteNoise(1.0))
    deviation = math.sqrt(0.5 / damping)
    rate = math.exp(-6.125) / (2.0 * math.pi)
    levels = {"x": 3.5 * deviation, "distance": 3.5 * deviation}
    found = simulate(problem, paths=12_000, duration=420.0, window=(20.0, 420.0), step=0.1, first_passage=levels)
    passage, distance = (found.first_passages[kind] for kind in levels)
    mean, error, assumed = passage.mean
    assert passage.share_censored > 0.8
    assert "have not passed" in assumed
    assert error < 0.06 / rate
    assert 1.0 / rate - 3.0 * error < mean < 1.1 / rate + 3.0 * error
    assert abs(distance.mean[0] / mean - 0.5) < 0.1


@pytest.mark.validation
def test_the_step_hardly_shows() -> None:
    """A coarse step beside one a fifth of it: for x, and for v and energy, which noise drives."""
    problem = oscillator(1.0, 0.3, restitution=0.9)
    levels = {"x": 2.0, "v": 2.0, "energy": 2.0}
    coarse, fine = (
        simulate(
            problem, paths=paths, duration=60.0, step=step, start="rest", seed=seed, first_passage=levels
        ).first_passages
        for paths, step, seed in ((12_000, 0.1, 1), (8000, 0.02, 2))
    )
    for name in levels:
        (first, error), (second, its_error) = coarse[name].restricted_mean, fine[name].restricted_mean
        assert math.hypot(error, its_error) < 0.02 * second
        assert abs(first - second) < 3.0 * math.hypot(error, its_error) + 0.01 * second, name


def survival_of_both_steps(
    system: sp.System, levels: dict[str, Any], paths: int, duration: float, step: float
) -> tuple[Floats, Floats]:
    """Shares not passed 0.1 s before the end, with errors, at a step of 0.02; those at a coarse one are the same."""
    (coarse, error), (fine, other) = (
        np.array([passage.survival(duration - 0.1)[:2] for passage in found.first_passages.values()]).T
        for found in (
            simulate(system, paths=paths, duration=duration, step=own, seed=seed, start="rest", first_passage=levels)
            for own, seed in ((step, 1), (0.02, 2))
        )
    )
    assert (np.hypot(error, other) < 0.02 * np.minimum(fine, 1.0 - fine)).all()
    assert (np.abs(coarse - fine) < 3.0 * np.hypot(error, other)).all()
    return fine, other


def test_the_step_hardly_shows_under_an_envelope() -> None:
    """What noise does between two observations is that of the time: before, v was passed 8 % too often."""
    system = of_pair(sp.WhiteNoise(1.0, on="a", envelope=BRIEF), damping=0.5)
    levels = {"a_v": 1.1, "dashpot_force": 0.4}
    fine, other = survival_of_both_steps(system, levels, 60_000, 6.0, 0.05)
    split = sp.exceedance(system, levels, duration=6.0, step=0.05, rtol=0.01)
    for name, p, error in zip(levels, 1.0 - fine, other, strict=True):
        assert split.error[name] < 0.011 * p
        assert abs(split.probability[name] - p) < 3.0 * np.hypot(split.error[name], error), name


def test_the_step_hardly_shows_in_passages_of_a_springpots_force() -> None:
    """As for a dashpot the level would be lowered too far: this one was passed 9 % more often at the coarse step."""
    system = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0))
    fine, _ = survival_of_both_steps(system, {"springpot_force": 0.8}, 30_000, 30.0, 0.1)
    assert 0.2 < fine[0] < 0.5


@pytest.mark.validation
def test_the_step_of_one_mass_hardly_shows_under_an_envelope() -> None:
    """Of what depends on v in other ways too, and of a function of one's own, which depends on the time."""
    envelope = sp.JenningsHousnerEnvelope(rise=4.0, fall=6.0, decay=0.5)
    system = sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0, envelope=envelope))
    levels: dict[str, Any] = {
        "v": 1.8, "speed": 1.6, "energy": 1.8, "amplitude": 1.9, "dashpot_force": 0.3,
        "own": (lambda t, x, v: v * (1.0 + 0.02 * t), 1.9),
    }  # fmt: skip
    survival_of_both_steps(system, levels, 40_000, 14.0, 0.1)


def test_the_first_impact_is_the_passage_of_x_to_the_wall() -> None:
    """A passage between the ends of a step, which only the impact shows."""
    problem = oscillator(1.0, 0.2, position=-1.0, restitution=0.8)
    found = simulate(problem, paths=200, record=200, duration=40.0, step=0.1, start="rest", first_passage={"x": -1.0})
    times = found.first_passages["x"].times
    x, v = found.record[:, :, 0], found.record[:, :, 1]
    # a path turns round at the wall faster than its spring could turn it
    turned = (v[:, :-1] < 0.0) & (v[:, 1:] > 0.0) & (x[:, :-1] < -0.7)
    first = np.where(turned.any(axis=1), 0.1 * turned.argmax(axis=1), np.inf)
    both = np.isfinite(times) & np.isfinite(first)
    assert both.mean() > 0.9
    assert np.median(np.abs(times[both] - first[both])) <= 0.1
    assert np.mean(first[both] - times[both] > 0.5) < 0.02
    assert times.min() > 0.3


def test_the_clock_of_a_stationary_start_starts_with_the_window() -> None:
    found = simulate(oscillator(), paths=2000, duration=60.0, window=(30.0, 60.0), step=0.05, first_passage={"x": 1.0})
    passage = found.first_passages["x"]
    assert passage.begin == pytest.approx(30.05)
    assert passage.horizon == pytest.approx(29.95)
    beyond = simulate(
        oscillator(), paths=2000, duration=60.0, window=(30.0, 60.0), step=0.05,
        observables={"beyond": lambda t, x, v: 1.0 if x >= 1.0 else 0.0},
    )  # fmt: skip
    share, error = beyond["beyond"].value, math.sqrt(0.25 / 2000)
    assert abs(passage.share_at_start - share) < 4.0 * error
    assert passage.survival(0.0)[0] == 1.0 - passage.share_at_start
    assert any("beyond the level when the clock started" in sentence for sentence in found.warnings)
    from_rest = simulate(oscillator(), paths=64, duration=5.0, step=0.05, start="rest", first_passage={"x": 1.0})
    assert from_rest.settings.window == (0.0, 5.0)
    assert from_rest.first_passages["x"].begin == 0.0


def censored(horizon: float, times: Floats, settling: float = 1.0) -> PassageTimes:
    times = np.where(times > horizon, np.inf, times)
    return PassageTimes("x", 1.0, math.nan, "m", 0.0, horizon, settling, times)


def test_a_mean_of_censored_times_holds_over_samples() -> None:
    """Exponential times after a dead time: value and standard error of the mean, over 300 samples."""
    generator = np.random.default_rng(1)
    found = []
    for _ in range(300):
        times = 0.5 + generator.exponential(8.0, 500)
        found.append(censored(6.0, times).mean[:2])
    values, errors = np.array(found).T
    assert abs(values.mean() - 8.5) < 4.0 * values.std() / math.sqrt(300) + 0.1
    assert values.std() == pytest.approx(errors.mean(), rel=0.15)


@pytest.mark.parametrize(
    ("times", "settling", "sentence"),
    [
        (np.linspace(0.1, 100.0, 1000), 20.0, "too short for a mean time"),
        (np.linspace(4.6, 2000.0, 1000), 1.0, "too few for a mean time"),
        (np.concatenate([np.linspace(0.1, 4.0, 990), np.full(10, 20.0)]), 1.0, "too few for a mean time"),
        (
            np.concatenate([np.linspace(0.1, 8.9, 500), np.linspace(9.0, 10.0, 300), np.full(200, 20.0)]),
            1.0,
            "still changes",
        ),
    ],
)
def test_a_mean_that_is_not_known_is_not_given(times: Floats, settling: float, sentence: str) -> None:
    passage = censored(10.0, times, settling)
    assert math.isnan(passage.mean_time)
    assert sentence in passage.mean[2]
    assert any(sentence in warning for warning in passage.warnings)
    assert math.isfinite(passage.restricted_mean[0])


@pytest.mark.parametrize("passed", [0.5, 0.999])
def test_after_an_earthquake_no_longer_run_is_advised(passed: float) -> None:
    """Who has not passed by its end need never pass: there is no mean time, and nothing is wrong."""
    times = np.where(np.linspace(0.0, 1.0, 1000) < passed, np.linspace(0.1, 9.0, 1000), 20.0)
    passage = censored(10.0, times, math.inf)
    assert math.isnan(passage.mean_time)
    assert passage.mean[2].endswith("so there is no mean time: use quantiles.")
    assert passage.warnings == ()
    brief = sp.ExponentialEnvelope(slow=0.2, fast=0.6)
    device = sp.System(sp.Mass(1.0), sp.Spring(40.0), sp.Dashpot(0.6), sp.WhiteNoise(0.5, on="ground", envelope=brief))
    run = sp.simulate(device, paths=200, first_passage={"distance": 0.15}, seed=1)
    assert 0.1 < run.first_passages["distance"].share_censored < 0.9
    assert not [warning for warning in run.warnings if "distance_first_passage" in warning]


def test_quantiles_and_survival_of_a_sample() -> None:
    times = np.random.default_rng(2).exponential(2.0, 4000)
    passage = censored(4.0, times)
    at, error = passage.quantile([0.5, 0.99])
    assert abs(at[0] - 2.0 * math.log(2.0)) < 4.0 * error[0]
    assert math.isnan(at[1])
    survival, its_error = passage.survival([0.0, 2.0])
    assert survival[0] == 1.0
    assert its_error[0] == pytest.approx(1.0 / 4000.0, rel=0.01)  # that no path has passed is not that none can
    assert abs(survival[1] - math.exp(-1.0)) < 4.0 * its_error[1]
    with pytest.raises(ValueError, match="where the paths were watched"):
        passage.survival(5.0)


def test_an_observable_passes_like_the_quantity_it_is() -> None:
    given: dict[str, Any] = {"paths": 128, "duration": 20.0, "step": 0.05, "start": "rest"}
    levels = {"energy": 2.0, "own": (lambda t, x, v: 0.5 * (v * v + x * x), 2.0)}
    found = simulate(oscillator(), **given, first_passage=levels).first_passages
    np.testing.assert_allclose(found["own"].times, found["energy"].times, rtol=1e-9)


@pytest.mark.parametrize(("order", "position"), [validation(1.0, 0.0), (0.5, None)])
def test_the_envelope_knows_when_x_passes_at_light_damping(order: float, position: float | None) -> None:
    """Within 10 % for x, where the amplitude passes the same level in about half of the time."""
    problem = oscillator(order, 0.1, position=position)
    envelope = sp.theory.envelope(problem)
    level = 1.2 * math.sqrt(envelope.amplitude_mean_square)
    levels = {"x": level, "amplitude": level}
    found = simulate(problem, paths=4000, duration=300.0, step=0.1, start="rest", first_passage=levels).first_passages
    mean, error, _ = found["x"].mean
    assert error < 0.025 * mean
    assert abs(envelope.first_passage(x=level).mean_time / mean - 1.0) < 0.1
    assert found["amplitude"].mean_time < 0.7 * mean
    with pytest.raises(sp.theory.NotCoveredError, match="simulate it"):
        sp.theory.envelope(oscillator(0.5, 0.4)).first_passage(x=level)
    with pytest.raises(TypeError, match="one level"):
        envelope.first_passage(x=level, amplitude=level)


@pytest.mark.parametrize(
    ("order", "c", "paths"), [(0.5, 0.3, 3000), validation(1.0, 0.04, 8000), validation(0.2, 0.1, 8000)]
)
def test_the_envelope_knows_when_x_passes_on_one_side_or_both(order: float, c: float, paths: int) -> None:
    """At three root mean squares, where the amplitude passes in a third to half of the time."""
    q = 2.0 * c * math.sin(order * math.pi / 2.0)
    problem = sp.Oscillator(springpot=sp.Springpot(order, c), barrier=None, excitation=sp.WhiteNoise(q))
    envelope = sp.theory.envelope(problem)
    level = 3.0 * math.sqrt(envelope.x_mean_square)
    levels = {"x": level, "distance": level, "amplitude": level}
    found = simulate(problem, paths=paths, duration=1000.0, step=0.1, start="rest", first_passage=levels).first_passages
    for name, room in (("x", 0.03), ("distance", 0.03), ("amplitude", 0.06)):
        mean, error, _ = found[name].mean
        assert error < 0.025 * mean
        assert abs(envelope.first_passage(**{name: level}).mean_time / mean - 1.0) < room + 2.0 * error / mean, name


def test_between_two_walls_an_impact_on_one_is_no_passage_at_the_other() -> None:
    """Mirror images alike, and a distance from a wall is a place: impacts were read as on the lower wall at 0."""
    parts = sp.Spring(1.0), sp.Dashpot(0.2), NEARLY_LINEAR
    even = sp.System(*parts, sp.WhiteNoise(0.4), sp.Barrier(-0.3, 0.3), sp.Barrier(0.3, 0.3, free_side="below"))
    (down, its), (up, error) = (
        simulate(even, paths=4000, duration=60.0, start="rest", seed=5, first_passage={"v": v})
        .first_passages["v"]
        .mean[:2]
        for v in (-1.0, 1.0)
    )
    assert math.hypot(its, error) < 0.025 * up
    assert abs(down - up) < 3.5 * math.hypot(its, error)
    pressed = sp.System(
        *parts, sp.Constant(1.0), sp.WhiteNoise(0.05), sp.Barrier(1.0, 0.7, "above"), sp.Barrier(2.0, 0.7, "below")
    )
    levels = {"distance": {"level": 0.4, "reference": 1.0}, "x": 1.4}
    found = simulate(pressed, paths=500, duration=60.0, start="rest", seed=5, first_passage=levels).first_passages
    np.testing.assert_allclose(found["distance"].times, found["x"].times, rtol=1e-9)


@pytest.mark.parametrize(("c", "level"), [(1e-5, 3.0), (1e-5, 6.0), (0.01, 5.0), (0.1, 6.0)])
def test_an_elastic_wall_at_rest_shows_the_distance_without_it(c: float, level: float) -> None:
    """Behind it x is |x| without the wall, at order 1: it was off by a factor of 2."""

    def of(barrier: sp.Barrier | None) -> sp.theory.Envelope:
        pot, noise = sp.Springpot(1.0, c), sp.WhiteNoise(2.0 * c)
        return sp.theory.envelope(sp.Oscillator(springpot=pot, barrier=barrier, excitation=noise))

    behind, without = of(sp.Barrier(0.0)).first_passage(x=level), of(None).first_passage(distance=level)
    assert behind.mean_time == pytest.approx(without.mean_time, rel=0.04)
    if c == 1e-5:  # one that is looked at so often passes as the amplitude does
        assert without.mean_time == pytest.approx(of(None).first_passage(amplitude=level).mean_time, rel=0.05)


@pytest.mark.parametrize("level", [6.0, 8.0])
def test_rare_passages_of_the_envelope_come_at_rices_rate(level: float) -> None:
    """At order 1, unit variance and c = 0.3: 2 pi exp(level^2 / 2) on one side, half of it on both."""
    c = 0.3
    envelope = sp.theory.envelope(
        sp.Oscillator(springpot=sp.Springpot(1.0, c), barrier=None, excitation=sp.WhiteNoise(2.0 * c))
    )
    rice = 2.0 * math.pi * math.exp(0.5 * level**2)
    assert envelope.first_passage(x=level).mean_time == pytest.approx(rice, rel=0.1)
    assert envelope.first_passage(distance=level).mean_time == pytest.approx(0.5 * rice, rel=0.1)


def test_the_amplitude_is_that_of_the_motion_with_the_springpot() -> None:
    """Where a springpot is most of the stiffness, A with the bare frequency passes in a cycle what x never does."""
    problem = sp.Oscillator(
        natural_frequency=68.9, springpot=sp.Springpot(0.25, 1555.0), barrier=None, excitation=sp.WhiteNoise(0.914)
    )
    assert problem.resonance == pytest.approx(96.0, rel=1e-2)
    level = 3.0 * math.sqrt(sp.theory.envelope(problem).x_mean_square)
    levels = {"x": level, "amplitude": level}
    found = simulate(problem, paths=2000, duration=10.0, start="rest", first_passage=levels).first_passages
    assert found["amplitude"].mean[0] > 0.15 * found["x"].mean[0]
    expected = sp.theory.envelope(problem).first_passage(amplitude=level).mean_time
    assert expected == pytest.approx(found["amplitude"].mean[0], rel=0.25)
    assert "resonance with all that has memory: 95." in sp.explain(problem) or "96." in sp.explain(problem)


@pytest.mark.parametrize(
    ("wanted", "sentence"),
    [
        ([("x", 1.0)], "first_passage must be a dict"),
        ({"x": "far"}, "first_passage level of x"),
        ({"x": -1.0}, "first_passage level of x is -1 m, behind a wall: x lies between 0 and inf."),
        ({"amplitude": 0.0}, "first_passage level of amplitude"),
        ({"distance": {"level": 1.0, "reference": "here"}}, "first_passage reference of distance"),
        ({"distance": {"reference": 1.0}}, "must be a level or a list of levels, or {'level': 0.004"),
        ({"x": {"level": 1.0, "reference": 0.5}}, "first_passage of x must be a level or a list of levels, not {"),
        ({"distance": (0.004, 0.006)}, "first_passage of distance must be a level or a list of levels, not (0.004, "),
        ({"distance": [0.004, -0.006]}, "first_passage level of distance must be"),
        ({"distance": [0.004, (0.1, 0.2)]}, "first_passage of distance must be a level or a list of levels, not (0.1"),
        ({"x": []}, "first_passage of x must have 1 to 1000 levels, not 0."),
        ({"x": np.linspace(1.0, 9.0, 1001)}, "first_passage of x must have 1 to 1000 levels, not 1001."),
        ({"x": [1.0, math.nan]}, "first_passage level of x must be in [-1e+50, 1e+50], not nan"),
        ({"x": [1.0, [2.0]]}, "or (low, high) for an interval that is left, not [2.0]."),
        ({"x": [1.0, -1.0]}, "first_passage level of x is -1 m, behind a wall: x lies between 0 and inf."),
        ({"x": (-1.0, 1.0)}, "first_passage level of x is -1 m, behind a wall: x lies between 0 and inf."),
        ({"x": (2.0, 1.0)}, "first_passage of x must have its interval from low to high, not (2.0, 1.0)."),
        ({"v": (-1.0, 0.0, 1.0)}, "must be levels in a list, or an interval (low, high), not (-1.0, 0.0, 1.0)."),
        ({"v": (-1.0, "up")}, "first_passage level of v must be"),
        ({"energy": [1.0, 0.0]}, "first_passage level of energy must be"),
        ({"own": (lambda t, x, v: x, [])}, "first_passage of own must have 1 to 1000 levels, not 0."),
        ({"own": 1.0}, "give a pair: a function of"),
        ({"two words": (abs, 1.0)}, "in one word"),
        ({"x_mean": (lambda t, x, v: x, 1.0)}, "already has a result of that name"),
        ({"own": (abs, 1.0)}, "must be of a function of"),
        ({"own": (lambda t, x: x, 1.0)}, "Numba can compile"),
        ({"own": (lambda t, x, v: x, math.nan)}, "first_passage level of own"),
    ],
)
def test_bad_levels_are_refused_in_one_sentence(wanted: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match="first_passage") as caught:
        simulate(oscillator(), paths=64, duration=1.0, first_passage=wanted)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_it_is_in_every_form_of_the_answer(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    words = "simulate --paths 640 --duration 20 --step 0.05 --start rest --first-passage x 1.2 --first-passage speed 2"
    assert cli.main(words.split()) == 0
    out = capsys.readouterr().out
    assert "mean time" in out
    assert "share not passed" in out
    assert cli.main([*words.split(), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    found = simulate(
        sp.Oscillator(), paths=640, duration=20.0, step=0.05, start="rest", first_passage={"x": 1.2, "speed": 2.0}
    )
    passage, data = found.first_passages["x"], found.to_xarray()
    assert answer["x_first_passage_mean"] == passage.mean_time == float(data["x_first_passage_mean"])
    assert data["x_first_passage_mean"].units == "s"
    assert len(answer["x_first_passage_survival"]) == data["x_first_passage_survival"].size == 101
    again = sp.load_run(found.save(tmp_path / "run.nc"))
    np.testing.assert_array_equal(again.first_passages["x"].times, passage.times)
    assert again.first_passages["x"].mean == passage.mean
    with pytest.raises(ValueError, match="cannot be given with rtol"):
        simulate(sp.Oscillator(), rtol=0.1, first_passage={"x": 1.2})


def test_a_distance_may_be_from_a_reference() -> None:
    own = {"distance": {"level": 1.0, "reference": 0.5}, "same": (lambda t, x, v: abs(x - 0.5), 1.0)}
    found = simulate(oscillator(), paths=64, duration=4.0, step=0.05, start="rest", first_passage=own).first_passages
    passed = np.isfinite(found["distance"].times)
    assert found["distance"].reference == 0.5
    assert passed.any()
    np.testing.assert_allclose(found["distance"].times[passed], found["same"].times[passed], atol=0.05)


def test_several_levels_are_passed_as_each_alone() -> None:
    """In any order and on both sides, to the last bit, for one thread and for three; a list of one is a list."""
    problem = sp.Oscillator(springpot=sp.Springpot(0.5, 0.3), barrier=sp.Barrier(-0.9, 0.8))
    given: dict[str, Any] = {"paths": 150, "duration": 20.0, "step": 0.05, "start": "rest"}
    levels: dict[str, list[Any]] = {
        "x": [1.2, -0.5, (-0.6, 1.1), 0.4, -0.8, 2.0, 0.4], "energy": [1.0, 0.2], "v": [(-1.0, 2.0), 1.5, -1.5, 0.5],
    }  # fmt: skip
    one, other = (
        simulate(problem, **given, first_passage=levels, threads=threads).first_passages for threads in (1, 3)
    )
    for name, own in levels.items():
        assert [each.title for each in one[name]] == [each.title for each in other[name]]
        for number, level in enumerate(own):
            alone = simulate(problem, **given, first_passage={name: level}).first_passages[name]
            np.testing.assert_array_equal(one[name][number].times, alone.times)
            np.testing.assert_array_equal(one[name][number].times, other[name][number].times)
    assert (one["x"][2].title, one["x"].levels[:2]) == ("x out of -0.6 to 1.1 m", (1.2, -0.5))
    assert 0.1 < one["x"][5].share_censored < 0.9
    single = simulate(problem, **given, first_passage={"x": [0.4]}).first_passages["x"]
    assert len(single) == 1


def test_an_interval_is_left_at_the_first_of_its_ends() -> None:
    """Of x and v: the earlier of both passages."""
    given: dict[str, Any] = {"paths": 150, "duration": 20.0, "step": 0.05, "start": "rest"}
    free = sp.Oscillator(springpot=sp.Springpot(0.5, 0.3), barrier=None)
    for name in ("x", "v"):
        found = simulate(free, **given, first_passage={name: [(-1.5, 1.0), -1.5, 1.0]}).first_passages[name]
        left, low, high = (each.times for each in found)
        first = np.minimum(low, high)
        np.testing.assert_array_equal(np.isfinite(left), np.isfinite(first))
        passed = np.isfinite(first)
        np.testing.assert_allclose(left[passed], first[passed], rtol=1e-9)
        assert 0.2 < np.mean(low < high) < 0.8


def test_levels_are_in_every_form_of_the_result(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    words = "simulate --paths 640 --duration 20 --step 0.05 --start rest --first-passage x 1.2 --first-passage x 9"
    assert cli.main(words.split()) == 0
    out = capsys.readouterr().out
    assert "x_first_passage 1.2" in out
    assert "at most 0.00" in out
    assert cli.main([*words.split(), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    found = simulate(
        sp.Oscillator(), paths=640, duration=20.0, step=0.05, start="rest", first_passage={"x": [1.2, 9.0]}
    )
    passages, data = found.first_passages["x"], found.to_xarray()
    assert answer["x_first_passage_level"] == data["x_first_passage_level"].to_numpy().tolist() == [1.2, 9.0]
    assert answer["x_first_passage_rate_high"] == [each.rate.high for each in passages]
    assert answer["x_first_passage_return_period"][1] is None
    assert data["x_first_passage_survival"].dims == ("x_first_passage_level", "x_first_passage_time")
    np.testing.assert_array_equal(data["x_first_passage_survival_low"][1, -1], passages[1].survival_interval(20.0)[0])
    for name in ("run.nc", "run.json", "run.csv"):
        found.save(tmp_path / name)
        if name != "run.csv":
            again = sp.load_run(tmp_path / name).first_passages["x"]
            assert again[0].rate == passages[0].rate
            np.testing.assert_array_equal(again[1].times, passages[1].times)
    assert "x_first_passage_rate,9.0,x_first_passage_level,0.0" in (tmp_path / "run.csv").read_text(encoding="utf-8")
