"""Sweeps, motions of the ground and noise that is not Gaussian, against what they state."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import springpot as sp
from tests.sizes import validation

BAND = sp.SpectralExcitation.from_psd((5.0, 50.0), 0.01, "g2/Hz")


@pytest.mark.parametrize("ends", [(5.0, 80.0), (80.0, 5.0)])
def test_a_sweep_passes_each_frequency_at_its_time(ends: tuple[float, float]) -> None:
    """By its upward passages of 0: one octave in 15 s."""
    made = sp.sweep(2.0, "m/s2", *ends, octaves_per_minute=4.0)
    time, values = (np.array(each) for each in made.records[0])
    assert made.duration == pytest.approx(60.0)
    assert made.on == "ground"
    assert np.abs(values).max() == pytest.approx(2.0, rel=1e-3)
    up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    passed = time[up] - values[up] * np.diff(time)[up] / (values[up + 1] - values[up])
    middle, found = 0.5 * (passed[1:] + passed[:-1]), 1.0 / np.diff(passed)
    sign = math.copysign(1.0, ends[1] - ends[0])
    np.testing.assert_allclose(found, ends[0] * 2.0 ** (sign * middle / 15.0), rtol=0.02)


def test_a_linear_sweep_has_as_many_cycles_as_its_mean_frequency() -> None:
    made = sp.sweep(1.0, "N", 10.0, 30.0, duration=5.0, linear=True, on="box")
    values = np.array(made.records[0][1])
    assert made.on == "box"
    assert ((values[:-1] < 0.0) & (values[1:] >= 0.0)).sum() in (99, 100)


def test_a_slow_sweep_reaches_the_response_to_a_sine() -> None:
    """At a damping ratio of 0.1: 1 / (2 z) times the amplitude, less what the sweep is too fast for."""
    slow = sp.sweep(1.0, "m/s2", 5.0, 20.0, octaves_per_minute=2.0)
    found = sp.response_spectrum(slow, [0.1], damping=0.1, output="pseudo_acceleration")
    z = 0.1
    assert found["pseudo_acceleration"].values[0, 0] == pytest.approx(0.5 / z / math.sqrt(1.0 - z * z), rel=5e-3)


@pytest.mark.parametrize(("of", "factor"), [("displacement", (20.0 * math.pi) ** 2), ("velocity", 20.0 * math.pi)])
def test_the_motion_of_the_ground_is_its_acceleration(of: Any, factor: float) -> None:
    """A burst of a sine at nine points in a period, and of two records each."""
    t = np.arange(400) / 90.0
    burst = np.exp(-((t - 2.2) ** 2) / 0.3)
    values = np.array([burst * np.sin(20.0 * math.pi * t), 2.0 * burst * np.sin(20.0 * math.pi * t)])
    made = np.array(sp.ground_motion(t, values, of).values)
    dense = np.linspace(0.0, t[-1], 400_001)
    exact = np.exp(-((dense - 2.2) ** 2) / 0.3) * np.sin(20.0 * math.pi * dense)
    for _ in range(2 if of == "displacement" else 1):
        exact = np.gradient(exact, dense)
    np.testing.assert_allclose(made[0], np.interp(t, dense, exact), atol=2e-4 * factor)
    np.testing.assert_allclose(made[1], 2.0 * made[0], atol=1e-9 * factor)


def test_a_density_of_a_displacement_is_that_of_the_acceleration() -> None:
    """The rms of a stiff mass is that of the ground's acceleration over the square of its frequency."""
    noise = sp.ground_motion_psd((1.0, 2.0, 8.0), (1e-6, 1e-6, 1e-9))
    for f in (1.3, 5.0):
        flat = sp.SpectralExcitation((1.0, 2.0, 8.0), (1e-6, 1e-6, 1e-9)).one_sided(f)
        assert noise.one_sided(f) == pytest.approx(flat * (2.0 * math.pi * f) ** 4, rel=1e-12)
    speed = sp.ground_motion_psd((1.0, 8.0), (1e-4, 1e-4), "velocity", scale=0.5)
    assert speed.one_sided(2.0) == pytest.approx(0.5e-4 * (4.0 * math.pi) ** 2)


@pytest.mark.parametrize(("kurtosis", "tau"), [validation(3.0, None), (6.0, 1.5)])
def test_records_of_noise_have_its_density_and_the_stated_kurtosis(kurtosis: float, tau: float | None) -> None:
    made = sp.noise_records(BAND, 40.0, 200, kurtosis=kurtosis, correlation_time=tau)
    values = np.array(made.values)
    squares, fourths = (values**2).mean(axis=1), (values**4).mean(axis=1)
    error = squares.std() / math.sqrt(200)
    assert squares.mean() == pytest.approx(BAND.mean_square, abs=3.5 * error)
    fourth = 3.5 * fourths.std() / math.sqrt(200) / BAND.mean_square**2
    assert fourths.mean() / BAND.mean_square**2 == pytest.approx(kurtosis, abs=fourth)
    assert fourth < 0.25 * kurtosis
    # half of the power is in half of the band
    step = made.duration / (values.shape[1] - 1)
    frequency = np.fft.rfftfreq(values.shape[1], step)
    power = (np.abs(np.fft.rfft(values * np.hanning(values.shape[1]), axis=1)) ** 2).mean(axis=0)
    low = power[(frequency > 5.0) & (frequency < 27.5)].sum() / power.sum()
    assert low == pytest.approx(0.5, abs=0.02)
    assert power[frequency > 53.0].sum() < 1e-3 * power.sum()


def test_the_same_seed_makes_the_same_records() -> None:
    one, same, other = (sp.noise_records(BAND, 2.0, 2, seed=seed) for seed in (1, 1, 2))
    assert one == same != other


def test_frequencies_in_hertz_are_those_in_radians() -> None:
    sine = sp.Harmonic.from_hz(0.5, "g", 10.0)
    assert (sine.frequency, sine.on) == (20.0 * math.pi, "ground")
    assert sine.amplitude == pytest.approx(0.5 * 9.80665)
    assert sp.Harmonic.from_hz(3.0, "N", 1.0, on="box").on == "box"
    common = {"damping": 0.6, "base_damping": 0.6}
    assert sp.CloughPenzienNoise.from_rms(
        0.1, "g", frequency_hz=2.0, base_frequency_hz=0.2, **common
    ) == sp.CloughPenzienNoise.from_rms(0.1, "g", frequency=4.0 * math.pi, base_frequency=0.4 * math.pi, **common)
    with pytest.raises(TypeError, match="frequency_hz must be left out where frequency is given"):
        sp.KanaiTajimiNoise.from_rms(0.1, "g", frequency_hz=2.0, frequency=1.0, damping=0.6)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.sweep(1.0, "g", 5.0, 5.0, duration=3.0), "high must not be the frequency from which"),
        (lambda: sp.sweep(1.0, "g", 5.0, 50.0), "duration must be given or octaves_per_minute, and not both"),
        (lambda: sp.sweep(1.0, "g", 5.0, 50.0, octaves_per_minute=1.0, linear=True), "duration must be given for"),
        (lambda: sp.sweep(1.0, "g", 5.0, 2000.0, octaves_per_minute=1.0), "duration takes 8.3e.06 points"),
        (lambda: sp.sweep(1.0, "mm", 5.0, 50.0, duration=1.0), "unit must be 'g'"),  # type: ignore[arg-type]
        (lambda: sp.sweep(1.0, "N", 5.0, 50.0, duration=1.0, on="ground"), "on must be a mass with a sweep in N"),
        (lambda: sp.ground_motion([0.0, 1.0], [0.0, 1.0]), "time must increase at equal steps, 32 points or more"),
        (lambda: sp.ground_motion(np.arange(40.0), np.zeros(39)), "values must have the 40 points of time"),
        (lambda: sp.ground_motion_psd((1.0, 2.0), (1.0,)), "psd must have a density for each of 2 frequencies"),
        (lambda: sp.noise_records(sp.WhiteNoise(1.0), 1.0, 1), "noise must be a SpectralExcitation"),  # type: ignore[arg-type]
        (lambda: sp.noise_records(BAND, 1.0, 0), "count must be a whole number"),
        (lambda: sp.noise_records(BAND, 1.0, 1, kurtosis=5.0), "correlation_time must be given with"),
        (lambda: sp.noise_records(BAND, 1.0, 1, kurtosis=2.0), "kurtosis must be"),
        (lambda: sp.noise_records(BAND, 1.0, 1, kurtosis=4.0, correlation_time=1e-3), "correlation_time must be at"),
    ],
)  # fmt: skip
def test_wrong_arguments_get_one_sentence(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()
