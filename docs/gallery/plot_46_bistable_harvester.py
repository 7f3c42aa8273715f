r"""
A harvester with two wells and two stops
========================================

A magnet pushes a piezoelectric beam away from its middle, so that its tip rests in one of two wells, 3 mm to the left
or to the right. A housing with two rubber stops limits the motion. How much power does the circuit deliver, and does
the housing cost power?

.. math:: m\ddot x + c\,\dot x + k_1 x + k_3 x^3 + \theta V = -m\,a(t), \qquad
          C_p\dot V + V/R = \theta\,\dot x, \qquad P = V^2/R

The reference is the linear harvester with the stiffness that the beam has at the bottom of a well: without stops its
power is known exactly. The ground's noise is white, so it feeds in the power :math:`mq/2` whatever the springs are;
what differs is the part of it that the circuit takes.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

MASS = 0.010  # kg
WELL = 0.003  # m, from the middle to the bottom of a well
STIFFNESS = MASS * (2.0 * np.pi * 10.0) ** 2  # at the bottom of a well: 10 Hz, in N/m
GROUND = sp.WhiteNoise.from_psd(4e-4, "g2/Hz")


def circuit(resistance):
    return sp.PiezoelectricCircuit(coupling=5e-4, resistance=resistance, capacitance=50e-9)  # N/V, ohm, F


def bistable(resistance, gap):
    return sp.System(
        sp.Mass(MASS), sp.Spring(-STIFFNESS / 2.0), sp.PolynomialSpring((0.0, 0.0, STIFFNESS / (2.0 * WELL**2))),
        sp.Dashpot(0.02), circuit(resistance), GROUND,
        left=sp.Barrier(-gap, restitution=0.6), right=sp.Barrier(gap, restitution=0.6, free_side="below"),
    )  # fmt: skip


def linear(resistance):
    return sp.System(sp.Mass(MASS), sp.Spring(STIFFNESS), sp.Dashpot(0.02), circuit(resistance), GROUND)


measured, fine = np.geomspace(3e4, 3e6, 5), np.geomspace(2e4, 4e6, 40)
figure, axes = plt.subplots(figsize=(6.8, 4.6), layout="constrained")
for gap, color, marker in ((0.008, "blue", "o"), (0.004, "green", "^"), (0.0035, "vermilion", "s")):
    runs = [sp.simulate(bistable(R, gap), paths=1000, duration=6.0, step=5e-4, window=(2.0, 6.0)) for R in measured]
    power, error = 1e6 * np.array([(run["harvested_power"].value, run["harvested_power"].error) for run in runs]).T
    look = {"color": sp.figures.COLORS[color], "marker": marker, "size": 5.0}
    sp.figures.bars(axes, measured / 1e3, power, error, label=f"two wells, stops at {1e3 * gap:g} mm", **look)
    axes.plot(measured / 1e3, power, ":", color=look["color"], lw=0.8)
    best = runs[2]
    stops = best["left_power"].value + best["right_power"].value
    print(f"stops at {1e3 * gap:g} mm: {best['impact_rate'].value:.2f} impacts per second take {1e6 * stops:.1f} uW "
          f"of {1e6 * best['input_power'].value:.1f} uW")  # fmt: skip
axes.plot(fine / 1e3, [1e6 * sp.theory.linear(linear(R)).harvested_power for R in fine], "-", color="black", lw=1.4,
          label="linear, without stops: exact")  # fmt: skip
axes.axhline(1e6 * MASS * GROUND.intensity / 2.0, color="0.4", ls="--", lw=1.0, label="power of the ground")
axes.set(xscale="log", xlabel=r"load resistance $R$ (k$\Omega$)", ylabel=r"harvested power ($\mu$W)", ylim=(0.0, 148.0))
axes.legend(frameon=False, loc="upper left", ncols=2)
plt.show()

# %%
# Points are Monte Carlo with 95 % intervals, joined by dotted lines. Far stops cost nothing.
# At the best resistance two wells deliver hardly more than a linear spring: the ground feeds in the same power. At a
# large resistance they deliver clearly more, since the jumps between the wells are slow, and the circuit then takes
# power from slow motion better than from fast. Stops half a millimetre beyond the wells halve the power.
