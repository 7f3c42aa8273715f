"""Atomic files: each is written under another name and then renamed, so that it is complete or missing."""

from __future__ import annotations

import contextlib
import csv
import errno
import functools
import io
import os
import re
import shlex
import shutil
import socket
import stat
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

from springpot.machine.faults import FileError
from springpot.machine.platforms import AT_ONCE, WINDOWS, alone, is_alive, patiently

if TYPE_CHECKING:
    from xarray import DataTree

_Read = TypeVar("_Read")

KEPT_BY_OTHERS = 3600.0  # s after which a half-written file of another machine is an orphan
ATTEMPTS = 3


class Damaged(ValueError):
    """A file exists, but its content is damaged."""


def read_file(path: str, largest: int) -> bytes | None:
    """Content of a file, or None if it or its folder does not exist.  Never blocks, as opening a named pipe would.

    Raises
    ------
    Damaged
        If a folder, a pipe, a device or a loop of links is in its place, or it has more than ``largest`` bytes.
    OSError
        If it cannot be read.
    """
    try:
        with _opened(path) as file:
            content = file.read(largest + 1)
    except (FileNotFoundError, NotADirectoryError):
        return None
    if len(content) > largest:
        raise Damaged(_too_large(largest))
    return content


@contextlib.contextmanager
def _opened(path: str) -> Iterator[BinaryIO]:
    """A file, opened without waiting; what is no file is Damaged."""
    if "\0" in path:
        raise Damaged("its name has a null character")
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise Damaged("it is not a file, but a pipe or a device")
            yield file
    except OSError as error:
        if os.path.isdir(path):
            raise Damaged("it is a folder, not a file") from None
        if error.errno == errno.ELOOP:
            raise Damaged("it is a link that leads back to itself") from None
        if error.errno == errno.ENXIO:
            raise Damaged("it is not a file, but a socket") from None
        raise


def _too_large(largest: int) -> str:
    return f"it has more than {largest:,} bytes"


def read_text(path: str | Path, title: str, largest: int) -> str:
    """The text of a file in UTF-8; a byte order mark at its beginning is ignored.

    Parameters
    ----------
    path : str or Path
    title : str
        Name of the file in errors, such as ``"study file 'a.toml'"``.
    largest : int
        Most bytes.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    FileError
        If it cannot be read, is not a file, too large or not UTF-8.
    """
    with _sentences(path, title):
        body = read_file(str(path), largest)
        if body is None:
            raise FileNotFoundError
        return body.decode("utf-8-sig")


@contextlib.contextmanager
def open_bytes(path: str | Path, title: str, largest: int) -> Iterator[BinaryIO]:
    """A file to be read line by line: no more of it is in memory than is asked for.

    Parameters
    ----------
    path, title, largest
        As of `read_text`.

    Raises
    ------
    FileNotFoundError, FileError
        As `read_text`, whatever the bytes are.
    """
    with _sentences(path, title), _opened(str(path)) as file:
        if os.fstat(file.fileno()).st_size > largest:
            raise Damaged(_too_large(largest))
        yield file


def read_by(reader: Callable[[str], _Read], content: bytes, title: str, what: str) -> _Read:
    """What a reader of another library finds in content, which it takes from a file; it prints and warns in vain.

    Raises
    ------
    FileError
        Whatever a damaged file makes of the reader.

    Examples
    --------
    >>> read_by(lambda path: len(open(path).read()), b"one", "file 'a.txt'", "a text")
    3
    """
    import tempfile  # slow to import

    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "content"
        place.write_bytes(content)
        try:
            with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
                warnings.simplefilter("ignore")
                return reader(str(place))
        except Exception as fault:
            why = " ".join(str(fault).split())[:100] or type(fault).__name__
            raise FileError(f"{title} cannot be read as {what}, it seems damaged: {why}.") from None


def append_line(path: str | Path, line: bytes) -> int:
    """Write a line at the end of a file, which is made if missing; a line that a killed process began stays as it is.

    An empty line only makes the file.

    Returns
    -------
    int
        Where the line begins.

    Raises
    ------
    OSError
        If it cannot be written: also where a folder, a pipe or a device is in its place, which is never waited for.
    """
    with open(path, "ab+", buffering=0, opener=_without_waiting) as file, alone(file.fileno()):
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(errno.EINVAL, "it is not a file, but a pipe or a device", str(path))
        end, begun = file.seek(0, os.SEEK_END), False
        if not line:
            return end
        if end:
            file.seek(-1, os.SEEK_END)
            begun = file.read(1) != b"\n"
        left = memoryview(b"\n" * begun + line + b"\n")
        while left:  # a disk that is nearly full takes a part, and says so only when it is asked again
            left = left[file.write(left) :]
        return file.tell() - len(line) - 1  # others may have written meanwhile


@contextlib.contextmanager
def _sentences(path: str | Path, title: str) -> Iterator[None]:
    """One sentence for whatever goes wrong with reading a text."""
    try:
        yield
    except (FileNotFoundError, NotADirectoryError):
        raise FileNotFoundError(f"There is no file {str(path)!r}.") from None
    except Damaged as fault:
        raise FileError(f"{title} cannot be read: {fault}.") from None
    except UnicodeDecodeError:
        raise FileError(f"{title} is not text in UTF-8.") from None
    except OSError as error:
        raise FileError(f"{title} cannot be read: {(error.strerror or str(error)).lower()}.") from None


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | AT_ONCE, 0o666)


def make_room(path: str, *, folder: bool = False) -> None:
    """Remove what holds no data from the place of a file (of a ``folder``): an empty folder, a pipe, a broken link.

    Raises
    ------
    FileExistsError
        If what is there may be somebody's: a file in place of a folder, or a folder that is not empty.
    """
    try:
        # a link counts as its target, and is removed only if it is broken
        kind = os.stat(path).st_mode
    except OSError as error:
        if error.errno not in (errno.ENOENT, errno.ELOOP):
            raise
        kind = None
    if kind is None:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(path)
    elif stat.S_ISDIR(kind) and not folder:
        try:
            os.rmdir(path)
        except OSError:
            raise FileExistsError(f"{path!r} is a folder, but a file belongs there: remove it") from None
    elif stat.S_ISREG(kind) and folder:
        raise FileExistsError(f"{path!r} is a file, but a folder belongs there: remove it")
    elif not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
        os.unlink(path)


def partial_name(name: str) -> str:
    """Name of a file while it is written: with host, process and thread, in case the process is killed."""
    return f".{name}.{socket.gethostname()}.{os.getpid()}.{threading.get_native_id()}"


def write(path: str, content: bytes | memoryview, *, durable: bool = False, private: bool = False) -> None:
    """Write a file under another name and rename it.

    ``durable`` waits until it is on disk, so that even a power failure leaves the old file or the new one: for files
    that cannot be computed again.  A ``private`` file can be read and written by this user only.
    """
    folder, name = os.path.split(path)
    partial = os.path.join(folder, partial_name(name))
    for attempt in range(ATTEMPTS):
        try:
            with open(partial, "wb", opener=functools.partial(os.open, mode=0o600) if private else None) as file:
                file.write(content)
                if durable:
                    file.flush()
                    os.fsync(file.fileno())
            try:
                patiently(os.replace, partial, path)
            except (IsADirectoryError, PermissionError):  # of a folder, in POSIX and in Windows
                if not os.path.isdir(path):
                    raise
                make_room(path)
                patiently(os.replace, partial, path)
        except BaseException as error:
            with contextlib.suppress(OSError):
                os.unlink(partial)
            # a container of the same name that does not see this process took the file for an orphan
            if isinstance(error, FileNotFoundError) and os.path.isdir(folder) and attempt < ATTEMPTS - 1:
                continue
            raise
        return


def write_table(path: Path, rows: Iterable[Iterable[object]]) -> None:
    """Write rows, the header first, as a CSV file, as `write` does."""
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows(rows)
    write(str(path), text.getvalue().encode())


def netcdf_of(tree: DataTree, encoding: Mapping[str, Any] | None = None) -> memoryview:
    """A netCDF file in memory: HDF5 itself ends the process where the disk is full."""
    content = io.BytesIO()
    tree.to_netcdf(content, engine="h5netcdf", encoding=encoding)
    return content.getbuffer()


def remove_orphans(folder: str, name: str = "") -> int:
    """Remove half-written files of killed processes from a folder (of one name); those of running ones are kept."""
    removed = 0
    with contextlib.suppress(FileNotFoundError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(f".{name}." if name else ".") and _is_orphan(entry):
                with contextlib.suppress(OSError):  # another process was quicker, or the store can only be read
                    shutil.rmtree(entry.path) if entry.is_dir() else os.unlink(entry.path)
                    removed += 1
    return removed


def _is_orphan(entry: os.DirEntry[str]) -> bool:
    rest, *numbers = entry.name.rsplit(".", 2)
    if len(numbers) < 2 or not all(number.isdigit() for number in numbers):
        return False  # not ours
    if rest.endswith(f".{socket.gethostname()}") and not is_alive(int(numbers[0])):
        return True
    try:
        return time.time() - entry.stat().st_mtime > KEPT_BY_OTHERS
    except FileNotFoundError:
        return False


def shell_word(path: str | Path) -> str:
    """A file's name as a person can copy it into a shell: quoted, on one line, and no flag.

    Examples
    --------
    >>> shell_word("device.toml"), shell_word("-device.toml")
    ('device.toml', './-device.toml')
    """
    name = str(path)
    name = f"./{name}" if name.startswith("-") else name
    if WINDOWS:  # where double quotes do in each shell, and no name has one
        return name if re.fullmatch(r"[\w.:\\/-]+", name, re.ASCII) else f'"{name}"'
    if name.isprintable():
        return shlex.quote(name)
    escaped = ""
    for letter in name:
        own = letter.encode("utf-8", "surrogateescape")
        plain = letter.isprintable() and letter not in "'\\"
        escaped += letter if plain else "".join(f"\\x{byte:02x}" for byte in own)
    return f"$'{escaped}'"  # of Bash, which has escapes
