"""Common errors, and how names, values and numbers with their errors are written."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from typing import Any, TypeVar

MOST_WORDS = 20  # of a list in a sentence
MOST_NUMBERS = 20  # of a table that is written out

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60
_SHORT.maxlevel, _SHORT.maxlist, _SHORT.maxtuple, _SHORT.maxdict = 3, 6, 6, 4

_Value = TypeVar("_Value")

_SYMBOLS = {
    "e": ("restitution",),
    "r": ("restitution",),
    "alpha": ("order",),
    "k": ("stiffness",),
    "c": ("coefficient",),
    "C": ("coefficient",),
    "m": ("value", "mass"),
    "b": ("position",),
    "gap": ("position",),
    "side": ("free_side", "free-side"),
    "q": ("intensity",),
    "omega": ("natural_frequency", "frequency"),
    "Omega": ("natural_frequency",),
    "dt": ("step",),
    "rms": ("x_mean_square",),
    "x_rms": ("x_mean_square",),
    "v_rms": ("v_mean_square",),
    "rate": ("impact_rate",),
    **{f"{part}_{what}": (f"damping_{what}",)
       for part in ("springpot", "dashpot") for what in ("power", "force_mean", "virial")},
}  # fmt: skip
"""What is often said for a name."""

_TELLING = ("Error", "Unknown", "Invalid", "No implementation", "Cannot", "cannot", "not supported", "missing")


class FileError(ValueError):
    """A file cannot be used; the sentence names keys of the file, not flags or arguments."""


class Stopped(Exception):
    """Work was stopped, as was asked, before it had a result."""


class NotCoveredError(ValueError):
    """A method does not cover this problem; the message says what it covers."""


class NoFitError(ValueError):
    """No numbers were found with which a model follows the data; the message says how far it is off."""


def shown(value: object) -> str:
    """The repr of any value, shortened if it is long.

    Examples
    --------
    >>> shown([0.5, "x" * 100])
    "[0.5, 'xxxxxxxxxxxxxxxxxxxxxxxxxxx...xxxxxxxxxxxxxxxxxxxxxxxxxxxx']"
    """
    try:
        text = _SHORT.repr(value)
    except ValueError:  # Python writes no whole number of more than 4300 digits
        return "a very long number"
    except Exception:  # a repr of its own that fails
        return f"<{type(value).__name__}>"
    return " ".join(map(str.strip, text.split("\n")))  # of an array it has several lines


def in_line(value: Any) -> str:
    """The repr of a value on one line; of a long table how many numbers it has, and between which they lie.

    Examples
    --------
    >>> in_line((0.0, 0.5)), in_line(tuple(0.01 * n for n in range(3001)))
    ('(0.0, 0.5)', '<3001 numbers from 0 to 30>')
    >>> in_line(((0.0, 1.0), (2.0, 3.0)) * 20)
    '<40 rows of 80 numbers from 0 to 3>'
    """
    table = value.tolist() if hasattr(value, "tolist") else value
    if not is_long(table):
        return " ".join(repr(table).split())
    numbers = [*_flat(table)]
    rows = f"{len(table)} rows of " if isinstance(table[0], list | tuple) else ""
    if not all(isinstance(number, int | float) for number in numbers):
        return f"<{rows}{len(numbers)} {'complex numbers' if isinstance(numbers[0], complex) else 'entries'}>"
    return f"<{rows}{len(numbers)} numbers from {min(numbers):.6g} to {max(numbers):.6g}>"


def is_long(value: object) -> bool:
    """Whether a value is a table that is not written out."""
    return isinstance(value, list | tuple) and len([*_flat(value)]) > MOST_NUMBERS


def _flat(table: Sequence[Any]) -> Iterator[Any]:
    for one in table:
        yield from _flat(one) if isinstance(one, list | tuple) else (one,)


def few(words: Iterable[str]) -> str:
    """Words with commas; of many the first ones, and the number of the others.

    Examples
    --------
    >>> few(["order", "coefficient"]), few([f"contact_{n}" for n in range(200)])[-34:]
    ('order, coefficient', 'contact_18, contact_19, 180 others')
    """
    return ", ".join(_first([*words])).replace("\n", " ")


def listed(words: Sequence[str], last: str = "and") -> str:
    """Words as a list in a sentence; of many the first ones, and the number of the others.

    Examples
    --------
    >>> listed(["order", "coefficient", "position"])
    'order, coefficient and position'
    """
    own = _first(words)
    return f" {last} ".join(filter(None, [", ".join(own[:-1]), own[-1]]))


def _first(words: Sequence[str]) -> list[str]:
    left = len(words) - MOST_WORDS
    return [*words] if left <= 1 else [*words[:MOST_WORDS], f"{left} others"]


def meant(word: object, names: Iterable[str]) -> str:
    """The words "; did you mean ...?" with the closest name, or an empty string.

    Examples
    --------
    >>> meant("avering", ["averaging", "envelope"]), meant("e", ["position", "restitution"])
    ('; did you mean averaging?', '; did you mean restitution?')
    """
    close = nearest(word, names) if isinstance(word, str) else ""
    return f"; did you mean {close}?" if close else ""


def known_word(word: object, names: Iterable[str], what: str, must: str = "must be one of") -> str:
    """The word, if it is one of these names.

    Raises
    ------
    ValueError
        If it is not; the sentence says ``what`` it is, which names there are, and which was meant.

    Examples
    --------
    >>> known_word("averaging", ["averaging", "envelope"], "method")
    'averaging'
    """
    known = [*names]
    if not isinstance(word, str) or word not in known:
        raise ValueError(f"{what} {must} {few(known)}, not {shown(word)}{meant(word, known) or '.'}")
    return word


def nearest(word: str, names: Iterable[str]) -> str:
    """The name that was probably meant: by its symbol, or the most similar one; empty if none is near.

    Examples
    --------
    >>> nearest("stiff", ["stiffness", "order"]), nearest("rms", ["x_mean", "x_mean_square"]), nearest("?", ["x"])
    ('stiffness', 'x_mean_square', '')
    >>> nearest("springpot_power", ["input_power", "damping_power"])
    'damping_power'
    """
    known = [*names]
    import difflib  # only mistakes need it

    close = [name for name in _SYMBOLS.get(word, ()) if name in known]
    return next(iter(close or difflib.get_close_matches(word[:100], known, n=1, cutoff=0.7)), "")


class Named(dict[str, _Value]):
    """Results by name; of an unknown name the error says which one was probably meant.

    Examples
    --------
    >>> Named({"impact_rate": 2.0})["impact_rates"]
    Traceback (most recent call last):
    KeyError: 'impact_rates is not among the results; did you mean impact_rate?'
    """

    def __missing__(self, name: object) -> _Value:
        if not isinstance(name, str):
            raise KeyError(f"{shown(name)} is not among the results, only {listed([*self])}.")
        hint = "; its square is x_mean_square" if name in ("rms", "x_rms", "rms_x") and "x_mean_square" in self else ""
        if not hint:
            hint = meant(name, self).rstrip("?") or f", only {listed([*self])}"
        end = "?" if hint.startswith("; did") else "."
        raise KeyError(f"{name} is not among the results{hint}{end}")


def name_results(result: object, *fields: str) -> None:
    """Make these fields of a frozen result `Named`, while it is being made."""
    for field in fields:
        object.__setattr__(result, field, Named(getattr(result, field)))


def per_cent(share: float, digits: int = 2) -> str:
    """A share in per cent, with so many digits at most and without a power of ten.

    Examples
    --------
    >>> [per_cent(share) for share in (0.0123, 1.0, 2e-7)], per_cent(0.98765, 3)
    (['1.2 %', '100 %', '0.00002 %'], '98.8 %')
    """
    return f"{Decimal(f'{100.0 * share:.{digits}g}'):f} %"


def with_error(value: float | None, error: float | None, unit: str = "1") -> str:
    """A number: the error to two digits, the value to as many decimals, both with a power of ten where that is shorter.

    Examples
    --------
    >>> with_error(0.25904, 0.00213, "m"), with_error(1.5e-9, 1.5e-11, "m"), with_error(0.5, None)
    ('0.2590 +- 0.0021 m', '(1.500 +- 0.015)e-09 m', '0.5 (no error known)')
    """
    unit = "" if unit == "1" else f" {unit}"
    if value is None or not math.isfinite(value):
        return "none"
    if error is None or not math.isfinite(error):
        return f"{value:.5g}{unit} (no error known)"
    if error == 0.0:
        return f"{value:.5g} +- 0{unit}"
    scale = max(abs(value), error)
    power = 0 if 1e-4 <= scale < 1e6 else _power(scale)
    decimals = max(0, power - _power(error) + 1)
    if decimals > 8:
        return f"{value:.7g} +- {error:.1e}{unit}"
    digits = f"{Decimal(value).scaleb(-power):.{decimals}f} +- {Decimal(error).scaleb(-power):.{decimals}f}"
    return f"({digits})e{power:+03d}{unit}" if power else f"{digits}{unit}"


def _power(number: float) -> int:
    """The power of ten of a number written with two digits."""
    return int(f"{number:.1e}".partition("e")[2])


def cause_of(reason: Exception) -> str:
    """The line with the cause, from a compiler's message."""
    lines = [line.strip() for line in str(reason).splitlines()]
    lines = [line for line in lines if line and not line.startswith(("During:", "File "))]
    telling = [line for line in lines if any(word in line for word in _TELLING)]
    return (telling or lines or [type(reason).__name__])[-1]
