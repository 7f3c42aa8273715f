"""Status of a store, and the labelled group of a finished study: beside the working chunks, for any xarray.

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
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from springpot.machine.files import Damaged, make_room, partial_name, read_file, write
from springpot.studies.dataset import open_tree
from springpot.studies.layout import LABELLED, NOT_IN_THE_FORMAT
from springpot.studies.store import ATTRIBUTE, Store, document, metadata_of, root_of, whole_folder
from springpot.studies.tasks import tasks

if TYPE_CHECKING:
    import xarray

ANSWERS, FILES = "springpot_answers_sha256", "labelled_sha256"
LARGEST = 2**31  # bytes of one of its files

State = Literal["right", "outdated", "damaged", "missing"]


@dataclass(frozen=True)
class Status:
    """Status of a store.

    Attributes
    ----------
    done, damaged, missing : dict
        Number of tasks of each method.
    answers : str or None
        Digest of all results; None if some are damaged or missing.
    labelled : {"right", "outdated", "damaged", "missing"}
        State of the group that any xarray can open.
    """

    done: dict[str, int]
    damaged: dict[str, int]
    missing: dict[str, int]
    answers: str | None
    labelled: State


def status(store: Store) -> Status:
    """Read all results of a store, and verify their checksums."""
    done, damaged, missing = (dict.fromkeys(map(str, store.study.methods), 0) for _ in range(3))
    digest = hashlib.sha256(json.dumps([document(store.study), store.versions], sort_keys=True).encode())
    for task in tasks(store.study):
        try:
            answer = store.read(task)
        except Damaged:
            damaged[task.method] += 1
            continue
        (missing if answer is None else done)[task.method] += 1
        if answer is not None:
            digest.update(struct.pack(f"<QQ{len(answer.numbers)}d", task.slot, task.check, *answer.numbers))
            digest.update(json.dumps([answer.statement, answer.warnings]).encode())
    answers = None if any((*damaged.values(), *missing.values())) else digest.hexdigest()
    return Status(done, damaged, missing, answers, _state(store, answers))


def _state(store: Store, answers: str | None) -> State:
    place = store.path / LABELLED
    if not os.path.lexists(place):
        return "missing"
    try:
        if answers is None or metadata_of(place)["attributes"].get(ANSWERS) != answers:
            return "outdated"
        now, listed = _described(store, place)
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
    found = status(store)
    if found.answers is None:
        return False
    if found.labelled != "right":
        tree = open_tree(store)
        tree.attrs[ANSWERS] = found.answers
        with whole_folder(store.path / LABELLED) as partial:
            write_zarr(tree, partial)
            described = root_of(*_described(store, partial))
            take_away_labelled(store)
        write(f"{store.path}/zarr.json", described, durable=True)
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
    with suppress(FileNotFoundError):  # another process was quicker
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


def _described(store: Store, place: Path) -> tuple[dict[str, Any], dict[str, bytes]]:
    """What the root says of a store with the labelled group in a folder, and the group's metadata, which it lists."""
    files = (Path(folder, name) for folder, _, names in os.walk(place) for name in names)
    digest, listed = hashlib.sha256(), {}
    for name in sorted(file.relative_to(place).as_posix() for file in files):
        body = read_file(f"{place}/{name}", LARGEST) or b""
        digest.update(struct.pack("<Q", len(body)) + name.encode() + b"\0" + body)
        if Path(name).name == "zarr.json":
            listed[f"{LABELLED}/{name}"] = body
    return {**store.described(), FILES: digest.hexdigest()}, listed
