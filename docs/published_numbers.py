"""Published numbers beside springpot's: each function computes those of one source, for the page and its test."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import optimize

import springpot as sp
from springpot.theory.spectral_fatigue import damage_rates


@dataclass(frozen=True)
class Row:
    """A published number, springpot's, and by how much they may differ, as a share of the published one.

    That is half a unit of the published number's last digit, or the deviation that the page explains.
    """

    quantity: str
    published: float
    here: float
    within: float

    @property
    def difference(self) -> float:
        return self.here / self.published - 1.0


def sdld101() -> list[Row]:
    m, k = 100.0, 1e6
    ground = sp.SpectralExcitation.from_psd((1e-6, 100.0), 1.0, "m2/s4/Hz", sides=2, on="ground")
    system = sp.System(sp.Mass(m), sp.Spring(k), sp.Dashpot(2 * 0.05 * math.sqrt(k * m)), ground)
    response = sp.theory.linear(system)
    f = np.array([5.0, 10.0, 15.0, 20.0, 25.0])
    per_hz = 2 * np.pi  # from a two-sided density per rad/s to a two-sided one per Hz
    absolute = per_hz * response.spectrum(2 * np.pi * f, of="acceleration")
    relative = per_hz * response.spectrum(2 * np.pi * f) * (2 * np.pi * f) ** 4
    l0, l1, l2, l3, l4 = response.spectral_moments(range(5), of="acceleration").values()
    rows = [
        Row(f"density of {name} acceleration, {at:g} Hz", theirs, ours, 1e-4)
        for name, all_theirs, all_ours in (
            ("absolute", (1.2307, 2.7116, 47.2154, 2.8924, 0.47047), absolute),
            ("relative", (0.011976, 0.42096, 36.9225, 7.1006, 2.7953), relative),
        )
        for at, theirs, ours in zip(f, all_theirs, all_ours, strict=True)
    ]
    return [
        *rows,
        Row("spectral moment 0", 505.70832, l0, 2e-3),
        Row("spectral moment 1", 49047.8, l1, 2e-3),
        Row("spectral moment 2", 5.025066e6, l2, 2e-3),
        Row("spectral moment 3", 5.52943e8, l3, 2e-3),
        Row("spectral moment 4", 7.2046e10, l4, 2e-3),
        Row("rms (m/s2)", 22.48796, math.sqrt(l0), 1e-3),
        Row("passages of zero (1/s)", 31.73006, math.sqrt(l2 / l0) / math.pi, 1e-3),
        Row("extrema (1/s)", 38.11766, math.sqrt(l4 / l2) / math.pi, 1e-3),
        Row("irregularity", 0.83242414, l2 / math.sqrt(l0 * l4), 1e-3),
    ]


def sdld23() -> list[Row]:
    names = [f"m{n}" for n in range(1, 9)]
    ends = [("ground", "m1"), *itertools.pairwise(names), ("ground", "m8")]
    chain = sp.System(
        *(sp.Mass(10.0, at=name) for name in names),
        *(sp.Spring(1e5, between=pair) for pair in ends),
        *(sp.Dashpot(50.0, between=pair) for pair in ends),
        sp.SpectralExcitation.from_psd((3.0, 13.0), 1.0, "N2/Hz", sides=2, on="m4"),
    )
    l0, l2, l4 = sp.theory.linear(chain).spectral_moments((0, 2, 4), of="m4").values()
    return [
        Row("rms of the fourth (m)", 5.63035e-4, math.sqrt(l0), 1e-3),
        Row("spectral moment 2 (m2/s2)", 3.803552e-4, l2, 1e-3),
        Row("passages of zero (1/s)", 11.025786, math.sqrt(l2 / l0) / math.pi, 1e-3),
        Row("extrema (1/s)", 11.121516, math.sqrt(l4 / l2) / math.pi, 1e-3),
        Row("irregularity", 0.99139238, l2 / math.sqrt(l0 * l4), 1e-3),
    ]


M, K, STOP = 100.0, 1e4, 1e6  # kg, N/m, N/m
STEP = 1e-5  # s


def sdnd101() -> list[Row]:
    stop = sp.Contact(0.0, STOP, exponent=1.0, free_side="below")
    system = sp.System(sp.Mass(M), sp.Spring(K), stop, sp.WhiteNoise(0.0))
    run = sp.simulate(system, paths=1, record=1, step=STEP, duration=0.4, initial_velocity=1.0)
    t, force = run.time, STOP * np.maximum(run.record[0, :, 0], 0.0)
    first, second = t < 0.2, t >= 0.2
    touching = t[second & (force > 0.0)]
    impulse = STEP * force[second].sum()
    return [
        Row("first contact, largest force (N)", 9950.0, force[first].max(), 1e-4),
        Row("at (s)", 0.01563, t[force[first].argmax()], 4e-4),
        Row("second contact, largest force (N)", 9950.372, force[second].max(), 1e-6),
        Row("at (s)", 0.361, t[second][force[second].argmax()], 2e-4),
        Row("it lasts (s)", 0.03126, touching[-1] - touching[0] + STEP, 4e-4),
        Row("its impulse (N s)", 198.05, impulse, 2e-4),
        Row("its impulse, closed form (N s)", 198.0198, impulse, 1e-6),
    ]


def sdnd102() -> list[Row]:
    gap = 0.004  # m
    pair = sp.System(
        *(sp.Mass(M, at=name) for name in "ab"),
        *(sp.Spring(K, between=("ground", name)) for name in "ab"),
        sp.Contact(-gap, STOP, exponent=1.0, between=("a", "b")),
        sp.WhiteNoise(0.0, on="a"),
    )
    alone = sp.System(
        sp.Mass(M), sp.Spring(K), sp.Contact(0.5 * gap, 2 * STOP, exponent=1.0, free_side="below"), sp.WhiteNoise(0.0)
    )
    asked = {"paths": 1, "record": 1, "step": STEP, "duration": 0.5}
    both = sp.simulate(pair, initial_velocity={"a": 1.0, "b": -1.0}, **asked).record[0, :, 0, 0]
    one = sp.simulate(alone, initial_velocity=1.0, **asked).record[0, :, 0]
    return [
        Row("largest x of one of two, over that of one (1)", 1.0, both.max() / one.max(), 1e-9),
        Row("largest deviation of the paths, over x + 1 (1)", 1.0, 1.0 + np.abs(both - one).max() / one.max(), 1e-9),
    ]


def szlz106() -> list[Row]:
    zero, two, four = 182.5984664, 96098024.76, 6.346193569e13
    moments = {0.0: zero, 2.0: two, 4.0: four} | dict.fromkeys((0.75, 1.0, 1.5), 1.0)  # these are of other formulas
    return [
        Row(f"narrow band, exponent {k:g}", theirs, a * damage_rates(moments, k)["narrow_band"], within)
        for k, a, theirs, within in (
            (4.065, 1.001730939e-14, 3.851827e-7, 2e-5),
            (4.065, 1.001730939e-14, 3.851777e-7, 2e-7),
            (5.0, 32e-13, 3.129527e-3, 2e-5),
            (5.0, 32e-13, 3.129484e-3, 2e-7),
        )
    ]


def _slopes(size: Callable[[np.ndarray], np.ndarray], order: float, w0: float, log_w: float) -> np.ndarray:
    """The first three derivatives of the logarithm of a size of the response by that of the frequency."""
    h = 0.02 * np.arange(-3, 4)
    system = sp.System(sp.Spring(w0**2), sp.Springpot(order, 1.0), sp.WhiteNoise(1.0))
    found = np.log(size(sp.theory.linear(system).frequency_response(np.exp(log_w + h))))
    return np.polynomial.Polynomial.fit(h, found, 6).convert(domain=[-1, 1]).coef[1:4]


def _loss(response: np.ndarray) -> np.ndarray:
    return -response.imag


def burov() -> list[Row]:
    weak = 1e-3  # w0, where the springpot alone has the frequency 1
    resonance = optimize.root(lambda p: _slopes(np.abs, p[0], weak, p[1])[:2], (0.44, -0.3)).x[0]
    second = optimize.root(lambda p: _slopes(_loss, p[0], weak, p[1])[:2], (0.52, -0.3)).x[0]
    merged = optimize.root(lambda p: _slopes(_loss, p[0], p[1], p[2]), (0.70, 0.47, -0.8)).x[0]

    def lowest(order: float) -> float:  # of the place of a free mass after a kick, where it comes back
        kicked = sp.System(sp.Springpot(order, 1.0), sp.WhiteNoise(0.0))
        run = sp.simulate(kicked, paths=1, record=1, step=2e-3, duration=10.0, initial_velocity=1.0)
        return float(run.record[0, run.time > 2.0, 0].min())

    turns = optimize.brentq(lowest, 0.39, 0.42, xtol=1e-5)
    return [
        Row("free motion is monotonic for weak springs above", 0.402, turns, 0.002 / 0.402),
        Row("a resonance for every w0 below", 0.441, resonance, 0.001 / 0.441),
        Row("two peaks of the loss for every weak spring below", 0.527, second, 0.001 / 0.527),
        Row("two peaks of the loss for some springs up to", 0.707, merged, 0.001 / 0.707),
    ]


def _highest(beam: sp.System, force: float) -> tuple[float, float]:
    """Frequency in Hz and largest density in mm2/Hz at the middle, from a force per length as that of the ground."""
    noise = sp.SpectralExcitation.from_psd((1.0, 1000.0), force**2, "m2/s4/Hz", on="ground")
    response = sp.theory.linear(sp.System(*beam.parts, noise))

    def density(f: float) -> float:
        return 1e6 * 4 * np.pi * float(response.spectrum(2 * np.pi * f, of="middle"))

    top = optimize.minimize_scalar(lambda f: -density(f), bounds=(38.0, 50.0), method="bounded").x
    return float(top), density(top)


def nafems_5r() -> list[Row]:
    length, side, e, nu, rho = 10.0, 2.0, 2e11, 0.3, 8000.0
    per_length, inertia = rho * side**2, side**4 / 12
    mass, ei = per_length * length, e * inertia
    euler = sp.beam(length, ei, mass, {"middle": 5.0}, kind="simply supported", modes=8, damping_ratios=0.02)
    # Timoshenko's modes between supports are sines too, with a rotation of their own (Cowper's share of the area)
    n = np.arange(1, 9)
    wave, shear = n * np.pi / length, 10 * (1 + nu) / (12 + 11 * nu) * e / (2 * (1 + nu))
    a, b = rho**2 * inertia / shear, per_length + rho * inertia * (1 + e / shear) * wave**2
    square = (b - np.sqrt(b**2 - 4 * a * ei * wave**4)) / (2 * a)
    turned = wave - square * rho / (shear * wave)  # of the cross section, over the deflection
    modal = (per_length + rho * inertia * turned**2) * length / 2
    pushed = per_length * np.where(n % 2 == 1, 2 / wave, 0.0)
    deep = sp.System.from_modes(np.sqrt(square), modal, {"middle": np.sin(wave * 5.0)}, 0.02, pushed / modal)
    own = np.sqrt(square[0]) / (2 * np.pi)
    (f_euler, top_euler), (_, top_deep) = (_highest(beam, 1e6 / per_length) for beam in (euler, deep))
    return [
        Row("Euler: first frequency (Hz)", 42.65, f_euler / math.sqrt(1 - 2 * 0.02**2), 0.07),
        Row("Euler: largest density (mm2/Hz)", 180.90, top_euler, 0.18),
        Row("Timoshenko's modes: first frequency (Hz)", 42.65, own, 1.2e-4),
        Row("Timoshenko's modes: largest density (mm2/Hz)", 180.90, top_deep, 0.01),
    ]


def flife() -> list[Row]:
    m, k = 100.0, 1e6
    ground = sp.SpectralExcitation.from_psd((1e-6, 100.0), 1.0, "m2/s4/Hz", sides=2, on="ground")
    system = sp.System(sp.Mass(m), sp.Spring(k), sp.Dashpot(2 * 0.05 * math.sqrt(k * m)), ground)
    found = sp.theory.fatigue(system, sp.Basquin(5.0, stress=1e4)).damage
    theirs = {
        "narrow_band": 1663681246.80,
        "alpha_075": 1610294386.63,
        "tovo_benasciutti": 1527227406.33,
        "wirsching_light": 1271561878.21,
        "dirlik": 1617798354.80,
    }  # 1 / life in s by FLife 2.3 from 100 001 lines, 0 to 100 Hz; Tovo and Benasciutti's second method
    return [Row(name.replace("_", " "), number, found[name] / 3600.0, 1e-7) for name, number in theirs.items()]


SOURCES = (sdld101, sdld23, sdnd101, sdnd102, szlz106, burov, nafems_5r, flife)


def show(rows: list[Row]) -> None:
    """Print a table; a number that differs by more than is said is an error."""
    print(f"{'':50}  {'published':>13}  {'springpot':>13}  {'difference':>10}")
    for row in rows:
        print(f"{row.quantity:50}  {row.published:>13.9g}  {row.here:>13.9g}  {row.difference:>+10.1e}")
        assert abs(row.difference) <= row.within, row
