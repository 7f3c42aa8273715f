"""The level of a given probability: it has that probability, its interval holds, and what there is not is said."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.simulation.rare.levels import level_of
from springpot.simulation.rare.search import ExceedanceCurve
from tests import kernels
from tests.sizes import validation

LIGHT = sp.System(sp.Spring(1.0), sp.Springpot(1.0, 0.1), sp.Barrier(-50.0), sp.WhiteNoise(0.2))
WALL = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.Barrier(-0.3, 0.8), sp.WhiteNoise(0.2))
COUPLED = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a")),
    sp.Spring(1.0, between=("a", "b")), sp.Dashpot(0.5, between=("ground", "a")), sp.WhiteNoise(1.0, on="a"),
)  # fmt: skip
SHORT: dict[str, Any] = {"duration": 20.0, "step": 0.05, "start": "rest"}


def test_the_level_has_the_probability_that_was_asked() -> None:
    """Other paths exceed it as often; 8.86e-7 and 2.3635e-3 are independent values of 4.8 and 3.2 m."""
    found = sp.exceedance(LIGHT, probability={"x": [2.3635e-3, 8.86e-7]}, **SHORT, seed=2)
    own = found.level["x"]
    assert (np.abs(own.level - [3.2, 4.8]) < 4.0 * own.error).all()
    assert (own.error < [0.012, 0.03]).all()
    assert ((own.low < own.level) & (own.level < own.high)).all()
    again = sp.exceedance(LIGHT, {"x": own.level}, **SHORT, seed=3)
    z = np.log(again.probability["x"] / own.probability) / math.hypot(0.1, 0.1)
    assert (np.abs(z) < 4.0).all()


@pytest.mark.parametrize(
    ("system", "name", "probability"),
    [
        validation(WALL, "impact_speed", 1e-5), (WALL, "x", 0.3), (LIGHT, "x below", 1e-5),
        validation(WALL, "energy", 1e-5), validation(WALL, "v", 1e-4), validation(WALL, "distance", 1e-8),
        validation(LIGHT, "spring_force below", 1e-4), validation(LIGHT, "amplitude", 1e-4),
        validation(COUPLED, "a_b_elongation", 1e-4), validation(COUPLED, "b_v", 1e-5),
    ],
)  # fmt: skip
def test_so_it_is_of_every_quantity(system: sp.System, name: str, probability: float) -> None:
    found = sp.exceedance(system, probability={name: probability}, **SHORT, rtol=0.2)
    plain = name.removesuffix(" below")
    own = found.level[plain]
    assert own.low < own.level < own.high
    assert not found.warnings
    again = sp.exceedance(system, {plain: float(own.level)}, **SHORT, rtol=0.1, seed=9)
    assert abs(math.log(float(again.probability[plain]) / probability)) < 4.0 * math.hypot(0.2, 0.1)


@pytest.mark.validation  # every day: one's own functions, in test_exceedance.py
def test_a_function_of_ones_own_has_it_too() -> None:
    """One that is x has the level of x."""
    one, other = (
        sp.exceedance(LIGHT, probability=asked, **SHORT, rtol=0.2).level[name]
        for name, asked in (("x", {"x": 1e-4}), ("own", {"own": (lambda t, x, v: x, 1e-4)}))
    )
    assert abs(one.level - other.level) < 4.0 * math.hypot(one.error, other.error)
    assert str(other).startswith("own > ")


@pytest.mark.validation  # every day: the level has the probability that was asked
def test_levels_of_many_calls_differ_as_their_errors_say() -> None:
    """And most of the intervals hold their mean."""
    found = [
        sp.exceedance(LIGHT, probability={"x": 1e-4}, **SHORT, rtol=0.3, seed=seed).level["x"] for seed in range(1, 11)
    ]
    level = np.array([each.level for each in found])
    within = [each.low <= level.mean() <= each.high for each in found]
    assert sum(within) >= 8
    spread = float(level.std(ddof=1)) / math.sqrt(np.mean([each.error**2 for each in found]))
    assert 0.4 < spread < 1.7


def test_what_there_is_not_is_said() -> None:
    """Towards a near wall the motion cannot be far."""
    with pytest.warns(
        sp.RareEventWarning, match=r"no level of x was found that is exceeded with a probability of 0.001"
    ):
        found = sp.exceedance(WALL, probability={"x below": 1e-3}, **SHORT, rtol=0.5)
    assert np.isnan(found.level["x"].level)
    assert "no level of x was found that is exceeded with a probability of 0.001 in 20 s" in str(found)


@pytest.mark.validation  # every day: a level that no path reaches, in test_exceedance.py
def test_what_does_not_move_has_no_level() -> None:
    with pytest.warns(sp.RareEventWarning, match=r"no level of b_x was found"):
        found = sp.exceedance(kernels.PAIR, probability={"b_x": 1e-3}, **SHORT, rtol=0.5)
    assert np.isnan(found.level["b_x"].level)


def test_it_goes_on_from_what_was_saved(tmp_path: Path) -> None:
    given = {**SHORT, "rtol": 0.3, "probability": {"x": 1e-4}}
    whole = sp.exceedance(LIGHT, **given).level["x"]
    for _ in range(2):
        assert sp.exceedance(LIGHT, **given, save=tmp_path / "file").level["x"].level == whole.level


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({}, "levels, probability or return_period must be given, and only one of them."),
        (
            {"levels": {"x": 1.0}, "probability": {"x": 0.1}},
            "levels, probability or return_period must be given, and only one of them.",
        ),
        (
            {"probability": 1e-6},
            "probability must be a dict of names and probabilities, such as {'x': 1e-6}, not 1e-06.",
        ),
        ({"probability": {"x": 0.7}}, "probability of x must be in [1e-15, 0.5], not 0.7."),
        ({"probability": {"x": 0.0}}, "probability of x must be in [1e-15, 0.5], not 0."),
        ({"probability": {"x": []}}, "probability of x must not be empty."),
        ({"probability": {"x": "rare"}}, "probability of x must be a real number"),
        ({"probability": {"y": 0.1}}, "probability has 'y', which is no quantity that can be asked"),
        ({"probability": {"energy below": 0.1}}, "probability has 'energy below', but energy has no sides"),
        ({"probability": {"x": 0.1, "x below": 0.1}}, "probability must have each quantity once"),
    ],
)
def test_bad_input_is_said_in_one_sentence(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError)) as fault:
        sp.exceedance(LIGHT, **{"levels": None, **given}, **SHORT)
    assert str(fault.value).startswith(sentence)


def curve(levels: Any, probability: Any, downwards: bool = False) -> ExceedanceCurve:
    levels, p = np.array(levels, float), np.array(probability, float)
    return ExceedanceCurve(
        "x", "m", levels, p, 0.1 * p, p / 1.2, p * 1.2, p, p, "splitting", 32, 256, 0.5, 9.0, 1.0, 1.0, 20.0,
        downwards=downwards,
    )  # fmt: skip


def test_between_two_levels_the_logarithm_is_a_straight_line() -> None:
    found = level_of(curve([1.0, 2.0, 3.0], [1e-2, 1e-4, 1e-6]), np.array([1e-3, 1e-5, 1e-8]))
    assert found.level[:2].tolist() == pytest.approx([1.5, 2.5])
    assert found.level[2] == pytest.approx(4.0)  # as far again as the last two
    assert found.error[0] == pytest.approx(0.1 / math.log(100.0))
    assert found.high[0] - found.level[0] == pytest.approx(math.log(1.2) / math.log(100.0))
    down = level_of(curve([-3.0, -1.0, -2.0], [1e-6, 1e-2, 1e-4], True), np.array(1e-3))
    assert (float(down.level), bool(down.low < down.level < down.high)) == (pytest.approx(-1.5), True)


def test_far_beyond_a_curve_nothing_is_known() -> None:
    assert np.isnan(level_of(curve([1.0, 2.0], [1e-2, 1e-3]), np.array([1e-9])).level).all()


def test_the_command_prints_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    words = "exceedance --coefficient 0.2 --position -0.3 --restitution 0.8 --intensity 0.2 --probability x 1e-4"
    words += " --duration 20 --step 0.05 --start rest --rtol 0.3"
    problem = sp.Oscillator(
        springpot=sp.Springpot(0.5, 0.2), barrier=sp.Barrier(-0.3, 0.8), excitation=sp.WhiteNoise(0.2)
    )
    found = sp.exceedance(problem, probability={"x": [1e-4]}, **SHORT, rtol=0.3)
    assert cli.main(words.split()) == 0
    assert capsys.readouterr().out == f"{found.level['x']}\n{found['x']}\n"
    assert cli.main([*words.split(), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["level"]["x"]["level"] == found.level["x"].level.tolist()
    assert cli.main(["exceedance", "--duration", "1"]) == 2
    assert "levels, probability or return_period must be given, and only one of them." in capsys.readouterr().err


DASHED = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))


@pytest.mark.validation  # every day: the level of a return period, below
@pytest.mark.parametrize("probability", [1e-2, validation(0.5)])
def test_of_a_long_time_the_paths_have_a_short_one(probability: float) -> None:
    found = sp.exceedance(DASHED, probability={"x": probability}, duration=36000.0, rtol=0.1)
    own, (begin, end) = found.level["x"], found.settings.window
    assert (own.duration, end - begin) == (36000.0, pytest.approx(40.0 * math.pi))
    formula = float(sp.theory.exceedance_level(DASHED, {"x": probability}, 36000.0)["x"].level["envelope"])
    assert abs(own.level - formula) < 4.0 * own.error < 0.1
    assert str(own).startswith("x > ")
    assert f"with a probability of {probability:g} in 36000 s (95 %: " in str(own)
    within = found["x"].within(36000.0)
    assert ((within.low < within.probability) & (within.probability < within.high)).all()
    assert within.probability.min() < probability < within.probability.max()


def test_the_level_of_a_return_period() -> None:
    found = sp.exceedance(DASHED, return_period={"x": [3600.0, 1e7]}, rtol=0.1)
    own = found.level["x"]
    periods = sp.theory.exceedance(DASHED, {"x": own.level})["x"].return_period["envelope"]
    assert np.abs(np.log(periods / [3600.0, 1e7])).max() < 0.2
    assert "once in 3600 s (95 %: " in str(own)
    assert own.to_dict()["return_period"] == [3600.0, 1e7]
    with pytest.raises(ValueError, match=r"return_period of x must be .*at least twice the time that shows the rate"):
        sp.exceedance(DASHED, return_period={"x": 100.0})
    with pytest.raises(ValueError, match="return_period must be of a motion with a stationary state"):
        sp.exceedance(sp.System(sp.Spring(1.0), sp.WhiteNoise(0.2)), return_period={"x": 1e4})
    with pytest.raises(TypeError, match="return_period must be a dict of names and times"):
        sp.exceedance(DASHED, return_period=1e4)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="duration must be"):
        sp.exceedance(DASHED, probability={"x": 1e-4})


@pytest.mark.validation  # every day: the command prints the same, in this file
def test_the_command_takes_return_periods(capsys: pytest.CaptureFixture[str]) -> None:
    words = "exceedance --coefficient 0.2 --no-barrier --intensity 0.2 --return-period x 3600 --rtol 0.5"
    assert cli.main(words.split()) == 0
    problem = sp.Oscillator(springpot=sp.Springpot(0.5, 0.2), barrier=None, excitation=sp.WhiteNoise(0.2))
    found = sp.exceedance(problem, return_period={"x": [3600.0]}, rtol=0.5)
    assert capsys.readouterr().out == f"{found.level['x']}\n{found['x']}\n"
