r"""
Energy along a chain of six masses that strike each other
=========================================================

Six equal masses hang on springs between two frames, with a springpot beside each spring. White noise pushes the first
mass, and fifty times weaker the others. The gap between neighbours is 1 m, about as large as the motion of the springs,
so the masses strike each other, and the outer ones the frames.

Two questions: how much of the energy reaches the other end, and where the impacts take it.
"""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp

LOOKS = ("blue", "o"), ("vermilion", "s"), ("green", "^")
MASSES = [f"m{number}" for number in range(1, 7)]
LINKS = [("ground", "m1"), *pairwise(MASSES), ("m6", "ground")]
WALLS = [f"wall_{number}" for number in range(1, 8)]


def chain(restitution=None):
    parts = [sp.Mass(1.0, at=name) for name in MASSES]
    for link in LINKS:
        parts += [sp.Spring(1.0, between=link), sp.Springpot(0.5, 0.05, between=link)]
    walls = {}
    if restitution is not None:
        walls = {
            wall: sp.Barrier(-1.0, restitution=restitution, between=link)
            for wall, link in zip(WALLS, LINKS, strict=True)
        }
    noise = [sp.WhiteNoise(1.0 if name == "m1" else 0.02, on=name) for name in MASSES]
    return sp.System(*parts, *noise, **walls)


linear = sp.theory.linear(chain())
runs = {r: sp.simulate(chain(r), paths=1000, duration=800.0, window=(450.0, 800.0), seed=1) for r in (1.0, 0.9, 0.7)}

place = np.arange(1, 7)
figure, (energy, lost) = plt.subplots(2, figsize=(6.4, 6.8), layout="constrained")
energy.plot(place, [0.5 * getattr(linear, f"{m}_v_mean_square") for m in MASSES], "k--", label="no walls, theory")
for r, (color, mark) in zip(runs, LOOKS, strict=False):
    found, color = runs[r], sp.figures.COLORS[color]
    energies = np.array([0.5 * found[f"{m}_v_mean_square"].value for m in MASSES])
    errors = np.array([0.5 * found[f"{m}_v_mean_square"].error for m in MASSES])
    energy.errorbar(place, energies, 1.96 * errors, color=color, marker=mark, label=f"restitution {r:g}, 95 %")
    if r < 1.0:
        power = 0.01 * found["input_power"].value  # one per cent
        taken = [found[f"{wall}_power"].value / power for wall in WALLS]
        errors = [1.96 * found[f"{wall}_power"].error / power for wall in WALLS]
        lost.errorbar(np.arange(0.5, 7.0), taken, errors, color=color, marker=mark, label=f"restitution {r:g}, 95 %")
    print(f"restitution {r:g}: energy residual {found['energy_residual']}")
energy.set(xlabel="mass", ylabel="mean kinetic energy (J)", ylim=(0.0, 2.2))
energy.legend(frameon=False, ncols=2, loc="upper right")
lost.set(xlabel="place of the wall, between the masses of these numbers")
lost.set(ylabel="taken by the wall (% of the input)", ylim=(0.0, None))
lost.legend(frameon=False)
plt.show()

# %%
# Without walls the energy is a sum over the chain's own modes, which are spread over all of it. Elastic walls raise it
# and make it more even: an impact takes no energy, and the masses have less time to stretch the springpots. Lossy walls
# let it fall along the chain, and most of it is lost near the mass that is pushed.
