"""A matrix of a finite element program, from a file in the Matrix Market format or an OP4 file of Nastran."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Literal

import numpy as np

from springpot.files.table import MOST_NUMBERS
from springpot.files.text import Line, Row, lines_of, numbers_of
from springpot.machine.arguments import checked_path, text
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, known_word, listed, shown
from springpot.machine.files import open_bytes, read_by
from springpot.machine.installed import need

if TYPE_CHECKING:
    from scipy.sparse import csc_array

MOST_BYTES = 1_000_000_000
_MOST_ROWS = 1_000_000
_OP4_TEXT = re.compile(rb" *-?\d+ +-?\d+ +\d+ +\d\w")
_OP4_RECORDS = b"\x18\0\0\0", b"\0\0\0\x18", b"\x30\0\0\0", b"\0\0\0\x30"  # of 24 or 48 bytes


def read_matrix(path: str | Path, name: str = "") -> Floats | csc_array:
    """A real matrix from a file, for `System.from_matrices`.

    Parameters
    ----------
    path : str or Path
        In the Matrix Market format, or a Nastran OP4 file, of text or binary; which of them is found from the content.
    name : str
        Of the matrix in an OP4 file, such as ``"KAA"``, where there are several.

    Returns
    -------
    ndarray or csc_array
        An array of a Matrix Market file in the form ``array``, else one of scipy.sparse.  Both sides of the diagonal
        have the numbers of a symmetric matrix.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    TypeError, ValueError
        One sentence that says what is wrong in it, and what to do.
    MissingExtraError
        At an OP4 file without pyyeti, which reads it: the extra ``op4``.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "stiffness.mtx"
    >>> _ = place.write_text("%%MatrixMarket matrix coordinate real symmetric\\n2 2 3\\n1 1 50\\n2 1 -20\\n2 2 20\\n")
    >>> read_matrix(place).toarray().tolist()
    [[50.0, -20.0], [-20.0, 20.0]]
    """
    place, title = checked_path(path, "path"), f"matrix file {str(path)!r}"
    text(name, "name")
    with open_bytes(place, title, MOST_BYTES) as file:
        begin = file.read(80)
        file.seek(0)
        if begin[:14].lower() == b"%%matrixmarket":
            if name:
                raise FileError(f"name must be left out of {title}, which has one matrix without a name.")
            sheet = io.TextIOWrapper(file, "latin-1")
            try:
                return _market(lines_of(sheet, title), title)
            finally:
                sheet.detach()
        if begin.startswith(_OP4_RECORDS) or _OP4_TEXT.match(begin):
            return _op4(file, title, name)
    raise FileError(
        f"{title} is neither in the Matrix Market format, which begins with %%MatrixMarket, nor an OP4 file: "
        "scipy.io.mmwrite saves a matrix of another program."
    )


def _market(lines: Iterable[Line], title: str) -> Floats | csc_array:
    """SciPy's reader takes 1,5 and 1D3 for 1, and damaged files may end the process."""
    rest = iter(lines)
    _, head = next(rest)
    kinds = head.lower().split()[1:]
    known = ({"matrix"}, {"coordinate", "array"}, {"real", "double", "integer"}, {"general", "symmetric"})
    if len(kinds) != 4 or not all(kind in words for kind, words in zip(kinds, known, strict=True)):
        raise FileError(
            f"{title} must begin with %%MatrixMarket matrix, coordinate or array, real or integer, and general or "
            f"symmetric, not with {shown(head)}."
        )
    sparse, symmetric = kinds[1] == "coordinate", kinds[3] == "symmetric"
    body = _cells(rest, title)
    at, sizes = next(body, (1, list[str]()))
    must = f"{title}, line {at}: the numbers of rows and columns{' and of entries' if sparse else ''} are needed"
    if len(sizes) != 2 + sparse or not all(re.fullmatch(r"\d{1,12}", size) for size in sizes):
        raise FileError(f"{must}, not {shown(' '.join(sizes))}.")
    rows, columns, *entries = map(int, sizes)
    stored = rows * (rows + 1) // 2 if symmetric else rows * columns
    wanted = entries[0] if sparse else stored
    if min(rows, columns) == 0 or max(rows, columns) > _MOST_ROWS or (symmetric and rows != columns):
        square = ", as many of both," if symmetric else ""
        raise FileError(f"{title} must have 1 to {_MOST_ROWS:,} rows and columns{square} not {rows:,} and {columns:,}.")
    if wanted > stored or (3 if sparse else 1) * wanted > MOST_NUMBERS:
        raise FileError(f"{title} must have at most {min(stored, MOST_NUMBERS // 3):,} entries, not {wanted:,}.")
    heads = ["row", "column", "value"] if sparse else ["value"]
    numbers, at_lines = numbers_of(body, heads, range(len(heads)), title)
    if len(numbers) != wanted:
        raise FileError(f"{title} states {wanted:,} entries, and has {len(numbers):,}: it may be cut off.")
    if not np.isfinite(numbers).all():
        raise FileError(f"{title}, line {at_lines[int(np.argmin(np.isfinite(numbers).all(axis=1)))]}: a number is "
                        "not finite.")  # fmt: skip
    if not sparse:
        if not symmetric:
            return np.ascontiguousarray(numbers.reshape(columns, rows).T)
        full = np.zeros((rows, rows))
        full.T[np.triu_indices(rows)] = numbers[:, 0]
        return np.asarray(full + np.tril(full, -1).T)
    from scipy.sparse import coo_array

    places, values = numbers[:, :2] - 1.0, numbers[:, 2]
    wrong = (places != np.floor(places)).any(axis=1) | (places < 0.0).any(axis=1)
    wrong |= (places >= [rows, columns]).any(axis=1) | (symmetric & (places[:, 0] < places[:, 1]))
    if wrong.any():
        below = ", on or below the diagonal" if symmetric else ""
        raise FileError(f"{title}, line {at_lines[int(wrong.argmax())]}: row and column must be whole numbers from 1 "
                        f"to {rows} and {columns}{below}.")  # fmt: skip
    row, column = places.astype(np.int64).T
    _, first = np.unique(row * columns + column, return_index=True)
    if len(first) < wanted:
        twice = int(np.setdiff1d(np.arange(wanted), first)[0])
        raise FileError(f"{title}, line {at_lines[twice]}: row {row[twice] + 1} and column {column[twice] + 1} are "
                        "there twice; one entry is needed, their sum if that is meant.")  # fmt: skip
    found = coo_array((values, (row, column)), shape=(rows, columns)).tocsc()
    if symmetric:
        off = row != column
        found = found + coo_array((values[off], (column[off], row[off])), shape=(rows, columns)).tocsc()
    return found


def _cells(lines: Iterator[Line], title: str) -> Iterator[Row]:
    for at, line in lines:
        if "," in line and not line.lstrip().startswith("%"):
            raise FileError(f"{title}, line {at}: numbers must have a decimal point, not a comma.")
        if line.strip() and not line.lstrip().startswith("%"):
            yield at, line.split()


def _op4(file: BinaryIO, title: str, name: str) -> csc_array:
    need("op4", "an OP4 file")
    from scipy.sparse import csc_array

    def matrices(place: str) -> Any:
        from pyyeti.nastran import op4

        return op4.OP4().listload(place, sparse=True)

    content = file.read()
    if content.startswith(_OP4_RECORDS) and not _has_records(content):
        raise FileError(f"{title} has records whose lengths do not fit: it seems damaged, or cut off.")
    with np.printoptions():  # pyyeti, imported, makes NumPy print as an old version did, in the whole process
        names, found, _, kinds = read_by(matrices, content, title, "an OP4 file")
    own = {each.lower(): n for n, each in enumerate(names)}
    if not name and len(own) != 1:
        raise FileError(
            f"{title} has the matrices {listed([each.upper() for each in own])}: give name= for one of them."
        )
    at = own[known_word(name.lower(), own, "name", f"must be that of a matrix in {title}:") if name else names[0]]
    matrix: Any = found[at]
    if kinds[at] > 2:
        raise FileError(f"{title} has complex numbers in {names[at].upper()}, and a real matrix is needed.")
    if max(matrix.shape) > _MOST_ROWS:
        raise FileError(f"{title} must have at most {_MOST_ROWS:,} rows and columns in {names[at].upper()}.")
    if not np.isfinite(matrix.data).all():
        raise FileError(f"{title} has a number in {names[at].upper()} that is not finite.")
    return csc_array(matrix, dtype=float)


def _has_records(content: bytes) -> bool:
    """Whether each record of Fortran has its length, in bytes, before it and after it."""
    order: Literal["little", "big"] = "little" if content[0] else "big"
    at = 0
    while at < len(content):
        size = int.from_bytes(content[at : at + 4], order)
        end = at + 4 + size
        if content[at : at + 4] != content[end : end + 4] or len(content) < end + 4:
            return False
        at = end + 4
    return True
