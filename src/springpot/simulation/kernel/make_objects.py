"""Make the machine code that a wheel brings: ``python -m springpot.simulation.kernel.make_objects [TARGET ...]``.

Each target is made in a process of its own, because the width of its vectors is known when modules are loaded.  The
objects are written beside a manifest with their checksums and the digest of the sources from which they were made; a
wheel that is built then holds them.  They are not kept in the repository: a checkout compiles once.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from springpot.machine.files import write
from springpot.simulation.kernel.kept import needed
from springpot.simulation.kernel.native import ENTRIES, MANIFEST, OBJECTS, Entry, compiler, file_of
from springpot.simulation.kernel.targets import TARGETS, named, target

LIBRARY = frozenset({"memcpy", "memmove", "memset", "atan2", "cos", "exp", "pow", "powf", "sin", "sincos"})
"""What code may call: functions of every C library, but for ``sincos``, which those of Linux have.

Where one is missing the code is compiled anew.
"""
SHIPPED = ("linux-x86-64-v4", "linux-x86-64-v3", "linux-aarch64")
"""Made where no target is named.  That for macOS can be made, and no such machine has run it."""


def make(
    names: tuple[str, ...] = SHIPPED, folder: Path = OBJECTS, entries: Sequence[Entry] = ENTRIES
) -> dict[str, dict[str, object]]:
    """Make the objects of these entries for these targets, and the manifest, which is returned.

    What was there is removed.

    Raises
    ------
    ValueError
        If a target is unknown.
    RuntimeError
        If one cannot be made; the manifest is missing then.
    """
    wanted = [named(name) for name in names]
    folder.mkdir(exist_ok=True)
    for file in (folder / MANIFEST, *folder.glob("*.o")):
        file.unlink(missing_ok=True)
    for goal in wanted:
        own = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
        words = [sys.executable, "-m", __spec__.name, "--here", str(folder), *(entry.name for entry in entries)]
        done = subprocess.run(
            words, env={**own, "SPRINGPOT_TARGET": goal.name, "NUMBA_DISABLE_INTEL_SVML": "1"}, text=True,
            stderr=subprocess.PIPE,
        )  # fmt: skip
        if done.returncode:
            raise RuntimeError(f"the code for {goal.name} cannot be made: {done.stderr.strip()}")
    manifest: dict[str, dict[str, object]] = {
        entry.name: {
            "sources": entry.sources,
            "compiler": compiler(),
            "sha256": {
                goal.name: hashlib.sha256(file_of(entry.name, goal, folder).read_bytes()).hexdigest() for goal in wanted
            },
        }
        for entry in entries
    }
    write(str(folder / MANIFEST), (json.dumps(manifest, indent=1) + "\n").encode())
    return manifest


def _make_here(folder: Path, names: list[str]) -> None:
    """The objects of some entries for the target of this process."""
    goal = target()
    for entry in (entry for entry in ENTRIES if entry.name in names):
        content = entry.compiled(goal)
        if others := needed(content) - LIBRARY:
            raise RuntimeError(f"{entry.name} calls {', '.join(sorted(others))}: not every system has it")
        file_of(entry.name, goal, folder).write_bytes(content)


def main(words: list[str]) -> int:
    """The command."""
    if words[:1] == ["--here"]:
        _make_here(Path(words[1]), words[2:])
        return 0
    try:
        manifest = make(tuple(words) or SHIPPED)
    except (ValueError, RuntimeError) as error:
        print(f"{error}\nKnown targets: {', '.join(each.name for each in TARGETS)}", file=sys.stderr)
        return 1
    for name in manifest:
        for file in sorted(OBJECTS.glob(f"{name}.*.o")):
            print(f"{file.name}: {file.stat().st_size} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
