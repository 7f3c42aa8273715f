r"""
Convergence of the schemes
==========================

Left: a free decay, whose exact solution is known. The library's own scheme is of second order in the step, the
paper's of first. Right: the impact rate behind a wall with :math:`r = 0.5`, where many impacts are slow. A step
misses the slowest ones, a share of the order of :math:`h^{1/2}`. Energies are not affected, because slow impacts
carry almost none.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp
from springpot.theory.numerics.contours import relaxation

order, steps = 0.5, np.array([0.1, 0.05, 0.02, 0.01, 0.005, 0.002])
free = sp.Oscillator(springpot=sp.Springpot(order, 0.5), barrier=None, excitation=sp.WhiteNoise(0.0))
errors = {}
for scheme, name in (("default", "the library's scheme"), ("grunwald", "the paper's scheme")):
    sizes = []
    for step in steps:
        run = sp.simulate(free, scheme=scheme, paths=1, record=1, duration=10.0, step=step, initial_velocity=1.0,
                     memory_tolerance=1e-9)  # fmt: skip
        exact = relaxation(order, 0.5).impulse_response(run.time)
        sizes.append(np.max(np.abs(run.record[0, :, 0] - exact)))
    errors[name] = (steps, sizes)

lossy = sp.Oscillator(springpot=sp.Springpot(1.0, 0.5), barrier=sp.Barrier(restitution=0.5))
truth = sp.theory.fokker_planck(lossy).impact_rate
coarse = np.array([0.16, 0.08, 0.04, 0.02, 0.01])
runs = [
    sp.simulate(lossy, paths=20_000, step=step, duration=80.0, window=(16.0, 80.0), start="stationary")
    for step in coarse
]
missed = np.array([1.0 - run["impact_rate"].value / truth for run in runs])
uncertain = np.array([run["impact_rate"].error / truth for run in runs])

figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.2))
sp.figures.plot_convergence(errors, left, ylabel="largest error of x in 10 s (m)")
sp.figures.plot_convergence(
    {"impacts missed, r = 0.5": (coarse, missed, uncertain)}, right, orders=(0.5,), ylabel="share of the impacts (1)"
)
for axes in (left, right):
    axes.legend(frameon=False, fontsize="small")
plt.show()
