r"""
How long the start from rest influences the results
===================================================

From rest the displacement climbs to its mean, and the springpot remembers that step with a force that decays only
like :math:`t^{-\alpha}`. At small :math:`\alpha` even a long run from rest is then not stationary. An adapted start
(``start="stationary"``) begins at the stationary mean, with no memory of another state.
"""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

oscillator = sp.Oscillator(springpot=sp.Springpot(order=0.2, coefficient=1.0))
figure, (above, below) = plt.subplots(2, figsize=(6.8, 6.2), sharex=True)
for start, color in (("rest", "vermilion"), ("stationary", "blue")):
    edges = np.geomspace(10.0, 640.0, 9)
    found = [
        sp.simulate(oscillator, paths=4000, duration=end, window=(begin, end), step=0.05, start=start)
        for begin, end in pairwise(edges)
    ]
    middle = np.sqrt(edges[:-1] * edges[1:])
    for axes, quantity in ((above, "x_mean"), (below, "impact_rate")):
        value = [run[quantity].value for run in found]
        error = [run[quantity].error for run in found]
        sp.figures.bars(axes, middle, value, error, color=sp.figures.COLORS[color], size=4.0, label=f"start={start!r}")
above.axhline(sp.theory.envelope(oscillator).x_mean, color="0.4", lw=1.0, ls="--", label="envelope (stationary)")
below.axhline(sp.theory.envelope(oscillator).impact_rate, color="0.4", lw=1.0, ls="--")
above.set_ylabel(r"mean displacement $\langle x\rangle$ (m)")
above.legend(frameon=False)
below.set(xscale="log", xlabel="time (s)", ylabel="impact rate (1/s)")
below.minorticks_off()
below.set_xticks([10, 30, 100, 300], ["10", "30", "100", "300"])
plt.show()
