"""The record of finished tasks: what is read is what was written, whoever wrote it and however it ended."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from springpot.machine.faults import FileError
from springpot.machine.record import Record, digest, line_of
from tests.kills import fill, kill_when, lines_in
from tests.posix import link, make_pipe

LONG = {"number": 1.0 / 3.0, "words": "x" * 9000}  # more than two pages


def record(place: Path, shared: bool = False) -> Record:
    return Record(place, "work", shared=shared)


def test_numbers_keep_every_bit_and_text_every_letter(tmp_path: Path) -> None:
    result = [0.1, -0.0, 5e-324, float("inf"), 1 / 3, 1.7e308, -2.5, "\N{GREEK SMALL LETTER ALPHA}\n", None, True]
    record(tmp_path / "file").add("a", result)
    assert json.dumps(record(tmp_path / "file").get("a")) == json.dumps(result)


def test_a_key_is_all_that_a_result_depends_on() -> None:
    contents: list[Any] = [1, 1.0, True, "1", [1], {"a": 1}, {"a": 1, "b": 2}, None]
    assert len({digest(content) for content in contents}) == len(contents)
    assert digest({"b": 2, "a": 1}) == digest({"a": 1, "b": 2})


def test_the_last_of_equal_keys_counts_and_others_stay(tmp_path: Path) -> None:
    for result in (1, 2):
        record(tmp_path / "file").add("a", result)
    assert lines_in(tmp_path / "file") == 2
    assert record(tmp_path / "file").get("a") == 2


def test_any_bit_that_flips_is_seen_also_after_the_record_was_read(tmp_path: Path) -> None:
    place = tmp_path / "file"
    record(place).add("a", [1.5])
    record(place).add("b", [2.5])
    right, opened = place.read_bytes(), record(place)
    first = right.index(b"\n")
    for at in range(first):
        for bit in range(8):
            body = bytearray(right)
            body[at] ^= 1 << bit
            place.write_bytes(body)
            assert (opened.get("a"), opened.get("b")) == (None, [2.5])
            assert (record(place).get("a"), record(place).get("b"), record(place).damaged) == (None, [2.5], 1)
    place.write_bytes(right)
    assert opened.get("a") == [1.5]


def test_a_line_that_is_being_written_is_no_damage_and_read_when_it_is_whole(tmp_path: Path) -> None:
    place, line = tmp_path / "file", line_of("work", "a", LONG) + b"\n"
    opened = record(place)
    for end in (3, 5000, len(line) - 2):
        place.write_bytes(line[:end])
        opened.read()
        assert (opened.get("a"), opened.damaged) == (None, 0)
    place.write_bytes(line[:-1])
    opened.read()
    assert opened.get("a") == LONG
    opened.add("b", 1)
    assert record(place).get("a") == LONG
    assert record(place).get("b") == 1


def test_what_a_killed_process_began_costs_that_line_only(tmp_path: Path) -> None:
    place = tmp_path / "file"
    place.write_bytes(line_of("work", "a", 1) + b"\n" + line_of("work", "b", LONG)[:4096])
    record(place).add("c", 3)
    again = record(place)
    assert [again.get(key) for key in "abc"] == [1, None, 3]
    assert again.damaged == 1


WRITER = """
import sys
from pathlib import Path
from springpot.machine.record import Record
kept = Record(Path(sys.argv[1]), "work", shared=sys.argv[2] == "True")
for number in range(int(sys.argv[3]), int(sys.argv[4])):
    kept.add(str(number), {"number": number, "words": "x" * 9000})
"""


def writer(place: Path, shared: bool, first: int, last: int) -> list[object]:
    return [sys.executable, "-c", WRITER, place, shared, first, last]


@pytest.mark.parametrize("shared", [False, True])
def test_two_processes_write_at_once_and_each_line_is_whole(shared: bool, tmp_path: Path) -> None:
    place = tmp_path / "place"
    if shared:
        place.mkdir()
    two = [subprocess.Popen([*map(str, writer(place, shared, first, first + 500))]) for first in (0, 500)]
    assert [process.wait() for process in two] == [0, 0]
    found = record(place, shared)
    assert [found.get(str(number))["number"] for number in range(1000)] == [*range(1000)]
    assert found.damaged == 0
    assert len([*place.iterdir()]) == 2 if shared else lines_in(place) >= 1000


@pytest.mark.parametrize("shared", [False, True])
def test_a_kill_while_it_does_nothing_but_write_leaves_whole_lines(shared: bool, tmp_path: Path) -> None:
    place = tmp_path / "place"
    if shared:
        place.mkdir()

    def begun() -> bool:
        files = [*place.iterdir()] if shared else [place]
        return sum(map(lines_in, files)) > 50

    for _ in range(3):
        kill_when(writer(place, shared, 0, 10**9), begun)
    found = record(place, shared)
    assert found.damaged <= (0 if shared else 2)  # the next process of a file writes behind what one had begun
    assert all(found.get(str(number)) == {"number": number, "words": "x" * 9000} for number in range(16))


def test_what_another_process_adds_is_seen_and_not_computed(tmp_path: Path) -> None:
    mine, other = record(tmp_path, shared=True), record(tmp_path, shared=True)
    other.add("a", 1)
    assert mine.get("a") is None  # until it looks
    assert mine.of("a", lambda: pytest.fail("it was there")) == 1
    assert mine.of("b", lambda: 2) == 2
    other.read()
    assert other.get("b") == 2


def test_threads_share_a_record(tmp_path: Path) -> None:
    kept = record(tmp_path / "file")

    def work(first: int) -> None:
        for number in range(first, first + 100):
            kept.of(str(number), lambda number=number: number)  # type: ignore[misc]

    team = [threading.Thread(target=work, args=(100 * number,)) for number in range(4)]
    for thread in team:
        thread.start()
    for thread in team:
        thread.join()
    again = record(tmp_path / "file")
    assert [again.get(str(number)) for number in range(400)] == [*range(400)]
    assert lines_in(tmp_path / "file") == 400


@pytest.mark.parametrize("room", [0, 4096])
def test_a_full_disk_is_said_and_what_was_there_stays(room: int, small_disk: Path) -> None:
    """Also where there is room for the half of a line: the system writes that, and fails only when asked again."""
    place = small_disk / "file"
    kept = record(place)
    kept.add("a", 1)
    fill(small_disk / "ballast", room)
    with pytest.raises(OSError, match="No space left"):
        kept.add("b", LONG)
    assert record(place).get("a") == 1
    assert record(place).get("b") is None
    (small_disk / "ballast").unlink()
    kept.add("b", LONG)
    assert record(place).get("b") == LONG


def test_what_is_no_file_in_a_folder_is_passed_over_at_once(tmp_path: Path) -> None:
    record(tmp_path, shared=True).add("a", 1)
    make_pipe(tmp_path / "pipe.tasks")
    (tmp_path / "folder.tasks").mkdir()
    link(tmp_path / "loop.tasks", tmp_path / "loop.tasks")
    (tmp_path / "other").write_bytes(line_of("work", "b", 2))
    begun = time.monotonic()
    found = record(tmp_path, shared=True)
    assert (found.get("a"), found.get("b"), found.damaged) == (1, None, 0)
    assert time.monotonic() - begun < 5.0


def test_a_file_of_another_kind_is_refused_and_stays(tmp_path: Path) -> None:
    place = tmp_path / "file"
    Record(place, "other").add("a", 1)
    before = place.read_bytes()
    with pytest.raises(FileError, match=r"^record must be a file of work or a new one, and '.*file' is not\.$"):
        record(place)
    assert place.read_bytes() == before
