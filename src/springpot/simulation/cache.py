"""A disk cache of compiled kernels that never serves a stale one.

Numba's own cache looks at the one file a function is defined in; a kernel here is compiled from several.  So the key
also holds a digest of every source file of this folder, and of the files in which parts from elsewhere are defined.
Where no folder can be written, the kernel is compiled anew in each process.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache

__all__ = ["cache_folder", "cached"]

_FOLDER = Path(__file__).parent


def _digest(files: Iterable[Path]) -> str:
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(files))).hexdigest()


_DIGEST = _digest(_FOLDER.glob("*.py"))


def _files_of_parts(kind: Any) -> set[Path | None]:
    """Files outside this folder that define the NamedTuples in a Numba type; None for a class without a file."""
    found: set[Path | None] = set()
    if (part := getattr(kind, "instance_class", None)) is not None:
        file = getattr(sys.modules.get(part.__module__), "__file__", None)
        found.add(Path(file) if file else None)
    for inner in getattr(kind, "types", ()):
        found |= _files_of_parts(inner)
    return {file for file in found if file is None or file.parent != _FOLDER}


class _SourceCache(FunctionCache):  # type: ignore[misc]
    def _index_key(self, sig: Any, codegen: Any) -> Any:
        _, *rest = super()._index_key(sig, codegen)
        files = set().union(*map(_files_of_parts, sig))
        # a part typed at a prompt has no source to compare: a key that no other process has
        foreign = os.getpid() if None in files else _digest(file for file in files if file is not None)
        # types as words: a process that cannot import somebody's part must be able to read the index all the same
        return (" ".join(map(repr, sig)), *rest, _DIGEST, foreign)


def cached(dispatcher: Any) -> Any:
    """Give a Numba dispatcher the disk cache, if there is a folder for it, and return it."""
    with contextlib.suppress(RuntimeError):  # Numba found no folder that it can write to
        dispatcher._cache = _SourceCache(dispatcher.py_func)
    return dispatcher


def cache_folder(dispatcher: Any) -> str | None:
    """The folder in which a dispatcher's compiled code is kept, or None."""
    return getattr(dispatcher._cache, "cache_path", None)
