"""A table of measurements: its columns in SI units, and what the caller says of a file that does not say it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, get_args

import numpy as np

from springpot.files.units import UNITS, Decimal, Heading, heading_of, is_unit
from springpot.machine.arguments import items_of, one_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, listed, shown
from springpot.machine.sampling import checked_rate

MOST_COLUMNS = 1000
MOST_NUMBERS = 20_000_000
RATES = 1e-9, 1e12  # in samples per second, between which one of a file lies
_UNIT = re.compile(r"\s*[(\[]|_(?=[^_]*$)")  # where it begins in a header


@dataclass(frozen=True)
class Stated:
    """What the caller says of a file.

    Parameters
    ----------
    unit : str
        Of the values, where the file does not say it.
    columns : sequence of str or mapping
        A header for each column, such as ``"time_s"``, empty for one that is left out; or headers by the names in the
        file, of the columns that are wanted.
    rate : float or None
        Samples per second, of a file without times.
    decimal : {"", ".", ","}
        The decimal mark, where it cannot be told from the file.

    Raises
    ------
    TypeError, ValueError
        One sentence that begins with the argument's name.

    Examples
    --------
    >>> Stated(unit="g", rate=200).rate
    200.0
    """

    unit: str = ""
    columns: Any = None
    rate: float | None = None
    decimal: Decimal = ""

    def __post_init__(self) -> None:
        if not isinstance(self.unit, str) or (self.unit and not is_unit(self.unit)):
            raise ValueError(f"unit must be a unit such as 'g', 'm/s2' or 'g2/Hz', not {shown(self.unit)}.")
        one_of(self.decimal, "decimal", get_args(Decimal), "It is the decimal mark of a file.")
        object.__setattr__(self, "rate", checked_rate(self.rate))
        if self.columns is None:
            return
        must = "columns must be a header for each column, or a mapping from names in the file to headers"
        is_mapping = isinstance(self.columns, Mapping)
        given = dict(self.columns) if is_mapping else tuple(items_of(self.columns, must))
        words = [*given, *given.values()] if isinstance(given, dict) else given
        if isinstance(self.columns, str) or not words or not all(isinstance(word, str) for word in words):
            raise TypeError(f"{must}, not {shown(self.columns)}.")
        object.__setattr__(self, "columns", given)

    def refuse(self, title: str, why: str, *names: str) -> None:
        """Refuse what is given beside a file that states it.

        Raises
        ------
        FileError
            If one of these is given.
        """
        for name in names:
            if getattr(self, name):
                raise FileError(f"{name} must be left out of {title}, {why}.")


@dataclass(frozen=True, eq=False)
class Column:
    """A column of a file, in SI units.

    Attributes
    ----------
    header : str
        As in the file.
    quantity, unit : str
        What it is, one of UNITS, and its unit in the file.
    values : ndarray
    """

    header: str
    quantity: str
    unit: str
    values: Floats


@dataclass(frozen=True, eq=False)
class Table:
    """The numbers of a file.

    Attributes
    ----------
    title : str
        Names the file in what is said of its faults.
    columns : list of Column
    lines : sequence of int
        Of the file, of each row; empty where rows have no lines.
    rate : float or None
        Samples per second, of a table without times.
    settings : dict of str
        Of its comments.
    notes : list of str
        What was assumed.
    """

    title: str
    columns: list[Column]
    lines: Sequence[int] = ()
    rate: float | None = None
    settings: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def where(self, row: int) -> str:
        """A row, in words."""
        return f"{self.title}, line {self.lines[row]}" if len(self.lines) else f"{self.title}, point {row + 1}"

    def of(self, quantity: str) -> list[Column]:
        """The columns of a quantity."""
        return [column for column in self.columns if column.quantity == quantity]

    def alike(self, quantity: str, stated: Stated) -> list[Column]:
        """The columns of a quantity, where they have one name in the file or were chosen by the caller.

        Raises
        ------
        FileError
            If they have several names, as the axes of one accelerometer have.
        """
        found = self.of(quantity)
        if stated.columns is None and len({_UNIT.split(column.header)[0].lower() for column in found}) > 1:
            others = {column.header: f"{column.quantity}_{column.unit}" for column in (*self.of("time"), found[0])}
            names = listed([shown(each.header) for each in found])
            raise FileError(f"{self.title} has columns of several names, {names}: columns= takes one, such as "
                            f"columns={others}.")  # fmt: skip
        return found

    def sampled_at(self, rate: float | None) -> float | None:
        """The rate of a record without a column of the time: its own or what is given, which must not contradict.

        Raises
        ------
        FileError
            If there are two of rate and column, or none.
        """
        if self.of("time"):
            if rate is not None:
                raise FileError(f"{self.title} has a column of the time: leave out rate.")
            return None
        if self.rate is not None and rate is not None:
            raise FileError(f"{self.title} states its rate, {self.rate:g} samples per second: leave out rate.")
        if (found := self.rate or rate) is None:
            raise FileError(f"{self.title} has no column of the time: give the rate, in samples per second, or a "
                            "column time_s.")  # fmt: skip
        return found


def headings(names: Sequence[str], stated: Stated, where: str, notes: list[str]) -> Iterator[tuple[int, Heading]]:
    """The columns that are taken, by their places, from the names in a file and what the caller says of them.

    Parameters
    ----------
    names : sequence of str
    stated : Stated
    where : str
        The place of the names, in words.
    notes : list of str
        Is given what was assumed.

    Raises
    ------
    FileError
        If a name is not that of a column, or columns do not fit.

    Examples
    --------
    >>> [each.unit for _, each in headings(["T", "Az"], Stated(columns={"Az": "a_g"}), "line 1", [])]
    ['g']
    """
    wanted: list[tuple[int, str, str]] = []
    if isinstance(stated.columns, dict):
        for name, header in stated.columns.items():
            places = [place for place, own in enumerate(names) if own == name or own.startswith(f"{name} (")]
            if len(places) != 1:
                count = "no" if not places else f"{len(places)}"
                raise FileError(f"{where}: columns has {shown(name)}, and the file has {count} column of that name, of "
                                f"{listed([*map(shown, names)])}.")  # fmt: skip
            wanted.append((places[0], header, "columns: "))
    elif stated.columns is not None:
        if len(stated.columns) != len(names):
            raise FileError(f"{where}: columns must have a header for each of the {len(names)} columns of the file, "
                            f"empty for one that is left out, not {len(stated.columns)}.")  # fmt: skip
        wanted = [(place, header, "columns: ") for place, header in enumerate(stated.columns) if header]
    else:
        wanted = [(place, name, "") for place, name in enumerate(names)]
    for place, name, which in wanted:
        try:
            found = heading_of(name, stated.unit)
        except ValueError as fault:
            raise FileError(f"{where}: {which}{fault}") from None
        if found.note:
            notes.append(found.note)
        yield place, found


def in_si(numbers: Floats, found: Iterable[tuple[int, Heading]]) -> list[Column]:
    """The columns of rows of numbers in SI units, which may be infinite then."""
    with np.errstate(over="ignore"):
        return [
            Column(each.text, each.quantity, each.unit, numbers[:, n] * UNITS[each.quantity][each.unit])
            for n, (_, each) in enumerate(found)
        ]
