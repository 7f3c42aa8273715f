"""The law of the impulses of Gaussian noise whose driving white noise is multiplied by an envelope e(t).

As in `springpot.simulation.lowering.filters` the impulses of a filtered noise, the integrals over the steps, have an
innovations form with one normal for each step.  Here the driving noise of step n has the factor e in the middle of the
step, so gain and variance change from step to step, by the Riccati recursion of the Kalman filter: the law is exact for
an envelope that is constant in each step, and the error of that is of second order.  The noise starts in the stationary
state of the envelope's value at time 0, which is silence if that is 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.problem.parts.envelopes import Envelope
from springpot.simulation.kernel import sources
from springpot.simulation.lowering.kernel_units import Units

__all__ = ["Modulation", "law_of", "mean_square"]

Floats = npt.NDArray[np.float64]

_SILENT = 1e-24  # of the largest variance of an impulse


@dataclass(frozen=True, eq=False)
class Modulation:
    """A noise that is made from a table over the steps.

    Attributes
    ----------
    name : str
    envelope : Envelope or None
        None for stationary noise of a filter that the kernel does not have otherwise.
    intensity : float
        Of white noise without its envelope, in the kernel's units; 0 of filtered noise.
    filter : Filter or None
        Of filtered noise, with time in steps.
    """

    name: str
    envelope: Envelope | None
    intensity: float = 0.0
    filter: sources.Filter | None = None

    def values(self, units: Units, step: float, steps: int) -> Floats:
        """e at time 0, then in the middle of each step."""
        if self.envelope is None:
            return np.ones(steps + 1)
        middles = step * units.time * (np.arange(steps) + 0.5)
        return np.concatenate([self.envelope.at([0.0]), self.envelope.at(middles)])


def mean_square(noise: Modulation, units: Units, step: float, window: tuple[int, int]) -> float:
    """The intensity of white noise with its envelope, its mean over a window of steps; 0 of filtered noise."""
    low, high = window
    return noise.intensity * float((noise.values(units, step, high)[low + 1 :] ** 2).mean())


def law_of(noise: Modulation, units: Units, step: float, steps: int, word: int, place: int) -> Any:
    """The kernel's source."""
    values = noise.values(units, step, steps)
    if noise.filter is None:
        return sources.ModulatedWhite(word, np.sqrt(noise.intensity * step) * values[1:])
    from springpot.simulation.lowering.filters import over_a_step  # SciPy's linear algebra is slow to import

    moved, noisy, stationary = over_a_step(noise.filter)
    move, seen = moved[:-1, :-1], step * moved[-1, :-1]
    spread, cross, unseen = noisy[:-1, :-1], step * noisy[:-1, -1], step**2 * float(noisy[-1, -1])
    squares = values**2
    known = squares[0] * stationary  # covariance of the state given all earlier impulses
    least = _SILENT * float(squares.max()) * (float(seen @ stationary @ seen) + unseen)
    roots, gains = np.zeros(steps), np.zeros((steps, len(seen)))
    for n, square in enumerate(squares[1:]):
        toward = known @ seen
        variance = float(seen @ toward) + square * unseen
        known = move @ known @ move.T + square * spread
        if variance > least:
            roots[n] = variance**0.5
            gains[n] = (move @ toward + square * cross) / roots[n]
            known = known - np.outer(gains[n], gains[n])
    return sources.Modulated(word, place, move - np.eye(len(seen)), seen, roots, gains)
