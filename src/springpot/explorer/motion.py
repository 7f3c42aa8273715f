"""One path of the ensemble, recorded completely, and a player for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.problem.coordinates import Coordinates
from springpot.problem.parts import PiezoelectricCircuit, ResonantCircuit
from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.registration import Element
from springpot.problem.parts.walls import Stop
from springpot.problem.system import System
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.lowering.memory import turned_in_step
from springpot.simulation.lowering.parts import Arm
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.plan.settings import Settings

MOST_STEPS = 400_000  # of a path that is shown: 6 MB
POINTS_PER_RADIAN = 40  # that are drawn
MOST_POINTS = 1200  # of one frame
NUDGE = 0.1  # in 1 / Omega, by which a single step moves time


@dataclass(frozen=True, eq=False)
class Motion:
    """A path and its impacts.

    Attributes
    ----------
    path : int
        Its number in the ensemble.
    step : float
        In s.
    x, v : ndarray, shape (points, steps + 1)
        Of each mass, in m and m/s.
    impacts : ndarray of int
        Steps with an impact.
    struck : ndarray of int
        Which wall or contact, in the order of the parts.
    rows : ndarray, shape (walls, points)
        What each of them sees of the displacements.
    voltages : ndarray, shape (circuits, steps + 1)
        Of each circuit, in V.
    """

    path: int
    step: float
    x: Floats
    v: Floats
    impacts: npt.NDArray[np.intp]
    struck: npt.NDArray[np.intp]
    rows: Floats
    voltages: Floats

    @property
    def steps(self) -> int:
        """Number of steps."""
        return int(self.x.shape[1]) - 1


def blocks(settings: Settings) -> int:
    """Number of paths of the ensemble that can be shown: the first of each block.

    Examples
    --------
    >>> from springpot.simulation.plan.plan import plan_of
    >>> from springpot.problem.parts import Dashpot, Spring, WhiteNoise
    >>> blocks(plan_of(System(Spring(1.0), Dashpot(0.5), WhiteNoise(1.0)), paths=100).settings)
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
    step, system = simulation.settings.step, simulation.plan.system
    length = min(simulation.settings.steps, MOST_STEPS // len(system.points)) * step
    single = simulation.but(paths=1, record=1, record_every=1, threads=1, duration=length, window=(0.0, length))
    states = single.advance(skipped=number * LANES).record[0]
    x, v = states.reshape(len(states), -1, 2).T.copy()
    found = marks(system, step, x, v)
    return Motion(number * LANES, step, x, v, *found, rows_of(system, Stop), voltages(system, step, x))


def marks(system: System, step: float, x: Floats, v: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Steps in which a recorded path turned round near a wall, or first touched a soft contact, and which it was.

    They are numbered in the order of the parts; for marks only.
    """
    walls = system.stops.values()
    found = [_struck(wall, step, row @ x, row @ v) for wall, row in zip(walls, rows_of(system, Stop), strict=True)]
    steps = np.concatenate([np.zeros(0, np.intp), *found])
    numbers = np.repeat(np.arange(len(walls)), [one.size for one in found])
    order = np.argsort(steps, kind="stable")
    return steps[order], numbers[order]


def _struck(wall: Stop, step: float, x: Floats, v: Floats) -> npt.NDArray[np.intp]:
    sign = 1.0 if wall.free_side == "above" else -1.0
    gap, speed = sign * (x - wall.position), sign * v
    if wall.soft_stop is not None:
        return np.flatnonzero((gap[:-1] > 0.0) & (gap[1:] <= 0.0))
    fastest = np.maximum(np.abs(speed[:-1]), np.abs(speed[1:]))
    near = np.minimum(gap[:-1], gap[1:]) <= step * fastest
    return np.flatnonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0) & near)


def voltages(system: System, step: float, x: Floats) -> Floats:
    """The voltage of each circuit along a path, from rest, with straight lines for x.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> system = System(Spring(1.0), PiezoelectricCircuit(coupling=2.0, resistance=1e9, capacitance=1.0))
    >>> voltages(system, 0.1, np.array([[0.0, 1.0, 1.0]])).round(6)
    array([[0., 2., 2.]])
    """
    from scipy.signal import lfilter  # slow to import

    circuits = system.circuits.values()
    found = rows_of(system, Circuit) @ x
    for row, circuit in zip(found, circuits, strict=True):
        if isinstance(circuit, ResonantCircuit):
            turned, (y, q) = turned_in_step(Arm(1.0, circuit.rate, turn=circuit.frequency), step)
            above = circuit.coupling / circuit.capacitance * np.array([y, turned[0, 1] * q - turned[1, 1] * y])
            row[:] = [0.0, *lfilter(above, [1.0, -np.trace(turned), np.linalg.det(turned)], np.diff(row))]
        elif isinstance(circuit, PiezoelectricCircuit):
            decay = step / circuit.time
            gain = circuit.coupling / circuit.capacitance * -np.expm1(-decay) / decay
            row[:] = [0.0, *lfilter([gain], [1.0, -np.exp(-decay)], np.diff(row))]
    return found


class Player:
    """Plays a motion: keeps the current time, and the part that has not been shown yet.

    Examples
    --------
    >>> still = np.zeros((1, 1001))
    >>> path = Motion(0, 0.01, still, still, np.array([3]), np.array([0]), np.ones((1, 1)), np.zeros((0, 1001)))
    >>> player = Player(path, frequency=1.0)
    >>> player.forward(2.0)
    >>> [round(float(part[0]), 3) for part in player.due()[:1]], player.ended
    ([0.0], False)
    """

    def __init__(self, motion: Motion, *, frequency: float) -> None:
        self.motion = motion
        self._frequency = frequency
        self._stride = max(1, int(1.0 / (POINTS_PER_RADIAN * frequency * motion.step)))
        self._shown = 0  # first sample that has not been shown
        self._now = 0.0  # in steps
        self._marked = 0  # impacts that have been shown

    @property
    def ended(self) -> bool:
        """Whether all of the path has been shown."""
        return self._shown > self.motion.steps

    def forward(self, radians: float) -> None:
        """Advance the time, in units of 1 / Omega."""
        self._now = min(self._now + radians / (self._frequency * self.motion.step), float(self.motion.steps))

    def due(self) -> list[npt.ArrayLike]:
        """The part to be shown next: (begin, spacing, path, end of the path), x, v of one mass after the
        other, times and speeds of impacts, the numbers of the walls that were struck, and the present voltages of the
        circuits.

        The speed of an impact on a wall that the mass strikes from below is negative.  Empty if there is no new sample.
        """
        motion, stride = self.motion, self._stride
        end = int(self._now) // stride * stride + 1
        if end <= self._shown:
            return []
        # after a long wait, or at high speed, only the newest points are drawn
        begin = max(self._shown, end - 1 - (MOST_POINTS - 1) * stride)
        taken = slice(begin, end, stride)
        marked = int(np.searchsorted(motion.impacts, end - 1))
        new = slice(max(self._marked, marked - MOST_POINTS), marked)
        struck, rows = motion.impacts[new], motion.rows[motion.struck[new]]
        self._marked = marked
        self._shown = begin + ((end - 1 - begin) // stride + 1) * stride
        return [
            [begin * motion.step, stride * motion.step, motion.path, motion.steps * motion.step],
            motion.x[:, taken],
            motion.v[:, taken],
            (struck + 0.5) * motion.step,
            -(rows.T * motion.v[:, struck]).sum(axis=0),
            motion.struck[new],
            motion.voltages[:, end - 1],
        ]


def rows_of(system: System, kind: type[Element]) -> Floats:
    """The row of each part of a kind, in their order: of numbers for the displacements of all points.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> rows_of(System(Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(2.0, between=("a", "b"))), Spring).tolist()
    [[-1.0, 1.0]]
    """
    at = Coordinates.of_masses(system.points)
    return np.array([at.row(part.between) for part in system.of(kind)]).reshape(-1, len(system.points))
