"""Observers of user-defined observables and of extremes.

Each observer is compiled separately, and the kernel calls it through its address (see
:mod:`springpot.simulation.kernel.watching`).  So it needs no new kernel, and runs without it are not slower.
"""

from __future__ import annotations

import inspect
import keyword
import math
from collections.abc import Callable
from functools import cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from numba import cfunc, njit
from numba.core.errors import NumbaError

from springpot.machine.faults import cause_of, shown
from springpot.problem.catalogue import possible_results
from springpot.problem.system import System
from springpot.simulation.kernel.cache import callback
from springpot.simulation.kernel.lanes import FAST, GROUP, INLINE, LANES
from springpot.simulation.kernel.watching import HEADER, ON_IMPACTS, ON_STEPS, Observer
from springpot.simulation.watch.distributions import SKETCHED

__all__ = [
    "COUNTED",
    "EXTREMES",
    "OF_A_POINT",
    "OF_A_WALL",
    "PARTS_OF_ERROR",
    "extremes",
    "faster_than",
    "is_taken",
    "mean_of",
]

Floats = npt.NDArray[np.float64]

PARTS_OF_ERROR = ("_se", "_step_bias", "_memory_bias", "_transient", "_error")
"""Endings of names of errors."""

OF_A_WALL = ("impact_rate", "impact_speed_mean", "power", "force_mean")
"""Results of each wall and contact, as ``barrier_impact_rate`` and so on over all of them in datasets."""

OF_A_POINT = tuple(f"{name}{end}" for end in ("", "_end") for name in ("x_mean", "x_mean_square", "v_mean_square"))
"""Results of each of several masses, without the point's name in datasets."""

FIRST = len(HEADER)
_LENGTH, _SPEED_UNIT, _TIME, _, _WALL, _ = range(FIRST)

COUNTED = {
    "counted_impact_rate": "s-1", "counted_impact_speed_mean": "m s-1", "counted_impact_speed_mean_square": "m2 s-2",
}  # fmt: skip
"""Results of the impacts that are not slower than a speed, and their units."""

EXTREMES = {"x_minimum": "m", "x_maximum": "m", "v_largest": "m s-1", "impact_speed_largest": "m s-1"}
"""Largest and smallest values of each path in the window, and their units; speeds without sign.

They are taken at the ends of the steps and at the impacts.
"""


# --- a user's own ---------------------------------------------------------------------------------------------------


def mean_of(name: str, function: Callable[..., float], kind: Literal["state", "impact"]) -> Observer:
    """Sum of a user's function: of (t, x, v) over the steps of the window, or of the speed over its impacts.

    Variables that the function captures have their values at the start of the run.

    Raises
    ------
    TypeError, ValueError
        If the name is not valid, or the function cannot be compiled.
    """
    wanted = "(t, x, v)" if kind == "state" else "(speed)"
    if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name):
        raise ValueError(f"an observable's name must be a word (letters, digits, underscores), not {shown(name)}.")
    if not callable(function) or not inspect.isfunction(getattr(function, "py_func", function)):
        given = shown(function)
        raise TypeError(f"observable {name!r} must be a function of {wanted}, not {given}: wrap it in a lambda.")
    try:
        compiled = (_on_steps_of if kind == "state" else _on_impacts_of)(function)
    except (NumbaError, TypeError) as reason:
        raise ValueError(
            f"observable {name!r} must be a function of {wanted} that Numba can compile to a real number: "
            f"{cause_of(reason)}"
        ) from reason
    on_steps, on_impacts = (compiled, None) if kind == "state" else (None, compiled)
    return Observer(on_steps, on_impacts, np.zeros(LANES), per_path=True)


def is_taken(system: System, name: str) -> bool:
    """Whether a run of a system uses a name already, for a result or in the dataset of its results."""
    if name in possible_results(system) or name.endswith(PARTS_OF_ERROR):
        return True
    sketched = (f"{name}_{part}" for name in SKETCHED for part in ("density", "quantile", "bin", "bin_width"))
    biased = ("impact_speed_density_step_bias", "impact_speed_quantile_step_bias", "v_largest_quantile_step_bias")
    extreme = (f"{name}_quantile" for name in EXTREMES)
    walls = (f"barrier_{quantity}" for quantity in OF_A_WALL)
    others = ("x", "v", "x_spectrum", "path", "time", "frequency", "probability", "barrier")
    attributes = ("system", "settings", "diagnostics", "warnings")
    return name in {*COUNTED, *sketched, *EXTREMES, *extreme, *biased, *walls, *others, *attributes}


def _on_steps_of(function: Callable[..., float]) -> Any:
    inner = njit(**INLINE)(getattr(function, "py_func", function))

    @cfunc(ON_STEPS, **FAST)
    def on_steps(x, v, step, n, low, high, array):
        length, speed, time = array[_LENGTH], array[_SPEED_UNIT], array[_TIME]
        for j in range(GROUP):
            if low <= n + j < high:
                t = time * step * (n + j + 1)
                for lane in range(LANES):
                    at = j * LANES + lane
                    so_far = array[FIRST + lane]
                    array[FIRST + lane] = np.nan  # stays if the function raises
                    array[FIRST + lane] = so_far + inner(t, length * x[at], speed * v[at])

    return on_steps


def _on_impacts_of(function: Callable[..., float]) -> Any:
    inner = njit(**INLINE)(getattr(function, "py_func", function))

    @cfunc(ON_IMPACTS, **FAST)
    def on_impacts(count, speed, lane, array):
        so_far = array[FIRST + lane]
        array[FIRST + lane] = np.nan
        array[FIRST + lane] = so_far + count * inner(abs(array[_SPEED_UNIT]) * speed)

    return on_impacts


# --- impacts that are not slow ---------------------------------------------------------------------------------------


def faster_than(speed: float) -> Observer:
    """Impacts at this speed, in m/s, or faster: their number, the sum of the speeds and of their squares."""
    initial = np.zeros(4 * LANES)
    initial[3 * LANES :] = speed
    return Observer(None, _on_fast_impacts(), initial, per_path=True)


@cache
def _on_fast_impacts() -> Any:
    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        before = abs(array[_SPEED_UNIT]) * speed
        if before >= array[FIRST + 3 * LANES + lane]:
            array[FIRST + lane] += count
            array[FIRST + LANES + lane] += count * before
            array[FIRST + 2 * LANES + lane] += count * before * before

    return on_impacts


# --- extremes -------------------------------------------------------------------------------------------------------


def extremes() -> Observer:
    """The EXTREMES of every path."""
    initial = np.repeat([math.inf, -math.inf, -math.inf, -math.inf], LANES)
    on_steps, on_impacts = _extreme_parts()
    return Observer(on_steps, on_impacts, initial, per_path=True)


@cache
def _extreme_parts() -> tuple[Any, Any]:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        length, speed = array[_LENGTH], abs(array[_SPEED_UNIT])
        for j in range(GROUP):
            if low <= n + j < high:
                for lane in range(LANES):
                    here = length * x[j * LANES + lane]
                    array[FIRST + lane] = min(array[FIRST + lane], here)
                    array[FIRST + LANES + lane] = max(array[FIRST + LANES + lane], here)
                    at = FIRST + 2 * LANES + lane
                    array[at] = max(array[at], speed * abs(v[j * LANES + lane]))

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        # the state just before the impact is an extreme of the step
        wall, reached = array[_LENGTH] * array[_WALL], abs(array[_SPEED_UNIT]) * speed
        array[FIRST + lane] = min(array[FIRST + lane], wall)
        array[FIRST + LANES + lane] = max(array[FIRST + LANES + lane], wall)
        for at in (FIRST + 2 * LANES + lane, FIRST + 3 * LANES + lane):
            array[at] = max(array[at], reached)

    return on_steps, on_impacts
