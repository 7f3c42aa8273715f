"""`exceedance`: against independent values, with its choices, its warnings and its sentences."""

from __future__ import annotations

import importlib
import json
import math
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot import cli
from springpot.machine.progress import Clock
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.rare import search
from springpot.simulation.rare.exceedance import hint_of
from tests import kernels
from tests.sizes import validation

LIGHT = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.1), sp.Barrier(-50.0), sp.WhiteNoise(0.2))
WALL = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.Barrier(-0.3, 0.8), sp.WhiteNoise(0.2))
CUBIC = sp.PolynomialSpring((0.0, 0.0, 1.0))
PAIR = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("a", "b")), sp.WhiteNoise(1.0, on="a")
)
SHORT: dict[str, Any] = {"duration": 20.0, "step": 0.05, "start": "rest"}


def off(found: Any, level: int, value: float, its_share: float, name: str = "x") -> float:
    """In standard errors of both."""
    p, error = found.probability[name][level], found.error[name][level]
    return float(abs(p - value) / math.hypot(error, its_share * value))


def test_a_curve_of_levels_from_one_run() -> None:
    found = sp.exceedance(LIGHT, {"x": [4.8, 1.0, 3.2]}, **SHORT)
    p, curve = found.probability["x"], found["x"]
    assert curve.method == "splitting"
    assert not found.warnings
    assert (found.error["x"] <= 0.1 * p).all()
    assert off(found, 0, 8.86e-7, 0.004) < 4.0
    assert off(found, 2, 2.3635e-3, 0.004) < 4.0
    assert ((curve.low < p) & (p < curve.high)).all()
    assert curve.return_period[0] > curve.return_period[2] > curve.return_period[1]
    time, first = str(found).splitlines()[:2]
    assert time == "in 20 s:"
    assert first.startswith("x > 4.8 m: (8.")
    assert repr(found) == "Exceedance(3 levels of x in 20 s: 0 warnings)"


def test_one_level_and_many_quantities() -> None:
    found = sp.exceedance(WALL, {"x": 2.0, "impact_speed": [[1.0, 2.0]]}, **SHORT, rtol=0.3)
    assert found.probability["x"].shape == ()
    assert found.probability["impact_speed"].shape == (1, 2)
    assert found["impact_speed"].unit == "m s-1"
    with pytest.raises(KeyError, match="impact_speed"):
        found["impact_sped"]


def test_several_masses_forces_and_functions_of_ones_own() -> None:
    """A force and a function that is x have its probabilities, to the last bit on plain paths."""
    found = sp.exceedance(
        kernels.PAIR, {"a_x": [1.0, 4.5], "own": (lambda a_x: a_x, 1.0), "spring_1_force": 1.0}, **SHORT, rtol=0.3
    )
    assert found["a_x"].method == "splitting"
    for name in ("own", "spring_1_force"):
        assert abs(found.probability[name] - found.probability["a_x"][0]) < 0.1
    assert str(found["own"]).startswith("own > 1: ")


def test_the_force_of_a_dashpot_has_the_probabilities_of_its_speed_at_a_long_step() -> None:
    """Its mean over a step is smaller than its largest value in between, which counts."""
    given = {"v": 2.0, "springpot_force": 0.2}
    found = sp.exceedance(LIGHT, given, duration=20.0, step=0.1, start="rest", rtol=0.02)
    (p, other), (error, its_error) = ([of[name] for name in given] for of in (found.probability, found.error))
    assert abs(p - other) < 3.0 * np.hypot(error, its_error) < 0.09 * p


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_what_all_paths_exceed_has_a_bound_and_no_return_period() -> None:
    curve = sp.exceedance(LIGHT, {"x": [0.01, 1.0]}, **SHORT, rtol=0.3)["x"]
    number = curve.paths * curve.repetitions
    assert curve.probability[0] == curve.high[0] == 1.0
    assert curve.low[0] == pytest.approx(1.0 - 3.0 / number, abs=1e-5)
    assert curve.error[0] > 0.0
    assert np.isnan([curve.rate[0], curve.return_period[0]]).all()
    assert np.isfinite([curve.rate[1], curve.return_period[1]]).all()


def test_what_is_exceeded_downwards_is_printed_so() -> None:
    curve = sp.exceedance(LIGHT, {"x": -1.0}, **SHORT, rtol=0.3)["x"]
    assert curve.downwards
    assert str(curve).startswith("x < -1 m: ")


def test_without_a_stationary_state_there_are_probabilities_and_no_return_periods() -> None:
    noise = sp.WhiteNoise(0.2, on="a", envelope=sp.ExponentialEnvelope(slow=0.2, fast=0.6))
    shaken = sp.System(*(part for part in kernels.PAIR.parts if not isinstance(part, sp.WhiteNoise)), noise)
    curve = sp.exceedance(shaken, {"a_x": [0.2, 0.5]}, **SHORT, rtol=0.5)["a_x"]
    assert ((curve.probability > 0.0) & (curve.probability < 1.0)).all()
    assert np.isnan([curve.rate, curve.rate_error, curve.return_period]).all()
    assert "once in" not in str(curve)
    assert str(curve).endswith("return periods of a_x: not known: the motion has no stationary state.")
    with pytest.raises(ValueError, match="no stationary state"):
        sp.figures.plot_return_periods(curve)
    assert not motion_of(sp.System(sp.Spring(1.0), sp.WhiteNoise(0.2))).settles
    assert motion_of(LIGHT).settles


def test_a_stationary_motion_far_from_a_wall_exceeds_levels_above_its_mean() -> None:
    """As long as the wall is far away the mean is 0, not that of a wall at 0, which is 0.8."""
    found = sp.exceedance(LIGHT, {"x": 0.5}, duration=1.0, step=0.1, start="stationary", rtol=0.3)
    beyond = float(scipy.stats.norm.sf(0.5))  # of which it must be more
    assert beyond + 0.05 < found.probability["x"] < beyond + 0.3


def test_what_is_not_rare_is_counted_on_plain_paths() -> None:
    found = sp.exceedance(LIGHT, {"x": [1.0, 2.0]}, **SHORT, rtol=0.05)
    assert found["x"].method == "plain"
    assert (found.error["x"] < 0.05 * found.probability["x"]).all()


def test_the_same_seed_gives_the_same_bits_for_any_number_of_threads() -> None:
    one, two = (sp.exceedance(WALL, {"x": 3.2}, **SHORT, threads=threads, rtol=0.2) for threads in (1, 2))
    assert one.probability == two.probability
    assert one["x"].repetitions == two["x"].repetitions
    assert sp.exceedance(WALL, {"x": 3.2}, **SHORT, seed=2, rtol=0.2).probability != one.probability


def test_a_mirrored_system_has_the_mirrored_law() -> None:
    other = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.Barrier(0.3, 0.8, "below"), sp.WhiteNoise(0.2))
    for name, level, its_own in (("x", 3.0, -3.0), ("v", 3.0, -3.0), ("distance", 3.0, 3.0)):
        a, b = (
            sp.exceedance(system, {name: at}, **SHORT, rtol=0.1) for system, at in ((WALL, level), (other, its_own))
        )
        error = math.hypot(a.error[name], b.error[name])
        assert abs(a.probability[name] - b.probability[name]) < 3.5 * error < 0.6 * a.probability[name]


@pytest.mark.validation
def test_thermal_motion_has_boltzmanns_law_at_once() -> None:
    """Energy over kT in so short a time that hardly any path rises: exp(-E/kT) at least, and a little more."""
    system = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.ThermalNoise(1.0))
    found = sp.exceedance(system, {"energy": [1.0, 8.0]}, duration=0.02, step=0.005)
    assert (found.probability["energy"] > np.exp([-1.0, -8.0])).all()
    assert (found.probability["energy"] < 1.2 * np.exp([-1.0, -8.0]) + 3.0 * found.error["energy"]).all()


@pytest.mark.parametrize(
    ("system", "given", "levels", "expected"),
    [
        validation(LIGHT, {}, [3.2, 4.8, 6.0], [(2.3635e-3, 0.003), (8.86e-7, 0.003), (3.53e-10, 0.006)]),
        validation(WALL, {}, [2.6, 3.6], [(1.709e-3, 0.013), (1.513e-6, 0.016)]),
        # 3.981(9)e-3 and 1.666(3)e-6 in continuous time, and the step's 0.9 and 1.0 %
        validation(LIGHT, {"name": "distance"}, [3.2, 4.8], [(4.017e-3, 0.004), (1.682e-6, 0.004)]),
        validation(LIGHT, {"start": "stationary"}, [3.2, 4.8], [(1.667e-2, 0.012), (3.09e-5, 0.015)]),
    ],
)
def test_independent_values(
    system: sp.System, given: dict[str, Any], levels: list[float], expected: list[tuple[float, float]]
) -> None:
    """By a backward equation on a lattice, by elementary failure events, by other splitting in another program."""
    name = given.get("name", "x")
    found = sp.exceedance(system, {name: levels}, **{**SHORT, "start": given.get("start", "rest")}, rtol=0.03)
    for n, value in enumerate(expected):
        assert off(found, n, *value, name) < 3.5
    assert (found.error[name] <= 0.03 * found.probability[name]).all()


@pytest.mark.validation
def test_the_rate_is_that_after_the_start() -> None:
    """From probabilities in 10, 20 and 40 s of stationary motion, on a lattice: 7.41e-4 and 7.26e-4 per s."""
    for duration, rate, p in ((20.0, 7.41e-4, 0.01667), (40.0, 7.26e-4, 0.03084)):
        found = sp.exceedance(LIGHT, {"x": 3.2}, duration=duration, step=0.05, rtol=0.01)["x"]
        assert abs(found.probability - p) < 4.0 * math.hypot(found.error, 0.004 * p)
        assert abs(found.rate - rate) < 4.0 * math.hypot(found.rate_error, 0.01 * rate)


@pytest.mark.validation  # every day: a mirrored system, and the mean over splitting
@pytest.mark.parametrize("rtol", [0.4, validation(0.03)])
def test_very_light_damping_from_rest(rtol: float) -> None:
    """Damping ratio 0.001.  The amplitude is the radius of a diffusing point, whose equation was solved on a grid."""
    # free, of the kernel of the others
    system = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.002), sp.Barrier(-50.0), sp.WhiteNoise(0.02))
    found = sp.exceedance(system, {"amplitude": [2.0, 4.0, 5.2]}, duration=100.0, step=0.2, start="rest", rtol=rtol)
    for n, value in enumerate((0.2156, 3.135e-4, 7.22e-7)):
        assert off(found, n, value, 0.01, "amplitude") < 3.5
    assert found["amplitude"].spread < 1.0
    assert not found.warnings


@pytest.mark.validation
def test_very_light_damping_in_the_steady_state() -> None:
    """Within two relaxation times: the rates are those of the envelope, and the errors are as large as they say."""
    system = sp.System(sp.Spring(1.0), sp.Dashpot(0.002), sp.WhiteNoise(0.004))
    levels = [3.0, 4.0, 5.0]
    rates = sp.theory.exceedance(system, {"x": levels})["x"].rate["envelope"]
    runs = [sp.exceedance(system, {"x": levels}, duration=2000.0, step=0.2, rtol=0.2, seed=s)["x"] for s in range(16)]
    found, said = np.mean([run.rate for run in runs], axis=0), np.array([run.rate_error for run in runs])
    error = np.sqrt((said**2).sum(axis=0)) / len(runs)
    assert (error < 0.03 * rates).all()
    assert (np.abs(found - rates) < 3.5 * np.hypot(error, 0.01 * rates)).all()
    off_by = np.array([run.probability for run in runs]) - np.mean([run.probability for run in runs], axis=0)
    assert (np.abs(off_by / [run.error for run in runs]) < 4.0).all()


SHOTS = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.02), sp.PoissonImpulses(0.01, 9.0))


@pytest.mark.validation
def test_two_ways_to_a_level_show_in_the_spread() -> None:
    """Noise that adds up, and one large impulse, which no energy announces."""
    with pytest.warns(sp.RareEventWarning, match="the repetitions of x differ by"):
        found = sp.exceedance(SHOTS, {"x": 14.0}, **{**SHORT, "step": 0.1}, rtol=0.2)
    assert found["x"].spread > 1.0


@pytest.mark.validation
def test_plain_paths_go_on_where_splitting_costs_more() -> None:
    found = sp.exceedance(SHOTS, {"x": 6.0}, **{**SHORT, "step": 0.1}, rtol=0.05)
    assert found["x"].method == "plain"
    assert found.error["x"] < 0.05 * found.probability["x"]


class OverSoon(Clock):
    """A clock whose time is over when it has been asked so often: after the plain paths, amid the splitting."""

    asked = 0

    @property
    def left(self) -> float:
        self.asked += 1
        return 0.0 if self.asked > 50 else 1.0


def test_the_time_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(TimeoutError, match="max_time is too short for any result"):
        sp.exceedance(LIGHT, {"x": 3.0}, **SHORT, max_time=1e-9)
    long = {**SHORT, "duration": 1000.0}
    monkeypatch.setattr(importlib.import_module("springpot.simulation.rare.exceedance"), "Clock", OverSoon)
    with pytest.warns(sp.RareEventWarning, match=r"no path exceeded x of 11 m: its probability is at most|known to"):
        found = sp.exceedance(LIGHT, {"x": 11.0}, **long, max_time=1.0)
    assert 0.0 <= found.probability["x"] < 1e-3
    assert found["x"].high < 0.2


def test_a_level_out_of_reach_has_a_bound_after_the_first_repetitions() -> None:
    with pytest.warns(sp.RareEventWarning, match=r"no path exceeded x of 27 m: its probability is at most"):
        found = sp.exceedance(LIGHT, {"x": [3.2, 27.0]}, **SHORT, rtol=0.3)["x"]
    assert found.paths * found.repetitions == 32 * 256
    assert np.isnan([found.rate[1], found.rate_error[1], found.return_period[1]]).all()
    assert found.high[1] < 1e-12
    assert abs(found.probability[0] - 2.3635e-3) < 4.0 * found.error[0] < 1e-3


def test_a_level_out_of_reach_does_not_keep_others_from_their_accuracy() -> None:
    with pytest.warns(sp.RareEventWarning, match=r"no path exceeded x of 27 m"):
        found = sp.exceedance(LIGHT, {"x": [3.2, 27.0]}, **SHORT, rtol=0.035)["x"]
    assert found.paths == 256
    assert found.high[1] < 1e-12
    assert found.error[0] <= 0.035 * found.probability[0]
    assert abs(found.probability[0] - 2.3635e-3) < 4.0 * found.error[0]


def test_the_time_that_is_left_is_told_before_it_passes() -> None:
    """From the steps of a path and a usual speed at first, then as measured."""
    told = list[Any]()

    def progress(fraction: float) -> None:
        told.append(fraction)
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        sp.exceedance(LIGHT, {"x": 12.0}, duration=4e4, step=0.05, start="rest", threads=1, progress=progress)
    estimate = told[0].estimate
    assert estimate.path_steps == 2048 * 8e5
    assert 5.0 < estimate.seconds < 10.0
    assert estimate.sentence.endswith("32 repetitions of 64 paths")


def test_time_that_is_over_for_one_quantity_leaves_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    module = importlib.import_module("springpot.simulation.rare.exceedance")
    search = module.search

    def late(simulation: Any, asked: Any, *rest: Any) -> Any:
        if asked.name == "v":
            raise TimeoutError
        return search(simulation, asked, *rest)

    monkeypatch.setattr(module, "search", late)
    with pytest.warns(sp.RareEventWarning, match=r"no path exceeded v of 1 m s-1: its probability is at most 1\."):
        found = sp.exceedance(LIGHT, {"x": [0.1], "v": [1.0, 2.0]}, **SHORT, rtol=1.0)
    assert found.probability["x"][0] > 0.5
    assert np.isnan(found.probability["v"]).all()
    assert (found["v"].high == 1.0).all()


def test_a_run_goes_on_from_what_it_has_saved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the same bits, wherever it was killed; and what has ended is not computed again."""
    place, given = tmp_path / "found.jsonl", {**SHORT, "rtol": 0.3}
    whole = sp.exceedance(WALL, {"x": [2.0, 3.2]}, **given)
    assert sp.exceedance(WALL, {"x": [2.0, 3.2]}, **given, save=place).probability["x"].tolist() == (
        whole.probability["x"].tolist()
    )
    lines = place.read_bytes().splitlines(keepends=True)
    assert len(lines) == 32 + whole["x"].repetitions  # the plain paths first
    computed, of = list[int](), search.repetitions
    monkeypatch.setattr(search, "repetitions", lambda *a, **k: computed.append(k["first"]) or of(*a, **k))
    for ended, missing in ((29, [29, 30, 31, *range(32)]), (40, [*range(8, 32)]), (64, [])):
        place.write_bytes(b"".join(lines[:ended]) + b"".join(lines[ended : ended + 1])[:40])  # killed while it wrote
        again = sp.exceedance(WALL, {"x": [2.0, 3.2]}, **given, threads=1, save=place)["x"]
        assert again.probability.tolist() == whole.probability["x"].tolist()
        assert again.error.tolist() == whole["x"].error.tolist()
        assert computed == missing
        computed.clear()
    place.write_text("something else\n", encoding="utf-8")
    with pytest.raises(ValueError, match="save must be a file of exceedance or a new one"):
        sp.exceedance(WALL, {"x": 2.0}, **given, save=place)


def test_progress_ends_a_run() -> None:
    def told(fraction: float) -> None:
        assert 0.0 <= fraction <= 1.0
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sp.exceedance(LIGHT, {"x": 12.0}, duration=400.0, step=0.01, start="rest", progress=told)


@pytest.mark.parametrize(
    ("system", "levels", "given", "sentence"),
    [
        (LIGHT, {"y": 1.0}, {}, "levels has 'y', which is no quantity"),
        (LIGHT, {"impact_sped": 1.0}, {}, "did you mean impact_speed?"),
        (LIGHT, [1.0], {}, "levels must be a dict of names and levels"),
        (LIGHT, {}, {}, "levels must be a dict of names and levels"),
        (LIGHT, {"x": []}, {}, "levels of x must not be empty"),
        (LIGHT, {"x": [1.0, math.nan]}, {}, "level of x must be"),
        (LIGHT, {"x": "high"}, {}, "level of x must be a real number"),
        (LIGHT, {"distance": 0.0}, {}, "level of distance must be"),
        (LIGHT, {"x": [-1.0, 1.0]}, {}, "levels of x must lie on one side of the start, 0 m"),
        (WALL, {"x": -0.5}, {}, "levels of x must lie between the walls, -0.3 and inf m"),
        (
            sp.System(sp.Spring(1.0), sp.Barrier(-0.3), sp.Barrier(0.5, free_side="below"), sp.WhiteNoise(0.2)),
            {"distance": 0.5},
            {},
            "levels of distance must be less than that of the farther wall, 0.5 m",
        ),
        (sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.WhiteNoise(1.0)), {"impact_speed": 1.0}, {}, "need a wall"),
        (sp.System(CUBIC, sp.Dashpot(1.0), sp.WhiteNoise(1.0)), {"energy": 1.0}, {}, "need a linear spring"),
        (LIGHT, {"x": 1.0}, {"rtol": 0.001}, "rtol must be in [0.01, 1]"),
        (LIGHT, {"x": 1.0}, {"max_time": 0.0}, "max_time must be"),
        (LIGHT, {"x": 1.0}, {"duration": None}, "duration must be a real number"),
        (LIGHT, {"x": 1.0}, {"progress": 1}, "progress must be a function"),
        (LIGHT, {"x": 1.0}, {"save": 1}, "save must be the place of a file"),
        (LIGHT, {"x": 1.0}, {"save": "nowhere/x"}, "save must lie in a folder that exists"),
        (LIGHT, {"own": (lambda t, x, v: x, 1.0)}, {"save": "x"}, "save cannot be given with the function of own"),
        (LIGHT, {"x": 1.0}, {"seed": -1}, "seed must be in"),
        (PAIR, {"x": 1.0}, {}, "levels has 'x', which is no quantity that can be asked"),
        (PAIR, {"x": 1.0}, {}, 'a function: {"difference": (lambda a_x, b_x: a_x - b_x, levels)}.'),
        (PAIR, {"a_x": [-1.0, 1.0]}, {}, "levels of a_x must lie on one side of the start, 0 m"),
        (PAIR, {"a_acceleration": 1.0}, {}, "a_acceleration cannot be seen: white_noise would be in it"),
        (LIGHT, {"spring_force": [-1.0, 1.0]}, {}, "levels of spring_force must lie on one side of 0"),
        (LIGHT, {"own": (lambda y: y, 1.0)}, {}, "argument"),
        (LIGHT, {"x": (lambda t, x, v: x, 1.0)}, {}, "x"),
        (sp.System(sp.Spring(1.0), sp.Dashpot(1.0)), {"x": 1.0}, {}, "system must have noise, a random phase"),
        (1.0, {"x": 1.0}, {}, "system must be a System"),
    ],
)
def test_bad_input_is_said_in_one_sentence(system: Any, levels: Any, given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=re.escape(sentence)) as fault:
        sp.exceedance(system, levels, **{**SHORT, **given})
    assert str(fault.value).count("\n") == 0


def test_the_command_prints_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    words = (
        "exceedance --coefficient 0.2 --position -0.3 --restitution 0.8 --intensity 0.2 --levels x 1.0 --levels x 3.2"
    )
    words += " --duration 20 --step 0.05 --start rest --rtol 0.3"
    problem = sp.Oscillator(
        springpot=sp.Springpot(0.5, 0.2), barrier=sp.Barrier(-0.3, 0.8), excitation=sp.WhiteNoise(0.2)
    )
    found = sp.exceedance(problem, {"x": [1.0, 3.2]}, **SHORT, rtol=0.3)
    assert cli.main(words.split()) == 0
    assert capsys.readouterr().out == f"{found['x']}\n"
    assert cli.main([*words.split(), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)["curves"]["x"]
    assert shown["probability"] == found.probability["x"].tolist()
    assert shown["method"] == "splitting"
    assert cli.main(["exceedance", "--levels", "y", "1", "--duration", "1"]) == 2
    assert "no quantity that can be asked" in capsys.readouterr().err


DASHED = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))


def test_a_longer_time_follows_from_the_rate() -> None:
    found = sp.exceedance(DASHED, {"x": [4.2, 4.8]}, duration=160.0, rtol=0.1)["x"]
    hour = sp.theory.exceedance(DASHED, {"x": [4.2, 4.8]})["x"].probability(3600.0)["envelope"]
    within = found.within(3600.0)
    assert (np.abs(within.probability - hour) < 4.0 * within.error + 0.05 * hour).all()
    assert ((within.low < within.probability) & (within.probability < within.high)).all()
    assert found.within(160.0).probability == pytest.approx(found.probability)
    with pytest.raises(ValueError, match="duration must be"):
        found.within(100.0)


@pytest.mark.validation  # every day: a longer time follows from the rate
def test_of_what_is_not_known_a_longer_time_has_a_bound() -> None:
    with pytest.warns(sp.RareEventWarning, match="no path exceeded"):
        curve = sp.exceedance(LIGHT, {"x": [0.01, 27.0]}, **SHORT, rtol=0.3)["x"]
    within = curve.within(2000.0)
    assert (within.probability[0], within.high[0]) == (1.0, 1.0)
    assert within.probability[1] == within.low[1] == 0.0
    assert 100.0 * curve.high[1] < within.high[1] < 300.0 * curve.high[1]


def test_each_level_is_printed_with_its_intervals() -> None:
    curve = sp.exceedance(LIGHT, {"x": 3.2}, **SHORT, rtol=0.3)["x"]
    low, high = curve.return_interval
    said = f"(95 %: {curve.low:.2g} to {curve.high:.2g}), once in {curve.return_period:.2g} s (95 %: {low:.2g} to "
    assert said + f"{high:.2g})" in str(curve)


def test_a_few_repetitions_that_make_most_of_it_widen_the_interval_and_are_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", sp.RareEventWarning)
        sp.exceedance(LIGHT, {"x": 4.8}, **SHORT, rtol=0.2)
    monkeypatch.setattr(importlib.import_module("springpot.simulation.rare.search"), "WIDE", 0.5)
    with pytest.warns(sp.RareEventWarning, match=r"interval of the probability of x above 4.8 m, .* times as wide as"):
        sp.exceedance(LIGHT, {"x": 4.8}, **SHORT, rtol=0.2)


def test_a_time_that_is_too_long_says_what_to_ask_for() -> None:
    with pytest.raises(TimeoutError, match=r"periods of the stationary state, duration=1.3e\+02, and take .within"):
        sp.exceedance(DASHED, {"x": 5.0}, duration=1e6, max_time=0.2)
    said = hint_of(DASHED, {"x": 5.0}, "max_time= ends it earlier", duration=1e6)()
    assert (
        "; duration=1.3e+02 and .within(1e+06) of the curve take less time; springpot.theory.exceedance has x" in said
    )


@pytest.mark.parametrize(
    ("system", "name", "asks"),
    [
        (LIGHT, "x", "{'distance': 1}"), (LIGHT, "v", "{'speed': 1}"), (PAIR, "a_x", "{'a_distance': 1}"),
        (PAIR, "a_b_elongation", "{'a_b_distance': 1}"),
        (LIGHT, "spring_force", "{'peak': (lambda spring_force: abs(spring_force), 1)}"),
    ],
)  # fmt: skip
def test_levels_on_both_sides_are_refused_with_what_has_both(system: sp.System, name: str, asks: str) -> None:
    with pytest.raises(ValueError, match="must lie on one side of") as fault:
        sp.exceedance(system, {name: [-1.0, 1.0]}, **SHORT)
    assert str(fault.value).endswith(f"ask for both as {asks}.")
    quantities = eval(asks)  # the advice itself
    assert [*sp.exceedance(system, quantities, **SHORT, rtol=1.0).curves] == [*quantities]
