"""Wrong inputs of a test specification, at every door: one sentence each, that says what would be right."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import springpot as sp
from springpot import cli
from springpot.problem.numbers import with_numbers

SPECTRAL = sp.SpectralExcitation
DEVICE = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), shake=SPECTRAL((0.05, 1.0), (1.0, 1.0)))


def in_a_file(**numbers: Any) -> sp.System:
    """A system file, as its content."""
    return sp.read_system({"parts": [{"kind": "spring", "stiffness": 80.0}, numbers]})


def simulated(**given: Any) -> sp.Run:
    """A run that must not begin."""
    return sp.simulate(DEVICE, paths=1, duration=1.0, start="rest", **given)


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "unsorted table": (
        lambda: SPECTRAL.from_psd((10, 500, 40), (1, 2, 3), "g2/Hz"),
        "frequency must increase from each point to the next, but 40 Hz follows 500 Hz.",
    ),
    "band upside down": (
        lambda: SPECTRAL.from_psd((2000, 10), 0.02, "g2/Hz"),
        "frequency must increase from each point to the next, but 10 Hz follows 2000 Hz.",
    ),
    "zero density": (
        lambda: SPECTRAL.from_psd((10, 40), (0.02, 0.0), "g2/Hz"),
        "psd[1] must be in (0, 1e+50], not 0. It is a density, not a level in dB, which is 10 log10 of it.",
    ),
    "dB for linear": (
        lambda: SPECTRAL.from_psd((10, 40), (-13.0, -10.0), "g2/Hz"),
        "psd[0] must be in (0, 1e+50], not -13. It is a density, not a level in dB, which is 10 log10 of it.",
    ),
    "g2/Hz with a force": (
        lambda: SPECTRAL.from_psd((10, 40), 0.02, "g2/Hz", on="box"),
        "on must be left out with a density in g2/Hz, which is that of the ground.",
    ),
    "rms of a force on the ground": (
        lambda: sp.KanaiTajimiNoise.from_rms(3.0, "N", frequency=1.0, damping=0.5, on="ground"),
        "on must be a mass with an rms in N, which is that of a force.",
    ),
    "rms and intensity": (
        lambda: sp.KanaiTajimiNoise.from_rms(0.1, "g", frequency=1.0, damping=0.5, intensity=1.0),
        "intensity must be left out: rms takes its place.",
    ),
    "rms in another unit": (
        lambda: sp.KanaiTajimiNoise.from_rms(0.1, "cm/s2", frequency=1.0, damping=0.5),  # type: ignore[arg-type]
        "unit must be one of g, m/s2, N, not 'cm/s2'",
    ),
    "units unknown": (
        lambda: SPECTRAL.from_psd((10, 40), 0.02, "g/rtHz"),  # type: ignore[arg-type]
        "psd_unit must be 'g2/Hz' or 'm2/s4/Hz' or 'N2/Hz', not 'g/rtHz'",
    ),
    "slopes and points do not fit": (
        lambda: SPECTRAL.from_slopes((20, 80, 350, 2000), (3, -3), 0.04, "g2/Hz", at=100),
        "slopes must be one for each piece between two frequencies",
    ),
    "unit left out in a file": (
        lambda: in_a_file(kind="spectral_excitation", frequency=[10, 40], slopes=[3.0], psd=0.02, at=20.0),
        "parts[1] (spectral_excitation) needs psd_unit.",
    ),
    "table's path without a place": (
        lambda: in_a_file(kind="spectral_excitation", path="profile.csv"),
        "parts[1] (spectral_excitation).path is read from a system's file only: give the points themselves.",
    ),
    "negative count": (
        lambda: sp.Springpot(0.3, 150.0, count=-4),
        "count must be a whole number from 1 to 1000, not -4.",
    ),
    "count of half a part in a file": (
        lambda: in_a_file(kind="dashpot", coefficient=1.0, count=2.5),
        "parts[1] (dashpot).count must be a whole number from 1 to 1000, not 2.5.",
    ),
    "negative inductance": (
        lambda: sp.ResonantCircuit(0.6, 0.3, 0.8, -1.25),
        "inductance must be in (0, 1e+50], not -1.25. It is L in henry.",
    ),
    "empty record": (
        lambda: sp.RecordedExcitation((), ()),
        "time and values must have the same number of points, two or more, not 0 and 0.",
    ),
    "envelope negative": (
        lambda: sp.WhiteNoise(1.0, envelope=sp.TabulatedEnvelope((0.0, 1.0), (1.0, -0.5))),
        "values must not be below 0, and one of them must be above.",
    ),
    "envelope decays the wrong way": (
        lambda: sp.WhiteNoise(1.0, envelope=sp.JenningsHousnerEnvelope(4.0, 2.0, 0.5)),
        "fall must not be before rise, 4 s, but it is 2 s.",
    ),
    "envelope of a number": (
        lambda: sp.WhiteNoise(1.0, envelope=2.0),  # type: ignore[arg-type]
        "envelope must be an envelope, such as ExponentialEnvelope(slow=0.2, fast=0.6), not 2.0.",
    ),
    "profile bins not increasing": (
        lambda: simulated(profile=[0.0, 0.5, 0.2]),
        "profile must be two or more times that increase, or a number of bins.",
    ),
    "a force of no part": (
        lambda: simulated(forces=["sprng_force"]),
        "forces has 'sprng_force', which is no force or acceleration; did you mean spring_force?",
    ),
    "the impulse of a wall whose impacts cannot be counted": (
        lambda: sp.simulate(sp.System(*DEVICE.parts, stop=sp.Barrier(-1.0, 0.6)), paths=1, forces=["stop_impuls"]),
        "which is no force or acceleration; did you mean stop_impulse?",
    ),
    "forces as True": (
        lambda: simulated(forces=True),
        "not True: spring_force, dashpot_force, force_on_ground",
    ),
    "forces as one word": (
        lambda: simulated(forces="spring_force"),
        "forces must be a list of names of forces and accelerations, not 'spring_force': ",
    ),
    "force of one of a part that is alone": (
        lambda: simulated(forces=["spring_force_of_one"]),
        "forces has 'spring_force_of_one', which is no force or acceleration",
    ),
    "overall rms below zero on an axis": (
        lambda: with_numbers(DEVICE, {"parts.shake.rms": -2.0}),
        "shake.rms must be in (0, 1e+50], not -2. It is the root mean square.",
    ),
    "level and scale on two axes": (
        lambda: with_numbers(DEVICE, {"parts.shake.level": 3.0, "parts.shake.scale": 2.0}),
        "shake.level and another of its numbers both say what scale is.",
    ),
    "an axis of a number that is not there": (
        lambda: with_numbers(DEVICE, {"parts.shake.levels": 3.0}),
        "shake (spectral_excitation) has no number 'levels'; did you mean level?",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_one_sentence_says_what_is_wrong(name: str) -> None:
    made, sentence = WRONG[name]
    with pytest.raises((TypeError, ValueError)) as caught:
        made()
    said = str(caught.value)
    assert sentence in said
    assert said.endswith((".", "?"))
    assert "\n" not in said


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (None, "profile.csv"),
        ("", "is empty: it needs a header"),
        ("10,0.02\n2000,0.02\n", "has no header: give columns="),
        ("frequency_Hz,level_dB\n10,-17\n", "'level_dB' is not a column"),
        ("time_s,time_s\n0,1\n", "time_s"),
        ("frequency_Hz,psd_g2/Hz\n10,0.02\n5,0.02\n", "frequency must increase"),
    ],
)
def test_a_table_beside_a_system_file(
    tmp_path: Path, text: str | None, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command ends with 2 and one sentence that names the file."""
    (tmp_path / "box.toml").write_text(
        '[[parts]]\nkind = "spring"\nstiffness = 1.0\n[[parts]]\nkind = "spectral_excitation"\npath = "profile.csv"\n',
        encoding="utf-8",
    )
    if text is not None:
        (tmp_path / "profile.csv").write_text(text, encoding="utf-8")
    assert cli.main(["explain", str(tmp_path / "box.toml")]) == 2
    said = capsys.readouterr().err
    assert "profile.csv" in said
    assert sentence in said
    assert "Traceback" not in said


def test_a_table_beside_a_system_file_is_the_table(tmp_path: Path) -> None:
    (tmp_path / "profile.csv").write_text("frequency_Hz,psd_g2/Hz\n10,0.02\n2000,0.02\n", encoding="utf-8")
    (tmp_path / "box.toml").write_text(
        '[[parts]]\nkind = "spring"\nstiffness = 1.0\n[[parts]]\nkind = "spectral_excitation"\npath = "profile.csv"\n'
        "scale = 0.5\n",
        encoding="utf-8",
    )
    found = sp.read_system(tmp_path / "box.toml").parts[1]
    assert found == SPECTRAL.from_psd((10, 2000), 0.02, "g2/Hz", scale=0.5)


def test_studies_take_the_level_and_the_overall_rms(tmp_path: Path) -> None:
    """In dB above the table, and in m/s^2."""
    for axis, values, ratio in (("level", [-10.0, 0.0], 10.0), ("rms", [1.0, 3.0], 9.0)):
        content = {"name": axis, "system": DEVICE, "methods": ["linear"], "axes": {f"parts.shake.{axis}": values},
                   "quantities": ["x_mean_square"]}  # fmt: skip
        found = sp.study(content, tmp_path / axis)["theory"]["x_mean_square"].values.ravel()
        assert found[1] / found[0] == pytest.approx(ratio, rel=1e-9)


def test_the_command_prints_results_in_bins_of_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / "box.toml"
    place.write_text(sp.to_toml(sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))), encoding="utf-8")
    words = ["simulate", str(place), "--paths", "8", "--duration", "4", "--step", "0.1", "--start", "rest", "--profile"]
    assert cli.main([*words, "0", "2", "4", "--json"]) == 0
    assert "x_mean_square_profile" in json.dumps(json.loads(capsys.readouterr().out))
    assert cli.main([*words, "0", "2", "1"]) == 2
    assert "profile" in capsys.readouterr().err
