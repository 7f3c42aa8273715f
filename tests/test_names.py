"""Wrong names get one sentence with the one that was probably meant; shares are written without powers of ten."""

import re
from typing import Any

import pytest

import springpot as sp
from springpot.machine.faults import per_cent


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.Barrier(-1.0, e=0.5), "Barrier has no argument 'e'; did you mean restitution?"),
        (lambda: sp.Barrier(-1.0, side="above"), "Barrier has no argument 'side'; did you mean free_side?"),
        (lambda: sp.Contact(-1.0, 5.0, side="above"), "Contact has no argument 'side'; did you mean free_side?"),
        (
            lambda: sp.Oscillator.from_numbers(side="above"),
            "Oscillator.from_numbers has no argument 'side'; did you mean free_side?",
        ),
        (
            lambda: sp.Oscillator.from_device(
                mass=1.0, stiffness=1.0, springpot=(1.0, 0.1), psd=1.0, psd_unit="g2/Hz", side="below"
            ),
            "Oscillator.from_device has no argument 'side'; did you mean free_side?",
        ),
        (lambda: sp.Spring(k=80.0), "Spring has no argument 'k'; did you mean stiffness?"),
        (lambda: sp.Springpot(alpha=0.5, coefficient=1.0), "Springpot has no argument 'alpha'; did you mean order?"),
        (lambda: sp.Mass(m=1.0), "Mass has no argument 'm'; did you mean value?"),
        (lambda: sp.Spring(color="red"), "Spring has no argument 'color': its argument is stiffness."),
        (lambda: sp.Oscillator(omega=2.0), "Oscillator has no argument 'omega'; did you mean natural_frequency?"),
        (lambda: sp.simulate(sp.Oscillator(), e=0.5), "no argument 'e'; did you mean Barrier(restitution=...)?"),
        (lambda: sp.simulate(sp.Oscillator(), path=5), "no argument 'path'; did you mean paths?"),
        (
            lambda: sp.System(sp.Spring(80.0), stiffness=80.0),
            "stiffness must be a part of that name, as stiffness=Spring(80.0), not 80.0; did you mean "
            "Spring(stiffness=...), ",
        ),
        (lambda: sp.System(barrier=-0.003), "barrier must be a part of that name"),
        (lambda: sp.System(barrier=-0.003), "did you mean Barrier(...)?"),
        (lambda: sp.System(sp.Mass(1.0), sp.Mass(2.0), sp.Spring(1.0)), "the 2 masses must have a name, as Mass("),
    ],
)
def test_what_was_meant_is_named(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError)) as fault:
        make()
    assert sentence in str(fault.value)


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("rms", "; its square is x_mean_square."),
        ("impact_rates", "; did you mean impact_rate?"),
        ("color", ", only x_mean"),
    ],
)
def test_an_unknown_result_names_a_near_one(word: str, hint: str) -> None:
    result = sp.simulate(sp.Oscillator(), paths=64, duration=2.0, start="rest")
    for numbers in (result, result.estimates):
        with pytest.raises(KeyError, match=re.escape(f"{word} is not among the results{hint}")):
            numbers[word]


def test_an_observable_has_no_unit_even_where_its_name_is_like_that_of_a_result() -> None:
    result = sp.simulate(
        sp.Oscillator(), paths=64, duration=2.0, start="rest", observables={"harvested_power": lambda t, x, v: v * v}
    )
    assert result["harvested_power"].unit == ""
    assert result["damping_power"].unit == "m2 s-3"
    with pytest.raises(ValueError, match="run must have moments only, but it has observables"):
        sp.extend(result, paths=128)


@pytest.mark.parametrize(
    ("share", "digits", "words"),
    [(0.996, 1, "100 %"), (0.998, 2, "100 %"), (25.0, 2, "2500 %"), (3e-8, 1, "0.000003 %"), (0.0123, 2, "1.2 %")],
)
def test_shares_have_no_powers_of_ten(share: float, digits: int, words: str) -> None:
    assert per_cent(share, digits) == words
