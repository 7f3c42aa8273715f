"""The law of the impulses of Gaussian noise whose driving white noise is multiplied by an envelope e(t).

As in `springpot.simulation.lowering.filters` the impulses of a filtered noise, the integrals over the steps, have an
innovations form with one normal for each step.  Here the driving noise of step n has the factor e in the middle of the
step, so gain and variance change from step to step, by the Riccati recursion of the Kalman filter: the law is exact for
an envelope that is constant in each step, and the error of that is of second order.  The noise starts in the stationary
state of the envelope's value at time 0, which is silence if that is 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts.envelopes import Envelope
from springpot.simulation.lowering import sources
from springpot.simulation.plan.scales import Units

_SILENT = 1e-24  # of the largest variance of an impulse
MOST_TABULATED = 100_000_000  # numbers of tables over the steps, 0.8 GB
_BESIDE = 3  # numbers of each step while a table is made


@dataclass(frozen=True, eq=False)
class Modulation:
    """A noise that is made from a table over the steps.

    Attributes
    ----------
    name : str
    envelope : Envelope or None
        None for stationary noise of a filter that the kernel does not have otherwise.
    intensity : float
        Of white noise without its envelope, in the kernel's units; 0 of other noise.
    multiplies : bool
        Whether it is white noise that multiplies the displacement.
    filter : Filter, callable or None
        Of filtered noise, with time in steps; of one that changes, at a time in s.
    make : callable or None
        (parts of a step) -> the source of a noise that is itself multiplied.
    states : int
        Numbers that the source keeps for each path.
    """

    name: str
    envelope: Envelope | None
    intensity: float = 0.0
    multiplies: bool = False
    filter: sources.Filter | Callable[[float], sources.Filter] | None = None
    make: Callable[[int], Any] | None = None
    states: int = 0

    @property
    def kept(self) -> int:
        """Numbers of each step in its table, and beside it while it is made."""
        changing = self.states * (self.states + 3) // 2 if callable(self.filter) else 0
        return _BESIDE + self.states + changing

    def values(self, units: Units, step: float, steps: int) -> Floats:
        """e at time 0, then in the middle of each step."""
        check_table(self.name, self.kept, steps)
        if self.envelope is None:
            return np.ones(steps + 1)
        middles = step * units.time * (np.arange(steps) + 0.5)
        return np.concatenate([self.envelope.at([0.0]), self.envelope.at(middles)])

    def squares(self, units: Units, step: float, steps: int) -> Floats:
        """e^2 in the middle of each step."""
        return self.values(units, step, steps)[1:] ** 2


def check_table(name: str, kept: int, steps: int) -> None:
    """That a table of so many numbers for each step of a run fits into memory, before it is made.

    Raises
    ------
    ValueError
        If it does not.

    Examples
    --------
    >>> check_table("ground", 4, 1_000_000)
    """
    if kept * steps > MOST_TABULATED:
        raise ValueError(
            f"duration takes {steps:,} steps, and {name} needs a table of {kept} numbers for each of them: at most "
            f"{MOST_TABULATED // kept:,} steps are possible. Use a longer step, or a shorter duration."
        )


def law_of(noise: Modulation, units: Units, step: float, steps: int, parts: int = 1) -> Any:
    """The kernel's source."""
    values = noise.values(units, step, steps)
    if noise.make is not None:
        return noise.make(parts)._replace(envelope=values[1:])
    if noise.filter is None:
        return sources.ModulatedWhite(np.sqrt(noise.intensity * step) * values[1:])
    from springpot.simulation.lowering.filters import over_a_step  # SciPy's linear algebra is slow to import

    filters = [noise.filter] if isinstance(noise.filter, sources.Filter) else [
        noise.filter(time) for time in (0.0, *(step * units.time * (np.arange(steps) + 0.5)).tolist())
    ]  # fmt: skip
    laws = [_Impulses(step, *over_a_step(each)) for each in filters]
    squares = values**2
    known = squares[0] * laws[0].stationary  # covariance of the state given all earlier impulses
    least = _SILENT * float(squares.max()) * laws[0].variance
    size = len(laws[0].seen)
    roots, gains = np.zeros(steps), np.zeros((steps, size))
    laws = laws[1:] or laws
    for n, square in enumerate(squares[1:]):
        move, seen, spread, cross, unseen = laws[min(n, len(laws) - 1)].numbers
        toward = known @ seen
        variance = float(seen @ toward) + square * unseen
        known = move @ known @ move.T + square * spread
        if variance > least:
            roots[n] = variance**0.5
            gains[n] = (move @ toward + square * cross) / roots[n]
            known = known - np.outer(gains[n], gains[n])
    changes = np.array([each.numbers[0] - np.eye(size) for each in laws])
    return sources.Modulated(changes, np.array([each.seen for each in laws]), roots, gains)


class _Impulses:
    """What a filter makes of white noise in a step: the state after it and the impulse, and their covariances."""

    def __init__(self, step: float, moved: Floats, noisy: Floats, stationary: Floats) -> None:
        self.seen, self.stationary = step * moved[-1, :-1], stationary
        unseen = step**2 * float(noisy[-1, -1])
        self.numbers = moved[:-1, :-1], self.seen, noisy[:-1, :-1], step * noisy[:-1, -1], unseen
        self.variance = float(self.seen @ stationary @ self.seen) + unseen
