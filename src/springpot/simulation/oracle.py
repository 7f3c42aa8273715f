"""One path with its whole past summed directly, O(N^2): the oracle for the exponential sums.

The same schemes, walls and normals as the kernel; only the memory differs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.memory import direct
from springpot.oscillator import Oscillator
from springpot.simulation.compose import Floats, Tables, family, mirror, recent_weights, tables
from springpot.simulation.lanes import FAST, GROUP, f64
from springpot.simulation.listening import NOBODY, Ear
from springpot.simulation.parts import begin, bounce, kick, push
from springpot.simulation.random import normals
from springpot.simulation.settings import Settings

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


def direct_path(oscillator: Oscillator, settings: Settings, path: int = 0) -> DirectPath:
    """Path number ``path`` of the run that these settings describe, with the direct sum over the past.

    Parameters
    ----------
    oscillator : Oscillator
    settings : Settings
        From :func:`springpot.simulation.settings.resolve`; the memory's tolerance is not used.
    path : int

    Returns
    -------
    DirectPath
        The time taken grows with the square of the number of steps: 1e4 steps take about 0.05 s.

    Examples
    --------
    >>> from springpot.simulation.settings import resolve
    >>> settings = resolve(Oscillator(), duration=1.0, step=0.01, scheme="grunwald", start="rest")
    >>> direct_path(Oscillator(), settings).x.shape
    (101,)
    """
    made = tables(oscillator, settings)
    weights = oracle_weights(oscillator, settings, made)
    g = normals(settings.seed, path + 1, settings.steps)[path]
    x, v = np.zeros((2, settings.steps + 1))  # the walk leaves the first to us
    impacts, speeds, squares, collapses = np.zeros((4, settings.steps))  # of each step
    ear = Ear(impacts, speeds, squares, collapses, NOBODY)
    _walk(made.scheme, made.wall, made.load, weights, made.drive, made.start, g, x, v, ear)
    x, v = mirror(oscillator) * made.length * x, mirror(oscillator) * made.length / made.time * v
    x[0], v[0] = settings.initial_position, settings.initial_velocity
    return DirectPath(x, v, impacts)


def oracle_weights(oscillator: Oscillator, settings: Settings, made: Tables) -> Floats:
    """What each increment of the past weighs, newest first, in the kernel's units of force."""
    order = oscillator.springpot.order
    scale = oscillator.springpot.coefficient * settings.step**-order * made.time**2
    weights = direct(family(settings), order, settings.steps + 1)
    weights[:GROUP] = recent_weights(order, settings)[: settings.steps + 1]
    return np.asarray(scale * weights)


@njit(**FAST)
def _walk(scheme, wall, load, weights, drive, start, g, xs, vs, ear):
    x, v = begin(scheme, wall, start, ear, 0, 1.0)
    e = 0.0
    steps = g.size
    increments = np.empty(steps + 1)
    increments[0] = x - start.x
    for n in range(steps):
        past = f64(drive[n]) if drive.size > 0 else 0.0
        for j in range(n + 1):
            past += weights[j] * increments[n - j]
        pushed, e = push(load, n, x, v, e, f64(g[n]))
        v, _ = kick(scheme, x, v, past, pushed)
        xs[n + 1], vs[n + 1], x_next, v = bounce(scheme, wall, x, v, ear, n, 1.0, 1.0)
        increments[n + 1] = x_next - x
        x = x_next
