"""Sensitivities and designs of several masses."""

from __future__ import annotations

import math
from typing import Any

import pytest

import springpot as sp
from tests.several import buildings
from tests.sizes import validation


def test_a_number_of_many_parts_has_the_sensitivity_of_all() -> None:
    """Under a noise of intensity q the motion is that of q / s^2 where all masses and forces of parts are s times."""
    s = sp.free("s", 1.0, (0.1, 10.0))
    model = sp.System(
        sp.Mass(s, at="frame"), sp.Mass(0.05 * s, at="damper"), sp.Spring(s, between=("ground", "frame")),
        sp.Spring(0.0464 * s, between=("frame", "damper")), sp.Springpot(0.5, 0.02 * s, between=("frame", "damper")),
        sp.WhiteNoise(sp.free("q", 1.0, (0.1, 10.0)), on="frame"),
    )  # fmt: skip
    found = sp.sensitivity(model, "frame_damper_elongation_mean_square")
    assert found.method == "linear"
    expected = {"s": pytest.approx(-2.0, abs=1e-5), "q": pytest.approx(1.0, abs=1e-9)}
    assert found.values["frame_damper_elongation_mean_square"] == expected


@pytest.mark.parametrize(
    ("mu", "on"), [(0.01, "frame"), (0.1, "ground"), validation(0.1, "frame"), validation(0.01, "ground")]
)
def test_the_classical_tuned_mass_damper_is_where_nothing_changes(mu: float, on: str) -> None:
    """Warburton, Earthquake Engineering & Structural Dynamics 10 (1982): the least <x^2>, q / (4 zeta_e)."""
    less = 0.5 * mu if on == "frame" else -0.5 * mu
    f = math.sqrt(1.0 + less) / (1.0 + mu)
    share = 0.75 * mu if on == "frame" else -0.25 * mu
    zeta = math.sqrt(mu * (1.0 + share) / (4.0 * (1.0 + mu) * (1.0 + less)))
    damper: dict[str, Any] = {"between": ("frame", "damper")}
    model = sp.System(
        sp.Mass(1.0, at="frame"), sp.Mass(mu, at="damper"), sp.Spring(1.0, between=("ground", "frame")),
        sp.Spring(sp.free("k", mu * f**2, (0.001, 1.0)), **damper), sp.WhiteNoise(1.0, on=on),
        sp.Dashpot(sp.free("c", 2.0 * zeta * f * mu, (1e-6, 1.0)), **damper),
    )  # fmt: skip
    found = sp.sensitivity(model, "frame_x_mean_square")
    grown = mu * (1.0 + mu) / (1.0 + share) if on == "frame" else mu / ((1.0 + mu) ** 3 * (1.0 + share))
    assert found.quantities["frame_x_mean_square"] == pytest.approx(1.0 / math.sqrt(grown), rel=1e-8)
    assert all(abs(value) < 1e-4 for value in found.values["frame_x_mean_square"].values())


def test_results_of_walls_have_sensitivities_or_a_sentence() -> None:
    driven = sp.sensitivity(buildings(sp.WhiteNoise(1e9, on="old")), ["gap_power", "gap_impact_rate"],
                            paths=128, duration=20.0)  # fmt: skip
    assert driven.method == "monte_carlo"
    assert driven.values["gap_power"]["white_noise_intensity"] > 1.0
    shaken = sp.sensitivity(buildings(sp.KanaiTajimiNoise(15.0, 0.6, 0.05, on="ground")), "gap_impact_rate",
                            paths=64, duration=5.0)  # fmt: skip
    (sentence,) = shaken.warnings
    assert sentence.startswith("gap_impact_rate has no value for this model: gap is lossy, and no white noise")
    far = sp.sensitivity(buildings(sp.WhiteNoise(1e3, on="old"), gap=-5.0), "gap_power", paths=8, duration=5.0)
    assert far.warnings == ("gap_power is 0 for this model: it has no relative change.",)


@pytest.mark.validation  # every day: where nothing changes there, in this file
def test_a_design_by_exact_theory_ends_at_the_classical_damper() -> None:
    """Warburton's minimum for a mass ratio of 0.05; Monte Carlo of the design agrees."""
    damper: dict[str, Any] = {"between": ("frame", "damper")}
    model = sp.System(
        sp.Mass(1.0, at="frame"), sp.Mass(0.05, at="damper"), sp.Spring(1.0, between=("ground", "frame")),
        sp.Spring(sp.free("k", 0.03, (0.01, 0.1)), **damper), sp.WhiteNoise(1.0, on="frame"),
        sp.Dashpot(sp.free("c", 0.03, (0.002, 0.1)), **damper),
    )  # fmt: skip
    found = sp.design(model, minimize="frame_x_mean_square", rtol=0.2)
    assert found.method == "linear"
    assert found.values == pytest.approx({"k": 0.0464852607, "c": 0.0105843}, rel=2e-3)
    assert sp.theory.linear(found.model).frame_x_mean_square == pytest.approx(4.445436, rel=1e-6)
    assert found.cost == pytest.approx(4.445436, rel=1e-6)
    measured, its_error = found.quantities["frame_x_mean_square"], found.errors["frame_x_mean_square"]
    assert abs(measured - 4.445436) < 4.0 * its_error


@pytest.mark.validation  # every day: the example of `sp.design`
def test_a_gap_is_designed_for_a_rate() -> None:
    model = buildings(sp.WhiteNoise(1e9, on="old"), gap=sp.free("gap", -0.05, (-0.1, -0.01)))
    found = sp.design(model, minimize=lambda gap: -gap, subject_to={"gap_impact_rate": (None, 0.1)},
                      rtol=0.1)  # fmt: skip
    assert found.method == "monte_carlo"
    assert found.promises[0].probability > 0.98
    assert found.quantities["gap_impact_rate"] < 0.1
