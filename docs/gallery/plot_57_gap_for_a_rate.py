r"""
A gap chosen for an impact rate
===============================

A relay's armature of 20 g on a spring of 800 N/m has a stop beside it, and rubber, a springpot. In a vehicle it is
shaken at 0.02 g²/Hz. The stop is to be as close as possible, but must be struck less than twice a second.
``springpot.design`` finds the gap: theory is searched, Monte Carlo corrects it and says with which probability the
limit holds. The curve shows what another limit would cost.
"""

import matplotlib.pyplot as plt

import springpot as sp

gap = sp.free("gap", 1.5e-3, (2e-4, 8e-3))  # m
armature = sp.System(
    sp.Mass(0.02), sp.Spring(800.0), sp.Springpot(0.4, 3.0),
    sp.Barrier(gap, free_side="below"), sp.WhiteNoise.from_psd(0.02, "g2/Hz"),
)  # fmt: skip
found = sp.design(armature, minimize="gap", subject_to={"impact_rate": (None, 2.0)})
print(found.report())

# %%
# The least gap against the limit of the rate. The square is the design, with the 95 % interval of Monte Carlo.

axes = sp.figures.plot_design_curve(found.curve(limits=[0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 6.0]), found)
figure = axes.figure
plt.show()
