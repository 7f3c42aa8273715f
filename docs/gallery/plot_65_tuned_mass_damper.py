r"""
A tuned mass damper with a springpot
====================================

A small mass on a spring and a damper takes the energy of a frame that a white force shakes. For a dashpot and a frame
without damping of its own, Warburton (1982) has the spring and the damping of the least
:math:`\langle x_\text{frame}^2\rangle` in closed form: for the ratio :math:`\mu` of the masses, the damper's frequency
over that of the frame and its damping ratio are

.. math:: f = \frac{\sqrt{1 + \mu/2}}{1 + \mu}, \qquad
          \zeta^2 = \frac{\mu\,(1 + 3\mu/4)}{4\,(1 + \mu)(1 + \mu/2)}.

Real dampers are often of rubber, a springpot of an order below 1. ``springpot.design`` finds the spring and the
springpot of each order. The system is linear, so the search is on the exact theory, and Monte Carlo verifies where it
ends.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp
from springpot.figures import COLORS

MU = 0.05
ON_THE_FRAME = {"between": ("frame", "damper")}
F = np.sqrt(1.0 + MU / 2.0) / (1.0 + MU)
ZETA = np.sqrt(MU * (1.0 + 0.75 * MU) / (4.0 * (1.0 + MU) * (1.0 + MU / 2.0)))
STIFFNESS, DASHPOT = MU * F**2, 2.0 * ZETA * F * MU  # by Warburton, for a frame of 1 kg and 1 N/m


def with_damper(order, stiffness, coefficient):
    return sp.System(
        sp.Mass(1.0, at="frame"), sp.Spring(1.0, between=("ground", "frame")), sp.WhiteNoise(1.0, on="frame"),
        sp.Mass(MU, at="damper"), tuning=sp.Spring(stiffness, **ON_THE_FRAME),
        pot=sp.Springpot(order, coefficient, **ON_THE_FRAME),
    )  # fmt: skip


def designed(order):
    """The spring and the springpot of the least motion of the frame."""
    model = with_damper(
        order,
        sp.free("k", STIFFNESS, (0.1 * STIFFNESS, 1.2 * STIFFNESS)),
        sp.free("c", DASHPOT, (0.5 * DASHPOT, 5.0 * DASHPOT)),
    )
    return sp.design(model, minimize="frame_x_mean_square", method="linear", rtol=0.1)


classical = sp.theory.linear(with_damper(1.0, STIFFNESS, DASHPOT)).frame_x_mean_square
orders = np.array([1.0, 0.8, 0.6, 0.4, 0.2])
found = [designed(order) for order in orders]
for order, one in zip(orders, found, strict=True):
    best = sp.theory.linear(one.model).frame_x_mean_square
    print(f"order {order}: {one.values}, {100 * (best / classical - 1):+.2f} %")
print(f"Warburton: k = {STIFFNESS:.6f}, c = {DASHPOT:.6f}, <x^2> = {classical:.6f}")
free = sp.design(
    with_damper(sp.free("order", 0.5, (0.1, 1.0)), sp.free("k", 0.03, (0.1 * STIFFNESS, STIFFNESS)),
                sp.free("c", 0.02, (0.5 * DASHPOT, 5.0 * DASHPOT))),
    minimize="frame_x_mean_square", method="linear", rtol=0.1,
)  # fmt: skip
print("the order free too:", free.values)

# %%
# The gain of the best damper is small, and the loss of one that is not tuned again is large: a springpot is also a
# spring. The dashed curve keeps Warburton's spring, and gives the springpot the loss of his dashpot at the frame's
# frequency.


def over_classical(system):
    """In per cent."""
    return 100.0 * (sp.theory.linear(system).frame_x_mean_square / classical - 1.0)


fine = np.linspace(0.2, 1.0, 17)
kept = [over_classical(with_damper(a, STIFFNESS, DASHPOT / np.sin(0.5 * np.pi * a))) for a in fine]
figure, (gain, tuning) = plt.subplots(2, sharex=True, figsize=(6.4, 6.6), layout="constrained")
gain.axhline(0.0, color=COLORS["black"], linewidth=0.8)
gain.plot(fine, kept, "--", color=COLORS["vermilion"], label="Warburton's spring kept")
gain.plot(orders, [over_classical(one.model) for one in found], "o-", color=COLORS["blue"], label="spring designed")
gain.plot([free.values["order"]], [over_classical(free.model)], "*", color=COLORS["black"], markersize=12,
          label="order designed too")  # fmt: skip
gain.set(ylabel=r"$\langle x_\mathrm{frame}^2\rangle$ over Warburton's (%)", ylim=(-5.0, 30.0))
gain.legend(frameon=False)

springs = np.array([one.values["k"] for one in found])
pots = np.array([one.values["c"] * np.cos(0.5 * np.pi * a) for a, one in zip(orders, found, strict=True)])
tuning.axhline(F, color=COLORS["vermilion"], linestyle="--", label="Warburton")
tuning.plot(orders, np.sqrt((springs + pots) / MU), "s-", color=COLORS["green"], label="spring and springpot together")
tuning.plot(orders, np.sqrt(springs / MU), "o-", color=COLORS["blue"], label="spring alone")
tuning.set(xlabel="order of the springpot (1: dashpot)", ylabel="damper's frequency over the frame's (1)",
           ylim=(0.5, 1.05))  # fmt: skip
tuning.legend(frameon=False, loc="lower right")
plt.show()

# %%
# An order below 1 gains up to 2.3 %, at orders of 0.2 to 0.3. What matters is the complex stiffness near the frame's
# frequency: with the springpot's own stiffness the damper's frequency is at most 0.7 % above Warburton's, while the
# spring alone is tuned ever lower, to 56 % of his frequency at order 0.2. A rubber that replaces the dashpot beside an
# unchanged spring costs 23 % at order 0.6, and 46 % at 0.5.
