"""Several masses in the command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import springpot as sp
from springpot import cli
from springpot.machine import bar
from springpot.simulation import monte_carlo
from tests.several import buildings, chain


@pytest.fixture
def pair(tmp_path: Path) -> str:
    (tmp_path / "pair.toml").write_text(sp.to_toml(buildings(sp.WhiteNoise(1e9, on="old"), gap=-5.0)), encoding="utf-8")
    return str(tmp_path / "pair.toml")


def test_masses_start_where_the_command_says(pair: str, capsys: pytest.CaptureFixture[str]) -> None:
    few = ["simulate", pair, "--paths", "64", "--duration", "5", "--initial-position", "old=0.02", "new=-0.01"]
    assert cli.main([*few, "--initial-velocity", "new=0.1", "--json"]) == 0
    settings = json.loads(capsys.readouterr().out)["settings"]
    assert settings["initial_position"] == {"old": 0.02, "new": -0.01}
    assert settings["initial_velocity"] == {"old": 0.0, "new": 0.1}
    for word, sentence in (
        ("0.02", "--initial-position must say of which masses it is, in Python as {'old': 0.01}, in the command as"),
        ("oldd=1", "--initial-position has 'oldd', which is no mass; did you mean old?\n"),
        ("old=x", "--initial-position must be a number"),
    ):
        assert cli.main(["simulate", pair, "--initial-position", word]) == 2
        assert sentence in capsys.readouterr().err
    assert cli.main(["simulate", "--initial-position", "0.3", "--paths", "64", "--duration", "5", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["settings"]["initial_position"] == 0.3


def test_first_passages_have_the_names_of_points_and_pairs(pair: str, capsys: pytest.CaptureFixture[str]) -> None:
    few = ["--paths", "64", "--duration", "5", "--first-passage"]
    assert cli.main(["simulate", pair, *few, "old_new_distance", "0.001", "--json"]) == 0
    assert "old_new_distance_first_passage_survival" in json.loads(capsys.readouterr().out)
    assert cli.main(["simulate", pair, *few, "x", "0.001"]) == 2
    assert "--first-passage must be one of old_x, old_v, old_distance, old_speed, new_x, " in capsys.readouterr().err
    assert cli.main(["simulate", *few, "distanc", "1"]) == 2
    assert "--first-passage must be one of x, distance, v, speed, amplitude, energy, not" in capsys.readouterr().err


def test_a_wall_that_is_never_struck_has_no_bias(pair: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", pair, "--paths", "64", "--duration", "5"]) == 0
    printed = capsys.readouterr().out
    assert "gap_impact_rate" in printed
    assert "step bias" not in printed


def test_a_long_run_says_so_first(
    pair: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(monte_carlo, "LONG", 1e4)
    monkeypatch.setattr(bar, "LONG_SECONDS", 0.0)
    assert cli.main(["simulate", pair, "--paths", "64", "--duration", "5"]) == 0
    said = capsys.readouterr().err
    assert "path-steps in all; 64 paths of 961 steps (fewer --paths or a shorter --duration take less)." in said


def test_masses_count_in_what_is_recorded() -> None:
    system = chain(sp.WhiteNoise(0.5, on="d"))
    with pytest.raises(ValueError, match=r"of 4 masses, but at most 50,000,000 points are stored: use record_every=3"):
        sp.simulate(system, paths=600, duration=1200.0, step=0.0234, record=600)


def test_a_start_in_a_state_that_there_is_not_is_one_sentence() -> None:
    loose = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a")),
        sp.Dashpot(0.1, between=("a", "b")), sp.WhiteNoise(1.0, on="a"),
    )  # fmt: skip
    with pytest.raises(ValueError, match="there is none: no spring or wall keeps b near the ground"):
        sp.simulate(loose, start="stationary")
