"""The file of repetitions: whatever happened to it, what is read is what would be computed, or it is refused."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import FileError
from springpot.machine.files import append_line
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.rare.saved import SavedFile
from springpot.simulation.rare.splitting import Tally

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
    ("of", 1), ("of", [1, 1, 2, 0]), ("of", [1, True, 2]), ("of", [1, True, 2, -1]), ("of", [1, True, 2, 2**80]),
    ("of", [1.0, True, 2, 0]), ("key", 3), ("key", None), ("exceeded", "x"), ("exceeded", None), ("exceeded", []),
    ("exceeded", [[[0.1]]]), ("exceeded", [[[0.1], [float("nan")]]]), ("exceeded", {"a": 1}),
    ("exceeded", [[[0.1], [1e308]]]), ("exceeded", [[[0.1], [-0.1]]]), ("exceeded", [[[1, 2], [3]]]),
    ("exceeded", [[[True], [True]]]), ("weights", [[0.1]]), ("weights", [10**400]), ("weights", [2.0]),
    ("reached", [float("nan")]), ("iterations", [-1]), ("iterations", [1e300]), ("iterations", ["1"]),
    ("ends", [[1.0]]), ("ends", "abc"), ("ends", [[0.0] * 10**5]), ("path_steps", "many"), ("path_steps", float("inf")),
    ("path_steps", -1.0), ("path_steps", 10**400), ("path_steps", [1.0]), ("path_steps", None),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value"), WRONG)
def test_wrong_kinds_with_a_right_checksum_are_no_repetition(tmp_path: Path, name: str, value: Any) -> None:
    place = tmp_path / "file"
    first, second = written(place, 2).splitlines()
    own = json.loads(first.split(b" ", 2)[2])
    body = json.dumps(own | {name: value}).encode()
    checksum = hashlib.sha256(body).hexdigest()[:32].encode()
    place.write_bytes(b"exceedance " + checksum + b" " + body + b"\n" + second + b"\n")
    found = read(place)
    assert [*found] == [1]
    assert same(found[1], tally(1))


@pytest.mark.parametrize("body", [b"[" * 100_000, b"3", b"{}", b'"key"', b"NaN", b"9" * 5000, b"\xff\xfe", b'{"key":'])
def test_what_is_no_repetition_with_a_right_checksum_is_left_alone(tmp_path: Path, body: bytes) -> None:
    place = tmp_path / "file"
    whole = written(place, 1)
    checksum = hashlib.sha256(body).hexdigest()[:32].encode()
    place.write_bytes(whole + b"exceedance " + checksum + b" " + body + b"\n")
    found = read(place)
    assert [*found] == [0]


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


def test_a_file_without_checksums_is_said_to_be_one(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b'{"key": "abc", "of": [0, false, 64, 0]}\n')
    with pytest.raises(FileError, match=r"springpot 0\.2 wrote it, without checksums\.$"):
        SavedFile(tmp_path / "file")


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    """A pipe is not waited for, and a device is not read without end."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
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


@pytest.mark.skipif(os.geteuid() == 0, reason="the administrator may read and write everything")
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
    import springpot.simulation.rare.saved as module

    def until_full(path: Path, line: bytes) -> None:
        nonlocal limit
        limit -= 1
        append_line(path if limit >= 0 else Path("/dev/full"), line)

    whole = sp.exceedance(LIGHT, {"x": 1.0}, **SHORT)
    monkeypatch.setattr(module, "append_line", until_full)
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


KILLED = """
import sys, springpot as sp
light = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.1), sp.Barrier(-50.0), sp.WhiteNoise(0.2))
sp.exceedance(light, {"x": 5.0}, duration=40.0, step=0.02, start="rest", rtol=0.02, threads=1, save=sys.argv[1])
"""


def test_a_kill_leaves_whole_repetitions(tmp_path: Path) -> None:
    """SIGKILL, when some are there: all lines but the last are whole."""
    place = tmp_path / "file"
    process = subprocess.Popen([sys.executable, "-c", KILLED, str(place)])
    try:
        until = time.monotonic() + 120.0
        while not place.exists() or place.read_bytes().count(b"\n") < 40:
            assert time.monotonic() < until
            assert process.poll() is None
            time.sleep(0.02)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    lines = place.read_bytes().split(b"\n")[:-1]
    assert len(lines) >= 40
    assert all(hashlib.sha256(line[44:]).hexdigest()[:32].encode() == line[11:43] for line in lines)
