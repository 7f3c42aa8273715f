r"""
Where the energy goes
=====================

Every run sums the power of each part: what the noise feeds in, and what springpots, dampers, stops and
circuits take out. In the stationary state the two must be equal. This is a check of the simulation, and it is an
answer: here, how much of the power of the road a harvester in a car turns into electricity, and how much its stops
waste as the road becomes rougher.
"""

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

MASS = sp.Mass(0.05)  # kg
PARTS = {
    "spring": sp.Spring(500.0),  # N/m: 16 Hz
    "rubber": sp.Springpot(0.4, 3.0),  # N s^0.4/m
    "air": sp.PolynomialDashpot((0.0, 0.5)),  # N s^2/m^2, quadratic in the speed
    "coil": sp.PiezoelectricCircuit(coupling=0.002, resistance=2e5, capacitance=5e-8),  # N/V, ohm, F
    "lower": sp.Barrier(-0.002, restitution=0.5),  # m
    "upper": sp.Barrier(0.002, restitution=0.5, free_side="below"),
}
LOOK = {"circuit": "green", "rubber": "sky", "air": "purple", "stops": "vermilion"}

roads = np.array([1e-4, 1e-3, 3e-3, 1e-2, 3e-2])  # one-sided, in g^2/Hz
shares = {name: [] for name in LOOK}
for place, road in enumerate(roads):
    noise = sp.WhiteNoise.from_psd(road, "g2/Hz")
    run = sp.simulate(sp.System(MASS, road=noise, **PARTS), paths=1000, duration=3.0, window=(1.0, 3.0), seed=place)
    power = {name: found.value for name, found in run.estimates.items()}
    taken = {
        "circuit": power["harvested_power"], "rubber": power["damping_power"] - power["harvested_power"],
        "air": power["air_power"], "stops": power["lower_power"] + power["upper_power"],
    }  # fmt: skip
    for name, value in taken.items():
        shares[name].append(100.0 * value / power["input_power"])
    print(f"{road:.0e} g2/Hz: the road feeds in {1e3 * power['input_power']:.2f} mW, m q / 2 is "
          f"{500.0 * MASS.value * noise.intensity:.2f} mW; residual {100.0 * power['energy_residual']:.1f} +- "
          f"{100.0 * run['energy_residual'].error:.1f} %; {power['impact_rate']:.1f} impacts per second")  # fmt: skip

figure, axes = plt.subplots(figsize=(6.8, 4.4), layout="constrained")
bottom = np.zeros(len(roads))
for name, color in LOOK.items():
    axes.bar(np.arange(len(roads)), shares[name], 0.7, bottom, color=sp.figures.COLORS[color], label=name)
    bottom += shares[name]
axes.set_xticks(np.arange(len(roads)), [f"{road:g}" for road in roads])
axes.set(xlabel="spectral density of the road (g$^2$/Hz)", ylabel="share of the power fed in (%)", ylim=(0.0, 118.0))
axes.legend(frameon=False, ncols=4, loc="upper center")
plt.show()

# %%
# White noise feeds in the power :math:`mq/2`, whatever the parts are: the printed lines confirm it, and the residual of
# the balance differs from zero only by chance. On a smooth road the circuit and the rubber share the power in a fixed
# ratio. The air damps in proportion to the square of the speed, so its share grows. On a rough road the stops take the
# largest part, and a stiffer spring or a wider housing would pay.
