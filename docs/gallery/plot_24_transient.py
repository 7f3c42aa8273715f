r"""
From rest to the stationary state
=================================

By the paper's Eq. 19 the mean-square amplitude grows from rest as :math:`\mu(t) = \mu_\infty (1 - e^{-2\beta t})`.
The figure also shows the energy envelope and, for a dashpot, the exact result, which includes the ripple at twice
the natural frequency.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.9))
for axes, order in zip(panels, (1.0, 0.5), strict=True):
    oscillator = sp.Oscillator(springpot=sp.Springpot(order, coefficient=0.2))
    run = sp.simulate(oscillator, paths=8000, record=8000, duration=30.0, step=0.05, start="rest", seed=5)
    theory = [sp.theory.averaging(oscillator), sp.theory.envelope(oscillator)]
    if order == 1.0:
        theory.append(sp.theory.exact(oscillator))
    sp.figures.plot_transient(run, ax=axes, theory=theory, at=np.linspace(0.0, 30.0, 301))
    axes.set_title(rf"$\alpha$ = {order:g}, $C$ = 0.2 s$^{{\alpha-2}}$", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")
panels[1].set_ylabel("")
plt.show()
