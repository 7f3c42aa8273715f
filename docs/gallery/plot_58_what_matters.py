r"""
Which numbers matter
====================

An oscillator of order 0.5 above a lossy wall: by how many per cent does each result change if one of its numbers is
changed by one per cent? ``springpot.sensitivity`` gives d ln(result) / d ln(number), by theory and by Monte Carlo. By
Monte Carlo both sides of each difference have the same random numbers, which makes the errors smaller.

A stronger spring gives more impacts, a higher restitution gives larger speeds; the order and the coefficient of the
springpot hardly change the impact rate. To measure them, look at speeds, not at the rate.
"""

import matplotlib.pyplot as plt

import springpot as sp

oscillator = sp.Oscillator(2.0, sp.Springpot(0.5, 0.4), sp.Barrier(-0.3, 0.8), sp.WhiteNoise(3.0))
results = ["impact_rate", "v_mean_square", "x_mean"]
by_theory = sp.sensitivity(oscillator, results, method="envelope")
by_chance = sp.sensitivity(oscillator, results, method="monte_carlo", paths=1000)
print(by_chance.report())

figure = sp.figures.plot_sensitivities(by_theory, by_chance)
plt.show()
