"""What a design is asked for: the numbers to choose, the cost and the limits, all checked."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.machine.arguments import LARGEST, Free, finite_number, named_arguments
from springpot.machine.arrays import Floats
from springpot.machine.faults import few, known_word, meant, shown

Wanted = str | Callable[..., float]
"""The name of a result or of a free number, or a function of some whose arguments are called as they are."""

_QUANTILE = re.compile(r"(.+)_quantile_(0?\.\d+)")


@dataclass(frozen=True)
class Cost:
    """What is to be least, or greatest.

    Attributes
    ----------
    name : str
    takes : tuple of str
        The results and free numbers that it depends on.
    function : callable or None
        Of these; None if it is one of them itself.
    greatest : bool
        Whether it is to be as great as possible, and not as small.
    """

    name: str
    takes: tuple[str, ...]
    function: Callable[..., float] | None = None
    greatest: bool = False

    @property
    def extreme(self) -> str:
        """What it is to be, in a word."""
        return "greatest" if self.greatest else "least"

    def of(self, values: Mapping[str, float]) -> float:
        """Its value, of results and free numbers; NaN if one of those that it takes is not known.

        Raises
        ------
        ValueError
            If the function of the user fails.

        Examples
        --------
        >>> Cost("twice", ("k",), lambda k: 2.0 * k).of({"k": 3.0, "x_mean": 0.0})
        6.0
        """
        taken = [values.get(name, math.nan) for name in self.takes]
        if self.function is None or any(map(math.isnan, taken)):
            return taken[0] if self.function is None else math.nan
        try:
            return float(self.function(*taken))
        except Exception as fault:
            told = dict(zip(self.takes, taken, strict=True))
            raise ValueError(f"{self.word} failed: {fault!r}; its arguments are {told}.") from fault

    @property
    def word(self) -> str:
        """The argument of a design that it is."""
        return "maximize" if self.greatest else "minimize"

    def signed(self, value: float) -> float:
        """The value with the sign by which the least is the best; and back.

        Examples
        --------
        >>> Cost("power", ("power",), greatest=True).signed(2.0)
        -2.0
        """
        return -value if self.greatest else value


@dataclass(frozen=True)
class Limit:
    """One side of a quantity's range.

    Attributes
    ----------
    name : str
        Of the quantity.
    bound : float
    upper : bool
        Whether the quantity must stay below it, and not above.
    """

    name: str
    bound: float
    upper: bool

    def excess(self, value: float) -> float:
        """How far a value is beyond the limit, relative to it; negative inside.

        The logarithm of the ratio where both are positive.

        Examples
        --------
        >>> Limit("impact_rate", 0.2, True).excess(0.2), Limit("impact_rate", 0.2, False).excess(0.4) < 0.0
        (0.0, True)
        """
        sign = 1.0 if self.upper else -1.0
        if self.bound > 0.0 and value >= 0.0:
            return sign * math.log(max(value / self.bound, 1e-12))
        return sign * (value - self.bound) / (abs(self.bound) or 1.0)

    def tightened(self, distance: float) -> Limit:
        """The limit moved inwards.

        Examples
        --------
        >>> str(Limit("impact_rate", 0.2, True).tightened(0.01))
        'impact_rate < 0.19'
        """
        return Limit(self.name, self.bound - distance if self.upper else self.bound + distance, self.upper)

    def __str__(self) -> str:
        return f"{self.name} {'<' if self.upper else '>'} {self.bound:g}"


@dataclass(frozen=True, eq=False)
class Space:
    """Free numbers as coordinates between 0 and 1: logarithms where both bounds have the same sign."""

    free: Mapping[str, Free]

    def values(self, u: Floats) -> dict[str, float]:
        """The numbers at a place.

        Examples
        --------
        >>> Space({"k": Free(80.0, "k", 10.0, 1000.0)}).values(np.array([0.5]))["k"]
        100.0
        """
        found = {}
        for (name, number), place in zip(self.free.items(), u, strict=True):
            if number.low * number.high > 0.0:
                value = number.low * (number.high / number.low) ** float(place)
            else:
                value = number.low + (number.high - number.low) * float(place)
            found[name] = min(max(value, number.low), number.high)
        return found

    def place(self, values: Mapping[str, float]) -> Floats:
        """Where the numbers are: the inverse of `values`.

        Examples
        --------
        >>> Space({"k": Free(80.0, "k", 10.0, 1000.0)}).place({"k": 100.0}).tolist()
        [0.5]
        """
        return np.array([
            math.log(values[name] / number.low) / math.log(number.high / number.low) if number.low * number.high > 0.0
            else (values[name] - number.low) / (number.high - number.low)
            for name, number in self.free.items()
        ])  # fmt: skip

    @property
    def start(self) -> Floats:
        """Where the numbers start."""
        return self.place({name: float(number) for name, number in self.free.items()})


def checked_limits(subject_to: object, free: Mapping[str, Free]) -> tuple[Limit, ...]:
    """Limits from ``{"impact_rate": (None, 0.2)}``; none from None.

    Raises
    ------
    TypeError, ValueError
        If they are no such dict, or a low limit is not below the high one.

    Examples
    --------
    >>> [str(limit) for limit in checked_limits({"impact_rate": (None, 0.2), "x_mean": (0.1, None)}, {})]
    ['impact_rate < 0.2', 'x_mean > 0.1']
    """
    if subject_to is None:
        return ()
    if not isinstance(subject_to, Mapping):
        raise TypeError(f"subject_to must be a dict such as {{'impact_rate': (None, 0.2)}}, not {shown(subject_to)}.")
    limits = []
    for name, pair in subject_to.items():
        if not isinstance(name, str) or not isinstance(pair, tuple | list) or len(pair) != 2:
            raise TypeError(
                f"subject_to must have a pair (low, high) for each name, as 'impact_rate': (None, 0.2), not "
                f"{shown(name)}: {shown(pair)}."
            )
        if name in free:
            raise ValueError(f"subject_to must not limit {name}: the bounds of a free number are its limits.")
        low, high = (
            None if end is None else finite_number(end, f"subject_to of {name}", low=-LARGEST, high=LARGEST)
            for end in pair
        )
        if low is not None and high is not None and not low < high:
            raise ValueError(f"subject_to of {name} must have a low limit below the high one, not ({low:g}, {high:g}).")
        if low is None and high is None:
            raise ValueError(f"subject_to of {name} must have a low or a high limit.")
        limits += [Limit(name, end, upper) for end, upper in ((low, False), (high, True)) if end is not None]
    return tuple(limits)


def quantile_in(name: str) -> tuple[str, float | None]:
    """The result in the name of a quantity, and the share of the devices that are below it; None of the mean.

    Examples
    --------
    >>> quantile_in("impact_rate_quantile_0.95"), quantile_in("impact_rate")
    (('impact_rate', 0.95), ('impact_rate', None))
    """
    found = _QUANTILE.fullmatch(name)
    return (found[1], float(found[2])) if found else (name, None)


def check_names(limits: Sequence[Limit], known: Sequence[str]) -> None:
    """Limits must be of known results.

    Raises
    ------
    ValueError
        If one is not.
    """
    for limit in limits:
        if limit.name not in known:
            result, share = quantile_in(limit.name)
            if share is not None and result in known:
                raise ValueError(
                    f"subject_to cannot limit {limit.name}: quantiles are over devices with uncertain numbers, at "
                    "shares from 0.005 to 0.995."
                )
            near = meant(limit.name, known) or "."
            raise ValueError(f"subject_to must limit results among {few(known)}, not {limit.name}{near}")


def checked_cost(minimize: object, maximize: object, free: Mapping[str, Free], known: Sequence[str]) -> Cost:
    """What is minimized or maximized: one of the two, a known name or a function whose arguments are known names.

    Raises
    ------
    TypeError, ValueError
        If it is neither, or both are given.

    Examples
    --------
    >>> checked_cost(None, "x_mean", {}, ["x_mean"])
    Cost(name='x_mean', takes=('x_mean',), function=None, greatest=True)
    """
    if (minimize is None) == (maximize is None):
        raise TypeError(f"minimize or maximize must be given{'' if minimize is None else ', not both'}.")
    greatest = minimize is None
    wanted, word = (maximize, "maximize") if greatest else (minimize, "minimize")
    names = [*free, *known]
    if isinstance(wanted, str):
        return Cost(name := known_word(wanted, names, word, "must be among"), (name,), greatest=greatest)
    if not callable(wanted):
        raise TypeError(
            f"{word} must be the name of a quantity or of a free number, or a function of some, not {shown(wanted)}."
        )
    try:
        takes = named_arguments(word, wanted, names, "neither a result nor a free number")
    except TypeError:
        raise TypeError(f"{word} must be a function with named arguments, not {shown(wanted)}.") from None
    name = getattr(wanted, "__name__", "<lambda>")
    return Cost(("gain" if greatest else "cost") if name == "<lambda>" else name, tuple(takes), wanted, greatest)
