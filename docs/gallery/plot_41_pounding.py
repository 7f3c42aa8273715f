r"""
Two structures that pound each other
====================================

Two equal buildings, each a mass on a spring with viscoelastic dampers (a springpot of order 0.6), stand a gap apart
and are shaken independently. Subtract their equations: the relative displacement :math:`u = x_1 - x_2` obeys

.. math:: \ddot u + C\,\mathrm{D}^\alpha u + \Omega^2 u = \zeta_1 - \zeta_2, \qquad
          \dot u_+ = -r\,\dot u_- \quad\text{at } u = -\text{gap},

since an impact of equal masses keeps their common motion and reverses the relative one. So this is one oscillator
with a wall at minus the gap and with the noise of both, :math:`q = q_1 + q_2`: nothing is neglected. (With the same
ground motion equal buildings never collide; unequal buildings are a system of two masses.)
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

FREQUENCY = 2.0 * np.pi  # one second of period
DAMPING = 0.05  # of critical, at that frequency
ORDER = 0.6
COEFFICIENT = 2.0 * DAMPING * FREQUENCY ** (2.0 - ORDER) / np.sin(ORDER * np.pi / 2.0)
INTENSITY = 2 * 0.02  # of both grounds, in m^2/s^3


def pair(gap):
    return sp.Oscillator(
        FREQUENCY, sp.Springpot(ORDER, COEFFICIENT), sp.Barrier(-gap, restitution=0.65), sp.WhiteNoise(INTENSITY)
    )


gaps = np.array([0.0, 0.02, 0.04, 0.06, 0.08, 0.10])
runs = [
    sp.simulate(pair(gap), paths=3000, step=0.005, duration=60.0, window=(30.0, 60.0), distributions=True)
    for gap in gaps
]
figure, (often, hard) = plt.subplots(2, figsize=(6.8, 6.6), sharex=True)
sp.figures.plot_against(
    "position", often, quantity="impact_rate", system=pair(0.0), values=-np.linspace(0.0, 0.11, 23),
    theory=[sp.theory.envelope], runs=runs,
)  # fmt: skip
often.set_xlabel("")
often.legend(frameon=False)
for share, color in ((0.5, "blue"), (0.95, "vermilion"), (0.99, "green")):
    value, error = np.array([run.distributions["impact_speed"].quantile(share) for run in runs]).T
    look = {"color": sp.figures.COLORS[color], "size": 4.0}
    sp.figures.bars(hard, -gaps, value, error, label=f"{share:.0%} are slower", **look)
hard.set(xlabel="position of the wall, minus the gap (m)", ylabel="impact speed (m/s)", ylim=(0.0, None))
hard.legend(frameon=False)
plt.show()

# %%
# A wider gap makes impacts rarer but harder: fewer impacts take energy from the motion.
