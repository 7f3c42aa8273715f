"""Mean squares in time of linear systems with noise that has an envelope."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp

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


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((sp.Barrier(0.0),), "not barrier"), ((sp.Friction(0.1),), "not friction"),
        ((sp.ColoredNoise(1.0, 1.0),), "not colored_noise"), ((sp.Dashpot(5.0),), "oscillations of their own"),
        ((sp.PolynomialSpring((0.0, 0.0, 1.0)),), "not the nonlinear polynomial_spring"),
    ],
)  # fmt: skip
def test_what_is_not_covered_is_named(parts: tuple[Any, ...], sentence: str) -> None:
    with pytest.raises(sp.theory.NotCoveredError, match=sentence):
        sp.theory.transient(sp.System(sp.Spring(1.0), sp.WhiteNoise(1.0), *parts), 1.0)
