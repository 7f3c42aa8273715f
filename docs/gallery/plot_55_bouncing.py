r"""
Restitution from a bouncing record
==================================

A steel ball bounces on a plate, and a microphone records the times of its impacts. A flight of duration T begins and
ends at the speed g T / 2, so the times give the speeds before and after every impact. The times are made in the
example from a restitution that falls slowly with the speed, with errors of 0.2 ms. A constant restitution and a power
law are fitted, and the Bayesian information criterion chooses. The law found is then a wall of the simulation.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

rng = np.random.default_rng(2)
speed, times = 3.0, [0.0]
for _ in range(24):
    times.append(times[-1] + 2.0 * speed / 9.80665)
    speed *= 0.88 * speed**-0.08
times = np.array(times) + 2e-4 * rng.standard_normal(25)
data = sp.MeasuredImpacts.from_times(times)

constant = sp.Barrier(0.0, sp.free("r", 0.8, (0.1, 1.0)))
falling = sp.Barrier(0.0, sp.PowerRestitution(
    sp.free("r_at_1", 0.8, (0.1, 1.0)), speed=1.0, exponent=sp.free("exponent", 0.1, (0.001, 1.0)),
))  # fmt: skip
found = sp.fit([constant, falling], data)
print(found.report())
print(found.model)

figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
axes.plot(found.table.at, found.table.data, "o", markersize=4, label="from the times")
axes.plot(found.table.at, found.table.fitted, color="black", label="power law")
axes.axhline(sp.fit(constant, data).values["r"], color="0.5", linestyle="--", label="constant")
axes.set(xlabel="speed before the impact (m/s)", ylabel="restitution")
axes.legend(frameon=False)
plt.show()
