"""Each erratum is carried by numbers: the correction agrees with them and the print does not."""

import math

import pytest

from springpot.paper.errata import ERRATA, prefactor_of_the_cosine, sign_of_the_sine

# How far the computed number may be from the correction: rounding, or the next term of an expansion where one is cut.
TOLERANCE = {1: 5e-3, 2: 5e-3, 3: 1e-8, 4: 1e-2, 7: 2e-3}


@pytest.mark.parametrize("erratum", ERRATA, ids=lambda erratum: erratum.title)
def test_the_correction_agrees(erratum):
    within = TOLERANCE.get(erratum.number, 1e-8)
    near_zero = 1e-3 if erratum.number == 1 else 1e-8
    for finding in erratum.check():
        assert finding.computed == pytest.approx(finding.corrected, rel=within, abs=near_zero), finding.what


@pytest.mark.parametrize("erratum", ERRATA, ids=lambda erratum: erratum.title)
def test_the_print_does_not(erratum):
    within = TOLERANCE.get(erratum.number, 1e-8)
    wrong = [f for f in erratum.check() if abs(f.printed - f.computed) > 20 * within * max(abs(f.computed), 1e-3)]
    assert wrong


def test_they_are_numbered_and_worded():
    assert [erratum.number for erratum in ERRATA] == [1, 2, 3, 4, 5, 6, 7]
    for erratum in ERRATA:
        assert erratum.statement.endswith(".")
        assert erratum.equation


def test_the_cosine_integral_vanishes_either_way():
    whole = prefactor_of_the_cosine()[-1]
    assert whole.printed == whole.corrected == 0.0
    assert abs(whole.computed) < 1e-14


def test_eq_17_at_m_1_and_the_growth_of_the_print():
    findings = sign_of_the_sine()
    assert findings[0].computed == pytest.approx(8 / 3, rel=1e-14)
    assert findings[-1].printed == pytest.approx(-findings[-1].computed, rel=1e-12)
    assert findings[-1].computed < 0 < findings[-1].printed
    assert math.isfinite(findings[-1].corrected)
