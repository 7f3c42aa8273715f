"""Files that somebody forged or damaged, and disks that are full: one sentence each, and nothing is lost."""

from __future__ import annotations

import json
import random
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.result import save as saved
from springpot.simulation.result.load import _unpacked
from tests.sizes import validation

resource = pytest.importorskip("resource", reason="limits of a process are those of Unix")

GARBAGE: tuple[Any, ...] = (
    None, True, -1, 0, 10**400, 1e308, -1e-308, "", "x" * 1000, [], {}, {"number": "nan"}, {"number": "inf"},
    {"empty": [0, 10**12], "kind": "<f8"}, {"empty": [10**9], "kind": "<f8"}, {"array": "record"}, {"array": "none"},
    {"tuple": []}, {"dict": {}}, {"system": {}}, {"class": "Run", "fields": {}}, {"list": [[[[]]]]},
    {"empty": ["a"], "kind": "V0"},
)  # fmt: skip
LONGEST = 2000  # characters in a sentence


@pytest.fixture(scope="module")
def words(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A saved run as JSON."""
    run = sp.simulate(
        sp.Oscillator(springpot=sp.Springpot(0.5, 0.4)), paths=64, duration=40.0, record=2, distributions=True,
        spectrum=[1.0, 2.0], first_passage={"speed": 1.0},
    )  # fmt: skip
    place = run.save(tmp_path_factory.mktemp("attack") / "run.json", path_sums=True)
    content: dict[str, Any] = json.loads(place.read_text(encoding="utf-8"))
    return content


def nodes(tree: Any) -> list[tuple[Any, Any]]:
    """Every place in a tree, as a container and a key."""
    inner = list(tree.items()) if isinstance(tree, dict) else list(enumerate(tree)) if isinstance(tree, list) else []
    return [(tree, key) for key, _ in inner] + [place for _, part in inner for place in nodes(part)]


def use(place: Path) -> str:
    """What a file is refused with, or nothing if the run in it can be used."""
    try:
        run = sp.load_run(place)
    except ValueError as error:
        return str(error)
    with np.errstate(all="ignore"):  # numbers may be anything
        run.to_dict()
        run.to_xarray()
    repr(run)
    return ""


@pytest.mark.parametrize("seeds", [range(40), validation(range(40, 600))])
def test_forged_runs(seeds: range, words: dict[str, Any], tmp_path: Path) -> None:
    """Random parts replaced, with a checksum that fits: one sentence, or a run that can be used."""
    place, refused = tmp_path / "run.json", 0
    for seed in seeds:
        rng = random.Random(seed)
        own = json.loads(json.dumps(words["run"]))
        if seed % 4 == 3:  # the arrays
            container, key = rng.choice(nodes(own["arrays"]))
            container[key] = rng.choice([*GARBAGE, [10**9], [3, -1], "<U9", ">f8"])
        else:
            tree = json.loads(own["words"])
            container, key = rng.choice(nodes(tree))
            container[key] = rng.choice(GARBAGE)
            own["words"] = json.dumps(tree)
        with suppress(Exception):  # then the checksum does not fit
            arrays = {name: _unpacked(packed, 10**7) for name, packed in own["arrays"].items()}
            own["checksum"] = saved.checksum_of(own["words"], arrays)
        place.write_text(json.dumps({**words, "run": own}), encoding="utf-8")
        start = time.perf_counter()
        said = use(place)
        refused += bool(said)
        if said:
            assert said.startswith(f"{str(place)!r} cannot be read as a run: ")
            assert len(said) < LONGEST
        assert time.perf_counter() - start < 10.0
    assert refused > 0.3 * len(seeds)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 4_000_000


def test_an_array_that_says_it_is_huge(words: dict[str, Any], tmp_path: Path) -> None:
    """The size that a file states is compared with that of the file before memory is taken."""
    import h5py

    run = sp.simulate(sp.Oscillator(), paths=64, duration=2.0, record=1)
    place = run.save(tmp_path / "run.nc")
    with h5py.File(place, "a") as file:
        del file["run"]["time"]
        file["run"].create_dataset("time", shape=(900_000_000,), dtype="f8", chunks=(1_000_000,))
    with pytest.raises(ValueError, match=r"cannot be read as a run: its content was damaged\.$"):
        sp.load_run(place)


FULL = """
import resource, sys
from pathlib import Path
import springpot as sp
from springpot.studies.export import export
from springpot.studies.store import open_store
folder, study = Path(sys.argv[1]), sys.argv[2]
run = sp.simulate(sp.Oscillator(), paths=64, duration=20.0, record=20)
store = open_store(study)
kept = run.save(folder / "kept.nc").read_bytes()
sys.dont_write_bytecode = True  # Python would keep files of bytecode that are cut off
resource.setrlimit(resource.RLIMIT_FSIZE, (700, 700))
def fails(write, place, **more):
    try:
        write(place, **more)
    except OSError as error:
        print(place.name, error.strerror)
for suffix in (".nc", ".json", ".csv"):
    fails(run.save, folder / f"run{suffix}")
for suffix in (".nc", ".csv"):
    fails(lambda place: export(store, place), folder / f"study{suffix}")
fails(run.save, folder / "kept.nc", overwrite=True)
assert (folder / "kept.nc").read_bytes() == kept
fails(lambda place: sp.figures.save(sp.figures.plot_path(run).figure, place), folder / "picture.png")
print("alive", run["x_mean"].value > 0.0)
"""


@pytest.mark.validation  # every day: of any record in machine/, and of the command in cli/test_cli.py
def test_a_full_disk(tmp_path: Path) -> None:
    """A limit on the size of files fails as a full disk does: HDF5 ended the process, and the run was lost."""
    from springpot.studies.running import run_study
    from tests.studies.samples import THEORY, given

    run_study(given(THEORY), tmp_path / "study")
    out = tmp_path / "out"
    out.mkdir()
    command = [sys.executable, "-c", FULL, str(out), str(tmp_path / "study")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    names = ["run.nc", "run.json", "run.csv", "study.nc", "study.csv", "kept.nc", "picture.png"]
    assert done.stdout.splitlines() == [*(f"{name} File too large" for name in names), "alive True"]
    assert sorted(place.name for place in out.iterdir()) == ["kept.nc"]
