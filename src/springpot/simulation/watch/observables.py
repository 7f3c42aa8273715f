"""Observers of user-defined observables and of extremes.

Each observer is compiled separately, and the kernel calls it through its address (see
:mod:`springpot.simulation.kernel.watching`).  So it needs no new kernel, and runs without it are not slower.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, Literal

import numpy as np
from numba import njit
from numba.core.errors import NumbaError

from springpot.machine.arguments import checked_name, named_arguments
from springpot.machine.arrays import Floats
from springpot.machine.faults import cause_of, shown
from springpot.problem.catalogue import OF_A_POINT, OF_A_WALL, PARTS_OF_ERROR, possible_results, results_on_request
from springpot.problem.system import System
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, OF_USER, greater, lesser
from springpot.simulation.kernel.watching import HEADER, ON_IMPACTS, ON_STEPS, Observer
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.seen import Seen
from springpot.simulation.watch.distributions import observer_of

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


def mean_of(
    motion: Motion, name: str, function: Callable[..., float], kind: Literal["state", "impact"], *, most: int = 0
) -> Observer:
    """Sum of a user's function: of the state over the steps of the window, or of the speed over its impacts.

    With ``most`` it is the largest value of a function of the state instead, from this place of the array on.

    Of one mass the state is (t, x, v), and the speed one argument; of several, and with forces or accelerations among
    them, the names of the arguments say what they are.  Variables that the function captures have their values at the
    start of the run.

    Raises
    ------
    TypeError, ValueError
        If the name is not valid, an argument is unknown, or the function cannot be compiled.
    """
    wanted = ("(t, x, v)" if kind == "state" else "(speed)") if not motion.arguments else "what it observes"
    checked_name(name, "an observable's name")
    if not callable(function) or not inspect.isfunction(getattr(function, "py_func", function)):
        given = shown(function)
        raise TypeError(f"observable {name!r} must be a function of {wanted}, not {given}: wrap it in a lambda.")
    own, stop = getattr(function, "py_func", function), ""
    takes: tuple[tuple[str, int], ...] = ("t", 0), ("x", 0), ("v", 0)
    feels: tuple[int, ...] = ()
    if kind == "state" and (motion.arguments or not motion.felt.keys().isdisjoint(inspect.signature(own).parameters)):
        first = motion.displacements_shown
        felt = {word: ("x", first + number) for number, word in enumerate(motion.felt)}
        known = (motion.arguments or {word: (word, 0) for word in "txv"}) | felt
        words = _arguments(name, own, known)
        takes, feels = tuple(known[word] for word in words), tuple(motion.number_felt(w) for w in words if w in felt)
    elif kind == "impact":
        stops = {"speed": "", **{f"{stop}_impact_speed": stop for stop in motion.touched}}
        words = [*inspect.signature(own).parameters]
        if motion.arguments or any(word.endswith("_impact_speed") for word in words):  # else of one mass any name
            stop = stops[_arguments(name, own, stops, most=1)[0]]
    try:
        compiled = _on_steps_of(own, takes, most or FIRST, most > 0) if kind == "state" else _on_impacts_of(own)
    except (NumbaError, TypeError) as reason:
        raise ValueError(
            f"observable {name!r} must be a function of {wanted} that Numba can compile to a real number: "
            f"{cause_of(reason)}"
        ) from reason
    on_steps, on_impacts = (compiled, None) if kind == "state" else (None, compiled)
    return Observer(on_steps, on_impacts, np.zeros(LANES), per_path=True, stop=stop, feels=feels)


def squares(seen: Seen) -> Observer:
    """The sums of a force or acceleration and of its square."""
    return observer_of(seen, _on_felt(), None, np.zeros(2 * LANES))


@cache
def _on_felt() -> Any:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        scale = array[_LENGTH]
        first, end = max(low - n, 0), min(high - n, GROUP)
        if end - first == GROUP:
            for lane in range(LANES):
                a, b = scale * x[lane], scale * x[LANES + lane]
                c, d = scale * x[2 * LANES + lane], scale * x[3 * LANES + lane]
                array[FIRST + lane] += (a + b) + (c + d)
                array[FIRST + LANES + lane] += (a * a + b * b) + (c * c + d * d)
        else:
            for j in range(first, end):
                for lane in range(LANES):
                    here = scale * x[j * LANES + lane]
                    array[FIRST + lane] += here
                    array[FIRST + LANES + lane] += here * here

    return on_steps


def _arguments(name: str, function: Callable[..., float], known: Iterable[str], most: int = 0) -> list[str]:
    return named_arguments(f"observable {name!r}", function, known, "nothing that can be seen", most)


def is_taken(system: System, name: str) -> bool:
    """Whether a run of a system uses a name already, for a result or in the dataset of its results."""
    if name in possible_results(system) or name.endswith(PARTS_OF_ERROR):
        return True
    asked = results_on_request(system)
    bins = (asked_for.removesuffix("_density") + end for asked_for in asked for end in ("_bin", "_bin_width"))
    samples = (asked_for.removesuffix("_quantile") for asked_for in asked)
    walls = (f"barrier_{quantity}" for quantity in OF_A_WALL)
    others = (*OF_A_POINT, "path", "time", "frequency", "probability", "barrier", "point", "time_bin", "time_bin_width")
    attributes = ("system", "settings", "diagnostics", "warnings")
    return name in {*COUNTED, *asked, *bins, *samples, *walls, *others, *attributes}


def _with(rest: Any, kind: str, begin: int) -> Any:
    """``rest``, which is given one argument more: the time, or the displacement or velocity that begins there."""
    if kind == "t":

        @njit(**INLINE)
        def value(t, length, speed, x, v, at, given):
            return rest(t, length, speed, x, v, at, (*given, t))

    elif kind == "x":

        @njit(**INLINE)
        def value(t, length, speed, x, v, at, given):
            return rest(t, length, speed, x, v, at, (*given, length * x[begin + at]))

    else:

        @njit(**INLINE)
        def value(t, length, speed, x, v, at, given):
            return rest(t, length, speed, x, v, at, (*given, speed * v[begin + at]))

    return value


def _on_steps_of(
    function: Callable[..., float], takes: Sequence[tuple[str, int]], place: int = FIRST, most: bool = False
) -> Any:
    """The sum, or the most, at this place; ``takes`` says of each argument if it is t, x or v, and the number of the
    displacement.
    """
    inner = njit(**OF_USER)(function)

    @njit(**INLINE)
    def value(t, length, speed, x, v, at, given):
        return inner(*given)

    for kind, number in reversed(takes):
        value = _with(value, kind, number * GROUP * LANES)

    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        length, speed, time = array[_LENGTH], array[_SPEED_UNIT], array[_TIME]
        for j in range(GROUP):
            if low <= n + j < high:
                t = time * step * (n + j + 1)
                for lane in range(LANES):
                    at = j * LANES + lane
                    so_far = array[place + lane]
                    array[place + lane] = np.nan  # stays if the function raises
                    found = value(t, length, speed, x, v, at, ())
                    array[place + lane] = (found if found > so_far else so_far) if most else so_far + found

    return on_steps


def _on_impacts_of(function: Callable[..., float]) -> Any:
    inner = njit(**OF_USER)(function)

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        so_far = array[FIRST + lane]
        array[FIRST + lane] = np.nan
        array[FIRST + lane] = so_far + count * inner(array[_SPEED_UNIT] * speed)

    return on_impacts


# --- impacts that are not slow ---------------------------------------------------------------------------------------


def of_impacts(seen: Seen) -> Observer:
    """The largest forces of the touches of a contact, or impulses: their number, sum and the sum of their squares."""
    return observer_of(seen, None, _on_fast_impacts(), np.zeros(4 * LANES))


def faster_than(speed: float, stop: str) -> Observer:
    """Impacts at this speed, in m/s, or faster: their number, the sum of the speeds and of their squares.

    ``stop``: on which wall or contact; empty for all.
    """
    initial = np.zeros(4 * LANES)
    initial[3 * LANES :] = speed
    return Observer(None, _on_fast_impacts(), initial, per_path=True, stop=stop)


@cache
def _on_fast_impacts() -> Any:
    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        before = array[_SPEED_UNIT] * speed
        if before >= array[FIRST + 3 * LANES + lane]:
            array[FIRST + lane] += count
            array[FIRST + LANES + lane] += count * before
            array[FIRST + 2 * LANES + lane] += count * before * before

    return on_impacts


# --- extremes -------------------------------------------------------------------------------------------------------


def extremes(seen: Seen) -> Observer:
    """The EXTREMES of a displacement in every path."""
    initial = np.append(np.repeat([math.inf, -math.inf, -math.inf, -math.inf], LANES), math.isnan(seen.place))
    return replace(observer_of(seen, *_extreme_parts(), initial), forgotten=1)


def extremes_in(seen: Seen, found: Floats) -> dict[str, Floats]:
    """The extremes of each path by name, from the numbers of `extremes`: NaN without an impact.

    Parameters
    ----------
    found : ndarray, shape (paths, 4)
    """
    found = np.where(np.isfinite(found), found, np.nan)
    by_name = {}
    for name, samples in zip(EXTREMES, found.T, strict=True):
        quantity, _, end = name.rpartition("_")
        if quantity in seen.names:
            by_name[f"{seen.names[quantity]}_{end}"] = samples
    return by_name


@cache
def _extreme_parts() -> tuple[Any, Any]:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        length, speed = array[_LENGTH], array[_SPEED_UNIT]
        first, end = max(low - n, 0), min(high - n, GROUP)
        for lane in range(LANES):
            least, most, fastest = math.inf, -math.inf, -math.inf
            for j in range(GROUP):
                if first <= j < end:
                    here = x[j * LANES + lane]
                    least, most = lesser(least, here), greater(most, here)
                    fastest = greater(fastest, abs(v[j * LANES + lane]))
            if length < 0.0:  # of a wall above
                least, most = most, least
            array[FIRST + lane] = lesser(array[FIRST + lane], length * least)
            array[FIRST + LANES + lane] = greater(array[FIRST + LANES + lane], length * most)
            array[FIRST + 2 * LANES + lane] = greater(array[FIRST + 2 * LANES + lane], speed * fastest)

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        # the state just before the impact is an extreme of the step
        wall, reached = array[_LENGTH] * array[_WALL], array[_SPEED_UNIT] * speed
        if array[FIRST + 4 * LANES] == 0.0:  # else it is not known which wall was struck
            array[FIRST + lane] = min(array[FIRST + lane], wall)
            array[FIRST + LANES + lane] = max(array[FIRST + LANES + lane], wall)
        for at in (FIRST + 2 * LANES + lane, FIRST + 3 * LANES + lane):
            array[at] = max(array[at], reached)

    return on_steps, on_impacts
