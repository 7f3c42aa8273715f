"""Checks of measured columns: each error is one sentence, and knows the point that is wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.machine.arguments import LARGEST
from springpot.machine.faults import shown

__all__ = ["FloatArray", "PointFault", "column", "enough", "frequencies", "positive", "rows"]

FloatArray = NDArray[np.float64]


class PointFault(ValueError):
    """One point of the data is not right.

    Parameters
    ----------
    name : str
        Of the column.
    place : int
        Of the point, from 0.
    what : str
        The rest of the sentence.

    Examples
    --------
    >>> print(PointFault("loss", 3, "must be greater than 0, not -1."))
    loss[3] must be greater than 0, not -1.
    """

    def __init__(self, name: str, place: int, what: str) -> None:
        super().__init__(f"{name}[{place}] {what}")
        self.name, self.place, self.what = name, place, what


def column(values: object, name: str) -> FloatArray:
    """A column of finite numbers, which cannot be changed.

    Raises
    ------
    TypeError, ValueError, PointFault
        If it is none.

    Examples
    --------
    >>> column((1, 2.5), "time").tolist()
    [1.0, 2.5]
    """
    try:
        found = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a list of numbers, not {shown(values)}.") from None
    if found.ndim != 1:
        raise ValueError(f"{name} must be a list of numbers, not an array of {found.ndim} dimensions.")
    wrong = ~np.isfinite(found) | (np.abs(found) > LARGEST)
    if wrong.any():
        place = int(np.argmax(wrong))
        raise PointFault(name, place, f"must be a finite number, not {found[place]:g}.")
    found.flags.writeable = False
    return found


def positive(values: object, name: str, length: int | None = None) -> FloatArray:
    """A column of positive numbers, of this length if one is given.

    Raises
    ------
    TypeError, ValueError, PointFault
        If it is none.
    """
    found = column(values, name)
    if length is not None and found.size != length:
        raise ValueError(f"{name} must have a number for each of the {length} points, not {found.size}.")
    if (found <= 0.0).any():
        place = int(np.argmax(found <= 0.0))
        raise PointFault(name, place, f"must be greater than 0, not {found[place]:g}.")
    return found


def frequencies(values: object) -> FloatArray:
    """At least three frequencies in ascending order.

    Raises
    ------
    TypeError, ValueError, PointFault
        If they are none.

    Examples
    --------
    >>> frequencies([1, 2, 4]).tolist()
    [1.0, 2.0, 4.0]
    """
    found = positive(values, "frequency_hz")
    enough(found, "frequency_hz")
    if (np.diff(found) <= 0.0).any():
        place = int(np.argmax(np.diff(found) <= 0.0)) + 1
        raise PointFault("frequency_hz", place, f"must be above the frequency before it, not {found[place]:g}.")
    return found


def enough(found: FloatArray, name: str) -> None:
    """Three points at least.

    Raises
    ------
    ValueError
        If there are fewer.
    """
    if found.size < 3:
        raise ValueError(f"{name} must have at least 3 points, not {found.size}.")


def rows(values: object, samples: int) -> FloatArray:
    """Paths, each of so many samples.

    Raises
    ------
    TypeError, ValueError, PointFault
        If they are none.
    """
    try:
        found = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"values must be numbers, one for each time, not {shown(values)}.") from None
    found = found[np.newaxis] if found.ndim == 1 else found
    if found.ndim != 2 or found.shape[0] == 0 or found.shape[1] != samples:
        raise ValueError(f"values must have one number for each of the {samples} times, or rows of them, not an array "
                         f"of shape {found.shape}.")  # fmt: skip
    wrong = ~np.isfinite(found) | (np.abs(found) > LARGEST)
    if wrong.any():
        place = int(np.argwhere(wrong)[0, 1])
        raise PointFault("values", place, f"must be a finite number, not {found[wrong][0]:g}.")
    found.flags.writeable = False
    return found
