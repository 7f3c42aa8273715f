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
