"""Machine code kept on disk between runs; it never stands in the way, and never returns a wrong file.

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
import tempfile
from pathlib import Path

from platformdirs import user_cache_dir

from springpot.machine.files import remove_orphans, write
from springpot.machine.trusted import UntrustedFolderError, make_folder, read, reason_against, say_unused

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
