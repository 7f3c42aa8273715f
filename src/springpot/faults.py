"""Common errors, and functions to write names and values in their sentences."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable, Sequence

__all__ = ["FileFault", "NotCovered", "Stopped", "cause_of", "few", "listed", "meant", "shown"]

MOST_WORDS = 24  # of a list in a sentence

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60
_SHORT.maxlevel, _SHORT.maxlist, _SHORT.maxtuple, _SHORT.maxdict = 3, 6, 6, 4

_TELLING = ("Error", "Unknown", "Invalid", "No implementation", "Cannot", "cannot", "not supported", "missing")


class FileFault(ValueError):
    """A file cannot be used; the sentence names keys of the file, not flags or arguments."""


class Stopped(Exception):
    """Work was stopped, as was asked, before it had a result."""


class NotCovered(ValueError):
    """A method does not cover this problem; the message says what it covers."""


def shown(value: object) -> str:
    """The repr of any value, shortened if it is long.

    Examples
    --------
    >>> shown([0.5, "x" * 100])
    "[0.5, 'xxxxxxxxxxxxxxxxxxxxxxxxxxx...xxxxxxxxxxxxxxxxxxxxxxxxxxxx']"
    """
    try:
        return _SHORT.repr(value)
    except ValueError:  # Python writes no whole number of more than 4300 digits
        return "a very long number"


def few(words: Iterable[str]) -> str:
    """Words with commas; of many the first ones, and the number of the others.

    Examples
    --------
    >>> few(["order", "coefficient"]), few([f"contact_{n}" for n in range(200)])[-34:]
    ('order, coefficient', 'contact_22, contact_23, 176 others')
    """
    return ", ".join(_first([*words]))


def listed(words: Sequence[str], last: str = "and") -> str:
    """Words as a list in a sentence; of many the first ones, and the number of the others.

    Examples
    --------
    >>> listed(["order", "coefficient", "position"])
    'order, coefficient and position'
    """
    own = _first(words)
    return f" {last} ".join(filter(None, [", ".join(own[:-1]), own[-1]]))


def _first(words: Sequence[str]) -> list[str]:
    left = len(words) - MOST_WORDS
    return [*words] if left <= 1 else [*words[:MOST_WORDS], f"{left} others"]


def meant(word: str, names: Iterable[str]) -> str:
    """The words "; did you mean ...?" with the closest name, or an empty string.

    Examples
    --------
    >>> meant("avering", ["averaging", "envelope"])
    '; did you mean averaging?'
    """
    close = difflib.get_close_matches(word[:100], names, n=1, cutoff=0.7)
    return f"; did you mean {close[0]}?" if close else ""


def cause_of(reason: Exception) -> str:
    """The line with the cause, from a compiler's message."""
    lines = [line.strip() for line in str(reason).splitlines()]
    lines = [line for line in lines if line and not line.startswith(("During:", "File "))]
    telling = [line for line in lines if any(word in line for word in _TELLING)]
    return (telling or lines or [type(reason).__name__])[-1]
