r"""
Densities: Monte Carlo and theory
=================================

Displacement, velocity, amplitude :math:`A = \sqrt{x^2 + \dot x^2/\Omega^2}` and impact speed. The run itself
collects the histograms; the curves are those of every method that has one.
"""

import matplotlib.pyplot as plt

import springpot as sp

oscillator = sp.Oscillator(springpot=sp.Springpot(order=0.5, coefficient=1.0), barrier=sp.Barrier(-0.5, 0.8))
run = sp.simulate(oscillator, paths=4000, duration=100.0, step=0.02, start="stationary", distributions=True)
answers, statements = sp.theory.solve_all(oscillator)

figure, panels = plt.subplots(2, 2, figsize=(8.4, 6.6))
for quantity, axes in zip(("x", "v", "amplitude", "impact_speed"), panels.flat, strict=True):
    sp.figures.plot_density(run, quantity, axes, theory=answers.values())
panels[0, 0].legend(frameon=False, fontsize="small")
plt.show()

# %%
# The validity map, which holds their deviations from Monte Carlo, shows which method to trust:

print("recommended:", sp.recommended(oscillator, answers))
print("no result:", statements["averaging"])
