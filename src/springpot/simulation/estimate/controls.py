"""Control variates: numbers of a path whose mean is known to be zero, from the balances of a stationary motion.

energy
    Dissipated power plus gain of energy less expected input power: zero at every step of the default scheme.
gain
    The gain of energy over the window: zero in a stationary state.  Under a harmonic force alone it is no control: all
    its scatter is that of the transient, however small, which the regression would take for the whole.
momentum
    The mean of all forces.
virial
    d<x v>/dt = <v^2> + <x times all forces>.

The last two need the means of x and v^2 - w^2 x^2 in the flights between two kicks.  The kernel sums both in the middle
of a flight, where a free flight of angular frequency w over a step h has its means over sin(w h / 2) / (w h / 2) and
sin(w h) / (w h).  A jump j of the velocity at a place b, at any instant of the flight with the same probability, adds
h^2 j / 24 to the first and -h^2 w^2 b j / 6 to the second.  What is left is of third order in the step.

A path with a larger input has a larger amplitude, and one that was pushed from the wall fewer impacts: regression on
all four leaves a hundredth of the variance of <A^2>, a third to a half of that of an impact rate on an elastic wall
(docs/performance.md).
"""

from __future__ import annotations

import math

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts import Barrier, Dashpot, FractionalMaxwell, Mass, Maxwell, Spring, Springpot, WhiteNoise
from springpot.simulation.lowering.compose import Sum
from springpot.simulation.paths.simulation import Simulation

SUMMED = (Mass, Spring, Springpot, Dashpot, FractionalMaxwell, Maxwell, Barrier, WhiteNoise)
"""Parts whose forces the kernel sums; with any other part there is no control by momentum and virial."""


def controls_of(simulation: Simulation, rows: Floats, residual: Floats | None) -> Floats:
    """The controls of every path, shape (paths, controls).

    Parameters
    ----------
    simulation : Simulation
    rows : ndarray, shape (paths, columns)
    residual : ndarray or None
        The samples of ``energy_residual``; None if there are none.
    """
    sums = simulation.parts.sums(rows)
    found = [sums["energy", "last"] - sums["energy", "first"]] if simulation.motion.is_noisy else []
    if residual is not None and np.isfinite(residual).all():
        found.append(residual)
    if _are_summed(simulation):
        found.extend(_balances(simulation, sums))
    return np.stack([np.zeros(len(rows)), *found], axis=1)[:, 1:]


def _are_summed(simulation: Simulation) -> bool:
    """Whether the kernel has the sums of all forces but those of exact flights."""
    if not simulation.parts.tables.count("turns"):
        return False
    stiffness = simulation.motion.unit.stiffness  # a flight has all of it, unless there is none
    return all(isinstance(part, SUMMED) for part in simulation.motion.centred.parts) and math.isclose(
        stiffness, _frequency(simulation) ** 2, rel_tol=1e-9
    )


def _balances(simulation: Simulation, sums: dict[Sum, Floats]) -> tuple[Floats, Floats]:
    """Means over the window of the forces and of d(x v)/dt, per unit mass."""
    settings, (low, high) = simulation.settings, simulation.settings.window_steps
    steps, step = high - low, settings.step
    frequency = _frequency(simulation)
    turn = frequency * step
    jumps = []  # the place of each wall as the kernel has it, and the jumps of the velocity there
    for name in simulation.parts.walls:
        wall, momentum = simulation.motion.touched[name], sums["momentum", name] / simulation.parts.mass
        jump = momentum if wall.free_side == "above" else -momentum
        jumps.append((wall.position - simulation.motion.origin, jump / (steps * step)))
    none, mass = np.zeros(sums["force", ""].size), simulation.parts.mass
    pushed = sum((jump for _, jump in jumps), none)
    turned = sum((place * jump for place, jump in jumps), none)
    x, xx, vv = (sums[name, simulation.parts.points[0]] / steps for name in ("x", "x^2", "v^2"))
    force, virial = sums["force", ""] / steps / mass, sums["virial", ""] / steps / mass
    mean = x * _sinc(0.5 * turn) + step**2 / 24.0 * pushed
    both = (vv - frequency**2 * xx) * _sinc(turn) - turn**2 / 6.0 * turned
    return pushed - frequency**2 * mean - force, both + turned - virial


def _frequency(simulation: Simulation) -> float:
    """Angular frequency of a flight, in rad/s."""
    return simulation.parts.frequency / simulation.parts.units.time


def _sinc(angle: float) -> float:
    return math.sin(angle) / angle if angle > 0.0 else 1.0
