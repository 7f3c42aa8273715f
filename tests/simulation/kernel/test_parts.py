"""A part from outside: new physics without a change to the kernel, tested against what is exact about it."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit
from scipy import integrate
from springpot.simulation.kernel.block import COLUMNS
from springpot.simulation.kernel.forces import only_pushes
from springpot.simulation.kernel.questions import Splitting, answers, begin, bounce, clearance, extras, push
from springpot.simulation.kernel.restitution import Fixed
from springpot.simulation.kernel.rigid_wall import fly

from springpot.simulation.kernel.lanes import INLINE
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.paths.statistics import standard_error
from springpot.simulation.plan.plan import plan_of
from tests.simulation.problems import oscillator


class Cubic(NamedTuple):
    """White noise and a hardening spring beside the linear one: -cubic x^3."""

    strength: float
    cubic_step: float


only_pushes(Cubic)


@answers(push, Cubic)
def _push_cubic(force, slot, n, x, v, g, forcing, at, lane, weight):  # type: ignore[no-untyped-def]
    return force.strength * g, -force.cubic_step * x * x * x


class Slot(NamedTuple):
    """Two elastic walls, at +-half."""

    half: float


@answers(extras, Slot)
def _no_extras(wall):  # type: ignore[no-untyped-def]
    return 0


@answers(clearance, Splitting, Slot)
def _clearance_slot(scheme, wall, least, greatest):  # type: ignore[no-untyped-def]
    dip = wall.half * (scheme.frequency * scheme.step) ** 2 * (1.01 / 32.0)
    return wall.half - dip - max(-least, greatest)


@answers(begin, Splitting, Slot)
def _begin_slot(scheme, wall, x, v, early, accumulators, lane, weight):  # type: ignore[no-untyped-def]
    return x, v


@njit(**INLINE)
def _fly(scheme, wall, side, x, v, accumulators, lane, weight):  # type: ignore[no-untyped-def]
    phase, none = 0.5 * scheme.frequency * scheme.step, 0.0
    place, rule = -wall.half, Fixed(1.0)
    x, v = fly(place, rule, scheme, side * x, side * v, phase, none, none, none, accumulators, lane, weight)
    return side * x, side * v


@answers(bounce, Splitting, Slot)
def _bounce_slot(scheme, wall, x, v, push, accumulators, lane, before, after):  # type: ignore[no-untyped-def]
    """Half a step at a time above the wall on the side of the motion: it is too short to reach the other one."""
    side = 1.0 if v <= 0.0 else -1.0
    xm, vm = _fly(scheme, wall, side, x, v, accumulators, lane, before)
    side = 1.0 if vm <= 0.0 else -1.0
    xn, vn = _fly(scheme, wall, side, xm, vm, accumulators, lane, after)
    return xm, vm, xn, vn


def _rows(problem: Any, given: dict[str, Any], **parts: Any) -> dict[str, Any]:
    """All in double precision, so that the tests share a kernel."""
    simulation = simulation_of(plan_of(problem, **given, start="rest", memory_tolerance=1e-8))
    assert (simulation.parts.units.length, simulation.parts.units.time) == (1.0, 1.0)
    rows = simulation.with_parts(**{k: make(simulation.parts) for k, make in parts.items()}).advance().rows
    return dict(zip(COLUMNS, rows.T, strict=True)) | {"steps": np.diff(simulation.settings.window_steps)[0]}


def test_a_cubic_spring_between_two_walls_has_the_maxwell_boltzmann_law() -> None:
    """Order 1, elastic: the density is exp(-(2 c / q) (v^2 / 2 + potential)) between the walls."""
    half, cubic, step = 0.9, 1.5, 0.02
    found = _rows(
        oscillator(1.0, 1.0, 1.0, 1.0),
        {"paths": 8192, "duration": 60.0, "step": step, "window": (15.0, 60.0)},
        load=lambda plain: Cubic(plain.load.strength, cubic * step),
        wall=lambda _: Slot(half),
    )

    def mean(f: Any) -> float:
        def weighed(x: float) -> float:
            return f(x) * math.exp(-(x**2) - 0.5 * cubic * x**4)

        return float(integrate.quad(weighed, -half, half)[0])

    squares, speeds = found["x_square"] / found["steps"], found["v_square"] / found["steps"]
    exact = mean(lambda x: x * x) / mean(lambda x: 1.0)
    # the cubic spring is kicked, which leaves a bias of the order of the step squared
    assert abs(squares.mean() - exact) < 4.0 * standard_error(squares) + step**2 * exact
    assert abs(speeds.mean() - 0.5) < 4.0 * standard_error(speeds)
    rates = found["impacts"] / 45.0
    wall = 2.0 * math.exp(-(half**2) - 0.5 * cubic * half**4) / mean(lambda x: 1.0)
    exact_rate = wall * math.sqrt(1.0 / (4.0 * math.pi))
    assert abs(rates.mean() - exact_rate) < 4.0 * standard_error(rates) + 0.5 * step**2
    assert standard_error(rates) < 0.005 * exact_rate
    assert standard_error(squares) < 0.005 * exact


def test_a_part_that_does_the_same_gives_the_same_path() -> None:
    """A cubic spring of no stiffness is white noise alone, and two walls out of reach are none."""
    given = {"paths": 64, "duration": 3.0, "step": 0.02}
    plain = _rows(oscillator(position=None), given)
    again = _rows(
        oscillator(position=None), given,
        load=lambda plain: Cubic(plain.load.strength, 0.0), wall=lambda _: Slot(1e9),
    )  # fmt: skip
    assert again["x_square"] == pytest.approx(plain["x_square"], rel=1e-12)


def test_two_parts_of_one_name_are_refused() -> None:
    """Compiled code could not tell them apart, and would run the first one's for both."""

    class White(NamedTuple):
        strength: float

    with pytest.raises(ValueError, match="push of White is defined already: give the part another name"):
        answers(push, White)


@pytest.mark.validation
def test_a_part_from_elsewhere_is_never_kept_on_disk(tmp_path: Path) -> None:
    """Nobody can tell what its code depends on: here on a module that is edited between two processes."""
    (tmp_path / "somebody.py").write_text("""
from typing import NamedTuple
from elsewhere import FACTOR
from springpot import Oscillator, simulate
from springpot.simulation.kernel.block import block
from springpot.simulation.kernel.forces import only_pushes
from springpot.simulation.kernel.questions import answers, push
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.paths.simulation import simulation_of

class Mine(NamedTuple):
    size: float

only_pushes(Mine)

@answers(push, Mine)
def _mine(force, slot, n, x, v, g, forcing, at, lane, weight):
    return FACTOR * force.size, 0.0

plan = plan_of(Oscillator(), paths=1, duration=0.1, step=0.05, start="rest")
mine = simulation_of(plan).with_parts(load=Mine(1.0)).advance().rows[0, 0]
plain = simulate(Oscillator(), paths=1, duration=0.1, step=0.05, start="rest")["x_mean"].value
print(mine, plain, sum(block.stats.cache_hits.values()))
""")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}

    def process() -> list[float]:
        words = [sys.executable, str(tmp_path / "somebody.py")]
        done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
        return [float(word) for word in done.stdout.split()]

    (tmp_path / "elsewhere.py").write_text("FACTOR = 1.0\n")
    first, plain, hits = process()
    assert first > 0.0
    assert hits == 0
    (tmp_path / "elsewhere.py").write_text("FACTOR = 3.0\n")
    assert process() == [pytest.approx(3.0 * first), plain, 1]  # the kernel of the house is found
