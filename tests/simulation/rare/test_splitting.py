"""Splitting: bits that depend on nothing but the repetition, and means that are right."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.machine.progress import Clock
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.paths.simulation import Simulation, simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.rare import exceedance as door
from springpot.simulation.rare.event import Event, event_of, quantity_of
from springpot.simulation.rare.splitting import Tally, _Paths, repetitions
from tests.simulation.systems import of_many_kinds
from tests.sizes import validation

Floats = np.ndarray[Any, np.dtype[np.float64]]

WHITE = sp.WhiteNoise(0.2)
LIGHT = sp.System(
    sp.Spring(1.0), sp.Springpot(1.0, 0.1), sp.Barrier(-50.0), WHITE
)  # as free, of the kernel of the next
WALL = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.Barrier(-0.3, 0.8), WHITE)
ABOVE = sp.System(sp.Spring(1.0), sp.Springpot(0.7, 0.2), sp.Barrier(0.5, 0.7, "below"), WHITE)
# all that has a state
MANY = of_many_kinds(
    sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.ColoredNoise(1.0, 0.3), sp.Harmonic(0.2, 1.1), WHITE,
    sp.PolynomialSpring((0.0, 0.0, 0.05)), sp.PoissonImpulses(0.5, 0.02), sp.Barrier(-1.0, 0.8),
)  # fmt: skip
WELLS = sp.System(sp.Spring(-1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Dashpot(0.3), sp.WhiteNoise(0.1))
QUAKE = sp.System(
    sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.8, envelope=sp.ExponentialEnvelope(slow=0.2, fast=0.6))
)
PAIR = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"),
    sp.Spring(1.0, between=("ground", "a")), sp.Spring(1.0, between=("a", "b")),
    sp.Springpot(0.5, 0.2, between=("ground", "a")), sp.Dashpot(0.1, between=("a", "b")),
    sp.WhiteNoise(0.2, on="ground"), sp.Harmonic(0.2, 1.1, on="a"), sp.ColoredNoise(1.0, 0.1, on="b"),
    stop=sp.Barrier(-1.0, 0.7, between=("a", "b")),
)  # fmt: skip
ON_GROUND = sp.System(
    sp.Mass(0.8), sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.WhiteNoise(0.2, on="ground"), sp.Barrier(-50.0)
)
# a record for each path, noise of a given density, and a part that yields
RECORDED = sp.System(
    sp.Spring(1.0), sp.BoucWen(1.0, 1.0), sp.WhiteNoise(0.1),
    sp.RecordedExcitation((0.0, 8.0, 16.0), ((0.0, 0.4, 0.0), (0.0, -0.2, 0.3), (0.1, 0.1, 0.1)), taken="at random"),
    sp.SpectralExcitation.from_psd([0.05, 0.2, 0.6], [0.3, 0.6, 0.3], "m2/s4/Hz"),
)  # fmt: skip
COIL = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), *(sp.Spring(1.0, between=("ground", end)) for end in "ab"),
    sp.ResonantCircuit(1.0, 0.2, 1.0, 1.0, between=("a", "b")), sp.Springpot(0.5, 0.2, between=("ground", "a")),
    sp.WhiteNoise(0.2, on="a"),
)  # fmt: skip
BETWEEN = sp.System(sp.Spring(1.0), sp.Springpot(0.3, 0.3), sp.Barrier(-1.5, 0.7), sp.Barrier(1.5, 0.9), WHITE)
COLORED = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.2), sp.ColoredNoise(1.0, 0.3), sp.Barrier(-50.0))
SHAKEN = sp.System(sp.Spring(1.0), sp.Dashpot(0.3), sp.WhiteNoise(0.3), sp.ParametricNoise(0.1))


def prepared(
    system: sp.System,
    name: str,
    levels: list[float],
    *,
    sign: float = 1.0,
    threads: int = 2,
    own: Any = None,
    **given: Any,
) -> tuple[Simulation, Event]:
    plan = door.settled(
        plan_of(system, **{"duration": 20.0, "step": 0.1, "threads": threads, "start": "rest", **given})
    )
    if plan.settings.start == "stationary":
        plan = door.adapt(plan)
    simulation = simulation_of(door.split_early(plan))
    asked = event_of(plan, simulation.parts, quantity_of(plan.motion, name, own), np.array(levels), sign)
    return simulation, asked.told_by(tally((simulation, asked), 0, 32, splits=False, stream=9).ends)


def tally(
    of: tuple[Simulation, Event], first: int, count: int, paths: int = 64, splits: bool = True, stream: int = 3
) -> Tally:
    given: dict[str, Any] = {"stream": stream + splits, "clock": Clock(None), "tell": lambda _: None}
    return repetitions(*of, first=first, count=count, paths=paths, splits=splits, **given)


def many(of: tuple[Simulation, Event], count: int, splits: bool = True) -> Floats:
    """Of so many repetitions, not too many at once, the probabilities by half time and by the end."""
    parts = [tally(of, first, min(1024, count - first), splits=splits) for first in range(0, count, 1024)]
    return np.concatenate([each.exceeded for each in parts])


def mean_of(samples: Floats) -> tuple[Floats, Floats]:
    return samples.mean(axis=0), samples.std(axis=0, ddof=1) / np.sqrt(len(samples))


@pytest.mark.parametrize(
    ("system", "name"),
    [
        (WALL, "x"),
        validation(MANY, "impact_speed"),
        validation(MANY, "x"),
        validation(PAIR, "b_x"),
        validation(RECORDED, "x"),
        validation(COIL, "a_x"),
    ],
)
def test_a_kept_state_is_complete(system: sp.System, name: str) -> None:
    """With the noise of before, a path goes on from it to the same bits."""
    simulation, asked = prepared(system, name, [3.0])
    paths = _Paths(simulation, replace(asked, floor=-np.inf), 0, 256, 4, True, Clock(None), lambda _: None, None)
    ends = np.full((256, MARKS), -np.inf)
    rows = paths.advance(np.arange(256), np.full(256, -1), np.zeros(256, np.int64), ends, 0, np.arange(256))
    of_path, kept = [], []
    for path, row in enumerate(rows):
        while row >= 0:
            of_path.append(path)
            kept.append(row)
            row = paths.kept.next[row]
    assert len(kept) > 1000
    order = np.argsort(paths.kept.step[kept], kind="stable")
    whose, these = np.array(of_path)[order], np.array(kept)[order]
    again = np.empty((len(these), MARKS))
    paths.advance(whose, these, paths.kept.step[these], again, 0, whose)
    np.testing.assert_array_equal(again, ends[whose])


@pytest.mark.parametrize(
    ("system", "name", "start"),
    [
        (WALL, "x", "rest"),
        validation(ABOVE, "impact_speed", "stationary"),
        validation(MANY, "x", "rest"),
        validation(PAIR, "b_x", "rest"),
    ],
)
def test_the_bits_of_a_repetition_are_its_own(system: sp.System, name: str, start: str) -> None:
    """Not those of threads, nor of the repetitions that are advanced with it."""
    one, two = (prepared(system, name, [1.5, 3.2], threads=threads, start=start) for threads in (1, 2))
    whole = tally(two, 0, 6)
    assert whole.exceeded[:, 1, 1].any()
    parts = [tally(one, 0, 1), tally(two, 1, 2), tally(one, 3, 3)]
    np.testing.assert_array_equal(whole.exceeded, np.concatenate([each.exceeded for each in parts]))
    np.testing.assert_array_equal(whole.iterations, np.concatenate([each.iterations for each in parts]))


def test_without_splitting_paths_are_those_of_a_plain_run() -> None:
    of = prepared(LIGHT, "x", [1.0, 2.0])
    run = simulated(LIGHT, paths=64, duration=20.0, step=0.1, start="rest", record=64)
    plain = repetitions(
        *of, first=0, count=1, paths=64, stream=0, splits=False, clock=Clock(None), tell=lambda _: None
    )  # fmt: skip
    for beyond, level in zip(plain.exceeded[0, 1], (1.0, 2.0), strict=True):
        seen = (run.record[:, :, 0].max(axis=1) > level).mean()
        assert seen <= beyond <= seen + 0.05  # between two steps x may be larger


@pytest.mark.parametrize(
    ("system", "name", "sign", "given", "levels", "size"),
    [
        # ends after a few iterations: how it ends must not matter
        (WALL, "x", 1.0, {"duration": 6.0}, [0.8, 1.3], 1.0),
        validation(LIGHT, "x", 1.0, {}, [1.0, 2.0, 2.6, 3.0], 1.0),
        validation(LIGHT, "v", -1.0, {}, [-2.0, -2.6, -3.1], 2.0),
        validation(LIGHT, "amplitude", 1.0, {"start": "stationary"}, [1.5, 3.0], 2.0),
        validation(LIGHT, "x", 1.0, {"start": "stationary"}, [1.5, 2.4, 3.2], 2.0),
        validation(WALL, "x", 1.0, {}, [1.5, 2.0, 2.6], 2.0),
        validation(ABOVE, "impact_speed", 1.0, {"start": "stationary"}, [1.5, 2.2, 2.7], 2.0),
        validation(ABOVE, "x", -1.0, {"start": "stationary"}, [-1.5, -2.0, -2.5], 2.0),
        validation(MANY, "x", 1.0, {}, [1.5, 2.0, 2.4], 2.0),
        validation(MANY, "energy", 1.0, {}, [2.0, 3.0], 2.0),
        validation(WELLS, "x", 1.0, {"initial_position": -1.0}, [1.0, 1.3, 1.6], 2.0),
        validation(SHAKEN, "distance", 1.0, {}, [2.0, 3.0], 2.0),
        validation(QUAKE, "x", 1.0, {}, [1.0, 2.0, 3.0], 2.0),
        validation(SHAKEN, "speed", 1.0, {}, [2.0, 3.0], 2.0),
        validation(BETWEEN, "v", 1.0, {}, [1.4, 2.2, 3.1], 2.0),
        validation(COLORED, "x", 1.0, {}, [1.8, 2.8, 4.4], 2.0),
        validation(PAIR, "b_x", 1.0, {}, [1.5, 2.5, 3.2], 1.0),
        validation(PAIR, "a_v", -1.0, {}, [-1.5, -2.2, -3.0], 1.0),
        validation(PAIR, "a_b_elongation", 1.0, {}, [1.2, 1.9, 2.4], 1.0),
        validation(PAIR, "stop_impact_speed", 1.0, {}, [0.5, 0.9, 1.4], 1.0),
        validation(PAIR, "force_on_ground", 1.0, {}, [1.2, 2.0, 2.6], 1.0),
        validation(PAIR, "mine", 1.0, {"own": lambda a_x, b_x: a_x * a_x + b_x * b_x}, [3.0, 8.0, 14.0], 1.0),
        validation(ON_GROUND, "acceleration", -1.0, {}, [-1.5, -2.2, -3.0], 2.0),
        validation(ON_GROUND, "springpot_force", 1.0, {}, [0.2, 0.4, 0.6], 2.0),
        validation(RECORDED, "x", 1.0, {}, [1.5, 2.6, 3.4], 1.0),
        validation(WALL, "mine", 1.0, {"own": lambda t, x, v: x * abs(x)}, [2.0, 4.0, 6.8], 2.0),
    ],
)
def test_the_mean_is_that_of_plain_paths(
    system: sp.System, name: str, sign: float, given: dict[str, Any], levels: list[float], size: float
) -> None:
    """At the levels on the way too, and by half time."""
    of = prepared(system, name, levels, sign=sign, **given)
    plain, its_error = mean_of(many(of, int(24000 * size), splits=False))
    found, error = mean_of(many(of, int(8192 * size)))
    assert (np.hypot(error, its_error)[1, :2] < [0.006, 0.02] * plain[1, :2]).all()
    np.testing.assert_array_less(np.abs(found - plain), 4.0 * np.hypot(error, its_error))


@pytest.mark.validation
def test_intervals_hold_the_probability_as_often_as_they_say() -> None:
    """200 of them, each of 32 repetitions."""
    of = prepared(LIGHT, "x", [3.2], step=0.05)
    samples = many(of, 6400)[:, 1, 0].reshape(200, 32)
    true, (mean, error) = samples.mean(), mean_of(samples.T)
    wide = np.exp(scipy.stats.t.ppf(0.975, 31) * error / mean)
    assert 0.90 <= ((mean / wide < true) & (true < mean * wide)).mean() <= 0.98


@pytest.mark.validation
def test_many_small_repetitions_give_what_a_lattice_gives() -> None:
    """Of the discrete chain with h = 0.05, by a backward equation: 2.3635(80)e-3 at 3.2; 8.86(3)e-7 at 4.8."""
    of = prepared(LIGHT, "x", [3.2, 4.8], step=0.05)
    (common, rare), (error, its_error) = (each[1] for each in mean_of(many(of, 8192)))
    assert abs(common - 2.3635e-3) < 3.0 * np.hypot(error, 8e-6)
    assert abs(rare - 8.86e-7) < 3.0 * np.hypot(its_error, 3e-9)
    assert its_error < 0.05 * rare
