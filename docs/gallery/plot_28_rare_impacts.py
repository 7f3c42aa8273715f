r"""
The impact of ten years
=======================

An instrument of 0.8 kg on a rubber mount is shaken with 0.01 g²/Hz, and strikes a stop 6 mm below. One impact that is
fast enough breaks its glass. Which speed is exceeded once in ten years?

The fastest impact of a minute has about 0.6 m/s. ``sp.exceedance`` finds the rate of faster ones by splitting. Two
seconds of motion are enough, because they are several relaxation times, and rarer impacts cost little more.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

device = sp.System(
    sp.Mass(0.8),
    sp.Spring(3200.0),
    sp.Springpot(0.3, 150.0),
    sp.Barrier(-0.006, restitution=0.7),
    sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
)
speeds = np.linspace(0.5, 1.25, 16)
found = sp.exceedance(device, {"impact_speed": speeds}, duration=2.0, step=4e-4, rtol=0.3, seed=1)
curve = found["impact_speed"]
print(found)

# %%
# The band is the 95 % interval of the return period at each speed, from independent repetitions.
YEAR = 365.25 * 86400.0
decade = np.interp(np.log(10.0 * YEAR), np.log(curve.return_period), speeds)

figure, axes = plt.subplots(figsize=(6.6, 4.2))
factor = np.exp(1.96 * curve.rate_error / curve.rate)
axes.fill_betweenx(speeds, curve.return_period / factor, curve.return_period * factor, alpha=0.25, lw=0)
axes.plot(curve.return_period, speeds)
axes.set_xscale("log")
axes.set_xlabel("return period in s")
axes.set_ylabel("impact speed in m/s")
for seconds, name in ((60.0, "minute"), (86400.0, "day"), (YEAR, "year"), (10.0 * YEAR, "ten years")):
    axes.axvline(seconds, color="0.8", lw=0.8, zorder=0)
    axes.text(seconds, speeds[0], name, rotation=90, va="bottom", ha="right", color="0.4")
plt.show()
print(f"once in ten years an impact is faster than {decade:.2f} m/s")

# %%
# The step matters more in the tail than in the mean: halve it where the number decides something. The same call with
# ``{"x": levels}`` gives the largest displacements.
