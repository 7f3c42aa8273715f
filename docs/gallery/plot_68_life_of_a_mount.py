r"""
Life of a mount
===============

A box on four rubber mounts is shaken from 10 to 2000 Hz. A mount survives a million cycles of 30 N amplitude, and
Basquin's exponent is 5.5. Stops limit the largest forces: how much longer do the mounts live? The cycles of the force
are counted by the rainflow method while the simulation runs; theory knows the box without stops.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

shake = sp.SpectralExcitation.from_psd((10, 40, 500, 2000), (0.01, 0.04, 0.04, 0.005), "g2/Hz")
mounts = {"spring": sp.Spring(2970.0, count=4), "rubber": sp.Springpot(0.25, 966.0, count=4)}  # the numbers of one
curve = sp.Basquin(5.5, strength=30.0, cycles=1e6, stress=0.25)  # a mount has a quarter of the force that is counted
force = {"force_on_ground": curve}


def counted(gap):
    stops = {"lower": sp.Barrier(-gap, 0.6), "upper": sp.Barrier(gap, 0.6, free_side="below")}
    box = sp.System(sp.Mass(2.5), **mounts, **stops, shake=shake)
    return sp.simulate(box, paths=1600, duration=4.0, slowest_counted_impact=0.02, rainflow=force, seed=1)


free = sp.System(sp.Mass(2.5), **mounts, shake=shake)
gaps = np.array([1.5, 2.0, 2.5, 3.0, 4.0, 5.0])
runs = [*map(counted, 1e-3 * gaps), sp.simulate(free, paths=1600, duration=4.0, rainflow=force, seed=1)]
theory = sp.theory.fatigue(free, curve, "force_on_ground")
for name, run in zip([*(f"gap {gap} mm" for gap in gaps), "without stops"], runs, strict=True):
    print(f"{name}: life {run['force_on_ground_life']}")
for name, hours in theory.life.items():
    print(f"without stops, {name}: {hours:.0f} h")

# %%
# Bars are 95 % intervals. With stops at 1.5 mm the mass strikes them often, and the force cannot be large. The formula
# of Dirlik agrees with the count where the system is linear, and the narrow band has too much damage.
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.0), layout="constrained")
life = np.array([[run["force_on_ground_life"].value, run["force_on_ground_life"].error] for run in runs]).T
left.errorbar(gaps, life[0, :-1], 1.96 * life[1, :-1], fmt="o-", capsize=3, label="with stops")
left.axhspan(*(life[0, -1] + 1.96 * np.array([-1.0, 1.0]) * life[1, -1]), alpha=0.3, label="without stops, counted")
left.axhline(theory.life["dirlik"], color="C2", ls="--", label="without stops, Dirlik")
left.axhline(theory.life["narrow_band"], color="C1", label="without stops, narrow band")
left.set(yscale="log", xlabel="gap (mm)", ylabel="life of the mounts (h)")
left.legend(frameon=False)
sp.figures.plot_rainflow(runs[-1], "force_on_ground", right, label="without stops", theory=theory)
sp.figures.plot_rainflow(runs[1], "force_on_ground", right, label="2 mm")
right.legend(frameon=False)
plt.show()
