"""What systems do otherwise, asked of the one that the tests run on."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path, PureWindowsPath

import pytest

from springpot.machine.arguments import checked_path
from springpot.machine.files import append_line, read_file, remove_orphans, write
from springpot.machine.platforms import WINDOWS, is_alive, patiently, wrong_letters


def test_a_file_that_somebody_reads_is_replaced(tmp_path: Path) -> None:
    """Windows refuses it as long as it is open."""
    place = tmp_path / "file"
    place.write_bytes(b"old")
    with place.open("rb") as file:
        closing = threading.Timer(0.2, file.close)
        closing.start()
        write(str(place), b"new")
        closing.join()
    assert place.read_bytes() == b"new"


def test_lines_that_threads_add_at_once_are_whole(tmp_path: Path) -> None:
    place = tmp_path / "file"
    places: list[int] = []
    team = [
        threading.Thread(target=lambda word=word: places.extend(append_line(place, word * 5000) for _ in range(50)))
        for word in (b"a", b"b")
    ]
    for thread in team:
        thread.start()
    for thread in team:
        thread.join()
    assert sorted(place.read_bytes().split(b"\n")) == [b"", *[b"a" * 5000] * 50, *[b"b" * 5000] * 50]


def test_lines_that_processes_add_at_once_are_whole(tmp_path: Path) -> None:
    """Of several pages each: what another process has written so far looks like a line that a kill cut."""
    place = tmp_path / "file"
    adding = "import sys; from springpot.machine.files import append_line\nfor _ in range(200): append_line(*ARGS)"
    code = adding.replace("ARGS", "[sys.argv[1], b'x' * 40000]")
    team = [subprocess.Popen([sys.executable, "-c", code, place]) for _ in range(3)]
    assert [process.wait() for process in team] == [0] * 3
    assert place.read_bytes() == (b"x" * 40000 + b"\n") * 600


def test_what_is_refused_for_good_is_said(tmp_path: Path) -> None:
    begun, count = time.monotonic(), 0

    def refused() -> None:
        nonlocal count
        count += 1
        raise PermissionError

    with pytest.raises(PermissionError):
        patiently(refused)
    assert count > 1 if WINDOWS else count == 1
    assert time.monotonic() - begun < 10.0


def test_who_lives() -> None:
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    assert is_alive(os.getpid())
    assert is_alive(process.pid)
    assert process.poll() is None  # the question does it no harm
    process.communicate(b"\n")
    assert is_alive(process.pid) == WINDOWS  # which has no such question


def test_a_folder_in_place_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").mkdir()
    with pytest.raises(ValueError, match="it is a folder, not a file"):
        read_file(str(tmp_path / "file"), 10)
    write(str(tmp_path / "file"), b"words")
    assert (tmp_path / "file").read_bytes() == b"words"
    (tmp_path / "full" / "more").mkdir(parents=True)
    with pytest.raises(OSError, match="full"):
        write(str(tmp_path / "full"), b"words")
    assert remove_orphans(str(tmp_path)) == 0


def test_names_with_a_colon(tmp_path: Path) -> None:
    """In Windows it would be a hidden part of another file."""
    assert wrong_letters(PureWindowsPath(r"\\server\share\a<b>.nc")) == "<>"
    assert wrong_letters(PureWindowsPath("run 1.nc")) == ""
    place = tmp_path / "a:b"
    if WINDOWS:
        with pytest.raises(ValueError, match="no name has : in Windows"):
            checked_path(place, "path")
    else:
        write(str(checked_path(place, "path")), b"words")
        assert [each.name for each in tmp_path.iterdir()] == ["a:b"]
