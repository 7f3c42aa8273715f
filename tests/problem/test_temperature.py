"""A material at another temperature: its modulus at the frequency times the factor."""

import math
import re
from typing import Any

import numpy as np
import pytest

import springpot as sp

LAWS = (
    sp.Shift.wlf(8.86, 101.6, reference=20.0),
    sp.Shift.arrhenius(90e3, reference=20.0),
    sp.Shift.table([-20.0, 0.0, 20.0, 60.0], [1e4, 120.0, 1.0, 0.003]),
)
POT = sp.Springpot(0.3, 150.0)
PARTS = (
    sp.Spring(3200.0), POT, sp.Dashpot(12.0), sp.Maxwell(100.0, 7.0),
    sp.FractionalMaxwell(sp.Springpot(0.6, 20.0), sp.Spring(900.0)),
)  # fmt: skip


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("celsius", [-15.0, 20.0, 55.0])
def test_the_modulus_is_that_at_the_shifted_frequency(law: sp.Shift, celsius: float) -> None:
    p, a = 2j * np.pi * np.array([0.1, 3.0, 50.0]), law.of(celsius)
    for part in PARTS[1:]:
        np.testing.assert_allclose(law.at(celsius, part).modulus(p), part.modulus(a * p), rtol=1e-12)
    whole = law.at(celsius, sp.System(sp.Mass(2.0), *PARTS, sp.WhiteNoise(1.0), mount=POT))
    assert whole.parts[1] == PARTS[0]
    assert [*whole.named()][-1] == ("mount", law.at(celsius, POT))
    assert law.at(20.0, POT) == POT


def test_the_laws_are_those_of_the_books() -> None:
    """Rubber's universal constants from the glass transition; 10 degrees more halve the time at 53 kJ/mol."""
    assert math.log10(sp.Shift.wlf(17.44, 51.6, reference=-70.0).of(-18.4)) == pytest.approx(-8.72, abs=1e-12)
    energy = 8.314462618 * math.log(2.0) / (1.0 / 293.15 - 1.0 / 303.15)
    assert sp.Shift.arrhenius(energy, reference=20.0).of(30.0) == pytest.approx(0.5, rel=1e-12)


def test_a_free_coefficient_stays_free() -> None:
    found = LAWS[0].at(0.0, sp.Springpot(0.3, sp.free("C", 150.0, (1.0, 1e4))))
    assert sp.with_values(found, {"C": 300.0}).coefficient == pytest.approx(300.0 * LAWS[0].of(0.0) ** 0.3)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.Shift.wlf(-1.0, 50.0, reference=0.0), "c1 must be in (0, "),
        (lambda: LAWS[0].of(-90.0), "celsius must be above -81.6, where this law ends, not -90."),
        (lambda: LAWS[0].of(-80.0), "celsius must be nearer to the reference"),
        (lambda: sp.Shift.wlf(8.0, 50.0, reference=-300.0), "reference must be in [-273.15, "),
        (lambda: LAWS[1].of("warm"), "celsius must be a"),
        (lambda: LAWS[2].of(70.0), "celsius must be in the table, from -20 to 60, not 70."),
        (lambda: sp.Shift.table([0.0, 0.0], [1.0, 2.0]), "celsius must ascend"),
        (lambda: sp.Shift.table([0.0, 1.0], [1.0, 0.0]), "factors must be above 0"),
        (lambda: sp.Shift.table([0.0], [1.0]), "celsius and factors must have as many numbers, two or more."),
        (lambda: LAWS[0].at(0.0, 3.0), "model must be a System or a part, not 3.0."),
    ],
)
def test_what_is_wrong_is_said(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=re.escape(sentence)):
        make()
