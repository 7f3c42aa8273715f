r"""
Gap and preload
===============

The wall is away from the equilibrium: with a gap, :math:`b < 0`, small cycles never reach it; with a preload,
:math:`b > 0`, the spring presses the mass against it. Averaging has a result at :math:`b = 0` only.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp


def wall(position):
    return sp.Oscillator(
        springpot=sp.Springpot(0.5, 0.3), barrier=sp.Barrier(position, restitution=0.9, free_side="above")
    )


runs = [
    sp.simulate(wall(b), paths=3000, step=0.02, start="stationary", duration=120.0, window=(60.0, 120.0))
    for b in (-3.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5)
]
figure, panels = plt.subplots(3, figsize=(6.8, 8.4), sharex=True)
for axes, quantity in zip(panels, ("amplitude_mean_square", "x_mean", "impact_rate"), strict=True):
    sp.figures.plot_against(
        "position", axes, quantity=quantity, system=wall(0.0), values=np.linspace(-3.0, 1.5, 19),
        theory=[sp.theory.envelope, sp.theory.memory_closure], runs=runs,
    )  # fmt: skip
    if axes is not panels[-1]:
        axes.set_xlabel("")
panels[0].legend(frameon=False)
plt.show()

# %%
# The closure covers walls within one length scale :math:`\sqrt{q/\Omega^3}` of the equilibrium, here 1 m. For other
# walls it says so:

try:
    sp.theory.memory_closure(wall(-2.0))
except sp.theory.NotCoveredError as refusal:
    print(refusal)
