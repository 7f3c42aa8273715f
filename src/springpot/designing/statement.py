"""What a design is asked for: the numbers to choose, the cost and the limits, all checked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.machine.arguments import LARGEST, Free, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import few, known_word, meant, shown

Cost = str | Callable[[Mapping[str, float]], float]


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
    """Limits from ``{"impact_rate": (None, 0.2)}``.

    Raises
    ------
    TypeError, ValueError
        If they are no such dict, or a low limit is not below the high one.

    Examples
    --------
    >>> [str(limit) for limit in checked_limits({"impact_rate": (None, 0.2), "x_mean": (0.1, None)}, {})]
    ['impact_rate < 0.2', 'x_mean > 0.1']
    """
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


def check_names(limits: Sequence[Limit], known: Sequence[str]) -> None:
    """Limits must be of known results.

    Raises
    ------
    ValueError
        If one is not.
    """
    for limit in limits:
        if limit.name not in known:
            near = meant(limit.name, known) or "."
            raise ValueError(f"subject_to must limit results among {few(known)}, not {limit.name}{near}")


def checked_cost(minimize: object, free: Mapping[str, Free], known: Sequence[str]) -> Cost:
    """What is minimized, if it is a function or a known name.

    Raises
    ------
    TypeError, ValueError
        If it is neither.
    """
    if callable(minimize):
        return minimize
    if not isinstance(minimize, str):
        raise TypeError(
            f"minimize must be the name of a quantity or of a free number, or a function, not {shown(minimize)}."
        )
    names = [*free, *known]
    return known_word(minimize, names, "minimize", "must be among")


def cost_of(cost: Cost, values: Mapping[str, float]) -> float:
    """The cost of quantities and free numbers together; NaN if it is not known.

    Raises
    ------
    ValueError
        If the function of the user fails.

    Examples
    --------
    >>> cost_of(lambda values: 2.0 * values["k"], {"k": 3.0})
    6.0
    """
    if isinstance(cost, str):
        return values.get(cost, math.nan)
    try:
        return float(cost(values))
    except Exception as fault:
        raise ValueError(f"minimize failed: {shown(fault)}; it has the values {few(values)}.") from fault


def name_of(cost: Cost) -> str:
    """The name of a quantity, a number or a function.

    Examples
    --------
    >>> name_of("k")
    'k'
    """
    return cost if isinstance(cost, str) else getattr(cost, "__name__", "cost")
