"""The door: a file of measurements, whose kind is found from its content, as a table of columns."""

from __future__ import annotations

import codecs
import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, islice
from pathlib import Path
from typing import BinaryIO

from springpot.files.matlab import is_matlab, read_matlab
from springpot.files.strong_motion import is_cosmos, is_peer, is_smc, read_cosmos, read_peer, read_smc
from springpot.files.table import Stated, Table
from springpot.files.text import HEAD, Sheet, lines_of, sheet_of, table_of
from springpot.files.universal import is_universal, read_universal
from springpot.machine.faults import FileError
from springpot.machine.files import open_bytes

MOST_BYTES = 200_000_000
_SNIFFED = 4096
_PIECE = 1 << 20
_MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}


def read_table(
    source: str | Path | bytes, title: str, stated: Stated, note: Callable[[str, int], None] | None = None
) -> Table:
    """The columns of a file in SI units.

    Parameters
    ----------
    source : str, Path or bytes
        A file, or the content of one.
    title : str
        Names it in what is said of its faults.
    stated : Stated
        What the caller says of it.
    note : callable, optional
        Is given each comment of a text, without its sign, and the number of its line.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    FileError
        One sentence that says what is wrong in it, and what to do.

    Examples
    --------
    >>> read_table(b"Time (sec),Acc (G)\\n0,0\\n0.01,1\\n", "a.csv", Stated()).columns[1].values.tolist()
    [0.0, 9.80665]
    """
    with contents(source, title, stated, note) as found:
        return found if isinstance(found, Table) else table_of(found, stated)


@contextmanager
def contents(
    source: str | Path | bytes, title: str, stated: Stated, note: Callable[[str, int], None] | None = None,
    texts: Sequence[str] = (), stop: Callable[[], bool] | None = None,
) -> Iterator[Table | Sheet]:  # fmt: skip
    """A file of measurements as `read_table` takes it; of a text with a header the rows are still to be read.

    Parameters
    ----------
    source, title, stated, note
        As of `read_table`.
    texts : sequence of str
        A header below which there need not be numbers.
    stop : callable, optional
        Tells whether to stop reading.
    """
    opened = _given(source) if isinstance(source, bytes) else open_bytes(source, title, MOST_BYTES)
    with opened as file:
        begin = file.read(_SNIFFED)
        if is_matlab(begin):
            yield read_matlab(file, title, stated)
        elif is_universal(begin):
            yield read_universal(file, title, stated)
        else:
            notes: list[str] = []
            text = io.TextIOWrapper(file, _encoding(file, begin, title, notes))
            try:
                lines = lines_of(text, title, stop)
                head = [*islice(lines, HEAD)]
                whole = chain(head, lines)
                if is_smc(head):
                    found: Table | Sheet = read_smc(whole, title, stated)
                elif is_cosmos(head):
                    found = read_cosmos(whole, title, stated)
                elif is_peer(head):
                    found = read_peer(whole, title, stated)
                else:
                    found = sheet_of(whole, title, stated, note, texts)
                found.notes[:0] = notes
                yield found
            except UnicodeDecodeError:
                raise FileError(f"{title} is not text, nor a kind of file that is read here: save it as CSV.") from None
            finally:
                text.detach()


@contextmanager
def _given(content: bytes) -> Iterator[BinaryIO]:
    yield io.BytesIO(content)


def _encoding(file: BinaryIO, begin: bytes, title: str, notes: list[str]) -> str:
    """That of a text: by its byte order mark, else UTF-8 if it can be, else Latin-1; then the file is at its begin."""
    file.seek(0)
    for mark, name in _MARKS.items():
        if begin.startswith(mark):
            return name
    if b"\0" in begin:
        raise FileError(f"{title} is not text, nor a kind of file that is read here: save it as CSV.")
    decoder, name = codecs.getincrementaldecoder("utf-8")(), "utf-8"
    try:
        while piece := file.read(_PIECE):
            decoder.decode(piece)
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        name = "latin-1"
        notes.append("it is not in UTF-8, and is read as Latin-1")
    file.seek(0)
    return name
