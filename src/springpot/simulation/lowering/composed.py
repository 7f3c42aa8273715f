"""What the arguments of both kernels have, that of one mass and that of several."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.memory import ExponentialSum
from springpot.simulation.kernel.branches import MARKS, Kept
from springpot.simulation.kernel.lanes import GROUP, LANES
from springpot.simulation.kernel.questions import Start
from springpot.simulation.kernel.watching import Observer
from springpot.simulation.lowering.felt import FeltInKernel
from springpot.simulation.lowering.kernel_units import Units
from springpot.simulation.lowering.memory import Tap
from springpot.simulation.lowering.parts import Named
from springpot.simulation.lowering.readings import Reading


@dataclass(frozen=True, eq=False, kw_only=True)
class Composed:
    """The arguments of a kernel for one system and one step, and how its sums are read.

    Attributes
    ----------
    start : Start
        x and v at time 0, in the kernel's units.
    half_drift : tuple of float
        Shares of a place, and of a velocity over ``frequency``, in the place half a drift away; and the latter again
        where a drift may turn in between.
    units : Units
    history : ExponentialSum
        The memory without units.
    expected_power : float
        Mean input power of the noise whose increments are independent; per unit mass in a kernel of one mass.
    expected_in : callable, optional
        The same between each two of some steps, where it changes in time.
    named : tuple of Named
        The forces with names, in the order of their works.
    taps : tuple of Tap
        Circuits whose voltage is observed.
    law : BoltzmannLaw, BoltzmannOfSeveral or None
        From which x and v at time 0 are drawn; otherwise they are those of ``start``.
    mass : float
        By which energies of the columns are multiplied.
    frequency : float
        Of the spring that is followed exactly, in the kernel's units; NaN without one.
    wall : NoWall, Rigid, Pair, Soft or None
        Walls whose impacts are summed together; None where each has its own sums.
    walls : tuple of str
        Walls and contacts by the numbers with which observers see their impacts; empty where there is none.
    contacts : tuple of str
        The soft ones, in the order of the kernel.
    struck : dict
        The column with the impacts of each of them, by its name.
    damped : dict
        The columns of the power of dampers and memory, with their factors; without ``taken_at_once``.
    readings : tuple of Reading
        The results that are read by the names of the columns.
    felt : FeltInKernel
    """

    start: Start
    half_drift: tuple[float, float, float]
    units: Units
    history: ExponentialSum
    expected_power: float
    expected_in: Callable[[Sequence[int]], Floats] | None = None
    named: tuple[Named, ...] = ()
    taps: tuple[Tap, ...] = ()
    law: Any = None
    mass: float = 1.0
    frequency: float = math.nan
    wall: Any = None
    walls: tuple[str, ...] = ()
    contacts: tuple[str, ...] = ()
    struck: Mapping[str, str] = field(default_factory=dict)
    damped: Mapping[str, float] = field(default_factory=lambda: {"power": 1.0})
    readings: tuple[Reading, ...] = ()
    felt: FeltInKernel = field(default_factory=FeltInKernel)

    @property
    def halves(self) -> dict[str, tuple[str, str]]:
        """By the mean squares of each mass, the columns of the sum over the window and of that over its first half."""
        raise NotImplementedError

    @property
    def numbers_kept(self) -> tuple[int, int, int, npt.DTypeLike, int, npt.DTypeLike]:
        """Of coordinates, of rows and of memory modes, with their precision, and of states of sources, with theirs."""
        raise NotImplementedError

    def frequency_and_wall(self, observer: Observer) -> tuple[float, float]:
        """Two numbers of the header of an observer of a displacement."""
        raise NotImplementedError

    def header_of(self, observer: Observer) -> list[float]:
        """Of an observer's array."""
        (length, speed), (frequency, wall) = self.units.state, self.frequency_and_wall(observer)
        if observer.feels:
            frequency, wall = self.felt.scale, self.felt.exceeding(observer.feels[0])
        speed = self.felt.force if observer.peaks else speed * (observer.impulse or 1.0)
        return [length, speed, self.units.time, frequency, wall, LANES]

    def room_for_states(self, many: int) -> Kept:
        """A pool of states, each in the precision in which the kernel has it; only what is used of it takes memory."""
        points, rows, modes, of_memory, states, of_sources = self.numbers_kept
        return Kept(
            state=np.empty((many, 2 * points + MARKS)),
            memory=np.empty((many, (2 + GROUP) * rows + modes), of_memory),
            sources=np.empty((many, states), of_sources),
            step=np.empty(many, np.int64),
            next=np.empty(many, np.int64),
        )

    def expected_in_bins(self, edges: npt.NDArray[np.int64]) -> Floats:
        """The expected power between each two of some steps."""
        if self.expected_in is None:
            return np.full(edges.size - 1, self.expected_power)
        return self.expected_in(edges.tolist())
