r"""
A record with its measured input
================================

:doc:`The Silverbox </how_to/silverbox>` is a published experiment: a circuit that moves like a mass on a spring that
hardens, recorded with its input, in volts in place of newtons and metres. Its file is not ours. So a short record of
the same kind is simulated here, with the numbers that a fit of the file finds, and 0.2 mV of sensor noise.
``sp.fit`` finds the numbers again from 1500 samples. Two other pieces show what the model is worth: one at the same
level, and one whose input grows to twice that level.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

rng, n, step = np.random.default_rng(1), 1500, 2**14 / 1e7  # samples of a piece, and s between two
time, frequency = step * np.arange(3 * n), np.fft.rfftfreq(3 * n, step)
noise = np.fft.irfft((frequency < 200.0) * np.fft.rfft(rng.standard_normal(3 * n)))  # up to 200 Hz
u = 0.022 * noise / noise.std() * np.concatenate([np.ones(2 * n), np.linspace(0.0, 2.0, n)])  # V


def circuit(m, d, *k, drive=()):
    return sp.System(sp.Mass(m), sp.Dashpot(d), sp.PolynomialSpring(k), *drive)


drive = sp.RecordedExcitation(time, u, "mass", interpolation="band-limited")
true = circuit(5.376e-6, 2.2525e-4, 0.99067, -0.0248, 3.9156, drive=[drive])
how = {"paths": 1, "record": 1, "start": "rest", "duration": time[-1], "seed": 1}
y = sp.simulate(true, step=step / 40, record_every=40, **how).record[0, :, 0] + 2e-4 * rng.standard_normal(3 * n)  # V


def piece(number):
    own = slice(number * n, (number + 1) * n)
    return sp.MeasuredRecord(time[own], y[own], input=u[own], interpolation="band-limited", skip=50 * step)


m, d = sp.free("m", 7e-6, (1e-6, 3e-5)), sp.free("d", 3e-4, (1e-5, 1e-2))
k1, k2, k3 = sp.free("k1", 1.3, (0.2, 5.0)), sp.free("k2", 0.0, (-1.0, 1.0)), sp.free("k3", 2.0, (0.1, 50.0))
found = sp.fit(circuit(m, d, k1, k2, k3), piece(0))
print(found.report())
figure = sp.figures.plot_fit(found)
figure.axes[0].set_ylabel("output (V)")
plt.show()

# %%
# What is left is the noise of the sensor. A linear model leaves more than twenty times as much, and ``check()`` says
# that something is missing. It is worst where the motion is larger than in the piece that was fitted. Its stated error
# is only that of its numbers, and far too small for a model that is wrong.

linear = sp.fit(circuit(m, d, k1), piece(0))
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), sharey=True, layout="constrained")
left.plot(time[-n:], 1e3 * y[-n:], color="0.75")
right.plot(time[-45:], 1e3 * y[-45:], color="0.75", lw=4.0, label="measured")
for name, fit, color, style in (("linear", linear, "vermilion", "--"), ("hardening", found, "blue", "-")):
    print(f"{name}: {' '.join(fit.check().sentences) or 'passed'}")
    level, growing = fit.predict(piece(1)), fit.predict(piece(2))
    for kind, own in (("same level", level), ("growing", growing)):
        error = 1e3 * own.error.max()
        print(f"  {kind}: leaves {1e3 * own.left:.2f} mV, {own.share:.1%}; error by the numbers up to {error:.2f} mV")
    left.plot(growing.time, 1e3 * (growing.measured - growing.values)[0], color=sp.figures.COLORS[color], lw=1.0)
    predicted = 1e3 * growing.values[0, -45:]
    right.plot(time[-45:], predicted, style, color=sp.figures.COLORS[color], lw=1.4, label=f"{name} model")
left.set(xlabel="time (s)", ylabel="output (mV)", title="growing piece: what the models leave")
right.set(xlabel="time (s)", title="its end: what they predict")
figure.legend(loc="outside lower center", ncols=3, frameon=False)
plt.show()
