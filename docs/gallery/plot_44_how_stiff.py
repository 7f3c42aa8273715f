"""
How stiff is a rigid stop?
==========================

A rubber or steel stop is often modelled as a rigid wall. The exact law of a mass with a dashpot and white noise covers
soft stops as well, so the error of that model is known without a simulation.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

# %%
# A mass on a spring rests against a stop at its equilibrium. The contact force is k d for a linear stop and k d^1.5 for
# Hertz's contact of a sphere; d is the penetration. Without the stop the root mean square displacement is 1.

oscillator = sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)
rigid = sp.theory.exact(sp.System(*oscillator, sp.Barrier(0.0)))
stiffness = np.geomspace(10.0, 1e7, 25)

fig, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for exponent, name, color, line in ((1.5, "Hertz", "#D55E00", "-"), (1.0, "linear", "#0072B2", "--")):
    soft = [sp.theory.exact(sp.System(*oscillator, sp.Contact(0.0, k, exponent))) for k in stiffness]
    gap = [100.0 * (1.0 - each.x_mean / rigid.x_mean) for each in soft]
    left.loglog(stiffness, gap, color=color, ls=line, label=name)
    needed = float(np.interp(-1.0, -np.array(gap), stiffness))
    print(f"{name}: an error of 1 % needs a stiffness of {needed:.2g}")
left.axhline(1.0, color="0.6", lw=0.8)
left.set_xlabel("stiffness $k$ of the stop (the spring has 1)")
left.set_ylabel(r"error of $\langle x\rangle$ with a rigid stop (%)")
left.legend()

x = np.linspace(-1.0, 2.5, 700)
right.plot(x, rigid.x_density(x), color="black", label="rigid")
for k, color, line in ((10.0, "#56B4E9", ":"), (100.0, "#009E73", "-."), (1e4, "#D55E00", "--")):
    soft = sp.theory.exact(sp.System(*oscillator, sp.Contact(0.0, k)))
    right.plot(x, soft.x_density(x), color=color, ls=line, label=f"Hertz, $k$ = {k:g}")
right.set_xlabel("displacement $x$ (m)")
right.set_ylabel("density of $x$ (1/m)")
right.legend()
plt.show()

# %%
# The error falls only like k^(-1/2) for the linear stop and like k^(-2/5) for Hertz's. A stop that seems hard, a
# thousand times stiffer than the spring, still shifts the mean by 3 to 7 %: model it as a `Contact`.
#
# The impact rate counts first touches. It is lower for a soft stop, in which the mass spends a part of its time:

for k in (10.0, 1e3, 1e5):
    soft = sp.theory.exact(sp.System(*oscillator, sp.Contact(0.0, k)))
    print(f"k = {k:7g}: impact rate {soft.impact_rate:.4f} per s (rigid {rigid.impact_rate:.4f})")
