"""Flags that take a name and numbers."""

from __future__ import annotations

import json

import pytest

import springpot as sp
from springpot import cli

FEW = ["simulate", "--no-barrier", "--paths", "64", "--duration", "10", "--step", "0.02", "--start", "rest"]


def test_cycles_and_intervals_are_those_of_python(capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "--rainflow",
        "x",
        "5",
        "2.0",
        "1e4",
        "--rainflow",
        "x",
        "3",
        "1.5",
        "--rainflow",
        "spring_force",
        "4",
        "2",
    ]
    passages = ["--first-passage", "x", "1.5", "--first-passage", "x", "-2", "1.8", "--first-passage", "v", "-1", "1"]
    assert cli.main([*FEW, *words, *passages, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    curves = {"x": [sp.Basquin(5.0, 2.0, 1e4), sp.Basquin(3.0, 1.5)], "spring_force": sp.Basquin(4.0, 2.0)}
    levels = {"x": [1.5, (-2.0, 1.8)], "v": (-1.0, 1.0)}
    own = sp.simulate(
        sp.Oscillator(barrier=None), paths=64, duration=10.0, step=0.02, start="rest", rainflow=curves,
        first_passage=levels,
    ).to_dict()  # fmt: skip
    names = [name for name in own if "damage_rate" in name or "first_passage" in name]
    assert len(names) > 20
    assert {name: found[name] for name in names} == {name: own[name] for name in names}
    assert cli.main([*FEW, *passages]) == 0
    printed = capsys.readouterr().out
    assert "x_first_passage 1.5  " in printed
    assert "x_first_passage -2 to 1.8  " in printed


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("--rainflow x 5", "--rainflow must be NAME EXPONENT STRENGTH [CYCLES], not x 5."),
        (
            "--rainflow 5 2",
            "--rainflow must be NAME EXPONENT STRENGTH [CYCLES], and begin with the name, not with 5.",
        ),
        ("--rainflow x five 1", "--rainflow must be NAME EXPONENT STRENGTH [CYCLES], not x five 1."),
        (
            "--rainflow x 0.5 1",
            "--rainflow of x: exponent must be in [1, 50], not 0.5. Of metals it is 3 to 15.",
        ),
        (
            "--rainflow y 5 1",
            "--rainflow has 'y', which is no displacement, force or acceleration; there are x, spring_force, "
            "springpot_force, force_on_ground, acceleration.",
        ),
        ("--rainflow", "--rainflow needs a value: springpot simulate --help says which."),
        ("--first-passage x 1 2 3", "--first-passage must be NAME LEVEL, or NAME LOW HIGH, not x 1 2 3."),
        (
            "--first-passage x 3 2",
            "--first-passage of x must have its interval from low to high, not (3.0, 2.0).",
        ),
    ],
)
def test_wrong_words_have_one_sentence(words: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*FEW, *words.split()]) == 2
    assert capsys.readouterr() == ("", f"springpot: {sentence}\n")


def test_theory_takes_levels_and_curves(capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "theory",
        "--no-barrier",
        "--levels",
        "x",
        "4",
        "--levels",
        "distance",
        "4",
        "--rainflow",
        "x",
        "5",
        "2",
        "1e4",
    ]
    assert cli.main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    system = sp.Oscillator(barrier=None)
    rates = sp.theory.exceedance(system, {"x": 4.0, "distance": 4.0})
    for name in ("x", "distance"):
        assert found["exceedance_rate"][f"{name} 4"] == {key: float(rate) for key, rate in rates[name].rate.items()}
    damage = sp.theory.fatigue(system, sp.Basquin(5.0, 2.0, 1e4)).damage
    assert found["damage_rate"] == {"x 5 2 10000": damage}
    assert cli.main(words) == 0
    printed = capsys.readouterr().out
    assert "damage_rate, h-1  narrow_band" in printed
    assert f"{damage['narrow_band']:.4g}" in printed
    assert cli.main(["theory", "--levels", "x", "4"]) == 2
    assert capsys.readouterr() == (
        "",
        "springpot: The linear theory covers linear springs, dampers, memory and circuits, without walls and contacts, "
        "not barrier.\n",
    )
