"""What every part checks when it is made, and how it is written in an equation."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import Field, fields
from typing import Any, ClassVar, Self

from springpot.machine.arguments import LARGEST, Free, Lost, Uncertain, finite_number, items_of
from springpot.machine.faults import in_line, is_long, listed, meant, shown


class Checked:
    """What every part and law is: it says which argument was meant where it is given one that it does not have.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier
    >>> Barrier(-1.0, e=0.8)
    Traceback (most recent call last):
    TypeError: Barrier has no argument 'e'; did you mean restitution?
    """

    tag: ClassVar[dict[str, str]] = {}  # what a file says beside its numbers

    def __new__(cls, *values: object, **given: object) -> Self:
        own = fields_of(cls)
        check_names(cls.__name__, given, [one.name for one in own], [one.name for one in own if one.repr])
        in_order = (one.name for one in own if not one.kw_only)
        for name, value in (*zip(in_order, values, strict=False), *given.items()):
            for number in value if isinstance(value, tuple | list) else (value,):
                if isinstance(number, Lost):
                    raise ValueError(
                        f"{name} cannot follow {listed(number.names)} through this expression: only sums with and "
                        "products by plain numbers, and powers of one number with positive bounds, keep their mark; "
                        "mark the result itself."
                    )
        return super().__new__(cls)


def fields_of(kind: type[Checked]) -> list[Field[Any]]:
    """The fields of a kind of part or law; last what is said only where there are several masses, with ``repr=False``.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> [own.name for own in fields_of(Spring)]
    ['stiffness', 'between', 'count', 'group']
    """
    return sorted(fields(kind), key=lambda own: not own.repr)  # type: ignore[arg-type]


def is_said(own: Field[Any], part: object) -> bool:
    """Whether a field is written: always, or where it is given."""
    return own.repr or getattr(part, own.name) != own.default


def as_call(part: Checked) -> str:
    """A part or law as a call, on one line: a long table is not written out.

    Examples
    --------
    >>> from springpot.problem.parts import RecordedExcitation
    >>> as_call(RecordedExcitation(range(40), range(40)))
    "RecordedExcitation(time=<40 numbers from 0 to 39>, values=<40 numbers from 0 to 39>, on='ground', scale=1.0)"
    """
    said = (f"{own.name}={in_line(getattr(part, own.name))}" for own in fields_of(type(part)) if is_said(own, part))
    return f"{type(part).__qualname__}({', '.join(said)})"


def is_written_out(part: object) -> bool:
    """Whether its repr is the whole of it: it has no long table.

    Examples
    --------
    >>> from springpot.problem.parts import RecordedExcitation
    >>> is_written_out(RecordedExcitation((0, 1), (0, 1))), is_written_out(RecordedExcitation(range(40), range(40)))
    (True, False)
    """
    if isinstance(part, Checked):
        return all(is_written_out(getattr(part, own.name)) for own in fields_of(type(part)))
    return not is_long(part)


def check_names(title: str, given: Iterable[str], known: list[str], usual: list[str] | None = None) -> None:
    """Refuse an argument that is not known, with the one that was meant, or the usual ones."""
    for name in given:
        if name not in known:
            raise TypeError(f"{title} has no argument {shown(name)}{meant(name, known) or _all(usual or known)}")


def _all(names: list[str]) -> str:
    return f": its argument is {names[0]}." if len(names) == 1 else f": its arguments are {listed(names)}."


def plain(value: Any, *, free: bool = False) -> Any:
    """A part, a law or a number as tables, numbers and words, for files and JSON; a function as its name.

    With ``free`` a free number is a table, else the number at which its search starts.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, PowerRestitution
    >>> plain(Barrier(-0.1, PowerRestitution(0.7, 0.1)))["restitution"]
    {'law': 'power', 'restitution': 0.7, 'speed': 0.1, 'exponent': 0.25}
    """
    if isinstance(value, Checked):
        said = [own.name for own in fields_of(type(value)) if is_said(own, value)]
        return value.tag | {name: plain(getattr(value, name), free=free) for name in said}
    if isinstance(value, tuple):
        return tuple(plain(item, free=free) for item in value)
    if free and isinstance(value, Free):
        own = value.itself
        if isinstance(value, Uncertain):
            tied = {"correlation": dict(value.correlation)} if value.correlation else {}
            law = {key: plain(each, free=True) for key, each in value.law.table.items()}
            table = {"uncertain": value.name, "value": float(own), **law, **tied}
        else:
            table = {"free": value.name, "start": float(own), "low": own.low, "high": own.high}
        follows = {"times": value.times, "plus": value.plus}
        power = {} if value.power == 1.0 else {"power": value.power}
        return table if own is value else {**table, **follows, **power}
    return getattr(value, "__qualname__", repr(value)) if callable(value) else value


def put(part: object, **values: Any) -> None:
    """Replace fields of a frozen part, while it is being made."""
    for name, value in values.items():
        object.__setattr__(part, name, value)


def real(value: object, name: str, hint: str) -> float:
    """A number of either sign."""
    return finite_number(value, name, low=-LARGEST, high=LARGEST, hint=hint)


def ends_of(bounds: object, where: str) -> tuple[float, float]:
    """Two plain numbers in ascending order; ``where`` says in a sentence whose bounds they are.

    Raises
    ------
    TypeError, ValueError
        If they are something else.

    Examples
    --------
    >>> ends_of((1, 2.5), "in the free number k")
    (1.0, 2.5)
    """
    if not isinstance(bounds, tuple | list) or len(bounds) != 2:
        raise TypeError(f"bounds must be two numbers, (low, high), not {shown(bounds)}, {where}.")
    if any(isinstance(end, Free) for end in bounds):
        raise TypeError(f"bounds must be plain numbers, not marked ones, {where}.")
    low, high = (real(end, name, f"It is a bound {where}.") for name, end in zip(("low", "high"), bounds, strict=True))
    if not low < high:
        raise ValueError(f"bounds must be in ascending order, not ({low:g}, {high:g}), {where}.")
    return low, high


def numbers_in(values: object, name: str, hint: str = "") -> tuple[float, ...]:
    """The numbers of a list, one by one."""
    given = items_of(values, f"{name} must be a list of numbers")
    if {*map(type, given)} == {float} and all(map(math.isfinite, given)) and max(map(abs, given)) <= LARGEST:
        return given  # of a long record, which is checked again whenever a part is made of it
    return tuple(real(value, f"{name}[{place}]", hint) for place, value in enumerate(given))


def tabulated(time: object, values: object, hint: str = "") -> dict[str, tuple[float, ...]]:
    """The points of a function of time: as many times as values, two or more.

    Raises
    ------
    TypeError, ValueError
        If there are not as many, or something is not a finite number.

    Examples
    --------
    >>> tabulated([0, 1], [0.5, 2])
    {'time': (0.0, 1.0), 'values': (0.5, 2.0)}
    """
    found = {"time": numbers_in(time, "time", hint), "values": numbers_in(values, "values", hint)}
    times, heights = map(len, found.values())
    if times != heights or times < 2:
        raise ValueError(
            f"time and values must have the same number of points, two or more, not {times} and {heights}."
        )
    return found


def coefficients(values: object, most: int, hint: str) -> tuple[float, ...]:
    """The coefficients of a polynomial without a constant term, at least one and at most ``most``.

    Raises
    ------
    TypeError, ValueError
        If they are not such numbers, or all of them are 0.
    """
    given = items_of(values, "coefficients must be a tuple of numbers")
    numbers = tuple(real(value, f"coefficients[{place}]", hint) for place, value in enumerate(given))
    if not 1 <= len(numbers) <= most:
        raise ValueError(f"coefficients must be 1 to {most} numbers, not {len(numbers)}. {hint}")
    if not any(numbers):
        raise ValueError(f"coefficients must not all be 0: leave the part out. {hint}")
    return numbers


def signed(number: float, symbol: str) -> str:
    """A term of an equation with its sign, as in `` - 3 x``.

    Examples
    --------
    >>> signed(-3.0, "x")
    ' - 3 x'
    """
    return f" {'-' if number < 0.0 else '+'} {abs(number):.6g} {symbol}".rstrip()
