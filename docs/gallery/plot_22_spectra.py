r"""
Spectra with and without a wall
===============================

The spectral density of the displacement, estimated in the run. Without a wall it is known exactly; with a wall at
the equilibrium the motion is reflected, :math:`x = |y|`: the line at the natural frequency moves to twice this
frequency, and slow changes of the amplitude appear at low frequency.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

springpot = sp.Springpot(order=0.5, coefficient=0.3)
frequencies = np.linspace(0.1, 4.5, 67)
figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.9), sharey=True)
for axes, barrier in zip(panels, (None, sp.Barrier()), strict=True):
    oscillator = sp.Oscillator(springpot=springpot, barrier=barrier)
    run = sp.simulate(
        oscillator, paths=600, step=0.025, duration=520.0, window=(120.0, 520.0), start="stationary",
        spectrum=frequencies,
    )  # fmt: skip
    methods = (
        (sp.theory.exact, sp.theory.averaging) if barrier is None else (sp.theory.memory_closure, sp.theory.averaging)
    )
    theory = [method(oscillator) for method in methods]
    sp.figures.plot_spectrum(run, axes, theory=theory, at=np.linspace(0.1, 4.5, 400))
    axes.set_title("no wall" if barrier is None else "elastic wall at the equilibrium", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")
panels[1].set_ylabel("")
plt.show()
