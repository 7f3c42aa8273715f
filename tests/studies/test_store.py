"""The store: what other Zarr readers see, every kind of damage found and mended, and no store ever half-made."""

from __future__ import annotations

import hashlib
import json
import math
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zarr

from springpot.machine.record import line_of
from springpot.studies import store as stores
from springpot.studies.labelled import status
from springpot.studies.running import run_study
from springpot.studies.store import StoreError, open_store
from springpot.studies.tasks import Answer, Task, compute, tasks
from tests.kills import fill
from tests.posix import link, make_pipe
from tests.sizes import thinned, validation
from tests.studies.samples import THEORY, content, given, lines, named, orphans, replaced

STUDY = given(THEORY)
DEAD = 2**22 + 1  # above the largest process number


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished store; not to be changed."""
    path = tmp_path_factory.mktemp("whole") / "study.zarr"
    found = run_study(STUDY, path, threads=1)
    assert (found.tasks, found.found, found.computed, found.failures) == (12, 0, 12, ())
    return path


@pytest.fixture
def copy(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "study.zarr"))


def test_any_program_sees_the_numbers(whole: Path) -> None:
    """Without springpot: words, checksums and JSON; numbers by the names of columns, and no number without a value."""
    word, checksum, name, text = (whole / "description").read_bytes().rstrip(b"\n").split(b" ", 3)
    assert (word, name) == (b"springpot-study", b"description")
    assert checksum == hashlib.sha256(name + b" " + text).hexdigest()[:32].encode()
    assert json.loads(text)["study"]["axes"]["order"] == [0.25, 0.5, 1.0]
    (file,) = whole.glob("*.tasks")
    seen = {}
    for line in file.read_bytes().splitlines():
        word, checksum, body = line.split(b" ", 2)
        assert word == b"springpot-study"
        assert checksum == hashlib.sha256(body).hexdigest()[:32].encode()
        key, _, text = body.partition(b" ")
        seen[key.decode()] = json.loads(text)
    for task in tasks(STUDY):
        row, answer = seen.pop(task.key), compute(task)
        assert (row["method"], row["point"], row["numbers"]) == (task.method, task.point, answer.numbers)
        assert (row["statement"], tuple(row["warnings"])) == (answer.statement, answer.warnings)
        assert dict(named(task, answer.numbers)).keys() >= row["numbers"].keys()
    (labelled,) = seen.values()  # of which results the labelled group is
    assert labelled == {"labelled": status(open_store(whole)).answers}


def test_any_program_sees_a_flipped_byte(copy: Path) -> None:
    (file,) = copy.glob("*.tasks")
    flip(file, 300)
    _, checksum, body = file.read_bytes().splitlines()[0].split(b" ", 2)
    assert checksum != hashlib.sha256(body).hexdigest()[:32].encode()


def flip(file: Path, place: int) -> None:
    body = bytearray(file.read_bytes())
    body[place] ^= 1
    file.write_bytes(body)


def in_line(words: bytes, new: bytes) -> Callable[[Path], object]:
    """Other words in the first line of a result that has these."""

    def damage(store: Path) -> None:
        number, line = next((number, line) for number, line in enumerate(lines(store)) if words in line)
        replaced(store, number, line.replace(words, new, 1) + b"\n")

    return damage


def cut(count: int) -> Callable[[Path], object]:
    """Take so many bytes from the end of the record, without what it says of the labelled group."""

    def damage(store: Path) -> None:
        (file,) = store.glob("*.tasks")
        file.write_bytes((b"\n".join(lines(store)) + b"\n")[:-count])

    return damage


def _of_record(change: Callable[[Path], object]) -> Callable[[Path], object]:
    return lambda store: change(next(store.glob("*.tasks")))


DAMAGE: dict[str, tuple[Callable[[Path], object], int, int]] = {
    "first byte": (_of_record(lambda file: flip(file, 0)), 1, 1),
    "a number": (in_line(b'"x_mean_square": 0.', b'"x_mean_square": 1.'), 1, 1),
    "the name of a number": (in_line(b'"x_mean_square"', b'"y_mean_square"'), 1, 1),
    "checksum": (_of_record(lambda file: flip(file, len("springpot-study ") + 5)), 1, 1),
    "key": (_of_record(lambda file: flip(file, len("springpot-study ") + 32 + 5)), 1, 1),
    "method": (in_line(b'"averaging"', b'"averagimg"'), 1, 1),
    "a letter of a sentence": (in_line(b"The exact", b"The exbct"), 1, 1),
    "the end of a line": (in_line(b"}", b"} "), 1, 1),
    "two lines in one": (lambda store: replaced(store, 0, lines(store)[0]), 1, 2),
    "a line in two": (
        lambda store: replaced(store, 0, lines(store)[0][:99] + b"\n" + lines(store)[0][99:] + b"\n"),
        2,
        1,
    ),
    "last end of a line": (cut(1), 0, 0),
    "one byte short": (cut(2), 0, 1),
    "empty": (_of_record(lambda file: file.write_bytes(b"")), 0, 12),
    "gone": (_of_record(Path.unlink), 0, 12),
    "one byte long": (_of_record(lambda file: file.write_bytes(file.read_bytes() + b"\0")), 0, 0),
    "zeros": (lambda store: replaced(store, 0, bytes(100) + b"\n"), 1, 1),
    "the line of another task": (lambda store: replaced(store, 0, lines(store)[1] + b"\n"), 0, 1),
    "under the key of another task": (lambda store: _swap(store), 1, 1),
}
"""What is done to a store, and how many lines are damaged and how many results are missing then."""


def _swap(store: Path) -> None:
    first, second = (line.split(b" ", 3) for line in lines(store)[:2])
    replaced(store, 0, b" ".join([*first[:2], second[2], first[3]]) + b"\n")


@pytest.mark.parametrize(("damage", "damaged", "missing"), thinned(DAMAGE.values(), 2), ids=DAMAGE)
def test_damage_is_found_and_mended(
    damage: Callable[[Path], object], damaged: int, missing: int, copy: Path, whole: Path
) -> None:
    damage(copy)
    found = status(open_store(copy))
    assert (found.damaged, sum(found.missing.values()), sum(found.done.values())) == (damaged, missing, 12 - missing)
    assert run_study(STUDY, copy, threads=1).computed == missing
    assert content(copy) == content(whole)


def test_deleted_lines_are_missing(copy: Path, whole: Path) -> None:
    for _ in range(3):
        replaced(copy, 0, b"")
    found = status(open_store(copy))
    assert (found.damaged, sum(found.done.values()), sum(found.missing.values())) == (0, 9, 3)
    assert run_study(STUDY, copy, threads=1).computed == 3
    assert content(copy) == content(whole)


def test_every_byte_of_a_line_counts(copy: Path) -> None:
    """Any one bit that flips in the line of an answer is seen, also by who has read it before."""
    store = open_store(copy)
    (file,) = copy.glob("*.tasks")
    first = lines(copy)[0]
    (task,) = (task for task in tasks(STUDY) if task.key.encode() in first)
    right = file.read_bytes()
    assert store.has(task)
    for place in range(len(first)):
        flip(file, place)
        assert not store.has(task)
        file.write_bytes(right)
    assert store.has(task)


@pytest.mark.parametrize(
    "result",
    [3, [], {}, {"numbers": 1}, {"numbers": {"x_mean": "a"}, "statement": "", "warnings": []},
     {"numbers": {}, "statement": "", "warnings": 1}, {"numbers": [1.0], "statement": "", "warnings": []}],
)  # fmt: skip
def test_what_is_no_result_with_a_right_checksum_is_missing(result: object, copy: Path, whole: Path) -> None:
    _, _, key, _ = lines(copy)[0].split(b" ", 3)
    replaced(copy, 0, line_of(stores.KIND, key.decode(), result) + b"\n")
    assert sum(status(open_store(copy)).missing.values()) == 1
    assert run_study(STUDY, copy, threads=1).computed == 1
    assert content(copy) == content(whole)


def test_the_description_is_mended_by_its_own_study_only(copy: Path, whole: Path) -> None:
    """Whichever byte of the description flips, no wrong study is read from it."""
    file = copy / "description"
    right = file.read_bytes()
    for place in range(0, len(right), 3):
        flip(file, place)
        with pytest.raises(ValueError, match=r"damaged|newer") as told:
            open_store(copy)
        assert "\n" not in str(told.value)
        file.write_bytes(right)
    file.write_bytes(right[:100])
    with pytest.raises(StoreError, match=r"springpot study run FILE --store .* writes it again and keeps every result"):
        open_store(copy)
    with pytest.raises(StoreError, match="none of its results belong to 'theory'"):
        open_store(copy, given(THEORY, fixed={"intensity": 2.0}))
    assert run_study(STUDY, copy).computed == 0
    assert content(copy) == content(whole)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"name": "other"}, "name"),
        ({"seed": 2}, "seed"),
        ({"fixed": {"intensity": 2.0}}, "fixed"),
        ({"axes": {"order": [0.25, 0.5, 1.0]}}, "names of axes"),
        ({"axes": {"order": [0.25], "intensity": [1.0]}}, "names of axes"),
        ({"name": "other", "seed": 2}, "name, seed"),
    ],
)
def test_another_study_is_refused(change: dict[str, object], what: str, copy: Path, whole: Path) -> None:
    with pytest.raises(StoreError, match=rf"belongs to another study \('theory'; different: {what}\): only the values"):
        run_study(given(THEORY, **change), copy)
    assert content(copy) == content(whole)


def _describe_otherwise(store: Path, change: Callable[[dict[str, object]], object]) -> None:
    """As a newer version would have written it: with a checksum that is right."""
    ours = open_store(store).described()
    change(ours)
    (store / "description").write_bytes(line_of(stores.KIND, "description", ours))


@pytest.mark.parametrize("use", [open_store, lambda path: run_study(STUDY, path)], ids=["open", "run"])
def test_a_newer_version_is_refused_with_the_reason(use: Callable[[Path], object], copy: Path) -> None:
    def newer_format(ours: dict[str, object]) -> None:
        ours["format"] = 2

    def newer_version(ours: dict[str, object]) -> None:
        ours["versions"] = [{"springpot": "99.1", "numba": "1", "numpy": "3"}]

    for change, says in ((newer_format, "store format 2"), (newer_version, r"springpot 99\.1 \(store format")):
        before = (copy / "description").read_bytes()
        _describe_otherwise(copy, change)
        changed = content(copy)
        with pytest.raises(StoreError, match=rf"was written by .*{says}.*newer than this one .* install that version"):
            use(copy)
        assert content(copy) == changed
        (copy / "description").write_bytes(before)


@pytest.mark.parametrize(
    "version",
    ["9\x1b[2J", validation("9\nspringpot: all is well."), validation("9" * 1000), validation(["9"]), None],
)
def test_a_version_that_is_none_is_damage_and_not_shown(version: object, copy: Path) -> None:
    def hostile(ours: dict[str, object]) -> None:
        ours["format"], ours["versions"] = 99, [{"springpot": version, "numba": "1", "numpy": "3"}]

    whole = content(copy)
    _describe_otherwise(copy, hostile)
    with pytest.raises(StoreError) as caught:
        open_store(copy)
    assert "damaged" in str(caught.value)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500
    run_study(STUDY, copy)
    assert content(copy) == whole


def test_what_is_no_store_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "letter").write_text("mine", encoding="utf-8")
    (tmp_path / "folder" / "description").write_text("mine", encoding="utf-8")
    zarr.create_group(tmp_path / "other.zarr", zarr_format=3)
    for name in ("file", "folder", "other.zarr"):
        before = content(tmp_path)
        for use in (open_store, lambda path: run_study(STUDY, path)):
            with pytest.raises(
                StoreError, match="is not a store of a springpot study: give the folder of a store, or a new"
            ):
                use(tmp_path / name)
        assert content(tmp_path) == before


def test_an_empty_folder_becomes_a_store(tmp_path: Path, whole: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(StoreError, match=r"there is no store .*: springpot study run FILE --store .* creates one"):
        open_store(tmp_path / "empty")
    assert run_study(STUDY, tmp_path / "empty", threads=1).computed == 12
    assert content(tmp_path / "empty") == content(whole)
    assert run_study(STUDY, tmp_path / "a" / "b" / "new.zarr", threads=1).computed == 12


def test_sentences_of_any_length_are_kept(tmp_path: Path) -> None:
    store, task = open_store(tmp_path / "study.zarr", STUDY), next(tasks(STUDY))
    for answer in (
        Answer({"x_mean": 1.0}, "", ("a" * 3000, "b" * 3000)),
        Answer({}, "\N{GREEK SMALL LETTER ALPHA}\n" * 5000, ()),
    ):
        store.write(task, answer)
        assert store.find(task) == open_store(store.path).find(task) == answer


def test_numbers_keep_every_bit(tmp_path: Path) -> None:
    store, task = open_store(tmp_path / "study.zarr", STUDY), next(tasks(STUDY))
    numbers = (0.1, -0.0, 5e-324, math.inf, 1 / 3, 1.7e308, 1e-300, -2.5, 7.0)
    store.write(task, Answer({str(place): number for place, number in enumerate(numbers)}, "", ()))
    found = open_store(store.path).find(task)
    assert found is not None
    assert np.array([*found.numbers.values()]).tobytes() == np.array(numbers).tobytes()


def _orphan(folder: Path, name: str, host: str, process: int, age: float = 0.0) -> Path:
    place = folder / f".{name}.{host}.{process}.{process}"
    place.write_bytes(b"half")
    os.utime(place, (time.time() - age,) * 2)
    return place


def test_orphans_of_the_dead_are_removed_and_those_of_the_living_left(copy: Path, whole: Path) -> None:
    here, day = socket.gethostname(), 86400.0
    dead = [_orphan(copy, name, here, DEAD) for name in ("description", "labelled", "labelled-before")]
    dead += [_orphan(copy, "description", "another.machine", DEAD, age=day)]
    living = [_orphan(copy, name, here, os.getpid()) for name in ("description", "labelled")]
    living += [_orphan(copy, "description", "other.machine", DEAD), copy / ".hidden"]
    living[-1].write_text("somebody else's", encoding="utf-8")
    half_made = copy.parent / f".{copy.name}.{here}.{DEAD}.{DEAD}"
    shutil.copytree(copy, half_made)
    neighbour = copy.parent / f".{copy.name}x.{here}.{DEAD}.{DEAD}"
    neighbour.mkdir()
    assert run_study(STUDY, copy).computed == 0
    assert [place for place in [*dead, half_made] if place.exists()] == []
    assert [place for place in [*living, neighbour] if not place.exists()] == []
    for place in living:
        place.unlink()
    assert content(copy) == content(whole)


WRITER = """
import sys
from springpot.studies.question import read_study
from springpot.studies.store import open_store
from springpot.studies.tasks import compute, tasks
from tests.studies.samples import THEORY
store = open_store(sys.argv[1], read_study(THEORY))
answers = [(task, compute(task)) for task in tasks(store.study)]
print("ready", flush=True)
while True:
    for task, answer in answers:
        store.write(task, answer)
"""


@pytest.mark.parametrize("times", [1, validation(3)])
def test_a_writer_killed_in_the_middle_leaves_whole_files(times: int, copy: Path, whole: Path) -> None:
    """Killed while it does nothing but write: each answer is whole, and at most one partial file stays behind."""
    for number in range(times):
        with subprocess.Popen([sys.executable, "-c", WRITER, str(copy)], stdout=subprocess.PIPE, text=True) as writer:
            assert writer.stdout is not None
            assert writer.stdout.readline() == "ready\n"
            time.sleep(0.01 + 0.0137 * number)
            writer.kill()
        assert sum(status(open_store(copy)).done.values()) == 12
        assert len(orphans(copy)) <= number + 1  # the sum over the three was compared with 3 before
    assert run_study(STUDY, copy).computed == 0
    assert orphans(copy) == []
    assert content(copy) == content(whole)


def test_a_full_disk_loses_nothing(small_disk: Path, whole: Path) -> None:
    path = small_disk / "study.zarr"
    ballast = small_disk / "ballast"
    first = given(THEORY, axes={"order": [0.25], "coefficient": [0.3, 2.0]})
    assert run_study(first, path, threads=1, labelled=False).computed == 4
    fill(ballast)
    says = r"^store '.*' cannot be written \(No space left on device\): all results so far are kept, and running "
    for _ in range(2):
        with pytest.raises(OSError, match=says) as told:
            run_study(STUDY, path, threads=2, labelled=False)
        assert "\n" not in str(told.value)
    assert sum(status(open_store(path)).done.values()) == 4
    assert orphans(path) == []
    with pytest.raises(OSError, match=r"^store '.*new\.zarr' cannot be created \(No space left on device\)\.$"):
        run_study(STUDY, small_disk / "new.zarr")
    assert not (small_disk / "new.zarr").exists()
    ballast.unlink()
    fill(ballast, room=16_384)  # for results, and not for the labelled group
    with pytest.raises(OSError, match=says):
        run_study(STUDY, path, threads=1)
    assert sum(status(open_store(path)).done.values()) > 4
    assert orphans(path) == []
    ballast.unlink()
    assert run_study(STUDY, path, threads=1).labelled
    assert status(open_store(path)).damaged == 0
    assert content(path) == content(whole)


def test_a_disk_that_can_only_be_read(small_disk: Path) -> None:
    path = small_disk / "study.zarr"
    first = given(THEORY, axes={"order": [0.25], "coefficient": [0.3, 2.0]})
    assert run_study(first, path).computed == 4
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    before = content(path)
    assert run_study(first, path).found == 4  # nothing to do, nothing to write
    with pytest.raises(OSError, match=r"^store '.*' cannot be written \(Read-only file system\): all results so"):
        run_study(STUDY, path)
    with pytest.raises(OSError, match=r"^store '.*' cannot be created \(Read-only file system\)\.$"):
        run_study(STUDY, small_disk / "new.zarr")
    assert content(path) == before
    assert sum(status(open_store(path)).done.values()) == 4


LIMITED = """
import resource, sys
from springpot.studies import read_study, run_study
from tests.studies.samples import THEORY
wider = read_study({**THEORY, "axes": {"order": [0.25, 0.3, 0.4, 0.45], "coefficient": [0.3, 2.0]}})
run_study(wider, sys.argv[1], threads=1, shard=(1, 16), labelled=False)  # what is needed for it is loaded
sys.dont_write_bytecode = True  # Python would keep files of bytecode that are cut off
resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))
try:
    run_study(wider, sys.argv[1], threads=1, labelled=False)
except OSError as error:
    print(error)
"""


@pytest.mark.validation
def test_a_limit_on_files_loses_nothing(copy: Path) -> None:
    """For machines on which nothing can be mounted: all lines are longer than the limit together, each is shorter."""
    resource = pytest.importorskip("resource", reason="limits of a process are those of Unix")
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[1] == resource.RLIM_INFINITY
    done = subprocess.run([sys.executable, "-c", LIMITED, str(copy)], capture_output=True, text=True, timeout=120)
    assert done.stdout.startswith(f"store {str(copy)!r} cannot be written (File too large): all results"), done
    found = status(open_store(copy))
    assert found.damaged == 0
    assert 5 < sum(found.done.values()) < 16
    assert orphans(copy) == []


def test_a_store_that_vanishes_while_it_is_written(copy: Path) -> None:
    store = open_store(copy)
    task: Task = next(tasks(STUDY))
    answer = store.find(task)
    assert answer is not None
    shutil.rmtree(copy)
    with pytest.raises(OSError, match=r"cannot be written \(No such file or directory\)"):
        store.write(task, answer)
    assert not copy.exists()


def test_a_partial_file_that_another_took_for_an_orphan(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Containers of one name do not see each other's processes: the file is written once more."""
    wider = given(THEORY, axes={"order": [0.25, 0.5, 1.0], "coefficient": [0.3, 2.0, 3.0]})
    replace, times = os.replace, 0

    def robbed(source: str, target: str) -> None:
        nonlocal times
        times += 1
        if times == 1:
            os.unlink(source)
        replace(source, target)

    monkeypatch.setattr(os, "replace", robbed)
    open_store(copy, wider)
    assert open_store(copy).study == wider
    assert times == 2
    assert orphans(copy) == []


def _replace(place: Path, make: Callable[[Path], object]) -> None:
    shutil.rmtree(place) if place.is_dir() else place.unlink()
    make(place)


@pytest.mark.parametrize("make", [validation(Path.mkdir), make_pipe, lambda place: link(place, place)])
def test_what_is_no_file_is_replaced(make: Callable[[Path], object], copy: Path, whole: Path) -> None:
    for place in (copy / "description", *copy.glob("*.tasks")):
        _replace(place, make)
        run_study(STUDY, copy, threads=1)
        assert content(copy) == content(whole)
    (copy / "description").unlink()
    (copy / "description").write_text("[" * 100_000, encoding="utf-8")
    with pytest.raises(StoreError, match="is damaged: springpot study run FILE"):
        open_store(copy)
