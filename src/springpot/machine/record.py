"""One record of finished tasks: what a process has computed is kept, whatever ends it, and another goes on from there.

A record is a text file to which lines are added and nothing else.  A line is a word that says what the record is of, a
checksum of the rest, the key of a task and its result as JSON.  A result is a function of its key.  So what is read is
what would be computed, and what was damaged, or begun by a killed process, is computed again, to the same bits.

Several processes, also of several machines, share a folder: each adds to a file of its own, and reads all of them.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import socket
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from springpot.machine.faults import FileError
from springpot.machine.files import append_line, open_bytes
from springpot.machine.platforms import patiently

ENDING = ".tasks"  # of the files in a folder
_DIGITS = 32  # of a checksum or a key
_LONGEST = 2**28  # bytes of a line: more is damage
_LARGEST, _LARGEST_OF_MANY = 2**30, 2**40  # bytes of a file


def digest(content: object) -> str:
    """A key: the digest of all that a result depends on, in plain values.

    Examples
    --------
    >>> digest({"order": 0.5}) == digest({"order": 0.5}) != digest({"order": 0.6})
    True
    """
    # Python writes the shortest decimal that reads back as the same double: equal text, equal numbers
    return _checksum(json.dumps(content, sort_keys=True).encode())


def line_of(kind: str, key: str, result: object) -> bytes:
    """A line of a record, without its end."""
    body = f"{key} {json.dumps(result)}"
    return f"{kind} {_checksum(body.encode())} {body}".encode()


def parts_of(kind: str, line: bytes) -> tuple[str, bytes] | None:
    """The key and the JSON of a line; None if it was damaged, or is not whole.

    Examples
    --------
    >>> parts_of("study", line_of("study", "a", [0.5])), parts_of("study", b"study 0 a [0.5]")
    (('a', b'[0.5]'), None)
    """
    word, _, rest = line.removesuffix(b"\n").partition(b" ")
    checksum, _, body = rest.partition(b" ")
    if word != kind.encode() or checksum != _checksum(body).encode():
        return None
    key, _, result = body.partition(b" ")
    return key.decode(errors="replace"), result


class Record:
    """The finished tasks in a file, or in a folder that processes share.

    Parameters
    ----------
    path : Path
        A file is made if missing.
    kind : str
        The word with which its lines begin.
    title : str
        Names it in errors.
    shared : bool
        Whether ``path`` is a folder.

    Attributes
    ----------
    damaged : int
        Lines that were damaged.

    Raises
    ------
    FileError
        If the file holds something else, cannot be read or written, is no file, or is too large.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     Record(Path(folder) / "squares", "squares").add("3", 9)
    ...     again = Record(Path(folder) / "squares", "squares")
    ...     again.get("3"), again.get("4"), again.of("4", lambda: 16)
    (9, None, 16)
    """

    def __init__(self, path: Path, kind: str, title: str = "record", *, shared: bool = False) -> None:
        own = f"{socket.gethostname()}.{os.getpid()}.{os.urandom(4).hex()}{ENDING}"
        self._folder = path if shared else None
        self._own = path / own if shared else path
        self._kind, self._title, self._most = kind, title, _LARGEST_OF_MANY if shared else _LARGEST
        self._places: dict[str, tuple[Path, int]] = {}
        self._ends = defaultdict[Path, int](int)
        self._lock = threading.Lock()
        self.damaged = 0
        self.read()
        if shared:
            return
        begin = f"{kind} ".encode()
        try:
            append_line(self._own, b"")  # an error unless lines may be added
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise FileError(f"{title} {str(self._own)!r} cannot be written: {reason}.") from None
        with open(self._own, "rb") as file:
            if not self._places and not begin.startswith(file.read(len(begin))):
                raise FileError(f"{title} must be a file of {kind} or a new one, and {str(self._own)!r} is not.")

    def read(self) -> None:
        """Look for what was added since, also by other processes."""
        with self._lock:
            for path in [*self._grown()]:
                title = f"{self._title} {str(path)!r}"
                with contextlib.suppress(FileNotFoundError), open_bytes(path, title, self._most) as file:
                    at = file.seek(self._ends[path])
                    while line := file.readline(_LONGEST):
                        if (parts := parts_of(self._kind, line)) is not None:
                            self._places[parts[0]] = path, at
                        elif not line.endswith(b"\n") and len(line) < _LONGEST:
                            break  # begun by a killed process, or just being written
                        else:
                            self.damaged += bool(line.strip())
                        at += len(line)
                    self._ends[path] = at

    def _grown(self) -> Iterator[Path]:
        """The files in which there is something to be read."""
        if self._folder is None:
            yield self._own
            return
        with contextlib.suppress(FileNotFoundError), os.scandir(self._folder) as entries:
            for entry in entries:
                path = self._folder / entry.name
                with contextlib.suppress(OSError):  # a link that leads nowhere
                    if entry.name.endswith(ENDING) and entry.is_file() and entry.stat().st_size != self._ends[path]:
                        yield path

    def get(self, key: str) -> Any:
        """The result of a task, or None if what was read has none that is right."""
        if key not in self._places:
            return None
        path, at = self._places[key]
        try:
            with open_bytes(path, self._title, self._most) as file:
                file.seek(at)
                parts = parts_of(self._kind, file.readline(_LONGEST))
            return json.loads(parts[1]) if parts is not None and parts[0] == key else None
        except (FileNotFoundError, ValueError, RecursionError):
            return None

    def add(self, key: str, result: Any) -> None:
        """Add the result of a task.

        Raises
        ------
        OSError
            If it cannot be written; what was there stays.
        """
        with self._lock:
            self._places[key] = self._own, append_line(self._own, line_of(self._kind, key, result))

    def of(self, key: str, compute: Callable[[], Any]) -> Any:
        """The result of a task: what is there, also from another process, or what is computed now and added."""
        self.read()
        if (result := self.get(key)) is None:
            result = compute()
            self.add(key, result)
        return result

    def remove(self) -> None:
        """Remove the file, when what was computed is kept elsewhere."""
        patiently(self._own.unlink, missing_ok=True)


@contextlib.contextmanager
def writing(what: str) -> Iterator[None]:
    """One sentence if a disk is full, or cannot be written for another reason."""
    try:
        yield
    except OSError as error:
        raise OSError(
            f"{what} cannot be written ({error.strerror or error}): all results so far are kept, and running it again "
            "continues from there."
        ) from error


def _checksum(body: bytes) -> str:
    return hashlib.sha256(body).hexdigest()[:_DIGITS]
