"""First passage: when a quantity of each path first passes a level.  It is detected during the run; no path is stored.

Times count from the start of the window.  From rest and without a given window they count from t = 0.  In the
stationary state the window begins when the transient is over; the first observation is the end of its first step.

States are observed at the ends of steps.  Passages between two of them are detected as follows.

- The velocity is continuous, so x has an extreme value in a step in which the velocity changes sign; it is that of the
  cubic through both states.  The error is of higher order in the step h.
- v, speed, energy and amplitude are driven by white noise of intensity q: between two ends they exceed the observed
  values by 0.5826 s sqrt(h) on average near the level, where s^2 is the rate of their variance (Broadie, Glasserman and
  Kou, "A continuity correction for discrete barrier options", Math. Finance 7, 1997).  The level is lowered by that.
  For an observable s comes from its difference in v.
- At an impact on the one rigid wall the state just before it is checked too: position of the wall, and the impact
  speed.
"""

from __future__ import annotations

import inspect
import keyword
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import cfunc, njit
from numba.core.errors import NumbaError

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.faults import cause_of, few, meant, shown
from springpot.simulation.kernel.lanes import FAST, GROUP, INLINE, LANES
from springpot.simulation.kernel.watching import HEADER, ON_IMPACTS, ON_STEPS, Observer
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.seen import LEVELS, Seen
from springpot.simulation.watch.distributions import observer_of
from springpot.simulation.watch.observables import is_taken
from springpot.simulation.watch.passage_times import PassageTimes

__all__ = ["Passage", "checked", "from_the_start", "passage_times"]

Floats = npt.NDArray[np.float64]
Wanted = Mapping[str, Any]

_OR_FROM = ", or {'level': 0.004, 'reference': 0.006} from a reference"
SHIFT = 0.5826  # -zeta(1/2) / sqrt(2 pi)
SETTLED = 2.0  # relaxation times after which the rate of passages is assumed constant
_FIRST = len(HEADER)
_LENGTH, _SPEED, _TIME, _, _WALL, _ = range(_FIRST)
# for each lane, from _FIRST on: state of the previous step, then constants
_PASSED, _SEEN, _X, _V, _STRUCK, _LEVEL, _SIGN, _REFERENCE, _ROOT, _OMEGA, _SIDE = (
    _FIRST + LANES * i for i in range(11)
)


@dataclass(frozen=True, eq=False)
class Passage:
    """One level to be passed.

    Attributes
    ----------
    quantity : str
    level, reference : float
    unit : str
    observer : Observer
    """

    quantity: str
    level: float
    reference: float
    unit: str
    observer: Observer


def from_the_start(plan: Plan, wanted: object, window: object) -> Plan:
    """The plan of a run with first passages or profiles: from rest the window is the whole run if none is given."""
    if not wanted or window is not None or plan.settings.start != "rest":
        return plan
    return plan.but(window=(0.0, plan.settings.duration))


def checked(plan: Plan, wanted: Wanted | None) -> tuple[Passage, ...]:
    """Check and compile the requested first passages.

    Parameters
    ----------
    wanted : dict
        Name and level of each quantity; a distance may have ``{"level": ..., "reference": ...}``, and with one mass any
        other name is an observable's, with a pair of a function f(t, x, v) and a level.

    Raises
    ------
    TypeError, ValueError
        One sentence, before any work.
    """
    if wanted is None:
        return ()
    if not isinstance(wanted, Mapping):
        words = "first_passage must be a dict of names and levels"
        raise TypeError(f"{words}, such as {{'x': 0.01}}, not {shown(wanted)}.")
    return tuple(_passage(plan, name, given) for name, given in wanted.items())


def _passage(plan: Plan, name: str, given: Any) -> Passage:
    motion, settings = plan.motion, plan.settings
    title, reference, sign = f"first_passage level of {name}", math.nan, 1.0
    quantity, seen = motion.levels.get(name) or ("", next(own for _, own in motion.levels.values()))
    if not quantity and motion.arguments:
        if isinstance(given, tuple | list):
            raise ValueError(
                f"first_passage of {shown(name)} cannot be of a function of your own, which is for one mass."
            )
        near = meant(str(name), motion.levels) or f"; there are {few(sorted(motion.levels))}."
        raise ValueError(f"first_passage has {shown(name)}, which is nothing that can pass a level{near}")
    if not quantity:
        function, given = _observable(plan, name, given)
        level, parts = finite_number(given, title, low=-LARGEST, high=LARGEST), _observable_parts(name, function)
    else:
        given, reference = _level_and_reference(name, quantity, given)
        signed = quantity in ("x", "v")
        low = -LARGEST if signed else 0.0
        level = finite_number(given, title, low=low, high=LARGEST, open_low=not signed)
        if signed:
            sign = _direction(plan, name, quantity, seen, level)
        parts = _parts(quantity)
    frequency = math.nan
    if not motion.arguments:
        frequency = motion.system.resonance if quantity == "amplitude" else motion.system.natural_frequency
    if quantity in ("amplitude", "energy") and not frequency > 0.0:
        raise ValueError(f"first_passage of {name} needs a linear spring: use x, v, speed, distance or an observable.")
    squared = 0.5 * (frequency * level) ** 2 if quantity == "amplitude" else level
    initial = np.zeros((11, LANES))
    initial[0] = -1.0
    if settings.window_steps[0] == 0 and settings.initial_position is not None:
        x, v = motion.start_of(seen, settings.initial_position, settings.initial_velocity)
        initial[1:4] = np.array([[1.0], [x], [v]])
    root = SHIFT * math.sqrt(motion.intensity_of(seen) * settings.step)
    initial[5:] = np.array([[squared], [sign], [reference], [root], [frequency], [seen.side]])
    observer = observer_of(seen, *parts, initial.ravel())
    return Passage(name, level, reference, LEVELS.get(quantity, ""), observer)


def _level_and_reference(name: str, quantity: str, given: Any) -> tuple[Any, float]:
    """The level of a quantity, not yet checked, and the reference of a distance."""
    wrong = (
        f"first_passage of {name} must be one level{_OR_FROM if quantity == 'distance' else ''}, not {shown(given)}."
    )
    if isinstance(given, tuple | list | np.ndarray):
        raise TypeError(wrong)
    if not isinstance(given, Mapping):
        return given, 0.0 if quantity == "distance" else math.nan
    if quantity != "distance" or not {"level"} <= set(given) <= {"level", "reference"}:
        raise ValueError(wrong)
    where = f"first_passage reference of {name}"
    return given["level"], finite_number(given.get("reference", 0.0), where, low=-LARGEST, high=LARGEST)


def _direction(plan: Plan, name: str, quantity: str, seen: Seen, level: float) -> float:
    """1 if the level is passed upwards: it lies above the start of the run (in the stationary state, above rest)."""
    motion, settings = plan.motion, plan.settings
    x, v = motion.start_of(seen, settings.initial_position, settings.initial_velocity)
    if quantity == "v":
        return 1.0 if level > v or (level == v >= 0.0) else -1.0
    if not seen.low <= level <= seen.high:
        raise ValueError(
            f"first_passage level of {name} is {level:g} m, behind a wall: {name} lies between {seen.low:g} and "
            f"{seen.high:g}."
        )
    if level == x:
        return {seen.low: -1.0, seen.high: 1.0}.get(level, motion.sign)
    return 1.0 if level > x else -1.0


def passage_times(simulation: Simulation, passage: Passage, left: Floats) -> PassageTimes:
    """The passage times from the array of the level's observer.

    Parameters
    ----------
    left : ndarray, shape (paths, numbers)
    """
    settings, (low, high) = simulation.settings, simulation.settings.window_steps
    at_once = low == 0 and passage.observer.initial[LANES] == 1.0
    begin = 0.0 if at_once else (low + 1) * settings.step
    horizon = high * settings.step - begin
    passed = left[:, 0]
    since = np.where(passed - begin < 1e-9 * settings.step, 0.0, np.minimum(passed - begin, horizon))
    times = np.where(passed < 0.0, np.inf, since)
    settling = SETTLED * simulation.motion.scales.relaxation_time
    return PassageTimes(
        passage.quantity, passage.level, passage.reference, passage.unit, begin, horizon, settling, times
    )


# --- compiled ------------------------------------------------------------------------------------------------------


def _observable(plan: Plan, name: object, given: Any) -> tuple[Callable[..., float], Any]:
    """The function and the level of an observable."""
    known = ", ".join(LEVELS)
    if not isinstance(name, str) or not name.isidentifier() or keyword.iskeyword(name):
        raise ValueError(f"first_passage must name {known} or an observable in one word, not {shown(name)}.")
    if not isinstance(given, tuple | list) or len(given) != 2:
        raise ValueError(
            f"first_passage must name {known}; for an observable such as {name!r} give a pair: a function of (t, x, "
            "v) and a level."
        )
    if is_taken(plan.system, name):
        raise ValueError(
            f"first_passage cannot call an observable {name!r}: the run already has a result of that name."
        )
    function, level = given
    if not callable(function) or not inspect.isfunction(getattr(function, "py_func", function)):
        raise TypeError(f"first_passage of {name!r} must be of a function of (t, x, v), not {shown(function)}.")
    return function, level


def _observable_parts(name: str, function: Callable[..., float]) -> tuple[Any, Any]:
    inner = njit(**INLINE)(getattr(function, "py_func", function))

    @njit(**INLINE)
    def value(t, x, v, level, sign, reference, omega):
        return inner(t, x, v) - level

    @njit(**INLINE)
    def shift(t, x, v, sign, omega, root):
        return 0.5 * abs(inner(t, x, v + root) - inner(t, x, v - root))

    try:
        return _compiled(value, shift, None)
    except (NumbaError, TypeError) as reason:
        raise ValueError(
            f"first_passage of {name!r} must be of a function of (t, x, v) that Numba can compile to a real number: "
            f"{cause_of(reason)}"
        ) from reason


@njit(**INLINE)
def _no_shift(t, x, v, sign, omega, root):
    return 0.0


@njit(**INLINE)
def _noise_in_v(t, x, v, sign, omega, root):
    return root


@njit(**INLINE)
def _noise_in_energy(t, x, v, sign, omega, root):
    return abs(v) * root


@njit(**INLINE)
def _x(t, x, v, level, sign, reference, omega):
    return sign * (x - level)


@njit(**INLINE)
def _x_slope(x, v, sign, reference):
    return sign * v


@njit(**INLINE)
def _distance(t, x, v, level, sign, reference, omega):
    return abs(x - reference) - level


@njit(**INLINE)
def _distance_slope(x, v, sign, reference):
    return v if x > reference else -v


@njit(**INLINE)
def _v(t, x, v, level, sign, reference, omega):
    return sign * (v - level)


@njit(**INLINE)
def _speed(t, x, v, level, sign, reference, omega):
    return abs(v) - level


@njit(**INLINE)
def _energy(t, x, v, level, sign, reference, omega):
    return 0.5 * (v * v + (omega * x) ** 2) - level


@cache
def _parts(name: str) -> tuple[Any, Any]:
    value, shift, slope = {
        "x": (_x, _no_shift, _x_slope),
        "distance": (_distance, _no_shift, _distance_slope),
        "v": (_v, _noise_in_v, None),
        "speed": (_speed, _noise_in_v, None),
        "amplitude": (_energy, _noise_in_energy, None),
        "energy": (_energy, _noise_in_energy, None),
    }[name]
    return _compiled(value, shift, slope)


@njit(**INLINE)
def _inside(before, after, slope_before, slope_after, h):
    """Time within a step at which a smooth quantity that is negative at both ends first reaches 0; -1 if it does not.
    It can only if it rises at the beginning and falls at the end."""
    if not (slope_before > 0.0 and slope_after < 0.0):
        return -1.0
    s = slope_before / (slope_before - slope_after)
    missing = after - before - 0.5 * h * (slope_before + slope_after)
    top = before + 0.5 * h * slope_before * s + missing * s * s * (3.0 - 2.0 * s)
    if top < 0.0:
        return -1.0
    return h * s * (1.0 - math.sqrt(top / (top - before)))


def _compiled(value: Any, shift: Any, slope: Any) -> tuple[Any, Any]:
    """``on_steps`` and ``on_impacts`` for a quantity that has passed the level if ``value`` is not negative."""
    smooth = slope is not None
    slope = _x_slope if slope is None else slope

    @cfunc(ON_STEPS, **FAST)
    def on_steps(x, v, step, n, low, high, array):
        h = array[_TIME] * step
        last = min(high - n, GROUP) - 1
        for j in range(GROUP):
            if not low <= n + j < high:
                continue
            t = h * (n + j + 1)
            for lane in range(LANES):
                if array[_PASSED + lane] >= 0.0:
                    continue
                level, sign = array[_LEVEL + lane], array[_SIGN + lane]
                reference, root, omega = array[_REFERENCE + lane], array[_ROOT + lane], array[_OMEGA + lane]
                here, speed = array[_LENGTH] * x[j * LANES + lane], array[_SPEED] * v[j * LANES + lane]
                before, speed_before = array[_X + lane], array[_V + lane]
                seen = array[_SEEN + lane] > 0.0
                after = value(t, here, speed, level, sign, reference, omega)
                at = -1.0
                if not seen:
                    at = t if after >= 0.0 else -1.0
                else:
                    value_before = value(t - h, before, speed_before, level, sign, reference, omega)
                    if n + j == 0 and value_before >= 0.0:
                        at = 0.0
                    else:
                        value_before += shift(t - h, before, speed_before, sign, omega, root)
                        shifted = after + shift(t, here, speed, sign, omega, root)
                        if shifted >= 0.0:
                            at = t - h * (shifted / (shifted - value_before) if value_before < 0.0 else 1.0)
                        elif smooth:
                            inside = _inside(
                                value_before, after, slope(before, speed_before, sign, reference),
                                slope(here, speed, sign, reference), h,
                            )  # fmt: skip
                            at = t - h + inside if inside >= 0.0 else -1.0
                struck = array[_STRUCK + lane]
                if struck > 0.0 and seen:
                    away = array[_SIDE + lane] * array[_SPEED]  # from the wall
                    if away * speed_before < 0.0 < away * speed or j == last:
                        wall = array[_LENGTH] * array[_WALL]
                        if at < 0.0 and value(t, wall, -away * struck, level, sign, reference, omega) >= 0.0:
                            at = t - 0.5 * h
                        array[_STRUCK + lane] = 0.0
                array[_PASSED + lane] = at
                array[_SEEN + lane], array[_X + lane], array[_V + lane] = 1.0, here, speed

    @cfunc(ON_IMPACTS, **FAST)
    def on_impacts(count, speed, lane, array):
        array[_STRUCK + lane] = max(array[_STRUCK + lane], speed)

    return on_steps, on_impacts
