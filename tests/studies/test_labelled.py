"""The labelled group of a finished study: xarray opens it without springpot, and an old one is known as such."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import springpot as sp
from springpot.studies import running
from springpot.studies.export import export
from springpot.studies.labelled import status
from springpot.studies.running import run_study
from springpot.studies.store import open_store
from tests.posix import link, make_pipe, needs_signals
from tests.sizes import validation
from tests.studies.samples import RUNS, content, given, orphans, replaced

BASE: dict[str, Any] = {
    **RUNS,
    "axes": {"order": [0.5, 1.0], "restitution": [1.0, 0.8]},
    "zipped": {"case": {"coefficient": [0.3, 2.0], "position": [0.0, 0.1]}},
    "monte_carlo": {"paths": 16, "duration": 5.0, "step": 0.02, "start": "rest"},
}
STUDY = given(BASE)
ADAPTED = given({**BASE, "monte_carlo": {**BASE["monte_carlo"], "start": "stationary"}})
WIDER = given(BASE, axes={"order": [0.5, 0.75, 1.0], "restitution": [1.0, 0.8]})


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("labelled") / "study.zarr"
    assert run_study(STUDY, path, threads=2).labelled
    return path


@pytest.fixture
def copy(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "study.zarr"))


def labels(path: Path) -> xarray.DataTree:
    with xarray.open_datatree(path / "labelled", engine="zarr") as tree:
        return tree.load()


ALONE = """
import sys
sys.path[:] = [place for place in sys.path if place != {source!r}]
try:
    import springpot
except ModuleNotFoundError:
    pass
else:
    raise SystemExit("springpot is there")
import warnings
warnings.simplefilter("error")
warnings.simplefilter("default", DeprecationWarning)
import xarray
tree = xarray.open_datatree({store!r} + "/labelled", engine="zarr")
assert set(tree.groups) == {{"/", "/theory", "/simulation"}}, tree.groups
rate = tree["simulation"]["impact_rate"]
assert rate.dims == ("order", "restitution", "case") and rate.attrs["units"] == "s-1", rate
one = tree["theory"]["x_mean"].sel(theory="averaging", order=0.5, restitution=0.8, case=2)
assert one.coords["position"].attrs["units"] == "m" and float(one.coords["position"]) == 0.1
part = xarray.open_zarr({store!r} + "/labelled", group="simulation")
assert bool(part["done"].all())
rate = float(rate.sel(order=1.0, restitution=0.8, case=1))
print(rate, float(one), part["order"].values.tolist(), tree.attrs["title"])
"""


def alone(store: Path) -> str:
    """What xarray says in a process that has no springpot."""
    source = str(Path(sp.__file__).parents[1])
    packages = str(Path(xarray.__file__).parents[1])
    code = f"import sys; sys.path.append({packages!r})\n" + ALONE.format(source=source, store=str(store))
    # -S: no .pth file, by which an editable installation is seen
    alone = [sys.executable, "-I", "-S", "-c", code]
    done = subprocess.run(alone, capture_output=True, text=True, timeout=300, cwd=store.parent, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_xarray_opens_a_finished_study_where_there_is_no_springpot(whole: Path) -> None:
    tree = sp.open_study(whole)
    rate = float(tree["simulation"]["impact_rate"].sel(order=1.0, restitution=0.8, case=1))
    one = float(tree["theory"]["x_mean"].sel(theory="averaging", order=0.5, restitution=0.8, case=2))
    assert alone(whole) == f"{rate} {one} [0.5, 1.0] runs\n"


def test_it_holds_what_open_study_gives(whole: Path) -> None:
    tree, found = sp.open_study(whole).load(), labels(whole)
    for part in ("theory", "simulation"):
        for name, variable in tree[part].to_dataset().variables.items():
            again = found[part].to_dataset().variables[name]
            assert (again.dims, {**again.attrs}) == (variable.dims, {**variable.attrs})
            np.testing.assert_array_equal(again.values.astype(variable.dtype), variable.values)
    assert {**tree.attrs}.items() <= {**found.attrs}.items()


def test_the_same_bytes_again(whole: Path, tmp_path: Path) -> None:
    assert run_study(STUDY, tmp_path / "study.zarr", threads=1).labelled
    assert content(tmp_path / "study.zarr") == content(whole)
    run_study(STUDY, whole)
    assert content(tmp_path / "study.zarr") == content(whole)


@pytest.mark.validation
def test_the_same_bytes_again_from_adapted_starts(tmp_path: Path) -> None:
    for threads in (1, 2):
        assert run_study(ADAPTED, tmp_path / f"{threads}.zarr", threads=threads).labelled
    assert content(tmp_path / "1.zarr") == content(tmp_path / "2.zarr")


@pytest.mark.validation  # every day: the same bytes again, in this file
def test_a_study_that_grows_has_none_until_it_is_finished(copy: Path) -> None:
    first = labels(copy)["simulation"].sizes["order"]
    assert not run_study(WIDER, copy, shard=(1, 2)).labelled
    assert not (copy / "labelled").exists()
    assert status(open_store(copy)).labelled == "missing"
    assert run_study(WIDER, copy, shard=(2, 2)).labelled  # the last job of an array makes it
    assert (first, labels(copy)["simulation"].sizes["order"]) == (2, 3)
    assert status(open_store(copy)).labelled == "right"
    assert orphans(copy) == []


@pytest.mark.validation  # every day: damage is found and mended, in this file
def test_a_missing_or_changed_answer_makes_it_outdated(copy: Path, whole: Path) -> None:
    replaced(copy, 0, b"")
    assert status(open_store(copy)).labelled == "outdated"
    assert run_study(STUDY, copy).labelled
    assert content(copy) == content(whole)
    other = given({**BASE, "fixed": {"intensity": 2.0}})
    run_study(other, copy.parent / "other.zarr")
    shutil.rmtree(copy / "labelled")
    shutil.copytree(copy.parent / "other.zarr" / "labelled", copy / "labelled")
    assert status(open_store(copy)).labelled == "damaged"  # this store has never written such a group
    assert run_study(STUDY, copy).computed == 0
    assert content(copy) == content(whole)


def _flip(file: Path) -> None:
    body = bytearray(file.read_bytes())
    body[len(body) // 2] ^= 1
    file.write_bytes(body)


def _folder_to_file(place: Path) -> None:
    shutil.rmtree(place)
    link(place, place)


@pytest.mark.parametrize(
    "damage",
    [
        lambda path: _flip(path / "labelled/simulation/x_mean/c/0/0/0"),
        validation(lambda path: _flip(path / "labelled/theory/said/zarr.json")),
        validation(lambda path: _flip(path / "labelled/zarr.json")),
        validation(lambda path: (path / "labelled/theory/x_mean/c/0/0/0/0").unlink()),
        validation(lambda path: (path / "labelled/zarr.json").write_text("[" * 100_000, encoding="utf-8")),
        validation(lambda path: make_pipe(path / "labelled/theory/pipe")),
        validation(lambda path: _folder_to_file(path / "labelled")),
        validation(lambda path: shutil.rmtree(path / "labelled")),
        lambda path: (path / "labelled/zarr.json").write_bytes(
            (path / "labelled/zarr.json").read_bytes().replace(b'"simulation/x_mean"', b'"simulation/y_mean"')
        ),
    ],
    ids=["chunk", "metadata", "root", "gone", "brackets", "pipe", "link", "missing", "listed"],
)
def test_damage_is_found_and_mended(damage: Any, copy: Path, whole: Path) -> None:
    damage(copy)
    assert status(open_store(copy)).labelled in ("damaged", "missing")
    assert run_study(STUDY, copy).computed == 0
    assert status(open_store(copy)).labelled == "right"
    assert content(copy) == content(whole)


@needs_signals
@pytest.mark.validation  # every day: failed tasks, and the kills of test_running.py
def test_a_kill_while_it_is_written_leaves_none(copy: Path, whole: Path) -> None:
    shutil.rmtree(copy / "labelled")
    code = (
        "import os, sys\nfrom springpot.studies import labelled\nfrom springpot.studies.store import open_store\n"
        "labelled.take_away_labelled = lambda path: os.kill(os.getpid(), 9)\n"
        "labelled.finish(open_store(sys.argv[1]))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(copy)], timeout=300, check=False)
    assert done.returncode == -9
    assert not (copy / "labelled").exists()
    assert len(orphans(copy)) > 0
    assert run_study(STUDY, copy).labelled
    assert content(copy) == content(whole)


def test_failed_tasks_leave_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    right = running.compute

    def failing(task: Any, **how: Any) -> Any:
        if task.method == "averaging" and task.point["order"] == 1.0:
            raise ArithmeticError("no number")
        return right(task, **how)

    monkeypatch.setattr(running, "compute", failing)
    assert not run_study(STUDY, tmp_path / "study.zarr").labelled
    assert not (tmp_path / "study.zarr" / "labelled").exists()


@pytest.mark.validation  # every day: the same bytes again, in this file
def test_export_to_zarr(whole: Path, tmp_path: Path) -> None:
    out = export(open_store(whole), tmp_path / "out.zarr")
    with xarray.open_datatree(out, engine="zarr") as tree:
        assert tree["simulation"]["impact_rate"].sel(order=0.5, case=1).dims == ("restitution",)
    for place, overwrite, says in (
        (out, False, r"out\.zarr' exists already: give another name, or --overwrite"),
        (whole, True, "is the store of a study, which export does not replace"),
    ):
        with pytest.raises(ValueError, match=says):
            export(open_store(whole), place, overwrite=overwrite)
    (tmp_path / "mine.zarr").mkdir()
    with pytest.raises(ValueError, match="exists and is not a Zarr group"):
        export(open_store(whole), tmp_path / "mine.zarr", overwrite=True)
    assert export(open_store(whole), out, overwrite=True) == out
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["mine.zarr", "out.zarr"]
