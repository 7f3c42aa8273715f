"""Master curves: known factors are found, their intervals hold, and what cannot be shifted is refused."""

import re
from typing import Any

import numpy as np
import pytest

import springpot as sp

LAW = sp.Shift.wlf(8.86, 101.6, reference=20.0)
FREQUENCY = np.geomspace(0.1, 50.0, 16)
CELSIUS = (-10.0, 0.0, 10.0, 20.0, 30.0, 45.0, 60.0)
PARTS = sp.Spring(1.0), sp.FractionalMaxwell(sp.Springpot(0.55, 0.6), sp.Spring(300.0))


def measured(celsius: float, rng: np.random.Generator, columns: tuple[str, ...] = ("storage", "loss")) -> Any:
    modulus = sum(part.modulus(2j * np.pi * LAW.of(celsius) * FREQUENCY) for part in PARTS)
    scatter = 1.0 + 0.02 * rng.standard_normal((2, FREQUENCY.size))
    both = {"storage": modulus.real * scatter[0], "loss": modulus.imag * scatter[1]}
    return sp.MeasuredModuli(FREQUENCY, **{name: both[name] for name in columns})


def found(seed: int, columns: tuple[str, ...] = ("storage", "loss"), reference: float = 20.0) -> Any:
    rng = np.random.default_rng(seed)
    return sp.master_curve({celsius: measured(celsius, rng, columns) for celsius in CELSIUS}, reference=reference)


def deviation(curve: Any, celsius: float, reference: float = 20.0) -> float:
    true = LAW.of(celsius) / LAW.of(reference)
    return float(np.log10(curve.factors[celsius] / true) / curve.errors[celsius])


@pytest.mark.parametrize("reference", [-10.0, 20.0, 60.0])
def test_the_factors_are_found(reference: float) -> None:
    curve = found(1, reference=reference)
    assert curve.factors[reference] == 1.0
    assert curve.errors[reference] == 0.0
    assert max(abs(deviation(curve, celsius, reference)) for celsius in CELSIUS if celsius != reference) < 4.0
    assert max(curve.errors.values()) < 0.02
    assert curve.relative_error == pytest.approx(0.02, rel=0.2)
    assert curve.shift.of(30.0) == pytest.approx(curve.factors[30.0])


def test_the_curve_is_that_of_the_material() -> None:
    data = found(2).data
    assert data.size == 2 * FREQUENCY.size * len(CELSIUS)
    assert data.frequency_hz[-1] / data.frequency_hz[0] > 1e8
    modulus = sum(part.modulus(2j * np.pi * data.frequency_hz) for part in PARTS)
    assert np.std(data.storage / modulus.real - 1.0) == pytest.approx(0.02, rel=0.3)
    assert np.std(data.loss / modulus.imag - 1.0) == pytest.approx(0.02, rel=0.3)


def test_one_column_alone_is_enough() -> None:
    for column in ("storage", "loss"):
        curve = found(3, (column,))
        assert max(abs(deviation(curve, celsius)) for celsius in CELSIUS if celsius != 20.0) < 4.5


@pytest.mark.validation
def test_the_intervals_hold() -> None:
    curves = [found(seed) for seed in range(100)]
    for celsius in CELSIUS:
        if celsius != 20.0:
            assert 88 <= sum(abs(deviation(curve, celsius)) < 1.96 for curve in curves) <= 100


def test_points_of_two_tables_may_fall_on_one_frequency() -> None:
    table = sp.MeasuredModuli(FREQUENCY, 2.0 * FREQUENCY**0.4)
    curve = sp.master_curve({0.0: table, 20.0: table}, reference=0.0)
    assert curve.factors[20.0] == pytest.approx(1.0, abs=1e-9)
    assert curve.data.size == 32


def test_tables_across_a_gap_are_refused() -> None:
    few = np.geomspace(1.0, 5.0, 8)
    modulus = [sum(part.modulus(2j * np.pi * few * LAW.of(celsius)) for part in PARTS) for celsius in (-20.0, 20.0)]
    cold, warm = (sp.MeasuredModuli(few, own.real, own.imag) for own in modulus)
    with pytest.raises(ValueError, match="tables of -20 and 20 degrees must share moduli when they are shifted"):
        sp.master_curve({-20.0: cold, 20.0: warm}, reference=20.0)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda a, b: sp.master_curve({0.0: a}, reference=0.0), "tables must be moduli by two temperatures or more"),
        (
            lambda a, b: sp.master_curve({0.0: a, 20.0: b}, reference=10.0),
            "reference must be one of the temperatures, not 10.",
        ),
        (
            lambda a, b: sp.master_curve({0.0: a, 20.0: 3.0}, reference=0.0),
            "tables must be of MeasuredModuli, not 3.0.",
        ),
        (
            lambda a, b: sp.master_curve({0.0: a, 20.0: sp.MeasuredModuli(FREQUENCY, b.storage)}, reference=0.0),
            "tables must all have storage and loss, or all the same one.",
        ),
    ],
)
def test_what_is_wrong_is_said(make: Any, sentence: str) -> None:
    rng = np.random.default_rng(4)
    with pytest.raises((TypeError, ValueError), match=re.escape(sentence)):
        make(measured(0.0, rng), measured(20.0, rng))
