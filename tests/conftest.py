"""Linear algebra on one thread, as the command has it: a second one mostly waits, and doubles the processor time."""

from __future__ import annotations

import gc
import linecache
import os
import shutil
import subprocess
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from _pytest.doctest import DoctestModule
from hypothesis import settings

from springpot.machine.crew import ONE_THREAD

# NumPy reads them when it is loaded, which none of the plugins named in pyproject.toml does
for name, number in ONE_THREAD.items():
    os.environ.setdefault(name, number)

settings.register_profile("untimed", deadline=None)  # a busy machine makes no test fail
settings.load_profile("untimed")

gc.disable()  # until the tests are collected, which makes much and drops little


def pytest_collection_finish() -> None:
    """What was collected stays to the end: the garbage collector need not look through it again and again."""
    linecache.clearcache()  # else each doctest asks the disk for all that imports looked at
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path: Path) -> Generator[None, list[pytest.Collector], list[pytest.Collector]]:
    """Examples are those of the library and of what measures the house: in a file of tests none is looked for."""
    found = yield
    tests = file_path.name.startswith("test_")
    return [each for each in found if not (tests and isinstance(each, DoctestModule))]


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
