"""What a run to a tolerance does next, decided without a simulation."""

from dataclasses import replace

import pytest

from springpot.machine.progress import Clock, OutOfTimeError
from springpot.simulation.error.decision import MOST_FINER, NORMAL, Known, Standing, bias_range, decide

QUIET = Known("x_mean", 1.0, 0.02, 4.0, 0.4, 1e-4, 1e-4, (1.0, 2.0), 0.0, 1.0, 1e-4)
START = Standing(0.01, (QUIET,), 4096, 1024, 1, 300, 0.0, 1e6, 1e12, MOST_FINER, True)


def bound(known: Known, paths: int, pairs: int, finer: int) -> float:
    """The expected total error."""
    middle, half = bias_range(known.orders, finer)
    error = (known.variance / paths + middle**2 * known.difference_variance / pairs) ** 0.5
    return NORMAL * error + half * (known.difference + (known.difference_variance / pairs) ** 0.5) + known.fixed


def test_it_ends_when_every_quantity_is_known_well_enough() -> None:
    good, bad = replace(QUIET, total=0.009), replace(QUIET, name="x_mean_square", total=0.011)
    assert decide(replace(START, known=(good,))).kind == "done"
    move = decide(replace(START, known=(good, bad)))
    assert (move.kind, move.worst) == ("more", "x_mean_square")


@pytest.mark.parametrize("impacts", [0.0, 10.0])
def test_more_paths_are_as_many_as_the_error_left_needs(impacts: float) -> None:
    known = replace(QUIET, variance=0.06, difference_variance=0.006)
    move = decide(replace(START, known=(known,), impacts=impacts))
    assert 0.005 < bound(known, move.paths, move.pairs, move.finer) < 0.01
    kept = START.paths if move.finer == START.finer else 0
    assert move.path_steps >= 0.99 * 300 * (2.0 ** (move.finer + 1) * (move.paths - kept) + 3 * (move.pairs - 1024))


def test_the_split_between_paths_and_pairs_is_the_cheapest() -> None:
    """Any other split of the same cost has a larger error, and so has any other step."""
    known = replace(QUIET, variance=0.6, difference_variance=0.1, difference=2e-4)
    move = decide(replace(START, known=(known,), paths=0, pairs=15_000, finer=0))
    plain = lambda paths, pairs, finer: 300 * (2.0 ** (finer + 1) * paths + 3.0 * pairs)  # noqa: E731
    cost, error = plain(move.paths, move.pairs, move.finer), bound(known, move.paths, move.pairs, move.finer)
    assert move.pairs > 15_000
    assert move.paths > 40_000
    for finer in range(MOST_FINER + 1):
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            paths, pairs = share * cost / (300 * 2.0 ** (finer + 1)), (1.0 - share) * cost / 900
            assert bound(known, paths, pairs, finer) > 0.93 * error


def test_behind_a_wall_where_a_step_is_a_small_part_of_the_cost_it_is_shorter() -> None:
    known = replace(QUIET, variance=0.06, difference_variance=0.006, difference=5e-3)
    fresh = replace(START, known=(known,), paths=0, finer=0)
    free, often = (decide(replace(fresh, impacts=impacts)) for impacts in (0.0, 24.0))
    assert often.finer > free.finer


def test_a_difference_that_is_hardly_known_is_measured_before_the_paths_begin() -> None:
    known = replace(QUIET, variance=0.6, difference_variance=4.0)
    move = decide(replace(START, known=(known,), paths=0, pairs=256, finer=0))
    assert (move.kind, move.paths, move.pairs) == ("more", 0, 1024)


def test_a_round_is_at_most_four_times_what_there_is() -> None:
    move = decide(replace(START, known=(replace(QUIET, variance=400.0, total=0.5),)))
    assert move.paths <= 4 * START.paths
    assert move.path_steps > 1e6 * 300


@pytest.mark.parametrize(
    ("difference", "error", "other", "kind"),
    [(0.2, 1e-2, 0.0, "halve"), (0.2, 6e-2, 0.0, "more"), (0.0, 1e-4, 0.03, "halve"), (2e-2, 1e-3, 0.0, "more")],
)
def test_the_step_is_halved_where_its_bias_is_sure_and_large(
    difference: float, error: float, other: float, kind: str
) -> None:
    known = replace(QUIET, difference=difference, difference_error=error, other_bias=other)
    assert decide(replace(START, known=(known,))).kind == kind


def test_a_step_that_cannot_be_halved_bounds_what_can_be_reached() -> None:
    known = replace(QUIET, difference=0.02, difference_error=1e-3, total=0.05)
    move = decide(replace(START, known=(known,), most_finer=0, finer=0, step_can_be_halved=False))
    assert move.kind == "more"
    assert move.aim == pytest.approx(max(0.01, 1.5 * (0.017 / 3.0 + QUIET.fixed)))
    assert move.finer == 0


@pytest.mark.parametrize("fixed", [1e-4, 5e-4, 2e-3])
def test_a_tighter_tolerance_never_aims_at_less(fixed: float) -> None:
    known = replace(QUIET, fixed=fixed)
    aims = [decide(replace(START, rtol=rtol, known=(known,))).aim for rtol in (0.01, 0.003, 1e-3, 3e-4, 1e-4)]
    assert aims == sorted(aims, reverse=True)
    assert aims[-1] == pytest.approx(max(1e-4, 1.5 * fixed))


def test_the_last_round_uses_what_room_there_is() -> None:
    known = replace(QUIET, variance=400.0, total=0.5)
    room = 300 * 8192
    move = decide(replace(START, known=(known,), most_path_steps=1e6 + room))
    assert move.kind == "more"
    kept = START.paths if move.finer == START.finer else 0
    spent = 300 * (2.0 ** (move.finer + 1) * (move.paths - kept) + 3 * (move.pairs - 1024))
    assert 0.9 * room < spent < 1.1 * room
    assert decide(replace(START, known=(known,), most_path_steps=1e6)).kind == "stop"


def test_a_clock_without_a_limit_never_ends_and_one_with_none_left_does() -> None:
    Clock(None).check()
    with pytest.raises(OutOfTimeError):
        Clock(1e-9).check()


@pytest.mark.parametrize(("value", "total"), [(0.0, 0.0), (float("nan"), float("nan"))])
def test_what_has_no_value_yet_is_looked_for_but_not_for_ever(value: float, total: float) -> None:
    unseen = replace(QUIET, name="impact_rate", value=value, total=total)
    move = decide(replace(START, known=(QUIET, unseen)))
    assert (move.kind, move.worst, move.paths, move.pairs) == ("more", "impact_rate", 4096, 4096)
    assert decide(replace(START, known=(unseen,), spent=2e9)).kind == "stop"
    assert decide(replace(START, known=(unseen,), most_path_steps=2e6)).kind == "stop"
