"""Numbers that differ from device to device: `springpot.uncertain`, and the laws that such a number can have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from springpot.machine.arguments import Free, Uncertain, checked_name, finite_number
from springpot.machine.faults import shown
from springpot.problem.parts.checks import ends_of, numbers_in, real

LEAST_CHANCE = 2.0**-31  # of a draw: half of the distance of neighbouring points of Sobol's sequence
_MOST_CUT = 0.05  # share of a law beyond its bounds that is refused
_FEWEST_VALUES = 3


class Law(Protocol):
    """A law of a number: its quantiles, and the share below a value."""

    def ppf(self, u: Any) -> Any:
        """The values below which the number lies with these probabilities."""

    def cdf(self, x: Any) -> Any:
        """The probability of a lower value."""


@dataclass(frozen=True)
class Normal:
    """Normal, by mean, which may be a free number, and standard deviation."""

    mean: float
    deviation: float
    is_gaussian = True

    def ppf(self, u: Any) -> Any:
        """Quantiles."""
        from scipy.special import ndtri

        return float(self.mean) + self.deviation * ndtri(u)

    def cdf(self, x: Any) -> Any:
        """Share below a value."""
        from scipy.special import ndtr

        return ndtr((np.asarray(x) - self.mean) / self.deviation)

    @property
    def table(self) -> dict[str, Any]:
        """As a file has it."""
        return {"value": self.mean, "sd": self.deviation}

    def __str__(self) -> str:
        return f"normal, standard deviation {self.deviation:g}"


@dataclass(frozen=True)
class Lognormal:
    """Lognormal, by mean, which may be a free number, and standard deviation over the mean."""

    mean: float
    variation: float
    is_gaussian = True

    @property
    def _logarithm(self) -> tuple[float, float]:
        square = math.log1p(self.variation**2)
        return math.log(self.mean) - 0.5 * square, math.sqrt(square)

    def ppf(self, u: Any) -> Any:
        """Quantiles."""
        from scipy.special import ndtri

        middle, spread = self._logarithm
        return np.exp(middle + spread * ndtri(u))

    def cdf(self, x: Any) -> Any:
        """Share below a value."""
        from scipy.special import ndtr

        middle, spread = self._logarithm
        with np.errstate(divide="ignore"):
            return ndtr((np.log(np.maximum(x, 0.0)) - middle) / spread)

    @property
    def table(self) -> dict[str, Any]:
        """As a file has it."""
        return {"value": self.mean, "cov": self.variation}

    def __str__(self) -> str:
        return f"lognormal, {100.0 * self.variation:g} %"


@dataclass(frozen=True)
class OfLogarithm(Lognormal):
    """Lognormal, by the median, in place of the mean, and the standard deviation of the logarithm."""

    @property
    def _logarithm(self) -> tuple[float, float]:
        return math.log(self.mean), self.variation

    @property
    def table(self) -> dict[str, Any]:
        """As a file has it."""
        return {"value": self.mean, "log_sd": self.variation}

    def __str__(self) -> str:
        return f"lognormal, standard deviation {self.variation:.3g} of the logarithm"


@dataclass(frozen=True)
class Uniform:
    """All values between two alike."""

    low: float
    high: float
    is_gaussian = False

    def ppf(self, u: Any) -> Any:
        """Quantiles."""
        return self.low + (self.high - self.low) * np.asarray(u)

    def cdf(self, x: Any) -> Any:
        """Share below a value."""
        return np.clip((np.asarray(x) - self.low) / (self.high - self.low), 0.0, 1.0)

    @property
    def table(self) -> dict[str, Any]:
        """As a file has it."""
        return {"low": self.low, "high": self.high}

    def __str__(self) -> str:
        return f"from {self.low:g} to {self.high:g}"


@dataclass(frozen=True)
class Measured:
    """Measured values: quantiles are interpolated between them in ascending order."""

    values: tuple[float, ...]
    is_gaussian = False

    def ppf(self, u: Any) -> Any:
        """Quantiles."""
        places = (np.arange(len(self.values)) + 0.5) / len(self.values)
        return np.interp(u, places, self.values)

    def cdf(self, x: Any) -> Any:
        """Share below a value."""
        places = (np.arange(len(self.values)) + 0.5) / len(self.values)
        return np.interp(x, self.values, places, left=0.0, right=1.0)

    @property
    def table(self) -> dict[str, Any]:
        """As a file has it."""
        return {"values": [*self.values]}

    def __str__(self) -> str:
        return f"{len(self.values)} measured values"


@dataclass(frozen=True)
class Other:
    """A law of `scipy.stats`, or any object with ``ppf``, or ``icdf``, and ``cdf``."""

    law: Any
    is_gaussian = True

    def ppf(self, u: Any) -> Any:
        """Quantiles."""
        return _of_each(getattr(self.law, "ppf", None) or self.law.icdf, u)

    def cdf(self, x: Any) -> Any:
        """Share below a value."""
        return _of_each(self.law.cdf, x)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Other) and (self.law is other.law or self._told == other._told)

    def __hash__(self) -> int:
        return hash(self._told)

    @property
    def _told(self) -> str:
        """The distribution of scipy.stats and its numbers; else what the object says of itself."""
        own = getattr(self.law, "dist", None)
        if own is None:
            return repr(self.law)
        return f"{own.name}{self.law.args}{sorted(self.law.kwds.items())}"

    @property
    def table(self) -> dict[str, Any]:
        """As a file has it."""
        raise ValueError(f"a file holds normal, lognormal and uniform laws and measured values, not {self}.")

    def __str__(self) -> str:
        return self._told


@dataclass(frozen=True)
class Bounded:
    """A law between two bounds, with the share beyond them left out."""

    law: Any
    low: float
    high: float

    @property
    def is_gaussian(self) -> bool:
        """Whether normal scores describe it best."""
        return bool(self.law.is_gaussian)

    def ppf(self, u: Any) -> Any:
        """Quantiles."""
        below, above = self._shares
        return np.clip(self.law.ppf(below + (above - below) * np.asarray(u)), self.low, self.high)

    def cdf(self, x: Any) -> Any:
        """Share below a value."""
        below, above = self._shares
        return np.clip((self.law.cdf(x) - below) / (above - below), 0.0, 1.0)

    @cached_property
    def _shares(self) -> tuple[float, float]:
        return float(self.law.cdf(self.low)), float(self.law.cdf(self.high))

    @property
    def cut(self) -> float:
        """The share that is left out."""
        return 1.0 - (self._shares[1] - self._shares[0])

    @property
    def table(self) -> dict[str, Any]:
        """As a file has it."""
        return {**self.law.table, "low": self.low, "high": self.high}

    def __str__(self) -> str:
        return f"{self.law}, between {self.low:g} and {self.high:g}"


def _of_each(function: Any, numbers: Any) -> Any:
    """A function of numbers, also one that takes one number only."""
    try:
        return function(numbers)
    except (TypeError, ValueError):
        if np.ndim(numbers) == 0:
            raise
        return np.array([float(function(each)) for each in np.ravel(numbers).tolist()]).reshape(np.shape(numbers))


def uncertain(
    name: str, value: float | None = None, *, cov: float | None = None, sd: float | None = None,
    log_sd: float | None = None, bounds: tuple[float, float] | None = None, law: Any = None, values: Any = None,
    correlation: Mapping[str, float] | None = None,
) -> Uncertain:  # fmt: skip
    """Mark a number of a part as one that differs from device to device, for `springpot.scatter`.

    Parameters
    ----------
    name : str
        A word of letters, digits and ``_``.  Numbers of the same name are one number; their laws must be the same.
    value : float, optional
        The mean of the law with ``cov`` or ``sd``, the median with ``log_sd``; otherwise the nominal value, if that is
        not the median.  A number that is marked by `springpot.free` is the centre of a law of ``cov``, ``sd`` or
        ``log_sd``, which moves with it: `springpot.design` finds it.
    cov : float, optional
        Standard deviation over the mean: a lognormal law, whose values are positive.
    sd : float, optional
        Standard deviation of a normal law.
    log_sd : float, optional
        Standard deviation of the logarithm: a lognormal law too.
    bounds : (float, float), optional
        Alone: all values between two alike.  With another law: its share beyond them is left out; at most 5 %.
    law : object, optional
        A frozen law of `scipy.stats`, or any object with ``ppf`` and ``cdf``.
    values : sequence of float, optional
        Measured values, three or more.
    correlation : mapping of str to float, optional
        By the names of other uncertain numbers: the correlation of both normal scores, as `springpot.scatter` takes it.

    Returns
    -------
    Uncertain
        A float, which every part takes and keeps.  Theory and pictures have its nominal value.  Plus, minus, times or
        over a plain number it stays uncertain, and so does a power of one with positive bounds.  A part refuses what is
        made of two of them: mark the result itself, with a law of its own.

    Raises
    ------
    TypeError, ValueError
        If the law is not stated once, or a number is wrong.

    Examples
    --------
    Rubber of 5 % in its stiffness and 10 % in its coefficient, a gap of 6 +- 0.6 mm, and an order within tolerances:

    >>> import springpot as sp
    >>> device = sp.System(
    ...     sp.Mass(0.8), sp.Spring(sp.uncertain("k", 3200.0, cov=0.05)), sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
    ...     sp.Springpot(sp.uncertain("order", bounds=(0.28, 0.32)), sp.uncertain("C", 150.0, cov=0.10)),
    ...     sp.Barrier(-sp.uncertain("gap", 0.006, sd=0.0006, bounds=(0.003, 0.009)), 0.7),
    ... )
    >>> device.of(sp.Spring)[0].stiffness
    uncertain('k', 3200.0, lognormal, 5 %)
    """
    checked_name(name, "name")
    where = f"in the uncertain number {name}"
    ends = None if bounds is None else ends_of(bounds, where)
    words = {"cov": cov, "sd": sd, "log_sd": log_sd, "law": law, "values": values}
    stated = [word for word, given in words.items() if given is not None]
    if len(stated) > 1 or not (stated or ends):
        raise TypeError(
            f"{name} must have one of cov, sd, log_sd, law and values, or bounds alone, not "
            f"{' and '.join(stated) or 'none of them'}, {where}."
        )
    middle = None if value is None else _value(value, name, {*stated} & {"cov", "sd", "log_sd"})
    tied = _tied(correlation, name)
    found = _law(name, middle, words, ends)
    if isinstance(middle, Free):
        if ends:
            raise ValueError(f"bounds must not be given with a free value, {where}: its law moves.")
        return Uncertain(float(middle), name, *_reach(found), law=found, correlation=tied)
    if ends and stated:
        found = Bounded(found, *ends)
        if found.cut > _MOST_CUT:
            raise ValueError(
                f"bounds must leave out at most 5 % of the law, but {ends[0]:g} to {ends[1]:g} leave out "
                f"{100.0 * found.cut:.3g} %, {where}."
            )
    low, high = _reach(found)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(f"law must give finite values that differ, not {low:g} to {high:g}, {where}.")
    nominal = float(found.ppf(0.5)) if middle is None else middle
    if not low <= nominal <= high:
        raise ValueError(f"value must be between {low:g} and {high:g}, where the law is, not {nominal:g}, {where}.")
    return Uncertain(nominal, name, low, high, law=found, correlation=tied)


def _tied(correlation: Any, name: str) -> tuple[tuple[str, float], ...]:
    if not isinstance(correlation or {}, Mapping):
        raise TypeError(
            f"correlation must be a dict of other names and numbers, such as {{'C': 0.5}}, not {shown(correlation)}."
        )
    for other, value in (correlation or {}).items():
        if other == name:
            raise ValueError(f"correlation of {name} must be with other numbers.")
        checked_name(other, "correlation must have names that")
        finite_number(value, f"correlation of {name} and {other}", low=-1.0, high=1.0)
    return tuple((other, float(value)) for other, value in (correlation or {}).items())


def centre_of(number: Free) -> Free | None:
    """The free number about which an uncertain one scatters, if there is one.

    Examples
    --------
    >>> import springpot as sp
    >>> centre_of(-sp.uncertain("gap", sp.free("g", 0.006, (0.002, 0.01)), cov=0.1))
    free('g', 0.006, (0.002, 0.01))
    """
    mean = getattr(number.law, "mean", None) if isinstance(number, Uncertain) else None
    return mean if isinstance(mean, Free) else None


def with_law(number: Uncertain, law: Any) -> Uncertain:
    """The same number about another centre."""
    low, high = sorted(number.at(end) for end in _reach(law))
    return Uncertain(
        number.at(float(law.mean)), number.name, low, high, number.times, number.plus, number.power, law,
        number.correlation,
    )  # fmt: skip


def _reach(law: Any) -> tuple[float, float]:
    """Between which all values lie, wherever a free centre is."""
    mean = getattr(law, "mean", None)
    laws = [replace(law, mean=end) for end in (mean.low, mean.high)] if isinstance(mean, Free) else [law]
    return float(laws[0].ppf(LEAST_CHANCE)), float(laws[-1].ppf(1.0 - LEAST_CHANCE))


def _value(value: Any, name: str, moves: set[str]) -> float:
    if isinstance(value, Uncertain) or (isinstance(value, Free) and not moves):
        raise TypeError(f"value must be a plain number, or a free one with cov, sd or log_sd, in {name}.")
    found = real(value, "value", f"It is that of {name}.")
    return found if isinstance(found, Free) else float(found)


def _law(name: str, middle: float | None, words: Mapping[str, Any], ends: tuple[float, float] | None) -> Any:
    for word, kind in (("cov", Lognormal), ("log_sd", OfLogarithm), ("sd", Normal)):
        if words[word] is None:
            continue
        if middle is None:
            what = "median" if word == "log_sd" else "mean"
            raise TypeError(f"value must be given with {word}: it is the {what} of {name}.")
        most = math.inf if word == "sd" else 2.0
        spread = finite_number(words[word], word, low=0.0, high=most, open_low=True, hint=f"It is that of {name}.")
        if word != "sd" and not (middle.low if isinstance(middle, Free) else middle) > 0.0:
            raise ValueError(f"value must be above 0 with {word}, whose law is lognormal, not {middle:g}, in {name}.")
        return kind(middle, float(spread))
    if words["values"] is not None:
        known = sorted(map(float, numbers_in(words["values"], "values")))
        if len(known) < _FEWEST_VALUES:
            raise ValueError(f"values must be at least {_FEWEST_VALUES} numbers, not {len(known)}, in {name}.")
        return Measured(tuple(known))
    if (law := words["law"]) is not None:
        quantiles = getattr(law, "ppf", None) or getattr(law, "icdf", None)
        if not (callable(quantiles) and callable(getattr(law, "cdf", None))):
            raise TypeError(
                f"law must have ppf and cdf, as the frozen laws of scipy.stats have, not {shown(law)}, in {name}."
            )
        if callable(getattr(law, "freeze", None)):
            raise TypeError(
                f"law must have its numbers, such as scipy.stats.norm(10.0, 2.0), not {shown(law)}, in {name}."
            )
        try:
            tried = np.asarray(Other(law).ppf(np.array([0.25, 0.75])), float)
        except Exception as fault:
            raise ValueError(f"law must give quantiles, but at 0.25 it failed: {shown(fault)}, in {name}.") from fault
        if tried.shape != (2,) or not np.isfinite(tried).all():
            raise ValueError(f"law must give finite quantiles, not {shown(tried.tolist())}, in {name}.")
        return Other(law)
    assert ends is not None
    return Uniform(*ends)
