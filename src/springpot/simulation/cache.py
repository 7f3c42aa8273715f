"""A disk cache of compiled kernels that never serves a wrong one.

Numba's own cache looks at the one file a function is defined in; a kernel here is compiled from several.  So the key
also holds a digest of every source file of this folder.  And Numba numbers its files in an index that processes which
compile at the same moment take from one another, so that one may be handed the other's kernel; here each kernel has a
file of its own, named by its key, that says whose it is and carries a checksum.

A kernel with a part from elsewhere is not kept on disk, for nobody can tell what that part's code depends on.  Where
no folder can be written, the kernel is compiled anew in each process.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

from springpot.files import write

__all__ = ["cache_folder", "cached"]

_DIGEST = hashlib.sha256(b"".join(f.read_bytes() for f in sorted(Path(__file__).parent.glob("*.py")))).hexdigest()
_HERE = __name__.rpartition(".")[0]


def _from_elsewhere(kind: Any) -> bool:
    """Whether a Numba type is, or holds, a NamedTuple that is not defined in this folder."""
    part = getattr(kind, "instance_class", None)
    inside = part is None or part.__module__.rpartition(".")[0] == _HERE
    return not inside or any(map(_from_elsewhere, getattr(kind, "types", ())))


class _Files:
    """Compiled code by key, a file for each: what Numba's cache reads from and writes to."""

    def __init__(self, folder: str, base: str) -> None:
        self.folder, self.base = Path(folder), f"{base}.{_DIGEST[:12]}"

    def _place(self, key: Any) -> Path:
        return self.folder / f"{self.base}.{hashlib.sha256(repr(key).encode()).hexdigest()[:24]}.nbc"

    def load(self, key: Any) -> Any:
        """What was saved under a key, or None if nothing was, or it is damaged."""
        try:
            checksum, content = self._place(key).read_bytes().split(b"\n", 1)
        except (OSError, ValueError):
            return None
        if hashlib.sha256(content).hexdigest().encode() != checksum:
            return None
        saved_under, data = pickle.loads(content)
        return data if saved_under == key else None

    def save(self, key: Any, data: Any) -> None:
        """Save under a key: at once or not at all, whoever else does so."""
        content = dumps((key, data))
        write(str(self._place(key)), hashlib.sha256(content).hexdigest().encode() + b"\n" + content)


class _SourceCache(FunctionCache):  # type: ignore[misc]
    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file = _Files(self._cache_path, self._impl.filename_base)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (*super()._index_key(sig, codegen), _DIGEST)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        return None if any(map(_from_elsewhere, sig)) else super().load_overload(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        if not any(map(_from_elsewhere, sig)):
            with contextlib.suppress(OSError):  # a full or failing disk costs the next process a compilation, no more
                super().save_overload(sig, data)


def cached(dispatcher: Any) -> Any:
    """Give a Numba dispatcher the disk cache, if there is a folder for it, and return it."""
    with contextlib.suppress(RuntimeError):  # Numba found no folder that it can write to
        dispatcher._cache = _SourceCache(dispatcher.py_func)
    return dispatcher


def cache_folder(dispatcher: Any) -> str | None:
    """The folder in which a dispatcher's compiled code is kept, or None."""
    return getattr(dispatcher._cache, "cache_path", None)
