r"""
Boltzmann's law at any order
============================

Whatever takes energy at a temperature also gives energy back, as noise. A springpot at the temperature :math:`T` has
the noise of correlation :math:`kT\,C\,t^{-\alpha}/\Gamma(1-\alpha)`: the same function of time as its memory. With
this noise, and elastic walls, the density of x and v is Boltzmann's, :math:`\exp(-H/kT)`. The order and the strength
of the springpot do not matter.

Here the spring has two wells, and an elastic wall stands on the left.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

KT = 0.4  # per unit mass, in m^2/s^2
LOOK = ((0.3, "blue", "o"), (0.5, "green", "^"), (0.7, "vermilion", "s"))


def tested(order):
    return sp.System(
        sp.Spring(-1.0), sp.PolynomialSpring((0.0, 0.2, 1.0)), sp.Springpot(order, 1.0), sp.Barrier(-1.2),
        sp.ThermalNoise(KT),
    )  # fmt: skip


exact = sp.theory.exact(tested(0.5))
x = np.linspace(-1.2, 2.0, 400)
figure, (above, below) = plt.subplots(2, figsize=(6.8, 6.6), layout="constrained", height_ratios=(3, 2))
above.plot(x, exact.x_density(x), color="black", lw=1.2, label="Boltzmann's law")
names = {
    "x_mean_square": r"$\langle x^2\rangle$", "v_mean_square": r"$\langle v^2\rangle$", "impact_rate": "impact rate"
}  # fmt: skip
for place, (order, color, marker) in enumerate(LOOK):
    run = sp.simulate(tested(order), paths=8000, duration=40.0, step=0.03, window=(0.0, 40.0), seed=place + 1,
                 distributions=True)  # fmt: skip
    look = {"color": sp.figures.COLORS[color], "marker": marker}
    edges, density, error = run.distributions["x"].density(bins=40)
    sp.figures.bars(above, 0.5 * (edges[1:] + edges[:-1]), density, error, size=3.5, label=f"order {order:g}", **look)
    known = [getattr(exact, name) for name in names]
    ratio, error = np.array([(run[name].value, run[name].error) for name in names]).T / known
    sp.figures.bars(below, np.arange(3) + 0.15 * (place - 1), ratio, error, size=5.0, **look)
above.set(xlabel="displacement $x$ (m)", ylabel="density of $x$ (1/m)", ylim=(0.0, None))
above.legend(frameon=False)
below.axhline(1.0, color="black", lw=1.2)
below.set_xticks(np.arange(3), names.values())
below.set_ylabel("Monte Carlo / Boltzmann's law")
plt.show()

# %%
# Points are Monte Carlo with 95 % intervals: all three orders follow the same law. A run with thermal noise draws x and
# v at time 0 from Boltzmann's law, and the noise from its stationary law. So it is stationary from the beginning, and
# the window is the whole run.
#
# This is a strict test of a simulation: any error of memory, noise or impacts would heat or cool the mass.
