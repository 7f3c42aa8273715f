"""The Zarr metadata (version 3) of the groups and arrays of a store.

They are small, fixed documents, written here instead of by the library: this saves half a second at every start, and
damaged metadata can be detected.  The tests compare them with what the library writes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from springpot.problem.system import System
from springpot.studies.columns import columns_of, unit_of_column
from springpot.studies.tasks import SLOTS

__all__ = ["ARRAYS", "CHECK", "LABELLED", "SENTENCES", "group", "metadata", "place_of"]

ARRAYS = ("numbers", "sentences")
SENTENCES = 4096  # bytes
LABELLED = "labelled"  # the group of a finished study
CHECK = "task"  # first column: the task's check


def place_of(method: str) -> str:
    """The group of a method."""
    return f"simulation/{method}" if method == "monte_carlo" else f"theory/{method}"


def metadata(methods: Iterable[str], system: System | None = None) -> dict[str, dict[str, Any]]:
    """Content of each ``zarr.json`` below the root's, by its folder."""
    documents: dict[str, dict[str, Any]] = {}
    for method in methods:
        columns = columns_of(method, system)
        units = [unit_of_column(column, system) for column in columns]
        place = place_of(method)
        documents |= {place.partition("/")[0]: group({}), place: group({})}
        documents[f"{place}/numbers"] = _array(
            2 + len(columns), "column", "float64", "NaN", {"name": "bytes", "configuration": {"endian": "little"}},
            {"columns": [CHECK, "sentences_length", *columns], "units": ["1", "1", *units]},
        )  # fmt: skip
        documents[f"{place}/sentences"] = _array(
            SENTENCES, "byte", "uint8", 0, {"name": "bytes"}, {"encoding": "JSON in UTF-8, padded with zero bytes"}
        )
    return documents


def group(attributes: dict[str, Any]) -> dict[str, Any]:
    """Metadata of a group."""
    return {"attributes": attributes, "zarr_format": 3, "node_type": "group"}


def _array(
    width: int, across: str, kind: str, empty: float | str, serializer: dict[str, Any], attributes: dict[str, Any]
) -> dict[str, Any]:
    return {
        "shape": [SLOTS, width],
        "data_type": kind,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [1, width]}},
        "chunk_key_encoding": {"name": "v2", "configuration": {"separator": "."}},
        "fill_value": empty,
        "codecs": [serializer, {"name": "crc32c"}],
        "attributes": attributes,
        "dimension_names": ["slot", across],
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    }
