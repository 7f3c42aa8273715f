"""The groups and arrays of a store: Zarr makes their metadata, encodes the chunks and verifies their checksums.

The metadata are made in memory and compared with what is on disk: so damage is found, and a store whose metadata are
damaged can still be read.  The files are read and written by `springpot.files`: each is written whole under the name of
its process and then renamed, and none is waited for.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import zarr
from zarr.abc.buffer import BufferPrototype
from zarr.buffer import default_buffer_prototype
from zarr.buffer.cpu import Buffer
from zarr.codecs import BytesCodec, Crc32cCodec
from zarr.storage import LocalStore, MemoryStore, WrapperStore

from springpot.machine.files import read_file, write
from springpot.studies.columns import Column
from springpot.studies.tables import SIMULATED
from springpot.studies.tasks import SENTENCES, SLOTS

ARRAYS = ("numbers", "sentences")
LABELLED = "labelled"  # the group of a finished study
NOT_IN_THE_FORMAT = "Consolidated metadata"  # an extension by Zarr and xarray, which other readers ignore
LARGEST = 2**24  # bytes of a chunk: more is damage


class _Files(WrapperStore[LocalStore]):
    """A folder of chunks, whose metadata are known.  Zarr's later versions read and write without a loop of events."""

    def __init__(self, folder: Path, known: Mapping[str, bytes]) -> None:
        super().__init__(LocalStore(folder))
        self._known = known

    def get_sync(self, key: str, *, prototype: BufferPrototype | None = None, byte_range: Any = None) -> Any:
        body = self._known.get(key) or read_file(f"{self._store.root}/{key}", LARGEST)
        return None if body is None else (prototype or default_buffer_prototype()).buffer.from_bytes(body)

    def set_sync(self, key: str, value: Any) -> None:
        write(f"{self._store.root}/{key}", value.to_bytes())

    async def get(self, key: str, prototype: BufferPrototype, byte_range: Any = None) -> Any:
        return self.get_sync(key, prototype=prototype)

    async def set(self, key: str, value: Any) -> None:
        self.set_sync(key, value)


def place_of(method: str) -> str:
    """The group of a method."""
    return f"simulation/{method}" if method in SIMULATED else f"theory/{method}"


def metadata(columns_of: Mapping[str, Sequence[Column]]) -> dict[str, bytes]:
    """Content of each ``zarr.json`` below the root's, by its place, for the columns of each method; groups first."""
    made: dict[str, Any] = {}
    group = zarr.create_group(MemoryStore(made), zarr_format=3)
    for method, columns in columns_of.items():
        names, units = [column.name for column in columns], [column.unit for column in columns]
        place = place_of(method)
        group.require_group(place.partition("/")[0])
        group.create_group(place)
        named: dict[str, Any] = {"columns": ["task", "sentences_length", *names], "units": ["1", "1", *units]}
        packed: dict[str, Any] = {"encoding": "JSON in UTF-8, padded with zero bytes"}
        for array, across, width, kind, empty, attributes in (
            ("numbers", "column", 2 + len(columns), "float64", math.nan, named),
            ("sentences", "byte", SENTENCES, "uint8", 0, packed),
        ):
            group.create_array(
                f"{place}/{array}", shape=(SLOTS, width), chunks=(1, width), dtype=kind, fill_value=empty,
                serializer=BytesCodec(endian="little"), compressors=Crc32cCodec(), filters=None,
                chunk_key_encoding={"name": "v2", "separator": "."}, dimension_names=("slot", across),
                attributes=attributes,
            )  # fmt: skip
    return {place: content.to_bytes() for place, content in made.items() if place != "zarr.json"}


def open_arrays(folder: Path, known: Mapping[str, bytes]) -> dict[str, Any]:
    """The arrays in a folder by their places, from their metadata."""
    group = zarr.open_group(_Files(folder, {**known, "zarr.json": root({}, {})}), mode="r+", zarr_format=3)
    places = [place.removesuffix("/zarr.json") for place in known]
    return {place: group[place] for place in places if place.endswith(ARRAYS)}


def root(attributes: Mapping[str, Any], listed: Mapping[str, bytes]) -> bytes:
    """Content of the root's ``zarr.json``, which lists the metadata of these groups and arrays, and no other."""
    made: dict[str, Any] = {place: Buffer.from_bytes(content) for place, content in listed.items()}
    zarr.create_group(MemoryStore(made), zarr_format=3, attributes=dict(attributes))
    if listed:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=NOT_IN_THE_FORMAT)
            zarr.consolidate_metadata(MemoryStore(made), zarr_format=3)
    return bytes(made["zarr.json"].to_bytes())
