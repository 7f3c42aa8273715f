"""Rare events in studies: the results by level, and a kill in the middle of a cell."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.rare.saved import Saved
from springpot.simulation.rare.splitting import Tally
from springpot.studies.question import read_study
from springpot.studies.running import run_study
from springpot.studies.store import open_store
from springpot.studies.tasks import tasks
from tests.sizes import validation
from tests.studies.samples import COMMAND, content, write_toml

RARE: dict[str, Any] = {
    "name": "rare",
    "methods": ["exceedance"],
    "fixed": {"coefficient": 0.2, "intensity": 0.2, "position": -0.3, "restitution": 0.8},
    "axes": {"order": [0.5]},
    "exceedance": {"levels": {"x": [2.6, 3.6]}, "duration": 20.0, "start": "rest", "step": 0.05, "rtol": 0.5},
}


def killed(file: Path, store: Path, lines: int) -> None:
    """Kill a run as soon as so many repetitions of a cell are on disk."""
    process = subprocess.Popen([*COMMAND, "run", file, "--store", store, "--threads", "1"], stdout=subprocess.DEVNULL)
    until = time.monotonic() + 60.0
    while True:
        ended = [kept.read_bytes().count(b"\n") for kept in store.glob("*/*/numbers/*.repetitions")]
        if ended and max(ended) >= lines:
            break
        assert process.poll() is None, "it ended before the kill"
        assert time.monotonic() < until
        time.sleep(0.005)
    process.kill()
    assert process.wait() == -signal.SIGKILL


@pytest.mark.parametrize("lines", [40, validation(5)])  # among those that split, and among the plain ones
def test_a_kill_in_a_cell_keeps_its_repetitions_and_the_bits(
    lines: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, store = write_toml(tmp_path / "rare.toml", RARE), tmp_path / "rare.zarr"
    study = read_study(file)
    killed(file, store, lines)
    kept = [*store.glob("*/*/numbers/*.repetitions")]
    assert len(kept) == 1
    before = {tuple(json.loads(line)["of"]) for line in kept[0].read_bytes().rpartition(b"\n")[0].splitlines()}
    run_study(study, tmp_path / "whole.zarr")
    added, add = list[tuple[Any, ...]](), Saved.add

    def watched(saved: Saved, tally: Tally, *of: Any) -> None:
        added.append(of)
        add(saved, tally, *of)

    monkeypatch.setattr(Saved, "add", watched)
    assert run_study(study, store).labelled
    assert added  # the kill came before the end of the cell
    assert not before & set(added)  # what had ended is read, not computed again
    assert content(store) == content(tmp_path / "whole.zarr")
    kept[0].write_bytes(b"damaged")
    assert run_study(study, store).found == 1
    assert not kept[0].exists()


def test_cells_are_those_of_exceedance() -> None:
    tree = sp.study(RARE)
    found, task = tree["exceedance"].to_dataset(), next(tasks(read_study(RARE)))
    alone = sp.exceedance(task.system, **RARE["exceedance"], seed=task.seed)["x"]
    assert found["x_probability"].dims == ("order", "x_level")
    for name, right in (("probability", alone.probability), ("probability_se", alone.error),
                        ("probability_low", alone.low), ("probability_high", alone.high),
                        ("exceedance_rate", alone.rate), ("return_period", alone.return_period)):  # fmt: skip
        assert np.array_equal(found[f"x_{name}"].values[0], right)
    assert len(sp.figures.plot_study(tree).axes) == 2
    assert (found["x_level"].attrs["units"], found["x_return_period"].attrs["units"]) == ("m", "s")


def test_a_damaged_file_of_repetitions_is_made_again(tmp_path: Path) -> None:
    study = read_study(RARE)
    store = open_store(tmp_path / "rare.zarr", study)
    store.repetitions(next(tasks(study))).write_bytes(b"damaged")
    assert not run_study(study, store.path).failures


def test_errors_come_before_work(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r'"exceedance" if, and only if, there is a table \[exceedance\]'):
        read_study({**RARE, "methods": ["averaging"]})
    with pytest.raises(ValueError, match=r"at order = 0\.5: levels has 'y'"):
        sp.study({**RARE, "exceedance": {**RARE["exceedance"], "levels": {"y": [1.0]}}})
    with pytest.raises(ValueError, match="holds a level twice"):
        read_study({**RARE, "exceedance": {**RARE["exceedance"], "levels": {"x": [5.0, 5.0]}}})
