"""``springpot design`` and ``springpot sensitivity``: what they print and write."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import springpot as sp
from springpot import cli
from tests.sizes import validation

DEVICE = """
[[parts]]
kind = "spring"
stiffness = 4.0

[[parts]]
kind = "dashpot"
coefficient = { free = "c", start = 0.5, low = 0.05, high = 5.0 }

[[parts]]
kind = "barrier"
position = -1.0

[[parts]]
kind = "white_noise"
intensity = 1.0
"""


@pytest.fixture
def device(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "device.toml").write_text(DEVICE, encoding="utf-8")
    return "device.toml"


def test_design_prints_and_writes(
    device: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[Any] = []

    def once(*given: Any, design: Any = sp.design, **how: Any) -> Any:
        """The same words ask for the same design twice: for people and for programs."""
        found.extend([design(*given, **how)] if not found else [])
        return found[0]

    monkeypatch.setattr("springpot.designing.design", once)
    words = [
        "design",
        device,
        "--minimize",
        "c",
        "--below",
        "impact_rate",
        "0.2",
        "--rtol",
        "0.1",
        "--cost-rtol",
        "0.2",
    ]
    assert cli.main([*words, "--out", "found.toml", "--plot", "found.png"]) == 0
    said = capsys.readouterr()
    assert "least c at which impact_rate < 0.2" in said.out
    assert [line.split()[-1] for line in said.out.splitlines() if line.startswith("  impact_rate ")] == ["s-1"]
    assert said.out.splitlines()[-2:] == ["found.toml", "found.png"]
    assert (tmp_path / "found.png").stat().st_size > 10_000
    (damper,) = sp.read_system("found.toml").of(sp.Dashpot)
    assert 0.15 < damper.coefficient < 0.25
    assert cli.main([*words, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["values"] == {"c": pytest.approx(float(damper.coefficient))}
    assert answer["promises"][0]["limit"] == "impact_rate < 0.2"
    assert answer["promises"][0]["probability"] > 0.95


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--below", "impact_rat", "1"], "--below and --above must limit results among"),
        (
            ["--below", "impact_rate", "1", "--below", "impact_rate", "2"],
            "--below must be given only once for impact_rat",
        ),
        (["--above", "impact_rate", "2", "--below", "impact_rate", "1"], "must have a low limit below the high one"),
        validation(["--below", "impact_rate", "1e-12"], "which misses impact_rate < 1e-12"),
        (["--plot", "found.png"], "--plot needs a limit, --below or --above."),
        (["--below", "impact_rate", "1", "--overwrite"], "--overwrite needs --out"),
        (["--below", "impact_rate", "1", "--rtol", "0"], "--rtol must be in"),
    ],
)
def test_design_refuses_in_one_sentence(
    device: str, words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["design", device, "--minimize", "c", *words]) == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert said.out == ""


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "one of --minimize and --maximize must be given."),
        (["--minimize", "c", "--maximize", "c"], "only one of --minimize and --maximize must be given."),
        (["--maximize", "impact_rat"], "--maximize must be among c, "),
    ],
)
def test_a_design_needs_one_cost(
    device: str, words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["design", device, *words]) == 2
    assert sentence in capsys.readouterr().err


def test_what_is_greatest_needs_no_limit(device: str, capsys: pytest.CaptureFixture[str]) -> None:
    """With less damping the wall is struck more often: the number ends at its lower bound."""
    assert cli.main(["design", device, "--maximize", "impact_rate", "--rtol", "0.2"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines()[0] == "greatest impact_rate"
    assert "c  0.05 s-1 (its lower bound)" in said.out


def test_sensitivity_draws(device: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert cli.main(["sensitivity", device, "--quantities", "impact_rate", "--plot", "found.png"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "found.png"
    assert (tmp_path / "found.png").stat().st_size > 10_000
