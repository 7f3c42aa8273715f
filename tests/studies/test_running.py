"""Running a study: the same bytes whoever computes them, however often they are killed, and nothing computed twice."""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import psutil
import pytest

from springpot import cli
from springpot.studies import running, tasks
from springpot.studies.labelled import status
from springpot.studies.question import read_study
from springpot.studies.running import run_study
from springpot.studies.store import open_store
from springpot.studies.workers import Workers
from tests.posix import KILLED, needs_signals
from tests.signals import in_a_terminal
from tests.sizes import validation
from tests.studies.samples import COMMAND, RUNS, STOPS, THEORY, content, given, lines, orphans, with_device, write_toml

LONGER: dict[str, Any] = {
    **RUNS,
    "name": "longer",
    "axes": {"order": {"linspace": [0.3, 1.0, 8]}, "restitution": [1.0, 0.8]},
    "monte_carlo": {"paths": 2048, "duration": 60.0, "step": 0.02, "start": "rest"},
}
"""Some seconds of processor time in tasks of tenths."""
WAIT = 180.0  # s; a busy machine starts a worker in tens of seconds


@pytest.fixture(scope="module")
def longer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The longer study, never interrupted; not to be changed."""
    path = tmp_path_factory.mktemp("longer") / "study.zarr"
    assert run_study(given(LONGER), path).computed == 32
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("runs") / "study.zarr"
    assert run_study(given(RUNS), path, threads=1).computed == 12
    return path


def stamps(store: Path) -> dict[str, tuple[int, bytes]]:
    """The files of answers, and when they were written."""
    return {file.name: (file.stat().st_mtime_ns, file.read_bytes()) for file in store.glob("*.tasks")}


@pytest.mark.parametrize(
    ("change", "new"),
    [
        validation({"axes": {**RUNS["axes"], "order": [0.2, 0.4, 0.7, 1.0]}}, 4),
        validation({"axes": {**RUNS["axes"], "restitution": [0.8, 0.9, 1.0]}}, 6),
        validation({"axes": {"restitution": [0.8, 1.0], "order": [1.0, 0.7, 0.4]}}, 0),
        ({"axes": {**RUNS["axes"], "order": {"linspace": [0.4, 1.0, 5]}}}, 8),
        validation({"methods": ["monte_carlo", "averaging", "averaging_printed"]}, 6),
        validation({"methods": ["averaging"], "monte_carlo": None}, 0),
        validation({"quantities": ["x_mean"]}, 0),
    ],
    ids=["longer axis", "value between", "other order", "finer linspace", "another method", "fewer", "quantities"],
)
def test_a_study_grows_without_computing_anything_again(
    change: dict[str, Any], new: int, runs: Path, tmp_path: Path
) -> None:
    path = Path(shutil.copytree(runs, tmp_path / "study.zarr"))
    before, count = stamps(path), len(lines(path))
    grown = given(RUNS, **change)
    found = run_study(grown, path, threads=2)
    assert found.computed == new
    assert found.found == found.tasks - new
    after = stamps(path)
    assert {name: after[name] for name in before} == before
    assert len(lines(path)) == count + new
    assert sum(status(open_store(path)).done.values()) == found.tasks
    assert open_store(path).study == grown


@pytest.mark.parametrize("threads", [2, validation(3)])
def test_threads_give_the_same_files(threads: int, runs: Path, tmp_path: Path) -> None:
    assert run_study(given(RUNS), tmp_path / "study.zarr", threads=threads).computed == 12
    assert content(tmp_path / "study.zarr") == content(runs)


def test_shards_give_the_same_files(runs: Path, tmp_path: Path) -> None:
    path = tmp_path / "study.zarr"
    found = [run_study(given(RUNS), path, threads=1, shard=(number, 3)) for number in (3, 1, 2)]
    assert [(outcome.tasks, outcome.computed, outcome.found) for outcome in found] == [(4, 4, 0)] * 3
    assert content(path) == content(runs)


@pytest.mark.parametrize("workers", [1, validation(2)])
def test_a_cluster_gives_the_same_files(
    workers: int, runs: Path, tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    """It does not quarrel about Dask's usual port with another one; nothing listens to other machines."""
    said: list[float] = []
    heard: set[str] = set()
    usual, ours = 8787, psutil.Process()

    def listen(done: float) -> None:
        said.append(done)
        for one in (ours, *ours.children(recursive=True)):
            with contextlib.suppress(psutil.NoSuchProcess):
                listening = [c.laddr for c in one.net_connections("tcp") if c.status == psutil.CONN_LISTEN]
                heard.update(address.ip for address in listening if address.port != usual)

    with socket.socket() as taken:
        with contextlib.suppress(OSError):  # somebody else has taken it
            taken.bind(("127.0.0.1", usual))
            taken.listen()
        found = run_study(given(RUNS), tmp_path / "study.zarr", workers=workers, progress=listen)
    assert (found.computed, found.found, found.failures) == (12, 0, ())
    assert said == sorted(said)
    assert said[-1] == 1.0
    assert heard == {"127.0.0.1"}
    assert not [warning for warning in recwarn if str(usual) in str(warning.message)]
    assert content(tmp_path / "study.zarr") == content(runs)


@pytest.mark.validation  # every day: the next test, which asks one for two tasks
def test_a_scheduler_elsewhere(runs: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, protocol="tcp", dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        found = run_study(given(RUNS), tmp_path / "study.zarr", scheduler=cluster.scheduler_address)
    assert found.computed == 12
    assert content(tmp_path / "study.zarr") == content(runs)


@pytest.mark.parametrize(("count", "each"), [validation(1, 5), (2, 2), validation(3, 1)])
def test_few_tasks_share_the_threads_of_their_worker(
    count: int, each: int, runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two tasks on a worker of five threads take two each; the bits are those of one thread."""
    distributed = pytest.importorskip("distributed")
    taken: list[int] = []
    together = threading.Barrier(count)

    def watched(task: tasks.Task, *, threads: int, **_: object) -> tasks.Answer:
        taken.append(threads)
        together.wait(WAIT)
        return tasks.compute(task, threads=threads)

    monkeypatch.setattr(running, "compute", watched)  # the worker is a thread of this process
    study = given(RUNS, methods=["monte_carlo"], axes={"order": RUNS["axes"]["order"][:count], "restitution": [0.8]})
    path = tmp_path / "study.zarr"
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=5, processes=False, protocol="tcp", dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        assert run_study(study, path, scheduler=cluster.scheduler_address).computed == count
    assert taken == [each] * count
    assert len(lines(path)) == count
    assert set(lines(path)) < set(lines(runs))


def test_workers_that_come_later_are_all_used(runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A batch system may start the study before the workers of its cluster: then too several tasks run at once."""
    distributed = pytest.importorskip("distributed")
    together = threading.Barrier(2)

    def watched(task: tasks.Task, *, threads: int, **_: object) -> tasks.Answer:
        together.wait(WAIT)
        return tasks.compute(task, threads=threads)

    monkeypatch.setattr(running, "compute", watched)
    monkeypatch.setattr(running, "RECOUNT", 0.1)
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=2, processes=False, protocol="tcp", dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        later = threading.Timer(1.0, cluster.scale, [1])
        later.start()
        found = run_study(given(RUNS), tmp_path / "study.zarr", scheduler=cluster.scheduler_address)
        later.join()
    assert (found.computed, found.failures) == (12, ())
    assert content(tmp_path / "study.zarr") == content(runs)


def test_own_workers_share_the_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "threads_available", lambda: 3)
    with running._client(1, None) as (client, _):
        client.wait_for_workers(1, timeout=WAIT)
        assert list(client.nthreads().values()) == [3]


def test_no_scheduler_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "PATIENCE", "1s")
    with pytest.raises(OSError, match=r"^there is no Dask scheduler at 'tcp://127\.0\.0\.1:1'"):
        run_study(given(RUNS), tmp_path / "study.zarr", scheduler="tcp://127.0.0.1:1")


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"threads": 2, "workers": 2}, "threads, workers and scheduler cannot be combined"),
        ({"threads": 0}, r"threads must be in \[1, 4096\], not 0"),
        ({"workers": 0}, "workers must be a whole number from 1 to 4096, not 0"),
        ({"workers": 1.5}, "workers must be a whole number from 1 to 4096, not 1.5"),
        ({"shard": (0, 3)}, "shard must be i/N with i from 1 to N, not 0/3"),
        ({"shard": (4, 3)}, "shard must be i/N with i from 1 to N, not 4/3"),
    ],
)
def test_wrong_arguments(how: dict[str, Any], says: str, tmp_path: Path) -> None:
    with pytest.raises((TypeError, ValueError), match=says):
        run_study(given(THEORY), tmp_path / "study.zarr", **how)
    assert list(tmp_path.iterdir()) == []


def test_progress(tmp_path: Path) -> None:
    said: list[tuple[float, int]] = []
    run_study(
        given(LONGER, axes={"order": [0.4, 0.8], "restitution": [1.0]}), tmp_path / "study.zarr", threads=2,
        progress=lambda done: said.append((done, threading.get_ident())),
    )  # fmt: skip
    assert {thread for _, thread in said} == {threading.get_ident()}
    assert all(0.0 <= done <= 1.0 for done, _ in said)
    assert said[-1][0] == 1.0


def test_what_the_callback_raises_ends_the_run(tmp_path: Path) -> None:
    class Enough(Exception):
        pass

    def stop(_: float) -> None:
        raise Enough

    path = tmp_path / "study.zarr"
    with pytest.raises(Enough):
        run_study(given(LONGER), path, threads=1, progress=stop)
    assert len(lines(path)) < 32


def _failing(task: tasks.Task, **settings: Any) -> tasks.Answer:
    if task.method == "averaging" and task.point["order"] == 0.7:
        raise ArithmeticError("no number")
    return tasks.compute(task, **settings)


def test_a_task_that_fails_does_not_stop_the_others(
    runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "study.zarr"
    monkeypatch.setattr(running, "compute", _failing)
    found = run_study(given(RUNS), path, threads=2)
    assert found.computed == 10
    assert {reason for _, reason in found.failures} == {"ArithmeticError: no number"}
    assert {task.point["order"] for task, _ in found.failures} == {0.7}
    monkeypatch.undo()
    again = run_study(given(RUNS), path, threads=2)
    assert (again.computed, again.found, again.failures) == (2, 10, ())
    assert content(path) == content(runs)


@pytest.mark.validation
def test_nor_on_a_cluster(runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed")
    path = tmp_path / "study.zarr"
    monkeypatch.setattr(running, "compute", _failing)  # the worker is a thread of this process
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        found = run_study(given(RUNS), path, scheduler=cluster.scheduler_address)
    assert (found.computed, len(found.failures)) == (10, 2)
    assert "ArithmeticError: no number" in found.failures[0][1]
    monkeypatch.undo()
    assert run_study(given(RUNS), path, threads=2).computed == 2
    assert content(path) == content(runs)


def start(words: Sequence[object], folder: Path) -> subprocess.Popen[str]:
    with in_a_terminal():
        return subprocess.Popen(
            [*COMMAND, "run", *map(str, words)], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            start_new_session=True,
        )  # fmt: skip


def wait_for_answers(process: subprocess.Popen[str], store: Path, count: int) -> None:
    until = time.monotonic() + WAIT
    while len(lines(store)) < count and process.poll() is None:
        assert time.monotonic() < until, "no answers"
        time.sleep(0.02)


def killed_and_resumed(
    how: Sequence[str],
    times: int,
    whole: Path,
    folder: Path,
    seed: int,
    study: dict[str, Any] = LONGER,
    longest: float = 0.3,
) -> int:
    """Kill a study so many times, beginning another store whenever one is whole; how many stores it took.

    Each time up to so many seconds after some answers have come.
    """
    rng = random.Random(seed)
    file = (with_device if "system" in study else write_toml)(folder / "longer.toml", study)
    stores, done, count = [folder / "0.zarr"], 0, len(lines(whole))
    while done < times:
        store = stores[-1]
        process = start([file, "--store", store, *how], folder)
        before = len(lines(store))
        wait_for_answers(process, store, before + rng.randint(0, 3))
        time.sleep(rng.uniform(0.0, longest))
        children = psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []
        process.kill()
        process.communicate()
        _, alive = psutil.wait_procs(children, timeout=30.0)
        assert alive == []  # workers do not outlive their parent
        done += process.returncode == KILLED
        assert status_of(store)["damaged"] == 0
        if status_of(store)["done"] == count:
            stores.append(folder / f"{len(stores)}.zarr")
    if not stores[-1].exists():
        stores.pop()
    for store in stores:
        run_study(given(study), store, threads=2)
        assert orphans(store) == []
        assert content(store) == content(whole)
    return len(stores)


def status_of(store: Path) -> dict[str, int]:
    if not store.exists():
        return {"done": 0, "damaged": 0}
    found = status(open_store(store))
    return {"done": sum(found.done.values()), "damaged": found.damaged}


@pytest.mark.validation  # every day: a writer that is killed, in test_store.py
def test_killed_at_a_random_moment(runs: Path, tmp_path: Path) -> None:
    assert killed_and_resumed(["--threads", "1"], 1, runs, tmp_path, seed=7, study=RUNS, longest=0.02) >= 1


@pytest.mark.validation
@pytest.mark.parametrize(
    ("how", "times"), [(("--threads", "2"), 30), (("--workers", "2"), 20), (("--workers", "1"), 10)]
)
def test_killed_at_sixty_random_moments(how: Sequence[str], times: int, longer: Path, tmp_path: Path) -> None:
    """One worker has several threads where the machine has."""
    assert killed_and_resumed(how, times, longer, tmp_path, seed=3) >= 2


@pytest.mark.validation
@pytest.mark.parametrize(("how", "times"), [("--threads", 10), ("--workers", 6)])
def test_a_study_of_systems_killed_at_random_moments(how: str, times: int, tmp_path: Path) -> None:
    """The same bytes as without an interruption, also where worker processes compute them."""
    study = {**STOPS, "monte_carlo": {"paths": 2048, "duration": 20.0, "step": 1e-3, "start": "rest"}}
    whole = tmp_path / "whole.zarr"
    assert run_study(given(study), whole).computed == 24
    assert killed_and_resumed([how, "2"], times, whole, tmp_path, seed=5, study=study) >= 1


def workers_of(process: subprocess.Popen[str]) -> list[psutil.Process]:
    found = []
    with contextlib.suppress(psutil.NoSuchProcess):
        for child in psutil.Process(process.pid).children(recursive=True):
            with contextlib.suppress(psutil.NoSuchProcess):
                if "springpot.studies.worker" in child.cmdline():
                    found.append(child)
    return found


def kill_workers(times: int, longer: Path, folder: Path, seed: int) -> None:
    """Kill a worker so many times; the study ends by itself with the right bytes."""
    rng = random.Random(seed)
    file = write_toml(folder / "longer.toml", LONGER)
    store = folder / "study.zarr"
    for _ in range(times):
        shutil.rmtree(store, ignore_errors=True)
        process = start([file, "--store", store, "--workers", "2"], folder)
        wait_for_answers(process, store, rng.randint(1, 12))
        time.sleep(rng.uniform(0.0, 0.2))
        workers = workers_of(process)
        assert workers  # of the two, one may still be starting
        rng.choice(workers).kill()
        out, errors = process.communicate(timeout=WAIT)
        assert (process.returncode, errors) == (0, "")
        assert out.startswith(f"{store}: 32 tasks, ")
        assert run_study(given(LONGER), store).computed == 0  # removes what the killed worker left
        assert orphans(store) == []
        assert content(store) == content(longer)


@pytest.mark.validation
def test_a_worker_killed_in_the_middle(longer: Path, tmp_path: Path) -> None:
    kill_workers(1, longer, tmp_path, seed=1)


@pytest.mark.validation
def test_workers_killed_while_they_start(runs: Path, tmp_path: Path) -> None:
    """Each is replaced, and the study ends by itself with the right bytes."""
    process = start([write_toml(tmp_path / "runs.toml", RUNS), "--store", "study.zarr", "--workers", "2"], tmp_path)
    killed: set[int] = set()
    while len(killed) < 5 and process.poll() is None:
        for worker in workers_of(process):
            if worker.pid not in killed and len(killed) < 5:
                worker.kill()
                killed.add(worker.pid)
        time.sleep(0.02)
    out, errors = process.communicate(timeout=WAIT)
    assert (process.returncode, errors) == (0, "")
    assert out.startswith("study.zarr: 12 tasks, 0 already there, 12 computed.\n")
    assert len(killed) == 5
    assert content(tmp_path / "study.zarr") == content(runs)


def test_workers_that_end_again_and_again(monkeypatch: pytest.MonkeyPatch) -> None:
    if (program := shutil.which("false")) is None:
        pytest.skip("no program that ends at once")
    monkeypatch.setattr(sys, "executable", program)

    def wait(own: Workers) -> None:
        for _ in range(1000):
            own.replace_ended(progress=False)
            time.sleep(0.01)

    with Workers("tcp://127.0.0.1:1", 1) as own, pytest.raises(OSError, match="keep ending, the last one with"):
        wait(own)


@pytest.mark.parametrize("wait", [validation(0.0), 0.3, validation(1.0)])
def test_workers_end_with_a_killed_parent_while_they_start(wait: float) -> None:
    code = (
        "import time; from springpot.studies.workers import Workers\n"
        "with Workers('tcp://127.0.0.1:1', 2) as own:\n"
        "    print('ready', flush=True); time.sleep(600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == "ready\n"
        time.sleep(wait)
        left = workers_of(parent)
        assert len(left) == 2
        parent.kill()
        begun = time.monotonic()
        assert psutil.wait_procs(left, timeout=20.0)[1] == []
        assert time.monotonic() - begun < 10.0  # a tenth of a second where nothing else runs


@pytest.mark.validation
def test_workers_killed_at_random_moments(longer: Path, tmp_path: Path) -> None:
    kill_workers(10, longer, tmp_path, seed=2)


@pytest.mark.parametrize(("study", "count"), [("runs", 12), validation("longer", 32)])
def test_two_processes_on_one_store(study: str, count: int, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    """They share the work: what one has finished the other leaves out."""
    file = write_toml(tmp_path / "study.toml", {"runs": RUNS, "longer": LONGER}[study])
    store = tmp_path / "study.zarr"
    process = start([file, "--store", store, "--threads", "1", "--json"], tmp_path)
    wait_for_answers(process, store, 1)
    ours = run_study(read_study(file), store, threads=1)
    out, errors = process.communicate(timeout=WAIT)
    assert process.returncode == 0, errors
    theirs = json.loads(out)["computed"]
    assert theirs >= 1
    assert ours.found >= 1
    assert count <= theirs + ours.computed <= 2 * count
    assert content(store) == content(request.getfixturevalue(study))
    assert orphans(store) == []


@needs_signals
@pytest.mark.parametrize(
    ("sent", "how"),
    [
        (signal.SIGINT, "--threads"),
        validation(signal.SIGTERM, "--threads"),
        validation(signal.SIGINT, "--workers"),
        validation(signal.SIGTERM, "--workers"),
    ],
)
def test_stopped_by_a_signal(sent: signal.Signals, how: str, tmp_path: Path) -> None:
    """A terminal's Ctrl-C reaches every process of the group, a batch system's SIGTERM the first one."""
    file = write_toml(
        tmp_path / "long.toml",
        {**LONGER, "monte_carlo": {"paths": 2048, "duration": 500.0, "step": 0.02, "start": "rest"}},
    )
    store = tmp_path / "study.zarr"
    process = start([file, "--store", store, how, "2"], tmp_path)
    wait_for_answers(process, store, 4)
    children = psutil.Process(process.pid).children(recursive=True)
    begun = time.monotonic()
    if sent == signal.SIGINT:
        os.killpg(process.pid, sent)
    else:
        process.send_signal(sent)
    out, errors = process.communicate(timeout=WAIT)
    taken = time.monotonic() - begun
    assert process.returncode == 130, errors
    assert out == ""
    assert errors == "springpot: interrupted; all results so far are kept; the same command continues.\n"
    assert taken < 20.0  # 2 s where nothing else runs
    assert psutil.wait_procs(children, timeout=20.0)[1] == []
    found = status_of(store)
    assert found["done"] >= 4
    assert found["damaged"] == 0
    assert orphans(store) == []


def test_sigterm_is_obeyed_as_before_afterwards(tmp_path: Path) -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, _: heard.append(number))
    try:
        run_study(given(THEORY), tmp_path / "study.zarr")
        signal.raise_signal(signal.SIGTERM)
        assert heard == [signal.SIGTERM]
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.validation  # every day: one that is not there
def test_a_scheduler_that_goes_away(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The client tries to find it again for a while, then says what has happened."""
    script = (
        "import sys, distributed, time\n"
        "if __name__ == '__main__':\n"
        "    c = distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False,\n"
        "                                 dashboard_address=None, protocol='tcp', host='127.0.0.1')\n"
        "    print(c.scheduler_address, flush=True)\n"
        "    time.sleep(600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as cluster:
        assert cluster.stdout is not None
        address, store = cluster.stdout.readline().strip(), tmp_path / "study.zarr"

        def end() -> None:
            until = time.monotonic() + WAIT
            while len(lines(store)) < 3 and time.monotonic() < until:
                time.sleep(0.02)
            cluster.kill()

        ending = threading.Thread(target=end)
        ending.start()
        file = write_toml(tmp_path / "longer.toml", LONGER)  # three answers of it are awaited
        assert cli.main(["study", "run", str(file), "--store", str(store), "--scheduler", address]) == 1
        ending.join()
    assert "springpot: the Dask scheduler is gone: all results so far are kept, and running" in capsys.readouterr().err
    assert status_of(store)["done"] >= 3
