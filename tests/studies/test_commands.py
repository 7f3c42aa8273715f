"""``springpot study``: what each command prints, its JSON, exit codes and sentences."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from springpot import cli
from springpot.cli.studying import _size, _time
from springpot.studies.question import Study, read_study
from tests.sizes import validation
from tests.studies.samples import RUNS, THEORY, content, lines, replaced, write_toml

PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("commands")
    file = write_toml(folder / "runs.toml", RUNS)
    assert cli.main(["study", "run", str(file), "--store", str(folder / "runs.zarr"), "--threads", "2"]) == 0
    return folder


def asked(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> tuple[str, str]:
    capsys.readouterr()
    assert cli.main(["study", *map(str, words)]) == code
    out, err = capsys.readouterr()
    if code:
        assert out == ""
        assert err.startswith("springpot: ")
        assert err.count("\n") == 1
    return out, err


@pytest.mark.parametrize("command", ["new", "schema", "check", "run", "status", "export", "plot"])
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert f"Usage: springpot study {command}" in asked(capsys, command, "--help")[0]


@pytest.mark.parametrize("name", ["example", 'a "quoted" name', "Ünïcode"])
def test_new_writes_a_study(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / f"{name}.toml"
    assert asked(capsys, "new", file)[0] == f"{file}\n"
    assert tomllib.loads(file.read_text(encoding="utf-8"))["name"] == name
    assert read_study(file).shape == {"order": 9, "restitution": 3}
    before = file.read_bytes()
    assert "exists already: give another name" in asked(capsys, "new", file, code=2)[1]
    assert file.read_bytes() == before


def test_new_asks_for_a_proper_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "must end in .toml, not 'study.txt'" in asked(capsys, "new", tmp_path / "study.txt", code=2)[1]
    said = asked(capsys, "new", tmp_path / "none" / "study.toml", code=2)[1]
    assert f"the study file must lie in a folder that exists, but {str(tmp_path / 'none')!r} does not." in said


def test_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert json.loads(asked(capsys, "schema")[0]) == Study.model_json_schema()


def test_check(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, err = asked(capsys, "check", made / "runs.toml")
    assert err == ""
    assert out.startswith("runs: 3 order x 2 restitution\n")
    assert "12 tasks, about " in out
    found = json.loads(asked(capsys, "check", made / "runs.toml", "--json")[0])
    assert found["shape"] == {"order": 3, "restitution": 2}
    assert found["tasks"] == {"averaging": 6, "monte_carlo": 6}
    assert found["without_answer"] == {"averaging": 0.0, "monte_carlo": 0.0}
    disk = sum(map(len, lines(made / "runs.zarr")))
    assert disk <= found["bytes"] <= 3 * disk
    assert found["seconds"] == pytest.approx(sum(found["processor_seconds"].values()) / found["threads"])


@pytest.mark.validation  # every day: a check, and one of dear tasks
def test_check_of_ten_million_tasks_takes_no_longer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    axes = {"order": {"linspace": [0.1, 1.0, 1000]}, "coefficient": {"linspace": [0.1, 1.0, 5000]}}
    file = write_toml(tmp_path / "large.toml", {**RUNS, "axes": axes})
    begun = time.process_time()
    out = asked(capsys, "check", file)[0]
    assert time.process_time() - begun < 5.0  # 2 s are the two samples
    assert "settings of Monte Carlo checked at 504 of 5,000,000 points.\n10,000,000 tasks, about " in out
    assert "(estimated from the tasks tried, to a factor of two)" in out
    found = json.loads(asked(capsys, "check", file, "--json")[0])
    assert 1 <= min(found["tried"].values()) <= max(found["tried"].values()) <= 12
    assert found["points_checked"] == 504


DEAR = [  # one task of each takes minutes
    {"paths": 100_000, "duration": 5000.0, "step": 0.005},
    validation({"paths": 10_000_000, "duration": 60.0, "step": 0.05}),
    validation({"paths": 4096, "duration": 20_000.0, "step": 0.01}),
    validation({"rtol": 2e-4}),
]


@pytest.mark.parametrize("settings", DEAR, ids=lambda settings: next(iter(settings)) + str(len(settings)))
def test_check_of_dear_tasks_takes_seconds(
    settings: dict[str, float], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They are tried for as long as tells how long they take."""
    file = write_toml(tmp_path / "dear.toml", {**RUNS, "monte_carlo": settings})
    begun = time.process_time()
    found = json.loads(asked(capsys, "check", file, "--json")[0])
    assert time.process_time() - begun < 10.0
    assert found["processor_seconds"]["monte_carlo"] > 100.0


def test_check_tells_methods_that_do_not_cover(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_toml(tmp_path / "theory.toml", THEORY)
    found = json.loads(asked(capsys, "check", file, "--json")[0])
    assert found["without_answer"]["averaging"] == 0.0
    assert found["without_answer"]["exact"] == pytest.approx(2 / 3)


@pytest.mark.validation
def test_the_estimate_for_the_example(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "example.toml"
    asked(capsys, "new", file)
    said = json.loads(asked(capsys, "check", file, "--json")[0])["seconds"]
    begun = time.perf_counter()
    asked(capsys, "run", file, "--store", tmp_path / "example.zarr")
    taken = time.perf_counter() - begun
    assert taken / 3.0 < said < 3.0 * taken


def test_run_resumes(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store = Path(shutil.copytree(made / "runs.zarr", tmp_path / "runs.zarr"))
    before = content(store)
    run = ("run", made / "runs.toml", "--store", store)
    assert asked(capsys, *run)[0] == (
        f"{store}: 12 tasks, 12 already there, 0 computed.\n"
        f'finished: xarray.open_datatree({str(store / "labelled")!r}, engine="zarr") opens it.\n'
    )
    replaced(store, 0, b"")
    assert json.loads(asked(capsys, *run, "--json")[0]) == {
        "store": str(store), "tasks": 12, "found": 11, "computed": 1, "failed": 0, "labelled": True,
    }  # fmt: skip
    assert json.loads(asked(capsys, *run, "--shard", "2/5", "--json")[0])["tasks"] == 3
    assert content(store) == before


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--shard", "3"], "--shard must be i/N, such as 1/4, not '3'"),
        (["--shard", "0/3"], "shard must be i/N with i from 1 to N, not 0/3"),
        (["--threads", "0"], "must be in [1, 4096], not 0"),
        (["--threads", "2.5"], "--threads must be a whole number, not '2.5'"),
        (["--threads", "2", "--workers", "2"], "cannot be combined"),
    ],
)
def test_run_with_wrong_flags(
    flags: list[str], says: str, made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert says in asked(capsys, "run", made / "runs.toml", "--store", tmp_path / "new.zarr", *flags, code=2)[1]
    assert list(tmp_path.iterdir()) == []


def test_run_needs_a_study(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store = tmp_path / "new.zarr"
    for command in (("run", tmp_path / "none.toml", "--store", store), ("check", tmp_path / "none.toml")):
        said = asked(capsys, *command, code=2)[1]
        assert said == f"springpot: There is no file {str(tmp_path / 'none.toml')!r}.\n"
    other = write_toml(tmp_path / "other.toml", {**RUNS, "seed": 9})
    assert "belongs to another study" in asked(capsys, "run", other, "--store", made / "runs.zarr", code=2)[1]


def test_failed_tasks_end_with_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object, **__: object) -> None:
        raise ArithmeticError("no number")

    monkeypatch.setattr("springpot.studies.running.compute", failing)
    file = write_toml(tmp_path / "theory.toml", THEORY)
    capsys.readouterr()
    assert cli.main(["study", "run", str(file), "--store", str(tmp_path / "theory.zarr"), "--threads", "1"]) == 1
    err = capsys.readouterr().err
    assert err.startswith("springpot: 12 tasks failed, the first of them ")
    assert err.endswith(": ArithmeticError: no number\n")


def test_status(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store = Path(shutil.copytree(made / "runs.zarr", tmp_path / "runs.zarr"))
    out = asked(capsys, "status", store)[0]
    assert [line.split() for line in out.splitlines()[2:-1]] == [
        ["averaging", "6", "0"],
        ["monte_carlo", "6", "0"],
    ]
    assert out.endswith("\nlabelled group, for xarray: right\n")
    of_theory = [number for number, line in enumerate(lines(store)) if line in lines(store, "averaging")]
    replaced(store, of_theory[1], b"damaged\n")
    replaced(store, of_theory[0], b"")
    out = asked(capsys, "status", store)[0]
    assert ["averaging", "4", "2"] in [line.split() for line in out.splitlines()]
    assert "\ndamaged lines: 1; what they held is missing, or was computed again.\n" in out
    assert out.endswith(
        f"springpot study run FILE --store {store} computes what is missing and repairs what is damaged.\n"
    )
    assert json.loads(asked(capsys, "status", store, "--json")[0]) == {
        "name": "runs",
        "shape": {"order": 3, "restitution": 2},
        "done": {"averaging": 4, "monte_carlo": 6},
        "missing": {"averaging": 2, "monte_carlo": 0},
        "damaged": 1,
        "labelled": "outdated",
    }
    assert "there is no store" in asked(capsys, "status", tmp_path / "none.zarr", code=2)[1]


def test_status_loads_nothing_heavy(made: Path) -> None:
    code = (
        f"import sys; from springpot.cli import main; main(['study', 'status', {str(made / 'runs.zarr')!r}])\n"
        "print(sorted({'numba', 'xarray', 'zarr', 'matplotlib', 'scipy', 'distributed'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr


def test_export(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, start in (("out.csv", b"method,order,restitution,"), ("out.nc", b"\x89HDF")):
        assert asked(capsys, "export", made / "runs.zarr", tmp_path / name)[0] == f"{tmp_path / name}\n"
        assert (tmp_path / name).read_bytes().startswith(start)
        said = asked(capsys, "export", made / "runs.zarr", tmp_path / name, code=2)[1]
        assert said.startswith(f"springpot: {str(tmp_path / name)!r} exists already: give another name, or --overwrite")
        (tmp_path / name).write_bytes(b"old")
        asked(capsys, "export", made / "runs.zarr", tmp_path / name, "--overwrite")
        assert (tmp_path / name).read_bytes().startswith(start)
    assert "must end in .nc" in asked(capsys, "export", made / "runs.zarr", tmp_path / "out.xls", code=2)[1]


def test_plot(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number, flags in enumerate([[], ["--kind", "map"], ["--along", "restitution", "--quantities", "x_mean"]]):
        out = tmp_path / f"{number}.png"
        assert asked(capsys, "plot", made / "runs.zarr", "--out", out, *flags)[0] == f"{out}\n"
        assert out.read_bytes().startswith(PNG)
    for flags, says in (
        (["--out", tmp_path / "a.jpg"], "must end in .png"),
        (["--out", tmp_path / "a.png", "--quantities", "x"], "--quantities must be among amplitude_mean_square, "),
        (["--out", tmp_path / "a.png", "--along", "position"], "must be an axis of the study, order or restitution"),
        (["--out", tmp_path / "a.png", "--kind", "pie"], "--kind must be 'curves', 'lines' or 'map', not 'pie'"),
    ):
        assert says in asked(capsys, "plot", made / "runs.zarr", *flags, code=2)[1]
    assert not (tmp_path / "a.png").exists()


def test_times_and_sizes_read_well() -> None:
    assert [_time(seconds) for seconds in (0.0, 9.94, 10.0, 89.0, 91.0, 3600.0, 5400.0, 86400.0, 1e6)] == [
        "0.1 s", "9.9 s", "10 s", "89 s", "1.5 min", "60 min", "1.5 h", "24 h", "12 d",
    ]  # fmt: skip
    assert [_size(size) for size in (0, 999, 1000, 123456, 8192e6, 1e15)] == [
        "0.0 B", "999 B", "1.0 kB", "123 kB", "8.2 GB", "1000 TB",
    ]  # fmt: skip


def test_linear_algebra_has_one_thread_as_that_of_the_workers_has() -> None:
    """With more, the last bits of the envelope and of the closure depend on their number."""
    code = (
        "import os, sys; sys.argv = ['springpot', 'no-such-command']; from springpot.__main__ import main; main(); "
        "print(os.environ['OPENBLAS_NUM_THREADS'], os.environ['OMP_NUM_THREADS'])"
    )
    without = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    for given, expected in (({}, "1 1\n"), ({"OMP_NUM_THREADS": "3"}, "1 3\n")):
        found = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, env={**without, **given}
        )
        assert found.stdout == expected
