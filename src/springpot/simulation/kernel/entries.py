"""The compiled functions that Python calls, by name; none of them needs Numba where its machine code is there."""

from __future__ import annotations

from springpot.simulation.kernel.native import Entry

FILL_NORMALS = Entry(
    "springpot.simulation.kernel.random:fill_normals",
    ("int64", "uint32", "uint32", "uint32", "uint32", "int64", "int64", "float32*"),
)


def _kernel(kind: str) -> Entry:
    return Entry(
        "springpot.simulation.kernel.advance:advance",
        ("int64*", f"{kind}*", "float64*", "float64*", *("int64",) * 6, "uint32", "uint32", "int64", "int64", "int64*",
         "int64*", "float64*", *("int64",) * 4, "uint8*", "float64*"),
        "the kernel" if kind == "float32" else "the kernel in double precision", f"advance-{kind}",
    )  # fmt: skip


KERNELS = {kind: _kernel(kind) for kind in ("float32", "float64")}
"""`springpot.simulation.kernel.advance.advance` by the precision of its sweep."""

ENTRIES = (FILL_NORMALS, *KERNELS.values())
"""All of them: what a release makes for each target."""
