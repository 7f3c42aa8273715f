r"""
Correlation in time
===================

:math:`\langle x(t)\,x(t + \mathrm{lag})\rangle`, from recorded paths and by theory. At large lags it is the squared
mean; with the wall it oscillates at twice the natural frequency.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

oscillator = sp.Oscillator(springpot=sp.Springpot(order=0.7, coefficient=0.3))
run = sp.simulate(oscillator, paths=2000, record=2000, step=0.05, duration=160.0, start="stationary", seed=7)
lags = np.linspace(0.0, 25.0, 76)
theory = [sp.theory.memory_closure(oscillator), sp.theory.averaging(oscillator)]

figure, axes = plt.subplots(figsize=(6.4, 4.0))
sp.figures.plot_correlation(run, axes, at=lags, since=40.0)
sp.figures.plot_correlation(None, axes, theory=theory, at=np.linspace(0.0, 25.0, 400))
axes.legend(frameon=False)
plt.show()

# %%
# Averaging assumes that the motion has one frequency, :math:`\Omega`. The closure includes the springpot's stiffness,
# which raises the frequency.
