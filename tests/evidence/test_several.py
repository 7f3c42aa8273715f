"""Comparisons of several masses."""

from __future__ import annotations

from pathlib import Path

import pytest

import springpot as sp
from springpot import cli
from springpot.evidence.comparison import compare
from tests.several import tuned


def test_theory_is_beside_monte_carlo_mass_by_mass() -> None:
    found = compare(tuned(), rtol=0.1)
    gaps = found.gaps("linear")
    assert found.recommended == "linear"
    assert {"frame_x_mean_square", "damper_v_mean_square", "frame_damper_elongation_mean_square"} <= gaps.keys()
    assert all(abs(gap.standard_errors) < 4.0 for gap in gaps.values())


def test_the_command_compares_and_draws_one_mass_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "damper.toml").write_text(sp.to_toml(tuned()), encoding="utf-8")
    assert cli.main(["compare", str(tmp_path / "damper.toml"), "--rtol", "0.2"]) == 0
    assert "* recommended here: linear" in capsys.readouterr().out
    assert cli.main(["compare", str(tmp_path / "damper.toml"), "--plot", str(tmp_path / "a.png")]) == 2
    assert "one mass is needed" in capsys.readouterr().err
