"""`fit.uncertain()`: the numbers of a fit with their covariance, in `sp.scatter`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.fitting.result import Fit
from springpot.problem.free_numbers import uncertain_numbers, with_values
from springpot.scattering.devices import correlated, drawn

RUBBER = sp.System(
    sp.Spring(sp.free("k", 1.0, (0.01, 100.0))),
    sp.Springpot(sp.free("order", 0.5, (0.01, 0.99)), sp.free("C", 1.0, (0.01, 100.0))),
)


def fitted(model: Any = RUBBER) -> Fit:
    f = np.geomspace(0.1, 100.0, 16)
    modulus = 3.0 + 2.0 * (2j * np.pi * f) ** 0.4
    noise = 1.0 + 0.02 * np.random.default_rng(1).standard_normal((2, f.size))
    return sp.fit(model, sp.MeasuredModuli(f, modulus.real * noise[0], modulus.imag * noise[1], relative_error=0.02))


def test_draws_have_the_covariance_of_the_fit() -> None:
    """In the coordinates of the search: logarithms here, for all bounds are positive."""
    fit = fitted()
    numbers = fit.uncertain()
    assert {name: float(number) for name, number in numbers.items()} == fit.values
    draws = np.log(drawn(numbers, 8192, 1, correlated({}, numbers)).values)
    names, value = [*numbers], np.array([*fit.values.values()])
    np.testing.assert_allclose(draws.mean(axis=0), np.log(value), atol=2e-4)
    wanted = fit.covariance / np.outer(value, value)
    size = np.sqrt(np.diag(wanted))
    assert names == ["k", "order", "C"]
    np.testing.assert_allclose(np.cov(draws.T) / np.outer(size, size), fit.correlations, atol=0.02)


@pytest.mark.validation  # every day: correlated numbers, in scattering/test_scatter.py
def test_they_are_one_input_of_a_scatter() -> None:
    """Its variance is that of linear propagation; without the correlations it would be several times that."""
    fit = fitted()
    whole = sp.with_values(RUBBER, fit.uncertain())
    device = sp.System(sp.Mass(0.01), *whole.parts, sp.WhiteNoise(1.0))
    found = sp.scatter(device, ["x_mean_square"], method="linear", devices=256)
    assert found.inputs == ("k and order and C",)
    assert found["x_mean_square"].alone["k and order and C"].value == pytest.approx(1.0, abs=0.02)

    def result(values: dict[str, float]) -> float:
        return float(sp.theory.linear(with_values(device, values)).x_mean_square)

    slopes = []
    for name in fit.values:
        step = 1e-3 * fit.values[name]
        ends = [result(fit.values | {name: fit.values[name] + side * step}) for side in (-1.0, 1.0)]
        slopes.append((ends[1] - ends[0]) / (2.0 * step))
    exact = math.sqrt(np.array(slopes) @ fit.covariance @ np.array(slopes))
    apart = math.sqrt(np.array(slopes) ** 2 @ np.diag(fit.covariance))
    assert found["x_mean_square"].scatter.value == pytest.approx(exact, rel=0.05)
    assert abs(math.log(apart / exact)) > 0.3


def test_a_fit_needs_plain_numbers_beside_its_free_ones() -> None:
    with pytest.raises(ValueError, match="a fit needs plain numbers, but k is uncertain"):
        fitted(sp.System(sp.Spring(sp.uncertain("k", 3.0, cov=0.1)), *RUBBER.of(sp.Springpot)))


def test_a_number_of_either_sign_is_normal() -> None:
    rest = sp.System(sp.Spring(sp.free("k", 1.0, (-5.0, 100.0))), sp.Dashpot(1.0))
    f = np.geomspace(0.1, 1.0, 8)
    data = sp.MeasuredModuli(f, 3.0 + 0.1 * np.cos(7.0 * f), 2.0 * np.pi * f, relative_error=0.02)
    k = sp.fit(rest, data).uncertain()["k"]
    assert k.law.table.keys() == {"value", "sd", "low", "high"}


def test_what_is_not_known_well_is_refused() -> None:
    order = sp.Springpot(sp.free("order", 0.5, (0.01, 0.99)), sp.free("C", 1.0, (0.01, 100.0)))
    near = sp.System(sp.Spring(sp.free("k", 1.0, (0.01, 3.1))), order)
    with pytest.raises(
        ValueError, match=r"k must be known better .* its 95 % interval is .* bounds of 0\.01 and 3\.1;"
    ):
        fitted(near).uncertain()
    held = sp.System(sp.Spring(sp.free("k", 1.0, (0.01, 2.0))), sp.Springpot(sp.free("order", 0.5, (0.01, 0.99)), 2.0))
    with pytest.raises(ValueError, match="k must be known better to be an uncertain number: it is held at a bound"):
        fitted(held).uncertain()
    alone = sp.Springpot(sp.free("order", 0.5, (0.0, 1.0)), sp.free("C", 1.0, (0.01, 100.0)))
    f = np.geomspace(1.0, 1.5, 8)
    short = sp.fit(alone, sp.MeasuredModuli(f, (2.0 * (2j * np.pi * f) ** 0.5).real, relative_error=0.05))
    assert 0.1 < short.errors["order"] < 0.25
    with pytest.raises(ValueError, match=r"order must be known to 0\.1 to be an uncertain number, not to 0\.1"):
        short.uncertain()


def test_a_file_keeps_them_and_the_command_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit = fitted()
    whole = sp.with_values(fit.given, fit.uncertain())
    file = tmp_path / "rubber.toml"
    file.write_text(sp.to_toml(whole), encoding="utf-8")
    again = uncertain_numbers(sp.read_system(file))
    assert again == uncertain_numbers(whole)
    for name, number in uncertain_numbers(whole).items():
        assert (again[name].law, again[name].correlation) == (number.law, number.correlation)
    model, data, out = (tmp_path / name for name in ("model.toml", "data.csv", "fitted.toml"))
    model.write_text(sp.to_toml(RUBBER), encoding="utf-8")
    table = np.column_stack([fit.data.frequency_hz, fit.data.storage, fit.data.loss])
    np.savetxt(data, table, delimiter=",", header="frequency_hz,storage_Pa,loss_Pa", comments="")
    words = ["fit", str(data), "--model", str(model), "--uncertain"]
    assert cli.main(words) == 2
    assert "uncertain is of the file that out names" in capsys.readouterr().err
    assert cli.main([*words, "--out", str(out)]) == 0
    assert uncertain_numbers(sp.read_system(out))["k"].correlation[0][0] == "order"
