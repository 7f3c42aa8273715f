"""Small studies, and what is on disk."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from springpot.studies.question import Study, read_study

__all__ = ["COMMAND", "RUNS", "THEORY", "chunks", "content", "given", "orphans", "write_toml"]

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


def given(base: dict[str, Any], **changes: Any) -> Study:
    return read_study({**base, **changes})


def write_toml(place: Path, content: dict[str, Any]) -> Path:
    """A study file; what JSON and TOML have in common is all that a study needs below its tables."""
    lines, tables = [], []
    for name, part in content.items():
        if isinstance(part, dict):
            tables += [f"[{name}]", *(f"{key} = {_value(value)}" for key, value in part.items())]
        else:
            lines.append(f"{name} = {_value(part)}")
    place.write_text("\n".join([*lines, *tables]) + "\n", encoding="utf-8")
    return place


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name} = {_value(part)}" for name, part in value.items()) + "}"
    return json.dumps(value)


def content(store: Path) -> dict[str, bytes]:
    """Every file of a store."""
    return {str(file.relative_to(store)): file.read_bytes() for file in sorted(store.rglob("*")) if file.is_file()}


def chunks(store: Path, array: str = "numbers") -> list[Path]:
    return sorted(file for file in store.rglob(f"{array}/*") if file.name.endswith(".0"))


def orphans(store: Path) -> list[str]:
    """Names of what a killed writer would leave, in a store and beside it."""
    return [file.name for file in [*store.rglob(".*"), *store.parent.glob(f".{store.name}.*")]]
