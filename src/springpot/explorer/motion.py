"""One path of the ensemble, recorded completely, and a player for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.oscillator import Oscillator
from springpot.simulation.lanes import LANES
from springpot.simulation.settings import Settings
from springpot.simulation.simulation import Simulation

__all__ = ["Motion", "Player", "blocks", "record"]

MOST_STEPS = 400_000  # of a path that is shown: 6 MB
POINTS_PER_RADIAN = 40  # that are drawn
MOST_POINTS = 1200  # of one frame
NUDGE = 0.1  # in 1 / Omega, by which a single step moves time

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motion:
    """A path and its impacts.

    Attributes
    ----------
    path : int
        Its number in the ensemble.
    step : float
        In s.
    x, v : ndarray, shape (steps + 1,)
        In m and m/s.
    impacts : ndarray of int
        Steps with an impact.
    """

    path: int
    step: float
    x: Floats
    v: Floats
    impacts: npt.NDArray[np.intp]

    @property
    def steps(self) -> int:
        """Number of steps."""
        return self.x.size - 1


def blocks(settings: Settings) -> int:
    """Number of paths of the ensemble that can be shown: the first of each block.

    Examples
    --------
    >>> from springpot.simulation.settings import resolve
    >>> blocks(resolve(Oscillator(), paths=100))
    2
    """
    return -(-settings.paths // LANES)


def record(simulation: Simulation, number: int) -> Motion:
    """Simulate the first path of a block of the ensemble again, and record it.

    Parameters
    ----------
    simulation : Simulation
        Of the ensemble.
    number : int
        Of the block; its first path is the number times LANES.
    """
    step = simulation.settings.step
    length = min(simulation.settings.steps, MOST_STEPS) * step
    single = simulation.but(paths=1, record=1, threads=1, duration=length, window=(0.0, length))
    x, v = single.advance(skipped=number * LANES).record[0].T.copy()
    return Motion(number * LANES, step, x, v, impacts(simulation.oscillator, step, x, v))


def impacts(oscillator: Oscillator, step: float, x: Floats, v: Floats) -> npt.NDArray[np.intp]:
    """Steps in which a recorded path turned round near the wall: for marks in the picture only."""
    if oscillator.barrier is None:
        return np.zeros(0, np.intp)
    sign = oscillator.direction
    gap, speed = sign * (x - oscillator.barrier.position), sign * v
    fastest = np.maximum(np.abs(speed[:-1]), np.abs(speed[1:]))
    near = np.minimum(gap[:-1], gap[1:]) <= step * fastest
    return np.flatnonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0) & near)


class Player:
    """Plays a motion: keeps the current time, and the part that has not been shown yet.

    Examples
    --------
    >>> path = Motion(0, 0.01, np.zeros(1001), np.zeros(1001), np.array([3]))
    >>> player = Player(path, natural_frequency=1.0)
    >>> player.forward(2.0)
    >>> [round(float(part[0]), 3) for part in player.due()[:1]], player.ended
    ([0.0], False)
    """

    def __init__(self, motion: Motion, *, natural_frequency: float) -> None:
        self.motion = motion
        self._frequency = natural_frequency
        self._stride = max(1, int(1.0 / (POINTS_PER_RADIAN * natural_frequency * motion.step)))
        self._shown = 0  # first sample that has not been shown
        self._now = 0.0  # in steps
        self._marked = 0  # impacts that have been shown

    @property
    def ended(self) -> bool:
        """Whether all of the path has been shown."""
        return self._shown >= self.motion.steps

    def forward(self, radians: float) -> None:
        """Advance the time, in units of 1 / Omega."""
        self._now = min(self._now + radians / (self._frequency * self.motion.step), float(self.motion.steps))

    def due(self) -> list[npt.ArrayLike]:
        """The part to be shown next: (begin, spacing, path, end of the path), x, v, times and speeds of impacts.

        Empty if there is no new sample.
        """
        motion, stride = self.motion, self._stride
        end = int(self._now) // stride * stride + 1
        if end <= self._shown:
            return []
        # after a long wait, or at high speed, only the newest points are drawn
        begin = max(self._shown, end - 1 - (MOST_POINTS - 1) * stride)
        taken = slice(begin, end, stride)
        marked = int(np.searchsorted(motion.impacts, end - 1))
        struck = motion.impacts[self._marked : marked][-MOST_POINTS:]
        self._marked = marked
        self._shown = begin + ((end - 1 - begin) // stride + 1) * stride
        return [
            [begin * motion.step, stride * motion.step, motion.path, motion.steps * motion.step],
            motion.x[taken],
            motion.v[taken],
            (struck + 0.5) * motion.step,
            np.abs(motion.v[struck]),
        ]
