"""A disk cache of compiled kernels that never serves a stale one.

Numba's own cache looks at the one file a function is defined in; a kernel here is compiled from several.  So the key
also holds a digest of every source file of this folder.  Where no folder can be written, the kernel is compiled anew in
each process.
"""

from __future__ import annotations

import contextlib
import hashlib
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache

__all__ = ["cache_folder", "cached"]

_DIGEST = hashlib.sha256(b"".join(f.read_bytes() for f in sorted(Path(__file__).parent.glob("*.py")))).hexdigest()


class _SourceCache(FunctionCache):  # type: ignore[misc]
    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (*super()._index_key(sig, codegen), _DIGEST)


def cached(dispatcher: Any) -> Any:
    """Give a Numba dispatcher the disk cache, if there is a folder for it, and return it."""
    with contextlib.suppress(RuntimeError):  # Numba found no folder that it can write to
        dispatcher._cache = _SourceCache(dispatcher.py_func)
    return dispatcher


def cache_folder(dispatcher: Any) -> str | None:
    """The folder in which a dispatcher's compiled code is kept, or None."""
    return getattr(dispatcher._cache, "cache_path", None)
