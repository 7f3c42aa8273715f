"""The command with a system of parts in a file."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import springpot as sp
from springpot import cli
from springpot.problem.file import schema
from tests.struck import rates_of

DUFFING = sp.System(
    sp.Mass(0.2), sp.Spring(80.0), sp.PolynomialSpring((0.0, 0.0, 4e5)), sp.Dashpot(0.4), sp.Barrier(-0.003),
    sp.Barrier(0.005, free_side="below"), sp.WhiteNoise(5e-5),
)  # fmt: skip


@pytest.fixture
def place(tmp_path: Path) -> str:
    found = tmp_path / "device.toml"
    found.write_text(sp.to_toml(DUFFING), encoding="utf-8")
    return str(found)


def test_theory_of_a_file(place: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["theory", place]) == 0
    out = capsys.readouterr().out
    exact = sp.theory.exact(DUFFING)
    assert out.startswith("0.2 x'' + 80 x + 400000 x^3 + 0.4 x' = w(t)\n")
    assert re.search(rf"barrier_2_impact_rate +.* {rates_of(exact)[1]:.5g} ", out)
    assert "* recommended here: exact" in out
    assert cli.main(["theory", place, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["system"] == json.loads(json.dumps(DUFFING.to_dict()))
    assert (found["exact"]["barrier_1_impact_rate"], found["exact"]["barrier_2_impact_rate"]) == rates_of(exact)
    assert sp.read_system({"parts": found["system"]["parts"]}) == DUFFING


def test_a_harvester_has_its_power_in_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / "harvester.toml"
    place.write_text(
        sp.to_toml(sp.System(sp.Spring(1.0), sp.PiezoelectricCircuit(0.5, 2.0, 1.0), sp.WhiteNoise(1.0))),
        encoding="utf-8",
    )
    assert cli.main(["theory", str(place)]) == 0
    assert any(line.split()[0] == "harvested_power" for line in capsys.readouterr().out.splitlines() if line.split())


def test_explain(place: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["explain", place]) == 0
    assert capsys.readouterr().out == sp.explain(DUFFING) + "\n"
    assert cli.main(["explain", "--order", "1"]) == 0
    assert capsys.readouterr().out.startswith("x'' + 1 x + 1 D^1 x = w(t)\n")
    assert cli.main(["explain", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out) == schema()


@pytest.mark.parametrize("command", [["atlas"], ["compare", "--plot", "x.png"]])
def test_what_needs_an_oscillator_names_the_part(
    command: list[str], place: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([command[0], place, *command[1:]]) == 2
    assert "polynomial_spring cannot be part of an Oscillator" in capsys.readouterr().err


def test_simulate_and_compare_a_file(place: str, capsys: pytest.CaptureFixture[str]) -> None:
    exact = sp.theory.exact(DUFFING)
    assert cli.main(["simulate", place, "--paths", "2000", "--step", "0.001", "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    for name in ("x_mean_square", "v_mean_square"):
        assert abs(numbers[name] - getattr(exact, name)) < 4.0 * numbers[f"{name}_se"] < 0.1 * numbers[name]
    places = zip(("barrier_1", "barrier_2"), rates_of(exact), strict=True)
    for wall, rate in places:
        assert abs(numbers[f"{wall}_impact_rate"] - rate) < 4.0 * numbers[f"{wall}_impact_rate_se"] + 1e-3
    assert numbers["system"] == json.loads(json.dumps(DUFFING.to_dict()))
    assert cli.main(["simulate", place, "--paths", "64", "--step", "0.001"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("system:\n  0.2 x'' + 80 x + 400000 x^3 + 0.4 x' = w(t)\n")
    assert " W\n" in out  # powers are those of the mass
    assert cli.main(["compare", place, "--rtol", "0.05", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["recommended"] == "exact"
    gaps = result["methods"]["exact"]["gap_standard_errors"]
    assert {"x_mean_square", "impact_rate"} <= {*gaps}
    assert max(map(abs, gaps.values())) < 5.0


def test_a_file_that_is_an_oscillator_runs_as_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = sp.Oscillator(2.0, sp.Springpot(0.5, 0.3), sp.Barrier(-0.1, 0.9), sp.WhiteNoise(0.5))
    place = tmp_path / "oscillator.toml"
    place.write_text(sp.to_toml(asked), encoding="utf-8")
    flags = ["--paths", "64", "--duration", "2", "--start", "rest", "--json"]
    numbers = sp.Dimensionless.of(asked).numbers
    words = [f"--{name.replace('_', '-')}={numbers[name]}" for name in numbers if name not in ("free_side", "barrier")]
    assert cli.main(["simulate", str(place), *flags]) == 0
    from_file = json.loads(capsys.readouterr().out)
    assert cli.main(["simulate", *words, *flags]) == 0
    from_flags = json.loads(capsys.readouterr().out)
    assert from_file["system"] == from_flags["system"]
    assert from_file["x_mean_square"] == from_flags["x_mean_square"] > 0.0
    assert sp.simulate(asked, paths=64, duration=2.0, start="rest").system == asked


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--order", "0.3"], "states the problem: no flag of the oscillator can be given with it."),
        (["--no-barrier"], "states the problem: no flag of the oscillator can be given with it."),
    ],
)
def test_a_file_and_flags(words: list[str], sentence: str, place: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["theory", place, *words]) == 2
    assert sentence in capsys.readouterr().err


def test_a_word_that_is_no_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["theory", "device"]) == 2
    assert "'device' is one word too many: springpot theory --help shows what it takes." in capsys.readouterr().err


def test_no_such_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["theory", "nowhere.toml"]) == 2
    assert "There is no file 'nowhere.toml'." in capsys.readouterr().err
    assert cli.main(["explain", "a.toml", "--schema"]) == 2
    assert "takes nothing else" in capsys.readouterr().err
