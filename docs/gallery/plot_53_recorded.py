r"""
A recorded shake, with friction and a stop
==========================================

``sp.RecordedExcitation`` takes any record of the ground's acceleration. The one here is made in the example: twenty
seconds of noise through a filter at 2.5 Hz, under an envelope that rises and dies out, with a largest acceleration of
some 3 m/s². A cabinet of 80 kg stands on rubber with a springpot, slides on a guide with dry friction, and has a bumper
30 mm away on one side. The run begins with the record, at rest; with a record alone every path is the same, so one
path is enough.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy import signal

import springpot as sp

rng = np.random.default_rng(7)
step = 0.01  # s
time = np.arange(0.0, 20.0, step)
band = signal.butter(2, (1.5, 4.0), "bandpass", fs=1.0 / step, output="sos")
filtered = signal.sosfilt(band, rng.normal(size=time.size))
shape = (time / 3.0) ** 2 * np.exp(2.0 - 2.0 * time / 3.0)
ground = 3.0 * shape * filtered / np.abs(shape * filtered).max()  # m/s^2


def cabinet(friction):
    return sp.System(
        sp.Mass(80.0), sp.Spring(1.2e4), sp.Springpot(order=0.25, coefficient=2.0e3), sp.Friction(friction),
        bumper=sp.Barrier(-0.03, restitution=0.5), shake=sp.RecordedExcitation(time, ground),
    )  # fmt: skip


frictions = {"without friction": 0.0, "30 N of friction": 30.0}
figure, panels = plt.subplots(3, 1, figsize=(7.2, 6.4), sharex=True, layout="constrained")
panels[0].plot(time, ground, color="0.3", linewidth=0.8)
panels[0].set_ylabel("ground (m/s²)")
for axes, (name, friction) in zip(panels[1:], frictions.items(), strict=True):
    run = sp.simulate(cabinet(friction), paths=1, record=1)
    sp.figures.plot_path(run, axes)
    axes.set(ylabel="$x$ (m)", xlabel="", title=name)
    taken = {part: run[f"{part}_power"].value * run.settings.duration for part in ("shake", "damping", "bumper")}
    print(f"{name}: fed in {taken['shake']:.2f} J, rubber {taken['damping']:.2f} J, bumper {taken['bumper']:.2f} J")
panels[2].set_xlabel("time $t$ (s)")
panels[1].legend(frameon=False, loc="upper right")
plt.show()
