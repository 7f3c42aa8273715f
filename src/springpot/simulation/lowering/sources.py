"""Laws of excitation that does not depend on the motion, and how the kernel's tables have each.

`springpot.simulation.kernel.excitations` says what the kernel does with them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.simulation.kernel import excitations

Table = npt.NDArray[np.floating]
Told = tuple[tuple[int, int, int], tuple[float, float], Table]
"""Of a law in the tables: its kind and two counts, two numbers, and a long list."""

NOTHING: Floats = np.zeros(0)
_NO_WAVE = (0.0, 0.0)


@dataclass(frozen=True)
class Filter:
    """A linear filter, e = c y and y' = A y + noise, started in its stationary state; time is in steps.

    Attributes
    ----------
    matrix : ndarray, shape (1, 1) or (2 n, 2 n)
        A, in units of one over a step: blocks of two states on the diagonal.
    noise : ndarray, of that shape
        Covariance of the noise in a step, of blocks with each other too.
    output : ndarray, shape (1,) or (2 n,)
        c.
    """

    matrix: Floats
    noise: Floats
    output: Floats


class Filtered(NamedTuple):
    """Gaussian noise through linear filters, as impulses of four steps (`springpot.simulation.lowering.filters`)."""

    pairs: Table  # (pairs, 20) of two states each; what they keep of themselves is less 1
    newest: Table  # (4,) effect of a normal on the impulses of its step and the next three
    start: Table  # lower triangle: the states at time 0 from normals
    envelope: Table = NOTHING  # of each step, by which impulses are multiplied; empty: 1

    def told(self) -> Told:
        """In the tables."""
        long = np.concatenate([self.newest, self.pairs.ravel(), self.start.ravel(), self.envelope])
        return (excitations.FILTERED, len(self.pairs), len(self.start)), _NO_WAVE, long

    def drawn(self) -> tuple[float, Table]:
        """Variance of what is drawn anew for the impulse of a step, and by what its root is multiplied in each step."""
        return float(self.newest[0]) ** 2, self.envelope


class Harmonic(NamedTuple):
    """A harmonic force whose phase is random, the same for all times of a path."""

    impulse: float  # amplitude times the step, averaged over it
    turn: float  # radians per step

    def told(self) -> Told:
        """In the tables."""
        return (excitations.HARMONIC, 0, 0), (self.impulse, self.turn), NOTHING

    def drawn(self) -> tuple[float, Table]:
        """As of `Filtered`: nothing."""
        return 0.0, NOTHING


class Poisson(NamedTuple):
    """Impulses at random times, of normal sizes."""

    rate: float  # impulses expected in a part of a step
    size: float  # standard deviation of an impulse
    envelope: Table = NOTHING

    def told(self) -> Told:
        """In the tables."""
        return (excitations.POISSON, 0, 0), (self.rate, self.size), self.envelope

    def drawn(self) -> tuple[float, Table]:
        """As of `Filtered`."""
        return float(self.size**2 * self.rate), self.envelope


class ModulatedWhite(NamedTuple):
    """White noise whose strength changes with time (`springpot.simulation.lowering.modulated`)."""

    roots: Table  # (steps,) standard deviations of the impulses

    def told(self) -> Told:
        """In the tables."""
        return (excitations.MODULATED, 0, self.roots.size), _NO_WAVE, self.roots

    def drawn(self) -> tuple[float, Table]:
        """As of `Filtered`."""
        return 1.0, self.roots


class Modulated(NamedTuple):
    """Filtered noise that is driven by white noise whose strength changes with time."""

    change: Table  # (1 or steps, states, states) of the best guess of the state in a step, by itself
    seen: Table  # (1 or steps, states) its effect on the impulse
    roots: Table  # (steps,) effect of the normal on the impulse
    gains: Table  # (steps, states) and on the guess

    def told(self) -> Told:
        """In the tables."""
        long = np.concatenate([self.roots, self.gains.ravel(), self.change.ravel(), self.seen.ravel()])
        return (excitations.MODULATED, self.seen.shape[1], self.roots.size), _NO_WAVE, long

    def drawn(self) -> tuple[float, Table]:
        """As of `Filtered`."""
        return 1.0, self.roots


class Records(NamedTuple):
    """Impulses of records; each path has one of them, that of its number in turn, or one that is drawn."""

    drawn_by_chance: bool
    impulses: Table  # (records, steps); 0 after the last

    def told(self) -> Told:
        """In the tables."""
        counts = excitations.TABLE, len(self.impulses), int(self.drawn_by_chance)
        return counts, _NO_WAVE, self.impulses.ravel()

    def drawn(self) -> tuple[float, Table]:
        """As of `Filtered`: nothing."""
        return 0.0, NOTHING


@dataclass(frozen=True)
class Named:
    """A source of excitation with a name, whose work is summed.

    Attributes
    ----------
    name : str
    make : callable
        (parts of a step) -> the law.
    states : int
        Numbers that it keeps for each path.
    does : {"feeds", "nothing"}
        How its work is reported: as what is fed in, or not at all, where its mean is known.
    tabulated : callable, optional
        Of a table over the steps: as ``make``, with the number of steps last.
    """

    name: str
    make: Callable[[int], Any]
    states: int
    does: str
    tabulated: Callable[[int, int], Any] | None = None

    def over(self, steps: int) -> Named:
        """With a table no longer than a run of so many steps."""
        if (tabulated := self.tabulated) is None:
            return self
        return replace(self, make=lambda parts: tabulated(parts, steps))
