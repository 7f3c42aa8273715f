"""Variables of a MATLAB file as columns."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from springpot.files.table import MOST_NUMBERS, RATES, Stated, Table, headings, in_si
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, shown

_RATES, _STEPS = ("fs", "rate", "sampling_rate", "samplerate", "sample_rate", "fsample"), ("dt", "ts")
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_MATRIX, _COMPRESSED = 14, 15  # other types of elements
_NUMBERS, _COMPLEX = range(6, 16), 0x800  # classes of arrays, and a flag of them
_HEADER = 128  # bytes
_MOST_BYTES = 8 * MOST_NUMBERS


def is_matlab(begin: bytes) -> bool:
    """Whether a file begins as those of MATLAB, or as HDF5, in which its newer ones are."""
    return begin.startswith((b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file", b"\x89HDF"))


def read_matlab(file: BinaryIO, title: str, stated: Stated) -> Table:
    """The vectors of a MATLAB file, whose names are headers; ``fs`` and ``dt`` are the rate and the step.

    Raises
    ------
    FileError
        If it cannot be read, has no vectors or several of different lengths, or a unit is not known.

    Examples
    --------
    >>> import io
    >>> from scipy.io import savemat
    >>> content = io.BytesIO()
    >>> savemat(content, {"acc": [1.0, 2.0], "fs": 100.0})
    >>> read = read_matlab(content, "a.mat", Stated(unit="g"))
    >>> read.rate, read.columns[0].values.tolist()
    (100.0, [9.80665, 19.6133])
    """
    stated.refuse(title, "which is no text", "decimal")
    file.seek(0)
    whole = file.read()
    if not whole.startswith(b"MATLAB 5.0"):
        raise FileError(f"{title} is a MATLAB file of version 7.3, which is not read: save it with "
                        "save(name, '-v7'), or as CSV.")  # fmt: skip
    try:
        content = dict(_variables(whole[_HEADER:], "<" if whole[126:_HEADER] == b"IM" else ">"))
    except (ValueError, struct.error, zlib.error) as fault:
        raise FileError(f"{title} cannot be read as a MATLAB file, it seems damaged: {fault}.") from None
    vectors: dict[str, Any] = {}
    rate = None
    for name, value in content.items():
        if value.size == 1 and name.lower() in (*_RATES, *_STEPS):
            number = float(value.ravel()[0])
            if rate is not None or not RATES[0] < number < RATES[1]:
                raise FileError(f"{title} must have one rate or step above 0, such as fs = 1000 or dt = 0.001.")
            rate = number if name.lower() in _RATES else 1.0 / number
        elif value.ndim == 2 and value.size > 1:
            if min(value.shape) == 1:
                vectors[name] = value.ravel()
            else:
                long = value if value.shape[0] > value.shape[1] else value.T
                vectors |= {f"{name} {n}": own for n, own in enumerate(long.T[:1000], 1)}
    if isinstance(stated.columns, dict):
        vectors = {name: own for name, own in vectors.items() if name in stated.columns}
    if not vectors or sum(own.size for own in vectors.values()) > MOST_NUMBERS:
        raise FileError(
            f"{title} has no vectors of numbers, or none that columns= names: save vectors, such as t and acc."
        )

    if len({own.size for own in vectors.values()}) > 1:
        sizes = ", ".join(f"{name} {own.size}" for name, own in [*vectors.items()][:20])
        raise FileError(f"{title} has vectors of different lengths ({sizes}): name those that belong together, such as "
                        "columns={'t': 'time_s', 'acc': 'acceleration_g'}.")  # fmt: skip
    notes: list[str] = []
    found = [*headings([*vectors], stated, title, notes)]
    own = [*vectors.values()]
    numbers = np.column_stack([own[place] for place, _ in found])
    return Table(title, in_si(numbers, found), rate=rate, notes=notes)


def _variables(content: bytes, order: str) -> Iterator[tuple[str, Floats]]:
    """The real arrays of numbers at the top, with their names: SciPy's reader ends the process at damaged files."""
    for kind, body in _elements(content, order):
        if kind == _COMPRESSED:
            unpacked = zlib.decompressobj()
            inner = unpacked.decompress(body, _MOST_BYTES)
            if not unpacked.eof:
                raise ValueError("a variable is larger than can be read, or ends too early")
            yield from _variables(inner, order)
        elif kind == _MATRIX and body:
            parts = _elements(body, order)
            (_, flags), (_, sizes), (_, name) = (next(parts, (0, b"")) for _ in range(3))
            (own, _) = struct.unpack(f"{order}II", flags)
            shape = np.frombuffer(sizes, f"{order}i4").tolist()
            if own & 0xFF not in _NUMBERS or own & _COMPLEX or len(shape) != 2:
                continue
            kind, body = next(parts, (0, b""))
            if kind not in _TYPES or [*parts]:
                raise ValueError(f"{shown(name.decode('latin-1'))} has no numbers where they should be")
            numbers = np.frombuffer(body, order + _TYPES[kind])
            yield name.decode("ascii"), numbers.reshape(shape, order="F").astype(float)


def _elements(content: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """The types and the content of the elements, each at a multiple of eight bytes."""
    at = 0
    while at < len(content):
        kind, size = struct.unpack_from(f"{order}II", content, at)
        begin = at + 8
        if kind >> 16:  # of four bytes or less, beside its type
            kind, size, begin = kind & 0xFFFF, kind >> 16, at + 4
            at += 8
        else:
            at = begin + size + (0 if kind == _COMPRESSED else -size % 8)
        if at > len(content) or begin + size > at:
            raise ValueError("an element goes over the end of what it is in")
        yield kind, content[begin : begin + size]
