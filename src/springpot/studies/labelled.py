"""The labelled group of a finished study: a Zarr group beside the working chunks that any xarray can open.

    study.zarr/zarr.json         its consolidated metadata list the labelled group, and nothing else
    study.zarr/labelled          groups theory and simulation, as `springpot.open_study` gives them

The group is written under another name and renamed when every task has a result; it is removed before a store is
changed.  It has two digests: of the results and of its own files.  So an outdated or damaged group is detected, and the
next run writes it again.  `open_study` never reads it.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import struct
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from springpot.machine.files import Damaged, partial_name, read_file, write
from springpot.studies.dataset import open_tree
from springpot.studies.layout import LABELLED, place_of
from springpot.studies.store import (
    CONSOLIDATED,
    Store,
    describe_labelled,
    document,
    listed,
    metadata_of,
    take_away_labelled,
)
from springpot.studies.tasks import Answer, Task, tasks

if TYPE_CHECKING:
    import xarray

__all__ = ["AnswersDigest", "State", "finish", "state", "write_zarr"]

ANSWERS, FILES = "springpot_answers_sha256", "springpot_files_sha256"
LARGEST = 2**31  # bytes of one of its files

State = Literal["right", "outdated", "damaged", "missing"]


class AnswersDigest:
    """Digest of all results of a study, added one by one in the order of its tasks."""

    def __init__(self, store: Store) -> None:
        self._sum = hashlib.sha256(json.dumps([document(store.study), store.versions], sort_keys=True).encode())
        self._whole = True

    def add(self, task: Task, answer: Answer | None) -> None:
        if answer is None:
            self._whole = False
            return
        self._sum.update(struct.pack(f"<QQ{len(answer.numbers)}d", task.slot, task.check, *answer.numbers))
        if answer.statement or answer.warnings:
            self._sum.update(json.dumps([answer.statement, answer.warnings]).encode())

    def value(self) -> str | None:
        """The digest, or None if a result is missing."""
        return self._sum.hexdigest() if self._whole else None


def state(store: Store, answers: str | None) -> State:
    """State of a store's labelled group; ``answers`` is the digest of the results (None if some are missing)."""
    place = store.path / LABELLED
    if not os.path.lexists(place):
        return "missing"
    root = metadata_of(place)
    attributes = root.get("attributes") if root is not None else None
    if root is None or not isinstance(attributes, dict) or attributes.get(FILES) != _files_digest(place, root):
        return "damaged"
    if answers is None or attributes.get(ANSWERS) != answers:
        return "outdated"
    return "right" if (metadata_of(store.path) or {}).get(CONSOLIDATED) == listed(root) else "damaged"


def finish(store: Store) -> bool:
    """Write the labelled group if every task has a result and the group is not up to date.

    Returns
    -------
    bool
        Whether there is an up-to-date group.
    """
    if not _may_be_complete(store):
        return False
    digest = AnswersDigest(store)
    for task in tasks(store.study):
        try:
            digest.add(task, store.read(task))
        except Damaged:
            return False
    answers = digest.value()
    if answers is None:
        return False
    if state(store, answers) != "right":
        partial = store.path / partial_name(LABELLED)
        try:
            write_zarr(open_tree(store), partial, {ANSWERS: answers})
            take_away_labelled(store.path)
            os.rename(partial, store.path / LABELLED)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
        describe_labelled(store.path, metadata_of(store.path / LABELLED))
    return True


def _may_be_complete(store: Store) -> bool:
    """Whether there are as many chunks as tasks: a quick check that can exclude completeness."""
    wanted = 1
    for length in store.study.shape.values():
        wanted *= length
    for method in store.study.methods:
        try:
            with os.scandir(store.path / place_of(method) / "numbers") as entries:
                if sum(entry.name.endswith(".0") for entry in entries) < wanted:
                    return False
        except OSError:
            return False
    return True


def write_zarr(tree: xarray.DataTree, place: Path, attributes: dict[str, str] | None = None) -> None:
    """Write a tree as a Zarr (version 3) group with consolidated metadata and a checksum in every chunk.

    The digest of its files is added to the given attributes.
    """
    from zarr.codecs import ZstdCodec

    plain = tree.map_over_datasets(_with_plain_texts)
    plain.attrs = tree.attrs
    packed = {"compressors": (ZstdCodec(level=3, checksum=True),)}
    encoding = {
        node.path: {str(name): packed for name in node.to_dataset(inherit=False).variables} for node in plain.subtree
    }
    with warnings.catch_warnings():
        # consolidated metadata are an extension by zarr-python and xarray, which other readers ignore
        warnings.filterwarnings("ignore", message="Consolidated metadata")
        plain.to_zarr(place, zarr_format=3, consolidated=True, encoding=encoding, mode="w-")
    root = json.loads((place / "zarr.json").read_text(encoding="utf-8"))
    root["attributes"] |= attributes or {}
    root["attributes"][FILES] = _files_digest(place, root)
    write(f"{place}/zarr.json", json.dumps(root, indent=1).encode())


def _with_plain_texts(part: xarray.Dataset) -> xarray.Dataset:
    """Strings of variable length: the format has none of fixed length."""
    return part.assign_coords({name: part[name].astype(object) for name in part.coords if part[name].dtype.kind == "U"})


def _files_digest(place: Path, root: dict[str, Any]) -> str | None:
    """Digest of all files of a labelled group, of its root's metadata without the digest itself; None if unreadable."""
    attributes = {name: value for name, value in root["attributes"].items() if name != FILES}
    digest = hashlib.sha256(json.dumps({**root, "attributes": attributes}, sort_keys=True).encode())
    try:
        for name in sorted(_names_below(place)):
            if name != "zarr.json":
                body = read_file(f"{place}/{name}", LARGEST) or b""
                digest.update(struct.pack("<Q", len(body)) + name.encode() + b"\0" + body)
    except (OSError, Damaged):
        return None
    return digest.hexdigest()


def _names_below(place: Path) -> Iterable[str]:
    for folder, _, names in os.walk(place):
        for name in names:
            yield os.path.relpath(os.path.join(folder, name), place).replace(os.sep, "/")
