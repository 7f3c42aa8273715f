r"""
The paper's second figure
=========================

The mean-square amplitude against the order of the derivative at three intensities of the noise: the paper's Eq. 20 as
printed, and its own Monte Carlo (Grünwald-Letnikov sums, Euler steps, from rest), with fewer samples and error bars.

By scale invariance :math:`\langle A^2\rangle / q` is one function of the order, so the three curves coincide.
``make figures`` reproduces the figure at full size.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

C, OMEGA = 1.0, 1.0
figure, (above, below) = plt.subplots(2, figsize=(7.0, 7.0), sharex=True, height_ratios=(3, 2))
orders = (0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
ratios = {}
for q, color in zip((1.0, 5.0, 10.0), ("blue", "vermilion", "green"), strict=True):
    oscillator = sp.Oscillator(OMEGA, sp.Springpot(0.5, C), excitation=sp.WhiteNoise(q))
    runs = [
        sp.simulate(
            sp.Oscillator(OMEGA, sp.Springpot(order, C), excitation=sp.WhiteNoise(q)),
            scheme="grunwald", start="rest", paths=1500, step=2e-3, seed=int(100 * order + q),
        )
        for order in orders
    ]  # fmt: skip
    sp.figures.plot_against(
        "order", above, system=oscillator, values=np.linspace(0.05, 1.0, 96), color=sp.figures.COLORS[color],
        theory={f"Eq. 20, q = {q:g} m²/s³": lambda o: sp.theory.averaging(o, form="printed")},
        runs=runs, label=f"Monte Carlo, q = {q:g} m²/s³",
    )  # fmt: skip
    for order, run in zip(orders, runs, strict=True):
        printed = sp.theory.averaging(run.system, form="printed").amplitude_mean_square
        found = run["amplitude_mean_square"]
        ratios[q, order] = [found.value / printed, found.error / printed]
    value, error = np.array([ratios[q, order] for order in orders]).T
    beside = np.array(orders) + 0.008 * (np.log2(q) - 1.7)
    sp.figures.bars(below, beside, value, error, color=sp.figures.COLORS[color])
above.set_yscale("log")
above.set_xlabel("")
above.legend(frameon=False, ncols=2)
below.axhline(1.0, color="black", lw=1.0)
below.set(xlabel=r"order of the derivative $\alpha$ (1)", ylabel="Monte Carlo / Eq. 20 (1)")
plt.show()

# %%
# In the middle of the range the formula is several per cent too high; the paper's logarithmic axis hides this. At
# :math:`\alpha = 1` it is exact. At small :math:`\alpha` a run from rest over 100 s has not become stationary: see
# :ref:`sphx_glr_auto_gallery_plot_26_start.py`.
