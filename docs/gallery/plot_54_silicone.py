r"""
Moduli of a silicone
====================

A silicone's storage and loss modulus from 0.01 to 100 Hz. The data are made in the example, with errors of 2 % on every
value, from a spring in parallel with two springpots. One springpot is not enough: the residuals have a shape. Three
models are fitted, and the Bayesian information criterion chooses between them.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

rng = np.random.default_rng(4)
frequency = np.geomspace(0.01, 100.0, 33)
p = 2j * np.pi * frequency
modulus = 2e5 + 4e4 * p**0.25 + 3e3 * p**0.75  # Pa
noise = 1.0 + 0.02 * rng.standard_normal((2, frequency.size))
data = sp.MeasuredModuli(frequency, modulus.real * noise[0], modulus.imag * noise[1], relative_error=0.02)

spring = sp.Spring(sp.free("k", 1e5, (1e3, 1e7)))
first = sp.Springpot(sp.free("order_1", 0.3, (0.02, 0.5)), sp.free("C_1", 1e4, (1e2, 1e7)))
second = sp.Springpot(sp.free("order_2", 0.7, (0.5, 0.98)), sp.free("C_2", 1e3, (1e1, 1e6)))
models = [sp.System(spring, first), sp.System(first, second), sp.System(spring, first, second)]
best = sp.fit(models, data)
print(best.report())

# %%
# The best model, and the residuals of a single springpot beside its spring.

best_fit = sp.figures.plot_fit(best)
plt.show()

simple = sp.fit(models[0], data)
print(simple.check().sentences)
figure, axes = plt.subplots(figsize=(6.4, 3.0), layout="constrained")
table = simple.table
for name, mark in (("storage", "o"), ("loss", "s")):
    own = table.group == name
    axes.semilogx(table.at[own], table.residual[own], mark, label=f"{name}, one springpot")
axes.axhline(0.0, color="0.5", linewidth=0.8)
axes.set(xlabel="frequency (Hz)", ylabel="residual (sd)")
axes.legend(frameon=False)
plt.show()
