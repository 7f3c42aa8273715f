"""Repetitions on disk: each is a line of a file as soon as it has ended, so that a killed run goes on from there.

A repetition is a function of its number, so what is read is what would be computed.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from springpot.machine.faults import FileError
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.rare.splitting import Tally

_NUMBERS = "exceeded", "weights", "reached", "iterations"
_BEGIN = b'{"key":'


class Saved:
    """The repetitions of a call that a file has; without a file there are none.

    Parameters
    ----------
    path : Path or None
        Made if missing.
    content : list
        All that a repetition depends on beside its number; other repetitions of the file are left alone.

    Raises
    ------
    FileError
        If the file holds something else.
    """

    def __init__(self, path: Path | None, content: list[Any]) -> None:
        self.path, self._found = path, dict[tuple[Any, ...], Tally]()
        self._key = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:32]
        lines = [] if path is None or not path.exists() else path.read_bytes().splitlines()
        for line in lines:
            try:
                own = json.loads(line)
            except ValueError:
                own = {"key": ""} if _BEGIN.startswith(line[: len(_BEGIN)]) else None  # a killed run began it
            if not isinstance(own, dict) or "key" not in own:
                raise FileError(f"save must be a file of exceedance or a new one, and {str(path)!r} is not.")
            if own["key"] == self._key:
                exceeded, weights, reached, iterations = (np.array(own[name]) for name in _NUMBERS)
                ends = np.array(own["ends"], float).reshape(-1, MARKS)
                tally = Tally(exceeded, weights, reached, iterations, own["path_steps"], True, ends)
                self._found[tuple(own["of"])] = tally

    def find(self, *of: Any) -> Tally | None:
        """The one of this stream, kind, number of paths, and number."""
        return self._found.get(of)

    def add(self, tally: Tally, *of: Any) -> None:
        """Write it."""
        if self.path is None or not tally.complete:
            return
        own = {"key": self._key, "of": of} | {name: getattr(tally, name).tolist() for name in (*_NUMBERS, "ends")}
        line = json.dumps(own | {"path_steps": tally.path_steps}).encode() + b"\n"
        with open(self.path, "ab+") as file:
            if file.tell():
                file.seek(-1, os.SEEK_END)
                line = line if file.read(1) == b"\n" else b"\n" + line
            file.write(line)
