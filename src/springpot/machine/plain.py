"""Plain values: read from TOML, and made of results for JSON.

The size and the nesting of a TOML file are limited before it is parsed.  The standard library's parser is recursive,
and its time grows with the square of the number of parts of a dotted key: without limits a file of 80 kB takes minutes
and gigabytes.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from springpot.machine.faults import FileError
from springpot.machine.files import read_text

MOST_BYTES = 2_000_000
DEEPEST = 8  # brackets within brackets, and parts of a dotted key; a study needs three

# the time is always proportional to the length of the file: texts in three quotes end where it does, if not sooner, and
# the other quantifiers are possessive (with the lookahead of those Python 3.11.2 has them wrong)
_TEXT_OR_COMMENT = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*(?:"{3,5}|\Z)'
    r"|'''(?:[^']|'(?!''))*(?:'{3,5}|\Z)"
    r'|"(?:[^"\\\n]|\\.)*+(?:"|$)'
    r"|'[^'\n]*+(?:'|$)"
    r"|\#[^\n]*+",
    re.DOTALL | re.MULTILINE,
)
_MANY_PARTS = re.compile(rf"(?:\.[^.=,\[\]{{}}\n]*+){{{DEEPEST}}}")
_BRACKET = re.compile(r"[\[\]{}]")


def read_toml(path: str | Path, title: str) -> dict[str, Any]:
    """Content of a TOML file; a byte order mark at its beginning is ignored.

    Parameters
    ----------
    path : str or Path
    title : str
        Name of the file in errors, such as ``"study file 'a.toml'"``.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    FileError
        If it cannot be read, is not a file, larger than `MOST_BYTES`, nested deeper than `DEEPEST`, not UTF-8 or not
        TOML.
    """
    return toml_of(read_text(path, title, MOST_BYTES), title)


def toml_of(text: str, title: str) -> dict[str, Any]:
    """The same of the text of a file.

    Examples
    --------
    >>> toml_of("a = 1", "the file")
    {'a': 1}
    """
    bare = _TEXT_OR_COMMENT.sub(lambda match: "" if match[0].startswith("#") else "s", text)
    if _MANY_PARTS.search(bare):
        raise FileError(f"{title} has a key of more than {DEEPEST} parts (a.b.c has three).")
    deep = 0
    for bracket in _BRACKET.finditer(bare):
        deep = deep + 1 if bracket[0] in "[{" else max(0, deep - 1)
        if deep > DEEPEST:
            raise FileError(f"{title} is nested deeper than {DEEPEST} brackets.")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason = " ".join(str(error).split())
        raise FileError(f"{title} is not TOML: {reason if len(reason) < 200 else reason[:200] + '...'}.") from None
    except ValueError:  # Python reads no whole number of more than 4300 digits
        raise FileError(f"{title} holds a number with thousands of digits.") from None


def plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """The same with None for NaN and infinity, lists for tuples and arrays, dicts for dataclasses, also inside of them.

    Examples
    --------
    >>> plain({"value": 1.0, "error": float("nan"), "range": (0.0, float("inf"))})
    {'value': 1.0, 'error': None, 'range': [0.0, None]}
    """
    return {str(name): _plain(value) for name, value in values.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return plain(value)
    if is_dataclass(value):
        return plain({own.name: getattr(value, own.name) for own in fields(value)})
    if hasattr(value, "tolist"):  # of NumPy
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
