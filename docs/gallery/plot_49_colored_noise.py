r"""
When the impact rate has no value
=================================

White noise throws a mass off its wall again at once, so it can be counted how often the mass arrives (above a
restitution of 0.163). Colored noise is smoother. Pressed onto a lossy wall, the mass makes smaller and smaller hops
and comes to rest, after infinitely many impacts in a finite time: like a ball that bounces out. The impact rate is
infinite, and a program that counts finds a number that grows with every halving of its step. The energy that the wall
takes has a value, because the small impacts take almost nothing.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp


def pressed(restitution):
    """A wall at x = 0.2 holds the mass away from its equilibrium; the noise has a correlation time of 0.5 s."""
    return sp.System(
        sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.Barrier(0.2, restitution, free_side="above"),
        sp.ColoredNoise(1.0, correlation_time=0.5),
    )  # fmt: skip


print(sp.simulate(pressed(0.8), paths=200, duration=20.0, step=0.04).warnings[0])
steps = np.array([0.04, 0.02, 0.01, 0.005])
figure, (often, power) = plt.subplots(2, figsize=(6.8, 6.4), sharex=True, layout="constrained")
for restitution, color, marker in ((0.8, "vermilion", "s"), (1.0, "blue", "o")):
    runs = [
        sp.simulate(
            pressed(restitution), paths=1500, duration=60.0, step=step, window=(20.0, 60.0),
            impact_observables={"impacts": lambda speed: 1.0},
        )
        for step in steps
    ]  # fmt: skip
    look = {"color": sp.figures.COLORS[color], "marker": marker, "size": 5.0, "label": f"r = {restitution:g}"}
    for axes, name in ((often, "impacts"), (power, "barrier_power")):
        value, error = np.array([(run[name].value, run[name].error) for run in runs]).T
        sp.figures.bars(axes, steps, value, error, **look)
often.set(ylabel="impacts counted per second (1/s)", ylim=(0.0, None))
often.legend(frameon=False)
power.set(xscale="log", xlabel="time step (s)", ylabel="power that the wall takes (m$^2$/s$^3$)")
power.set_xticks(steps, [f"{step:g}" for step in steps], minor=False)
power.minorticks_off()
power.invert_xaxis()
plt.show()

# %%
# Points are Monte Carlo with 95 % intervals. Behind the lossy wall (r = 0.8) the number of impacts grows as the step
# becomes finer, and so does its error. The power that this wall takes does not change. Behind an elastic wall the rate
# has a value, and every step finds it.
#
# So ``sp.simulate`` gives NaN for the rate behind a lossy wall without white noise, with the warning printed above. The
# impacts were counted here by an observable of our own, ``{"impacts": lambda speed: 1.0}``. For wear, ask for a power
# of the impact speed: slow impacts then do not count, and the result has a value.
