"""The compiled functions that Python calls, by name; none of them needs Numba where its machine code is there."""

from __future__ import annotations

from springpot.simulation.kernel.native import Entry

FILL_NORMALS = Entry(
    "springpot.simulation.kernel.random:fill_normals",
    ("int64", "uint32", "uint32", "uint32", "uint32", "int64", "int64", "float32*"),
)


def _kernel(kind: str, function: str) -> Entry:
    words = "the kernel" if function == "advance" else "the kernel of systems in neighbouring lanes"
    return Entry(
        f"springpot.simulation.kernel.advance:{function}",
        ("int64*", f"{kind}*", "float64*", "float64*", *("int64",) * 6, "uint32", "uint32", "int64", "int64", "int64*",
         "int64*", "float64*", *("int64",) * 4, "uint8*", "float64*"),
        words if kind == "float32" else f"{words} in double precision", f"{function}-{kind}",
    )  # fmt: skip


KERNELS, KERNELS_BY_LANE = (
    {kind: _kernel(kind, function) for kind in ("float32", "float64")} for function in ("advance", "advance_by_lane")
)
"""The functions of `springpot.simulation.kernel.advance` by the precision of their sweep."""

ENTRIES = (FILL_NORMALS, *KERNELS.values(), KERNELS_BY_LANE["float32"])
"""What a release makes for each target: all but the kernel by lane in double precision, which fits of records with
their measured input need, and compile once."""
