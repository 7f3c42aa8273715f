"""
How stiff is a rigid stop?
==========================

A rubber or steel stop is often modelled as a rigid wall. The exact law of a mass with a dashpot and white noise covers
soft stops as well, so the error of that model is known without a simulation. Monte Carlo covers them too, here as a
check, and with memory and losses, where no exact law is known.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy import integrate

import springpot as sp

# %%
# A mass on a spring rests against a stop at its equilibrium. The contact force is k d for a linear stop and k d^1.5 for
# Hertz's contact of a sphere; d is the penetration. Without the stop the root mean square displacement is 1.

oscillator = sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)
rigid = sp.theory.exact(sp.System(*oscillator, sp.Barrier(0.0)))
stiffness = np.geomspace(10.0, 1e7, 13)
MEASURED = np.array([10.0, 100.0, 1e3, 1e4])

fig, (left, middle, right) = plt.subplots(1, 3, figsize=(11.4, 3.8), layout="constrained")
for exponent, name, color, line in ((1.5, "Hertz", "#D55E00", "-"), (1.0, "linear", "#0072B2", "--")):
    soft = [sp.theory.exact(sp.System(*oscillator, sp.Contact(0.0, k, exponent))) for k in stiffness]
    gap = [100.0 * (1.0 - each.x_mean / rigid.x_mean) for each in soft]
    left.loglog(stiffness, gap, color=color, ls=line, label=name)
    needed = float(np.interp(-1.0, -np.array(gap), stiffness))
    print(f"{name}: an error of 1 % needs a stiffness of {needed:.2g}")
    deepest = 6.0 * stiffness ** (-1.0 / (exponent + 1.0))
    share = [integrate.quad(each.x_density, -d, 0.0)[0] for each, d in zip(soft, deepest, strict=True)]
    middle.loglog(stiffness, np.multiply(100.0, share), color=color, ls=line, label=name)
    runs = [
        sp.simulate(
            sp.System(*oscillator, sp.Contact(0.0, k, exponent)), paths=6000, duration=60.0, window=(20.0, 60.0)
        )
        for k in MEASURED
    ]
    mean, error = np.array([(run["x_mean"].value, run["x_mean"].error) for run in runs]).T / rigid.x_mean
    sp.figures.bars(left, MEASURED, 100.0 * (1.0 - mean), 100.0 * error, color=color, size=4.0)
    part, error = 100.0 * np.array([(run["contact_share"].value, run["contact_share"].error) for run in runs]).T
    sp.figures.bars(middle, MEASURED, part, error, color=color, size=4.0)
left.axhline(1.0, color="0.6", lw=0.8)
left.set_xlabel("stiffness $k$ of the stop (the spring has 1)")
left.set_ylabel(r"error of $\langle x\rangle$ with a rigid stop (%)")
left.legend()
middle.set_xlabel("stiffness $k$ of the stop (the spring has 1)")
middle.set_ylabel("time in contact (%)")

x = np.linspace(-1.0, 4.0, 1000)
right.plot(x, rigid.x_density(x), color="black", label="rigid")
for k, color, line in ((10.0, "#56B4E9", ":"), (100.0, "#009E73", "-."), (1e4, "#D55E00", "--")):
    soft = sp.theory.exact(sp.System(*oscillator, sp.Contact(0.0, k)))
    right.plot(x, soft.x_density(x), color=color, ls=line, label=f"Hertz, $k$ = {k:g}")
right.set_xlabel("displacement $x$ (m)")
right.set_ylabel("density of $x$ (1/m)")
right.legend()
plt.show()

# %%
# Lines are the exact law, points Monte Carlo with 95 % intervals. The error falls only like k^(-1/2) for the linear
# stop and like k^(-2/5) for Hertz's. A stop that seems hard, a thousand times stiffer than the spring, still shifts the
# mean by 3 to 7 %: model it as a `Contact`. The part of the time in contact falls in the same way.
#
# The impact rate counts first touches. It is lower for a soft stop, in which the mass spends a part of its time:

for k in (10.0, 1e3, 1e5):
    soft = sp.theory.exact(sp.System(*oscillator, sp.Contact(0.0, k)))
    print(f"k = {k:7g}: impact rate {soft.impact_rate:.4f} per s (rigid {rigid.impact_rate:.4f})")
