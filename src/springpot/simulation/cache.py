"""A disk cache of compiled kernels that never serves a stale one.

Numba's own cache looks at the one file a function is defined in; a kernel here is compiled from several.  So the key
also holds a digest of every source file of this folder.  A kernel with a part from elsewhere is not kept on disk, for
nobody can tell what that part's code depends on.  Where no folder can be written, the kernel is compiled anew in each
process.
"""

from __future__ import annotations

import contextlib
import hashlib
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache

__all__ = ["cache_folder", "cached"]

_DIGEST = hashlib.sha256(b"".join(f.read_bytes() for f in sorted(Path(__file__).parent.glob("*.py")))).hexdigest()
_HERE = __name__.rpartition(".")[0]


def _from_elsewhere(kind: Any) -> bool:
    """Whether a Numba type is, or holds, a NamedTuple that is not defined in this folder."""
    part = getattr(kind, "instance_class", None)
    inside = part is None or part.__module__.rpartition(".")[0] == _HERE
    return not inside or any(map(_from_elsewhere, getattr(kind, "types", ())))


class _SourceCache(FunctionCache):  # type: ignore[misc]
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
