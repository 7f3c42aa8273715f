r"""
First passage
=============

How long does it take until the amplitude first exceeds a level? The envelope gives the whole distribution of that
time; recorded paths show how accurate it is. The displacement first exceeds the same level later:
``first_passage={"x": level}`` takes its times from a run, without storing a path.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

oscillator = sp.Oscillator(
    springpot=sp.Springpot(order=0.5, coefficient=0.1), barrier=sp.Barrier(position=-1.0, restitution=0.9)
)
envelope = sp.theory.envelope(oscillator)
run = sp.simulate(oscillator, paths=2000, record=2000, duration=120.0, step=0.05, start="rest")
spread = np.sqrt(envelope.amplitude_mean_square)

figure, axes = plt.subplots(figsize=(6.6, 4.2))
for times, color in zip((1.0, 1.5, 2.0), ("blue", "vermilion", "green"), strict=True):
    level = round(times * spread, 2)
    before = len(axes.lines)
    sp.figures.plot_survival(run, level, axes, theory=envelope)
    for line in axes.lines[before:]:
        line.set_color(sp.figures.COLORS[color])
    axes.lines[-1].set_label(f"A < {level:g} m, mean time {envelope.first_passage(amplitude=level).mean_time:.0f} s")
axes.set_ylabel("probability that the level was not reached")
axes.legend(handles=[line for line in axes.lines if "mean time" in line.get_label()], frameon=False)
plt.show()

# %%
# Points: 2000 recorded paths with 95 % bars; lines: the envelope. At first the paths are later than the envelope: its
# amplitude diffuses from the first instant, but a path needs part of a cycle to move.

# %%
# Mean times of both, from one run. A run states how many paths have not passed when it ends, and what its mean assumes
# about them.
levels = {"x": round(2.0 * spread, 2), "amplitude": round(2.0 * spread, 2)}
watched = sp.simulate(oscillator, paths=4000, duration=400.0, step=0.05, start="rest", first_passage=levels)
for name, passage in watched.first_passages.items():
    mean, error, assumed = passage.mean
    print(f"{name} > {passage.level:g} m after {mean:.0f} +- {error:.0f} s on average. {assumed}")

# %%
# Several levels in one run, and how often they are passed. A list is levels, a pair such as ``(-0.4, 0.3)`` an interval
# that is left on either side. From some time on the rate of passages of the paths that are left is constant; a test on
# the passages decides from when. With this rate the run of five minutes tells the probability within hours: the bands
# are 95 % intervals, and beyond the vertical line the rate is assumed to go on. The highest level was never passed; it
# has an upper bound.
free = sp.Oscillator(springpot=sp.Springpot(0.5, 0.1), barrier=None, excitation=sp.WhiteNoise(0.14))
levels = [2.0, 3.0, 4.0, 5.0]
short = sp.simulate(free, paths=500, duration=300.0, step=0.05, start="rest", first_passage={"x": levels})
passages = short.first_passages["x"]
for passage in passages:
    print(f"{passage}\n    within an hour: {passage.probability(3600.0)}")
print(passages[1].probability(3600.0).statement)

figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), layout="constrained")
sp.figures.plot_passage_probability(passages, left, until=36_000.0)
sp.figures.plot_return_periods(passages, right)
sp.figures.plot_return_periods(sp.exceedance(free, {"x": [4.0, 5.0, 5.5]}, duration=60.0)["x"], right)
sp.figures.plot_return_periods(sp.theory.exceedance(free, {"x": np.linspace(1.5, 5.5, 15)})["x"], right)
plt.show()

# %%
# Right: ``sp.exceedance`` reaches by splitting what plain paths cannot. Rice's formula counts all crossings, also those
# that follow each other in one clump; Vanmarcke's corrects for the clumps, and the envelope diffuses from cycle to
# cycle.
