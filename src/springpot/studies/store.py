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

import errno
import json
import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from springpot.faults import FileFault
from springpot.files import (
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
from springpot.studies.layout import ARRAYS, LABELLED, SENTENCES, group, metadata, place_of
from springpot.studies.question import Study, read_study
from springpot.studies.tasks import Answer, Task, columns_of, tasks

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
VERSION = r"[\w.+!-]{1,40}"  # of a program; what else may stand in its place is not shown to a terminal
CHECKSUM = "crc32c"  # of the root's metadata without it


class StoreError(FileFault):
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
        """A task's answer, or None if there is none.

        Raises
        ------
        Damaged
            If its chunk is not what was written.
        """
        columns = columns_of(task.method)
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
                said = json.loads(text[: int(row[1])])
                owner, statement, warnings = said["task"], said["statement"], tuple(said["warnings"])
            except (ValueError, KeyError, TypeError):
                owner = None
            if owner != task.check:
                raise Damaged("it holds the sentences of another task")
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
        said = _sentences(task, answer)
        row = np.array([float(task.check), float(len(said)), *answer.numbers], "<f8")
        try:
            if said:
                write_chunk(self._chunk(task, "sentences"), said.ljust(SENTENCES, b"\0"))
            write_chunk(self._chunk(task, "numbers"), row.tobytes())
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def remove_orphans(self) -> int:
        """Remove what killed processes left half-written; files of processes at work are left alone."""
        places = [f"{place_of(method)}/{array}" for method in self.study.methods for array in ARRAYS]
        folders = {"", *places, *metadata(self.study.methods)}
        beside = remove_orphans(str(self.path.parent), self.path.name)
        return beside + sum(remove_orphans(f"{self.path}/{folder}") for folder in folders)

    def damaged_metadata(self) -> list[str]:
        """Metadata of groups and arrays that other Zarr readers would stumble over; running the study mends them."""
        expected = metadata(self.study.methods)
        return [f"{place}/zarr.json" for place in expected if _json(self.path / place / "zarr.json") != expected[place]]

    def _chunk(self, task: Task, array: str) -> str:
        return f"{self.path}/{place_of(task.method)}/{array}/{task.slot}.0"


def cannot_write(path: Path, error: OSError) -> OSError:
    """The error with the sentence that says what of the store is kept."""
    return OSError(
        f"store {str(path)!r} cannot be written ({error.strerror or error}): all results so far are kept, and "
        "running the study again goes on from there."
    )


def _sentences(task: Task, answer: Answer) -> bytes:
    """Statement and warnings as JSON, at most SENTENCES bytes: of more warnings than fit, the first ones."""
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

    Examples
    --------
    >>> import tempfile
    >>> asked = read_study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5]}})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     open_store(f"{folder}/orders.zarr", asked).study.shape
    {'order': 2}
    """
    path = Path(path)
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        if study is None:
            raise StoreError(f"there is no store {str(path)!r}: springpot study run FILE --store {path} makes one.")
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
    """Content of a JSON file, or None if it is missing, damaged, or no file."""
    try:
        body = read_file(str(place), MOST_METADATA)
        return None if body is None else json.loads(body)
    except (Damaged, ValueError, RecursionError):
        return None


def metadata_of(place: Path) -> dict[str, Any] | None:
    """Zarr's metadata in a folder, or None if they are missing or damaged."""
    content = _json(place / "zarr.json")
    return content if isinstance(content, dict) else None


def describe_labelled(path: Path, labelled: dict[str, Any] | None) -> None:
    """Let the root's consolidated metadata list the labelled group, by its metadata, or (None) nothing."""
    root = metadata_of(path)
    if root is None:
        return
    wanted = {name: part for name, part in root.items() if name != CONSOLIDATED}
    if labelled is not None:
        wanted[CONSOLIDATED] = listed(labelled)
    if wanted != root:
        write(f"{path}/zarr.json", _text(wanted), durable=True)


def listed(labelled: dict[str, Any]) -> dict[str, Any]:
    """The root's consolidated metadata where there is a labelled group with these metadata."""
    below = labelled[CONSOLIDATED]["metadata"]
    own = {name: part for name, part in labelled.items() if name != CONSOLIDATED}
    found = {LABELLED: own} | {f"{LABELLED}/{name}": part for name, part in below.items()}
    return {"kind": "inline", "must_understand": False, "metadata": found}


def take_away_labelled(path: Path) -> None:
    """Remove the labelled group, if there is one; first from the root's list, so that this never leads to nothing."""
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
    """What the root's attributes say of the study, or None if they are damaged."""
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
        raise StoreError(f"{str(path)!r} is not a store of a springpot study: give the place of one, or a new place.")
    if kept > FORMAT or _release(made_by) > _release(version("springpot")):
        raise StoreError(
            f"store {str(path)!r} was written by springpot {made_by} (store format {kept}), newer than this one "
            f"({version('springpot')}, format {FORMAT}): install that version, or use a new store."
        )
    return ours


def is_store(path: Path) -> bool:
    """Whether a folder holds, or held, the answers of a study."""
    attributes = (metadata_of(path) or {}).get("attributes")
    described = isinstance(attributes, dict) and ATTRIBUTE in attributes
    return described or any(path.glob("*/*/numbers"))


def _release(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in str(version).split("+")[0].split(".") if part.isdigit())


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
            f"store {str(path)!r} is of another study ({kept.name!r}; not the same: {', '.join(apart)}): only the "
            "values on the axes, methods and quantities may change in a store, so use another store for "
            f"{given.name!r}."
        )


def _check_answers(store: Store) -> None:
    """A store whose description is lost may only be described anew by the study that its answers belong to."""
    empty = all(not entry.name.endswith(".0") for entry in store.path.glob("*/*/numbers/*"))
    if not empty and not any(store.has(task) for task in tasks(store.study)):
        raise StoreError(
            f"the description of store {str(store.path)!r} (its zarr.json) is damaged, and none of its results belong "
            f"to {store.study.name!r}: give the study file that it was made from."
        )


def _make(path: Path, study: Study) -> None:
    """Make the store beside its place and move it there, so that no half-made store is ever seen."""
    made = path.with_name(partial_name(path.name))
    try:
        made.mkdir(parents=True)
        _describe(made, study, None)
        os.rename(made, path)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):  # otherwise another process was quicker
            raise OSError(f"store {str(path)!r} cannot be made ({error.strerror}).") from error
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _describe(path: Path, study: Study, ours: dict[str, Any] | None) -> Store:
    """Bring all metadata up to the study: make what is missing, mend what is damaged, leave what is right."""
    from importlib.metadata import version

    versions = [] if ours is None else ours["versions"]
    at_work = {name: version(name) for name in ("springpot", "numba", "numpy")}
    store = Store(path, study, versions if at_work in versions else [*versions, at_work])
    for place, content in metadata(study.methods).items():
        if _json(path / place / "zarr.json") != content:
            make_room(f"{path}/{place}", folder=True)
            (path / place).mkdir(parents=True, exist_ok=True)
            write(f"{path}/{place}/zarr.json", _text(content), durable=True)
    now = {"format": FORMAT, "study": document(study), "versions": store.versions}
    if ours is None or {name: ours.get(name) for name in now} != now:
        try:
            write(f"{path}/zarr.json", _text(_root(now)), durable=True)
        except OSError:
            # where only the versions are new, a store that can only be read is as good as it was
            if ours is None or ours["study"] != now["study"]:
                raise
    if ours is not None and ours["study"] != now["study"]:
        take_away_labelled(path)
    return store


def document(study: Study) -> dict[str, Any]:
    """The study as its file says it, axes written out."""
    return study.model_dump(mode="json", exclude_none=True, exclude_unset=True)


def _root(ours: dict[str, Any]) -> dict[str, Any]:
    """The root's metadata, with their checksum."""
    attributes = {"Conventions": "CF-1.11", "title": ours["study"]["name"]}
    said = {name: part for name, part in ours.items() if name != CHECKSUM}
    text = json.dumps({**attributes, ATTRIBUTE: said}, sort_keys=True)
    return group({**attributes, ATTRIBUTE: {**said, CHECKSUM: checksum(text.encode())}})


def _text(content: dict[str, Any]) -> bytes:
    return json.dumps(content, indent=1).encode()
