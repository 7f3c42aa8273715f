r"""
A study of a device with two stops
==================================

How wide should the gap be, and how elastic the stops? A study of a system answers for a whole grid. Its axes are
numbers of the parts, ``parts.<name>.<number>``; here two numbers always change together, so each pair is one
``zipped`` axis.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

device = sp.System(
    sp.Mass(0.2), sp.Spring(80.0), sp.Springpot(0.5, 1.2), sp.WhiteNoise.from_psd(1e-4, "N2/Hz"),
    lower=sp.Barrier(-0.002, restitution=0.7), upper=sp.Barrier(0.002, restitution=0.7, free_side="below"),
)  # fmt: skip
gaps, restitutions = np.linspace(0.0005, 0.0035, 7), [0.9, 0.7, 0.5]
tree = sp.study(
    {
        "name": "two stops",
        "system": device,
        "methods": ["envelope", "monte_carlo"],
        "quantities": ["impact_rate", "lower_power"],
        "zipped": {
            "gap": {"parts.lower.position": -gaps, "parts.upper.position": gaps},
            "stops": {"parts.lower.restitution": restitutions, "parts.upper.restitution": restitutions},
        },
        "monte_carlo": {"paths": 800, "duration": 20.0},
    }
)

# %%
# Every number has its label. The results of each wall have the dimension ``barrier``: the power that both stops take is
# a sum over it.

simulation = tree["simulation"].to_dataset().swap_dims(gap="upper_position", stops="upper_restitution")
theory = tree["theory"].to_dataset().swap_dims(gap="upper_position", stops="upper_restitution")
power = simulation["barrier_power"].sum("barrier")
error = np.sqrt((simulation["barrier_power_se"] ** 2).sum("barrier"))

figure, (rate_axes, power_axes) = plt.subplots(2, figsize=(6.8, 7.0), sharex=True, layout="constrained")
for r, color, marker in zip(restitutions, ("blue", "green", "vermilion"), "os^", strict=True):
    look = {"color": sp.figures.COLORS[color], "marker": marker, "size": 4.5}
    here = simulation.sel(upper_restitution=r)
    sp.figures.bars(rate_axes, 1e3 * gaps, here["impact_rate"], here["impact_rate_se"], label=f"r = {r}", **look)
    envelope = theory["impact_rate"].sel(theory="envelope", upper_restitution=r)
    rate_axes.plot(1e3 * gaps, envelope, color=look["color"], lw=1.2)
    taken, its_error = (1e3 * part.sel(upper_restitution=r) for part in (power, error))
    sp.figures.bars(power_axes, 1e3 * gaps, taken, its_error, **look)
fed = 1e3 * 0.5 * device.of(sp.WhiteNoise)[0].intensity / device.mass
power_axes.axhline(fed, color="0.6", lw=0.8)
power_axes.annotate("all that the noise feeds in", (3.5, fed), ha="right", va="bottom", color="0.4")
rate_axes.set(ylabel="impacts per second", yscale="log")
rate_axes.legend(frameon=False)
power_axes.set(xlabel="gap on either side (mm)", ylabel="power taken by the stops (mW)", ylim=(0.0, 1.15 * fed))
plt.show()

# %%
# Points are Monte Carlo with 95 % intervals, lines are the envelope theory. In a narrow gap impacts are many, and the
# stops take most of the power; the springpot takes the rest.

share = (power / simulation["input_power"]).sel(upper_position=gaps[0])
for r in restitutions:
    print(f"r = {r}: at the narrowest gap the stops take {100.0 * float(share.sel(upper_restitution=r)):.0f} %")
