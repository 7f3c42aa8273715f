"""Common to all commands: tables, JSON, and types of flags."""

from __future__ import annotations

import contextlib
import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

from cyclopts import CoercionError, Parameter, Token

from springpot.machine.bar import say
from springpot.machine.extras import need
from springpot.machine.plain import plain
from springpot.machine.trusted import CacheWarning
from springpot.problem.messages import FileWarning


def _whole(type_: object, tokens: Sequence[Token]) -> int:
    """Cyclopts' own conversion rounds 2.5 to 2; a number of paths or a seed must be refused instead."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise CoercionError(token=tokens[0], target_type=int) from None


Whole = Annotated[int, Parameter(converter=_whole)]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object and nothing else.")]


def check_picture(path: str | None, name: str = "plot") -> None:
    """Raise an error, before any work, if a picture that is asked for cannot be written to this path."""
    if path is None:
        return
    need("plots", "a picture")
    if not path.endswith(".png"):
        raise ValueError(f"{name} must end in .png, but it is {path!r}.")
    if not Path(path).resolve().parent.is_dir():
        raise ValueError(f"{name} must lie in a folder that exists, but {str(Path(path).parent)!r} does not.")


def print_table(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip_longest(*rows, fillvalue="")]
    for row in rows:
        print("".join(f"  {cell:<{width}}" for cell, width in zip(row, widths, strict=False)).rstrip())


def print_json(answer: Mapping[str, Any]) -> None:
    print(json.dumps(plain(answer), indent=2, allow_nan=False))


@contextlib.contextmanager
def warnings_as_sentences() -> Iterator[None]:
    """Context in which warnings of an unused cache and of files are one sentence, without their place in the code."""
    before = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, CacheWarning | FileWarning):
            say(f"warning: {message}")
        else:
            before(message, category, *place, **more)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield
