"""Small studies, and what is on disk."""

from __future__ import annotations

import contextlib
import json
import math
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import springpot as sp
from springpot.machine.record import ENDING, parts_of
from springpot.studies.columns import columns_of
from springpot.studies.question import Study, read_study
from springpot.studies.store import KIND
from springpot.studies.tasks import Task

__all__ = [
    "COMMAND", "DEVICE", "RUNS", "STOPS", "THEORY", "content", "given", "lines", "named", "orphans",
    "replaced", "with_device", "write_toml",
]  # fmt: skip

COMMAND = [sys.executable, "-m", "springpot", "study"]

THEORY: dict[str, Any] = {
    "name": "theory",
    "methods": ["averaging", "exact"],
    "axes": {"order": [0.25, 0.5, 1.0], "coefficient": [0.3, 2.0]},
}
"""A moment's work.  Averaging warns at coefficient 2; exact covers order 1 only and says so elsewhere."""

RUNS: dict[str, Any] = {
    "name": "runs",
    "seed": 7,
    "methods": ["averaging", "monte_carlo"],
    "quantities": ["amplitude_mean_square", "impact_rate"],
    "axes": {"order": [0.4, 0.7, 1.0], "restitution": [1.0, 0.8]},
    "monte_carlo": {"paths": 128, "duration": 20.0, "step": 0.02, "start": "rest"},
}
"""Six points of theory and six short runs."""


DEVICE = sp.System(
    sp.Mass(0.2), sp.Spring(80.0), sp.Dashpot(0.4), sp.WhiteNoise(5e-5), magnet=sp.PolynomialSpring((0.0, 0.0, 4e5)),
    lower=sp.Barrier(-0.001, 0.9), upper=sp.Barrier(0.002, free_side="below"),
)  # fmt: skip
"""Two walls and a hardening spring."""

STOPS: dict[str, Any] = {
    "name": "stops",
    "seed": 3,
    "system": DEVICE,
    "methods": ["exact", "linear", "monte_carlo"],
    "quantities": ["x_mean_square", "upper_impact_rate"],
    "axes": {"parts.lower.restitution": [1.0, 0.8], "parts.magnet.coefficients.3": [4e5, 8e5]},
    "zipped": {"gap": {"parts.lower.position": [-0.001, -0.002], "parts.upper.position": [0.002, 0.003]}},
    "monte_carlo": {"paths": 64, "duration": 2.0, "step": 1e-3, "start": "rest"},
}
"""Eight points; exact covers elastic walls, linear no wall."""


def given(base: dict[str, Any], **changes: Any) -> Study:
    return read_study({**base, **changes})


def write_toml(place: Path, content: dict[str, Any]) -> Path:
    """A study file; what JSON and TOML have in common is all that a study needs below its tables."""
    lines, tables = [], []
    for name, part in content.items():
        if isinstance(part, dict):
            tables += [f"[{name}]", *(f"{json.dumps(key)} = {_value(value)}" for key, value in part.items())]
        else:
            lines.append(f"{name} = {_value(part)}")
    place.write_text("\n".join([*lines, *tables]) + "\n", encoding="utf-8")
    return place


def with_device(place: Path, content: dict[str, Any]) -> Path:
    """A study file and, beside it, the file of its system."""
    place.with_name("device.toml").write_text(sp.to_toml(content["system"]), encoding="utf-8")
    return write_toml(place, {**content, "system": "device.toml"})


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(name)} = {_value(part)}" for name, part in value.items()) + "}"
    return json.dumps(value)


def content(store: Path) -> dict[str, Any]:
    """Every file of a store by its name; all records together by their lines, whoever has written them and when."""
    files = {
        file.relative_to(store).as_posix(): file.read_bytes() for file in sorted(store.rglob("*")) if file.is_file()
    }
    return {name: body for name, body in files.items() if not name.endswith(ENDING)} | {"lines": set(lines(store))}


def lines(store: Path, method: str = "") -> list[bytes]:
    """The results in a store as they are written, file by file; those of one method if it is named.

    Files that are removed meanwhile are passed over.
    """
    found = list[bytes]()
    for file in filter(Path.is_file, sorted(store.glob(f"*{ENDING}"))):
        with contextlib.suppress(FileNotFoundError):
            found += [line for line in file.read_bytes().splitlines() if parts_of(KIND, line)]
    return [line for line in found if b' {"method": "%b' % method.encode() in line]


def replaced(store: Path, number: int, line: bytes) -> None:
    """Write something else in the place of a line of a store that one process has made."""
    (file,) = store.glob(f"*{ENDING}")
    own = file.read_bytes().splitlines(keepends=True)
    own[number] = line
    file.write_bytes(b"".join(own))


def orphans(store: Path) -> list[str]:
    """Names of what a killed writer would leave, in a store and beside it."""
    return [file.name for file in [*store.rglob(".*"), *store.parent.glob(f".{store.name}.*")]]


def named(task: Task, numbers: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """The numbers of a result with the names of their columns; NaN where there are none."""
    names = [column.name for column in columns_of(task.method, task.base, task.settings)]
    assert numbers.keys() <= set(names)
    return ((name, numbers.get(name, math.nan)) for name in names)
