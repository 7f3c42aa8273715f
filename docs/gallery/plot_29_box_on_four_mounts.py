r"""
A box on four mounts, tested from 10 to 2000 Hz
===============================================

A box of 2.5 kg on four equal mounts has stops 4 mm away on both sides. The test is 0.02 g²/Hz, flat from 10 to 2000 Hz.
White noise of the same density is easier to state, but it also has what lies below 10 Hz, and the box on its mounts
moves at 15 Hz. How many impacts does it add?

The second answer shares no code with the library: a sum of 2000 sinusoids with random amplitudes, an Euler step, and
the memory of the rubber as a sum of exponentials, in NumPy alone.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

mass, k, C, order = 2.5, 2967.0, 965.8, 0.25  # kg, and of one mount N/m and N s^0.25/m
parts = {
    "mass": sp.Mass(mass),
    "spring": sp.Spring(k, count=4),
    "rubber": sp.Springpot(order, C, count=4),
    "lower": sp.Barrier(-4e-3, 0.6),
    "upper": sp.Barrier(4e-3, 0.6, free_side="below"),
}
band = sp.System(**parts, shake=sp.SpectralExcitation.from_psd((10, 2000), 0.02, "g2/Hz"))
white = sp.System(**parts, shake=sp.WhiteNoise.from_psd(0.02, "g2/Hz"))
speeds = np.array([0.02, 0.1, 0.2, 0.3, 0.4])


def per_minute(system):
    found = []
    for slowest in speeds:
        run = sp.simulate(
            system, paths=8192, duration=3.0, window=(1.0, 3.0), start="rest", seed=1, slowest_counted_impact=slowest
        )
        found.append((60.0 * run["counted_impact_rate"].value, 60.0 * run["counted_impact_rate"].error))
    return np.array(found).T


# %%
# The sinusoids: 3 s with steps of 0.2 ms, of which the first second is left out. Each of the 2000 lies in its own bin
# of equal width on a logarithmic scale. The force of the rubber is :math:`\int s^{\alpha - 1} e^{-st} ds`, by the
# trapezoidal rule over :math:`\log s`.
def of_sinusoids(paths=2048, lines=2000, h=2e-4, seconds=3.0, first=1.0):
    rng = np.random.default_rng(3)
    edges = np.geomspace(10.0, 2000.0, lines + 1)
    w = 2.0 * np.pi * (edges[:-1] + rng.random(lines) * np.diff(edges))
    size = 9.80665 * np.sqrt(0.02 * np.diff(edges)) * np.sinc(w * h / (2.0 * np.pi))
    amplitudes = (np.tile(size, 2)[:, None] * rng.standard_normal((2 * lines, paths))).astype(np.float32)
    u = np.arange(math.log(0.02), math.log(3.0 / h), 0.5)
    scale = 4.0 * C / mass / (math.gamma(order) * math.gamma(1.0 - order))
    weight, rate = 0.5 * scale * np.exp(order * u), np.exp(u)[:, None]
    stiff = 4.0 * k / mass + scale * math.exp(order * (u[0] - 0.25)) / order
    damper = scale * math.exp((order - 1.0) * (u[-1] + 0.25)) / (1.0 - order)
    decay = np.exp(-rate * h)
    gain = (1.0 - decay) / (rate * h)
    x, v, z = np.zeros(paths), np.zeros(paths), np.zeros((u.size, paths))
    counts = np.zeros((speeds.size, paths))
    for begin in range(0, round(seconds / h), 500):
        angle = np.outer((begin + np.arange(500) + 0.5) * h, w)
        for push in np.hstack([np.cos(angle), np.sin(angle)]).astype(np.float32) @ amplitudes:
            v = v - h * (push + stiff * x + damper * v + weight @ z)
            after = x + h * v
            struck = np.abs(after) > 4e-3
            if begin * h >= first:
                counts += struck & (np.abs(v) > speeds[:, None])
            after = np.where(struck, np.sign(after) * (4e-3 - 0.6 * (np.abs(after) - 4e-3)), after)
            v = np.where(struck, -0.6 * v, v)
            z, x = decay * z + gain * (after - x), after
    counts *= 60.0 / (seconds - first)
    return counts.mean(axis=1), counts.std(axis=1) / math.sqrt(paths)


answers = {
    "springpot, 10 to 2000 Hz": per_minute(band), "springpot, white": per_minute(white),
    "2000 sinusoids in NumPy": of_sinusoids(),
}  # fmt: skip
for name, (value, error) in answers.items():
    print(f"{name}: {value[0]:.1f} +- {error[0]:.1f} impacts per minute faster than 2 cm/s")

# %%
# Bars are 95 % intervals.
figure, axes = plt.subplots(figsize=(6.6, 4.2))
for marker, (name, (value, error)) in zip(("o-", "s--", "kx"), answers.items(), strict=True):
    axes.errorbar(speeds, value, 1.96 * np.array(error), fmt=marker, capsize=3, label=name)
axes.set(yscale="log", xlabel="impact speed (m/s)", ylabel="faster impacts per minute")
axes.legend(frameon=False)
plt.show()
