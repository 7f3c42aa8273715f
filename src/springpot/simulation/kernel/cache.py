"""A disk cache of compiled kernels that never returns a wrong one.

Numba's own cache checks only the file in which a function is defined, but a kernel is compiled from several.  So the
key also contains a digest of every source file of this folder, and of the function's own file.  Numba also numbers its
files in one index, and two processes that compile at the same time can mix them up; here each function has its own
file, named by its key, with the key and a checksum in it.

A kernel with a part that is defined outside this folder is not cached, because changes of that code are not detected.

A file of the cache holds machine code, and loading it runs it.  So only a folder is used that no other user can write
(:mod:`springpot.machine.trusted`): NUMBA_CACHE_DIR if it is set, else the first of Numba's places that is so, which are
beside the source and in the user's cache folder.  Where there is none, the kernel is compiled anew in each process.
"""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import caching
from numba.core.ccallback import CFunc
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature

from springpot.machine.files import write
from springpot.machine.trusted import make_folder, read, reason_against, say_unused
from springpot.simulation.kernel.lanes import FAST

__all__ = ["cached", "callback", "find_folder"]

_SOURCES = b"".join(f.read_bytes() for f in sorted(Path(__file__).parents[1].rglob("*.py")))
_COMPILER = f"{numba.__version__} {llvmlite.__version__}"
_DIGEST = hashlib.sha256(_SOURCES + _COMPILER.encode()).hexdigest()
_LARGEST = 64 << 20  # bytes of a file; kernels take less than one MiB
_HERE = __name__.rpartition(".")[0]


class _OnlyTrusted:
    """Mixed into Numba's cache locators: new folders are private, and folders that others can write are not used."""

    get_cache_path: Callable[[], str]

    def ensure_cache_path(self) -> None:
        path = self.get_cache_path()
        make_folder(path)
        tempfile.TemporaryFile(dir=path).close()


class _Chosen(_OnlyTrusted, caching.UserProvidedCacheLocator):  # type: ignore[misc]
    """NUMBA_CACHE_DIR."""


class _BesideTheSource(_OnlyTrusted, caching.InTreeCacheLocator):  # type: ignore[misc]
    """``__pycache__``."""


class _OfTheUser(_OnlyTrusted, caching.UserWideCacheLocator):  # type: ignore[misc]
    """Numba's folder among the user's caches."""


class _InTrustedFolders(caching.CompileResultCacheImpl):  # type: ignore[misc]
    """Finds the folder, or raises RuntimeError with a reason that follows "because"."""

    def __init__(self, function: Any) -> None:
        chosen = caching.config.CACHE_DIR
        # never another place than the one chosen
        self._locator_classes = (_Chosen,) if chosen else (_BesideTheSource, _OfTheUser)
        try:
            super().__init__(function)
            folder = self.locator.get_cache_path()  # NUMBA_CACHE_LOCATOR_CLASSES may have named another than ours
        except RuntimeError:
            last = self._locator_classes[-1](function, inspect.getfile(function)).get_cache_path()
            raise RuntimeError(reason_against(last) or f"{last!r} cannot be written") from None
        if reason := reason_against(folder):
            raise RuntimeError(reason)


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
        """The data saved under a key; None if there are none, they are damaged or others could have written them."""
        checksum, _, content = (read(self._place(key), _LARGEST) or b"").partition(b"\n")
        if hashlib.sha256(content).hexdigest().encode() != checksum:
            return None
        try:
            saved_under, data = pickle.loads(content)
        except (pickle.UnpicklingError, EOFError, ValueError, TypeError, AttributeError, ImportError, IndexError):
            return None  # not written by this class
        return data if saved_under == key else None

    def save(self, key: Any, data: Any) -> None:
        """Save under a key: atomically, also if other processes do the same."""
        content = dumps((key, data))
        if reason_against(self.folder) is None:
            write(str(self._place(key)), hashlib.sha256(content).hexdigest().encode() + b"\n" + content, private=True)


class _SourceCache(caching.FunctionCache):  # type: ignore[misc]
    _impl_class = _InTrustedFolders

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file = _Files(self._cache_path, self._impl.filename_base)
        self._own = hashlib.sha256(Path(inspect.getfile(function)).read_bytes()).hexdigest()

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (*super()._index_key(sig, codegen), _DIGEST, self._own)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Numba's own first learns all that a compilation may need, longer than all the rest takes; this does not."""
        if any(map(_from_elsewhere, _arguments(sig))):
            return None
        rtsys.initialize(target_context)  # what unpacks the arrays
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        if not any(map(_from_elsewhere, _arguments(sig))):
            with contextlib.suppress(OSError):  # a full or failing disk costs the next process a compilation, no more
                super().save_overload(sig, data)


def _arguments(sig: Any) -> Any:
    """The types of the arguments; a callback's come with that of what it returns."""
    return getattr(sig, "args", sig)


class _NoCache(caching.NullCache):  # type: ignore[misc]
    """Caches nothing, and says why at the first use."""

    def __init__(self, reason: str) -> None:
        self.reason = reason

    def load_overload(self, sig: Any, target_context: Any) -> None:
        say_unused(
            "Compiled kernels are not stored, and every process compiles them again for a few seconds, because "
            f"{self.reason}. Set NUMBA_CACHE_DIR to a folder that only you can write."
        )


def cached(dispatcher: Any) -> Any:
    """Give a Numba dispatcher the disk cache, if there is a folder for it, and return it."""
    dispatcher._cache = _cache_of(dispatcher.py_func)
    return dispatcher


def callback(signature: Any) -> Callable[[Callable[..., None]], Any]:
    """As ``numba.cfunc`` with the disk cache, for functions that hold nothing but numbers of their own.

    Another compiled function in it would have another key in every process.
    """

    def compiled(function: Callable[..., None]) -> Any:
        made: Any = CFunc(function, normalize_signature(signature), {}, dict(FAST))
        made._cache = _cache_of(function)
        made.compile()
        return made

    return compiled


def _cache_of(function: Any) -> Any:
    try:
        return _SourceCache(function)
    except RuntimeError as error:
        return _NoCache(str(error))


def find_folder(dispatcher: Any) -> tuple[str | None, str | None]:
    """The folder in which a dispatcher's compiled code is kept, or None and the reason why there is none."""
    return getattr(dispatcher._cache, "cache_path", None), getattr(dispatcher._cache, "reason", None)
