"""Estimates of the work and time of a long run, before and during it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import TypeVar

from springpot.machine.faults import Stopped

Item = TypeVar("Item")

COMPILATION = "A compilation, up to half a minute, counts too."


@dataclass(frozen=True)
class Estimate:
    """Work and time of a run, as known now; right to a factor of two or three.

    Attributes
    ----------
    path_steps : float
        Steps of all paths together, of the whole run.
    seconds : float
        From now to its end, at the current speed of the machine; NaN before the first measurement.
    reason : str
        What takes the time.
    aim : float
        Relative error that will be reached: ``rtol``, or the best that is possible; NaN of a run without it.
    unreachable : str
        Empty, or words that say that ``rtol`` cannot be reached, and what can.
    """

    path_steps: float
    seconds: float
    reason: str
    aim: float
    unreachable: str = ""

    @property
    def sentence(self) -> str:
        """For the terminal."""
        seconds = f"about {in_words(self.seconds)} more, " if math.isfinite(self.seconds) else ""
        return f"{seconds}{self.path_steps:.1e} path-steps in all; {self.reason}"


class FractionDone(float):
    """The fraction done, as a float that also carries the `Estimate`.

    Examples
    --------
    >>> done = FractionDone(0.25, Estimate(1e9, 20.0, "the damping is light", 0.01))
    >>> done + 0.5, done.estimate.seconds
    (0.75, 20.0)
    """

    estimate: Estimate | None

    def __new__(cls, fraction: float, estimate: Estimate | None = None) -> FractionDone:
        self = super().__new__(cls, fraction)
        self.estimate = estimate
        return self


def counted(items: Collection[Item], progress: Callable[[float], None] | None) -> Iterator[Item]:
    """Items one after the other; each that is done is told as the fraction of all that are.

    Examples
    --------
    >>> [item for item in counted("ab", print)]
    0.5
    1.0
    ['a', 'b']
    """
    for number, item in enumerate(items, start=1):
        yield item
        if progress is not None:
            progress(number / len(items))


def until_stopped(progress: Callable[[float], None], stop: Callable[[], bool]) -> Callable[[float], None]:
    """What passes the fraction done on, and raises `Stopped` where ``stop`` says so."""

    def check(fraction: float) -> None:
        if stop():
            raise Stopped("it was stopped.")
        progress(fraction)

    return check


def part_of(progress: Callable[[float], None] | None, begin: float, end: float) -> Callable[[float], None]:
    """What passes the fraction of a part of the work on, as that of the whole."""

    def told(fraction: float) -> None:
        if progress is not None:
            progress(FractionDone(begin + (end - begin) * fraction, getattr(fraction, "estimate", None)))

    return told


class OutOfTimeError(Exception):
    """The time allowed is over."""


class Clock:
    """Seconds since the start, path-steps per second, and the end of the time allowed."""

    def __init__(self, limit: float | None) -> None:
        self.begun = time.perf_counter()
        self.limit = math.inf if limit is None else limit
        self.rate = math.nan  # path-steps per second

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self.begun

    @property
    def left(self) -> float:
        """Seconds until the time allowed is over; infinite without a limit."""
        return self.limit - self.elapsed

    def seconds(self, path_steps: float) -> float:
        """How long so many path-steps will take."""
        return path_steps / self.rate

    def measure(self, path_steps: float, seconds: float) -> None:
        """Set the rate from the time that some work took."""
        if path_steps > 0.0 and seconds > 0.0:
            self.rate = path_steps / seconds

    def check(self) -> None:
        """Raise `OutOfTimeError` if the time allowed is over."""
        if self.left <= 0.0:
            raise OutOfTimeError


def in_words(seconds: float) -> str:
    """A length of time with two digits at most.

    Examples
    --------
    >>> [in_words(s) for s in (0.3, 42.0, 200.0, 9000.0, 1e6)]
    ['1 s', '42 s', '3.3 min', '2.5 h', '12 days']
    """
    for unit, size, most in (("s", 1.0, 120.0), ("min", 60.0, 5400.0), ("h", 3600.0, 172800.0)):
        if seconds < most:
            number = max(seconds / size, 1.0)
            return f"{float(f'{number:.2g}'):g} {unit}"
    return f"{float(f'{seconds / 86400.0:.2g}'):g} days"
