"""A mass that only walls hold starts on its way from wall to wall: an impact damper is stationary at once."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import plan_of
from tests.sizes import validation

# of the damper with a gap of 3, by event-driven runs of its own program: <x^2> of the main mass, and the rate of a wall
SQUARE, RATE = (0.2766, 0.0007), (0.0814, 0.0003)
SETTLED = 7900.0  # s, about, that a start from rest needs: 28 times 283 s


def damper(gap: float = 3.0, *parts: Any) -> sp.System:
    """A free ball between two walls on a mass that is shaken."""
    cage = ("main", "ball")
    return sp.System(
        sp.Mass(1.0, at="main"), sp.Mass(0.1, at="ball"), sp.Spring(1.0, between=("ground", "main")),
        sp.Dashpot(0.02, between=("ground", "main")), sp.WhiteNoise(0.04, on="main"), *parts,
        left=sp.Barrier(-gap, 0.6, between=cage), right=sp.Barrier(gap, 0.6, free_side="below", between=cage),
    )  # fmt: skip


def start_law(system: sp.System) -> Any:
    motion = motion_of(system)
    return motion.drawn_about(motion.near_mean)


def check(run: Any, name: str, exact: tuple[float, float], most: float = 3.0) -> None:
    assert abs(run[name].value - exact[0]) < most * math.hypot(run[name].error, exact[1]), name


def names(run: Any) -> list[str]:
    return [message.name for message in run.warnings]


def test_the_default_run_of_an_impact_damper_is_stationary() -> None:
    """From rest it had 0.714 for 0.277, and 0.024 impacts in a second for 0.081."""
    run = simulated(damper(), paths=256)
    check(run, "main_x_mean_square", SQUARE)
    assert run["main_x_mean_square"].error < 0.02 * SQUARE[0]
    for wall in ("left", "right"):
        check(run, f"{wall}_impact_rate", RATE)
        assert run[f"{wall}_impact_rate"].error < 0.02 * RATE[0]
    assert not run.warnings


def test_from_rest_the_warning_names_how_long_the_ball_waits() -> None:
    short = simulated(damper(), paths=64, duration=1000.0, start="rest")
    assert names(short) == ["transient_in_window"]
    assert "of ball, which only walls hold" in short.warnings[0]
    later = float(short.warnings[0].partition("start it after ")[2].partition(" s")[0])
    assert SETTLED / 2.0 < later < SETTLED * 2.0
    late = simulated(damper(), paths=256, duration=1.4 * later, window=(later, 1.4 * later), start="rest")
    check(late, "main_x_mean_square", SQUARE)
    check(late, "left_impact_rate", RATE)
    assert not late.warnings


def test_a_total_error_of_an_impact_damper_holds() -> None:
    run = simulated(damper(), rtol=0.05)
    for name in ("main_x_mean_square", "main_v_mean_square", "ball_v_mean_square"):
        assert run[name].budget.total < 0.05 * run[name].value
    assert abs(run["main_x_mean_square"].value - SQUARE[0]) < run["main_x_mean_square"].budget.total + 3.0 * SQUARE[1]
    assert run.settings.window[0] > SETTLED


@pytest.mark.parametrize(("gap", "square"), [(2.0, 0.2128), validation(2.5, 0.2385), validation(3.5, 0.3213)])
def test_the_start_holds_for_other_rooms(gap: float, square: float) -> None:
    """The squares are those of runs from rest, from 50 waiting times on."""
    run = simulated(damper(gap), paths=512)
    check(run, "main_x_mean_square", (square, 0.003 * square))


def test_the_ball_is_anywhere_in_its_room_and_as_fast_as_its_neighbour() -> None:
    x, v = start_law(damper()).drawn(np.random.Generator(np.random.Philox(3)), 20_000)
    main, ball = x.T
    assert np.abs(main - ball).max() <= 3.0
    np.testing.assert_allclose([main.var(), *v.var(axis=0)], 1.0, rtol=0.05)
    np.testing.assert_allclose((main - ball).var(), 36.0 / 12.0, rtol=0.05)
    assert abs(np.corrcoef(main, main - ball)[0, 1]) < 0.03


def test_the_start_of_a_path_depends_on_nothing_but_seed_and_number() -> None:
    given: dict[str, Any] = {"duration": 20.0, "seed": 7}
    one, other = (simulated(damper(), paths=256, threads=threads, **given) for threads in (1, 2))
    np.testing.assert_array_equal(one.path_sums, other.path_sums)
    few = simulated(damper(), paths=100, **given)
    np.testing.assert_array_equal(one.path_sums[:100], few.path_sums)
    np.testing.assert_array_equal(sp.extend(few, paths=256).path_sums, one.path_sums)
    assert not np.array_equal(one.path_sums, simulated(damper(), paths=256, duration=20.0, seed=8).path_sums)


@pytest.mark.parametrize(
    "part",
    [
        sp.Spring(0.01, between=("main", "ball")),
        sp.Dashpot(0.01, between=("main", "ball")),
        sp.WhiteNoise(0.01, on="ball"),
        sp.WhiteNoise(0.01, on="ground"),
    ],
)
def test_what_anything_else_moves_does_not_wait(part: Any) -> None:
    motion = motion_of(damper(3.0, part))
    assert motion.waiting_time("rest") == 0.0
    assert motion.drawn_about(motion.near_mean) is None


def test_a_wall_that_nothing_reaches_is_not_waited_for() -> None:
    plan = plan_of(damper(12.0))
    assert start_law(damper(12.0)) is None
    assert plan.transient_left < 0.01


def test_held_masses_keep_behind_their_own_walls() -> None:
    stop = sp.Barrier(-0.5, 0.8, between=("ground", "main"))
    x, _ = start_law(damper(3.0, stop)).drawn(np.random.Generator(np.random.Philox(3)), 2000)
    assert x[:, 0].min() >= -0.5
    assert np.abs(x[:, 0] - x[:, 1]).max() <= 3.0


@pytest.mark.validation
def test_the_start_holds_where_the_neighbour_has_memory() -> None:
    """The held masses are then drawn by their velocities alone; right is what a start from rest has from 6000 s on."""
    cage = ("main", "ball")
    system = sp.System(
        sp.Mass(1.0, at="main"), sp.Mass(0.1, at="ball"), sp.Spring(1.0, between=("ground", "main")),
        sp.Springpot(0.5, 0.03, between=("ground", "main")), sp.WhiteNoise(0.04, on="main"),
        left=sp.Barrier(-2.5, 0.6, between=cage), right=sp.Barrier(2.5, 0.6, free_side="below", between=cage),
    )  # fmt: skip
    run = simulated(system, paths=1000)
    check(run, "main_x_mean_square", (0.23337, 0.0006))
    check(run, "left_impact_rate", (0.09185, 0.0002))
