"""One path with direct summation over its history, O(N^2): the reference for the exponential sums.

Schemes, walls and normals are those of the kernel; only the memory differs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.machine.arrays import Floats
from springpot.memory import direct
from springpot.problem.parts import Springpot
from springpot.simulation.kernel.lanes import FAST, GROUP, f64
from springpot.simulation.kernel.questions import Forcing, begin, bounce, kick, push
from springpot.simulation.kernel.random import normals
from springpot.simulation.kernel.watching import NO_OBSERVERS, Accumulators
from springpot.simulation.paths.simulation import Simulation

__all__ = ["DirectPath", "direct_path"]


@dataclass(frozen=True, eq=False)
class DirectPath:
    """One path of a run.

    Attributes
    ----------
    x, v : ndarray, shape (steps + 1,)
        At 0, h, 2h, ...
    impacts : ndarray of float, shape (steps,)
        Impacts in each step.
    """

    x: npt.NDArray[np.float64]
    v: npt.NDArray[np.float64]
    impacts: npt.NDArray[np.float64]


def direct_path(simulation: Simulation, path: int = 0) -> DirectPath:
    """Path number ``path`` of a simulation, with direct summation over its history.

    Parameters
    ----------
    simulation : Simulation
        The memory's tolerance is not used.
    path : int

    Returns
    -------
    DirectPath
        The time taken grows with the square of the number of steps: 1e4 steps take about 0.05 s.

    Examples
    --------
    >>> from springpot import Oscillator
    >>> from springpot.simulation.plan.plan import plan_of
    >>> from springpot.simulation.paths.simulation import simulation_of
    >>> plan = plan_of(Oscillator(), duration=1.0, step=0.01, scheme="grunwald", start="rest")
    >>> direct_path(simulation_of(plan)).x.shape
    (101,)
    """
    settings, parts = simulation.settings, simulation.parts
    weights = oracle_weights(simulation)
    g = normals(settings.seed, path + 1, settings.steps)[path]
    x, v = np.zeros((2, settings.steps + 1))  # `_walk` writes from t = h on
    impacts, speeds, squares, collapses = np.zeros((4, settings.steps))  # of each step
    accumulators = Accumulators(impacts, speeds, squares, collapses, np.zeros(0), NO_OBSERVERS)
    forcing = Forcing(*(np.zeros(0) for _ in Forcing._fields))  # white noise needs none
    _walk(parts.scheme, parts.wall, parts.load, weights, parts.drive, parts.start, g, x, v, forcing, accumulators)
    x[0], v[0] = parts.start.states[0, :2]
    x_unit, v_unit = parts.units.state
    return DirectPath(x_unit * x, v_unit * v, impacts)


def oracle_weights(simulation: Simulation) -> Floats:
    """Weights of all increments, newest first, in the kernel's units of force."""
    (spring,), settings = simulation.motion.unit.of(Springpot), simulation.settings
    order, scale = spring.order, spring.coefficient * settings.step**-spring.order * simulation.parts.units.time**2
    scheme = settings.numerical_scheme
    weights = direct(scheme.family, order, settings.steps + 1)
    weights[:GROUP] = scheme.recent_weights(order)[: settings.steps + 1]
    return np.asarray(scale * weights)


@njit(**FAST)
def _walk(scheme, wall, load, weights, drive, start, g, xs, vs, forcing, accumulators):
    x0, v0 = start.states[0, 0], start.states[0, 1]
    x, v = begin(scheme, wall, x0, v0, start.early, accumulators, 0, 1.0)
    steps = g.size
    increments = np.empty(steps + 1)
    increments[0] = x - x0
    for n in range(steps):
        memory_force = f64(drive[n]) if drive.size > 0 else 0.0
        for j in range(n + 1):
            memory_force += weights[j] * increments[n - j]
        noise, force = push(load, 0, n, x, v, f64(g[n]), forcing, 0, 0, 1.0)
        impulse, _ = kick(scheme, x, v, memory_force, noise + force)
        v += impulse
        xs[n + 1], vs[n + 1], x_next, v = bounce(scheme, wall, x, v, accumulators, n, 1.0, 1.0)
        increments[n + 1] = x_next - x
        x = x_next
