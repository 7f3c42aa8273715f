"""Repetitions on disk: each is a line of a record as soon as it has ended, so that a killed run goes on from there."""

from __future__ import annotations

import math
from dataclasses import dataclass
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
    record : Record or None
    failure : str
        Why something could not be written; empty if all was.

    Raises
    ------
    FileError
        If it holds something else, cannot be read or written, is no file, or is too large.
    """

    def __init__(self, path: Path | None) -> None:
        self.path, self.failure = path, ""
        self.record = None if path is None else Record(path, "exceedance", "save")

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


@dataclass(frozen=True)
class Saved:
    """The repetitions of one quantity that a file has, and where further ones are written.

    Parameters
    ----------
    file : SavedFile
    key : str
    levels : int
    """

    file: SavedFile
    key: str
    levels: int

    def find(self, stream: int, splits: bool, paths: int, number: int) -> Tally | None:
        """The one of this stream, kind, number of paths, and number."""
        record = self.file.record
        own = None if record is None else record.get(digest([self.key, stream, splits, paths, number]))
        if own is None:
            return None
        try:
            exceeded, weights, reached, iterations, ends = (_numbers(own[name]) for name in _NUMBERS)
            steps = float(own["path_steps"])
        except (KeyError, TypeError, ValueError, OverflowError):
            return None
        shapes = exceeded.shape, weights.shape, reached.shape, iterations.shape
        shares = np.concatenate([exceeded.ravel(), weights.ravel()])
        is_one = (
            shapes == ((1, 2, self.levels), (1,), (1,), (1,))
            and ends.size in (0, paths * MARKS)
            and ((shares >= 0.0) & (shares <= 1.0 + 1e-9)).all()
            and 0.0 < steps < math.inf
            and 0.0 <= iterations[0] < 2**31
            and not (np.isnan(reached).any() or np.isnan(ends).any())
        )
        if not is_one:  # its numbers are none that a repetition can have
            return None
        return Tally(exceeded, weights, reached, iterations.astype(np.int64), steps, True, ends.reshape(-1, MARKS))

    def add(self, tally: Tally, *of: Any) -> None:
        """Write it; where that fails the run goes on without the file, for what it computes is worth more."""
        record = self.file.record
        if record is None or self.file.failure or not tally.complete:
            return
        numbers = {name: getattr(tally, name).tolist() for name in _NUMBERS}
        try:
            record.add(digest([self.key, *of]), {"of": of, **numbers, "path_steps": tally.path_steps})
        except OSError as error:
            self.file.failure = (error.strerror or str(error)).lower()


def _numbers(given: Any) -> Floats:
    found = np.array(given)
    if found.dtype.kind not in "fiu" and found.size:
        raise TypeError("no numbers")
    return found.astype(float)
