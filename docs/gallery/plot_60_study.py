r"""
A study, from a file to a chart
===============================

A dict (or a TOML file, for ``springpot study run``) describes a grid of systems, which is computed by theory
and by Monte Carlo. With ``store=`` the results are saved: a study that was stopped continues where it was, and a
study with longer axes computes only what is new. The result is an xarray DataTree with ``theory`` and
``simulation``, units included.
"""

import matplotlib.pyplot as plt

import springpot as sp

tree = sp.study(
    {
        "name": "restitution and order",
        "methods": ["averaging", "envelope", "monte_carlo"],
        "quantities": ["amplitude_mean_square", "impact_rate"],
        "axes": {"order": {"linspace": [0.2, 1.0, 9]}, "restitution": [1.0, 0.9, 0.7]},
        "monte_carlo": {"rtol": 0.02},  # the total error of the quantities, at every point
    }
)
figure = sp.figures.plot_study(tree)
plt.show()

# %%
# Every number has its label, so questions are short. How far is the envelope's impact rate from Monte Carlo's, at most?

rate = tree["theory"]["impact_rate"].sel(theory="envelope")
gap = 100.0 * (rate / tree["simulation"]["impact_rate"] - 1.0)
print(gap.max("order").to_series().round(1))
