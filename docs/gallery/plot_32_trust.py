r"""
How far to trust a method
=========================

The gap of each method to Monte Carlo has been measured on 700 cells of the dimensionless problem. The panels show
the cells with an elastic wall at the equilibrium. Numbers are bold where the gap is more than 2 % of
:math:`\langle A^2\rangle`; cells are hatched where the method has no result.
"""

import matplotlib.pyplot as plt

import springpot as sp

figure, panels = plt.subplots(2, 2, figsize=(8.6, 7.0), sharex=True, sharey=True)
for method, axes in zip(("averaging", "averaging_shifted", "envelope", "closure"), panels.flat, strict=True):
    sp.figures.gaps(method, axes=axes)
for axes in panels[0]:
    axes.set_xlabel("")
for axes in panels[:, 1]:
    axes.set_ylabel("")
plt.show()

# %%
# The warnings in the results and the recommendation come from this map:

for order, c, r in ((0.9, 0.03, 1.0), (0.3, 1.0, 1.0), (0.5, 0.3, 0.6)):
    oscillator = sp.Oscillator(springpot=sp.Springpot(order, c), barrier=sp.Barrier(restitution=r))
    answers, _ = sp.theory.solve_all(oscillator)
    best = sp.theory.recommended(oscillator, answers)
    gaps = sp.theory.trust(oscillator, best).gaps
    print(f"order {order:g}, c = {c:g}, r = {r:g}: {best},", *(f"{name} {gap:.1f} %" for name, gap in gaps.items()))
