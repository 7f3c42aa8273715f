r"""
A part of your own
==================

The kernel is composed of parts. A part is a ``NamedTuple`` of numbers, with compiled functions that the kernel
calls. Here a hardening spring with the force :math:`-\kappa x^3` is added in a few lines, and checked against an
exact result: with a dashpot and an elastic wall the density is :math:`\exp[-(2C/q)(v^2/2 + V(x))]`, whatever the
potential :math:`V`. (The library has this spring, as `springpot.PolynomialSpring`: the other
parts of a `springpot.System` are added in the same way. For a force that is just a function, take `springpot.Force`.)
"""

from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp
from springpot.simulation.forces import only_pushes
from springpot.simulation.kernel import COLUMNS
from springpot.simulation.parts import answers, push
from springpot.simulation.settings import resolve
from springpot.simulation.simulation import simulation_of


class HardeningSpring(NamedTuple):
    """White noise, and a spring beside the linear one."""

    strength: float  # of the noise
    impulse: float  # kappa times the step


only_pushes(HardeningSpring)


@answers(push, HardeningSpring)
def push_of_the_hardening_spring(force, slot, n, x, v, g, forcing, at, lane, weight):
    """The impulses of step n, of the noise and of the spring: g is a standard normal."""
    return force.strength * g, -force.impulse * x**3


def x_mean_square(kappa, step=0.02):
    oscillator = sp.Oscillator(springpot=sp.Springpot(1.0, 1.0))
    settings = resolve(oscillator, paths=6400, duration=60.0, step=step, window=(15.0, 60.0), start="rest")
    simulation = simulation_of(oscillator, settings)  # with unit scales, since this oscillator's are 1
    load = HardeningSpring(simulation.parts.load.strength, kappa * step)
    rows = simulation.with_parts(load=load).advance().rows
    squares = rows[:, COLUMNS.index("x_square")] / np.diff(settings.window_steps)
    return squares.mean(), squares.std(ddof=1) / np.sqrt(squares.size)


kappas = np.array([0.0, 0.5, 1.0, 2.0, 4.0])
value, error = np.array([x_mean_square(kappa) for kappa in kappas]).T
fine, x = np.linspace(0.0, 4.0, 81), np.linspace(0.0, 6.0, 4001)
density = np.exp(-2.0 * (x**2 / 2.0 + fine[:, None] * x**4 / 4.0))
exact = (density @ x**2) / density.sum(axis=1)

figure, axes = plt.subplots(figsize=(6.2, 3.9))
sp.figures.bars(axes, kappas, value, error, size=4.0, label="Monte Carlo with the part, 95 %")
axes.plot(fine, exact, "-", color=sp.figures.COLOURS["vermilion"], label="exact")
axes.set(xlabel=r"hardening $\kappa$ (m$^{-2}$ s$^{-2}$)", ylabel=r"$\langle x^2\rangle$ (m$^2$)")
axes.legend(frameon=False)
plt.show()
print("distance in standard errors:", np.round((value - np.interp(kappas, fine, exact)) / error, 1))
