"""Repetitions on disk: each is a line of a record as soon as it has ended, so that a killed run goes on from there."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.record import Record, digest
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.rare.splitting import Tally

_NUMBERS = "exceeded", "weights", "reached", "iterations", "ends"


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
        self._record = None if path is None else Record(path, "exceedance", "save")

    def of(self, content: list[Any], levels: int) -> Saved:
        """Its repetitions of one quantity.

        Parameters
        ----------
        content : list
            All that a repetition depends on beside its number; other repetitions of the file are left alone.
        levels : int
            How many there are.
        """
        return Saved(self, digest(content), levels)

    def find(self, key: str) -> Any:
        """What a line holds, or None."""
        return None if self._record is None else self._record.get(key)

    def write(self, key: str, own: dict[str, Any]) -> None:
        """Write a repetition; where that fails the run goes on without the file, for what it computes is worth more."""
        if self._record is None or self.failure:
            return
        try:
            self._record.add(key, own)
        except OSError as error:
            self.failure = (error.strerror or str(error)).lower()


class Saved:
    """The repetitions of one quantity that a file has, and where further ones are written."""

    def __init__(self, file: SavedFile, key: str, levels: int) -> None:
        self._file, self._key, self._levels = file, key, levels

    @property
    def is_file(self) -> bool:
        """Whether there is a file."""
        return self._file.path is not None

    def find(self, stream: int, splits: bool, paths: int, number: int) -> Tally | None:
        """The one of this stream, kind, number of paths, and number."""
        own = self._file.find(self._name(stream, splits, paths, number))
        return None if own is None else _tally(own, self._levels, paths)

    def add(self, tally: Tally, *of: Any) -> None:
        """Write it."""
        if tally.complete:
            numbers = {name: getattr(tally, name).tolist() for name in _NUMBERS}
            self._file.write(self._name(*of), {"of": of, **numbers, "path_steps": tally.path_steps})

    def _name(self, *of: Any) -> str:
        return digest([self._key, *of])


def _tally(own: Any, levels: int, paths: int) -> Tally | None:
    """The repetition of a line; None if its numbers are none that a repetition can have."""
    try:
        exceeded, weights, reached, iterations, ends = (_numbers(own[name]) for name in _NUMBERS)
        steps = float(own["path_steps"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
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
