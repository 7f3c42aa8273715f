r"""
A part of your own
==================

``sp.Force`` takes any function :math:`f(t, x, v)` that Numba can compile, in newtons, metres and seconds. Here a small
magnet at :math:`x = 6` mm repels a mass of 50 g on a spring and a dashpot: the force is
:math:`-c / (d - x)^2` with a distance of :math:`d = 6` mm, cut off 1 mm before the magnet. No theory knows the
function, but with a dashpot and white noise the density is exact for any potential :math:`U`:
:math:`p(x) \propto \exp(-2 c_1 U(x) / q)`, so the simulation can be checked.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

MASS, STIFFNESS, DAMPING, INTENSITY = 0.05, 400.0, 0.6, 2.5e-3  # kg, N/m, N s/m, N^2 s
DISTANCE, SHORTEST = 6e-3, 1e-3  # m


def magnet(t, x, v):
    """The force of a magnet of 1 N m^2; one function is compiled once, whatever its share."""
    return -1.0 / max(DISTANCE - x, SHORTEST) ** 2


def device(strength):
    """A magnet of c = strength, in N m^2, beside a spring and a dashpot."""
    return sp.System(
        sp.Mass(MASS), sp.Spring(STIFFNESS), sp.Dashpot(DAMPING), sp.WhiteNoise(INTENSITY),
        magnet=sp.Force(magnet, share=strength),
    )  # fmt: skip


def exact(strength):
    """Mean displacement of the Maxwell-Boltzmann law, in m."""
    x = np.linspace(-0.02, 0.02, 40001)
    far = np.maximum(DISTANCE - x, SHORTEST)
    magnet = strength / far + strength * np.maximum(x - DISTANCE + SHORTEST, 0.0) / SHORTEST**2
    weight = np.exp(-2.0 * DAMPING * (0.5 * STIFFNESS * x**2 + magnet) / INTENSITY)
    return (weight @ x) / weight.sum()


strengths = np.array([0.0, 4e-6, 1e-5])
runs = [sp.simulate(device(strength), paths=4000) for strength in strengths]
means, errors = np.array([(run["x_mean"].value, run["x_mean"].error) for run in runs]).T
fine = np.linspace(0.0, 1.1e-5, 60)

figure, axes = plt.subplots(figsize=(6.2, 3.9))
axes.plot(1e6 * fine, [1e3 * exact(s) for s in fine], "-", color=sp.figures.COLORS["vermilion"], label="exact")
sp.figures.bars(axes, 1e6 * strengths, 1e3 * means, 1e3 * errors, size=5.0, label="Monte Carlo, 95 %")
axes.set(xlabel=r"magnet $c$ (µN m$^2$)", ylabel=r"mean displacement $\langle x\rangle$ (mm)")
axes.legend(frameon=False)
plt.show()
print("distance in standard errors:", np.round((means - [exact(s) for s in strengths]) / errors, 1))
