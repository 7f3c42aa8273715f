r"""
A damper chosen so that impacts are rare
========================================

A building of 400 t on isolators of 1.6 MN/m can hit the wall of its pit, 80 mm away, with a restitution of 0.8. In a
strong earthquake its base is shaken with a one-sided spectral density of 0.04 (m/s²)²/Hz near the natural frequency.
Viscoelastic dampers of order 0.5 are to be added. How strong must they be for fewer than 0.2 impacts per second?

The atlas is fast, so a root finder can call it. It gives its error, and the upper end of its 95 % interval is kept
below the limit. Monte Carlo then confirms the design, to 1 %.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import springpot as sp

LIMIT = 0.2  # impacts per second


def building(k_alpha):
    return sp.Oscillator.from_device(
        mass=400e3, stiffness=1.6e6, springpot=(0.5, k_alpha), gap=0.08, restitution=0.8,
        psd=0.04, psd_unit="m2/s4/Hz",
    )  # fmt: skip


def upper_end(k_alpha):
    found = sp.atlas(building(k_alpha))
    return found.impact_rate + found.errors["impact_rate"]


chosen = brentq(lambda k_alpha: upper_end(k_alpha) - LIMIT, 1e5, 1.6e6)
chosen = 1e4 * np.ceil(chosen / 1e4)  # a round number on the safe side
run = sp.simulate(building(chosen), rtol=0.01, quantities=("impact_rate",))
rate, error = run["impact_rate"].value, run["impact_rate"].budget.total
paper = sp.Dimensionless.of(building(chosen))
print(f"k_alpha = {chosen / 1e3:.0f} kN s^0.5/m, that is c = {paper.dimensionless_coefficient:.3f}")
print(f"atlas: at most {upper_end(chosen):.4f} impacts per second; Monte Carlo: {rate:.4f} +- {error:.4f}")
assert rate + error < LIMIT

figure, axes = plt.subplots(figsize=(6.8, 4.2))
strengths = np.geomspace(6e4, 1.5e6, 40)
found = [sp.atlas(building(k_alpha)) for k_alpha in strengths]
rates, errors = np.array([(answer.impact_rate, answer.errors["impact_rate"]) for answer in found]).T
axes.fill_between(strengths / 1e3, rates - errors, rates + errors, color=sp.figures.COLORS["sky"], alpha=0.4, lw=0.0)
axes.plot(strengths / 1e3, rates, color=sp.figures.COLORS["blue"], label="atlas, with its 95 % interval")
sp.figures.bars(
    axes, [chosen / 1e3], [rate], [error / 1.96], color=sp.figures.COLORS["vermilion"], size=5.0,
    label="Monte Carlo, 95 %",
)  # fmt: skip
axes.axhline(LIMIT, color="0.4", ls="--", lw=1.0, label="limit")
axes.set(xscale="log", xlabel=r"strength of the dampers, $k_\alpha$ (kN s$^{0.5}$/m)", ylabel="impacts per second")
axes.minorticks_off()
axes.set_xticks([100, 200, 500, 1000], ["100", "200", "500", "1000"])
axes.legend(frameon=False)
plt.show()

# %%
# Outside the atlas (another restitution than 0.8 or 1 with a gap, for example) replace ``sp.atlas`` by
# ``sp.theory.envelope``. It has no error of its own: leave a margin, and confirm with Monte Carlo.
