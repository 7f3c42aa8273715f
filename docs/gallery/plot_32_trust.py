r"""
How far to trust a method
=========================

The deviation of each method from Monte Carlo has been measured on 700 cells of the dimensionless problem. The panels
show the cells with an elastic wall at the equilibrium. Numbers are bold where it is more than 2 % of
:math:`\langle A^2\rangle`; cells are hatched where the method has no result.
"""

import matplotlib.pyplot as plt

import springpot as sp

figure, panels = plt.subplots(2, 2, figsize=(8.6, 7.0), sharex=True, sharey=True)
for method, axes in zip(("averaging", "averaging_amplitude", "envelope", "memory_closure"), panels.flat, strict=True):
    sp.figures.plot_gaps(method, ax=axes)
for axes in panels[0]:
    axes.set_xlabel("")
for axes in panels[:, 1]:
    axes.set_ylabel("")
plt.show()

# %%
# The recommendation comes from this map:

for order, c, r in ((0.9, 0.03, 1.0), (0.3, 1.0, 1.0), (0.5, 0.3, 0.6)):
    oscillator = sp.Oscillator(springpot=sp.Springpot(order, c), barrier=sp.Barrier(restitution=r))
    best = sp.recommended(oscillator).method
    gaps = sp.trust(oscillator, best).gaps
    print(f"order {order:g}, c = {c:g}, r = {r:g}: {best},", *(f"{name} {gap:.1f} %" for name, gap in gaps.items()))

# %%
# A hardening spring, other walls or colored noise are on a second map, of 911 cells. The panels have
# :math:`\kappa q/\Omega^5 = 1`: three show :math:`\langle x^2\rangle` without a wall, the last one the impact rate at a
# wall of restitution 0.8.

figure, panels = plt.subplots(2, 2, figsize=(8.6, 6.4), sharex=True, sharey=True)
for method, axes in zip(("averaging_amplitude", "linearization", "envelope"), panels.flat, strict=False):
    sp.figures.plot_system_gaps(method, ax=axes)
sp.figures.plot_system_gaps("envelope", "impact_rate", panels[1, 1], walls=1, restitution=0.8)
for axes in panels[0]:
    axes.set_xlabel("")
for axes in panels[:, 1]:
    axes.set_ylabel("")
plt.show()

# %%
# Warnings and recommendations come from it:

for kappa, tau in ((0.3, 0.0), (0.3, 0.5), (30.0, 0.0)):
    noise = sp.ColoredNoise(1.0, tau) if tau else sp.WhiteNoise(1.0)
    system = sp.System(sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, kappa)), sp.Springpot(0.5, 0.3), noise)
    print(f"kappa {kappa:g}, tau {tau:g}: {sp.recommended(system)}")
    for sentence in sp.trust(system, "envelope").warnings:
        print("   envelope:", sentence)
