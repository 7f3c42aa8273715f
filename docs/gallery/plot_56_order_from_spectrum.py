r"""
What a spectrum can and cannot tell about the order
===================================================

Two oscillators with a springpot of order 0.5, seen through the spectral density of x. In the first the springpot is
strong; its order shows in the shape of the spectrum far from the resonance. In the second it is weak. Its resonance is
narrow, and only two things of the springpot matter: what it adds to the stiffness and to the damping at the natural
frequency. With the stiffness free too, order and coefficient cannot be told apart. The fit says so, and the profile of
the order has no limits.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

order, k = sp.free("order", 0.4, (0.02, 0.98)), sp.free("k", 3.5, (1.0, 10.0))
q = sp.free("q", 0.7, (0.01, 100.0))
figure, panels = plt.subplots(2, 2, figsize=(7.4, 5.6), layout="constrained")
for row, coefficient in zip(panels, (2.0, 0.1), strict=True):
    true = sp.System(sp.Spring(4.0), sp.Springpot(0.5, coefficient), sp.WhiteNoise(1.0))
    frequency = np.linspace(0.01, 1.5, 150)
    exact = 4.0 * np.pi * sp.theory.linear(true).spectrum(2.0 * np.pi * frequency)  # one-sided, per Hz
    averages = 100
    density = exact * np.random.default_rng(1).gamma(averages, 1.0 / averages, frequency.size)
    C = sp.free("C", 1.5 * coefficient, (1e-3, 1e2))
    model = sp.System(sp.Spring(k), sp.Springpot(order, C), sp.WhiteNoise(q))
    found = sp.fit(model, sp.MeasuredSpectrum(frequency, density, averages))
    print(found.report(), end="\n\n")
    row[0].semilogy(frequency, density, ".", markersize=3)
    row[0].semilogy(frequency, found.table.fitted, color="black", linewidth=1.0)
    row[0].set(xlabel="frequency (Hz)", ylabel="density of $x$ (m²/Hz)", title=f"C = {coefficient:g}")
    sp.figures.plot_profile(found.profile("order", points=15), row[1])
plt.show()
