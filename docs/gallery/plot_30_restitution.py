r"""
A wall that takes energy
========================

Mean-square amplitude and impact rate against the restitution, by three methods and by Monte Carlo. Averaging
multiplies the amplitude by :math:`r` once in a half period, which is right for small losses only. Behind a lossy
wall many impacts are slow, so the impact rate rises steeply: below :math:`r = e^{-\pi/\sqrt 3} = 0.163` it is
infinite. At :math:`r \le 0.5` the rate of the simulation is a few per cent too low: its step misses the slowest
impacts, as the run's warning says.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp


def wall(restitution):
    return sp.Oscillator(springpot=sp.Springpot(0.5, 0.1), barrier=sp.Barrier(restitution=restitution))


runs = [
    sp.simulate(wall(r), paths=3000, step=0.01, start="stationary", duration=120.0, window=(60.0, 120.0))
    for r in (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
]
figure, (above, below) = plt.subplots(2, figsize=(6.8, 6.8), sharex=True)
for axes, quantity in ((above, "amplitude_mean_square"), (below, "impact_rate")):
    sp.figures.plot_against(
        "restitution", axes, quantity=quantity, system=wall(1.0), values=np.linspace(0.4, 1.0, 19),
        theory=[sp.theory.averaging, sp.theory.envelope, sp.theory.memory_closure], runs=runs,
    )  # fmt: skip
above.set(yscale="log", xlabel="")
above.minorticks_off()
above.set_yticks([2.0, 5.0, 10.0, 20.0], ["2", "5", "10", "20"])
above.legend(frameon=False)
plt.show()
