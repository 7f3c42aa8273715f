"""The file of repetitions: whatever happened to it, what is read is what would be computed, or it is refused."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine import record
from springpot.machine.faults import FileError
from springpot.machine.files import append_line
from springpot.machine.record import line_of, parts_of
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.rare.saved import SavedFile
from springpot.simulation.rare.splitting import Tally
from tests.kills import fill, kill_when, lines_in
from tests.posix import link, make_pipe
from tests.sizes import validation
from tests.strangers import needs_limits

LIGHT = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.1), sp.Barrier(-50.0), sp.WhiteNoise(0.2))
SHORT: dict[str, Any] = {"duration": 5.0, "step": 0.1, "start": "rest", "rtol": 0.5, "threads": 1}
LEVELS, PATHS = 1, 2
CONTENT = ["a call"]


def tally(number: int) -> Tally:
    generator = np.random.default_rng(number)
    ends = generator.normal(size=(PATHS, MARKS)) if number % 2 else np.zeros((0, MARKS))
    reached = np.array([-np.inf if number % 2 else 3.25])
    return Tally(
        generator.random((1, 2, LEVELS)), generator.random(1), reached, np.array([number]), 1e3 + number, True, ends
    )


def of(number: int) -> tuple[int, bool, int, int]:
    return 1, number % 2 == 0, PATHS, number


def written(place: Path, count: int = 4) -> bytes:
    saved = SavedFile(place).of(CONTENT, LEVELS)
    for number in range(count):
        saved.add(tally(number), *of(number))
    return place.read_bytes()


def same(one: Tally, other: Tally) -> bool:
    names = ("exceeded", "weights", "reached", "iterations", "ends")
    return one.path_steps == other.path_steps and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in names
    )


def read(place: Path) -> dict[int, Tally]:
    """The repetitions that are there."""
    saved = SavedFile(place).of(CONTENT, LEVELS)
    return {n: found for n in range(8) if (found := saved.find(*of(n))) is not None}


def test_what_is_written_is_read_to_the_last_bit(tmp_path: Path) -> None:
    written(tmp_path / "file")
    found = read(tmp_path / "file")
    assert all(same(found[n], tally(n)) for n in range(4))
    assert SavedFile(tmp_path / "file").of(["another call"], LEVELS).find(*of(0)) is None


def test_a_damaged_byte_costs_one_repetition_and_gives_no_wrong_one(tmp_path: Path) -> None:
    """At each place."""
    place = tmp_path / "file"
    whole = written(place, 2)
    for at in range(len(whole)):
        damaged = bytearray(whole)
        damaged[at] ^= 1 if at % 2 else 64
        place.write_bytes(damaged)
        found = read(place)
        assert found or whole[at] == ord("\n"), at
        assert all(same(own, tally(n)) for n, own in found.items()), at


def test_a_file_that_was_cut_has_what_is_whole(tmp_path: Path) -> None:
    place = tmp_path / "file"
    whole = written(place, 3)
    ends = np.cumsum([len(line) for line in whole.splitlines(keepends=True)])
    for at in range(0, len(whole), 7):
        place.write_bytes(whole[:at])
        found = read(place)
        assert len(found) == np.count_nonzero(ends - 1 <= at), at  # the last end of a line may be missing
        again = SavedFile(place).of(CONTENT, LEVELS)
        again.add(tally(3), *of(3))
        assert same(read(place)[3], tally(3)), at


WRONG: list[tuple[str, Any]] = [
    ("exceeded", "x"), ("exceeded", None), ("exceeded", []),
    ("exceeded", [[[0.1]]]), ("exceeded", [[[0.1], [float("nan")]]]), ("exceeded", {"a": 1}),
    ("exceeded", [[[0.1], [1e308]]]), ("exceeded", [[[0.1], [-0.1]]]), ("exceeded", [[[1, 2], [3]]]),
    ("exceeded", [[[True], [True]]]), ("weights", [[0.1]]), ("weights", [10**400]), ("weights", [2.0]),
    ("reached", [float("nan")]), ("iterations", [-1]), ("iterations", [1e300]), ("iterations", ["1"]),
    ("ends", [[1.0]]), ("ends", "abc"), ("ends", [[0.0] * 10**5]), ("path_steps", "many"), ("path_steps", float("inf")),
    ("path_steps", -1.0), ("path_steps", 10**400), ("path_steps", [1.0]), ("path_steps", None),
]  # fmt: skip


def parts(line: bytes) -> tuple[str, bytes]:
    found = parts_of("exceedance", line)
    assert found is not None
    return found


@pytest.mark.parametrize(("name", "value"), WRONG)
def test_wrong_kinds_with_a_right_checksum_are_no_repetition(tmp_path: Path, name: str, value: Any) -> None:
    place = tmp_path / "file"
    first, second = written(place, 2).splitlines()
    key, own = parts(first)
    place.write_bytes(line_of("exceedance", key, json.loads(own) | {name: value}) + b"\n" + second + b"\n")
    found = read(place)
    assert [*found] == [1]
    assert same(found[1], tally(1))


def test_a_repetition_under_the_key_of_another_one_is_not_read_as_that(tmp_path: Path) -> None:
    """Kinds and numbers that a key may not have are other keys, for it is a digest of them."""
    place = tmp_path / "file"
    written(place, 1)
    saved = SavedFile(place).of(CONTENT, LEVELS)
    assert saved.find(*of(0)) is not None
    for other in ((1, 1, PATHS, 0), (1, True, PATHS, -1), (1.0, True, PATHS, 0), (1, True, PATHS, 2**80)):
        assert saved.find(*other) is None


@pytest.mark.parametrize("body", [b"[" * 100_000, b"3", b"{}", b'"key"', b"NaN", b"9" * 5000, b"\xff\xfe", b'{"key":'])
def test_what_is_no_repetition_with_a_right_checksum_is_left_alone(tmp_path: Path, body: bytes) -> None:
    place = tmp_path / "file"
    first, second = written(place, 2).splitlines()
    rest = parts(first)[0].encode() + b" " + body
    checksum = hashlib.sha256(rest).hexdigest()[:32].encode()
    place.write_bytes(b"exceedance " + checksum + b" " + rest + b"\n" + second + b"\n")
    assert [*read(place)] == [1]


@pytest.mark.parametrize(
    "content",
    [
        b"something else\n", b"\x00" * 5000, b"\xff" * 100, b"{}\n", b"[1, 2]\n", b"x = 1\ny = 2\n", b"9" * 10_000,
        b'{"key": "abc", "of": [0, false, 64, 0]}\n', b"exceedancf 1\n",
    ],
)  # fmt: skip
def test_a_file_of_something_else_is_refused_and_stays(tmp_path: Path, content: bytes) -> None:
    place = tmp_path / "file"
    place.write_bytes(content)
    with pytest.raises(FileError, match="save must be a file of exceedance or a new one, and"):
        sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=place)
    assert place.read_bytes() == content


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    """A pipe is not waited for, and a device is not read without end."""
    make_pipe(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    link(tmp_path / "loop", tmp_path / "loop")
    begun = time.monotonic()
    for place, reason in (
        ("/dev/zero", "it is not a file, but a pipe or a device"),
        (tmp_path / "pipe", "it is not a file, but a pipe or a device"),
        (tmp_path / "folder", "it is a folder, not a file"),
        (tmp_path / "loop", "it is a link that leads back to itself"),
    ):
        with pytest.raises(FileError) as fault:
            sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=place)
        assert str(fault.value) == f"save {str(place)!r} cannot be read: {reason}."
    assert time.monotonic() - begun < 5.0


@pytest.mark.parametrize("name", ["a\0b", "a\ud800"])
def test_what_is_no_name_is_said(name: str) -> None:
    with pytest.raises(ValueError, match=r"^save must be the place of a file, and "):
        sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=name)


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    place = tmp_path / "file"
    with place.open("wb") as file:
        file.truncate(2**40)  # a hole
    with pytest.raises(FileError, match="it has more than 1,073,741,824 bytes"):
        sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=place)


@needs_limits
def test_a_file_that_cannot_be_read_or_written_is_refused_before_the_work(tmp_path: Path) -> None:
    place = tmp_path / "file"
    written(place)
    for mode, what in ((0o000, "read"), (0o400, "written")):
        place.chmod(mode)
        with pytest.raises(FileError, match=f"cannot be {what}: permission denied"):
            SavedFile(place)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has it")
def test_a_full_disk_ends_no_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was computed is the result, and what had been written can be read."""
    place, limit = tmp_path / "file", 3

    def until_full(path: Path, line: bytes) -> int:
        nonlocal limit
        limit -= 1
        return append_line(path if limit >= 0 else Path("/dev/full"), line)

    whole = sp.exceedance(LIGHT, {"x": 1.0}, **SHORT)
    monkeypatch.setattr(record, "append_line", until_full)
    with pytest.warns(sp.RareEventWarning, match="could not be written any more"):
        found = sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=place)
    assert found.probability["x"] == whole.probability["x"]
    assert [message.name for message in found.warnings] == ["not_saved"]
    monkeypatch.undo()
    assert sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=place).probability["x"] == whole.probability["x"]


def test_a_damaged_file_gives_the_right_probability(tmp_path: Path) -> None:
    """One digit made .0655 into .182."""
    place = tmp_path / "file"
    whole = sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=place)
    content = place.read_bytes()
    at = content.index(b'"exceeded": [[[') + len(b'"exceeded": [[[') + 2
    place.write_bytes(content[:at] + b"9" + content[at + 1 :])
    again = sp.exceedance(LIGHT, {"x": 1.0}, **SHORT, save=place)
    assert again.probability["x"] == whole.probability["x"]


CALL = """
import sys, springpot as sp
light = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.1), sp.Barrier(-50.0), sp.WhiteNoise(0.2))
found = sp.exceedance(light, {"x": 5.0}, duration=20.0, step=0.05, start="rest", rtol=0.2, threads=1, save=sys.argv[1])
print(found["x"].probability, found["x"].error)
"""
QUICK = [sys.executable, "-c", CALL]


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, int]:
    """What the call says, and how many repetitions it writes."""
    place = tmp_path_factory.mktemp("whole") / "file"
    return subprocess.run([*QUICK, place], capture_output=True, text=True, check=True).stdout, lines_in(place)


@pytest.mark.validation  # every day: cut at three places, in test_exceedance.py; kills in machine/
@pytest.mark.parametrize("share", [0.3, validation(0.05), validation(0.6)])
def test_a_killed_call_goes_on_to_the_same_bits(share: float, tmp_path: Path, uninterrupted: tuple[str, int]) -> None:
    """SIGKILL; all that had ended is read, and no line but the last is not whole."""
    said, whole = uninterrupted
    place, count = tmp_path / "file", int(share * whole)
    kill_when([*QUICK, place], lambda: lines_in(place) >= count)
    lines = place.read_bytes().split(b"\n")[:-1]
    assert count <= len(lines) < whole
    assert all(parts_of("exceedance", line) for line in lines)
    done = subprocess.run([*QUICK, place], capture_output=True, text=True, check=True)
    assert done.stdout == said
    assert lines_in(place) - whole in (0, 1)  # one that was begun may stand between


@pytest.mark.validation  # every day: two processes on any record, in machine/
def test_two_calls_at_once_share_a_file_and_say_the_same(tmp_path: Path, uninterrupted: tuple[str, int]) -> None:
    place = tmp_path / "file"
    two = [subprocess.Popen([*QUICK, place], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert [process.communicate()[0] for process in two] == [uninterrupted[0]] * 2
    assert all(parts_of("exceedance", line) for line in place.read_bytes().splitlines())
    again = subprocess.run([*QUICK, place], capture_output=True, text=True, check=True)
    assert again.stdout == uninterrupted[0]


@pytest.mark.validation  # every day: a full disk ends no run, above
def test_a_disk_that_becomes_full_ends_no_call(small_disk: Path, uninterrupted: tuple[str, int]) -> None:
    place = small_disk / "file"
    fill(small_disk / "ballast", room=20_000)
    done = subprocess.run([*QUICK, place], capture_output=True, text=True, check=True)
    assert done.stdout == uninterrupted[0]
    assert "could not be written any more (no space left on device)" in done.stderr
    assert 0 < lines_in(place) < uninterrupted[1]
    (small_disk / "ballast").unlink()
    again = subprocess.run([*QUICK, place], capture_output=True, text=True, check=True)
    assert (again.stdout, again.stderr) == (uninterrupted[0], "")
