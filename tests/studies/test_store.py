"""The store: what other Zarr readers see, every kind of damage found and mended, and no store ever half-made."""

from __future__ import annotations

import asyncio
import json
import math
import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import zarr
from zarr.codecs import BytesCodec, Crc32cCodec

from springpot.studies import layout
from springpot.studies import store as stores
from springpot.studies.columns import columns_of
from springpot.studies.labelled import status
from springpot.studies.running import run_study
from springpot.studies.store import Store, StoreError, open_store
from springpot.studies.tasks import SENTENCES, SLOTS, Answer, Task, compute, tasks
from tests.sizes import thinned, validation
from tests.studies.samples import THEORY, chunks, content, given, named, orphans

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


def test_a_zarr_reader_sees_the_numbers(whole: Path) -> None:
    root = zarr.open_group(whole, mode="r", use_consolidated=False)
    seen = root.attrs["springpot_study"]
    assert seen["study"]["axes"]["order"] == [0.25, 0.5, 1.0]
    assert root.attrs["title"] == "theory"
    for task in tasks(STUDY):
        numbers = root[f"theory/{task.method}/numbers"]
        row = np.asarray(numbers[task.slot])
        answer = compute(task)
        names = [name for name, _ in named(task, answer.numbers)]
        assert numbers.attrs["columns"] == ["task", "sentences_length", *names]
        assert numbers.attrs["units"][2:4] == ["m2", "m"]
        np.testing.assert_array_equal(row[2:], answer.numbers)
        text = bytes(np.asarray(root[f"theory/{task.method}/sentences"][task.slot])[: int(row[1])])
        if answer.statement or answer.warnings:
            said = json.loads(text)
            assert (said["statement"], tuple(said["warnings"])) == (answer.statement, answer.warnings)
        else:
            assert text == b""
        assert np.all(np.isnan(np.asarray(numbers[task.slot + 1])))  # never written


def test_a_zarr_reader_sees_a_flipped_byte(copy: Path) -> None:
    task = next(tasks(STUDY))
    flip(copy / f"theory/averaging/numbers/{task.slot}.0", 30)
    with pytest.raises(ValueError, match=r"(?i)checksum"):
        zarr.open_group(copy, mode="r", use_consolidated=False)["theory/averaging/numbers"][task.slot]


def test_every_chunk_is_one_tasks_and_has_a_checksum(whole: Path) -> None:
    """The metadata are those of Zarr itself: no other reader needs springpot to decode a chunk."""
    root = zarr.open_group(whole, mode="r", use_consolidated=False)
    widths = {"numbers": 2 + len(columns_of("exact", STUDY.system)), "sentences": SENTENCES}
    for method in STUDY.methods:
        for name, width in widths.items():
            array = root[f"theory/{method}/{name}"]
            assert isinstance(array, zarr.Array)
            assert (array.shape, array.chunks) == ((SLOTS, width), (1, width))
            assert array.dtype == {"numbers": np.dtype("<f8"), "sentences": np.dtype("u1")}[name]
            assert [type(codec) for codec in array.metadata.codecs] == [BytesCodec, Crc32cCodec]
            assert array.metadata.dimension_names == ("slot", {"numbers": "column", "sentences": "byte"}[name])


def flip(file: Path, place: int) -> None:
    body = bytearray(file.read_bytes())
    body[place] ^= 1
    file.write_bytes(body)


def _with_sentences(store: Path) -> Path:
    return chunks(store, "sentences")[0]


def _swap(store: Path) -> None:
    first, second = chunks(store)[:2]
    shutil.copy(first, second)


def _swap_sentences(store: Path) -> None:
    """All of exact's statements are equal and so are their lengths: only their owner differs."""
    first, second = chunks(store / "theory/exact", "sentences")[:2]
    shutil.copy(first, second)


DAMAGE: dict[str, Callable[[Path], object]] = {
    "first byte": lambda store: flip(chunks(store)[0], 0),
    "a number": lambda store: flip(chunks(store)[1], 8 * 2 + 3),
    "length of the sentences": lambda store: flip(chunks(store)[0], 15),
    "checksum": lambda store: flip(chunks(store)[2], -1),
    "one byte short": lambda store: os.truncate(chunks(store)[0], chunks(store)[0].stat().st_size - 1),
    "empty": lambda store: chunks(store)[0].write_bytes(b""),
    "one byte long": lambda store: chunks(store)[0].write_bytes(chunks(store)[0].read_bytes() + b"\0"),
    "zeros": lambda store: chunks(store)[0].write_bytes(bytes(chunks(store)[0].stat().st_size)),
    "the chunk of another task": _swap,
    "a byte of the sentences": lambda store: flip(_with_sentences(store), 5),
    "a byte of the padding": lambda store: flip(_with_sentences(store), SENTENCES - 1),
    "sentences cut off": lambda store: os.truncate(_with_sentences(store), 100),
    "sentences deleted": lambda store: _with_sentences(store).unlink(),
    "sentences of another task": _swap_sentences,
}


@pytest.mark.parametrize("damage", thinned(DAMAGE.values(), 2), ids=DAMAGE)
def test_damage_is_found_and_mended(damage: Callable[[Path], object], copy: Path, whole: Path) -> None:
    damage(copy)
    found = status(open_store(copy))
    assert (sum(found.damaged.values()), sum(found.done.values()), sum(found.missing.values())) == (1, 11, 0)
    assert run_study(STUDY, copy, threads=1).computed == 1
    assert content(copy) == content(whole)


def test_deleted_chunks_are_missing(copy: Path, whole: Path) -> None:
    for chunk in chunks(copy)[:3]:
        chunk.unlink()
    found = status(open_store(copy))
    assert (sum(found.damaged.values()), sum(found.done.values()), sum(found.missing.values())) == (0, 9, 3)
    assert run_study(STUDY, copy, threads=1).computed == 3
    assert content(copy) == content(whole)


def test_every_byte_of_a_chunk_counts(copy: Path) -> None:
    """Any one bit that flips in the file of an answer is seen."""
    store, task = open_store(copy), next(tasks(STUDY))
    file = copy / f"theory/averaging/numbers/{task.slot}.0"
    right = file.read_bytes()
    for place in range(len(right)):
        flip(file, place)
        assert not store.has(task)
        file.write_bytes(right)
    assert store.has(task)


@pytest.mark.parametrize("place", ["theory", "theory/averaging", "theory/exact/numbers", "theory/exact/sentences"])
def test_metadata_of_groups_and_arrays_are_mended(place: str, copy: Path, whole: Path) -> None:
    file = copy / place / "zarr.json"
    flip(file, file.read_bytes().index(b"3"))
    assert open_store(copy).damaged_metadata() == [f"{place}/zarr.json"]
    assert run_study(STUDY, copy).computed == 0
    file.unlink()
    assert open_store(copy).damaged_metadata() == [f"{place}/zarr.json"]
    assert run_study(STUDY, copy).computed == 0
    assert content(copy) == content(whole)


def test_the_description_is_mended_by_its_own_study_only(copy: Path, whole: Path) -> None:
    """Whichever byte of the root's metadata flips, no wrong study is read from it."""
    file = copy / "zarr.json"
    right = file.read_bytes()
    listed = right.index(b"consolidated_metadata")  # what follows is not the study's: see test_labelled.py
    for place in range(0, listed, 3):
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


def _change_root(store: Path, change: Callable[[dict[str, object]], object]) -> None:
    """As a newer version would have written it: with a checksum that is right."""
    root = json.loads((store / "zarr.json").read_text())
    ours = root["attributes"]["springpot_study"]
    change(ours)
    (store / "zarr.json").write_bytes(stores.root_of(ours))


@pytest.mark.parametrize("use", [open_store, lambda path: run_study(STUDY, path)], ids=["open", "run"])
def test_a_newer_version_is_refused_with_the_reason(use: Callable[[Path], object], copy: Path) -> None:
    def newer_format(ours: dict[str, object]) -> None:
        ours["format"] = 2

    def newer_version(ours: dict[str, object]) -> None:
        ours["versions"] = [{"springpot": "99.1", "numba": "1", "numpy": "3"}]

    for change, says in ((newer_format, "store format 2"), (newer_version, r"springpot 99\.1 \(store format")):
        before = (copy / "zarr.json").read_bytes()
        _change_root(copy, change)
        changed = content(copy)
        with pytest.raises(StoreError, match=rf"was written by .*{says}.*newer than this one .* install that version"):
            use(copy)
        assert content(copy) == changed
        (copy / "zarr.json").write_bytes(before)


@pytest.mark.parametrize(
    "version",
    ["9\x1b[2J", validation("9\nspringpot: all is well."), validation("9" * 1000), validation(["9"]), None],
)
def test_a_version_that_is_none_is_damage_and_not_shown(version: object, copy: Path) -> None:
    def hostile(ours: dict[str, object]) -> None:
        ours["format"], ours["versions"] = 99, [{"springpot": version, "numba": "1", "numpy": "3"}]

    whole = content(copy)
    _change_root(copy, hostile)
    with pytest.raises(StoreError) as caught:
        open_store(copy)
    assert "damaged" in str(caught.value)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500
    run_study(STUDY, copy)
    assert content(copy) == whole


def test_what_is_no_store_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "letter").write_text("mine")
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


def test_sentences_that_do_not_fit_are_shortened(tmp_path: Path) -> None:
    store, task = open_store(tmp_path / "study.zarr", STUDY), next(tasks(STUDY))
    numbers = (1.0,) * len(columns_of(task.method, task.base))
    store.write(task, Answer(numbers, "", ("a" * 3000, "b" * 3000)))
    assert store.read(task) == Answer(numbers, "", ("a" * 3000,))
    store.write(task, Answer(numbers, "\N{GREEK SMALL LETTER ALPHA}" * 5000, ()))
    found = store.read(task)
    assert found is not None
    assert set(found.statement) == {"\N{GREEK SMALL LETTER ALPHA}"}
    assert len(found.statement) == 600


def test_numbers_keep_every_bit(tmp_path: Path) -> None:
    store, task = open_store(tmp_path / "study.zarr", STUDY), next(tasks(STUDY))
    numbers = (0.1, -0.0, 5e-324, math.inf, math.nan, 1 / 3, 1.7e308, 1e-300, -2.5, 7.0)
    store.write(task, Answer(numbers, "", ()))
    found = store.read(task)
    assert found is not None
    assert np.array(found.numbers).tobytes() == np.array(numbers).tobytes()


def _orphan(folder: Path, name: str, host: str, process: int, age: float = 0.0) -> Path:
    place = folder / f".{name}.{host}.{process}.{process}"
    place.write_bytes(b"half")
    os.utime(place, (time.time() - age,) * 2)
    return place


def test_orphans_of_the_dead_are_removed_and_those_of_the_living_left(copy: Path, whole: Path) -> None:
    here, day = socket.gethostname(), 86400.0
    arrays = [copy / "theory/averaging/numbers", copy / "theory/exact/sentences"]
    dead = [_orphan(folder, "123.0", here, DEAD) for folder in arrays]
    dead += [_orphan(copy, "zarr.json", here, DEAD), _orphan(copy / "theory", "zarr.json", here, DEAD)]
    dead += [_orphan(arrays[0], "124.0", "another.machine", DEAD, age=day)]
    living = [_orphan(folder, "123.0", here, os.getpid()) for folder in arrays]
    living += [_orphan(arrays[0], "125.0", "another.machine", DEAD), copy / "theory/.hidden"]
    living[-1].write_text("somebody else's")
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
            writer.send_signal(signal.SIGKILL)
        assert sum(status(open_store(copy)).done.values()) == 12
        assert len(orphans(copy)) <= number + 1  # the sum over the three was compared with 3 before
    assert run_study(STUDY, copy).computed == 0
    assert orphans(copy) == []
    assert content(copy) == content(whole)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of its own of 768 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = shutil.which("mount")
    if mount is None or os.geteuid() != 0:
        pytest.skip("only root may mount a file system")
    done = subprocess.run([mount, "-t", "tmpfs", "-o", "size=768k", "none", folder], capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"mounting is refused here: {done.stderr.strip()}")
    yield folder
    subprocess.run(["umount", folder], check=True)


def _fill(file: Path) -> None:
    with file.open("wb", buffering=0) as out:
        while True:
            out.write(bytes(4096))


def test_a_full_disk_loses_nothing(small_disk: Path, whole: Path) -> None:
    path = small_disk / "study.zarr"
    ballast = small_disk / "ballast"
    first = given(THEORY, axes={"order": [0.25], "coefficient": [0.3, 2.0]})
    assert run_study(first, path, threads=1).computed == 4
    with pytest.raises(OSError, match="No space left"):
        _fill(ballast)
    says = r"^store '.*' cannot be written \(No space left on device\): all results so far are kept, and running "
    for _ in range(2):
        with pytest.raises(OSError, match=says) as told:
            run_study(STUDY, path, threads=2)
        assert "\n" not in str(told.value)
    assert sum(status(open_store(path)).done.values()) == 4
    assert orphans(path) == []
    with pytest.raises(OSError, match=r"^store '.*new\.zarr' cannot be created \(No space left on device\)\.$"):
        run_study(STUDY, small_disk / "new.zarr")
    assert not (small_disk / "new.zarr").exists()
    ballast.unlink()
    assert run_study(STUDY, path, threads=1).computed == 8
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
run_study(read_study(THEORY), sys.argv[1], threads=1)  # what is needed for it is loaded
sys.dont_write_bytecode = True  # Python would keep files of bytecode that are cut off
resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))
try:
    run_study(read_study({**THEORY, "axes": {"order": [0.25, 0.3], "coefficient": [0.3, 2.0]}}), sys.argv[1], threads=1)
except OSError as error:
    print(error)
"""


@pytest.mark.validation
def test_a_limit_on_files_loses_nothing(copy: Path) -> None:
    """For machines on which nothing can be mounted: sentences are larger than the limit, numbers are not."""
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[1] == resource.RLIM_INFINITY
    done = subprocess.run([sys.executable, "-c", LIMITED, str(copy)], capture_output=True, text=True, timeout=120)
    assert done.stdout.startswith(f"store {str(copy)!r} cannot be written (File too large): all results"), done
    found = status(open_store(copy))
    assert sum(found.damaged.values()) == 0
    assert sum(found.done.values()) >= 4
    assert orphans(copy) == []


def test_files_are_written_whole_whether_zarr_waits_for_them_or_not(tmp_path: Path) -> None:
    """Zarr's versions differ in which of the two they call: both are ours."""
    files, prototype = layout._Files(tmp_path, {"zarr.json": b"known"}), zarr.buffer.default_buffer_prototype()
    os.mkfifo(tmp_path / "old")
    os.mkfifo(tmp_path / "new")
    asyncio.run(files.set("old", prototype.buffer.from_bytes(b"one")))
    files.set_sync("new", prototype.buffer.from_bytes(b"two"))
    assert content(tmp_path) == {"new": b"two", "old": b"one"}
    (tmp_path / "zarr.json").write_bytes(b"damaged")
    for name, expected in (("old", b"one"), ("new", b"two"), ("zarr.json", b"known"), ("none", None)):
        for found in (asyncio.run(files.get(name, prototype)), files.get_sync(name)):
            assert (None if found is None else found.to_bytes()) == expected


def test_a_store_that_vanishes_while_it_is_written(copy: Path) -> None:
    store = open_store(copy)
    task: Task = next(tasks(STUDY))
    answer = store.read(task)
    assert answer is not None
    shutil.rmtree(copy)
    with pytest.raises(OSError, match=r"cannot be written \(No such file or directory\)"):
        store.write(task, answer)
    assert not copy.exists()


def test_a_partial_file_that_another_took_for_an_orphan(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Containers of one name do not see each other's processes: the file is written once more."""
    store: Store = open_store(copy)
    task = next(tasks(STUDY))
    answer = store.read(task)
    assert answer is not None
    replace, times = os.replace, 0

    def robbed(source: str, target: str) -> None:
        nonlocal times
        times += 1
        if times == 1:
            os.unlink(source)
        replace(source, target)

    monkeypatch.setattr(os, "replace", robbed)
    store.write(task, answer)
    assert store.read(task) == answer
    assert times >= 2
    assert orphans(copy) == []


def _replace(place: Path, make: Callable[[Path], object]) -> None:
    shutil.rmtree(place) if place.is_dir() else place.unlink()
    make(place)


@pytest.mark.parametrize("make", [validation(Path.mkdir), os.mkfifo, lambda place: place.symlink_to(place)])
def test_what_is_no_file_is_replaced(make: Callable[[Path], object], copy: Path, whole: Path) -> None:
    task = next(tasks(STUDY))
    for place in (f"theory/averaging/numbers/{task.slot}.0", "theory/averaging/numbers/zarr.json", "zarr.json"):
        _replace(copy / place, make)
        run_study(STUDY, copy, threads=1)
        assert content(copy) == content(whole)
    (copy / "zarr.json").write_text("[" * 100_000)
    with pytest.raises(StoreError, match="is damaged: springpot study run FILE"):
        open_store(copy)
