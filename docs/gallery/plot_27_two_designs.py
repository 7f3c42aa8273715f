r"""
Two designs on one plot
=======================

A soft and a stiff mount in front of the same wall, a gap of 0.5 m away. Each call with a ``label=`` is a design: Monte
Carlo and theory share its color, and its name is in the legend.
"""

import matplotlib.pyplot as plt

import springpot as sp

wall, noise = sp.Barrier(position=-0.5, restitution=0.8), sp.WhiteNoise(intensity=1.0)
designs = {
    "soft mount": sp.Oscillator(1.0, sp.Springpot(order=0.5, coefficient=0.4), wall, noise),
    "stiff mount": sp.Oscillator(1.6, sp.Springpot(order=0.3, coefficient=0.8), wall, noise),
}

figure, panels = plt.subplots(2, 1, figsize=(7.2, 7.6), layout="constrained")
for name, oscillator in designs.items():
    run = sp.simulate(oscillator, paths=4000, duration=100.0, step=0.02, distributions=True)
    envelope = sp.theory.envelope(oscillator)
    for quantity, axes in zip(("x", "impact_speed"), panels, strict=True):
        sp.figures.plot_density(run, quantity, axes, theory=envelope, label=name)
    rate, error = run["impact_rate"].value, run["impact_rate"].error
    fast = run.distributions["impact_speed"].quantile(0.99)[0]
    print(f"{name}: {rate:.4f} +- {error:.4f} impacts per second, one in a hundred faster than {fast:.2f} m/s")
for axes in panels:
    axes.legend(frameon=False)
plt.show()
