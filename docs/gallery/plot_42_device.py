r"""
A device from its data sheet to the answers
===========================================

An instrument of 0.8 kg stands on a spring of 3200 N/m and a rubber mount: a springpot of order 0.3 with
:math:`k_\alpha = 150\;\mathrm{N\,s^{0.3}/m}`. The base is shaken with 0.01 g²/Hz. A stop 6 mm below takes 30 % of the
speed of each impact. A test engineer asks:

1. What is the rms of the displacement?
2. How many impacts are there per second?
3. Which impact speed do 99 % of the impacts not exceed?
4. How long does it take on average until x first exceeds 10 mm?

All inputs are in SI units, except the spectral density: :doc:`/device` has every factor.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

device = sp.Oscillator.from_device(
    mass=0.8, stiffness=3200.0, springpot=(0.3, 150.0), gap=0.006, restitution=0.7, psd=0.01, psd_unit="g2/Hz"
)
run = sp.simulate(device, paths=8000, record=1, distributions=True, seed=1)

rms = run["x_mean_square"].value ** 0.5
rms_error = run["x_mean_square"].error / (2.0 * rms)  # the derivative of the square root
fast, fast_error = run.distributions["impact_speed"].quantile(0.99)
print(f"1. rms displacement: {1e3 * rms:.3f} +- {1e3 * rms_error:.3f} mm")
print(f"2. impacts per second: {run['impact_rate'].value:.2f} +- {run['impact_rate'].error:.2f}")
print(f"3. 99 % of the impacts are slower than {fast:.3f} +- {fast_error:.3f} m/s")

watched = sp.simulate(
    device, paths=2000, duration=20.0, window=(2.0, 20.0), first_passage={"x": 0.010, "amplitude": 0.010}
)
wait, wait_error, assumption = watched.first_passages["x"].mean
print(f"4. mean time until x > 10 mm: {wait:.1f} +- {wait_error:.1f} s")
print(f"   {assumption}")

envelope = sp.theory.envelope(device)
print(f"theory (envelope): {1e3 * envelope.x_mean_square**0.5:.3f} mm, {envelope.impact_rate:.2f} impacts per second")

figure, (above, middle, below) = plt.subplots(3, figsize=(7.2, 9.0))
sp.figures.plot_path(run, above)
sp.figures.plot_density(run, "impact_speed", middle, theory=[envelope])
middle.axvline(fast, color="0.4", ls="--", lw=1.0, label="99 % are slower")
middle.legend(frameon=False)
time = np.linspace(0.0, 17.0, 18)
for quantity, color in (("x", "blue"), ("amplitude", "vermilion")):
    share, error = watched.first_passages[quantity].survival(time)
    sp.figures.bars(below, time, share, error, color=sp.figures.COLORS[color], label=f"{quantity}, Monte Carlo, 95 %")
below.set(xlabel="time (s)", ylabel="probability of less than 10 mm", ylim=(0.0, 1.02))
below.legend(frameon=False)
plt.show()

# %%
# The numbers after +- are standard errors. Theory takes milliseconds, so use it to search for a design, and Monte Carlo
# to confirm the design that you found.
#
# The last picture shows why the quantity must be named. The amplitude :math:`\sqrt{x^2 + \dot x^2/w^2}`, with the
# resonance :math:`w` of spring and springpot, also passes the level with a large velocity, and near the stop, so it
# passes 10 mm much earlier than x does.
