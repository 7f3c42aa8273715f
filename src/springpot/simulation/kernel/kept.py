"""Machine code as object files: loaded into this process by llvmlite, and kept on disk between runs.

What is kept never stands in the way, and never returns a wrong file.

Loading such a file runs what is in it.  So only a folder is used that no other user can write
(:mod:`springpot.machine.trusted`): NUMBA_CACHE_DIR if it is set, else the user's cache folder.  Each piece of code has
its own file, named by its key, with a checksum of key and content in it, and is written under another name and
renamed: two processes that keep the same code at the same moment, and one that is killed meanwhile, do no harm.
Where nothing can be kept, code is compiled anew in each process.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import struct
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from platformdirs import user_cache_dir

from springpot.machine.files import remove_orphans, write
from springpot.machine.trusted import UntrustedFolderError, make_folder, read, reason_against, say_unused

SYMBOL = "springpot"  # the name of the function in its object file


class MissingSymbolError(RuntimeError):
    """Machine code needs a function that this process does not have."""


@dataclass(frozen=True, eq=False)
class Code:
    """Machine code in memory, for as long as this object lives.

    Attributes
    ----------
    address : int
        Of the function.
    how : str
        Where it comes from, in words.
    held : object
        What owns the memory.
    """

    address: int
    how: str
    held: Any


def loaded(content: bytes, how: str) -> Code:
    """The function of an object file.

    Raises
    ------
    MissingSymbolError
        If it needs functions that this process does not have; LLVM would end the process.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    if missing := sorted(name for name in needed(content) if not _found(name)):
        raise MissingSymbolError(f"it needs {', '.join(missing)}, which this process does not have")
    engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(content))
    engine.finalize_object()
    return Code(engine.get_function_address(SYMBOL), how, engine)


@cache
def _found(symbol: str) -> bool:
    if sys.platform == "linux":
        for library in ("libc.so.6", "libm.so.6"):  # Python itself may be linked with none of it
            try:
                llvm.load_library_permanently(library)
            except RuntimeError:
                continue
    return llvm.address_of_symbol(symbol) is not None


def needed(content: bytes) -> set[str]:
    """Functions that an object in the form ELF does not hold itself; of another form none is found."""
    if content[:6] != b"\x7fELF\x02\x01":
        return set()
    sections = {
        section.name(): section.data() for section in llvm.object_file.ObjectFileRef.from_data(content).sections()
    }
    names = sections[b".strtab"]
    found = set()
    for name, _, _, section, _, _ in struct.iter_unpack("<IBBHQQ", sections[b".symtab"]):
        if name and section == 0:
            found.add(names[name : names.index(b"\0", name)].decode())
    return found


_LARGEST = 64 << 20  # bytes of a file; a kernel takes less than one MiB
_MOST = 1000  # files; a function that captures another number in each call makes one each time


def folder() -> tuple[Path | None, str | None]:
    """Where code is kept, or None and the reason why it is not, in words that follow "because".

    Examples
    --------
    >>> place, reason = folder()
    >>> (place is None) == (reason is not None)
    True
    """
    try:
        base = os.environ.get("NUMBA_CACHE_DIR") or user_cache_dir("springpot", appauthor=False)
        place = Path(base) / "kernels"
        make_folder(place)
        tempfile.TemporaryFile(dir=place).close()
    except UntrustedFolderError as error:
        return None, str(error)
    except OSError as error:
        return None, f"{error.filename!r} cannot be used ({error.strerror})"
    except RuntimeError:
        return None, "this user has no home folder"
    return place, None


def warn_if_unused() -> None:
    """Say once in a process that code is compiled for this process only, if so."""
    if reason := folder()[1]:
        say_unused(
            "Compiled kernels are not stored, and every process compiles them again for a few seconds, because "
            f"{reason}. Set NUMBA_CACHE_DIR to a folder that only you can write."
        )


def load(name: str, key: str) -> bytes | None:
    """What was kept under a name and a key; None if there is nothing, or it is damaged, or others could write it."""
    place = folder()[0]
    if place is None:
        return None
    file = _file(place, name, key)
    checksum, _, content = (read(file, _LARGEST) or b"").partition(b"\n")
    if checksum != _checksum(key, content):
        return None
    with contextlib.suppress(OSError):
        os.utime(file)  # so that it is not among the first to go
    return content


def save(name: str, key: str, content: bytes) -> None:
    """Keep it, if there is a folder for it; a full disk costs the next process a compilation, no more."""
    with contextlib.suppress(OSError):
        place = folder()[0]
        if place and reason_against(place) is None:
            remove_orphans(str(place))
            _make_room(place)
            write(str(_file(place, name, key)), _checksum(key, content) + b"\n" + content, private=True)


def _make_room(place: Path) -> None:
    """Remove the half that was not used for longest, where there are many files."""
    files = [*place.glob("*.o")]
    if len(files) < _MOST:
        return
    ages = []
    for file in files:
        with contextlib.suppress(OSError):
            ages.append((file.stat().st_mtime, str(file)))
    for _, name in sorted(ages)[: len(ages) // 2]:
        with contextlib.suppress(OSError):  # another process was quicker
            os.unlink(name)


def _file(place: Path, name: str, key: str) -> Path:
    return place / f"{name}.{hashlib.sha256(key.encode()).hexdigest()[:24]}.o"


def _checksum(key: str, content: bytes) -> bytes:
    return hashlib.sha256(key.encode() + b"\n" + content).hexdigest().encode()
