"""The compiled functions that Python calls, by name; none of them needs Numba where its machine code is there."""

from __future__ import annotations

from springpot.simulation.kernel.native import Entry

FILL_NORMALS = Entry(
    "springpot.simulation.kernel.random:fill_normals",
    ("int64", "uint32", "uint32", "uint32", "uint32", "int64", "int64", "float32*"),
)

ENTRIES = (FILL_NORMALS,)
"""All of them: what a release makes for each target."""
