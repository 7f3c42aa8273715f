"""Checks that only this user can have written a file, for caches.

A cached kernel is machine code, and whoever can write it runs commands as the user who loads it.  So a cache is used
only where its folder and its files belong to this user or to the administrator, nobody else can write them, and nobody
else can put another folder in their place: each folder above is checked in the same way, with each symbolic link on the
way.  A folder like ``/tmp``, in which others can write and where the sticky bit keeps them from moving what is not
theirs, may be one of those above.

A group may write where it is this user's own (the group of one user that many systems make).  Without user numbers
(Windows) a folder is trusted if it lies in the user's home, which other users cannot write unless they are let in.
"""

from __future__ import annotations

import contextlib
import os
import stat
import warnings
from functools import lru_cache
from pathlib import Path

__all__ = ["CacheWarning", "UntrustedFolderError", "make_folder", "read", "reason_against", "say_unused"]

_MOST_LINKS = 40  # as in Linux


class UntrustedFolderError(OSError):
    """Another user can write in a folder or replace it; the message is the reason."""


class CacheWarning(UserWarning):
    """A cache is not used; its content is computed again each time."""


@lru_cache(maxsize=64)
def say_unused(sentence: str) -> None:
    """Warn that a cache is not used, once in a process."""
    warnings.warn(sentence, CacheWarning, stacklevel=2)


def reason_against(folder: str | os.PathLike[str]) -> str | None:
    """Why files in a folder are not to be trusted, or None if they are.

    Parameters
    ----------
    folder : path
        What does not exist yet is not looked at; what exists of the folders above it is.

    Returns
    -------
    str or None
        The reason, in words that follow "because".

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as private:
    ...     alone = reason_against(private)
    ...     os.chmod(private, 0o777)
    ...     open_to_all = reason_against(private)
    >>> alone is None, "can be written by other users" in open_to_all
    (True, True)
    """
    path = Path(folder).absolute()  # with each ".." in its place: after a link it leads up from where the link leads
    if not hasattr(os, "geteuid"):
        return _against_outside_home(path)
    try:
        return _against(path)
    except OSError as error:
        return f"{str(path)!r} cannot be examined ({error.strerror})"


def make_folder(folder: str | os.PathLike[str]) -> None:
    """Create a private folder, and those above it, if it can be trusted.

    Raises
    ------
    UntrustedFolderError
        If it cannot; nothing was made then.
    OSError
        If it cannot be made.
    """
    if reason := reason_against(folder):
        raise UntrustedFolderError(reason)
    path = Path(folder).absolute()
    for place in (*reversed(path.parents), path):
        with contextlib.suppress(FileExistsError):
            if not place.is_dir():
                place.mkdir(mode=0o700)
    if reason := reason_against(path):  # of what was made meanwhile by another
        raise UntrustedFolderError(reason)


def read(path: str | os.PathLike[str], most: int) -> bytes | None:
    """Content of a file, or None if it does not exist, is not trusted, or is longer than ``most``.

    Only a regular file is read, and the file that is opened is the one that is checked: what is put in its place
    afterwards is not read.  Neither a pipe nor a device can keep the caller waiting.

    Parameters
    ----------
    path : path
    most : int
        In bytes.

    Returns
    -------
    bytes or None

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
    path = Path(path)
    if reason_against(path.parent) is not None:
        return None
    flags = os.O_RDONLY
    for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_NOCTTY", "O_BINARY"):
        flags |= getattr(os, name, 0)
    try:
        opened = os.open(path, flags)
    except OSError:
        return None
    try:
        status = os.fstat(opened)
        if not stat.S_ISREG(status.st_mode) or status.st_size > most:
            return None
        if hasattr(os, "geteuid") and (not _ours(status) or _writable_by_others(status, opened)):
            return None
        parts, left = [], most + 1
        while left and (part := os.read(opened, left)):
            parts.append(part)
            left -= len(part)
    except OSError:
        return None
    finally:
        os.close(opened)
    return b"".join(parts) if left else None


def _against(path: Path) -> str | None:
    """Check each folder and link from the root on, as the system resolves the path, up to the first missing one."""
    waiting, here, links = list(reversed(path.parts[1:])), Path(path.anchor), 0
    while True:
        try:
            status = os.lstat(here)
        except FileNotFoundError:
            return None
        if stat.S_ISLNK(status.st_mode):
            links += 1
            if not _ours(status):
                return f"the link {str(here)!r} belongs to {_owner(status)}"
            if links > _MOST_LINKS:
                return f"{str(path)!r} is a link that leads back to itself"
            target = Path(os.readlink(here))
            here = Path(target.anchor) if target.is_absolute() else here.parent
            waiting += reversed(target.parts[1:] if target.is_absolute() else target.parts)
            continue
        if not stat.S_ISDIR(status.st_mode):
            return f"{str(here)!r} is not a folder"
        if not _ours(status):
            return f"{str(here)!r} belongs to {_owner(status)}"
        if _writable_by_others(status, here) and not (waiting and status.st_mode & stat.S_ISVTX):
            return f"{str(here)!r} can be written by other users"
        if not waiting:
            return None
        name = waiting.pop()
        here = here.parent if name == ".." else here / name


def _ours(status: os.stat_result) -> bool:
    return status.st_uid in (0, os.geteuid())


def _owner(status: os.stat_result) -> str:
    import pwd

    with contextlib.suppress(KeyError):
        return f"the user {pwd.getpwuid(status.st_uid).pw_name!r}"
    return f"the user of number {status.st_uid}"


def _writable_by_others(status: os.stat_result, place: Path | int) -> bool:
    if status.st_mode & stat.S_IWOTH:
        return True
    return bool(status.st_mode & stat.S_IWGRP) and not (_group_of_one(status.st_gid) and not _has_list(place))


@lru_cache(maxsize=64)
def _group_of_one(group: int) -> bool:
    """Whether no other user is in a group."""
    import grp
    import pwd

    try:
        mine = pwd.getpwuid(os.geteuid())
        members = set(grp.getgrgid(group).gr_mem)
        members |= {user.pw_name for user in pwd.getpwall() if user.pw_gid == group}
    except (KeyError, OSError):
        return False
    return mine.pw_gid == group and members == {mine.pw_name}


def _has_list(place: Path | int) -> bool:
    """Whether an access list gives rights to more users than the mode."""
    try:
        return "system.posix_acl_access" in os.listxattr(place)
    except (AttributeError, OSError):
        return False


def _against_outside_home(path: Path) -> str | None:
    try:
        home = Path.home().resolve()
        inside = path.resolve().is_relative_to(home)
    except (OSError, RuntimeError):
        return "this user has no home folder"
    return None if inside else f"{str(path)!r} is outside this user's home {str(home)!r}"
