"""Runs written to files and read back."""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import random
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import springpot as sp
from springpot.problem.catalogue import OF_A_WALL, possible_results, unit_of_result
from springpot.problem.file import read_system
from springpot.simulation import Run
from springpot.simulation.result import load as loaded
from springpot.simulation.result import save as saved
from springpot.simulation.watch.counted_impacts import COUNTED

OSCILLATOR = sp.Oscillator(springpot=sp.Springpot(0.5, 0.4), barrier=sp.Barrier(0.1, 0.8, "below"))


@pytest.fixture(scope="module")
def rich() -> Run:
    """Everything that a run can hold, but a budget."""
    return sp.simulate(
        OSCILLATOR, paths=700, duration=40.0, start="stationary", record=3, record_every=5, distributions=True,
        spectrum=[1.0, 2.0], observables={"power": lambda t, x, v: 0.1 * v * v}, first_passage={"speed": 1.0},
    )  # fmt: skip


@pytest.fixture(scope="module")
def budgeted() -> Run:
    return sp.simulate(OSCILLATOR, rtol=0.1)


def equal(one: Any, other: Any) -> bool:
    """To the last bit, and in their types."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if dataclasses.is_dataclass(one):
        return all(equal(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one))
    if isinstance(one, dict):
        return list(one) == list(other) and all(equal(one[name], other[name]) for name in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    return bool(one == other) or (isinstance(one, float) and math.isnan(one) and math.isnan(other))


@pytest.mark.parametrize("suffix", ["nc", "json"])
@pytest.mark.parametrize("which", ["rich", "budgeted", "tiny"])
def test_a_run_comes_back_equal(which: str, suffix: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    run = sp.simulate(sp.Oscillator(barrier=None), paths=1, duration=1.0) if which == "tiny" else None
    run = run or request.getfixturevalue(which)
    again = sp.load_run(run.save(tmp_path / f"run.{suffix}", path_sums=True))
    assert equal(run, again)
    assert again.to_dict() == run.to_dict()
    xarray.testing.assert_identical(again.to_xarray(), run.to_xarray())
    assert [place.name for place in tmp_path.iterdir()] == [f"run.{suffix}"]
    if which == "rich":
        assert np.array_equal(again.distributions["x"].density()[1], run.distributions["x"].density()[1])
        off = dataclasses.replace(run["x_mean"], value=np.nextafter(run["x_mean"].value, 9.0))
        broken = dataclasses.replace(again, estimates={**run.estimates, "x_mean": off})
        assert not equal(run, broken)


def test_every_field_of_a_run_can_be_saved() -> None:
    """What is added to a run later must be of kinds that a file can hold."""
    kinds = {"Run", "Settings", "Adapted", "Budget", "Distribution", "PassageTimes", "Spectrum"}
    assert set(loaded._classes()) >= kinds


@pytest.mark.validation  # every day: a run comes back equal, in this file
def test_other_programs_read_the_netcdf_file(rich: Run, tmp_path: Path) -> None:
    rich.save(tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as found:
        assert found["impact_rate"].item() == rich["impact_rate"].value
        assert found["impact_rate"].units == "s-1"
        assert found["x"].dims == ("path", "time")
        assert np.array_equal(found["x"], rich.record[:, :, 0])
        assert found["time"].units == "s"
        assert read_system(json.loads(found.attrs["system"])).of(sp.Barrier) == (sp.Barrier(0.1, 0.8, "below"),)


def test_other_programs_read_the_json_file(rich: Run, tmp_path: Path) -> None:
    rich.save(tmp_path / "run.json")
    found = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert found.pop("run")["format"] == 1
    assert found == rich.to_dict()


def test_the_table_has_every_number_with_its_error_and_unit(rich: Run, budgeted: Run, tmp_path: Path) -> None:
    rich.save(tmp_path / "run.csv")
    rows = list(csv.DictReader((tmp_path / "run.csv").open(newline="")))
    numbers = {row["quantity"]: row for row in rows if not row["at"]}
    names = [name for name in possible_results(rich.system) if not name.startswith("barrier_")]
    of_the_wall = [row for row in rows if row["at"] == "barrier"]
    usual = [what for what in OF_A_WALL if what not in COUNTED]
    assert [row["quantity"] for row in of_the_wall] == [f"barrier_{what}" for what in usual]
    for row in of_the_wall:
        assert row["along"] == "barrier"
        assert float(row["value"]) == rich[row["quantity"]].value
        assert float(row["standard_error"]) == rich[row["quantity"]].error
        assert row["unit"] == unit_of_result(rich.system, row["quantity"])
    assert list(numbers)[: len(names) + 1] == [*names, "power"]
    of_passages = [row for name, row in numbers.items() if name.startswith("speed_first_passage_")]
    assert {row["unit"] for row in of_passages} == {"s", "s-1", "1"}
    for name in (*names, "power"):
        row = numbers[name]
        assert float(row["value"]) == rich[name].value
        assert float(row["standard_error"]) == rich[name].error
        assert row["unit"] == ("" if name == "power" else unit_of_result(rich.system, name))
    median = [row for row in rows if row["quantity"] == "impact_speed_quantile" and row["at"] == "0.5"]
    assert float(median[0]["value"]) == float(rich.distributions["impact_speed"].quantile(0.5)[0])
    assert (median[0]["along"], median[0]["unit"]) == ("probability", "m s-1")
    assert [float(row["at"]) for row in rows if row["quantity"] == "x_spectrum"] == [1.0, 2.0]
    paths = list(csv.reader((tmp_path / "run_paths.csv").open(newline="")))
    assert paths[0][:3] == ["time (s)", "x of path 0 (m)", "v of path 0 (m/s)"]
    body = np.array(paths[1:], float)
    assert np.array_equal(body[:, 0], rich.time)
    assert np.array_equal(body[:, 5], rich.record[2, :, 0])
    budgeted.save(tmp_path / "budget.csv")
    first = next(csv.DictReader((tmp_path / "budget.csv").open(newline="")))
    assert float(first["total_error"]) == budgeted["x_mean"].budget.total
    assert float(first["step_bias"]) == budgeted["x_mean"].budget.step_bias


@pytest.mark.parametrize("suffix", ["nc", "json", "csv"])
def test_nothing_is_replaced_unless_asked_for(suffix: str, rich: Run, tmp_path: Path) -> None:
    place = tmp_path / f"run.{suffix}"
    place.write_text("mine", encoding="utf-8")
    with pytest.raises(ValueError, match=r"exists already: give another name, or overwrite=True to replace it\.$"):
        rich.save(place)
    assert place.read_text(encoding="utf-8") == "mine"
    rich.save(place, overwrite=True)
    assert place.stat().st_size > 1000


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("run.txt", "the file to save to must end in .nc (netCDF), .json or .csv (for spreadsheets), not 'run.txt'."),
        ("none/run.nc", "cannot be written: the folder"),
        ("folder.nc", "cannot be written: it is a folder"),
    ],
)
def test_a_place_that_cannot_be_is_one_sentence(name: str, sentence: str, rich: Run, tmp_path: Path) -> None:
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(ValueError, match=re.escape(sentence)):
        rich.save(tmp_path / name)


def damaged(content: bytes, seed: int) -> bytes:
    """One byte changed, or the file cut, somewhere."""
    rng = random.Random(seed)
    at = rng.randrange(len(content))
    if seed % 2:
        return content[:at]
    return content[:at] + bytes([content[at] ^ (1 << rng.randrange(8))]) + content[at + 1 :]


@pytest.mark.parametrize("suffix", ["nc", "json"])
def test_damage_is_one_sentence_or_no_damage_to_the_run(suffix: str, rich: Run, tmp_path: Path) -> None:
    place = rich.save(tmp_path / f"run.{suffix}", path_sums=True)
    content, sentences = place.read_bytes(), []
    for seed in range(60):
        place.write_bytes(damaged(content, seed))
        try:
            found = sp.load_run(place)
        except ValueError as error:
            sentences.append(str(error))
        else:
            assert equal(found, rich)  # a byte that only other programs read, or that nobody does
    assert len(sentences) >= 30
    pattern = re.compile(rf"{re.escape(repr(str(place)))} cannot be read as a run: [^\n]+\.")
    assert all(pattern.fullmatch(sentence) for sentence in sentences)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "it is not JSON, or was cut short"),
        (b"{}", "it was not written by springpot"),
        (b"[" * 100_000, "it is not JSON, or was cut short"),
        (b'{"run": {"format": 9, "words": "", "arrays": {}}}', "it was written by a newer version of springpot"),
        (b'{"run": {"format": 1, "words": "[]", "arrays": {}}}', "its content was damaged"),
    ],
)
def test_a_foreign_file_is_one_sentence(content: bytes, reason: str, tmp_path: Path) -> None:
    place = tmp_path / "run.json"
    place.write_bytes(content)
    with pytest.raises(ValueError, match=f"^{re.escape(f'{str(place)!r} cannot be read as a run: {reason}.')}$"):
        sp.load_run(place)


def test_other_files_are_one_sentence(tmp_path: Path, rich: Run) -> None:
    xarray.Dataset({"x": 1.0}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    (tmp_path / "words.nc").write_text("nothing of the kind", encoding="utf-8")
    for name in ("other.nc", "words.nc"):
        with pytest.raises(ValueError, match=r"cannot be read as a run: it was not written by springpot\.$"):
            sp.load_run(tmp_path / name)
    with pytest.raises(ValueError, match=r"is a table for spreadsheets: only \.nc and \.json can be read back\.$"):
        sp.load_run(rich.save(tmp_path / "run.csv"))
    with pytest.raises(FileNotFoundError, match=r"^There is no file '.*missing\.nc'\.$"):
        sp.load_run(tmp_path / "missing.nc")
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(ValueError, match=r"is not a file\.$"):
        sp.load_run(tmp_path / "folder.nc")


def test_a_file_makes_nothing_but_the_parts_of_a_run(rich: Run, tmp_path: Path) -> None:
    """A forged class name, with a checksum that fits."""
    for name in ("Popen", "Path", "Bar"):
        words = json.dumps({"class": name, "fields": {"args": "true"}})
        own = {"format": 1, "words": words, "arrays": {}, "checksum": saved.checksum_of(words, {})}
        (tmp_path / "run.json").write_text(json.dumps({"run": own}), encoding="utf-8")
        with pytest.raises(ValueError, match="it was not written by springpot"):
            sp.load_run(tmp_path / "run.json")


def test_import_stays_light() -> None:
    code = "import sys, springpot; springpot.load_run; print(sorted({'xarray', 'h5py'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "[]", done.stderr
