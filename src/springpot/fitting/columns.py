"""Checks of measured columns: each error is one sentence, and knows the point that is wrong."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.machine.arguments import LARGEST, finite_number, numbers_in_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import in_line
from springpot.problem.parts.checks import put


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


class Measured:
    """Data of a dataclass, whose repr is one line.

    Examples
    --------
    >>> from springpot.fitting.part_data import MeasuredModuli
    >>> MeasuredModuli([0.1, 1.0, 10.0], storage=[1.0, 2.0, 4.0])
    MeasuredModuli(frequency_hz=[0.1, 1.0, 10.0], storage=[1.0, 2.0, 4.0], loss=None, relative_error=None)
    """

    def __repr__(self) -> str:
        """As a call, on one line."""
        own = fields(self)  # type: ignore[arg-type]
        said = (f"{each.name}={in_line(getattr(self, each.name))}" for each in own)
        return f"{type(self).__name__}({', '.join(said)})"


def check_points(wrong: NDArray[np.bool_], values: NDArray[Any], name: str, words: str) -> None:
    """Nothing may be wrong with any point.

    Raises
    ------
    PointFault
        About the first that is wrong.

    Examples
    --------
    >>> try:
    ...     check_points(np.array([False, True]), np.array([3.0, 1.0]), "time", "must be above 2, not {:g}.")
    ... except PointFault as fault:
    ...     print(fault)
    time[1] must be above 2, not 1.
    """
    if wrong.any():
        place = np.argwhere(wrong)[0].tolist()
        raise PointFault(name, place[-1], words.format(values[tuple(place)]))


def falls(values: Floats) -> NDArray[np.bool_]:
    """Whether each number is not above the one before it.

    Examples
    --------
    >>> falls(np.array([1.0, 2.0, 2.0])).tolist()
    [False, False, True]
    """
    return np.diff(values, prepend=-np.inf) <= 0.0


def fixed(values: NDArray[Any]) -> NDArray[Any]:
    """The same array, which cannot be changed from here on."""
    values.flags.writeable = False
    return values


def column(values: object, name: str, length: int | None = None) -> Floats:
    """A column of finite numbers, which cannot be changed, of this length if one is given.

    Raises
    ------
    TypeError, ValueError, PointFault
        If it is none.

    Examples
    --------
    >>> column((1, 2.5), "time").tolist()
    [1.0, 2.5]
    """
    found = numbers_in_array(values, f"{name} must be a list of numbers")
    if found.ndim != 1:
        raise ValueError(f"{name} must be a list of numbers, not an array of {found.ndim} dimensions.")
    _check_finite(found, name)
    if length is not None and found.size != length:
        raise ValueError(f"{name} must have a number for each of the {length} points, not {found.size}.")
    return fixed(found)


def positive(values: object, name: str, length: int | None = None) -> Floats:
    """A column of positive numbers, of this length if one is given.

    Raises
    ------
    TypeError, ValueError, PointFault
        If it is none.
    """
    found = column(values, name, length)
    check_points(found <= 0.0, found, name, "must be greater than 0, not {:g}.")
    return found


def frequencies(values: object) -> Floats:
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
    check_points(falls(found), found, "frequency_hz", "must be above the frequency before it, not {:g}.")
    return found


def check_number(data: Any, name: str, **limits: Any) -> None:
    """A number of the data, where it is given, is a finite one within limits, from here on a float.

    Raises
    ------
    TypeError, ValueError
        If it is none.
    """
    if (value := getattr(data, name)) is not None:
        put(data, **{name: finite_number(value, name, **limits)})


def enough(found: Floats, name: str) -> None:
    """Three points at least.

    Raises
    ------
    ValueError
        If there are fewer.
    """
    if found.size < 3:
        raise ValueError(f"{name} must have at least 3 points, not {found.size}.")


def rows(values: object, samples: int, name: str = "values") -> Floats:
    """Paths, each of so many samples.

    Raises
    ------
    TypeError, ValueError, PointFault
        If they are none.
    """
    found = numbers_in_array(values, f"{name} must be numbers, one for each time")
    given, found = found.shape, found[np.newaxis] if found.ndim == 1 else found
    if found.ndim != 2 or found.shape[0] == 0 or found.shape[1] != samples:
        raise ValueError(f"{name} must have one number for each of the {samples} times, or rows of them, not an array "
                         f"of shape {given}.")  # fmt: skip
    _check_finite(found, name)
    return fixed(found)


def _check_finite(found: Floats, name: str) -> None:
    check_points(~(np.abs(found) <= LARGEST), found, name, "must be a finite number, not {:g}.")
