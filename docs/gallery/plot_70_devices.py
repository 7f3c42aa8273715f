"""
Devices that differ
===================

No two mounts are alike: rubber has tolerances, and a gap is set by hand. Which of them matter for the number of
impacts, and how much likelier is a large displacement for a device that is drawn at random than for the nominal one?
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

device = sp.System(
    sp.Mass(0.8), sp.Spring(sp.uncertain("k", 3200.0, cov=0.05)),
    sp.Springpot(sp.uncertain("order", bounds=(0.28, 0.32)), sp.uncertain("C", 150.0, cov=0.10)),
    sp.Barrier(-sp.uncertain("gap", 0.006, sd=0.0006, bounds=(0.003, 0.009)), restitution=0.7),
    sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
)  # fmt: skip
scatter = sp.scatter(device, ["impact_rate"], devices=512, limits={"impact_rate": 3.0}, seed=1)
print(scatter.report())
picture = sp.figures.plot_scatter(scatter)
plt.show()

# %%
# A tighter gap is worth more than better rubber. For rare events the order may be another one. The dots are devices
# that exceeded 13 mm in two seconds; the larger a dot, the larger is its share in the probability over all devices.
rare = sp.exceedance_over_devices(device, {"x": [0.009, 0.011, 0.013]}, duration=2.0, start="rest", seed=1)
print(rare)
found = rare["x"]
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for values, errors, label, color in (
    (found.probability, found.error, "over devices", "#D55E00"),
    (found.nominal.probability, found.nominal.error, "nominal device", "#0072B2"),
):
    left.errorbar(1e3 * found.levels, values, 1.96 * errors, marker="o", capsize=3, label=label, color=color)
left.set(yscale="log", xlabel="x, mm", ylabel="probability in 2 s")
left.legend(frameon=False)
gap, stiffness = (found.draws[:, rare.numbers.index(name)] for name in ("gap", "k"))
right.scatter(1e3 * gap, stiffness, s=3.0, color="0.8")
right.scatter(1e3 * gap, stiffness, s=2e4 * found.shares, color="#D55E00", alpha=0.4)
right.set(xlabel="gap, mm", ylabel="stiffness, N/m", title="devices that exceed 13 mm, by their share")
plt.show()
print(f"{np.count_nonzero(found.shares)} of {found.shares.size} devices exceeded 13 mm")
