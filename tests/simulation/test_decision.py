"""What a run to a tolerance does next, decided without a simulation."""

from dataclasses import replace

import pytest

from springpot.simulation.cost import Clock, OutOfTime
from springpot.simulation.decision import NORMAL, Known, Standing, decide

QUIET = Known("x_mean", 1.0, 0.02, 4.0, 0.4, 1e-4, 1e-4, 1.0, 0.0, 1e-4)
START = Standing(0.01, (QUIET,), 2048, 1024, 300, 1e6, 1e12, True)


def test_it_ends_when_every_quantity_is_known_well_enough() -> None:
    good, bad = replace(QUIET, total=0.009), replace(QUIET, name="x_mean_square", total=0.011)
    assert decide(replace(START, known=(good,))).kind == "done"
    move = decide(replace(START, known=(good, bad)))
    assert (move.kind, move.worst) == ("more", "x_mean_square")


def test_more_paths_are_as_many_as_the_error_left_needs() -> None:
    known = replace(QUIET, variance=0.06, difference_variance=0.006)
    move = decide(replace(START, known=(known,)))
    paths, pairs = move.paths, move.pairs
    error = NORMAL * (0.06 / paths + 0.006 / pairs) ** 0.5
    assert 0.007 < error + known.difference + (0.006 / pairs) ** 0.5 + known.fixed < 0.01
    assert move.path_steps >= 0.99 * 300 * (paths - 2048 + 3 * (pairs - 1024))


def test_a_round_is_at_most_four_times_what_there_is() -> None:
    move = decide(replace(START, known=(replace(QUIET, variance=400.0, total=0.5),)))
    assert move.paths == 4 * START.paths
    assert move.path_steps > 1e6 * 300


@pytest.mark.parametrize(
    ("difference", "error", "other", "kind"),
    [(6e-3, 1e-3, 0.0, "halve"), (6e-3, 4e-3, 0.0, "more"), (0.0, 1e-4, 6e-3, "halve"), (2e-3, 1e-4, 0.0, "more")],
)
def test_the_step_is_halved_where_its_bias_is_sure_and_large(
    difference: float, error: float, other: float, kind: str
) -> None:
    known = replace(QUIET, difference=difference, difference_error=error, other_bias=other)
    assert decide(replace(START, known=(known,))).kind == kind


def test_a_step_that_cannot_be_halved_bounds_what_can_be_reached() -> None:
    known = replace(QUIET, difference=0.02, difference_error=1e-3, total=0.05)
    move = decide(replace(START, known=(known,), step_can_be_halved=False))
    assert move.kind == "more"
    assert move.aim == pytest.approx(1.5 * (0.018 + QUIET.fixed))


@pytest.mark.parametrize("fixed", [1e-4, 5e-4, 2e-3])
def test_a_tighter_tolerance_never_aims_at_less(fixed: float) -> None:
    known = replace(QUIET, fixed=fixed)
    aims = [decide(replace(START, rtol=rtol, known=(known,))).aim for rtol in (0.01, 0.003, 1e-3, 3e-4, 1e-4)]
    assert aims == sorted(aims, reverse=True)
    assert aims[-1] == pytest.approx(max(1e-4, 1.5 * fixed))


def test_the_last_round_uses_what_room_there_is() -> None:
    known = replace(QUIET, variance=400.0, total=0.5)
    move = decide(replace(START, known=(known,), most_path_steps=1e6 + 300 * 2048))
    assert move.kind == "more"
    spent = 300 * (move.paths - 2048 + 3 * (move.pairs - 1024))
    assert 0.9 * 300 * 2048 < spent < 1.1 * 300 * 2048
    assert decide(replace(START, known=(known,), most_path_steps=1e6)).kind == "stop"


def test_a_clock_without_a_limit_never_ends_and_one_with_none_left_does() -> None:
    Clock(None).check()
    with pytest.raises(OutOfTime):
        Clock(1e-9).check()


@pytest.mark.parametrize(("value", "total"), [(0.0, 0.0), (float("nan"), float("nan"))])
def test_what_has_no_value_yet_is_looked_for_but_not_for_ever(value: float, total: float) -> None:
    unseen = replace(QUIET, name="impact_rate", value=value, total=total)
    move = decide(replace(START, known=(QUIET, unseen)))
    assert (move.kind, move.worst, move.paths, move.pairs) == ("more", "impact_rate", 8192, 4096)
    assert decide(replace(START, known=(unseen,), spent=2e9)).kind == "stop"
    assert decide(replace(START, known=(unseen,), most_path_steps=2e6)).kind == "stop"
