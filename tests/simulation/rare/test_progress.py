"""What a call of `exceedance` shows and says while it works, and how soon it ends."""

from __future__ import annotations

import importlib
import math
import time
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine import bar
from springpot.machine.progress import Estimate, FractionDone
from springpot.simulation.rare.search import MOST_SKEW, factor_of_interval
from tests.sizes import validation

LINEAR = sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.4))
WALL = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.Barrier(-0.3, 0.8), sp.WhiteNoise(0.2))
SHORT: dict[str, Any] = {"duration": 20.0, "step": 0.1, "start": "rest", "threads": 1}


def test_a_long_call_in_python_says_so_first_and_what_has_it_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The sentence of a call of more than a hundredth of a second; of a wall there is no such theory."""
    sp.exceedance(LINEAR, {"x": 2.0}, **SHORT, rtol=1.0)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(bar, "LONG_SECONDS", 0.01)
    sp.exceedance(LINEAR, {"x": 4.5, "energy": 1.0}, **SHORT, rtol=0.6)
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith("springpot: this takes about ")
    assert said[0].endswith(
        " (max_time= ends it earlier; springpot.theory.exceedance has x at once, by formulas of the stationary state)."
    )
    sp.exceedance(WALL, {"x": 4.0}, **SHORT, rtol=0.6)
    assert capsys.readouterr().err.splitlines()[0].endswith("(max_time= ends it earlier).")


def test_a_function_for_the_progress_takes_the_place_of_the_bar(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bar, "LONG_SECONDS", 0.0)
    told = list[float]()
    sp.exceedance(WALL, {"x": 4.0}, **SHORT, rtol=0.3, progress=told.append)
    assert capsys.readouterr().err == ""
    assert 0.0 <= told[0] <= told[-1] <= 1.0


@pytest.mark.parametrize(("level", "rtol"), [(4.8, 0.2), validation(7.0, 0.1), validation(9.8, 0.3)])
def test_the_work_that_is_announced_is_about_that_which_is_done(level: float, rtol: float) -> None:
    """The first estimate of splitting, before any of its repetitions has ended, within a factor of four."""
    told = list[Estimate]()

    def watch(fraction: float) -> None:
        if isinstance(fraction, FractionDone) and fraction.estimate is not None:
            told.append(fraction.estimate)

    found = sp.exceedance(LINEAR, {"x": level}, duration=20.0, start="rest", step=0.02, rtol=rtol, progress=watch)["x"]
    first = next(estimate for estimate in told if "of 256 paths" in estimate.reason)
    assert 0.25 < first.path_steps / found.path_steps < 4.0


def test_what_a_progress_function_raises_ends_the_call_soon() -> None:
    begun = math.inf

    def told(fraction: float) -> None:
        nonlocal begun
        begun = time.monotonic()
        raise RuntimeError("enough")

    sp.exceedance(LINEAR, {"x": 1.0}, **SHORT, rtol=1.0)  # the kernel is there
    with pytest.raises(RuntimeError, match="enough"):
        sp.exceedance(LINEAR, {"x": 14.0}, duration=4000.0, step=0.005, start="rest", rtol=0.05, progress=told)
    assert time.monotonic() - begun < 2.5


def test_max_time_counts_compilation() -> None:
    with pytest.raises(TimeoutError, match=r"A compilation, up to half a minute, counts too\."):
        sp.exceedance(LINEAR, {"x": 9.0}, duration=2000.0, step=0.005, start="rest", max_time=1e-6)
    with pytest.raises(TimeoutError, match="counts too"):
        sp.simulate(LINEAR, rtol=1e-3, max_time=1e-6)


@pytest.mark.parametrize("deviation", [0.6, 0.8, 1.0])  # of the logarithm of what a repetition finds
def test_intervals_of_skew_repetitions_hold(deviation: float) -> None:
    """32 repetitions, whose law is lognormal: of 4000 intervals 94 % or more hold the mean, where the spread of the
    samples alone gives 89 to 93 %."""
    generator = np.random.default_rng(1)
    shares = np.exp(deviation * generator.normal(size=(32, 4000)) - 0.5 * deviation**2)
    log_p = np.log(shares.mean(axis=0))
    share_of = [float((np.abs(log_p) <= np.log(factor_of_interval(shares, splits))).mean()) for splits in (False, True)]
    assert share_of[0] < 0.937
    assert 0.938 < share_of[1] < 0.98
    assert (factor_of_interval(shares) <= factor_of_interval(shares, False) ** MOST_SKEW * (1.0 + 1e-12)).all()


@pytest.mark.validation
def test_intervals_of_rare_events_hold() -> None:
    """Of 200 calls each, against the mean of all: between 1e-4 and 1e-8."""
    module = importlib.import_module("springpot.simulation.rare.exceedance")
    levels = {"x": [4.2, 4.8, 5.7]}
    curves = [module.exceeded(LINEAR, levels, **SHORT, rtol=0.2, seed=seed)["x"] for seed in range(1, 201)]
    truth = np.mean([curve.probability for curve in curves], axis=0)
    held = np.mean([(curve.low <= truth) & (truth <= curve.high) for curve in curves], axis=0)
    assert (held >= 0.92).all()
    assert truth[0] > 1e-4
    assert truth[-1] < 1e-7
