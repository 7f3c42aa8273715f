"""Contacts: their exponent, and the restitution of Hunt and Crossley's dissipation."""

import math

import mpmath
import pytest

import springpot as sp


def test_the_exponent_is_said() -> None:
    said = sp.explain(
        sp.System(sp.Mass(1.0), sp.Spring(1.0), stop=sp.Contact(-0.1, 5e4), hard=sp.Contact.linear(0.1, 1e6))
    )
    assert "soft contact (stop): exponent 1.5 (Hertz's contact)" in said
    assert "soft contact (hard): exponent 1 (a linear stop)" in said


def test_a_linear_contact_takes_what_every_part_takes() -> None:
    found = sp.Contact.linear(-0.1, 2e5, dissipation=0.2, between=("a", "b"), group="stops")
    assert found == sp.Contact(-0.1, 2e5, 1.0, 0.2, between=("a", "b"), group="stops")


@pytest.mark.parametrize("strength", [1e-9, 9.9e-4, 1.01e-3, 0.02, 0.5, 3.0, 40.0, 1e5])
def test_the_restitution_solves_its_equation(strength: float) -> None:
    r = sp.Contact(0.0, 1.0, dissipation=strength).restitution_at(1.0)
    with mpmath.workdps(50):
        s = mpmath.mpf(strength)
        last = -(1 + s) * mpmath.exp(-(1 + s))
        exact = (1 + mpmath.lambertw(last).real) / s
    assert r == pytest.approx(float(exact), rel=2e-9)
    assert sp.Contact.dissipation_of(r, speed=2.0) == pytest.approx(
        strength / 2.0, rel=1e-6 if strength > 1e-6 else 1e-3
    )


@pytest.mark.parametrize(("exponent", "chi"), [(1.0, 0.1), (1.5, 0.6), (1.5, 2.0), (2.0, 0.6)])
@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_one_impact_has_that_restitution(exponent: float, chi: float) -> None:
    v = 1.5
    stop = sp.Contact(0.0, 2e6, exponent, dissipation=chi, free_side="above")
    ball = sp.System(sp.Mass(0.5), sp.Spring(1e-6), stop, sp.WhiteNoise(0.0))
    run = sp.simulate(ball, paths=1, record=1, step=1e-6, duration=0.02, initial_position=1e-5, initial_velocity=-v)
    x, after = run.record[0, -1]
    assert x > 0.0
    assert after / v == pytest.approx(stop.restitution_at(v), abs=2e-4)


def test_what_is_wrong_is_said() -> None:
    assert sp.Contact.dissipation_of(1.0, 0.5) == 0.0
    assert sp.Contact(0.0, 1.0).restitution_at(3.0) == 1.0
    with pytest.raises(ValueError, match="restitution must be"):
        sp.Contact.dissipation_of(0.0, 1.0)
    with pytest.raises(ValueError, match="speed must be"):
        sp.Contact(0.0, 1.0, dissipation=1.0).restitution_at(-1.0)
    assert math.isfinite(sp.Contact.dissipation_of(1e-6, 1.0))
