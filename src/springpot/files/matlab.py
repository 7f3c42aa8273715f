"""Variables of a MATLAB file as columns."""

from __future__ import annotations

from typing import Any, BinaryIO, cast

import numpy as np

from springpot.files.table import MOST_NUMBERS, Stated, Table, headings, in_si
from springpot.files.units import is_unit
from springpot.machine.faults import FileError

_RATES, _STEPS = ("fs", "rate", "sampling_rate", "samplerate", "sample_rate", "fsample"), ("dt", "ts")


def is_matlab(begin: bytes) -> bool:
    """Whether a file begins as those of MATLAB, or as HDF5, in which its newer ones are."""
    return begin.startswith((b"MATLAB", b"\x89HDF")) or begin[:4] in (b"\0\0\0\0", b"\x0a\0\0\0")


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
    if file.read(4) == b"\x89HDF" or _is_seven_three(file):
        raise FileError(f"{title} is a MATLAB file of version 7.3, which is not read: save it with "
                        "save(name, '-v7'), or as CSV.")  # fmt: skip
    file.seek(0)
    from scipy.io import loadmat

    try:
        content: dict[str, Any] = loadmat(cast(Any, file), squeeze_me=False, struct_as_record=True)
    except Exception as fault:  # whatever a damaged file makes of the reader
        why = " ".join(str(fault).split())[:100] or type(fault).__name__
        raise FileError(f"{title} cannot be read as a MATLAB file, it seems damaged: {why}.") from None
    vectors: dict[str, Any] = {}
    rate = None
    for name, value in content.items():
        if name.startswith("__") or not isinstance(value, np.ndarray) or value.dtype.kind not in "iuf":
            continue
        if value.size == 1 and name.lower() in (*_RATES, *_STEPS):
            number = float(value.ravel()[0])
            if rate is not None or not 0.0 < number < 1e12:
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

    if len(sizes := {name: own.size for name, own in vectors.items()}) > 1 and len({*sizes.values()}) > 1:
        own = ", ".join(f"{name} {size}" for name, size in [*sizes.items()][:20])
        raise FileError(f"{title} has vectors of different lengths ({own}): name those that belong together, such as "
                        "columns={'t': 'time_s', 'acc': 'acceleration_g'}.")  # fmt: skip
    notes: list[str] = []
    names = [*vectors]
    found = [*headings(names, stated, title, notes)]
    notes += [f"{name} is read as {each.quantity} in {each.unit}" for name, (_, each) in
              zip(names, found, strict=False) if stated.columns is None and not is_unit(stated.unit)]  # fmt: skip
    return Table(title, in_si(np.column_stack([own.astype(float) for own in vectors.values()]), found), rate=rate,
                 notes=notes)  # fmt: skip


def _is_seven_three(file: BinaryIO) -> bool:
    file.seek(0)
    return b"MATLAB 7.3" in file.read(128)
