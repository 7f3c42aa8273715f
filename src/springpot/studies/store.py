"""The store of a study's results: Zarr (version 3), one chunk for each task, each with its checksum.

    study.zarr/zarr.json                     group; its attributes hold the study, versions and units
    study.zarr/theory/<method>/numbers       float64, shape (2^60, columns), one row for each chunk
    study.zarr/simulation/monte_carlo/numbers
    .../sentences                            uint8, shape (2^60, 4096): warnings, or why there is no result, as JSON

A row is the task's slot (`springpot.studies.tasks.Task`), so the shape of the arrays is fixed, a result keeps its chunk
when the grid grows, and chunks that were never written take no space.  Any Zarr reader can open the store.  Here chunks
are written and read directly as files (little-endian bytes and their CRC-32C, as the arrays' metadata say), which takes
a tenth of the time.  A file is written under another name and then renamed, so that it is never seen half-written.

A result is valid if its file has the right length, checksum and task.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from springpot.machine.faults import FileError
from springpot.machine.files import (
    Damaged,
    checksum,
    make_room,
    partial_name,
    read_chunk,
    read_file,
    remove_orphans,
    write,
    write_chunk,
)
from springpot.studies.columns import columns_of
from springpot.studies.layout import ARRAYS, LABELLED, SENTENCES, group, metadata, place_of
from springpot.studies.question import Study, read_study
from springpot.studies.tasks import Answer, Task, tasks

__all__ = [
    "Damaged",
    "Store",
    "StoreError",
    "cannot_write",
    "describe_labelled",
    "is_store",
    "listed",
    "metadata_of",
    "open_store",
    "take_away_labelled",
]

FORMAT = 1
ATTRIBUTE = "springpot_study"
CONSOLIDATED = "consolidated_metadata"
MOST_METADATA = 2**28  # bytes of a zarr.json: a million values on axes take a tenth of it
VERSION = r"[\w.+!-]{1,40}"  # of a program; other text is not printed to a terminal
CHECKSUM = "crc32c"  # of the root's other metadata


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

    def read(self, task: Task) -> Answer | None:
        """A task's result, or None if there is none.

        Raises
        ------
        Damaged
            If its chunk is damaged.
        """
        columns = self._columns[task.method]
        body = read_chunk(self._chunk(task, "numbers"), 8 * (2 + len(columns)))
        if body is None:
            return None
        row = np.frombuffer(body, "<f8")
        if row[0] != float(task.check):
            raise Damaged("it holds the result of another task")
        statement, warnings = "", ()
        if row[1] > 0.0:
            text = read_chunk(self._chunk(task, "sentences"), SENTENCES)
            if text is None:
                raise Damaged("its sentences are missing")
            try:
                content = json.loads(text[: int(row[1])])
                owner, statement, warnings = content["task"], content["statement"], tuple(content["warnings"])
            except (ValueError, KeyError, TypeError):
                owner = None
            if owner != task.check:
                raise Damaged("it holds the sentences of another task")
        return Answer(tuple(row[2:].tolist()), statement, warnings)

    @cached_property
    def _columns(self) -> dict[str, tuple[str, ...]]:
        return {method: columns_of(method, self.study.system) for method in self.study.methods}

    def has(self, task: Task) -> bool:
        """Whether there is a valid result of a task."""
        try:
            return self.read(task) is not None
        except Damaged:
            return False

    def write(self, task: Task, answer: Answer) -> None:
        """Save a result.  The sentences are written first, so that a result with numbers is complete.

        Raises
        ------
        OSError
            If it cannot be written; an earlier result is then unchanged.
        """
        sentences = _sentences(task, answer)
        row = np.array([float(task.check), float(len(sentences)), *answer.numbers], "<f8")
        try:
            if sentences:
                write_chunk(self._chunk(task, "sentences"), sentences.ljust(SENTENCES, b"\0"))
            write_chunk(self._chunk(task, "numbers"), row.tobytes())
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def remove_orphans(self) -> int:
        """Remove half-written files of killed processes; those of running processes are kept."""
        places = [f"{place_of(method)}/{array}" for method in self.study.methods for array in ARRAYS]
        folders = {"", *places, *metadata(self.study.methods, self.study.system)}
        beside = remove_orphans(str(self.path.parent), self.path.name)
        return beside + sum(remove_orphans(f"{self.path}/{folder}") for folder in folders)

    def damaged_metadata(self) -> list[str]:
        """Damaged metadata of groups and arrays, which other Zarr readers need; running the study repairs them."""
        expected = metadata(self.study.methods, self.study.system)
        return [f"{place}/zarr.json" for place in expected if _json(self.path / place / "zarr.json") != expected[place]]

    def _chunk(self, task: Task, array: str) -> str:
        return f"{self.path}/{place_of(task.method)}/{array}/{task.slot}.0"


def cannot_write(path: Path, error: OSError) -> OSError:
    """The error to raise if a store cannot be written."""
    return OSError(
        f"store {str(path)!r} cannot be written ({error.strerror or error}): all results so far are kept, and running "
        "the study again continues from there."
    )


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
    path = Path(path)
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        if study is None:
            raise StoreError(f"there is no store {str(path)!r}: springpot study run FILE --store {path} creates one.")
        _make(path, study)
    ours = _ours(path)
    if study is None:
        if ours is None:
            raise StoreError(
                f"the description of store {str(path)!r} (its zarr.json) is damaged: springpot study run FILE --store "
                f"{path}, with the study's file, writes it again and keeps every result."
            )
        return Store(path, read_study(ours["study"]), ours["versions"])
    if ours is None:
        _check_answers(Store(path, study, []))
    else:
        _check_same(path, read_study(ours["study"]), study)
    try:
        return _describe(path, study, ours)
    except OSError as error:
        raise cannot_write(path, error) from error


def _json(place: Path) -> Any:
    """Content of a JSON file, or None if it is missing, damaged, or not a file."""
    try:
        body = read_file(str(place), MOST_METADATA)
        return None if body is None else json.loads(body)
    except (Damaged, ValueError, RecursionError):
        return None


def metadata_of(place: Path) -> dict[str, Any] | None:
    """Zarr metadata in a folder, or None if they are missing or damaged."""
    content = _json(place / "zarr.json")
    return content if isinstance(content, dict) else None


def describe_labelled(path: Path, labelled: dict[str, Any] | None) -> None:
    """List the labelled group, given its metadata, in the root's consolidated metadata; remove the list for None."""
    root = metadata_of(path)
    if root is None:
        return
    wanted = {name: part for name, part in root.items() if name != CONSOLIDATED}
    if labelled is not None:
        wanted[CONSOLIDATED] = listed(labelled)
    if wanted != root:
        write(f"{path}/zarr.json", _text(wanted), durable=True)


def listed(labelled: dict[str, Any]) -> dict[str, Any]:
    """The root's consolidated metadata for a labelled group with these metadata."""
    below = labelled[CONSOLIDATED]["metadata"]
    own = {name: part for name, part in labelled.items() if name != CONSOLIDATED}
    groups = {LABELLED: own} | {f"{LABELLED}/{name}": part for name, part in below.items()}
    return {"kind": "inline", "must_understand": False, "metadata": groups}


def take_away_labelled(path: Path) -> None:
    """Remove the labelled group, if there is one; first from the root's list, which never lists a missing group."""
    place = path / LABELLED
    if not os.path.lexists(place):
        return
    describe_labelled(path, None)
    if place.is_symlink() or not place.is_dir():
        make_room(str(place), folder=True)
        return
    aside = path / partial_name(f"{LABELLED}-before")
    os.rename(place, aside)
    shutil.rmtree(aside, ignore_errors=True)


def _ours(path: Path) -> dict[str, Any] | None:
    """The study's description in the root's attributes, or None if it is damaged."""
    from importlib.metadata import version

    content = _json(path / "zarr.json")
    try:
        ours = dict(content["attributes"][ATTRIBUTE])
        kept, made_by = int(ours["format"]), ours["versions"][-1]["springpot"]
        bare = {name: part for name, part in content.items() if name != CONSOLIDATED}
        right = re.fullmatch(VERSION, made_by) is not None and (kept > FORMAT or bare == _root(ours))
    except (AttributeError, TypeError, KeyError, IndexError, ValueError, OverflowError, RecursionError):
        right = False
    if not right:
        if any(path.glob("*/*/numbers")):
            return None
        raise StoreError(
            f"{str(path)!r} is not a store of a springpot study: give the folder of a store, or a new folder."
        )
    if kept > FORMAT or _release(made_by) > _release(version("springpot")):
        raise StoreError(
            f"store {str(path)!r} was written by springpot {made_by} (store format {kept}), newer than this one "
            f"({version('springpot')}, format {FORMAT}): install that version, or use a new store."
        )
    return ours


def is_store(path: Path) -> bool:
    """Whether a folder is, or was, the store of a study."""
    attributes = (metadata_of(path) or {}).get("attributes")
    described = isinstance(attributes, dict) and ATTRIBUTE in attributes
    return described or any(path.glob("*/*/numbers"))


def _release(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in str(version).split("+")[0].split(".") if part.isdigit())


def _check_same(path: Path, kept: Study, given: Study) -> None:
    """Raise an error if more than the values on axes, methods and quantities has changed."""
    apart = []
    for name in ("name", "seed", "fixed", "monte_carlo"):
        before, now = getattr(kept, name), getattr(given, name)
        if before != now and not (name == "monte_carlo" and None in (before, now)):
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


def _check_answers(store: Store) -> None:
    """Raise an error if a store whose description is lost has results, but none of this study."""
    empty = all(not entry.name.endswith(".0") for entry in store.path.glob("*/*/numbers/*"))
    if not empty and not any(store.has(task) for task in tasks(store.study)):
        raise StoreError(
            f"the description of store {str(store.path)!r} (its zarr.json) is damaged, and none of its results belong "
            f"to {store.study.name!r}: give the study file that it was made from."
        )


def _make(path: Path, study: Study) -> None:
    """Create the store under another name and rename it, so that it is never seen incomplete."""
    partial = path.with_name(partial_name(path.name))
    try:
        partial.mkdir(parents=True)
        _describe(partial, study, None)
        os.rename(partial, path)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):  # otherwise another process was quicker
            raise OSError(f"store {str(path)!r} cannot be created ({error.strerror}).") from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _describe(path: Path, study: Study, ours: dict[str, Any] | None) -> Store:
    """Write all metadata of the study that are missing, damaged or outdated."""
    from importlib.metadata import version

    versions = [] if ours is None else ours["versions"]
    at_work = {name: version(name) for name in ("springpot", "numba", "numpy")}
    store = Store(path, study, versions if at_work in versions else [*versions, at_work])
    for place, content in metadata(study.methods, study.system).items():
        if _json(path / place / "zarr.json") != content:
            make_room(f"{path}/{place}", folder=True)
            (path / place).mkdir(parents=True, exist_ok=True)
            write(f"{path}/{place}/zarr.json", _text(content), durable=True)
    now = {"format": FORMAT, "study": document(study), "versions": store.versions}
    if ours is None or {name: ours.get(name) for name in now} != now:
        try:
            write(f"{path}/zarr.json", _text(_root(now)), durable=True)
        except OSError:
            # a read-only store is fine if only the versions are new
            if ours is None or ours["study"] != now["study"]:
                raise
    if ours is not None and ours["study"] != now["study"]:
        take_away_labelled(path)
    return store


def document(study: Study) -> dict[str, Any]:
    """The study as in its file, with the values of all axes."""
    return study.model_dump(mode="json", exclude_none=True, exclude_unset=True)


def _root(ours: dict[str, Any]) -> dict[str, Any]:
    """The root's metadata, with a checksum."""
    attributes = {"Conventions": "CF-1.11", "title": ours["study"]["name"]}
    described = {name: part for name, part in ours.items() if name != CHECKSUM}
    text = json.dumps({**attributes, ATTRIBUTE: described}, sort_keys=True)
    return group({**attributes, ATTRIBUTE: {**described, CHECKSUM: checksum(text.encode())}})


def _text(content: dict[str, Any]) -> bytes:
    return json.dumps(content, indent=1).encode()
