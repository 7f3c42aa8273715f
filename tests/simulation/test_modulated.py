"""Noise with an envelope, and results in bins of time.

The tables are those of the Lyapunov equation P' = A P + P A^T + B B^T e(t)^2, of the exact impulse response, and of an
independent Monte Carlo with a wall.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import springpot as sp
from springpot.simulation.lowering.filters import filtered
from springpot.simulation.lowering.modulated import Modulation, law_of
from springpot.simulation.lowering.sources import Filter
from springpot.simulation.plan.scales import Units
from tests.kernels import PAIR
from tests.sizes import validation

ENVELOPE = sp.ExponentialEnvelope(slow=0.2, fast=0.6)
SHAKEN = sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0, envelope=ENVELOPE)
AWAY = sp.Barrier(-1e3, 0.8)
SINGLE = 3e-7  # a run has sums of four steps in single precision, a profile has all in double
TIMES = [0.0, 2.0, 4.0, 6.0, 10.0, 15.0, 25.0]


def of_pair(*noises: Any, damping: float = 0.3) -> sp.System:
    """An oscillator with these noises beside another mass."""
    ends = {"between": ("ground", "a")}
    return sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(4.0, **ends), sp.Dashpot(damping, **ends),
        sp.Spring(1.0, between=("ground", "b")), *noises,
    )  # fmt: skip


def lyapunov(noise: Any, damping: float, times: list[float], stiffness: float = 4.0) -> np.ndarray:
    """x^2 and v^2 at times, of white noise, or of noise that it drives through one or two filters."""
    match noise:
        case sp.WhiteNoise() | sp.PoissonImpulses() | sp.ParametricNoise():
            rows, out = np.zeros((0, 0)), np.zeros(0)
        case sp.KanaiTajimiNoise(frequency=w, damping=z):
            rows, out = np.array([[0.0, 1.0], [-w * w, -2 * z * w]]), np.array([w * w, 2 * z * w])
        case sp.CloughPenzienNoise(frequency=w, damping=z, base_frequency=f, base_damping=zf):
            first = [0.0, 1.0, 0.0, 0.0], [-w * w, -2 * z * w, 0.0, 0.0]
            rows = np.array([*first, [0.0, 0.0, 0.0, 1.0], [w * w, 2 * z * w, -f * f, -2 * zf * f]])
            out = rows[3]
        case _:
            rows, out = np.array([[-1.0 / noise.correlation_time]]), np.ones(1)
    size = len(out) + 2
    a = np.zeros((size, size))
    a[0, 1], a[1, 0], a[1, 1], a[1, 2:], a[2:, 2:] = 1.0, -stiffness, -damping, out, rows
    push = np.zeros(size)
    push[min(3, size - 1)] = 1.0
    is_colored = isinstance(noise, sp.ColoredNoise)
    q = 2.0 * noise.variance / noise.correlation_time if is_colored else noise.intensity

    def grow(t: float, p: np.ndarray) -> np.ndarray:
        square = p.reshape(size, size)
        if isinstance(noise, sp.KanaiTajimiNoise):  # whose frequency may fall
            own = noise.frequency + noise.frequency_rate * t
            a[1, 2:] = own * own, 2.0 * noise.damping * own
            a[3, 2:] = -a[1, 2:]
        fed = q * float(noise.envelope.at(t)) ** 2 * np.outer(push, push)
        if isinstance(noise, sp.ParametricNoise):  # beside white noise of intensity 1
            fed = fed * square[0, 0] + np.outer(push, push)
        return (a @ square + square @ a.T + fed).ravel()

    found = solve_ivp(grow, (0.0, times[-1]), np.zeros(size**2), t_eval=times, rtol=1e-9, atol=1e-12, max_step=0.1)
    return found.y[[0, size + 1]]


def apart(profile: Any, expected: np.ndarray) -> np.ndarray:
    return np.asarray((profile.value - expected) / profile.standard_error)


def test_white_noise_and_a_springpot_in_twenty_bins_against_the_exact_response() -> None:
    system = sp.System(*SHAKEN, AWAY)
    run = sp.simulate(system, paths=65536, step=0.05, duration=24.0, profile=20)
    assert run.settings.window == (0.0, 24.0)
    fine = np.linspace(0.0, 24.0, 961)
    exact = sp.theory.transient(sp.System(*SHAKEN), fine)
    for name in ("x_mean_square", "v_mean_square"):
        values = getattr(exact, name)
        means = (0.5 * (values[1:] + values[:-1])).reshape(20, -1).mean(axis=1)
        profile = run.profiles[f"{name}_profile"]
        assert profile.edges[[0, -1]].tolist() == [0.0, 24.0]
        assert profile.unit == run[name].unit
        assert np.abs(apart(profile, means)).max() < 3.0
        assert profile.value.mean() == pytest.approx(run[name].value, rel=2e-3)  # sums of the kernel, at other instants
        assert np.median(profile.standard_error / profile.value) < 0.008
    assert np.abs(apart(run.profiles["x_mean_profile"], np.zeros(20))).max() < 3.5
    assert (run.profiles["impact_rate_profile"].value == 0.0).all()
    assert run.profiles["impact_rate_profile"].standard_error[0] == pytest.approx(3.0 / 1.96 / (65536 * 1.2), rel=1e-3)
    # what is fed in, int q e^2 / 2 dt, is lost or left
    residual = run["energy_residual"]
    assert abs(residual.value) < 3.0 * residual.error < 0.015


BAND = sp.SpectralExcitation((0.05, 0.12, 0.6), (1.0, 4.0, 0.5), on="ground", envelope=ENVELOPE)
TWO = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(1.0, between=("ground", "a")),
    sp.Springpot(0.5, 0.3, between=("ground", "a")), sp.Spring(2.0, between=("a", "b")),
    sp.FractionalMaxwell(sp.Springpot(0.5, 0.5), sp.Spring(1.0), between=("a", "b")), BAND,
)  # fmt: skip


def off_the_exact(system: sp.System, paths: int, step: float) -> dict[str, np.ndarray]:
    """Deviations in twenty bins, in standard errors."""
    run = sp.simulate(system, paths=paths, step=step, duration=24.0, profile=20)
    exact, found = sp.theory.transient(system, np.linspace(0.0, 24.0, 481)), {}
    for name, values in exact.numbers.items():
        profile = run.profiles[f"{name}_profile"]
        assert np.median(profile.standard_error / profile.value) < 0.02
        found[name] = apart(profile, (0.5 * (values[1:] + values[:-1])).reshape(20, -1).mean(axis=1))
    return found


@pytest.mark.validation  # every day: filtered noise, above
def test_two_masses_under_a_given_density_with_an_envelope_in_twenty_bins() -> None:
    found = off_the_exact(TWO, 12800, 0.06)
    assert len(found) == 5
    assert max(np.abs(each).max() for each in found.values()) < 3.5  # the largest of 100


@pytest.mark.validation
def test_in_short_steps_and_for_one_mass() -> None:
    for system in (TWO, sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.3), BAND)):
        for name, each in off_the_exact(system, 65536, 0.02).items():
            print(name, each.round(2).tolist())
            assert np.abs(each).max() < 3.0


def test_a_wall_against_an_independent_program() -> None:
    run = sp.simulate(
        sp.System(*SHAKEN, sp.Barrier(0.0, 0.8)), paths=20480, step=0.02, duration=25.0, profile=TIMES, seed=5,
        distributions=True,
    )  # fmt: skip
    rate, power = run.profiles["impact_rate_profile"], run.profiles["impact_power_profile"]
    theirs = np.array([0.3401, 0.3489, 0.3331, 0.3276, 0.3157]), np.array([11, 10, 5, 3, 2]) * 1e-4
    assert (np.abs(rate.value[1:] - theirs[0]) / np.hypot(rate.standard_error[1:], theirs[1])).max() < 3.0
    theirs = np.array([0.01713, 0.0817, 0.1466, 0.1198, 0.0554, 0.01105]), np.array([10, 40, 70, 40, 20, 4]) * 1e-5
    assert (np.abs(power.value - theirs[0]) / np.hypot(power.standard_error, theirs[1])).max() < 3.0
    assert (power.value * np.diff(power.edges)).sum() / 25.0 == pytest.approx(run["barrier_power"].value, rel=SINGLE)
    assert (rate.value * np.diff(rate.edges)).sum() / 25.0 == pytest.approx(run["impact_rate"].value, rel=1e-9)
    largest = run.extremes["x_maximum"]
    for level, theirs_share, error in ((2.0, 0.1968, 0.0013), (3.0, 0.0158, 0.0004)):
        share = (largest > level).mean()
        assert abs(share - theirs_share) < 3.0 * np.hypot(error, np.sqrt(share * (1.0 - share) / largest.size))
    assert abs(largest.mean() - 1.5347) < 3.0 * np.hypot(0.0019, largest.std() / np.sqrt(largest.size))


def test_profiles_at_a_wall_above_are_mirror_images() -> None:
    """Under records, of which there is the opposite, as there is not of drawn noise."""
    times = np.linspace(0.0, 10.0, 200)
    shakes = -3.0 * np.sin(np.multiply.outer((1.0, 1.4), times**1.4) + 1.0)
    runs = [
        sp.simulate(
            sp.System(
                *SHAKEN[:2], sp.RecordedExcitation([tuple(times)] * 2, (sign * shakes).tolist(), on="mass"),
                sp.Barrier(-0.2 * sign, 0.8, free_side=side),
            ),
            paths=2, step=0.05, duration=10.0, window=(0.0, 10.0), start="rest", profile=5, forces=["spring_force"],
        )
        for sign, side in ((1.0, "above"), (-1.0, "below"))
    ]  # fmt: skip
    odd = {"x_mean_profile", "spring_force_mean_profile"}
    assert odd < {*runs[0].profiles}
    speeds = runs[0].profiles["impact_speed_mean_profile"].value
    assert (speeds > 0.0).sum() >= 4
    for name, own in runs[0].profiles.items():
        other, sign = runs[1].profiles[name], -1.0 if name in odd else 1.0
        np.testing.assert_allclose(other.value, sign * own.value, rtol=1e-12, err_msg=name)
        np.testing.assert_allclose(other.standard_error, own.standard_error, rtol=1e-12, err_msg=name)


@pytest.mark.parametrize(
    "noise",
    [
        sp.WhiteNoise(1.0, on="a", envelope=ENVELOPE),
        validation(sp.ColoredNoise(1.0, 0.8, on="a", envelope=ENVELOPE)),
        validation(sp.KanaiTajimiNoise(6.0, 0.4, 1.0, on="a", envelope=sp.JenningsHousnerEnvelope(2.0, 5.0, 0.5))),
        sp.KanaiTajimiNoise(6.0, 0.4, 1.0, on="a", frequency_rate=-0.35, envelope=ENVELOPE),
        sp.PoissonImpulses(2.0, 0.5, on="a", envelope=ENVELOPE),
        sp.ParametricNoise(0.3, between=("ground", "a"), envelope=ENVELOPE),
        sp.CloughPenzienNoise(
            6.0, 0.4, 0.9, 0.5, 1.0, on="a", envelope=sp.TabulatedEnvelope((0.0, 2.0, 6.0, 9.0), (0.0, 1.0, 0.6, 0.0))
        ),
    ],
    ids=lambda noise: type(noise).__name__,
)
def test_filtered_noise_against_the_equation_of_lyapunov(noise: Any) -> None:
    """In long steps: the law of the impulses is that of the driven filter, not of modulated output."""
    beside = [sp.WhiteNoise(1.0, on="a")] if isinstance(noise, sp.ParametricNoise) else []
    system = of_pair(noise, *beside)
    run = sp.simulate(system, paths=40960, step=0.05, duration=12.0, profile=[0.0, 3.0, 6.0, 9.0, 12.0])
    fine = np.linspace(0.0, 12.0, 481)
    exact = lyapunov(noise, 0.3, [*fine])
    for name, values in zip(("x", "v"), exact, strict=True):
        means = (0.5 * (values[1:] + values[:-1])).reshape(4, -1).mean(axis=1)
        assert np.abs(apart(run.profiles[f"a_{name}_mean_square_profile"], means)).max() < 3.5
    assert run.profiles["b_x_mean_square_profile"].value.max() == 0.0


def test_an_envelope_of_1_is_stationary_noise() -> None:
    """The recursion goes to the law of the innovations that stationary noise has."""
    step, steps = 0.3, 400
    noise = Modulation("", None, filter=Filter(np.array([[-0.2]]), np.array([[0.4]]), np.ones(1)))
    law = law_of(noise, Units(1.0, 1.0), step, steps)
    stationary = filtered([noise.filter], step)
    assert law.roots[-1] == pytest.approx(stationary.newest[0], rel=1e-12)
    assert law.roots[0] ** 2 > law.roots[-1] ** 2  # nothing is known at first
    assert law.seen @ law.gains[-1] == pytest.approx(stationary.newest[1], rel=1e-12)


def test_stationary_clough_penzien_noise() -> None:
    noise = sp.CloughPenzienNoise(4.0, 0.4, 0.8, 0.5, 1.0, on="a")
    run = sp.simulate(of_pair(noise), paths=8192, step=0.1, duration=60.0)
    exact = sp.theory.linear(sp.System(sp.Spring(4.0), sp.Dashpot(0.3), sp.CloughPenzienNoise(4.0, 0.4, 0.8, 0.5, 1.0)))
    for name in ("x_mean_square", "v_mean_square"):
        own = run[f"a_{name}"]
        assert abs(own.value / getattr(exact, name) - 1.0) < 3.0 * own.error / own.value + 0.004 < 0.02


def test_a_run_with_an_envelope_is_that_of_the_whole_envelope() -> None:
    system = sp.System(sp.Mass(1.0, at="a"), *PAIR.parts[1:-1], sp.WhiteNoise(1.0, on="a", envelope=ENVELOPE))
    run = sp.simulate(system, paths=64)
    assert run.settings.duration == pytest.approx(ENVELOPE.duration, abs=0.5)
    assert run.settings.window[0] == 0.0
    with pytest.raises(sp.theory.NoStationaryStateError, match="there is none: an envelope has a beginning"):
        sp.simulate(system, rtol=0.1)
    with pytest.raises(sp.theory.NotCoveredError, match="not the envelope of"):
        sp.theory.linear(system)


def test_profiles_do_not_depend_on_threads_and_go_to_files(tmp_path: Any) -> None:
    system = of_pair(sp.WhiteNoise(1.0, on="a"))
    one, two = (
        sp.simulate(system, paths=1000, duration=6.0, step=0.02, profile=[1.0, 2.0, 5.0], start="rest", threads=threads)
        for threads in (1, 2)
    )
    name = "a_x_mean_square_profile"
    assert (one.profiles[name].value == two.profiles[name].value).all()
    again = sp.load_run(one.save(tmp_path / "run.nc"))
    assert (again.profiles[name].standard_error == one.profiles[name].standard_error).all()
    dataset = one.to_xarray()
    assert dataset[name].dims == ("time_bin",)
    assert dataset["time_bin_width"].values.tolist() == pytest.approx([1.04, 2.96])
    with pytest.raises(ValueError, match="but it has profiles"):
        sp.extend(one, paths=2000)


def test_the_bins_of_a_profile_are_those_of_the_recorded_paths() -> None:
    system = of_pair(sp.WhiteNoise(1.0, on="a"))
    run = sp.simulate(
        system, paths=300, duration=4.0, step=0.05, record=300, window=(0.5, 3.9), profile=[1.0, 2.0, 3.9]
    )
    x = run.record[:, :, 0, 0]
    edges = np.rint(run.profiles["a_x_mean_profile"].edges / 0.05).astype(int)
    for n, (low, high) in enumerate(itertools.pairwise(edges)):
        own = np.trapezoid(x[:, low : high + 1] ** 2, axis=1) / (high - low)
        profile = run.profiles["a_x_mean_square_profile"]
        assert profile.value[n] == pytest.approx(own.mean(), rel=1e-5)
        assert profile.standard_error[n] == pytest.approx(own.std(ddof=1) / np.sqrt(300), rel=1e-5)


@pytest.mark.parametrize(
    ("profile", "sentence"),
    [
        (0, "profile must be in"), (2.5, "a whole number of bins"), ("all", "a number of bins, or times"),
        ([1.0], "two or more times"), ([0.0, 2.0, 1.0], "two or more times that increase"),
        ([0.0, 99.0], "must lie in the window from .* window may begin earlier"), (100, "shorter than 4 steps"),
        ([0.0, 0.5, 0.51], "shorter than 4 steps"),
    ],
)  # fmt: skip
def test_wrong_bins_are_refused(profile: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        sp.simulate(
            of_pair(sp.WhiteNoise(1.0, on="a")), paths=64, duration=4.0, step=0.02, start="rest", profile=profile
        )


@pytest.mark.validation
@pytest.mark.parametrize(
    "noise",
    [
        sp.KanaiTajimiNoise(6.0, 0.4, 1.0, on="mass", frequency_rate=-0.35, envelope=ENVELOPE),
        sp.PoissonImpulses(2.0, 0.5, envelope=ENVELOPE), sp.ParametricNoise(0.3, envelope=ENVELOPE),
    ],
    ids=lambda noise: type(noise).__name__,
)  # fmt: skip
def test_the_kernel_of_one_mass_against_the_equation_of_lyapunov(noise: Any) -> None:
    beside = [sp.WhiteNoise(1.0)] if isinstance(noise, sp.ParametricNoise) else []
    system = sp.System(sp.Spring(4.0), sp.Dashpot(0.3), noise, *beside)
    run = sp.simulate(system, paths=40960, step=0.05, duration=12.0, profile=[0.0, 3.0, 6.0, 9.0, 12.0])
    exact = lyapunov(noise, 0.3, [*np.linspace(0.0, 12.0, 481)])
    for name, values in zip(("x", "v"), exact, strict=True):
        means = (0.5 * (values[1:] + values[:-1])).reshape(4, -1).mean(axis=1)
        assert np.abs(apart(run.profiles[f"{name}_mean_square_profile"], means)).max() < 3.5
    residual = run["energy_residual"] if beside else None
    assert residual is None or abs(residual.value) < 3.0 * residual.error < 0.05


def test_a_frequency_that_changes_needs_an_end() -> None:
    with pytest.raises(ValueError, match="frequency_rate needs an envelope"):
        sp.KanaiTajimiNoise(6.0, 0.4, 1.0, frequency_rate=-0.2)
    falling = sp.KanaiTajimiNoise(6.0, 0.4, 1.0, on="a", frequency_rate=-1.0, envelope=ENVELOPE)
    with pytest.raises(ValueError, match=r"takes its frequency to 0 at 6 s: end the run before"):
        sp.simulate(of_pair(falling), paths=1, step=0.05, duration=12.0)


def whole(run: sp.Run, name: str) -> float:
    """The mean of a profile over the whole window."""
    profile = run.profiles[f"{name}_profile"]
    return float((profile.value * np.diff(profile.edges)).sum() / (profile.edges[-1] - profile.edges[0]))


def test_powers_and_speeds_in_bins_are_those_of_the_run() -> None:
    system = sp.System(*of_pair(sp.ColoredNoise(1.0, 0.5, on="a", envelope=ENVELOPE), sp.WhiteNoise(0.2, on="a")).parts,
                       stop=sp.Barrier(-0.3, 0.8, between=("ground", "a")))  # fmt: skip
    run = sp.simulate(system, paths=2048, duration=12.0, step=0.05, start="rest", profile=[0.0, 3.0, 5.0, 12.0])
    assert whole(run, "damping_power") == pytest.approx(run["damping_power"].value, rel=1e-5)
    assert whole(run, "stop_impact_power") == pytest.approx(run["stop_power"].value, rel=SINGLE)
    # of the white noise the expected power
    fed = run["input_power"]
    assert abs(whole(run, "input_power") - fed.value) < 4.0 * fed.error
    assert whole(run, "input_power") == pytest.approx(run["colored_noise_power"].value + 0.1, rel=1e-5)
    rate, speed = (run.profiles[f"stop_impact_{name}_profile"] for name in ("rate", "speed_mean"))
    counts = rate.value * np.diff(rate.edges)
    assert (counts @ speed.value) / counts.sum() == pytest.approx(run["stop_impact_speed_mean"].value, rel=SINGLE)
    assert 0.5 < speed.standard_error[-1] / run["stop_impact_speed_mean"].error < 3.0
    alone = sp.simulate(system, paths=2048, duration=12.0, step=0.05, start="rest", profile=[0.0, 12.0])
    own = alone.profiles["stop_impact_speed_mean_profile"], alone.profiles["damping_power_profile"]
    for profile, name in zip(own, ("stop_impact_speed_mean", "damping_power"), strict=True):
        assert profile.standard_error[0] == pytest.approx(alone[name].error, rel=2e-3)


@pytest.mark.parametrize("several", [False, True])
def test_impacts_that_are_not_slow_in_bins(several: bool) -> None:
    """Together they are those of the run, and without a least speed all impacts."""
    given: dict[str, Any] = {"paths": 64, "step": 0.05, "duration": 12.0}
    noise = sp.WhiteNoise(4.0, on="a" if several else "mass", envelope=ENVELOPE)
    parts = of_pair(noise).parts if several else (sp.Spring(1.0), sp.Dashpot(0.3), noise)
    system = sp.System(*parts, gap=sp.Barrier(-0.1, 0.8, **{"between": ("a", "b")} if several else {}))
    of = "gap_" * several
    for slowest in (0.0, 0.8):
        run = sp.simulate(system, **given, profile=[0.0, 3.0, 5.0, 12.0], slowest_counted_impact=slowest)
        rate, speed = (run.profiles[f"{of}counted_impact_{what}_profile"] for what in ("rate", "speed_mean"))
        number = rate.value * np.diff(rate.edges)
        assert number.sum() / 12.0 == pytest.approx(run["counted_impact_rate"].value, rel=1e-9)
        mean = (number * speed.value).sum() / number.sum()
        assert mean == pytest.approx(run["counted_impact_speed_mean"].value, rel=1e-9)
        assert (speed.value > slowest).all()
        every = run.profiles[f"{of}impact_rate_profile"]
        assert (rate.value < every.value).all() if slowest else np.array_equal(rate.value, every.value)


@pytest.mark.validation
def test_powers_in_bins_of_one_mass() -> None:
    """What white noise with an envelope feeds in is lost or left in each bin."""
    run = sp.simulate(
        sp.System(sp.Mass(2.0), sp.Spring(2.0), sp.Springpot(0.5, 0.6), sp.WhiteNoise(4.0, envelope=ENVELOPE),
                  sp.Barrier(0.0, 0.8)),
        paths=16384, step=0.02, duration=25.0, profile=TIMES,
    )  # fmt: skip
    fed, lost, taken = (run.profiles[f"{name}_power_profile"] for name in ("input", "damping", "impact"))
    fine = np.linspace(0.0, 25.0, 25001)
    for n, (low, high) in enumerate(itertools.pairwise(fed.edges)):
        inside = (fine >= low) & (fine <= high)
        assert fed.value[n] == pytest.approx((ENVELOPE.at(fine[inside]) ** 2).mean(), rel=2e-3)  # q / (2 m)
    assert (fed.standard_error == 0.0).all()
    assert whole(run, "damping_power") == pytest.approx(run["damping_power"].value, rel=1e-5)
    assert whole(run, "impact_power") == pytest.approx(run["barrier_power"].value, rel=SINGLE)
    left = (whole(run, "input_power") - whole(run, "damping_power") - whole(run, "impact_power")) * 25.0
    energy = 0.5 * 2.0 * (run["x_mean_square_end"].value + run["v_mean_square_end"].value)
    error = 25.0 * np.hypot(run["damping_power"].error, run["barrier_power"].error)
    assert abs(left - energy) < 4.0 * error < 0.4
    assert (lost.value + taken.value)[-1] > fed.value[-1]  # the noise is over


IN_TIME = {
    "wall": (
        (sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.Barrier(0.0, 0.8)),
        {"x": ((0.4095, 0.7394, 0.7954, 0.6237, 0.3757, 0.1146), (10, 18, 19, 16, 9, 3)),
         "x^2": ((0.2716, 0.8827, 1.0124, 0.6182, 0.2240, 0.02083), (13, 40, 44, 27, 10, 0.9)),
         "v^2": ((0.4702, 0.9880, 1.0629, 0.6780, 0.2359, 0.02042), (21, 42, 50, 30, 12, 0.9))},
    ),
    "Duffing": (
        (sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 0.5)), sp.Dashpot(0.3)),
        {"x^2": ((0.2534, 0.5607, 0.5986, 0.3832, 0.1379, 0.01000), (17, 35, 31, 22, 9, 0.6)),
         "v^2": ((0.4307, 1.0196, 1.0634, 0.5517, 0.1615, 0.01017), (31, 64, 68, 43, 12, 0.8))},
    ),
    "dashpot": (
        (sp.Spring(1.0), sp.Dashpot(0.3)),
        {"x^2": ((0.26371, 0.97190, 1.03921, 0.60221, 0.18627, 0.012009), (0,) * 6),
         "v^2": ((0.45841, 0.87978, 0.98970, 0.57838, 0.18671, 0.011971), (0,) * 6)},
    ),
}  # fmt: skip
"""Of other programs, at times: values, and their standard errors in units of 1e-4."""


@pytest.mark.validation
@pytest.mark.parametrize("case", IN_TIME)
def test_moments_at_times_against_other_programs(case: str) -> None:
    parts, table = IN_TIME[case]
    system = sp.System(*parts, sp.WhiteNoise(1.0, envelope=ENVELOPE))
    run = sp.simulate(system, paths=40960, step=0.01, duration=25.0, record=40960, record_every=100, seed=3)
    at = [int(np.abs(run.time - time).argmin()) for time in TIMES[1:]]
    x, v = run.record[:, at, 0], run.record[:, at, 1]
    for name, (values, errors) in table.items():
        own = {"x": x, "x^2": x**2, "v^2": v**2}[name]
        spread = np.hypot(own.std(axis=0) / np.sqrt(len(own)), 1e-4 * np.array(errors))
        off = (own.mean(axis=0) - values) / spread
        print(case, name, off.round(2).tolist())
        assert np.abs(off).max() < 3.0


@pytest.mark.validation
def test_a_wall_in_twenty_bins_against_a_fine_run() -> None:
    """A density that an envelope multiplies, and a soft ground that falls, with a wall at a distance."""
    noises = BAND, sp.KanaiTajimiNoise(6.0, 0.4, 1.0, frequency_rate=-0.2, envelope=ENVELOPE)
    for noise in noises:
        system = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.3), noise, sp.Barrier(-0.3, 0.8))
        coarse, fine = (
            sp.simulate(system, paths=20480, step=step, duration=24.0, profile=20, seed=seed)
            for step, seed in ((0.03, 4), (0.005, 5))
        )
        for name in ("x_mean", "x_mean_square", "v_mean_square", "damping_power", "impact_power"):
            one, other = (run.profiles[f"{name}_profile"] for run in (coarse, fine))
            off = (one.value - other.value) / np.hypot(one.standard_error, other.standard_error)
            print(noise.said, name, off.round(2).tolist())
            assert np.abs(off).max() < 3.5  # the largest of 200
