r"""
A path, its impacts, and its phase portrait
===========================================

One sample path of a mass on a springpot of order 0.5 that bounces off a wall at its equilibrium. It leaves the wall
with 0.8 of its speed before the impact.
"""

import matplotlib.pyplot as plt

import springpot as sp

oscillator = sp.Oscillator(springpot=sp.Springpot(order=0.5, coefficient=0.2), barrier=sp.Barrier(restitution=0.8))
run = sp.simulate(oscillator, paths=64, record=1, duration=100.0, seed=3)

figure = plt.figure(figsize=(8.4, 4.6))
grid = figure.add_gridspec(2, 2, width_ratios=(5, 3))
above = figure.add_subplot(grid[0, 0])
below = figure.add_subplot(grid[1, 0], sharex=above)
plane = figure.add_subplot(grid[:, 1])
window = (60.0, 100.0)
sp.figures.plot_path(run, above, window=window)
sp.figures.plot_path(run, below, quantity="v", window=window)
sp.figures.plot_phase_portrait(run, plane, window=window)
above.set_xlabel("")
above.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=2, fontsize="small")
plt.show()

# %%
# The noise acts on the velocity, which is continuous between impacts but rough; the displacement is smooth. An
# impact reverses the velocity and changes nothing else: the springpot keeps its memory of the displacement.
