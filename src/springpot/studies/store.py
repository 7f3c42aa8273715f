"""Where answers are kept: a Zarr (version 3) store, one chunk for each task, each with its checksum.

    study.zarr/zarr.json                     group; its attributes hold the study, versions and units
    study.zarr/theory/<method>/numbers       float64, shape (2^60, columns), one row for each chunk
    study.zarr/simulation/monte_carlo/numbers
    .../sentences                            uint8, shape (2^60, 4096): warnings, or why there is no answer, as JSON

A row is the task's slot (`springpot.studies.tasks.Task`), so the arrays are preallocated once, an answer keeps its
chunk however the grid grows, and chunks that were never written take no room.  Any Zarr reader opens the store; here
chunks are written and read as the files they are (little-endian bytes and their CRC-32C, as the arrays' metadata say),
each written beside its place and moved there in one step: a tenth of the time, and nothing half-written is ever seen.

An answer is there if its file has the right length, checksum and task, never because a file exists.
"""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import socket
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import google_crc32c
import numpy as np

from springpot.studies.question import THEORIES, Study, read_study
from springpot.studies.tasks import SLOTS, Answer, Task, columns_of
from springpot.units import UNITS

__all__ = ["Damaged", "Store", "StoreError", "open_store"]

FORMAT = 1
SENTENCES = 4096  # bytes
CHECK = "task"  # first column: the task's check
KEPT_BY_OTHERS = 3600.0  # s after which another machine's half-written file is an orphan
ATTRIBUTE = "springpot_study"


class StoreError(ValueError):
    """The store cannot be used; the message says why."""


class Damaged(ValueError):
    """A chunk is there and does not hold its task's answer."""


@dataclass(frozen=True)
class Store:
    """An opened store.

    Attributes
    ----------
    path : Path
    study : Study
        The grid as it was last run.
    attributes : dict
        Of the root group.
    """

    path: Path
    study: Study
    attributes: dict[str, Any]

    def read(self, task: Task) -> Answer | None:
        """A task's answer, or None if there is none.

        Raises
        ------
        Damaged
            If its chunk is not what was written.
        """
        columns = columns_of(task.method)
        body = _read_chunk(self._chunk(task, "numbers"), 8 * (2 + len(columns)))
        if body is None:
            return None
        row = np.frombuffer(body, "<f8")
        if row[0] != float(task.check):
            raise Damaged("it holds the answer to another task")
        statement, warnings = "", ()
        if row[1] > 0.0:
            text = _read_chunk(self._chunk(task, "sentences"), SENTENCES)
            if text is None:
                raise Damaged("its sentences are missing")
            said = json.loads(text[: int(row[1])])
            statement, warnings = said["statement"], tuple(said["warnings"])
        return Answer(tuple(row[2:].tolist()), statement, warnings)

    def has(self, task: Task) -> bool:
        """Whether a task's answer is there, whole."""
        try:
            return self.read(task) is not None
        except Damaged:
            return False

    def write(self, task: Task, answer: Answer) -> None:
        """Keep an answer.  Its sentences come first, so that the numbers stand for the whole.

        Raises
        ------
        OSError
            If it cannot be written; what was there before is still there.
        """
        said = _sentences(answer)
        if said:
            _write_chunk(self._chunk(task, "sentences"), said.ljust(SENTENCES, b"\0"))
        row = np.array([float(task.check), float(len(said)), *answer.numbers], "<f8")
        _write_chunk(self._chunk(task, "numbers"), row.tobytes())

    def remove_orphans(self) -> int:
        """Remove what killed processes left half-written; files of processes at work are left alone."""
        removed = 0
        for method in self.study.methods:
            for array in ("numbers", "sentences"):
                for entry in os.scandir(self.path / _place(method) / array):
                    if entry.name.startswith(".") and _is_orphan(entry):
                        with contextlib.suppress(FileNotFoundError):
                            os.unlink(entry.path)
                            removed += 1
        return removed

    def _chunk(self, task: Task, array: str) -> str:
        return f"{self.path}/{_place(task.method)}/{array}/{task.slot}.0"


def _place(method: str) -> str:
    return f"theory/{method}" if method in THEORIES else f"simulation/{method}"


def _sentences(answer: Answer) -> bytes:
    """Statement and warnings as JSON, at most SENTENCES bytes: of more warnings than fit, the first ones."""
    if not answer.statement and not answer.warnings:
        return b""
    for kept in range(len(answer.warnings), -1, -1):
        text = json.dumps({"statement": answer.statement, "warnings": answer.warnings[:kept]}).encode()
        if len(text) <= SENTENCES:
            return text
    return json.dumps({"statement": answer.statement[:500], "warnings": ()}).encode()


def _write_chunk(path: str, body: bytes) -> None:
    _write(path, body + google_crc32c.value(body).to_bytes(4, "little"))


def _write(path: str, content: bytes) -> None:
    """Write a file beside its place and move it there."""
    folder, name = os.path.split(path)
    # the name tells whose it is, in case its writer is killed
    partial = f"{folder}/.{name}.{socket.gethostname()}.{os.getpid()}.{threading.get_native_id()}"
    try:
        with open(partial, "wb") as file:
            file.write(content)
        os.replace(partial, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(partial)
        raise


def _read_chunk(path: str, size: int) -> bytes | None:
    try:
        with open(path, "rb") as file:
            found = file.read(size + 5)
    except FileNotFoundError:
        return None
    if len(found) != size + 4:
        raise Damaged("its length is wrong")
    body = found[:-4]
    if google_crc32c.value(body) != int.from_bytes(found[-4:], "little"):
        raise Damaged("its checksum is wrong")
    return body


def _is_orphan(entry: os.DirEntry[str]) -> bool:
    with contextlib.suppress(ValueError, FileNotFoundError):
        _, host, process = entry.name.rsplit(".", 2)[0].rpartition(f".{socket.gethostname()}.")
        if host and not _is_alive(int(process)):
            return True
        return time.time() - entry.stat().st_mtime > KEPT_BY_OTHERS
    return False


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def open_store(path: str | Path, study: Study | None = None) -> Store:
    """Open a store, or make it if there is none and a study is given.

    Parameters
    ----------
    path : str or Path
    study : Study, optional
        What is to be run: the store must be this study's, and grows if its axes or methods have.

    Returns
    -------
    Store

    Raises
    ------
    StoreError
        If the store is another study's, was made by a newer version, or is no store of ours.
    OSError
        If it cannot be read or written.
    """
    path = Path(path)
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        if study is None:
            raise StoreError(f"there is no store {str(path)!r}: springpot study run FILE --store {path} makes one.")
        _make(path, study)
    attributes = _attributes(path)
    kept = read_study(attributes["study"])
    if study is None or _document(study) == _document(kept):
        return Store(path, kept, attributes)
    _check_same(path, kept, study)
    for method in set(study.methods) - set(kept.methods):
        _make_arrays(path, method)
    attributes = _write_attributes(path, {**attributes, "study": _document(study)})
    return Store(path, study, attributes)


def _attributes(path: Path) -> dict[str, Any]:
    from importlib.metadata import version

    try:
        content = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
        attributes = content["attributes"]
        ours = attributes[ATTRIBUTE]
        kept, made_by = ours["format"], ours["versions"][-1]["springpot"]
    except (FileNotFoundError, NotADirectoryError, ValueError, TypeError, KeyError, IndexError):
        raise StoreError(
            f"{str(path)!r} is not a store of a springpot study: give the place of one, or a new place."
        ) from None
    if kept > FORMAT or _release(made_by) > _release(version("springpot")):
        raise StoreError(
            f"store {str(path)!r} was written by springpot {made_by} (store format {kept}), newer than this one "
            f"({version('springpot')}, format {FORMAT}): install that version, or use a new store."
        )
    return dict(ours)


def _release(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split("+")[0].split(".") if part.isdigit())


def _check_same(path: Path, kept: Study, given: Study) -> None:
    """A study may get other values on its axes, other methods and quantities; all else makes it another one."""
    apart = []
    for name in ("name", "seed", "fixed", "monte_carlo"):
        before, now = getattr(kept, name), getattr(given, name)
        if before != now and not (name == "monte_carlo" and None in (before, now)):
            apart.append(name)
    if set(kept.shape) != set(given.shape) or set(kept.columns) != set(given.columns):
        apart.append("names of axes")
    if apart:
        raise StoreError(
            f"store {str(path)!r} is of another study ({kept.name!r}; {' and '.join(apart)} differ): only the "
            "values on the axes, methods and quantities may change in a store, so use another store for "
            f"{given.name!r}."
        )


def _make(path: Path, study: Study) -> None:
    """Make the store beside its place and move it there, so that no half-made store is ever seen."""
    import zarr

    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as folder:
        made = Path(folder) / "store"
        zarr.create_group(made, zarr_format=3)
        for method in study.methods:
            _make_arrays(made, method)
        _write_attributes(made, {"format": FORMAT, "study": _document(study), "versions": []})
        try:
            os.rename(made, path)
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise  # otherwise another process was quicker


def _make_arrays(path: Path, method: str) -> None:
    import zarr
    from zarr.codecs import BytesCodec, Crc32cCodec

    columns = columns_of(method)
    group = zarr.open_group(path, mode="r+")
    shapes: dict[str, tuple[int, Any, float, dict[str, Any]]] = {
        "numbers": (2 + len(columns), "float64", math.nan, {"columns": [CHECK, "sentences_length", *columns],
                                                            "units": ["1", "1", *map(_unit, columns)]}),
        "sentences": (SENTENCES, "uint8", 0, {"encoding": "JSON in UTF-8, padded with zero bytes"}),
    }  # fmt: skip
    for name, (width, kind, empty, attributes) in shapes.items():
        place = f"{_place(method)}/{name}"
        if place in group:
            continue
        group.create_array(
            place,
            shape=(SLOTS, width),
            chunks=(1, width),
            dtype=kind,
            fill_value=empty,
            filters=(),
            serializer=BytesCodec(endian="little"),
            compressors=(Crc32cCodec(),),
            chunk_key_encoding={"name": "v2", "separator": "."},
            attributes=attributes,
        )


def _unit(column: str) -> str:
    for part in ("_se", "_error"):
        column = column.removesuffix(part)
    return UNITS[column]


def _document(study: Study) -> dict[str, Any]:
    """The study as its file says it, axes written out."""
    return study.model_dump(mode="json", exclude_none=True, exclude_unset=True)


def _write_attributes(path: Path, ours: dict[str, Any]) -> dict[str, Any]:
    """Put the attributes into the root's metadata, in one step, with the versions at work."""
    from importlib.metadata import version

    import numba

    versions = {"springpot": version("springpot"), "numba": numba.__version__, "numpy": np.__version__}
    if versions not in ours["versions"]:
        ours = {**ours, "versions": [*ours["versions"], versions]}
    place = path / "zarr.json"
    content = json.loads(place.read_text(encoding="utf-8"))
    content["attributes"] = {
        **content["attributes"],
        "Conventions": "CF-1.11",
        "title": ours["study"]["name"],
        ATTRIBUTE: ours,
    }
    _write(str(place), json.dumps(content, indent=1).encode())
    return ours


def chunks(store: Store, method: str) -> Iterator[str]:
    """Names of the number chunks that a method has in the store, whether of the present grid or not."""
    for entry in os.scandir(store.path / _place(method) / "numbers"):
        if entry.name.endswith(".0") and not entry.name.startswith("."):
            yield entry.name
