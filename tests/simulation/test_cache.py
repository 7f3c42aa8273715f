"""The disk cache of kernels never stands in the way."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

TINY = """
import resource
import sys
import numba
from springpot.simulation.cache import cache_folder, cached

def twice(number):
    return 2 * number

kernel = cached(numba.njit(twice))
if sys.argv[1] == "limited":
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
print(kernel(21), cache_folder(kernel) is not None)
"""


def test_a_kernel_that_cannot_be_kept_is_compiled_all_the_same(tmp_path: Path) -> None:
    script = tmp_path / "tiny.py"
    for word, kept in (("limited", 0), ("free", 1)):
        script.write_text(TINY)
        done = subprocess.run(
            [sys.executable, str(script), word], capture_output=True, text=True, timeout=300,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
        )  # fmt: skip
        assert done.stdout == "42 True\n", done.stderr
        assert len([file for file in tmp_path.rglob("tiny*.nbc") if file.stat().st_size > 100]) == kept


ONE = """
import numba
from springpot.simulation.cache import cached

kernel = cached(numba.njit(lambda number: number + number))
assert kernel(21) == 42
print(sum(kernel.stats.cache_hits.values()))
"""

MANY = """
import sys
import numba
from springpot.simulation.cache import cached

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
    script, cache, number = tmp_path / "many.py", tmp_path / "cache", 200
    cache.mkdir()
    script.write_text(MANY)
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
    script.write_text(MANY.split("who,")[0] + code)
    assert _asked(script, cache).communicate(timeout=300) == ("", "")
    assert {file.suffix for file in cache.rglob("*") if file.is_file()} == {".nbc"}  # nothing half-written


def test_a_damaged_kernel_is_compiled_anew(tmp_path: Path) -> None:
    script, cache = tmp_path / "one.py", tmp_path / "cache"
    script.write_text(ONE)
    assert _asked(script, cache).communicate(timeout=300) == ("0\n", "")
    (kept,) = cache.rglob("one*.nbc")
    whole = kept.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    for damaged in (whole[: len(whole) // 2], b"", bytes(flipped)):
        kept.write_bytes(damaged)
        assert _asked(script, cache).communicate(timeout=300) == ("0\n", "")
    assert _asked(script, cache).communicate(timeout=300) == ("1\n", "")
