r"""
Self-excited motion at a wall
=============================

Flow past a cable, friction and a singing machine feed a motion while it is small and damp it when it is large: van der
Pol's damper :math:`\mu(x^2 - l^2)\dot x`. A viscoelastic support, here a springpot, damps at every size. Which of them
wins is seen in the density of the state: around one peak the mass is only shaken, around a ring (a crater) it
oscillates by itself. The change from one to the other is a bifurcation. A wall cuts the ring.

.. math:: \ddot x + \mu(x^2 - l^2)\,\dot x + C\,\mathrm{D}^{\alpha} x + x = \zeta(t), \qquad x \le 1.2
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp


def excited(coefficient):
    return sp.System(
        sp.Spring(1.0), sp.VanDerPol(0.4, length=1.0), sp.Springpot(0.6, coefficient),
        sp.Barrier(1.2, restitution=0.9, free_side="below"), sp.WhiteNoise(0.02),
    )  # fmt: skip


coefficients = (0.2, 0.35, 0.5, 0.8)
figure, panels = plt.subplots(1, len(coefficients), figsize=(10.4, 3.8), sharey=True, layout="constrained")
edges = np.linspace(-2.4, 1.2, 73), np.linspace(-2.4, 2.4, 97)
for axes, coefficient in zip(panels, coefficients, strict=True):
    run = sp.simulate(excited(coefficient), paths=1000, duration=200.0, step=0.04, record=1000, record_every=10)
    late = run.record[:, run.time > 100.0]
    density, *_ = np.histogram2d(late[..., 0].ravel(), late[..., 1].ravel(), bins=edges, density=True)
    picture = axes.pcolormesh(*edges, density.T, cmap="cividis", rasterized=True)
    axes.axvline(1.2, color=sp.figures.COLORS["vermilion"], lw=2.0)
    axes.set(title=f"$C$ = {coefficient:g}", xlabel="displacement $x$ (m)", aspect="equal", xlim=(-2.4, 1.4))
    axes.grid(visible=False)
    taken = {name: round(run[f"{name}_power"].value, 4) for name in ("van_der_pol", "damping", "barrier", "input")}
    print(f"C = {coefficient:g}: {run['impact_rate'].value:.3f} impacts per second; powers in m2/s3: {taken}")
panels[0].set_ylabel("velocity $v$ (m/s)")
plt.show()

# %%
# Bright is probable, with a scale of its own in each panel; the vermilion line is the wall. With a weak springpot the
# mass goes round a ring and strikes the wall in each turn; with a strong one it hardly moves. Between them the ring
# comes off the wall and closes: there the density has a flat top.
#
# A negative power of van der Pol's damper feeds the motion. Over the whole ring it is many times the power of the noise
# (``input``), and springpot (``damping``) and wall take it.
