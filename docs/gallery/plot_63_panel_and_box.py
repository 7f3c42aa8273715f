r"""
An instrument on a panel, with a stop
=====================================

A box of 0.4 kg stands on a rubber mount (a spring and a springpot), on a panel of 5 kg on which a random pressure acts.
A stop limits how near the box comes to the panel. Both masses move, so the system has two points, and each part says
between which of them it acts. Displacements are relative to the frame, the ground.

Without the stop the system is linear, and theory has the transmissibility of the mount, the motion of the box over
that of the panel, :math:`\lvert H_\text{box}(\omega) / H_\text{panel}(\omega)\rvert`. With the stop it is simulated.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

FRAME, MOUNT = {"between": ("ground", "panel")}, {"between": ("panel", "box")}
LINEAR = sp.System(
    sp.Mass(5.0, at="panel"), sp.Spring(8e4, **FRAME), sp.Dashpot(60.0, **FRAME), sp.Mass(0.4, at="box"),
    sp.Spring(900.0, **MOUNT), sp.Springpot(0.3, 150.0, **MOUNT),
    sp.WhiteNoise.from_psd(30.0, "N2/Hz", on="panel"),
)  # fmt: skip


def simulated(gap):
    stop = sp.Barrier(-gap, restitution=0.7, **MOUNT)
    return sp.simulate(
        sp.System(*LINEAR.parts, stop=stop), paths=300, duration=16.0, window=(4.0, 16.0), record=1, seed=1
    )


linear = sp.theory.linear(LINEAR)
gaps = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])  # mm
runs = [simulated(1e-3 * gap) for gap in gaps]
run, free = runs[1], 1e3 * linear.panel_box_elongation_mean_square**0.5
print("natural frequencies in Hz", sp.theory.modes(LINEAR).frequencies / (2.0 * np.pi))
print(f"between panel and box, without the stop: {free:.2f} mm rms")
print("with a gap of 2 mm:", run["panel_box_elongation_mean_square"], "and impacts", run["stop_impact_rate"])

figure, (across, path, wide) = plt.subplots(3, figsize=(6.8, 8.4), layout="constrained")
hertz = np.linspace(1.0, 50.0, 400)
w = 2.0 * np.pi * hertz
box, panel = (linear.frequency_response(w, of=point, on="panel") for point in ("box", "panel"))
across.semilogy(hertz, np.abs(box / panel), label="theory, without the stop")
across.axhline(1.0, color="0.6", linewidth=0.8)
across.set(xlabel="frequency (Hz)", ylabel="box over panel (1)")
across.legend(frameon=False)

sp.figures.plot_path(run, path, of="stop", window=(5.0, 7.0))
path.axhspan(-1e-3 * free, 1e-3 * free, color="0.9", zorder=0, label="rms without the stop")
path.set(ylabel="from panel to box (m)", ylim=(-0.003, 0.02))
path.legend(frameon=False, loc="upper right", ncols=3)

squares = [one["panel_box_elongation_mean_square"] for one in runs]
rms = np.array([each.value**0.5 for each in squares])
errors = np.array([0.5 * each.error / each.value**0.5 for each in squares])
wide.axhline(free, color="0.5", linestyle="--", label="theory, without the stop")
sp.figures.bars(wide, gaps, 1e3 * rms, 1e3 * errors, size=4.0, label="Monte Carlo, 95 %")
wide.set(xlabel="gap (mm)", ylabel="rms from panel to box (mm)", ylim=(0.0, None))
wide.legend(frameon=False)
plt.show()

# %%
# The mount isolates the box above 13 Hz. The stop does not reduce the motion but increases it: the panel moves at
# 20 Hz, is faster than the box, and throws it at each impact. Here the gap must be so wide that impacts are rare.
