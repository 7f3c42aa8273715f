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
DECADE = 10.0 * 365.25 * 86400.0
speed = np.interp(np.log(DECADE), np.log(curve.return_period), speeds)
axes = sp.figures.plot_return_periods(curve, plt.figure(figsize=(6.6, 4.2)).add_subplot())
axes.plot(speed, DECADE, "ko", ms=4)
for seconds, name in ((60.0, "minute"), (86400.0, "day"), (DECADE / 10.0, "year"), (DECADE, "ten years")):
    axes.axhline(seconds, color="0.8", lw=0.8, zorder=0)
    axes.text(speeds[0], seconds, name, va="bottom", color="0.4")
plt.show()
print(f"once in ten years an impact is faster than {speed:.2f} m/s")

# %%
# The step matters more in the tail than in the mean: halve it where the number decides something. The same call with
# ``{"x": levels}`` gives the largest displacements.
