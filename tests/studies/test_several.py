"""Studies of several masses: results by points, pairs and walls, starts, stores, and files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.studies.question import read_study
from springpot.studies.running import run_study
from springpot.studies.template import of_system
from tests.several import buildings, tuned

SHAKEN = sp.KanaiTajimiNoise(15.0, 0.6, 0.05, on="ground")
DAMPERS: dict[str, Any] = {
    "name": "dampers", "methods": ["linear", "monte_carlo"], "system": tuned(),
    "quantities": ["frame_x_mean_square", "frame_damper_elongation_mean_square"],
    "axes": {"parts.pot.order": [0.5, 1.0], "parts.mass_2.value": [0.05, 0.1]},
    "monte_carlo": {"paths": 64, "duration": 40.0, "initial_position": {"damper": 0.5}},
}  # fmt: skip


def test_a_grid_has_the_results_of_points_and_pairs(tmp_path: Path) -> None:
    """A part of it first, which the whole one does not compute again."""
    store = tmp_path / "dampers.zarr"
    assert run_study(read_study(DAMPERS), store, shard=(1, 2)).computed == 4
    assert run_study(read_study(DAMPERS), store).computed == 4
    tree = sp.open_study(store)
    theory = tree["theory"].to_dataset()["frame_x_mean_square"].sel(theory="linear")
    assert (theory.attrs["units"], theory.dims) == ("m2", ("pot_order", "mass_2_value"))
    heavier = sp.System(*(sp.Mass(0.1, at="damper") if part == sp.Mass(0.05, at="damper") else part
                          for part in tuned(order=1.0).parts))  # fmt: skip
    assert float(theory[1, 1]) == pytest.approx(sp.theory.linear(heavier).frame_x_mean_square, rel=1e-12)
    simulated = tree["simulation"].to_dataset()
    assert simulated["damper_x_mean_se"].shape == (2, 2)
    assert (simulated["frame_damper_elongation_mean_square"] > 0.0).all()


def test_a_run_starts_from_rest_where_it_must_and_needs_a_stationary_state() -> None:
    held = {**DAMPERS, "monte_carlo": {"paths": 64, "duration": 20.0}, "methods": ["monte_carlo"],
            "axes": {"parts.tuning.stiffness": [0.0464, 0.0]}}  # fmt: skip
    found = sp.study(held)["simulation"].to_dataset()
    assert found["done"].all()
    assert np.isfinite(found["frame_x_mean_square"].values[0])
    assert "there is none: no spring or wall keeps damper near the ground" in str(found["said"].values[1])


def test_walls_have_their_dimension_and_quantities_a_default() -> None:
    pounding = {
        "name": "gaps", "system": buildings(SHAKEN), "methods": ["monte_carlo"],
        "axes": {"parts.gap.position": [-0.02, -0.05]}, "monte_carlo": {"paths": 64, "duration": 20.0},
    }  # fmt: skip
    assert read_study(pounding).quantities == ("old_x_mean_square",)
    found = sp.study(pounding)["simulation"].to_dataset()
    assert found["barrier_power"].dims == ("gap_position", "barrier")
    assert float(found["barrier_power"].sel(barrier="gap", gap_position=-0.02)) > 0.0
    assert np.isnan(found["barrier_impact_rate"]).all()
    assert len(sp.figures.plot_study(sp.study(pounding), quantities=("gap_power",)).axes) == 1


def test_the_new_file_of_a_system_can_be_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert of_system(tuned(), "t.toml")["methods"] == '"linear", "linearization", "monte_carlo"'
    (tmp_path / "pair.toml").write_text(sp.to_toml(buildings(SHAKEN)), encoding="utf-8")
    question = tmp_path / "study.toml"
    assert cli.main(["study", "new", str(question), "--system", str(tmp_path / "pair.toml")]) == 0
    text = question.read_text(encoding="utf-8")
    assert 'quantities = ["old_x_mean_square", "new_x_mean_square", "gap_impact_rate"]' in text
    few = "paths = 64\nduration = 10.0\ninitial_position = { old = 0.01 }\ninitial_velocity = { new = 0.1 }"
    question.write_text(text.replace("paths = 1000", few), encoding="utf-8")
    assert cli.main(["study", "run", str(question), "--store", str(tmp_path / "s.zarr")]) == 0
    assert cli.main(["study", "export", str(tmp_path / "s.zarr"), str(tmp_path / "s.csv")]) == 0
    assert "new_x_mean_square" in (tmp_path / "s.csv").read_text(encoding="utf-8").splitlines()[0]
    question.write_text(
        question.read_text(encoding="utf-8").replace("{ old = 0.01 }", "{ oldd = 0.01 }"), encoding="utf-8"
    )
    assert cli.main(["study", "run", str(question), "--store", str(tmp_path / "t.zarr")]) == 2
    assert "initial_position has 'oldd', which is no mass; did you mean old?" in capsys.readouterr().err
