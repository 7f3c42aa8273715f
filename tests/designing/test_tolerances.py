"""Designs of devices that scatter: limits on means and quantiles over devices, against closed forms."""

from __future__ import annotations

import math
import pickle
import tomllib
from pathlib import Path
from typing import Any

import pytest
import scipy
from scipy import optimize

import springpot as sp
from springpot import cli
from springpot.problem.free_numbers import free_numbers, restarted, uncertain_numbers

SPREAD = math.sqrt(math.log1p(0.1**2))


def walled(**law: Any) -> sp.System:
    gap = sp.uncertain("gap", sp.free("centre", 0.8, (0.4, 2.0)), **(law or {"cov": 0.1}))
    return sp.System(sp.Spring(4.0), sp.Dashpot(0.5), sp.Barrier(-gap), sp.WhiteNoise(1.0))


def exact_quantile(centre: float) -> float:
    """Of the impact rate behind an elastic wall, Omega exp(-u^2 / 2) / (2 pi Phi(u)), u = gap / s: it falls with the
    gap."""
    gap = centre / math.sqrt(1.01) * math.exp(-float(scipy.stats.norm.ppf(0.95)) * SPREAD)
    u = gap / 0.5
    return 2.0 * math.exp(-0.5 * u * u) / (2.0 * math.pi * float(scipy.stats.norm.cdf(u)))


@pytest.mark.validation  # every day: the command that takes a quantile, below
def test_a_gap_so_wide_that_95_of_100_devices_hold() -> None:
    """The design, and what `sp.scatter` says of it with other random numbers."""
    found = sp.design(walled(), "centre", {"impact_rate_quantile_0.95": (None, 0.1)}, rtol=0.04, cost_rtol=0.04)
    best = optimize.brentq(lambda centre: exact_quantile(centre) - 0.1, 0.4, 2.0)
    assert best < found.values["centre"] < 1.08 * best
    (promise,) = found.promises
    assert promise.limit == "impact_rate_quantile_0.95 < 0.1"
    assert promise.probability >= 0.99
    assert abs(promise.value - exact_quantile(found.values["centre"])) < 3.5 * promise.error
    assert found.units == {"impact_rate_quantile_0.95": "s-1", "centre": "m"}
    again = sp.scatter(found.model, ["impact_rate"], devices=1024, seed=77, quantiles=[0.95])["impact_rate"]
    assert again.quantiles[0.95].low < 0.1
    assert [*again.quantiles] == [0.95]


@pytest.mark.validation  # every day: the command that takes a quantile, below
def test_the_mean_over_devices_is_not_the_nominal_device() -> None:
    """E[1 / c] of a lognormal c is (1 + cov^2) / E[c]; the search is by exact theory of each device."""
    damper = sp.Dashpot(sp.uncertain("c", sp.free("middle", 1.0, (0.1, 5.0)), cov=0.3))
    device = sp.System(sp.Spring(4.0), damper, sp.WhiteNoise(1.0))
    found = sp.design(device, "middle", {"x_mean_square": (None, 0.2)}, rtol=0.02, method="linear")
    exact = 1.09 / (2.0 * 4.0 * 0.2)
    assert exact < found.values["middle"] < 1.06 * exact
    assert found.method == "linear"


def test_a_free_centre_moves_with_its_law() -> None:
    gap = sp.uncertain("gap", sp.free("g", 0.006, (0.002, 0.01)), cov=0.1)
    device = sp.System(
        sp.Mass(0.8), sp.Spring(3200.0), sp.Barrier(-gap, 0.7), sp.Barrier(1.5 * gap, 0.7, free_side="below"),
        sp.WhiteNoise(1.0),
    )  # fmt: skip
    assert [*free_numbers(device)] == ["g"]
    assert [*uncertain_numbers(device)] == ["gap"]
    assert (gap.low, gap.high) == (pytest.approx(0.002 * 0.5408, rel=1e-3), pytest.approx(0.01 * 1.8307, rel=1e-3))
    moved = sp.with_values(device, {"g": 0.004})
    lower, upper = moved.of(sp.Barrier)
    assert (lower.position, upper.position) == (-0.004, pytest.approx(0.006))
    number = uncertain_numbers(moved)["gap"]
    assert number.law == sp.uncertain("gap", 0.004, cov=0.1).law
    assert not free_numbers(moved)
    assert restarted(device, {"g": 0.005}).of(sp.Barrier)[0].position == -0.005
    again = sp.read_system(tomllib.loads(sp.to_toml(device)))
    assert free_numbers(again) == free_numbers(device)
    assert uncertain_numbers(again)["gap"].law == gap.law == pickle.loads(pickle.dumps(gap)).law
    assert sp.nominal(device).of(sp.Barrier)[0].position == -0.006
    assert sp.with_values(device, {"gap": 0.003}).of(sp.Barrier)[1].position == pytest.approx(0.0045)


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: walled(sd=0.1, bounds=(0.1, 3.0)), ValueError, "bounds must not be given with a free value"),
        (
            lambda: sp.uncertain("a", sp.free("b", 0.5, (-1.0, 1.0)), cov=0.1),
            ValueError, "value must be above 0 with cov",
        ),
        (lambda: sp.uncertain("a", sp.free("b", 0.5, (0.1, 1.0)), bounds=(0.1, 1.0)), TypeError, "or a free one with"),
        (lambda: sp.uncertain("a", sp.uncertain("b", 0.5, cov=0.1), cov=0.1), TypeError, "value must be a plain"),
        (
            lambda: sp.design(walled(), "centre", {"impact_speed_mean_quantile_0.9": (None, 0.1)}),
            ValueError, "subject_to must limit results among",
        ),
        (
            lambda: sp.design(walled(), "centre", {"impact_rate_quantile_0.999": (None, 0.1)}),
            ValueError, "subject_to cannot limit impact_rate_quantile_0.999: quantiles are over devices",
        ),
        (
            lambda: sp.design(sp.with_values(walled(), {"gap": 1.0}), "centre", {"impact_rate": (None, 0.1)}),
            ValueError, "model must have a free number",
        ),
        (
            lambda: sp.design(
                sp.System(sp.Spring(1.0), sp.Dashpot(sp.free("c", 0.2, (0.1, 1.0))), sp.WhiteNoise(0.1)), "c",
                {"x_mean_square_quantile_0.95": (None, 0.1)},
            ),
            ValueError, "quantiles are over devices with uncertain numbers",
        ),
        (lambda: sp.scatter(walled(), quantiles=[1.0]), ValueError, "quantiles must be in [0.005, 0.995], not 1"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_sentence(call: Any, kind: type[Exception], words: str) -> None:
    with pytest.raises(kind) as caught:
        call()
    assert words in str(caught.value), str(caught.value)


def test_the_command_takes_a_quantile(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "device.toml", tmp_path / "found.toml"
    file.write_text(sp.to_toml(walled()), encoding="utf-8")
    words = ["design", str(file), "--minimize", "centre", "--below", "impact_rate_quantile_0.95", "0.1"]
    assert cli.main([*words, "--rtol", "0.2", "--cost-rtol", "0.2", "--out", str(out)]) == 0
    assert "impact_rate_quantile_0.95 < 0.1 holds with a probability of" in capsys.readouterr().out
    assert [*uncertain_numbers(sp.read_system(out))] == ["gap"]
