"""Checks that only this user can have written a file, for caches.

A cached kernel is machine code, and whoever can write it runs commands as the user who loads it.  So a file is used
only if it, its folder and each folder above belong to this user or to the administrator and nobody else can write them.
A folder like ``/tmp``, where the sticky bit keeps others from moving what is not theirs, may be one of those above.
Without user numbers (Windows) a folder is trusted if it lies in the user's home.
"""

from __future__ import annotations

import os
import stat
import warnings
from functools import lru_cache
from pathlib import Path

from springpot.machine.platforms import AT_ONCE, NO_LINK, user_number


class UntrustedFolderError(OSError):
    """Another user can write in a folder or replace it; the message is the reason."""


class CacheWarning(UserWarning):
    """A cache is not used; its content is computed again each time."""


@lru_cache(maxsize=64)
def say_unused(sentence: str) -> None:
    """Warn that a cache is not used, once in a process."""
    warnings.warn(sentence, CacheWarning, stacklevel=2)


def reason_against(folder: str | os.PathLike[str]) -> str | None:
    """Why files in a folder are not to be trusted, in words that follow "because", or None if they are.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as private:
    ...     reason_against(private) is None
    True
    """
    path, real = Path(folder).absolute(), Path(os.path.realpath(folder))
    user = user_number()
    if user is None:
        home = Path(os.path.realpath(os.path.expanduser("~")))
        return None if real.is_relative_to(home) else f"{str(path)!r} is outside this user's home {str(home)!r}"
    for place in dict.fromkeys((path, *path.parents, real, *real.parents)):
        try:
            status = os.lstat(place)
        except (FileNotFoundError, NotADirectoryError):
            continue
        except OSError as error:
            return f"{str(place)!r} cannot be examined ({error.strerror})"
        if status.st_uid not in (0, user):
            return f"{str(place)!r} belongs to the user of number {status.st_uid}"
        sticky = place != real and status.st_mode & stat.S_ISVTX
        if status.st_mode & 0o022 and not sticky and not stat.S_ISLNK(status.st_mode):
            return f"{str(place)!r} can be written by other users"
    return None


def make_folder(folder: str | os.PathLike[str]) -> None:
    """Create a private folder, and those above it.

    Raises
    ------
    UntrustedFolderError
        If it cannot be trusted; nothing was made then.
    OSError
        If it cannot be made.
    """
    real = Path(os.path.realpath(folder))
    for places in ((*reversed(real.parents), real), ()):  # and again: another user may have been quicker
        if reason := reason_against(folder):
            raise UntrustedFolderError(reason)
        for place in places:
            place.mkdir(mode=0o700, exist_ok=True)


def read(path: str | os.PathLike[str], most: int) -> bytes | None:
    """Content of a file, or None if it does not exist, is not trusted, or is longer than ``most`` bytes.

    The file that is opened is the one that is checked.  Neither a pipe nor a device can keep the caller waiting.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as private:
    ...     place = Path(private) / "some"
    ...     _ = place.write_bytes(b"words")
    ...     os.chmod(place, 0o600)
    ...     read(place, 5), read(place, 4)
    (b'words', None)
    """
    if reason_against(Path(path).parent) is not None:
        return None
    try:
        with open(path, "rb", opener=_no_link_and_no_waiting) as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode) or status.st_size > most:
                return None
            user = user_number()
            if user is not None and (status.st_uid not in (0, user) or status.st_mode & 0o022):
                return None
            content = file.read(most + 1)
            return content if len(content) <= most else None
    except OSError:
        return None


def _no_link_and_no_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | NO_LINK | AT_ONCE)
