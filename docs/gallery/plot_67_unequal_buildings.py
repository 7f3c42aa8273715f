r"""
Two unequal buildings that pound each other
===========================================

Two buildings stand a gap apart, of 200 t and 0.6 s of period, and of 400 t and 1 s. One ground shakes both, and they
strike each other because they swing out of step. Under a stationary noise with the Kanai-Tajimi spectrum the rate of
impacts is counted from 5 cm/s on: a smooth acceleration lets the buildings come to rest against each other after
infinitely many small impacts.

:doc:`Two equal buildings <plot_41_pounding>` are one oscillator of their distance, but only if each is shaken by a
ground of its own: on the same ground they would never meet. That shortcut is drawn beside, with the mean period of the
two buildings.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy import signal

import springpot as sp
from springpot.figures import COLORS, bars

OLD, NEW = 2.0 * np.pi / 0.6, 2.0 * np.pi / 1.0  # rad/s
DAMPING, RESTITUTION = 0.05, 0.65
SOIL = {"frequency": 15.0, "damping": 0.6}
INTENSITY = 0.02  # m^2/s^3


def building(mass, frequency, name):
    ends = {"between": ("ground", name)}
    return (
        sp.Mass(mass, at=name), sp.Spring(mass * frequency**2, **ends),
        sp.Dashpot(2.0 * DAMPING * mass * frequency, **ends),
    )  # fmt: skip


def pair(gap, shaking):  # new stands on the + side of old: the stop is at -gap of new's displacement less old's
    stop = sp.Barrier(-gap, RESTITUTION, between=("old", "new"))
    return sp.System(*building(2e5, OLD, "old"), *building(4e5, NEW, "new"), shaking, gap=stop)


def shortcut(gap):
    mean = np.sqrt(OLD * NEW)
    return sp.System(
        sp.Spring(mean**2), sp.Dashpot(2.0 * DAMPING * mean), gap=sp.Barrier(-gap, RESTITUTION),
        both=sp.KanaiTajimiNoise(**SOIL, intensity=2.0 * INTENSITY, on="ground"),  # the difference of two grounds
    )  # fmt: skip


def rates(system_of):
    runs = [
        sp.simulate(system_of(gap), paths=1000, duration=40.0, window=(20.0, 40.0), slowest_counted_impact=0.05)
        for gap in gaps
    ]
    found = [run["counted_impact_rate"] for run in runs]
    return np.array([each.value for each in found]), np.array([each.error for each in found])


gaps = np.array([0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08])
noise = sp.KanaiTajimiNoise(**SOIL, intensity=INTENSITY, on="ground")
unequal, errors = rates(lambda gap: pair(gap, noise))
equal, errors_of_equal = rates(shortcut)
for gap, one, other in zip(gaps, unequal, equal, strict=True):
    print(f"gap {100 * gap:.0f} cm: {one:.3f} impacts per second, by the shortcut {other:.3f}")

# %%
# A record has a beginning and an end, and one path: the impacts in it are a number. This one is made here, 20 s of
# filtered noise under an envelope.

rng = np.random.default_rng(7)
time = np.arange(0.0, 20.0, 0.01)
band = signal.butter(2, (0.5, 4.0), "bandpass", fs=100.0, output="sos")
shape = (time / 4.0) ** 2 * np.exp(2.0 - 2.0 * time / 4.0)
ground = shape * signal.sosfilt(band, rng.normal(size=time.size))
record = sp.RecordedExcitation(time, 2.5 * ground / np.abs(ground).max(), on="ground")  # m/s^2

narrow = np.linspace(0.005, 0.11, 43)
runs = [sp.simulate(pair(gap, record), paths=1, slowest_counted_impact=0.05) for gap in narrow]
impacts = np.array([run["counted_impact_rate"].value * run.settings.duration for run in runs])
taken = np.array([run["gap_power"].value * run.settings.duration for run in runs])

figure, (often, once) = plt.subplots(2, sharex=True, figsize=(6.6, 6.6), layout="constrained")
bars(often, 100 * gaps, unequal, errors, size=4.0, color=COLORS["blue"], label="two unequal buildings, one ground")
bars(often, 100 * gaps, equal, errors_of_equal, size=4.0, color=COLORS["vermilion"], marker="s",
     label="shortcut: equal buildings, two grounds")  # fmt: skip
often.set(ylabel="impacts per second", yscale="log", title="Kanai-Tajimi noise", ylim=(1e-3, 3.0))
often.legend(frameon=False)
once.step(100 * narrow, impacts, where="mid", color=COLORS["blue"], label="impacts")
once.set(xlabel="gap (cm)", ylabel="impacts in 20 s", title="a record", ylim=(0.0, None))
energy = once.twinx()
energy.plot(100 * narrow, 1e-3 * taken, "--", color=COLORS["green"], label="energy taken")
energy.set(ylabel="energy taken by the impacts (kJ)", ylim=(0.0, None))
once.legend(*map(sum, zip(once.get_legend_handles_labels(), energy.get_legend_handles_labels(), strict=True), ([], [])),
            frameon=False)  # fmt: skip
plt.show()

# %%
# Up to a gap of 2 cm the shortcut has the rate within 3 %. At 6 cm it has 0.045 impacts per second and not 0.082, and
# at 8 cm a third. In the record there is no impact from a gap of 10.4 cm on; the energy that the impacts take falls
# more slowly than their number, because a wider gap is struck harder.
