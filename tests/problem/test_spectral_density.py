"""From a device to the oscillator: the conversion is held against records that scipy makes and filters."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from springpot import Barrier, Dimensionless, Oscillator, Springpot, WhiteNoise, cli, theory
from springpot.problem.spectral_density import STANDARD_GRAVITY, intensity_from_psd, psd_from_intensity
from tests.sizes import validation

RATE = 1000.0  # samples per second
SAMPLES = 2**22
DEVICE: dict[str, Any] = {
    "mass": 0.4, "stiffness": 0.4 * (2.0 * math.pi * 20.0) ** 2, "springpot": (1.0, 0.4 * 25.0),
}  # fmt: skip


def record(one_sided: float, seed: int = 7) -> Any:
    """White noise of this one-sided density per Hz, between 0 and half the sampling rate."""
    return np.random.default_rng(seed).normal(scale=math.sqrt(one_sided * RATE / 2.0), size=SAMPLES)


def response(per_mass: Any, mass: float, stiffness: float, springpot: tuple[float, float]) -> Any:
    """Displacement of the device with a dashpot and no stop, by scipy's exact filter of a sampled-and-held input."""
    system = ([1.0 / mass], [1.0, springpot[1] / mass, stiffness / mass])
    top, bottom, _ = scipy.signal.cont2discrete(system, 1.0 / RATE, method="zoh")
    return scipy.signal.lfilter(top.ravel(), bottom, mass * per_mass)


def welch(samples: Any) -> tuple[float, float]:
    """Mean one-sided density of a flat record as Welch estimates it, and a bound on its standard error."""
    _, density = scipy.signal.welch(samples, fs=RATE, nperseg=4096)
    return float(np.mean(density[2:-2])), float(np.mean(density) * math.sqrt(2.0 / SAMPLES))


@pytest.mark.parametrize(
    ("given_as", "in_si"),
    [
        ({"psd": 0.02, "psd_unit": "g2/Hz"}, 0.02 * 9.80665**2),
        validation({"psd": 0.01, "psd_unit": "g2/Hz", "sides": 2}, 0.02 * 9.80665**2),
        validation({"psd": 3.0, "psd_unit": "m2/s4/Hz", "of": "base"}, 3.0),
        ({"psd": 0.5, "psd_unit": "N2/Hz", "of": "force"}, 0.5 / 0.4**2),
    ],
)
def test_a_shaken_device_moves_as_a_filtered_record_does(given_as: dict[str, Any], in_si: float) -> None:
    """A record whose Welch density is the one given, through m x'' + c x' + k x, has the predicted mean square."""
    acceleration = record(in_si)
    density, error = welch(acceleration)
    assert abs(density - in_si) < 4.0 * error < 0.01 * in_si
    moved = response(-acceleration, **DEVICE)[2000:]
    oscillator = Oscillator.from_device(**DEVICE, **given_as)
    pieces = np.mean(np.square(moved[: len(moved) // 64 * 64].reshape(64, -1)), axis=1)
    measured, standard_error = pieces.mean(), pieces.std(ddof=1) / 8.0
    predicted = theory.exact(oscillator).x_mean_square
    held = 1.0 - (oscillator.natural_frequency / RATE) ** 2 / 12.0  # what holding the samples takes at resonance
    assert standard_error < 0.005 * measured
    assert abs(measured - predicted * held) < 4.0 * standard_error


def test_miles_equation() -> None:
    """Random vibration's rule of thumb, sqrt(pi/2 f Q G), is exact for the spring's force per unit mass."""
    oscillator = Oscillator.from_device(**DEVICE, psd=0.02, psd_unit="g2/Hz")
    frequency, quality = 20.0, 2.0 * math.pi * 20.0 / 25.0
    in_g = math.sqrt(theory.exact(oscillator).x_mean_square) * oscillator.natural_frequency**2 / STANDARD_GRAVITY
    assert in_g == pytest.approx(math.sqrt(math.pi / 2.0 * frequency * quality * 0.02), rel=1e-9)


def test_the_factors_one_by_one() -> None:
    assert STANDARD_GRAVITY == 9.80665
    assert intensity_from_psd(2.0, "m2/s4/Hz") == 1.0
    assert intensity_from_psd(2.0, "m2/s4/Hz", sides=2) == 2.0
    assert intensity_from_psd(2.0, "g2/Hz") == pytest.approx(9.80665**2)
    assert intensity_from_psd(2.0, "N2/Hz", mass=0.5) == 4.0
    # two-sided per rad/s: q / (2 pi), so that the integral over all angular frequencies is that over all frequencies
    per_radian = WhiteNoise(3.0).intensity / (2.0 * math.pi)
    assert intensity_from_psd(2.0 * math.pi * per_radian, "m2/s4/Hz", sides=2) == pytest.approx(3.0)


@given(
    psd=st.floats(1e-12, 1e12),
    unit=st.sampled_from(["g2/Hz", "m2/s4/Hz", "N2/Hz"]),
    sides=st.sampled_from([1, 2]),
    mass=st.floats(1e-6, 1e6),
)
def test_there_and_back(psd: float, unit: Any, sides: Any, mass: float) -> None:
    there = intensity_from_psd(psd, unit, sides=sides, mass=mass)
    assert psd_from_intensity(there, unit, sides=sides, mass=mass) == pytest.approx(psd, rel=1e-12)


def test_what_a_device_becomes() -> None:
    device = Oscillator.from_device(
        mass=2.0, stiffness=18.0, springpot=(0.5, 1.0), gap=0.01, restitution=0.7, psd=4.0, psd_unit="N2/Hz"
    )
    assert Dimensionless.of(device) == Dimensionless(3.0, Springpot(0.5, 0.5), Barrier(-0.01, 0.7), WhiteNoise(0.5))


@pytest.mark.parametrize(
    ("wall", "barrier", "dimensionless"),
    [
        ({"gap": 0.01}, Barrier(-0.01), -1.0),
        ({"gap": 0.01, "free_side": "below"}, Barrier(0.01, free_side="below"), -1.0),
        ({"gap": -0.01}, Barrier(0.01, free_side="above"), 1.0),
        ({"gap": 0.0}, Barrier(0.0), 0.0),
        ({}, None, None),
        ({"gap": None}, None, None),
    ],
)
def test_a_gap_is_the_way_to_the_stop(
    wall: dict[str, Any], barrier: Barrier | None, dimensionless: float | None
) -> None:
    """On either side a positive gap leaves the equilibrium free, and a negative one is a preload."""
    device = Dimensionless.of(
        Oscillator.from_device(mass=1.0, stiffness=1.0, springpot=(0.5, 1.0), psd=2e-4, psd_unit="m2/s4/Hz", **wall)
    )
    assert device.barrier == barrier
    if device.barrier is not None and dimensionless is not None:
        assert math.copysign(1.0, device.barrier.position) == math.copysign(1.0, barrier.position)  # type: ignore[union-attr]
        assert device.dimensionless_position == pytest.approx(dimensionless)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"mass": 0.0}, "mass must be in (0, 1e+50], not 0. It is in kg."),
        ({"mass": "1"}, "mass must be a real number, not '1' (str). It is in kg."),
        ({"stiffness": -1.0}, "stiffness must be in (0, 1e+50], not -1. It is in N/m."),
        ({"springpot": 0.5}, "springpot must be two numbers, (order, k_alpha), not 0.5."),
        ({"springpot": (1.5, 1.0)}, "springpot's order must be in [0, 1], not 1.5."),
        ({"springpot": (0.5, -1.0)}, "springpot's k_alpha must be in [0, 1e+50], not -1."),
        ({"psd": -1.0}, "psd must be in [0, 1e+50], not -1."),
        ({"psd_unit": "g^2/Hz"}, "psd_unit must be 'g2/Hz' or 'm2/s4/Hz' or 'N2/Hz', not 'g^2/Hz'."),
        ({"sides": 3}, "sides must be 1 or 2, not 3."),
        ({"sides": True}, "sides must be 1 or 2, not True."),
        ({"of": "wall"}, "of must be 'base' or 'force', not 'wall'."),
        ({"of": "force"}, "of='force' needs psd_unit='N2/Hz', not 'g2/Hz'."),
        ({"of": "base", "psd_unit": "N2/Hz"}, "of='base' needs psd_unit='g2/Hz' or psd_unit='m2/s4/Hz', not 'N2/Hz'."),
        ({"gap": math.nan}, "gap must be in [-1e+50, 1e+50], not nan."),
        ({"gap": 0.1, "restitution": -0.1}, "restitution must be in [0, 1], not -0.1."),
        ({"restitution": 0.5}, "gap must be given with restitution or free_side: without a gap there is no wall."),
        ({"free_side": "below"}, "gap must be given with restitution or free_side: without a gap there is no wall."),
        ({"gap": 0.1, "free_side": "left"}, "free_side must be 'above' (the mass moves at x >= position) or 'below'"),
    ],
)
def test_what_a_device_cannot_be(changed: dict[str, Any], sentence: str) -> None:
    right = {"mass": 1.0, "stiffness": 1.0, "springpot": (0.5, 1.0), "psd": 1.0, "psd_unit": "g2/Hz"}
    with pytest.raises((TypeError, ValueError)) as refused:
        Oscillator.from_device(**(right | changed))
    assert str(refused.value).startswith(sentence)


def test_a_density_of_force_needs_the_mass() -> None:
    with pytest.raises(ValueError, match=r"^mass must be given with psd_unit='N2/Hz'"):
        intensity_from_psd(1.0, "N2/Hz")


# --- on the command line ----------------------------------------------------------------------------------------------

WORDS = "--mass 2 --stiffness 18 --springpot 0.5 1 --psd 4 --psd-unit N2/Hz"


@pytest.mark.parametrize("command", ["theory", "atlas"])
def test_a_device_on_the_command_line(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([command, *f"{WORDS} --gap 0 --restitution 0.8 --free-side below --json".split()]) == 0
    asked = json.loads(capsys.readouterr().out)["system"]
    device = Oscillator.from_device(
        mass=2.0, stiffness=18.0, springpot=(0.5, 1.0), psd=4.0, psd_unit="N2/Hz", gap=0.0, restitution=0.8,
        free_side="below",
    )  # fmt: skip
    assert asked == device.to_dict()


def test_a_device_simulated_and_compared(capsys: pytest.CaptureFixture[str]) -> None:
    words = [*WORDS.replace("0.5", "1").split(), "--sides", "2", "--of", "force"]
    assert cli.main(["simulate", *words, "--paths", "100", "--duration", "2", "--json"]) == 0
    asked = {part["kind"]: part for part in json.loads(capsys.readouterr().out)["system"]["parts"]}
    assert "barrier" not in asked
    assert asked["white_noise"]["intensity"] == 4.0  # N^2 s
    assert cli.main(["compare", *words, "--rtol", "0.1", "--json"]) == 0


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            "--mass 2 --psd 1 --order 0.5",
            "Either a device (--mass and --psd) or an oscillator per unit mass (--order) can be given, not both.",
        ),
        (
            f"{WORDS} --natural-frequency 1 --position 0",
            "Either a device (--mass, --stiffness, --springpot, --psd and --psd-unit) or an oscillator per unit mass "
            "(--natural-frequency and --position) can be given, not both.",
        ),
        (
            "--mass 2 --stiffness 18 --springpot 0.5 1",
            "--psd and --psd-unit must be given too: a device needs --mass, --stiffness, --springpot, --psd and "
            "--psd-unit.",
        ),
        (f"{WORDS} --gap 1 --no-barrier", "--no-barrier cannot be combined with --gap: there is no wall."),
        (
            f"{WORDS} --restitution 0.5",
            "--gap must be given with restitution or --free-side: without a gap there is no wall.",
        ),
        (f"{WORDS} --of base", "--of base needs --psd-unit g2/Hz or --psd-unit m2/s4/Hz, not 'N2/Hz'."),
        (f"{WORDS} --sides 3", "--sides must be 1 or 2, not '3'."),
        (WORDS.replace("N2/Hz", "N^2/Hz"), "--psd-unit must be 'g2/Hz', 'm2/s4/Hz' or 'N2/Hz', not 'N^2/Hz'."),
        (WORDS.replace("0.5 1", "0.5"), "--springpot needs two numbers, ORDER and K_ALPHA."),
        (
            WORDS.replace("0.5 1", "0.5 1 3"),
            "'3' is one word too many: --springpot takes two numbers, ORDER and K_ALPHA.",
        ),
        (WORDS.replace("0.5 1", "0.5 x"), "--springpot must be two numbers, ORDER and K_ALPHA, not 'x'."),
        (WORDS.replace("mass 2", "mass -2"), "--mass must be in (0, 1e+50], not -2. It is in kg."),
    ],
)
def test_a_device_refused_on_the_command_line(words: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["theory", *words.split()]) == 2
    assert capsys.readouterr() == ("", f"springpot: {sentence}\n")


def test_help_shows_the_defaults_of_an_oscillator(capsys: pytest.CaptureFixture[str]) -> None:
    """They are shown as text, since a flag that was not given is None."""
    assert cli.main(["theory", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    default = Dimensionless.of(Oscillator())
    assert default.barrier is not None
    shown = {
        "order": default.springpot.order, "coefficient": default.springpot.coefficient,
        "natural-frequency": default.natural_frequency, "intensity": default.excitation.intensity,
        "position": default.barrier.position, "restitution": default.barrier.restitution, "free-side": "that of x = 0",
    }  # fmt: skip
    for name, value in shown.items():
        entries = [after.partition(" --")[0] for after in text.split(f" --{name} ")[1:]]
        assert any(f"[default: {value}]" in entry for entry in entries), name
