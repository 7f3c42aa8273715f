"""Tables in text: how their cells are separated, their decimal mark, their header, and their numbers line by line."""

from __future__ import annotations

import csv
import re
from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, islice
from typing import TextIO

import numpy as np

from springpot.files.table import MOST_COLUMNS, MOST_NUMBERS, Stated, Table, headings, in_si
from springpot.files.units import heading_of, is_unit, quantities_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, Stopped, shown

LONGEST_LINE = 100_000  # characters
LONGEST_HEADER = 10_000  # that is divided in unusual ways
HEAD = 400  # lines by which a table is known
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x1f\x7f]")
_SIGNS = re.compile(r"[\s\"0-9+\-.,;eEdD]*")  # of numbers, with what may be between them
_DIGIT = re.compile(r"[0-9]")
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?")
_COMMENT = re.compile(r"\s*(#|%|//)+\s*")
_BLANKS = str.maketrans({"\u00a0": " ", "\u202f": " ", "\u2212": "-", "\ufeff": None})

Line = tuple[int, str]
Row = tuple[int, list[str]]
"""The number of its line, and its cells."""


def lines_of(file: TextIO, title: str, stop: Callable[[], bool] | None = None) -> Iterator[Line]:
    """The lines of a text with their numbers from 1, within limits.

    Raises
    ------
    FileError
        If a line is too long, or is no text.
    Stopped
        If reading was stopped.

    Examples
    --------
    >>> import io
    >>> list(lines_of(io.StringIO("a\\nb"), "a.csv"))
    [(1, 'a'), (2, 'b')]
    """
    at = 0
    while line := file.readline(LONGEST_LINE + 1):
        at += 1
        if stop is not None and stop():
            raise Stopped("reading was stopped.")
        if len(line) > LONGEST_LINE:
            raise FileError(f"{title}, line {at}: a line must have at most {LONGEST_LINE:,} characters.")
        line = line.rstrip("\n").rstrip("\x1a")
        if _CONTROL.search(line):
            raise FileError(f"{title}, line {at}: it has a control character, so it is not text.")
        yield at, line if line.isascii() else line.translate(_BLANKS)


@dataclass(eq=False)
class Sheet:
    """A table in text, of which the header has been read.

    Attributes
    ----------
    title : str
    names : list of str
        The header, column by column.
    line : int
        Of the header.
    rows : iterator of Row
        Those below it.
    decimal : str
        The decimal mark.
    notes : list of str
        What was assumed.
    """

    title: str
    names: list[str]
    line: int
    rows: Iterator[Row]
    decimal: str = "."
    notes: list[str] = field(default_factory=list)


def sheet_of(
    lines: Iterable[Line], title: str, stated: Stated, note: Callable[[str, int], None] | None = None,
    texts: Sequence[str] = (),
) -> Sheet:  # fmt: skip
    """A table from the lines of a text.

    Parameters
    ----------
    lines : iterable of Line
    title : str
        Names the file in what is said of its faults.
    stated : Stated
        What the caller says of it.
    note : callable, optional
        Is given each comment, without its sign, and the number of its line.
    texts : sequence of str
        A header below which there need not be numbers.

    Raises
    ------
    FileError
        If it is no table, or may be read in two ways: then the sentence names the argument that decides.

    Examples
    --------
    >>> sheet = sheet_of([(1, "time_s;x_mm"), (2, "0,00;0,5")], "a.csv", Stated())
    >>> sheet.names, sheet.decimal, list(sheet.rows)
    (['time_s', 'x_mm'], ',', [(2, ['0,00', '0,5'])])
    """
    notes: list[str] = []
    comments: list[Line] = []  # before the first row
    whole = _without_comments(lines, comments, notes, note)
    head = [*islice(whole, HEAD)]
    separator = ""
    if head and (match := re.fullmatch(r'"?sep=(.)"?', head[0][1].strip(), re.IGNORECASE)):
        separator = match[1]
        del head[0]
    if not head:
        raise FileError(f"{title} is empty: it needs a header, with the name and the unit of each column.")
    body = [(at, text) for at, text in head if are_numbers(text)]
    separator = separator or _separator([text for _, text in body], head[0][1], stated.decimal)
    for place, (at, text) in enumerate(head if texts else ()):
        if [name.lower() for name in _names(text, separator)] == [*texts]:
            rows = _rows(chain(head[place + 1 :], whole), separator, title)
            decimal = _decimal(head[place + 1 :], separator, stated.decimal, title, notes)
            return Sheet(title, [*texts], at, rows, decimal, notes)
    counts = Counter(len(_cells(text, separator)) for _, text in body)
    width = counts.most_common(1)[0][0] if counts else 0
    if (most := max(width, len(_names(head[0][1], separator)))) > MOST_COLUMNS:
        raise FileError(f"{title} must have at most {MOST_COLUMNS:,} columns, not {most:,}.")
    decimal = _decimal(body, separator, stated.decimal, title, notes)
    rows_begin = {at for at, text in body if len(_cells(text, separator)) == width}
    first = next((place for place, (at, _) in enumerate(head) if at in rows_begin), 1)
    if not body and isinstance(stated.columns, tuple):  # columns that are left out have words in each row
        cells = zip(_cells(head[0][1], separator), stated.columns, strict=False)
        first = int(not all(are_numbers(cell) for cell, header in cells if header))
    names, at = _header(head[:first], comments, width, separator, title, stated, notes)
    return Sheet(title, names, at, _rows(chain(head[first:], whole), separator, title), decimal, notes)


def table_of(sheet: Sheet, stated: Stated) -> Table:
    """The numbers of a sheet in SI units.

    Raises
    ------
    FileError
        If there is no such column or unit, or a row has other than one number for each column.

    Examples
    --------
    >>> sheet = sheet_of([(1, "time_ms,x (m)"), (2, "10,3")], "a.csv", Stated())
    >>> [column.values.tolist() for column in table_of(sheet, Stated()).columns]
    [[0.01], [3.0]]
    """
    found = [*headings(sheet.names, stated, f"{sheet.title}, line {sheet.line}", sheet.notes)]
    taken = [place for place, _ in found]
    numbers, lines = numbers_of(sheet.rows, sheet.names, taken, sheet.title, sheet.decimal)
    return Table(sheet.title, in_si(numbers, found), lines, notes=sheet.notes)


def numbers_of(
    rows: Iterable[Row], heads: Sequence[str], taken: Sequence[int], title: str, decimal: str = "."
) -> tuple[Floats, Sequence[int]]:
    """The numbers below a header, of the columns that are taken, and the line of each row.

    Raises
    ------
    FileError
        If a row has other than one cell for each column, one that is taken is no number, or there are too many.

    Examples
    --------
    >>> numbers_of([(2, ["0", "1"]), (4, ["1", "3"])], ["time_s", "x_m"], [1], "a.csv")[0].tolist()
    [[1.0], [3.0]]
    """
    numbers, lines = array("d"), array("I")
    width, point = len(heads), decimal == "."
    for line, row in rows:
        if len(row) == width + 1 and not row[-1].strip():
            del row[-1]
        if len(row) != width:
            raise FileError(f"{title}, line {line}: {width} numbers are needed, not {len(row)}.")
        if len(taken) < width:
            row = [row[place] for place in taken]
        try:
            text = "".join(row)
            if not point or "_" in text or not text.isascii():
                raise ValueError
            numbers.extend([float(cell) for cell in row])
        except ValueError:
            try:
                numbers.extend([number_of(cell, decimal) for cell in row])
            except ValueError:
                names = [heads[place] for place in taken]
                raise FileError(f"{title}, line {line}: {_first_fault(row, names, decimal)}") from None
        lines.append(line)
        if len(numbers) > MOST_NUMBERS:
            raise FileError(f"{title} must have at most {MOST_NUMBERS:,} numbers: line {line} has more.")
    return np.asarray(numbers).reshape(-1, len(taken)), lines


def are_numbers(text: str) -> bool:
    """Whether a line has numbers and nothing else, whatever is between them.

    Examples
    --------
    >>> are_numbers("0,5;1e-3"), are_numbers("time_s"), are_numbers(";;")
    (True, False, False)
    """
    return _SIGNS.fullmatch(text) is not None and _DIGIT.search(text) is not None


def number_of(cell: str, decimal: str = ".") -> float:
    """The number in a cell.

    Raises
    ------
    ValueError
        If it is none.

    Examples
    --------
    >>> number_of("0,5", ","), number_of("1.5D-03")
    (0.5, 0.0015)
    """
    if "_" in cell or not cell.isascii() or (decimal == "," and "." in cell):
        raise ValueError("it is no number.")
    text = cell.replace(",", ".") if decimal == "," else cell
    return float(text.replace("D", "E").replace("d", "e"))


def _first_fault(row: Sequence[str], heads: Sequence[str], decimal: str) -> str:
    """What is wrong with the first cell that is no number."""
    for cell, head in zip(row, heads, strict=False):
        try:
            number_of(cell, decimal)
        except ValueError:
            if not (text := cell.strip()):
                return f"{head} has no number."
            if decimal == "," and "." in text:
                return f"{head} must be a number with a decimal comma, as the others, not {shown(text)}."
            other = "; if its comma is a decimal mark, give decimal=','" if decimal == "." and "," in text else ""
            return f"{head} must be a number, not {shown(text)}{other}."
    return f"{len(heads)} numbers are needed, not {len(row)}."


def _without_comments(
    lines: Iterable[Line], comments: list[Line], notes: list[str], note: Callable[[str, int], None] | None
) -> Iterator[Line]:
    """The lines that are neither empty nor comments; the comments before the first numbers are kept."""
    begun = told = False
    for at, text in lines:
        if sign := _COMMENT.match(text):
            own = text[sign.end() :]
            if note is not None:
                note(own, at)
            if not begun:
                comments.append((at, own))
            elif not told and are_numbers(own):
                told = True
                notes.append(f"line {at} is a comment: its numbers are left out")
        elif text.strip(" \t,;"):
            begun = begun or are_numbers(text)
            yield at, text


def _separator(body: Sequence[str], first: str, decimal: str) -> str:
    """What is between two cells of most rows of numbers; without such rows, of the header."""
    if not body:
        return next((mark for mark in "\t;" if mark in first), ",")
    half = 0.5 * len(body)
    for mark in ";\t":
        if sum(mark in text for text in body) > half:
            return mark
    blanks = sum(len(text.split()) > 1 for text in body) > half
    if decimal == "," or sum("," in text for text in body) <= half:
        return " " if blanks else ";"
    words = [word for text in body for word in text.split()]
    return " " if blanks and not any(word.startswith(",") or word.endswith(",") for word in words) else ","


def _cells(text: str, separator: str) -> list[str]:
    """Those of one line; an empty one at its end is left out."""
    if separator == " ":
        return text.split()
    try:
        cells = next(csv.reader([text], delimiter=separator))
    except csv.Error:
        cells = text.split(separator)
    return cells[:-1] if len(cells) > 1 and not cells[-1].strip() else cells


def _names(text: str, separator: str, width: int = 0) -> list[str]:
    """The names in a line, as many as there are columns, if it can be divided so."""
    text = re.sub(r"(?<![A-Za-z])([EGKegk])\"(?!\s*[,;\t]|\s*$|\")", r"\1''", text)
    ways = [_cells(text, separator)]
    if width and len(ways[0]) != width and len(text) < LONGEST_HEADER:
        ways += [_cells(text, mark) for mark in "\t;," if mark in text]
        ways += [re.split(r"\s{2,}", text.strip()), re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", text)]
    cells = next((cells for cells in ways if len(cells) == width), ways[0])
    return [" ".join(cell.split()) for cell in cells]


def _rows(lines: Iterable[Line], separator: str, title: str) -> Iterator[Row]:
    if separator == " ":
        yield from ((at, text.split()) for at, text in lines)
        return
    at = 0

    def texts() -> Iterator[str]:
        nonlocal at
        for line in lines:
            at = line[0]
            yield line[1]

    reader = csv.reader(texts(), delimiter=separator, strict=True)
    try:
        for count, row in enumerate(reader, start=1):
            if reader.line_num != count:
                raise FileError(f"{title} must have one row in each line: a cell goes over the end of one.")
            yield at, row
    except csv.Error:
        raise FileError(f"{title}, line {at}: a quotation mark has no partner, or stands within a cell.") from None


def _decimal(body: Sequence[Line], separator: str, given: str, title: str, notes: list[str]) -> str:
    """The decimal mark: a comma where cells have some that separate no thousands."""
    if given:
        return given
    cells = [(at, cell.strip()) for at, text in body for cell in _cells(text, separator) if "," in cell]
    if not cells:
        return "."
    if all(_GROUPED.fullmatch(cell) for _, cell in cells):
        at, cell = cells[0]
        raise FileError(f"{title}, line {at}: the comma of {shown(cell)} may be a decimal mark or may separate "
                        "thousands: give decimal=',' if it is a decimal mark, else leave the commas out.")  # fmt: skip
    notes.append("its commas are decimal marks")
    return ","


def _header(
    before: Sequence[Line], comments: Sequence[Line], width: int, separator: str, title: str, stated: Stated,
    notes: list[str],
) -> tuple[list[str], int]:  # fmt: skip
    """The names of the columns and the line that they are in, from the lines before the first row."""
    passed, at, names = before, before[-1][0] if before else 1, list[str]()
    if isinstance(stated.columns, tuple):
        names = [f"column {n}" for n in range(1, (width or len(stated.columns)) + 1)]
    elif not before:
        for at, text in reversed(comments):
            if len(names := _names(text, separator, width)) == width and _is_header(names, stated.unit):
                notes.append(f"its header is the comment in line {at}")
                return names, at
        kinds = quantities_of(stated.unit) if stated.unit and width == 1 else []
        if len(kinds) != 1:
            such = "['acceleration_g'] and rate=" if width == 1 else "['time_s', 'acceleration_g']"
            comma = "; if its commas are decimal marks, give decimal=','" if separator == "," and width > 1 else ""
            raise FileError(f"{title} has no header: give columns=, a header for each of its {width} columns, such as "
                            f"columns={such}{comma}.")  # fmt: skip
        return [f"{kinds[0]}_{stated.unit}"], 1
    else:
        at, text = before[-1]
        names, passed = _names(text, separator, width), before[:-1]
        above = _names(passed[-1][1], separator, width) if passed else []
        if len(above) == len(names) and any(names) and all(is_unit(name) or not name for name in names):
            at, passed = passed[-1][0], passed[:-1]
            names = [f"{name} ({unit})" if unit else name for name, unit in zip(above, names, strict=True)]
        elif not _is_header(names, stated.unit):
            for _, other in reversed(passed):
                if len(heads := _names(other, separator, width)) == width and _is_header(heads, stated.unit):
                    raise FileError(f"{title}, line {at}: {_first_fault(_cells(text, separator), heads, '.')}")
        if width and len(names) != width:
            more = "; if its commas are decimal marks, give decimal=','" if separator == "," else ""
            if separator == "," and width == 2 * len(names) > 2:
                more = "; if its commas separate numbers and are decimal marks too, save it with semicolons or points"
            raise FileError(f"{title}, line {at}: it has {len(names)} names, and the rows have {width} numbers; "
                            f"columns= gives a header for each{more}.")  # fmt: skip
    if passed:
        own = [at for at, _ in passed]
        lines = f"line {own[0]} is" if len(own) == 1 else f"lines {own[0]} to {own[-1]} are"
        notes.append(f"{lines} passed over, before its table")
    return names, at


def _is_header(names: Sequence[str], unit: str) -> bool:
    """Whether each is the name of a column."""
    try:
        return all(heading_of(name, unit) for name in names)
    except ValueError:
        return False
