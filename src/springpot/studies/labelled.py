"""The labelled group of a finished study: a Zarr group beside the working chunks that any xarray can open.

    study.zarr/zarr.json         its consolidated metadata list the labelled group, and nothing else
    study.zarr/labelled          groups theory and simulation, as `springpot.open_study` gives them

The group is written under another name and renamed when every task has a result; it is removed before a store is
changed.  It has a digest of the results, and the root has one of its files.  So an outdated or damaged group is
detected, and the next run writes it again.  `open_study` never reads it.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import struct
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from springpot.machine.files import Damaged, make_room, partial_name, read_file, write
from springpot.studies.dataset import open_tree
from springpot.studies.layout import LABELLED, NOT_IN_THE_FORMAT
from springpot.studies.store import ATTRIBUTE, Store, document, metadata_of, root_of
from springpot.studies.tasks import Answer, Task, tasks

if TYPE_CHECKING:
    import xarray

__all__ = ["AnswersDigest", "State", "finish", "state", "take_away_labelled", "write_zarr"]

ANSWERS, FILES = "springpot_answers_sha256", "labelled_sha256"
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
    try:
        if answers is None or metadata_of(place)["attributes"].get(ANSWERS) != answers:
            return "outdated"
        now, listed = _described(store)
        kept = metadata_of(store.path)
        unchanged = kept["attributes"][ATTRIBUTE].get(FILES) == now[FILES]  # else Zarr may be unable to list them
        return "right" if unchanged and kept == json.loads(root_of(now, listed)) else "damaged"
    except (OSError, Damaged, KeyError, TypeError, AttributeError):
        return "damaged"


def finish(store: Store) -> bool:
    """Write the labelled group if every task has a result and the group is not up to date.

    Returns
    -------
    bool
        Whether there is an up-to-date group.
    """
    digest = AnswersDigest(store)
    for task in tasks(store.study):
        answer = store.found(task)
        if answer is None:
            return False
        digest.add(task, answer)
    answers = digest.value()
    if state(store, answers) != "right":
        partial = store.path / partial_name(LABELLED)
        tree = open_tree(store)
        tree.attrs[ANSWERS] = answers
        try:
            write_zarr(tree, partial)
            take_away_labelled(store)
            os.rename(partial, store.path / LABELLED)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
        write(f"{store.path}/zarr.json", root_of(*_described(store)), durable=True)
    return True


def take_away_labelled(store: Store) -> None:
    """Remove the labelled group, if there is one; first from the root's list, which never lists a missing group."""
    place = store.path / LABELLED
    if not os.path.lexists(place):
        return
    write(f"{store.path}/zarr.json", root_of(store.described()), durable=True)
    if place.is_symlink() or not place.is_dir():
        make_room(str(place), folder=True)
        return
    aside = store.path / partial_name(f"{LABELLED}-before")
    os.rename(place, aside)
    shutil.rmtree(aside, ignore_errors=True)


def write_zarr(tree: xarray.DataTree, place: Path) -> None:
    """Write a tree as a Zarr (version 3) group with consolidated metadata and a checksum in every chunk."""
    from zarr.codecs import ZstdCodec

    # strings of variable length: the format has none of fixed length
    plain = tree.map_over_datasets(
        lambda part: part.assign_coords(
            {name: part[name].astype(object) for name in part.coords if part[name].dtype.kind == "U"}
        )
    )
    plain.attrs = tree.attrs
    packed = {"compressors": (ZstdCodec(level=3, checksum=True),)}
    encoding = {
        node.path: {str(name): packed for name in node.to_dataset(inherit=False).variables} for node in plain.subtree
    }
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=NOT_IN_THE_FORMAT)
        plain.to_zarr(place, zarr_format=3, consolidated=True, encoding=encoding, mode="w-")


def _described(store: Store) -> tuple[dict[str, Any], dict[str, bytes]]:
    """What the root says of a store with its labelled group as it is, and the group's metadata, which it lists."""
    files = ((Path(folder), name) for folder, _, names in os.walk(store.path / LABELLED) for name in names)
    digest, listed = hashlib.sha256(), {}
    for name in sorted((folder / name).relative_to(store.path).as_posix() for folder, name in files):
        body = read_file(f"{store.path}/{name}", LARGEST) or b""
        digest.update(struct.pack("<Q", len(body)) + name.encode() + b"\0" + body)
        if name.endswith("/zarr.json"):
            listed[name] = body
    return {**store.described(), FILES: digest.hexdigest()}, listed
