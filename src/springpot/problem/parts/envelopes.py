"""Envelopes: functions of time by which stationary noise is multiplied."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from springpot.problem.parts.checks import put, tabulated
from springpot.problem.parts.registration import Form, Number

if TYPE_CHECKING:
    import numpy.typing as npt

    from springpot.machine.arrays import Floats

__all__ = ["Envelope", "ExponentialEnvelope", "JenningsHousnerEnvelope", "TabulatedEnvelope"]

_OVER = 0.01  # of the largest value: an envelope that never ends is over there


class Envelope(Form):
    """A function e(t) >= 0 of the time of a run, with a ``form`` in files; its `words` have the time t."""

    key, called, needed, known = "form", "envelope", ("at", "words", "duration", "largest"), {}

    @property
    def largest(self) -> float:
        """Its largest value."""
        raise NotImplementedError

    def at(self, time: npt.ArrayLike) -> Floats:
        """e at times in s."""
        raise NotImplementedError

    @property
    def duration(self) -> float:
        """Where it ends, in s; one that does not, where it has fallen to a hundredth of its largest value."""
        raise NotImplementedError

    @property
    def corners(self) -> tuple[float, ...]:
        """Times in s at which its slope jumps."""
        return ()


@dataclass(frozen=True)
class JenningsHousnerEnvelope(Envelope):
    """An earthquake in three parts: (t / rise)^2 up to ``rise``, 1 up to ``fall``, then exp(-decay (t - fall)).

    Parameters
    ----------
    rise : float
        Time in s at which it reaches 1.
    fall : float
        Time in s at which it begins to fall, at or after ``rise``.
    decay : float
        Rate in 1/s at which it falls.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    References
    ----------
    P. C. Jennings, G. W. Housner and N. C. Tsai, *Simulated earthquake motions* (Caltech, 1968).

    Examples
    --------
    >>> JenningsHousnerEnvelope(rise=4.0, fall=15.0, decay=0.1).at([2.0, 10.0, 25.0]).round(4).tolist()
    [0.25, 1.0, 0.3679]
    """

    rise: Annotated[float, Number("t", "rises until", "s", "positive", "It is the time at which it reaches 1.")]
    fall: Annotated[float, Number("t", "falls from", "s", "positive", "It is the time at which it begins to fall.")]
    decay: Annotated[float, Number("c", "decay", "s-1", "positive", "It is the rate at which it falls, in 1/s.")]

    largest = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.fall < self.rise:
            raise ValueError(f"fall must not be before rise, {self.rise:g} s, but it is {self.fall:g} s.")

    def at(self, time: npt.ArrayLike) -> Floats:
        """e at times in s."""
        import numpy as np  # slow to import

        t = np.asarray(time, float)
        return np.minimum(np.clip(t / self.rise, 0.0, 1.0) ** 2, np.exp(-self.decay * np.maximum(t - self.fall, 0.0)))

    @property
    def corners(self) -> tuple[float, ...]:
        """The ends of its three parts."""
        return self.rise, self.fall

    @property
    def duration(self) -> float:
        """Where it has fallen to a hundredth, in s."""
        return self.fall - math.log(_OVER) / self.decay

    def words(self) -> str:
        """The formula with its numbers."""
        return (
            f"(t / {self.rise:.6g} s)^2, 1 from {self.rise:.6g} s, exp(-{self.decay:.6g} (t - {self.fall:.6g} s)) "
            f"from {self.fall:.6g} s"
        )


@dataclass(frozen=True)
class ExponentialEnvelope(Envelope):
    """A pair of exponentials, exp(-slow t) - exp(-fast t), times a number that makes its largest value ``peak``.

    Parameters
    ----------
    slow, fast : float
        Rates in 1/s, ``fast`` the larger one.
    peak : float
        The largest value, at the time ln(fast / slow) / (fast - slow).

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    Examples
    --------
    >>> envelope = ExponentialEnvelope(slow=0.2, fast=0.6)
    >>> round(envelope.peak_time, 6), round(float(envelope.at(envelope.peak_time)), 6)
    (2.746531, 1.0)
    """

    slow: Annotated[float, Number("b", "slow rate", "s-1", "positive", "It is the rate of the later decay, in 1/s.")]
    fast: Annotated[float, Number("b", "fast rate", "s-1", "positive", "It is the rate of the rise, in 1/s.")]
    peak: Annotated[float, Number("e", "peak", "1", "positive", "It is the largest value.")] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.fast > self.slow:
            raise ValueError(f"fast must be above slow, {self.slow:g} per s, but it is {self.fast:g} per s.")

    @property
    def largest(self) -> float:
        """The largest value."""
        return self.peak

    @property
    def peak_time(self) -> float:
        """When it is largest, in s."""
        return math.log(self.fast / self.slow) / (self.fast - self.slow)

    @property
    def _factor(self) -> float:
        top = self.peak_time
        return self.peak / (math.exp(-self.slow * top) - math.exp(-self.fast * top))

    def at(self, time: npt.ArrayLike) -> Floats:
        """e at times in s."""
        import numpy as np  # slow to import

        t = np.maximum(np.asarray(time, float), 0.0)
        return np.asarray(self._factor * (np.exp(-self.slow * t) - np.exp(-self.fast * t)))

    @property
    def duration(self) -> float:
        """Where it has fallen to a hundredth of its peak, in s: of the slow exponential alone."""
        return math.log(self._factor / (_OVER * self.peak)) / self.slow

    def words(self) -> str:
        """The formula with its numbers."""
        return f"{self._factor:.6g} (exp(-{self.slow:.6g} t) - exp(-{self.fast:.6g} t))"


@dataclass(frozen=True)
class TabulatedEnvelope(Envelope):
    """Straight lines between points; 0 before the first one and after the last.

    Parameters
    ----------
    time : tuple of float
        Increasing, in s, from 0 or later; at least two.
    values : tuple of float
        One for each time, none below 0, one of them above.

    Raises
    ------
    TypeError, ValueError
        If the times do not increase, the two have different lengths, or a number is below 0.

    Examples
    --------
    >>> TabulatedEnvelope((0.0, 2.0, 6.0), (0.0, 1.0, 0.0)).at([1.0, 4.0, 8.0]).tolist()
    [0.5, 0.5, 0.0]
    """

    time: Annotated[tuple[float, ...], Number("t", "time", "s", own=True)]
    values: Annotated[tuple[float, ...], Number("e", "values", "1", own=True)]

    def __post_init__(self) -> None:
        put(self, **tabulated(self.time, self.values))
        if self.time[0] < 0.0 or any(b <= a for a, b in zip(self.time, self.time[1:], strict=False)):
            raise ValueError("time must begin at 0 or later and increase from each point to the next.")
        if min(self.values) < 0.0 or not any(self.values):
            raise ValueError("values must not be below 0, and one of them must be above.")
        super().__post_init__()

    @property
    def largest(self) -> float:
        """The largest value."""
        return max(self.values)

    def at(self, time: npt.ArrayLike) -> Floats:
        """e at times in s."""
        import numpy as np  # slow to import

        return np.asarray(np.interp(np.asarray(time, float), self.time, self.values, left=0.0, right=0.0))

    @property
    def corners(self) -> tuple[float, ...]:
        """Its times."""
        return self.time

    @property
    def duration(self) -> float:
        """The last time, in s."""
        return self.time[-1]

    def words(self) -> str:
        """How many points it has."""
        return f"straight lines through {len(self.time)} points, up to {self.largest:.6g}, until {self.time[-1]:.6g} s"
