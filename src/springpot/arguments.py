"""Check of a number that a user gives, and numbers that are marked as free."""

from __future__ import annotations

import math
import numbers
from typing import Any

__all__ = ["LARGEST", "Free", "finite_number"]

LARGEST = 1e50  # of any number of a problem: squares, cubes and their ratios stay far from the ends of double precision


class Free(float):
    """A number to be found, marked by `springpot.free`: everywhere else it is the number at which the search starts.

    Parameters
    ----------
    start : float
        The number that it is.
    name : str
    low, high : float
        Its bounds.

    Notes
    -----
    Arithmetic gives plain numbers: ``2 * springpot.free("k", 1.0, (0.1, 10.0))`` is 2, and no longer free.

    Examples
    --------
    >>> stiffness = Free(80.0, "k", 10.0, 200.0)
    >>> stiffness, stiffness == 80.0, stiffness.high
    (free('k', 80.0, (10.0, 200.0)), True, 200.0)
    """

    __slots__ = ("high", "low", "name")
    name: str
    low: float
    high: float

    def __new__(cls, start: float, name: str, low: float, high: float) -> Free:
        number = super().__new__(cls, start)
        number.name, number.low, number.high = name, low, high
        return number

    def __getnewargs__(self) -> tuple[Any, ...]:
        return float(self), self.name, self.low, self.high

    def __repr__(self) -> str:
        return f"free({self.name!r}, {float(self)!r}, ({self.low!r}, {self.high!r}))"


def finite_number(
    value: object, name: str, *, low: float = -math.inf, high: float = math.inf, open_low: bool = False, hint: str = ""
) -> float:
    """Return ``value`` as a float, or raise one sentence that names the argument and its allowed range.

    A `Free` number is returned as it is; its bounds must be allowed too.

    Parameters
    ----------
    value : object
        What the caller gave.
    name : str
        The argument's name, for the message.
    low, high : float
        Allowed range, ends included; with ``open_low`` the lower end is excluded.
    hint : str
        What the argument means, appended to the message.

    Raises
    ------
    TypeError
        If ``value`` is not a real number (strings and booleans are not).
    ValueError
        If it is NaN, infinite or outside the range.

    Examples
    --------
    >>> finite_number(2, "duration", low=0.0)
    2.0
    """
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} must be a real number, not {value!r} ({type(value).__name__}).{_sentence(hint)}")
    try:
        number = float(value)
    except OverflowError:  # a whole number beyond double precision
        number = math.inf
    inside = (number > low if open_low else number >= low) and number <= high
    if not math.isfinite(number) or not inside:
        raise ValueError(f"{name} must be {_range(low, high, open_low)}, not {number:g}.{_sentence(hint)}")
    if isinstance(value, Free):
        for bound in (value.low, value.high):
            try:
                finite_number(bound, name, low=low, high=high, open_low=open_low)
            except ValueError as fault:
                raise ValueError(f"{fault} This is a bound of the free number {value.name}.") from None
        return value
    return number


def _sentence(hint: str) -> str:
    return f" {hint}" if hint else ""


def _range(low: float, high: float, open_low: bool) -> str:
    if math.isinf(low) and math.isinf(high):
        return "a finite number"
    if math.isinf(high):
        return f"a finite number {'greater than' if open_low else 'at least'} {low:g}"
    return f"in {'(' if open_low else '['}{low:g}, {high:g}]"
