"""A disk cache of compiled kernels that never returns a wrong one.

Numba's own cache checks only the file in which a function is defined, but a kernel is compiled from several.  So the
key also contains a digest of every source file of this folder, and of the function's own.  Numba also numbers its
files in one index, and two processes that compile at the same time can mix them up; here each function has its own
file, named by its key, with the key and a checksum in it.

A user's own function is not cached, because changes of that code are not detected: the kernel calls its address.

A file of the cache holds machine code, and loading it runs it.  So only a folder is used that no other user can write
(:mod:`springpot.machine.trusted`): NUMBA_CACHE_DIR if it is set, else the user's cache folder.  Where it cannot be
used, the kernel is compiled anew in each process.
"""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import pickle
import sys
import tempfile
from pathlib import Path
from typing import Any

import llvmlite
import numba
from platformdirs import user_cache_dir

from springpot.machine.files import write
from springpot.machine.trusted import UntrustedFolderError, make_folder, read, reason_against, say_unused
from springpot.simulation.kernel.lanes import INLINE, QUICK

try:  # private names of Numba: where one is missing nothing is cached
    if "forceinline" not in INLINE:  # code from the disk could differ by rounding
        raise ImportError
    from numba.core.caching import FunctionCache
    from numba.core.compiler import CompileResult
    from numba.core.runtime import rtsys
    from numba.core.serialize import dumps
except ImportError:
    FunctionCache = None


def _sources(folder: Path) -> bytes:
    return b"".join(file.read_bytes() for file in sorted(folder.glob("*.py")))


_COMPILER = f"{numba.__version__} {llvmlite.__version__} {sys.version} {QUICK}"
_DIGEST = hashlib.sha256(_sources(Path(__file__).parent) + _COMPILER.encode()).hexdigest()
_LARGEST = 64 << 20  # bytes of a file; kernels take less than one MiB
_IF_UNTESTED = () if QUICK else (Exception,)  # what another Numba may raise costs a compilation, no more


class _Files:
    """Compiled code by key, a file for each: what Numba's cache reads from and writes to."""

    def __init__(self, folder: Path, base: str) -> None:
        self.folder, self.base = folder, f"{base}.{_DIGEST[:12]}"

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


class _Cache(FunctionCache or object):  # type: ignore[misc]
    """Numba's cache of a function, in a folder and files of ours; ``reason`` says why they are not used, if so."""

    def __init__(self, function: Any) -> None:
        self._py_func, self._cache_path, self.reason = function, None, None
        try:
            base = numba.config.CACHE_DIR or user_cache_dir("springpot", appauthor=False)
            folder, source = Path(base) / "kernels", Path(inspect.getfile(function))
            self._own = hashlib.sha256(_sources(source.parent)).hexdigest()
            make_folder(folder)
            tempfile.TemporaryFile(dir=folder).close()
        except UntrustedFolderError as error:
            self.reason = str(error)
        except OSError as error:
            self.reason = f"{error.filename!r} cannot be used ({error.strerror})"
        except RuntimeError:
            self.reason = "this user has no home folder"
        else:
            name = function.__qualname__.replace("<", "").replace(">", "")
            self._cache_path = str(folder)
            self._cache_file = _Files(folder, f"{source.stem}.{name}-{function.__code__.co_firstlineno}")

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Numba's own first learns all that a compilation may need, longer than all the rest takes; this does not."""
        if self.reason:
            say_unused(
                "Compiled kernels are not stored, and every process compiles them again for a few seconds, because "
                f"{self.reason}. Set NUMBA_CACHE_DIR to a folder that only you can write."
            )
        else:
            with contextlib.suppress(*_IF_UNTESTED):
                rtsys.initialize(target_context)  # what unpacks the arrays
                data = self._cache_file.load(self._key(sig, target_context.codegen()))
                return data and CompileResult._rebuild(target_context, *data)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with contextlib.suppress(OSError, *_IF_UNTESTED):  # a full disk costs the next process a compilation, no more
            if not (self.reason or data.library.has_dynamic_globals or data.lifted):
                self._cache_file.save(self._key(sig, data.codegen), data._reduce())

    def _key(self, sig: Any, codegen: Any) -> Any:
        return (*self._index_key(sig, codegen), _DIGEST, self._own)


def cached(dispatcher: Any) -> Any:
    """Give a Numba dispatcher the disk cache, if there is a folder for it, and return it."""
    if FunctionCache:
        dispatcher._cache = _Cache(dispatcher.py_func)
    return dispatcher


def find_folder(dispatcher: Any) -> tuple[str | None, str | None]:
    """The folder in which a dispatcher's compiled code is kept, or None and the reason why there is none."""
    if not FunctionCache:
        return None, f"springpot does not know Numba {numba.__version__}"
    return dispatcher._cache.cache_path, dispatcher._cache.reason
