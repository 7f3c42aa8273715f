"""Status of a store, and the labelled group of a finished study: beside its record, for any xarray.

    study/labelled          a Zarr group with theory and simulation, as `springpot.open_study` gives them

The group is written under another name and renamed when every task has a result; it is removed before a store is
changed.  The record says of the digest of its files of which results it is.  So an outdated or damaged group is
detected, and the next run writes it again.  `open_study` never reads it.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import struct
import warnings
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from springpot.machine.files import Damaged, make_room, partial_name, read_file
from springpot.machine.platforms import patiently
from springpot.machine.record import digest
from springpot.studies.dataset import to_xarray
from springpot.studies.store import Store, document, whole_folder
from springpot.studies.tasks import tasks

if TYPE_CHECKING:
    import xarray

LABELLED = "labelled"
LARGEST = 2**31  # bytes of one of its files
NOT_IN_THE_FORMAT = "Consolidated metadata"  # an extension by Zarr and xarray, which other readers ignore

State = Literal["right", "outdated", "damaged", "missing"]


@dataclass(frozen=True)
class Status:
    """Status of a store.

    Attributes
    ----------
    done, missing : dict
        Number of tasks of each method.
    damaged : int
        Damaged lines of the record; what they held is missing, or was computed again.
    answers : str or None
        Digest of all results; None if some are missing.
    labelled : {"right", "outdated", "damaged", "missing"}
        State of the group that any xarray can open.
    """

    done: dict[str, int]
    missing: dict[str, int]
    damaged: int
    answers: str | None
    labelled: State


def status(store: Store) -> Status:
    """Read all results of a store, those that other processes have added too, and verify their checksums."""
    store.record.read()
    done, missing = (dict.fromkeys(map(str, store.study.methods), 0) for _ in range(2))
    of_all = hashlib.sha256(json.dumps([document(store.study), store.versions], sort_keys=True).encode())
    for task in tasks(store.study):
        answer = store.find(task)
        (missing if answer is None else done)[task.method] += 1
        if answer is not None:
            content = [task.key, answer.numbers, answer.statement, answer.warnings]
            of_all.update(json.dumps(content, sort_keys=True).encode())
    answers = None if any(missing.values()) else of_all.hexdigest()
    return Status(done, missing, store.record.damaged, answers, _state(store, answers))


def _state(store: Store, answers: str | None) -> State:
    place = store.path / LABELLED
    if not os.path.lexists(place):
        return "missing"
    try:
        written_of = store.record.get(_key(place))
    except (OSError, Damaged):
        return "damaged"
    return "damaged" if written_of is None else "right" if written_of == {LABELLED: answers} else "outdated"


def finish(store: Store) -> bool:
    """Write the labelled group if every task has a result and the group is not up to date.

    Returns
    -------
    bool
        Whether there is an up-to-date group.
    """
    found = status(store)
    if found.answers is None:
        return False
    if found.labelled != "right":
        with whole_folder(store.path / LABELLED) as partial:
            to_zarr(to_xarray(store), partial)
            key, words = _key(partial), {LABELLED: found.answers}
            if store.record.get(key) != words:
                store.record.add(key, words)
            take_away_labelled(store)
    return True


def take_away_labelled(store: Store) -> None:
    """Remove the labelled group, if there is one."""
    place = store.path / LABELLED
    if place.is_dir() and not place.is_symlink():
        aside = store.path / partial_name(f"{LABELLED}-before")
        with suppress(FileNotFoundError):  # another process was quicker
            patiently(os.rename, place, aside)
        shutil.rmtree(aside, ignore_errors=True)
    elif os.path.lexists(place):
        make_room(str(place), folder=True)


def to_zarr(tree: xarray.DataTree, place: Path) -> None:
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


def _key(place: Path) -> str:
    """Of the labelled group in a folder, in the record: a digest of all its files."""
    files = (Path(folder, name) for folder, _, names in os.walk(place) for name in names)
    of_all = hashlib.sha256()
    for name in sorted(file.relative_to(place).as_posix() for file in files):
        body = read_file(f"{place}/{name}", LARGEST) or b""
        of_all.update(struct.pack("<Q", len(body)) + name.encode() + b"\0" + body)
    return digest([LABELLED, of_all.hexdigest()])
