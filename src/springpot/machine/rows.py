"""The rows of a table in a text file, one after the other and within limits: of the file only its numbers are kept."""

from __future__ import annotations

import csv
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import TextIO

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, Stopped, listed, meant, shown

MOST_COLUMNS = 1000
MOST_NUMBERS = 20_000_000
LONGEST_LINE = 100_000  # characters

# no two parts of a pattern may take the same character: the time is then proportional to the length
_HEADER = re.compile(r"([A-Za-z]+)(?:_|\s*([\[(]))(.+)")
_SPELLINGS = {"²": "2", "⁴": "4", "^": "", "(m/s2)2": "m2/s4"}  # of the same unit, in this order

Row = tuple[int, list[str]]
"""The number of its line, and its cells."""


def rows_of(
    file: TextIO,
    title: str,
    note: Callable[[str, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Iterator[Row]:
    """Each row of a table, the header first.

    Parameters
    ----------
    file : TextIO
        Cells are separated by commas, semicolons or tabs; empty lines are passed over.
    title : str
        Names the file in what is said of its faults.
    note : callable, optional
        Is given each line that begins with ``#``, and its number.
    stop : callable, optional
        Tells whether to stop reading.

    Raises
    ------
    FileError
        If it is no table, or exceeds a limit.
    Stopped
        If reading was stopped.

    Examples
    --------
    >>> import io
    >>> list(rows_of(io.StringIO("time_s;x_m\\n\\n0;1\\n"), "a.csv"))
    [(1, ['time_s', 'x_m']), (3, ['0', '1'])]
    """
    at = 0

    def lines() -> Iterator[str]:
        nonlocal at
        for at, line in enumerate(iter(partial(file.readline, LONGEST_LINE + 1), ""), start=1):
            if stop is not None and stop():
                raise Stopped("reading was stopped.")
            if len(line) > LONGEST_LINE:
                raise FileError(f"{title}, line {at}: a line must have at most {LONGEST_LINE:,} characters.")
            if line.lstrip().startswith("#"):
                if note is not None:
                    note(line, at)
            elif line.strip():
                yield line

    whole = lines()
    first = next(whole, None)
    if first is None:
        raise FileError(f"{title} is empty: it needs a header, with the name and the unit of each column.")
    separator = next((mark for mark in "\t;" if mark in first), ",")
    if (columns := first.count(separator) + 1) > MOST_COLUMNS:
        raise FileError(f"{title} must have at most {MOST_COLUMNS:,} columns, not {columns:,}.")
    reader = csv.reader(chain([first], whole), delimiter=separator, strict=True)
    try:
        for count, row in enumerate(reader, start=1):
            if reader.line_num != count:
                raise FileError(f"{title} must have one row in each line: a cell goes over the end of one.")
            yield at, row
    except csv.Error:
        raise FileError(f"{title}, line {at}: a quotation mark has no partner, or stands within a cell.") from None


@dataclass(frozen=True, eq=False)
class Table:
    """The numbers of a file.

    Attributes
    ----------
    heads : list of str
        The header, column by column.
    columns : list of (str, str)
        What each column is, and its unit in the file.
    values : ndarray, shape (rows, columns)
        In SI units.
    lines : sequence of int
        Of the file, of each row.
    """

    heads: list[str]
    columns: list[tuple[str, str]]
    values: Floats
    lines: Sequence[int]


def table_in(rows: Iterator[Row], units: Mapping[str, Mapping[str, float]], title: str) -> Table:
    """The numbers of a table whose header has the units, from its rows.

    Parameters
    ----------
    rows : iterator of Row
        As of `rows_of`, the header first.
    units : mapping
        What a column may be, and the size of each unit that it may have.
    title : str
        Names the file in what is said of its faults.

    Raises
    ------
    FileError
        If there is no such column or unit, or a row has other than one number for each column.

    Examples
    --------
    >>> import io
    >>> rows = rows_of(io.StringIO("time_ms,x (m)\\n10,3\\n"), "a.csv")
    >>> table_in(rows, {"time": {"s": 1.0, "ms": 0.001}, "x": {"m": 1.0}}, "a.csv").values.tolist()
    [[0.01, 3.0]]
    """
    line, cells = next(rows)
    heads = [" ".join(cell.split()) for cell in cells]
    columns = [column_of(head, units, line, title) for head in heads]
    values, lines = numbers_of(rows, heads, title)
    with np.errstate(over="ignore"):  # what is infinite then is refused
        values *= [units[name][unit] for name, unit in columns]  # in place: the table may be large
    return Table(heads, columns, values, lines)


def column_of(text: str, units: Mapping[str, Mapping[str, float]], line: int, title: str) -> tuple[str, str]:
    """What a column is, and its unit, from its header.

    Parameters
    ----------
    text : str
    units : mapping
        What a column may be, and the units it may have.
    line : int
        Of the header.
    title : str
        Names the file in what is said of its faults.

    Raises
    ------
    FileError
        If there is no such column or unit.

    Examples
    --------
    >>> column_of("frequency (rad/s)", {"frequency": {"Hz": 1.0, "rad/s": 0.159}}, 1, "a.csv")
    ('frequency', 'rad/s')
    >>> column_of("psd [g²/Hz]", {"psd": {"g2/Hz": 1.0}}, 1, "a.csv")
    ('psd', 'g2/Hz')
    """
    match = _HEADER.fullmatch(text)
    name = match[1].lower() if match else text.lower()
    if name not in units:
        known, such = listed([*units], "or"), listed([f"{each}_{next(iter(own))}" for each, own in units.items()], "or")
        raise FileError(f"{title}, line {line}: {shown(text)} is not a column: its name must be {known}, with a unit, "
                        f"as {such}{meant(name, units) or '.'}")  # fmt: skip
    if match is None:
        unit = next(iter(units[name]))
        raise FileError(f"{title}, line {line}: {text} must have its unit, as {name}_{unit}.")
    if (unit := _unit_of(match)) not in units[name]:
        own = listed([*units[name]], "or")
        raise FileError(f"{title}, line {line}: the unit of {name} must be {own}, not {shown(unit)}.")
    return name, unit


def _unit_of(match: re.Match[str]) -> str:
    """The unit in a header, with its powers as digits: programs write g^2/Hz and g²/Hz for g2/Hz."""
    unit = match[3].strip()
    unit = unit[:-1].strip() if match[2] and unit.endswith((")", "]")) else unit
    for other, ours in _SPELLINGS.items():
        unit = unit.replace(other, ours)
    return unit


def numbers_of(rows: Iterable[Row], heads: Sequence[str], title: str) -> tuple[Floats, Sequence[int]]:
    """The numbers below a header, and the line of each row.

    Raises
    ------
    FileError
        If a row has other than one number for each column, or there are more than `MOST_NUMBERS`.

    Examples
    --------
    >>> numbers_of([(2, ["0", "1"]), (4, ["1", "3"])], ["time_s", "x_m"], "a.csv")[0].tolist()
    [[0.0, 1.0], [1.0, 3.0]]
    """
    numbers, lines = array("d"), array("I")
    for line, row in rows:
        if len(row) != len(heads):
            raise FileError(f"{title}, line {line}: {len(heads)} numbers are needed, not {len(row)}.")
        try:
            numbers.extend(map(float, row))
        except ValueError:
            raise FileError(f"{title}, line {line}: {_first_fault(row, heads)}") from None
        lines.append(line)
        if len(numbers) > MOST_NUMBERS:
            raise FileError(f"{title} must have at most {MOST_NUMBERS:,} numbers: line {line} has more.")
    return np.asarray(numbers).reshape(-1, len(heads)), lines


def _first_fault(row: Sequence[str], heads: Sequence[str]) -> str:
    """What is wrong with the first cell that is no number."""
    for cell, head in zip(row, heads, strict=True):
        try:
            float(cell)
        except ValueError:
            text = cell.strip()
            return f"{head} must be a number, not {shown(text)}." if text else f"{head} has no number."
    raise AssertionError("every cell is a number")
