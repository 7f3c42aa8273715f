"""Sensitivities and designs of several masses."""

from __future__ import annotations

import pytest

import springpot as sp
from tests.several import buildings, tuned


def test_elasticities_of_a_linear_system_add_up() -> None:
    """Under a noise of intensity q the motion is that of q / s^2 where all masses and forces of parts are s times."""
    found = sp.sensitivity(tuned(), "frame_x_mean_square")
    own = found.values["frame_x_mean_square"]
    assert found.method == "linear"
    assert own["white_noise_intensity"] == pytest.approx(1.0, abs=1e-9)
    scaled = sum(own[name] for name in own if name not in ("pot_order", "white_noise_intensity"))
    assert scaled == pytest.approx(-2.0, abs=1e-4)


def test_results_of_walls_have_sensitivities_or_a_sentence() -> None:
    driven = sp.sensitivity(buildings(sp.WhiteNoise(1e9, on="old")), ["gap_power", "gap_impact_rate"],
                            paths=128, duration=20.0)  # fmt: skip
    assert driven.method == "monte_carlo"
    assert driven.values["gap_power"]["white_noise_intensity"] > 1.0
    shaken = sp.sensitivity(buildings(sp.KanaiTajimiNoise(15.0, 0.6, 0.05, on="ground")), "gap_impact_rate",
                            paths=64, duration=5.0)  # fmt: skip
    (sentence,) = shaken.warnings
    assert sentence.startswith("gap_impact_rate has no value for this model: gap is lossy, and no white noise")
