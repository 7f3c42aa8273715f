"""Extreme numbers and many parts: one short sentence, and no warning of NumPy."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.evidence.explanation import equation
from springpot.evidence.recommendation import all_methods
from springpot.machine.faults import few, listed
from springpot.simulation.error.reach import reach
from springpot.simulation.kernel import advance, excitations, lanes, rest
from springpot.simulation.lowering.filters import Filter, _stationary
from springpot.simulation.plan.plan import plan_of
from tests.sizes import validation

LONGEST = 600  # characters in a sentence
SPRINGS = sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0))
PRESSED = sp.System(*SPRINGS, sp.Springpot(0.5, 0.3), sp.Barrier(40.0, 0.9, free_side="above"), sp.WhiteNoise(1.0))
HUGE = sp.System(
    sp.Spring(1e50), sp.PolynomialSpring((0.0, 0.0, 1e50)), sp.Springpot(0.5, 1e-50), sp.Barrier(-1e-50, 0.9),
    sp.WhiteNoise(1e50),
)  # fmt: skip
PINNED = sp.System(sp.Spring(1e12), sp.Springpot(0.5, 3.0), sp.Barrier(1.0, free_side="above"), sp.ThermalNoise(1e-18))
FAR = sp.Oscillator(1.0, sp.Springpot(0.5, 0.2), sp.Barrier(-1e30, 0.9), sp.WhiteNoise(1.0))
UNDAMPED = sp.Oscillator(1.0, sp.Springpot(0.5, 1e-20), None, sp.WhiteNoise(1.0))


@pytest.fixture(autouse=True)
def _warnings_are_errors() -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        yield


@pytest.mark.parametrize("problem", [PRESSED, HUGE, FAR])
def test_theory_of_extreme_numbers_answers_or_refuses(problem: sp.System) -> None:
    answers = all_methods(problem)
    assert "envelope" in answers


def test_scales_of_a_wall_far_outside_the_law() -> None:
    assert plan_of(PRESSED, paths=1).settings.steps > 0


def test_huge_numbers_that_belong_together_are_simulated() -> None:
    """Frequency and noise fit each other, and the wall is at the equilibrium: a bouncing mass in small units.

    The other wall is far away in these units.
    """
    step = 0.1 * plan_of(HUGE).settings.step
    huge = sp.System(*HUGE.parts, sp.Barrier(1e-11, free_side="below"))
    given: dict[str, Any] = {"duration": 2500 * step, "window": (1500 * step, 2500 * step), "step": step}
    found = sp.simulate(huge, paths=256, **given, start="rest")
    usual = sp.System(
        sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1e-25)), sp.Springpot(0.5, 1e-50), sp.Barrier(0.0, 0.9),
        sp.WhiteNoise(1.0), sp.Barrier(200.0, free_side="below"),
    )  # fmt: skip
    own = sp.simulate(usual, paths=256, duration=25.0, window=(15.0, 25.0), step=0.01, start="rest")
    assert found["barrier_1_impact_rate"].value / 1e25 == pytest.approx(own["barrier_1_impact_rate"].value, rel=0.01)
    assert found["barrier_1_impact_rate"].value > 0.1e25
    assert found["barrier_2_impact_rate"].value == 0.0
    assert found["x_mean_square"].value * 1e25 == pytest.approx(own["x_mean_square"].value, rel=0.01)


MANY = [sp.Contact(-0.1 - 0.01 * n, 100.0) for n in range(200)]
REFUSED: list[Any] = [
    (lambda: plan_of(PINNED), "must be closer together|system must move by more than rounding"),
    validation(lambda: sp.simulate(FAR, paths=4), "the problem's numbers must be closer together"),
    (
        lambda: reach(UNDAMPED, 0.1),
        "rtol cannot be reached: the motion forgets its start only after 1.4e.20 s",
    ),
    (  # the energy settles in 3.4 s, slow displacements keep a share until then
        lambda: reach(sp.System(sp.Springpot(0.4, 1.0), sp.WhiteNoise(1.0)), 0.05, quantities=["x_mean_square"]),
        r"rtol cannot be reached: the motion forgets its start only after \d(\.\d)?e.\d\d s",
    ),
    (lambda: plan_of(sp.Oscillator(), duration=1e290), "takes more than the 100,000,000 steps of 0.1 s"),
    (lambda: sp.System(*SPRINGS, *MANY), "a system must have at most 64 parts, not 202"),
    (lambda: sp.System(*SPRINGS, *MANY[:17]), "a system must have at most 16 contacts, not 17"),
    (lambda: sp.explain([MANY]), "system must be a System"),
    (lambda: sp.Oscillator([*range(10_000)]), "natural_frequency must be a real number, not "),  # type: ignore[arg-type]
    (lambda: sp.simulate(MANY), "system must be a System"),  # type: ignore[arg-type]
    (lambda: sp.theory.envelope(MANY), "system must be a System"),  # type: ignore[call-overload]
    (lambda: plan_of(sp.Oscillator(), seed=[0] * 5000), "seed must be a whole number, not "),
    (lambda: sp.design(_walled(7), "c", {"impact_rat": (None, 1.0)}), "did you mean impact_rate"),
]


def _walled(dampers: int) -> sp.System:
    """With many results: each damper has a power."""
    more = [sp.PolynomialDashpot((0.0, 0.0, 0.1)) for _ in range(dampers)]
    damper = sp.Dashpot(sp.free("c", 0.5, (0.1, 2.0)))
    return sp.System(sp.Spring(1.0), damper, *more, sp.Barrier(-1.0), sp.WhiteNoise(1.0))


@pytest.mark.parametrize(("make", "sentence"), REFUSED)
def test_what_is_too_much_is_one_short_sentence(make: Callable[[], Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence) as caught:
        make()
    assert len(str(caught.value)) < LONGEST


def test_an_equation_of_many_parts_is_short() -> None:
    dampers = [sp.Springpot(0.01 * n, 0.1) for n in range(1, 51)]
    lines = [*equation(sp.System(sp.Spring(1.0), *dampers, sp.WhiteNoise(1.0)))]
    assert max(map(len, lines)) < LONGEST
    assert "(39 more terms) = w(t)" in lines[0]
    noises = [sp.WhiteNoise(1.0) for _ in range(50)]
    assert "w2(t): white noise (white_noise_23)" in "\n".join(equation(sp.System(sp.Spring(1.0), *noises)))


def test_lists_in_sentences_end() -> None:
    assert listed([f"n{k}" for k in range(400)], "or").endswith("n19 or 380 others")
    assert few(["a", "b, c"]) == "a, b, c"
    assert listed(["b, c"]) == "b, c"


def test_numbers_that_overflow_with_their_unit_are_refused(tmp_path: Path) -> None:
    rows = "\n".join(f"{n},1e308,1" for n in range(1, 9))
    (tmp_path / "a.csv").write_text(f"frequency_kHz,storage_GPa,loss_GPa\n{rows}", encoding="utf-8")
    with pytest.raises(ValueError, match="line 2: storage_GPa must be a finite number, not inf"):
        sp.read_data(tmp_path / "a.csv")


def test_a_fast_filter_does_not_hide_a_slow_one() -> None:
    both = Filter(np.diag([-1e40, -1.0]), np.diag([2e40, 2.0]), np.ones(2))
    assert _stationary(both) == pytest.approx(np.eye(2))


def test_the_page_of_limits_says_how_much_a_simulation_holds() -> None:
    page = " ".join((Path(__file__).parent.parent / "docs" / "limits.md").read_text(encoding="utf-8").split())
    for most, what in (
        (rest.MOST_POINTS, "masses"), (advance.MOST_ROWS, "points and pairs of ends"),
        (rest.MOST_WALLS, "walls and contacts"), (advance.MOST_NOISES, "white noises"),
        (excitations.MOST_SOURCES, "sources of other excitation"), (advance.MOST_DAMPERS, "nonlinear dampers"),
        (advance.MOST_TAPS, "circuits"), (lanes.MOST_MODES, "modes of memory"), (advance.MOST_STATES, "states"),
    ):  # fmt: skip
        assert f" {most} {what}" in page, what
