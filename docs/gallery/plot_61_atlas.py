r"""
Design charts from the atlas
============================

Only four numbers matter: the order, the strength :math:`c = C\,\Omega^{\alpha-2}`, the restitution and the position
of the wall in units of :math:`\sqrt{q/\Omega^3}`. So the whole stationary response was simulated once, and comes
with the library: ``sp.atlas`` interpolates in it in microseconds, and gives the half-width of the 95 % interval of
every number.
"""

import matplotlib.pyplot as plt

import springpot as sp

figure, panels = plt.subplots(4, 2, figsize=(10.4, 15.0), layout="constrained")
moments = (
    "amplitude_mean_square", "x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean",
    "impact_speed_mean_square",
)  # fmt: skip
for axes, moment in zip(panels.flat, moments, strict=False):
    sp.figures.plot_design_chart(moment, axes, restitution=0.7)
sp.figures.plot_design_chart("impact_rate", panels[3, 1], position=-1.0)
plt.show()

# %%
# A harvester with a stop half a length scale away, whose impacts return 0.64 of the energy:

found = sp.atlas(
    sp.Oscillator(
        natural_frequency=30.0,
        springpot=sp.Springpot(order=0.3, coefficient=100.0),
        barrier=sp.Barrier(position=-0.5 * (0.5 / 30.0**3) ** 0.5, restitution=0.8),
        excitation=sp.WhiteNoise(intensity=0.5),
    )
)
print(f"{found.impact_rate:.3f} +- {found.errors['impact_rate']:.3f} impacts per second")
print(f"at {found.impact_speed_mean:.4f} +- {found.errors['impact_speed_mean']:.4f} m/s on average")
