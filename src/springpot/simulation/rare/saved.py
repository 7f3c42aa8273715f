"""Repetitions on disk: each is a line of a file as soon as it has ended, so that a killed run goes on from there.

A line is a word, a checksum of what follows, and JSON.  A repetition is a function of its number, so what is read is
what would be computed; and what was damaged, or begun by a killed run, is computed again, to the same bits.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError
from springpot.machine.files import append_line, open_bytes
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.rare.splitting import Tally

MOST_BYTES = 2**30
_BEGIN = b"exceedance "
_DIGITS = 32  # of a checksum
_NUMBERS = "exceeded", "weights", "reached", "iterations", "ends"
_UNCHECKED = b'{"key":'  # a line of springpot 0.2

Of = tuple[int, bool, int, int]
"""By which a repetition is found: its stream, whether it splits, its number of paths, and its number."""


class SavedFile:
    """A file of repetitions, of one call or of several; without a path there is none.

    Parameters
    ----------
    path : Path or None
        Made if missing.

    Attributes
    ----------
    path : Path or None
    failure : str
        Why something could not be written; empty if all was.

    Raises
    ------
    FileError
        If it holds something else, cannot be read or written, is no file, or is too large.
    """

    def __init__(self, path: Path | None) -> None:
        self.path, self.failure = path, ""
        self._found = defaultdict[str, dict[Of, dict[str, Any]]](dict)
        if path is None:
            return
        self._read(path)
        try:
            append_line(path, b"")
        except OSError as error:
            raise FileError(f"save {str(path)!r} cannot be written: {_reason(error)}.") from None

    def _read(self, path: Path) -> None:
        lines, last = 0, b""
        try:
            with open_bytes(path, f"save {str(path)!r}", MOST_BYTES) as file:
                for line in filter(None, map(bytes.strip, file)):
                    lines, last = lines + 1, line
                    if (own := _of_line(line)) is not None:
                        self._found[own["key"]][_name_of(own)] = own
        except FileNotFoundError:
            return
        begun = lines == 1 and (last.startswith(_BEGIN) or _BEGIN.startswith(last))  # by a killed run
        if lines and not self._found and not begun:
            old = ": springpot 0.2 wrote it, without checksums" if last.startswith(_UNCHECKED) else ""
            raise FileError(f"save must be a file of exceedance or a new one, and {str(path)!r} is not{old}.")

    def of(self, content: list[Any], levels: int) -> Saved:
        """Its repetitions of one quantity.

        Parameters
        ----------
        content : list
            All that a repetition depends on beside its number; other repetitions of the file are left alone.
        levels : int
            How many there are.
        """
        key = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:_DIGITS]
        tallies = {of: _tally(own, levels) for of, own in self._found.get(key, {}).items()}
        return Saved(self, key, {of: tally for of, tally in tallies.items() if tally is not None})

    def write(self, own: dict[str, Any]) -> None:
        """Write a repetition; where that fails the run goes on without the file, for what it computes is worth more."""
        if self.path is None or self.failure:
            return
        body = json.dumps(own).encode()
        try:
            append_line(self.path, _BEGIN + _checksum(body) + b" " + body)
        except OSError as error:
            self.failure = _reason(error)


class Saved:
    """The repetitions of one quantity that a file has, and where further ones are written."""

    def __init__(self, file: SavedFile, key: str, found: dict[Of, Tally]) -> None:
        self._file, self._key, self._found = file, key, found

    @property
    def is_file(self) -> bool:
        """Whether there is a file."""
        return self._file.path is not None

    def find(self, *of: Any) -> Tally | None:
        """The one of this stream, kind, number of paths, and number."""
        return self._found.get(of)

    def add(self, tally: Tally, *of: Any) -> None:
        """Write it."""
        if not tally.complete:
            return
        numbers = {name: getattr(tally, name).tolist() for name in _NUMBERS}
        self._file.write({"key": self._key, "of": of, **numbers, "path_steps": tally.path_steps})


def _of_line(line: bytes) -> dict[str, Any] | None:
    """What a line holds; None if it was damaged, or is not whole."""
    checksum, body = line[len(_BEGIN) : len(_BEGIN) + _DIGITS], line[len(_BEGIN) + _DIGITS + 1 :]
    if not line.startswith(_BEGIN) or checksum != _checksum(body):
        return None
    try:
        own = json.loads(body)
    except (ValueError, RecursionError):
        return None
    if not isinstance(own, dict) or not isinstance(own.get("key"), str) or not _is_name(own.get("of")):
        return None
    return own


def _is_name(of: Any) -> bool:
    kinds = [int, bool, int, int]
    return isinstance(of, list) and [*map(type, of)] == kinds and all(0 <= number < 2**63 for number in of)


def _name_of(own: dict[str, Any]) -> Of:
    stream, splits, paths, number = own["of"]
    return stream, splits, paths, number


def _tally(own: dict[str, Any], levels: int) -> Tally | None:
    """The repetition of a line; None if its numbers are none that a repetition can have."""
    try:
        exceeded, weights, reached, iterations, ends = (_numbers(own[name]) for name in _NUMBERS)
        steps = float(own["path_steps"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    _, _, paths, _ = own["of"]
    shapes = exceeded.shape, weights.shape, reached.shape, iterations.shape
    shares = np.concatenate([exceeded.ravel(), weights.ravel()])
    if shapes != ((1, 2, levels), (1,), (1,), (1,)) or ends.size not in (0, paths * MARKS):
        return None
    if not ((shares >= 0.0) & (shares <= 1.0 + 1e-9)).all() or not (0.0 < steps < math.inf):
        return None
    if not (0.0 <= iterations[0] < 2**31) or np.isnan(reached).any() or np.isnan(ends).any():
        return None
    return Tally(exceeded, weights, reached, iterations.astype(np.int64), steps, True, ends.reshape(-1, MARKS))


def _numbers(given: Any) -> Floats:
    found = np.array(given)
    if found.dtype.kind not in "fiu" and found.size:
        raise TypeError("no numbers")
    return found.astype(float)


def _checksum(body: bytes) -> bytes:
    return hashlib.sha256(body).hexdigest()[:_DIGITS].encode()


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()
