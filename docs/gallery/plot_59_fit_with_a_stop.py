r"""
Numbers of a device with a stop
===============================

A device of 0.8 kg on a rubber mount strikes a stop 6 mm away. At two levels of shaking six numbers were measured: how
far it moves, how often it strikes the stop, and how fast. ``springpot.fit`` simulates the model at many places. It
finds the order and the coefficient of the rubber, and the restitution of the stop, at which the simulated numbers agree
with the measured ones. There is no formula for them: the stop makes the motion nonlinear.

Here the measurement is a simulation of a device that is known, with errors of 1 %.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp


def device(psd, order, C, r):
    return sp.System(
        sp.Mass(0.8), sp.Spring(3200.0), sp.Springpot(order, C), sp.Barrier(-0.006, r),
        sp.WhiteNoise.from_psd(psd, "g2/Hz"),
    )  # fmt: skip


names = ["x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean", "impact_speed_mean_square"]
levels = [0.01, 0.04]  # g^2/Hz
random = np.random.default_rng(1)
cases = []
for psd in levels:
    run = sp.simulate(device(psd, 0.3, 150.0, 0.7), paths=5000, seed=11)
    true = {name: run[name].value for name in names}
    measured = {name: (true[name] * (1.0 + 0.01 * random.standard_normal()), 0.01 * abs(true[name])) for name in names}
    free = device(
        psd, sp.free("order", 0.5, (0.05, 0.95)), sp.free("C", 80.0, (5.0, 1000.0)), sp.free("r", 0.9, (0.3, 1.0))
    )
    cases.append((free, sp.MeasuredStatistics(**measured)))

fit = sp.fit(cases, seed=2)
print(fit.report())

# %%
# Each statistic, and below it the difference between measured and simulated, in standard errors.

figure = sp.figures.plot_fit(fit)
plt.show()
