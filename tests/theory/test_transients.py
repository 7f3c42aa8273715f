"""Mean squares in time of linear systems with noise that has an envelope."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp
from tests.sizes import validation

ENVELOPE = sp.ExponentialEnvelope(slow=0.2, fast=0.6)
TIMES = [2.0, 4.0, 6.0, 10.0, 15.0, 25.0]
TABLE: dict[Any, Any] = {
    sp.Dashpot(0.3): (
        (0.26371, 0.97190, 1.03921, 0.60221, 0.18627, 0.012009),
        (0.45841, 0.87978, 0.98970, 0.57838, 0.18671, 0.011971),
    ),
    sp.Springpot(0.5, 0.3): (
        (0.287488, 0.983336, 1.16063, 0.778170, 0.334260, 0.0436884),
        (0.503350, 1.12468, 1.31143, 0.959328, 0.405130, 0.0544311),
    ),
}


@pytest.mark.parametrize("damper", TABLE, ids=lambda damper: type(damper).__name__)
def test_white_noise_against_other_programs(damper: Any) -> None:
    found = sp.theory.transient(sp.System(sp.Spring(1.0), damper, sp.WhiteNoise(1.0, envelope=ENVELOPE)), TIMES)
    x, v = (np.array(column) for column in TABLE[damper])
    assert found.x_mean_square == pytest.approx(x, rel=5e-4)
    assert found.v_mean_square == pytest.approx(v, rel=5e-4)


@pytest.mark.parametrize(
    "noise",
    [sp.WhiteNoise(2.0), sp.KanaiTajimiNoise(6.0, 0.4, 1.0), sp.CloughPenzienNoise(6.0, 0.4, 0.6, 0.5, 1.0)],
    ids=lambda noise: type(noise).__name__,
)
def test_without_an_envelope_it_ends_in_the_stationary_state(noise: Any) -> None:
    system = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Springpot(0.5, 0.6), sp.Dashpot(0.1), noise)
    found, stationary = sp.theory.transient(system, 400.0), sp.theory.linear(system)
    assert float(found.x_mean_square) == pytest.approx(stationary.x_mean_square, rel=3e-4)
    assert float(found.v_mean_square) == pytest.approx(stationary.v_mean_square, rel=3e-4)


FALLING = sp.KanaiTajimiNoise(6.0, 0.4, 1.0, on="mass", frequency_rate=-0.2, envelope=ENVELOPE)


def test_ground_whose_frequency_falls_against_another_program() -> None:
    found = sp.theory.transient(sp.System(sp.Spring(4.0), sp.Dashpot(0.2), FALLING), TIMES)
    x, v = (
        (0.12108, 0.33799, 0.41904, 0.31967, 0.15098, 0.023911),
        (0.53312, 1.44829, 1.74141, 1.29292, 0.60747, 0.095492),
    )
    assert found.x_mean_square == pytest.approx(x, rel=5e-4)
    assert found.v_mean_square == pytest.approx(v, rel=5e-4)


ENDS = ("ground", "a"), ("a", "b"), ("ground", "b")
PAIR = (
    sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"), sp.Spring(4.0, between=ENDS[0]), sp.Spring(3.0, between=ENDS[1]),
    sp.Springpot(0.4, 0.6, between=ENDS[0]), sp.Maxwell(1.0, 2.0, between=ENDS[2]),
    sp.FractionalMaxwell(sp.Springpot(0.6, 1.0), sp.Spring(2.0), between=ENDS[1]),
    sp.PiezoelectricCircuit(0.5, 1.0, 0.4, between=ENDS[1]),
)  # fmt: skip


@pytest.mark.parametrize(
    "noise",
    [
        sp.ColoredNoise(1.0, 0.3, on="b"), sp.PoissonImpulses(0.5, 2.0, on="ground"),
        sp.SpectralExcitation((0.05, 0.2, 3.0), (0.5, 1.0, 0.1), on="ground"),
        validation(sp.CloughPenzienNoise(6.0, 0.4, 0.6, 0.5, 1.0)),
    ],
    ids=lambda noise: type(noise).__name__,
)  # fmt: skip
def test_several_masses_with_every_memory_end_in_the_stationary_state(noise: Any) -> None:
    system = sp.System(*PAIR, noise)
    found, stationary = sp.theory.transient(system, [0.0, 150.0]), sp.theory.linear(system)
    assert [*found.numbers] == [
        "a_x_mean_square", "a_v_mean_square", "b_x_mean_square", "b_v_mean_square", "a_b_elongation_mean_square"
    ]  # fmt: skip
    for name, (start, end) in found.numbers.items():
        assert start == 0.0
        assert end == pytest.approx(stationary.numbers[name], rel=3e-4)


def test_a_given_density_with_an_envelope_against_the_double_integral() -> None:
    """<x^2> = int int h(t - s) h(t - u) e(s) e(u) R(s - u), of a dashpot and a flat band, whose R is known."""
    band = sp.SpectralExcitation((0.1, 0.6), (2.0, 2.0), envelope=sp.JenningsHousnerEnvelope(2.0, 4.0, 0.4))
    found = sp.theory.transient(sp.System(sp.Spring(4.0), sp.Dashpot(0.4), band), [1.5, 5.0, 9.0])
    turn = np.sqrt(4.0 - 0.04)
    for n, time in enumerate(found.time):
        s, step = np.linspace(0.0, time, 901, retstep=True)
        weight = np.full(s.size, step)
        weight[[0, -1]] *= 0.5
        lag = np.where(s[:, None] == s, 1e-9, s[:, None] - s)
        own = 2.0 * (np.sin(2.0 * np.pi * 0.6 * lag) - np.sin(2.0 * np.pi * 0.1 * lag)) / (2.0 * np.pi * lag)
        fading = np.exp(-0.2 * (time - s))
        h, away = fading * np.sin(turn * (time - s)) / turn, turn * (time - s)
        slope = fading * (np.cos(away) - 0.2 / turn * np.sin(away))
        for values, exact in ((h, found.x_mean_square[n]), (slope, found.v_mean_square[n])):
            shown = values * band.envelope.at(s) * weight
            assert exact == pytest.approx(shown @ own @ shown, rel=2e-4)


def test_strong_damping_and_noises_together() -> None:
    parts = sp.Spring(1.0), sp.Dashpot(5.0)
    noises = sp.WhiteNoise(1.0, envelope=ENVELOPE), sp.ColoredNoise(1.0, 0.3)
    together = sp.theory.transient(sp.System(*parts, *noises), TIMES)
    alone = [sp.theory.transient(sp.System(*parts, noise), TIMES) for noise in noises]
    assert together.x_mean_square == pytest.approx(sum(one.x_mean_square for one in alone), rel=1e-6)
    late = sp.theory.transient(sp.System(*parts, sp.WhiteNoise(1.0)), 60.0)
    assert float(late.x_mean_square) == pytest.approx(0.1, rel=1e-4)
    with pytest.raises(AttributeError, match="a transient has no 'impact_rate'"):
        _ = late.impact_rate


def test_a_factor_of_the_envelope_is_its_square() -> None:
    small, large = (
        sp.theory.transient(
            sp.System(
                sp.Spring(1.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0, envelope=sp.ExponentialEnvelope(0.2, 0.6, peak))
            ),
            [3.0],
        )
        for peak in (1.0, 3.0)
    )
    assert large.x_mean_square == pytest.approx(9.0 * small.x_mean_square, rel=1e-12)


DUFFING = sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 0.5)), sp.WhiteNoise(1.0, envelope=ENVELOPE)


def test_a_cubic_spring_is_linearized_at_each_time() -> None:
    """Against another program of the same closure."""
    found = sp.theory.transient(sp.System(*DUFFING, sp.Dashpot(0.3)), TIMES)
    assert found.x_mean_square == pytest.approx([0.25016, 0.52525, 0.55635, 0.35887, 0.13398, 0.00978], rel=5e-4)
    assert found.v_mean_square == pytest.approx([0.43020, 1.04468, 1.08532, 0.55937, 0.16083, 0.01001], rel=5e-4)
    assert not found.is_exact
    assert found.warnings == (
        "The springs bend so much that x is far from Gaussian: its variance comes out too small.",
    )
    weak = sp.System(sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1e-9)), sp.Springpot(0.5, 0.3), DUFFING[-1])
    still = sp.theory.transient(weak, [0.0, 6.0])
    assert still.x_mean_square == pytest.approx([0.0, TABLE[sp.Springpot(0.5, 0.3)][0][2]], rel=5e-4)
    assert still.v_mean_square == pytest.approx([0.0, TABLE[sp.Springpot(0.5, 0.3)][1][2]], rel=5e-4)
    assert not still.warnings


@pytest.mark.validation  # every day: a cubic spring at each time, above
def test_nonlinear_systems_end_in_the_stationary_linearization() -> None:
    ends = ("ground", "a"), ("a", "b")
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"), sp.PolynomialSpring((0.0, 0.0, 2.0), between=ends[0]),
        sp.Spring(3.0, between=ends[1]), sp.PolynomialDashpot((0.8, 0.4), between=ends[1]),
        sp.Maxwell(1.0, 1.0, between=ends[0]), sp.Dashpot(0.5, between=ends[0]), sp.ColoredNoise(1.0, 0.3, on="b"),
    )  # fmt: skip
    found, stationary = sp.theory.transient(system, 32.0), sp.theory.linearization(system)
    for name, end in found.numbers.items():
        assert end == pytest.approx(stationary.numbers[name], rel=1e-3)


@pytest.mark.validation
@pytest.mark.parametrize(
    ("damper", "stiffest", "limits"),
    [
        (sp.Dashpot(0.3, between=("ground", "a")), 0.5, (0.09, 0.03)),
        (sp.Springpot(0.5, 0.3, between=("ground", "a")), 0.5, (0.06, 0.05)),
        (sp.Dashpot(0.3, between=("ground", "a")), 5.0, (0.17, 0.07)),
    ],
)
def test_the_linearization_in_time_is_as_near_to_simulation_as_it_says(
    damper: Any, stiffest: float, limits: tuple[float, float]
) -> None:
    ends = {"between": ("ground", "a")}
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "b")), sp.Spring(1.0, **ends),
        sp.PolynomialSpring((0.0, 0.0, stiffest), **ends), damper, sp.WhiteNoise(1.0, on="a", envelope=ENVELOPE),
    )  # fmt: skip
    near = [0.0, *(time + side for time in TIMES for side in (-0.1, 0.1))]
    found, run = sp.theory.transient(system, TIMES), sp.simulate(system, paths=60_000, step=0.02, profile=near)
    for name, limit in zip(("a_x_mean_square", "a_v_mean_square"), limits, strict=True):
        own = run.profiles[f"{name}_profile"]
        value, error = own.value[1::2], own.standard_error[1::2]
        assert (error < 0.01 * value).all()
        assert (np.abs(getattr(found, name) - value) < limit * value + 3.0 * error).all()


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((sp.Barrier(0.0),), "not barrier"), ((sp.Friction(0.1),), "not friction"),
        ((sp.PolynomialSpring((0.0, 0.1, 1.0)),), "where the mean of x stays 0"),
        ((sp.PolynomialSpring((-3.0, 0.0, 1.0)),), "not two wells"),
        ((sp.VanDerPol(0.1, 1.0),), "none that feed small motions"),
        ((sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.BoucWen(1.0, 1.0)), "in time not bouc_wen"),
        ((sp.Jenkins(1.0, 1.0),), "Statistical linearization .* in time not jenkins"),
        ((sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Barrier(0.0)), "Statistical linearization .* not barrier"),
        (
            (sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.SpectralExcitation((0.1, 1.0), (1.0, 1.0))),
            "not a noise of a given spectral density",
        ),
        ((sp.Constant(1.0),), "not constant or harmonic forces, thermal noise or noise that multiplies x"),
        ((sp.Dashpot(0.1), sp.ThermalNoise(1.0)), "not constant or harmonic forces, thermal noise"),
    ],
)  # fmt: skip
def test_what_is_not_covered_is_named(parts: tuple[Any, ...], sentence: str) -> None:
    with pytest.raises(sp.theory.NotCoveredError, match=sentence):
        sp.theory.transient(sp.System(sp.Spring(1.0), sp.WhiteNoise(1.0), *parts), 1.0)
