"""The disk cache of kernels never stands in the way."""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numba
import pytest

from springpot.machine import trusted
from springpot.simulation.kernel.cache import cached, find_folder
from tests.posix import make_pipe
from tests.sizes import validation
from tests.strangers import as_stranger, needs_another_user, needs_owners

TINY = """
import resource
import sys
import numba
from springpot.simulation.kernel.cache import cached, find_folder

def twice(number):
    return 2 * number

kernel = cached(numba.njit(twice))
if sys.argv[1] == "limited":
    sys.dont_write_bytecode = True  # Python would keep files of bytecode that are cut off
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
print(kernel(21), find_folder(kernel)[0] is not None)
"""


@needs_owners  # and limits
@pytest.mark.parametrize(("word", "kept"), [("limited", 0), validation("free", 1)])
def test_a_kernel_that_cannot_be_kept_is_compiled_all_the_same(word: str, kept: int, tmp_path: Path) -> None:
    script = tmp_path / "tiny.py"
    script.write_text(TINY, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(script), word], capture_output=True, text=True, timeout=300,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
    )  # fmt: skip
    assert done.stdout == "42 True\n", done.stderr
    assert len([file for file in tmp_path.rglob("tiny*.nbc") if file.stat().st_size > 100]) == kept


ONE = """
import numba
from springpot.simulation.kernel.cache import cached

kernel = cached(numba.njit(lambda number: number + number))
assert kernel(21) == 42
print(sum(kernel.stats.cache_hits.values()))
"""

MANY = """
import sys
import numba
from springpot.simulation.kernel.cache import cached

files = cached(numba.njit(lambda number: number + number))._cache._cache_file
who, number = sys.argv[1], int(sys.argv[2])
print("ready", flush=True)
sys.stdin.readline()
for i in range(number):
    files.save((who, i), f"{who} made {i}")
"""


def _asked(script: Path, cache: Path, *words: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(script), *map(str, words)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
    )  # fmt: skip


def test_what_two_processes_keep_at_the_same_moment_is_all_there(tmp_path: Path) -> None:
    """With Numba's own index some of it is lost, and some handed out as the other's."""
    script, cache, number = tmp_path / "many.py", tmp_path / "cache", 50
    cache.mkdir()
    script.write_text(MANY, encoding="utf-8")
    both = [_asked(script, cache, who, number) for who in ("one", "other")]
    for process in both:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in both:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    for process in both:
        assert process.communicate(timeout=300) == ("", "")
    code = f"""
for who in ("one", "other"):
    for i in range({number}):
        assert files.load((who, i)) == f"{{who}} made {{i}}"
"""
    script.write_text(MANY.split("who,")[0] + code, encoding="utf-8")
    assert _asked(script, cache).communicate(timeout=300) == ("", "")
    assert {file.suffix for file in cache.rglob("*") if file.is_file()} == {".nbc"}  # nothing half-written


def twice(number: float) -> float:
    return 2 * number


def kernel(cache: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A small kernel that is kept in a folder, called once."""
    monkeypatch.setattr(numba.core.config, "CACHE_DIR", str(cache))
    made = cached(numba.njit(twice))
    assert made(21) == 42
    return made


def hits(kernel: Any) -> int:
    return sum(kernel.stats.cache_hits.values())


def test_a_damaged_kernel_is_compiled_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = tmp_path / "cache"
    assert hits(kernel(cache, monkeypatch)) == 0
    (kept,) = cache.rglob("*.nbc")
    whole = kept.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    for damaged in (whole[: len(whole) // 2], b"", bytes(flipped)):
        kept.write_bytes(damaged)
        assert hits(kernel(cache, monkeypatch)) == 0
    assert hits(kernel(cache, monkeypatch)) == 1


def _forged(kept: bytes, command: str) -> bytes:
    """The file of a kernel with its key, which runs a command when it is unpickled, and the right checksum."""

    class Command:
        def __reduce__(self) -> tuple[object, ...]:
            return os.system, (command,)

    key, _ = pickle.loads(kept.split(b"\n", 1)[1])
    content = pickle.dumps((key, Command()))
    return hashlib.sha256(content).hexdigest().encode() + b"\n" + content


@pytest.fixture
def shared() -> Iterator[Path]:
    """A folder that all users reach, and in which all can write."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        os.chmod(folder, 0o1777)
        yield Path(folder)


@needs_another_user
@pytest.mark.parametrize("where", ["the folder", "the folder above", "a link", "its own folder"])
def test_a_kernel_forged_by_another_user_is_not_run(
    tmp_path: Path, shared: Path, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The attack: where another user can write he replaces a kernel."""
    cache, ran = tmp_path / "cache", tmp_path / "ran"
    assert hits(kernel(cache, monkeypatch)) == 0
    (kept,) = cache.rglob("*.nbc")
    forged = _forged(kept.read_bytes(), f"touch {ran}")
    kept.write_bytes(forged)  # it does what it says, where it is trusted
    with contextlib.suppress(Exception):
        kernel(cache, monkeypatch)
    assert ran.exists()
    ran.unlink()
    open_to_all = shared / "cache"
    its = open_to_all / kept.parent.name / kept.name
    if where in ("the folder", "the folder above"):
        its.parent.mkdir(parents=True)
        (its.parent if where == "the folder" else open_to_all).chmod(0o777)
    with as_stranger():
        if where == "the folder above":
            its.parent.rename(open_to_all / "away")
        if where == "a link":
            (shared / "its").mkdir()
            open_to_all.symlink_to(shared / "its")
        its.parent.mkdir(parents=True, exist_ok=True)
        its.write_bytes(forged)
    if where == "a link":  # even where it leads to what is this user's
        for path in (shared / "its", *(shared / "its").rglob("*")):
            os.chown(path, 0, 0)
    trusted.say_unused.cache_clear()
    with pytest.warns(trusted.CacheWarning, match="Compiled kernels are not stored") as said:
        made = kernel(open_to_all, monkeypatch)
    assert hits(made) == 0
    assert not ran.exists()
    folder, reason = find_folder(made)
    assert folder is None
    assert reason is not None
    assert str(shared) in reason
    assert "can be written by other users" in reason or "belongs to the user" in reason
    assert str(said[0].message).endswith(f"because {reason}. Set NUMBA_CACHE_DIR to a folder that only you can write.")


@pytest.mark.parametrize("content", [b"no pickle", pickle.dumps(3), b""])
def test_another_content_with_the_right_checksum_is_compiled_anew(
    tmp_path: Path, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path / "cache"
    assert hits(kernel(cache, monkeypatch)) == 0
    (kept,) = cache.rglob("*.nbc")
    kept.write_bytes(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
    assert hits(kernel(cache, monkeypatch)) == 0
    assert hits(kernel(cache, monkeypatch)) == 1


@needs_owners
@pytest.mark.parametrize("place", ["pipe", "huge", "for all", "folder"])
def test_a_kernel_in_no_proper_file_is_compiled_anew(
    tmp_path: Path, place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path / "cache"
    assert hits(kernel(cache, monkeypatch)) == 0
    (kept,) = cache.rglob("*.nbc")
    assert kept.stat().st_mode & 0o777 == 0o600
    assert {folder.stat().st_mode & 0o777 for folder in (cache, kept.parent)} == {0o700}
    assert hits(kernel(cache, monkeypatch)) == 1
    if place == "for all":
        kept.chmod(0o666)
    else:
        kept.unlink()
    if place == "pipe":
        make_pipe(kept)
    elif place == "huge":
        with kept.open("wb") as file:
            file.truncate(1 << 36)
    elif place == "folder":
        kept.mkdir()
    assert hits(kernel(cache, monkeypatch)) == 0
    assert hits(kernel(cache, monkeypatch)) == 1  # and kept, where nothing was lost by that


@needs_owners
def test_beside_the_source_where_others_can_write_is_no_place(tmp_path: Path) -> None:
    """Then the user's own cache folder is, without a word."""
    script, home = tmp_path / "shared" / "one.py", tmp_path / "home"
    script.parent.mkdir()
    home.mkdir()
    script.write_text(ONE, encoding="utf-8")
    script.parent.chmod(0o777)
    places = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
    environment = {name: value for name, value in os.environ.items() if name not in places}
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=300,
        env={**environment, "HOME": str(home)},
    )  # fmt: skip
    assert (done.stdout, done.stderr) == ("0\n", "")
    assert not list(script.parent.rglob("*.nbc"))
    assert len(list(home.rglob("one*.nbc"))) == 1
