"""Errors of a study file: one sentence that names the key."""

from __future__ import annotations

import re
from collections.abc import Iterable

from pydantic import ValidationError

from springpot.machine.faults import listed, meant, shown

_WORDS = (
    ("Input should be ", "must be "),
    (r"a valid dictionary( or instance of \w+)?", "a table"),
    ("a valid integer", "a whole number"),
    ("a valid number", "a number"),
    ("a valid string", "a text in quotes"),
    ("a valid tuple", "a list"),
    ("String should have at least 1 character", "must not be empty"),
    ("Tuple should have at least 1 item after validation, not 0", "must not be empty"),
    ("String should have", "must have"),
    ("Tuple should have", "must have"),
    (" after validation", ""),
)
"""Pydantic's words, and the words for the user of a TOML file."""


def unknown_key(key: object, table: str, known: Iterable[str]) -> str:
    """The sentence for a key that a table (``""``: the file itself) does not have."""
    names = [*known]
    where = f"[{table}]" if table else "a study file"
    return f"{shown(key)} is not a key of {where}{meant(str(key), names) or f': its keys are {listed(names)}.'}"


def sentence(error: ValidationError) -> str:
    """The sentence for the first error that pydantic reports."""
    fault = error.errors(include_url=False)[0]
    place = _place(fault["loc"])
    if fault["type"] == "missing":
        return f"{place} is missing."
    text = str(fault.get("ctx", {}).get("error", ""))
    if not text:
        text = str(fault["msg"])
        for theirs, ours in _WORDS:
            text = re.sub(theirs, ours, text)
        if text.startswith("must be") and isinstance(fault["input"], str | int | float):
            text += f", not {shown(fault['input'])}"
            if fault["type"] == "literal_error" and isinstance(fault["input"], str):
                text += meant(fault["input"], re.findall(r"'(\w+)'", str(fault["ctx"]["expected"])))
    text = text if text.endswith((".", "?")) else f"{text}."
    return f"{place}: {text}" if place else text


def _place(parts: tuple[str | int, ...]) -> str:
    """``methods, number 2`` for the second of a list, ``fixed.order`` for the key of a table."""
    keys = ".".join(part for part in parts if isinstance(part, str))
    numbers = [f"number {part + 1}" for part in parts if isinstance(part, int)]
    return ", ".join([keys, *numbers] if keys else numbers)
