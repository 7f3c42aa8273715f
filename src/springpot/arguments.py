"""Check of a number that a user gives."""

from __future__ import annotations

import math
import numbers

__all__ = ["LARGEST", "finite_number"]

LARGEST = 1e50  # of any number of a problem: squares, cubes and their ratios stay far from the ends of double precision


def finite_number(
    value: object, name: str, *, low: float = -math.inf, high: float = math.inf, open_low: bool = False, hint: str = ""
) -> float:
    """Return ``value`` as a float, or raise one sentence that names the argument and its allowed range.

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
    return number


def _sentence(hint: str) -> str:
    return f" {hint}" if hint else ""


def _range(low: float, high: float, open_low: bool) -> str:
    if math.isinf(low) and math.isinf(high):
        return "a finite number"
    if math.isinf(high):
        return f"a finite number {'greater than' if open_low else 'at least'} {low:g}"
    return f"in {'(' if open_low else '['}{low:g}, {high:g}]"
