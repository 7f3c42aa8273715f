"""Fatigue damage from spectra, against rainflow counts of long simulations, and what the formulas refuse."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.theory.spectral_fatigue import ORDERS, damage_rates


def test_light_damping_under_white_noise() -> None:
    system = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
    # rainflow counts of 960 000 time units: rate, its standard error, and how much the formulas are above it, in %
    for k, counted, error, above in (
        (3.0, 0.5822, 0.0007, (2.8, -0.7, 0.0)), (5.0, 2.849, 0.018, (5.0, 1.4, 2.1)),
        (8.0, 56.6, 1.3, (8.0, 4.0, 5.0)),
    ):  # fmt: skip
        found = sp.theory.fatigue(system, sp.Basquin(k))
        assert found.crossing_rate == pytest.approx(0.5 / math.pi, rel=1e-7)
        assert [*found.damage] == ["narrow_band", "alpha_075", "tovo_benasciutti"]  # x'' is white: there is no m_4
        assert math.isinf(found.peak_rate)
        for rate, percent in zip(found.damage.values(), above, strict=True):
            assert 100.0 * (rate / 3600.0 / counted - 1.0) == pytest.approx(percent, abs=100.0 * error / counted + 0.06)


def test_two_modes_under_a_smooth_force() -> None:
    def density(w: float) -> float:
        p = 1j * w
        response = 1.0 / (1.0 + 0.1 * p - w**2) + 8.0 / (16.0 + 0.4 * p - w**2)
        return 0.16 / (1.0 + 0.01 * w**2) / math.pi * abs(response) ** 2

    ends = np.array([0.0, 0.9, 1.1, 3.7, 4.3, 20.0, 1e3, 1e5])
    moments = {
        order: sum(
            integrate.quad(lambda w, order=order: density(w) * w**order, low, high, limit=2000)[0]
            for low, high in pairwise(ends)
        )
        + density(1e5) * 1e5 ** (order + 1.0) / (5.0 - order)
        for order in ORDERS
    }
    assert moments[0.0] == pytest.approx(1.491998, rel=1e-6)
    assert moments[2.0] == pytest.approx(11.36658, rel=1e-6)
    for k, counted, above in (
        (3.0, 2.412, (24.8, -5.1, -1.9, 3.7, -3.9)), (5.0, 17.45, (28.7, -2.2, -9.5, -2.1, -4.5)),
        (8.0, 640.0, (30.6, -0.7, -13.2, -13.5, -3.6)),
    ):  # fmt: skip
        found = damage_rates(moments, k)
        assert [100.0 * (rate / counted - 1.0) for rate in found.values()] == pytest.approx(above, abs=0.06)


def test_units_of_the_curve() -> None:
    system = sp.System(sp.Mass(2.0), sp.Spring(50.0), sp.Springpot(0.5, 1.0), sp.ColoredNoise(4.0, 0.1))
    curve = sp.Basquin(4.0, strength=0.5, cycles=80.0, stress=3.0)
    plain, scaled = sp.theory.fatigue(system, sp.Basquin(4.0)), sp.theory.fatigue(system, curve, "x")
    assert scaled.damage["dirlik"] == pytest.approx(plain.damage["dirlik"] * 3.0**4 / 5.0)
    assert scaled.life["dirlik"] == pytest.approx(1.0 / scaled.damage["dirlik"])
    assert plain.moments[0.0] == pytest.approx(sp.theory.linear(system).x_mean_square, rel=1e-8)
    assert plain.moments[2.0] == pytest.approx(sp.theory.linear(system).v_mean_square, rel=1e-8)
    assert plain.peak_rate > plain.crossing_rate


def test_an_elongation_of_several_masses() -> None:
    pair = sp.System(
        sp.Mass(1.0, at="panel"), sp.Mass(0.1, at="box"), sp.Spring(100.0, between=("ground", "panel")),
        sp.Dashpot(1.0, between=("ground", "panel")), sp.Spring(30.0, between=("panel", "box")),
        mount=sp.Springpot(0.3, 5.0, between=("panel", "box")), shaker=sp.WhiteNoise(1.0, on="panel"),
    )  # fmt: skip
    linear = sp.theory.linear(pair)
    found = sp.theory.fatigue(pair, sp.Basquin(3.0), "mount_elongation")
    assert found.moments[0.0] == pytest.approx(linear.panel_box_elongation_mean_square, rel=1e-7)
    with pytest.raises(ValueError, match=r"^of must be one of .*mount"):
        sp.theory.fatigue(pair, sp.Basquin(3.0), "mont_elongation")


def test_forces_have_the_moments_of_their_spectra() -> None:
    mount, noise = sp.Springpot(0.3, 2.0), sp.ColoredNoise(1.0, 0.2, on="ground")
    system = sp.System(sp.Mass(2.0), sp.Spring(8.0), noise, mount=mount)
    linear = sp.theory.linear(system)
    for name in ("mount_force", "force_on_ground", "acceleration"):
        found = sp.theory.fatigue(system, sp.Basquin(3.0), name)
        assert found.moments[0.0] == pytest.approx(linear.mean_square(name), rel=1e-7)


@pytest.mark.parametrize(
    ("parts", "of", "words"),
    [
        ((sp.Spring(1.0), sp.Dashpot(0.1), sp.Harmonic(1.0, 2.0)), "", "Gaussian"),
        ((sp.Spring(1.0), sp.Dashpot(0.1), sp.PoissonImpulses(1.0, 2.0)), "", "poisson"),
        ((sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(1.0), sp.Barrier(0.0)), "", "barrier"),
        (
            (sp.Spring(1.0), sp.Springpot(0.5, 0.1), sp.WhiteNoise(1.0)),
            "springpot_force",
            "crosses its mean infinitely",
        ),
        ((sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(1.0)), "velocity", "of must be one of"),
    ],
)
def test_what_is_refused(parts: tuple[object, ...], of: str, words: str) -> None:
    with pytest.raises((NotCoveredError, ValueError), match=words):
        sp.theory.fatigue(sp.System(*parts), sp.Basquin(3.0), of)
    with pytest.raises(sp.theory.NoStationaryStateError):
        sp.theory.fatigue(sp.System(sp.Dashpot(1.0), sp.WhiteNoise(1.0)), sp.Basquin(3.0))
    with pytest.raises(TypeError, match=r"^curve must be a Basquin curve, such as"):
        sp.theory.fatigue(sp.System(*parts), 3.0)
