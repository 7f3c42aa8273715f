"""The store of a study's results: Zarr (version 3), one chunk for each task, each with its checksum.

    study.zarr/zarr.json                     group; its attributes hold the study, versions and units
    study.zarr/theory/<method>/numbers       float64, shape (2^60, columns), one row for each chunk
    study.zarr/simulation/<monte_carlo or exceedance>/numbers
    .../numbers/<slot>.repetitions           of exceedance: those that have ended, until their task has a result
    .../sentences                            uint8, shape (2^60, 4096): warnings, or why there is no result, as JSON

A row is the task's slot (`springpot.studies.tasks.Task`), so the shape of the arrays is fixed, a result keeps its chunk
when the grid grows, and chunks that were never written take no space.

A result is valid if Zarr can decode its chunk, whose checksum must be right, and it is the task's.
"""

from __future__ import annotations

import errno
import json
import math
import os
import re
import shutil
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from springpot.machine.arguments import checked_path
from springpot.machine.faults import FileError
from springpot.machine.files import Damaged, make_room, partial_name, read_file, remove_orphans, write
from springpot.machine.places import shell_word
from springpot.machine.versions import __version__, versions
from springpot.studies.layout import ARRAYS, metadata, open_arrays, place_of, root
from springpot.studies.question import Study, read_study
from springpot.studies.tables import SIMULATED
from springpot.studies.tasks import SENTENCES, Answer, Task, tasks

FORMAT = 1
ATTRIBUTE = "springpot_study"
REPETITIONS = ".repetitions"
CONSOLIDATED = "consolidated_metadata"
MOST_METADATA = 2**28  # bytes of a zarr.json: a million values on axes take a tenth of it
VERSION = r"[\w.+!-]{1,40}"  # of a program; other text is not printed to a terminal
CHECKSUM = "crc32"  # of the root's other attributes


class StoreError(FileError):
    """The store cannot be used; the message says why."""


@dataclass(frozen=True)
class Store:
    """An opened store.

    Attributes
    ----------
    path : Path
    study : Study
        The grid as it was last run.
    versions : list of dict
        Versions of springpot, numba and numpy that worked on it.
    """

    path: Path
    study: Study
    versions: list[dict[str, str]]

    @cached_property
    def metadata(self) -> dict[str, bytes]:
        """The metadata of groups and arrays by their places, as they should be."""
        return metadata({method: self.study.columns_of(method) for method in self.study.methods})

    @cached_property
    def _arrays(self) -> dict[str, Any]:
        return open_arrays(self.path, self.metadata)

    def read(self, task: Task) -> Answer | None:
        """A task's result, or None if there is none.

        Raises
        ------
        Damaged
            If its chunk is damaged.
        """
        numbers, sentences = (self._arrays[f"{place_of(task.method)}/{array}"] for array in ARRAYS)
        try:
            row = numbers[task.slot].tolist()
            text = sentences[task.slot].tobytes()[: int(row[1])] if row[1] > 0.0 else b""
        except ValueError as error:
            raise Damaged(str(error)) from None
        if math.isnan(row[0]):
            return None
        if row[0] != float(task.check):
            raise Damaged("it holds the result of another task")
        if not text:
            return Answer(tuple(row[2:]), "", ())
        try:
            content = json.loads(text)
            owner, statement, warnings = content["task"], content["statement"], tuple(content["warnings"])
        except (ValueError, KeyError, TypeError):
            owner = None
        if owner != task.check:
            raise Damaged("its sentences are missing or those of another task")
        return Answer(tuple(row[2:]), statement, warnings)

    def found(self, task: Task) -> Answer | None:
        """A task's result, or None if there is none or it is damaged."""
        try:
            return self.read(task)
        except Damaged:
            return None

    def has(self, task: Task) -> bool:
        """Whether there is a valid result of a task."""
        return self.found(task) is not None

    def repetitions(self, task: Task) -> Path:
        """Where a task's repetitions are written as they end."""
        return self.path / place_of(task.method) / "numbers" / f"{task.slot}{REPETITIONS}"

    def write(self, task: Task, answer: Answer) -> None:
        """Save a result.  The sentences are written first, so that a result with numbers is complete.

        Raises
        ------
        OSError
            If it cannot be written; an earlier result is then unchanged.
        """
        numbers, sentences = (self._arrays[f"{place_of(task.method)}/{array}"] for array in ARRAYS)
        text = _sentences(task, answer)
        with writing(self.path):
            if text:
                sentences[task.slot] = np.frombuffer(text.ljust(SENTENCES, b"\0"), "u1")
            numbers[task.slot] = np.array([float(task.check), float(len(text)), *answer.numbers])
            self.repetitions(task).unlink(missing_ok=True)

    def remove_orphans(self) -> int:
        """Remove half-written files of killed processes, and repetitions of results; those in use are kept."""
        for ended in (self.path / place_of("exceedance") / "numbers").glob(f"*{REPETITIONS}"):
            if ended.with_suffix(".0").exists():
                ended.unlink(missing_ok=True)
        folders = {self.path, *((self.path / place).parent for place in self.metadata)}
        beside = remove_orphans(str(self.path.parent), self.path.name)
        return beside + sum(remove_orphans(str(folder)) for folder in folders)

    def damaged_metadata(self) -> list[str]:
        """Damaged metadata of groups and arrays, which other Zarr readers need; running the study repairs them."""
        known = self.metadata.items()
        return [place for place, right in known if metadata_of((self.path / place).parent) != json.loads(right)]

    def described(self) -> dict[str, Any]:
        """What the attributes of the root say of the study."""
        return {"format": FORMAT, "study": document(self.study), "versions": self.versions}


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """A folder that is made under another name and then renamed, so that it is never seen incomplete."""
    partial = path.with_name(partial_name(path.name))
    try:
        yield partial
        os.rename(partial, path)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):  # otherwise another process was quicker
            raise
    finally:
        shutil.rmtree(partial, ignore_errors=True)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """One sentence if a store cannot be written."""
    try:
        yield
    except OSError as error:
        raise OSError(
            f"store {str(path)!r} cannot be written ({error.strerror or error}): all results so far are kept, and "
            "running the study again continues from there."
        ) from error


def _sentences(task: Task, answer: Answer) -> bytes:
    """Statement and warnings as JSON, at most SENTENCES bytes: the first warnings if not all fit."""
    if not answer.statement and not answer.warnings:
        return b""
    statement = answer.statement if len(json.dumps(answer.statement)) < SENTENCES - 100 else answer.statement[:600]
    for kept in range(len(answer.warnings), -1, -1):
        content = {"task": task.check, "statement": statement, "warnings": answer.warnings[:kept]}
        text = json.dumps(content).encode()
        if len(text) <= SENTENCES:
            break
    return text


def open_store(path: str | Path, study: Study | None = None) -> Store:
    """Open a store, or create it if a study is given.

    Parameters
    ----------
    path : str or Path
    study : Study, optional
        The study to be run: the store must be of this study; axes and methods may have been extended.

    Returns
    -------
    Store

    Raises
    ------
    StoreError
        If the store is of another study, was written by a newer version, or is not a store.
    OSError
        If it cannot be read or written.

    Examples
    --------
    >>> import tempfile
    >>> orders = read_study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5]}})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     open_store(f"{folder}/orders.zarr", orders).study.shape
    {'order': 2}
    """
    path = checked_path(path, "store")
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        if study is None:
            raise StoreError(
                f"there is no store {str(path)!r}: springpot study run FILE --store {shell_word(path)} creates one."
            )
        _make(path, study)
    ours = _ours(path)
    if study is None:
        if ours is None:
            raise StoreError(
                f"the description of store {str(path)!r} (its zarr.json) is damaged: springpot study run FILE --store "
                f"{shell_word(path)}, with the study's file, writes it again and keeps every result."
            )
        return Store(path, read_study(ours["study"]), ours["versions"])
    if ours is None:
        lost = Store(path, study, [])
        empty = all(not entry.name.endswith(".0") for entry in path.glob("*/*/numbers/*"))
        if not empty and not any(lost.has(task) for task in tasks(study)):
            raise StoreError(
                f"the description of store {str(path)!r} (its zarr.json) is damaged, and none of its results belong to "
                f"{study.name!r}: give the study file that it was made from."
            )
    else:
        _check_same(path, read_study(ours["study"]), study)
    with writing(path):
        return _describe(path, study, ours)


def metadata_of(folder: Path) -> dict[str, Any]:
    """Zarr's metadata in a folder; empty if they are missing or damaged, or no file."""
    try:
        content = json.loads(read_file(f"{folder}/zarr.json", MOST_METADATA) or b"{}")
    except (Damaged, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _ours(path: Path) -> dict[str, Any] | None:
    """The study's description in the root's attributes, or None if it is damaged."""
    content = metadata_of(path)
    try:
        ours = dict(content["attributes"][ATTRIBUTE])
        kept, made_by = int(ours["format"]), ours["versions"][-1]["springpot"]
        bare = {name: part for name, part in content.items() if name != CONSOLIDATED}
        right = re.fullmatch(VERSION, made_by) is not None and (kept > FORMAT or bare == json.loads(root_of(ours)))
    except (AttributeError, TypeError, KeyError, IndexError, ValueError, OverflowError, RecursionError):
        right = False
    if not right:
        if any(path.glob("*/*/numbers")):
            return None
        raise StoreError(
            f"{str(path)!r} is not a store of a springpot study: give the folder of a store, or a new folder."
        )
    if kept > FORMAT or _release(made_by) > _release(__version__):
        raise StoreError(
            f"store {str(path)!r} was written by springpot {made_by} (store format {kept}), newer than this one "
            f"({__version__}, format {FORMAT}): install that version, or use a new store."
        )
    return ours


def is_store(path: Path) -> bool:
    """Whether a folder is, or was, the store of a study."""
    attributes = metadata_of(path).get("attributes")
    return (isinstance(attributes, dict) and ATTRIBUTE in attributes) or any(path.glob("*/*/numbers"))


def _release(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split("+")[0].split(".") if part.isdigit())


def _check_same(path: Path, kept: Study, given: Study) -> None:
    """Raise an error if more than the values on axes, methods and quantities has changed."""
    apart = []
    for name in ("name", "seed", "fixed", *SIMULATED):
        before, now = getattr(kept, name), getattr(given, name)
        if before != now and not (name in SIMULATED and None in (before, now)):
            apart.append(name)
    if kept.unvaried != given.unvaried:
        parts = [name for name in kept.unvaried | given.unvaried if kept.unvaried.get(name) != given.unvaried.get(name)]
        apart.append(f"system ({', '.join(parts) or 'the order of its parts'})")
    if set(kept.shape) != set(given.shape) or set(kept.columns) != set(given.columns):
        apart.append("names of axes")
    if apart:
        raise StoreError(
            f"store {str(path)!r} belongs to another study ({kept.name!r}; different: {', '.join(apart)}): only the "
            "values on the axes, methods and quantities may change in a store, so use another store for "
            f"{given.name!r}."
        )


def _make(path: Path, study: Study) -> None:
    try:
        with whole_folder(path) as partial:
            partial.mkdir(parents=True)
            _describe(partial, study, None)
    except OSError as error:
        raise OSError(f"store {str(path)!r} cannot be created ({error.strerror}).") from error


def _describe(path: Path, study: Study, ours: dict[str, Any] | None) -> Store:
    """Write all metadata of the study that are missing, damaged or outdated."""
    before, at_work = [] if ours is None else ours["versions"], versions("numba", "numpy")
    store = Store(path, study, before if at_work in before else [*before, at_work])
    for name in store.damaged_metadata():
        place = path / name
        make_room(str(place.parent), folder=True)
        place.parent.mkdir(parents=True, exist_ok=True)
        write(str(place), store.metadata[name], durable=True)
    now = store.described()
    if ours is None or {name: ours.get(name) for name in now} != now:
        try:
            write(f"{path}/zarr.json", root_of(now), durable=True)
        except OSError:
            # a read-only store is fine if only the versions are new
            if ours is None or ours["study"] != now["study"]:
                raise
    return store


def document(study: Study) -> dict[str, Any]:
    """The study as in its file, with the values of all axes."""
    return study.model_dump(mode="json", exclude_none=True, exclude_unset=True)


def root_of(ours: Mapping[str, Any], listed: Mapping[str, bytes] | None = None) -> bytes:
    """The root's metadata: the study's description with a checksum, and a list of metadata of groups and arrays."""
    attributes = {"Conventions": "CF-1.11", "title": ours["study"]["name"]}
    described = {name: part for name, part in ours.items() if name != CHECKSUM}
    text = json.dumps({**attributes, ATTRIBUTE: described}, sort_keys=True)
    return root({**attributes, ATTRIBUTE: {**described, CHECKSUM: zlib.crc32(text.encode())}}, listed or {})
