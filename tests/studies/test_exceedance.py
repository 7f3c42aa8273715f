"""Rare events in studies: the results by level, and a kill in the middle of a cell."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import springpot as sp
from springpot.simulation.rare.saved import Saved
from springpot.simulation.rare.splitting import Tally
from springpot.studies.export import export
from springpot.studies.question import read_study
from springpot.studies.running import run_study
from springpot.studies.store import open_store
from springpot.studies.tasks import tasks
from tests.kills import kill_when, lines_in
from tests.sizes import validation
from tests.studies.samples import COMMAND, content, write_toml

RARE: dict[str, Any] = {
    "name": "rare",
    "methods": ["exceedance", "monte_carlo", "linear"],
    "quantities": ["x_return_period", "x_first_passage_rate", "spring_force_mean_square", "counted_impact_rate"],
    "fixed": {"coefficient": 0.2, "intensity": 0.2, "position": -0.3, "restitution": 0.8},
    "axes": {"order": [0.5]},
    "exceedance": {"levels": {"x": [2.6, 3.6]}, "duration": 20.0, "start": "rest", "step": 0.05, "rtol": 0.5},
    "monte_carlo": {
        "paths": 512, "duration": 60.0, "start": "rest", "step": 0.05, "first_passage": {"x": [1.0, 2.6]},
        "forces": ["spring_force"], "slowest_counted_impact": 0.2,
    },
}  # fmt: skip
"""Every column that a study may ask for: of levels by splitting and on plain paths, of a force, and of fast impacts."""


def killed(file: Path, store: Path, lines: int) -> None:
    """Kill a run as soon as so many repetitions of a cell are on disk."""
    run = [*COMMAND, "run", file, "--store", store, "--threads", "1"]
    kill_when(run, lambda: any(lines_in(kept) >= lines for kept in store.glob("*.repetitions")))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rare") / "whole.zarr"
    run_study(read_study(RARE), path)
    return path


@pytest.mark.validation  # every day: a call that goes on, in simulation/rare
@pytest.mark.parametrize("lines", [40, validation(5)])  # among those that split, and among the plain ones
def test_a_kill_in_a_cell_keeps_its_repetitions_and_the_bits(
    lines: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: Path
) -> None:
    file, store = write_toml(tmp_path / "rare.toml", RARE), tmp_path / "rare.zarr"
    study = read_study(file)
    killed(file, store, lines)
    kept = [*store.glob("*.repetitions")]
    assert len(kept) == 1
    ended = kept[0].read_bytes().rpartition(b"\n")[0].splitlines()
    before = {tuple(json.loads(line.split(b" ", 3)[3])["of"]) for line in ended}
    added, add = list[tuple[Any, ...]](), Saved.add

    def watched(saved: Saved, tally: Tally, *of: Any) -> None:
        added.append(of)
        add(saved, tally, *of)

    monkeypatch.setattr(Saved, "add", watched)
    assert run_study(study, store).labelled
    assert added  # the kill came before the end of the cell
    assert not before & set(added)  # what had ended is read, not computed again
    assert content(store) == content(whole)
    kept[0].write_bytes(b"damaged")
    assert run_study(study, store).found == 3
    assert not kept[0].exists()


def test_cells_are_those_of_exceedance(whole: Path) -> None:
    tree = sp.open_study(whole)
    found, task = tree["exceedance"].to_dataset(), next(tasks(read_study(RARE)))
    alone = sp.exceedance(task.system, **RARE["exceedance"], seed=task.seed)["x"]
    assert found["x_probability"].dims == ("order", "x_level")
    for name, right in (("probability", alone.probability), ("probability_se", alone.error),
                        ("probability_low", alone.low), ("probability_high", alone.high),
                        ("exceedance_rate", alone.rate), ("return_period", alone.return_period)):  # fmt: skip
        assert np.array_equal(found[f"x_{name}"].values[0], right)
    assert sum(ax.axison for ax in sp.figures.plot_study(tree).axes) == 2 + 2 + 1 + 1  # of two levels two panels
    assert (found["x_level"].attrs["units"], found["x_return_period"].attrs["units"]) == ("m", "s")


@pytest.mark.validation  # every day: cells are those of exceedance, in this file
def test_what_a_run_is_asked_for_is_in_its_cells(tmp_path: Path, whole: Path) -> None:
    """First passages of levels, a force, and impacts that are not slow: as in the run of the point, in all files."""
    store, task = open_store(whole), next(task for task in tasks(read_study(RARE)) if task.method == "monte_carlo")
    found, right = (
        sp.open_study(whole)["simulation"].to_dataset(),
        sp.simulate(task.system, **RARE["monte_carlo"], seed=task.seed).to_xarray(),
    )
    asked = [name for name in right if "first_passage" in name and right[name].dims == ("x_first_passage_level",)]
    assert {f"x_first_passage_{what}" for what in ("probability_low", "rate_se", "mean", "return_period")} < {*asked}
    for name in (*asked, "spring_force_mean_square", "counted_impact_rate", "counted_impact_rate_se"):
        assert np.array_equal(found[name].values[0], right[name].values, equal_nan=True)
        assert found[name].units == right[name].units
    assert found["x_first_passage_level"].values.tolist() == [1.0, 2.6]
    assert 0.0 < found["x_first_passage_probability"].values[0, 1] < found["x_first_passage_probability"].values[0, 0]
    with xarray.open_dataset(export(store, tmp_path / "asked.nc"), group="simulation") as kept:
        xarray.testing.assert_identical(kept["x_first_passage_rate"].load(), found["x_first_passage_rate"])
    with export(store, tmp_path / "asked.csv").open(encoding="utf-8") as file:
        row = next(row for row in csv.DictReader(file) if row["method"] == "monte_carlo")
    assert float(row["x_2.6_first_passage_rate"]) == found["x_first_passage_rate"].values[0, 1]


def test_a_damaged_file_of_repetitions_is_made_again(tmp_path: Path) -> None:
    alone = {name: RARE[name] for name in RARE if name not in ("quantities", "monte_carlo")}
    study = read_study({**alone, "methods": ["exceedance"]})
    assert study.quantities == ("x_return_period",)
    store = open_store(tmp_path / "rare.zarr", study)
    store.repetitions(next(tasks(study))).write_bytes(b"damaged")
    assert not run_study(study, store.path).failures


def test_errors_come_before_work(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r'"exceedance" if, and only if, there is a table \[exceedance\]'):
        read_study({**RARE, "methods": ["averaging", "monte_carlo"]})
    with pytest.raises(ValueError, match=r"at order = 0\.5: levels has 'y'"):
        sp.study({**RARE, "quantities": ["x_mean"], "exceedance": {**RARE["exceedance"], "levels": {"y": [1.0]}}})
    with pytest.raises(ValueError, match=r"exceedance\.levels: x holds a level twice"):
        read_study({**RARE, "exceedance": {**RARE["exceedance"], "levels": {"x": [5.0, 5.0]}}})
    with pytest.raises(ValueError, match=r"at order = 0\.5: first_passage level of x is -0\.5 m, behind a wall"):
        sp.study({**RARE, "monte_carlo": {**RARE["monte_carlo"], "first_passage": {"x": [-0.5]}}})
    with pytest.raises(ValueError, match="rtol chooses all settings, so first_passage cannot be given with it"):
        read_study({**RARE, "monte_carlo": {"rtol": 0.1, "first_passage": {"x": [2.0]}}})
