"""The store of a study's results: a folder with a record of finished tasks, and what the study is.

    study/description             the study with all values of its axes, and the versions that worked on it
    study/<process>.tasks         a line for each task that a process has finished: method, point, numbers by name,
                                  warnings, or why there is no result
    study/<task>.repetitions      of exceedance: those that have ended, until their task has a result
    study/labelled                of a finished study: all of it as a Zarr group (:mod:`springpot.studies.labelled`)

Every line has a checksum (:mod:`springpot.machine.record`), that of the description too.  A task's key depends on
nothing but the task, so its result is found when the grid has grown.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from springpot.machine.arguments import checked_path
from springpot.machine.faults import FileError
from springpot.machine.files import Damaged, partial_name, read_file, remove_orphans, shell_word, write
from springpot.machine.installed import __version__, versions
from springpot.machine.platforms import patiently
from springpot.machine.record import ENDING, Record, line_of, parts_of, writing
from springpot.studies.question import Study, read_study
from springpot.studies.tables import SIMULATED
from springpot.studies.tasks import Answer, Task, tasks

FORMAT = 1
KIND = "springpot-study"  # the first word of each line
DESCRIPTION, REPETITIONS = "description", ".repetitions"
MOST_BYTES = 2**28  # of a description: a million values on axes take a tenth of it
VERSION = r"[\w.+!-]{1,40}"  # of a program; other text is not printed to a terminal


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
    def record(self) -> Record:
        """What is finished; read at first use."""
        return Record(self.path, KIND, "store", shared=True)

    def find(self, task: Task) -> Answer | None:
        """A task's result, or None if there is none or it was damaged."""
        found = self.record.get(task.key)
        try:
            numbers = {str(name): float(number) for name, number in found["numbers"].items()}
            return Answer(numbers, str(found["statement"]), tuple(map(str, found["warnings"])))
        except (AttributeError, KeyError, TypeError, ValueError, OverflowError):
            return None

    def has(self, task: Task) -> bool:
        """Whether there is a result of a task, also from another process meanwhile."""
        self.record.read()
        return self.find(task) is not None

    def repetitions(self, task: Task) -> Path:
        """Where a task's repetitions are written as they end."""
        return self.path / f"{task.key}{REPETITIONS}"

    def write(self, task: Task, answer: Answer) -> None:
        """Save a result.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        words = {"statement": answer.statement, "warnings": answer.warnings}
        with self.writing():
            self.record.add(task.key, {"method": task.method, "point": task.point, "numbers": answer.numbers, **words})
            patiently(self.repetitions(task).unlink, missing_ok=True)

    def remove_orphans(self) -> int:
        """Remove half-written files of killed processes, and repetitions of results; those in use are kept."""
        for ended in self.path.glob(f"*{REPETITIONS}"):
            if self.record.get(ended.stem) is not None:
                patiently(ended.unlink, missing_ok=True)
        return remove_orphans(str(self.path.parent), self.path.name) + remove_orphans(str(self.path))

    def writing(self) -> AbstractContextManager[None]:
        """One sentence if the store cannot be written."""
        return writing(f"store {str(self.path)!r}")

    def described(self) -> dict[str, Any]:
        """What the description says of the study."""
        return {"format": FORMAT, "study": document(self.study), "versions": self.versions}


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """A folder that is made under another name and then renamed, so that it is never seen incomplete."""
    partial = path.with_name(partial_name(path.name))
    try:
        yield partial
        with suppress(OSError):
            os.rmdir(path)  # an empty one: Windows would keep it
        patiently(os.rename, partial, path)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):  # otherwise another process was quicker
            raise
    finally:
        shutil.rmtree(partial, ignore_errors=True)


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
    ...     open_store(f"{folder}/orders.store", orders).study.shape
    {'order': 2}
    """
    path = checked_path(path, "store")
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        if study is None:
            raise StoreError(
                f"there is no store {str(path)!r}: springpot study run FILE --store {shell_word(path)} creates one."
            )
        try:
            with whole_folder(path) as partial:
                partial.mkdir(parents=True)
                _describe(partial, study, None)
        except OSError as error:
            raise OSError(f"store {str(path)!r} cannot be created ({error.strerror}).") from error
    ours = _ours(path)
    if study is None:
        if ours is None:
            raise StoreError(
                f"the description of store {str(path)!r} is damaged: springpot study run FILE --store "
                f"{shell_word(path)}, with the study's file, writes it again and keeps every result."
            )
        return Store(path, read_study(ours["study"]), ours["versions"])
    if ours is None:
        lost = Store(path, study, [])
        if any(path.glob(f"*{ENDING}")) and not any(lost.find(task) for task in tasks(study)):
            raise StoreError(
                f"the description of store {str(path)!r} is damaged, and none of its results belong to "
                f"{study.name!r}: give the study file that it was made from."
            )
    else:
        _check_same(path, read_study(ours["study"]), study)
    with writing(f"store {str(path)!r}"):
        return _describe(path, study, ours)


def _ours(path: Path) -> dict[str, Any] | None:
    """The study's description, or None if it is damaged."""
    try:
        _, content = parts_of(KIND, read_file(f"{path}/{DESCRIPTION}", MOST_BYTES) or b"") or ("", b"")
        ours = dict(json.loads(content))
        kept, made_by = int(ours["format"]), ours["versions"][-1]["springpot"]
        right = re.fullmatch(VERSION, made_by) is not None
    except (Damaged, TypeError, KeyError, IndexError, ValueError, OverflowError, RecursionError):
        right = False
    if not right:
        if is_store(path):
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
    try:
        begin = (read_file(f"{path}/{DESCRIPTION}", MOST_BYTES) or b"").partition(b" ")[0]
    except Damaged:
        begin = b""
    return begin == KIND.encode() or any(path.glob(f"*{ENDING}"))


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


def _describe(path: Path, study: Study, ours: dict[str, Any] | None) -> Store:
    """Write the description if it is missing, damaged or outdated."""
    before, at_work = [] if ours is None else ours["versions"], versions("numba", "numpy")
    store = Store(path, study, before if at_work in before else [*before, at_work])
    now = store.described()
    if ours != now:
        try:
            write(f"{path}/{DESCRIPTION}", line_of(KIND, DESCRIPTION, now) + b"\n", durable=True)
        except OSError:
            # a read-only store is fine if only the versions are new
            if ours is None or ours["study"] != now["study"]:
                raise
    return store


def document(study: Study) -> dict[str, Any]:
    """The study as in its file, with the values of all axes."""
    return study.model_dump(mode="json", exclude_none=True, exclude_unset=True)
