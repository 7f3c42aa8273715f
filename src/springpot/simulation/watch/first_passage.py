"""First passage: when a quantity of each path first passes a level.  It is detected during the run; no path is stored.

Times count from the start of the window.  From rest and without a given window they count from t = 0.  In the
stationary state the window begins when the transient is over; the first observation is the end of its first step.

States are observed at the ends of steps.  Passages between two of them are detected as follows.

- The velocity is continuous, so x has an extreme value in a step in which the velocity changes sign; it is that of the
  cubic through both states.  The error is of higher order in the step h.
- v, speed, energy and amplitude are driven by white noise of intensity q: between two ends they exceed the observed
  values by 0.5826 s sqrt(h) on average near the level, where s^2 is the rate of their variance (Broadie, Glasserman and
  Kou, "A continuity correction for discrete barrier options", Math. Finance 7, 1997).  The level is lowered by that.
  For an observable s comes from its difference in v.  With an envelope q is that of the step.
- A force or an acceleration is seen as its mean over each step.  The level is lowered by what its values between
  exceed these means on average: like h^(3/2 - order) for a springpot under white noise, which random walks gave.
- At an impact on the one rigid wall the state just before it is checked too: position of the wall, and the impact
  speed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.machine.arguments import LARGEST, checked_name, finite_number, without_axis
from springpot.machine.faults import shown
from springpot.problem.catalogue import LEVELS, unit_of_result
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.kept import Code
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, OF_USER
from springpot.simulation.kernel.watching import ON_IMPACTS, ON_STEPS
from springpot.simulation.lowering.compose import Parts
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.lowering.outputs import roughness_in_steps
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.observables import compiled_of, is_taken, python_of
from springpot.simulation.watch.passage_times import PassagesOfLevels, PassageTimes
from springpot.simulation.watch.requested import Observed, Request

SHIFT = 0.5826  # -zeta(1/2) / sqrt(2 pi)
SETTLED = 2.0  # relaxation times after which the rate of passages is assumed constant
MOST_LEVELS = 1000
ROUNDED = 1e-9  # relative to a level: what vector code may round otherwise
_OF_LANES = "next", "level", "known", "x", "v", "struck", "near"
"""The number of the next level and this level; whether there is a previous step, its state and the speed of an impact
since then; and how near a group of steps comes to the level."""
_CONSTANTS = "count", "times_at", "sign", "reference", "root", "omega", "side", "slack", "shares_at"


def _layout(levels: int, steps: int = 0) -> np.dtype[np.void]:
    """With when each lane passed each level, -1 if it has not, and the share of the root in each of so many steps."""
    lanes, constants = dict.fromkeys(_OF_LANES, LANES), dict.fromkeys(_CONSTANTS, ())
    return layout(**lanes, **constants, levels=levels, times=(levels, LANES), shares=steps)


(_LENGTH, _SPEED, _TIME, _WALL, _NEXT, _LEVEL, _KNOWN, _X, _V, _STRUCK, _NEAR, _COUNT, _TIMES_AT, _SIGN, _REFERENCE,
 _ROOT, _OMEGA, _SIDE, _SLACK, _SHARES_AT, _LEVELS) = begins(
    _layout(1), "length", "speed", "time", "wall", *_OF_LANES, *_CONSTANTS, "levels",
)  # fmt: skip

_SIZES = {"x": "distance", "v": "speed", "force": "size of force"}
"""Quantities with a sign, which can leave an interval: their distance from its middle."""


@dataclass(frozen=True)
class Way:
    """Levels of a quantity that are passed one after another, in one direction.

    Attributes
    ----------
    levels : tuple of float
    places : tuple of int
        Of the levels, among those that were given.
    reference : float
        From which distances are measured; NaN for other quantities.
    """

    levels: tuple[float, ...]
    places: tuple[int, ...]
    reference: float


@dataclass(frozen=True, eq=False)
class FirstPassages(Request):
    """The first passages of one quantity, with an observer for each way.

    Attributes
    ----------
    quantity, unit : str
    listed : bool
        Whether a list of levels was given.
    at_once : bool
        Whether the state at time 0 counts.
    ways : tuple of Way
    """

    quantity: str
    unit: str
    listed: bool
    at_once: bool
    ways: tuple[Way, ...]

    over_time: ClassVar[bool] = True

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[FirstPassages]:
        """Of each quantity by its name: a level, or a list of levels.

        A pair (low, high) of a displacement or velocity is an interval to be left; a distance may have ``{"level": ...,
        "reference": ...}``, and with one mass any other name is an observable's, with a pair of a function f(t, x, v)
        and its level or levels.
        """
        given = wishes["first_passage"]
        if not isinstance(given, Mapping):
            words = "first_passage must be a dict of names and levels"
            raise TypeError(f"{words}, such as {{'x': 0.01}}, not {shown(given)}.")
        for name, levels in given.items():
            yield cls.of(plan, name, levels)

    @classmethod
    def of(cls, plan: Plan, name: str, given: Any) -> FirstPassages:
        """Of one quantity."""
        motion = plan.motion
        reference = math.nan
        quantity, signal = motion.levels.get(name) or ("", next(own for _, own in motion.levels.values()))
        if name in motion.outputs:
            quantity, signal = "force", motion.signal_by_name(name, "first_passage")
        if not quantity and motion.arguments:
            if isinstance(given, tuple | list) and any(map(callable, given)):
                raise ValueError(
                    f"first_passage of {shown(name)} cannot be of a function of your own, which is for one mass."
                )
            near = motion.near(name, sorted({*motion.levels, *motion.outputs}))
            raise ValueError(f"first_passage has {shown(name)}, which is nothing that can pass a level{near}")
        if not quantity:
            function, given = _observable(plan, name, given)
        elif isinstance(given, Mapping):
            if quantity != "distance" or not {"level"} <= set(given) <= {"level", "reference"}:
                more = ", or {'level': 0.004, 'reference': 0.006} from a reference" if quantity == "distance" else ""
                raise ValueError(
                    f"first_passage of {name} must be a level or a list of levels{more}, not {shown(given)}."
                )
            where = f"first_passage reference of {name}"
            reference = finite_number(given.get("reference", 0.0), where, low=-LARGEST, high=LARGEST)
            given = given["level"]
        elif quantity == "distance":
            reference = 0.0
        listed = isinstance(given, list) or (isinstance(given, np.ndarray) and given.ndim > 0)
        each = [*given] if listed else [given]
        if not 0 < len(each) <= MOST_LEVELS:
            raise ValueError(f"first_passage of {name} must have 1 to {MOST_LEVELS} levels, not {len(each)}.")
        compiled = _compiled_of(quantity) if quantity else _compiled_of_observable(name, function)
        # of all that are passed in one direction, each lies beyond the one before
        found = dict[tuple[str, float, float], list[tuple[float, int]]]()
        for place, one in enumerate(each):
            if quantity in _SIZES and isinstance(one, tuple):
                middle, half = _interval(name, signal if quantity == "x" else Signal(), one)
                way, level = (_SIZES[quantity], 1.0, middle), half
            else:
                level = _level(name, quantity, one)
                sign = _direction(plan, name, quantity, signal, level) if quantity in _SIZES else 1.0
                way = quantity, sign, reference
            found.setdefault(way, []).append((level, place))
        unit = unit_of_result(plan.system, name) if signal.outputs else LEVELS.get(quantity, "")
        # the state at time 0 counts, unless it is not known or there is no force yet
        at_once = (
            plan.settings.window_steps[0] == 0 and plan.settings.initial_position is not None and not signal.outputs
        )
        observers, ways = list[Observer](), list[Way]()
        for (kind, sign, middle), own in found.items():
            own.sort(key=lambda each, sign=sign: sign * each[0])  # type: ignore[misc]
            levels, places = zip(*own, strict=True)
            initial = _initial(plan, signal, kind, levels, sign, middle, at_once)
            on_steps, on_impacts = compiled if kind == quantity else _compiled_of(kind)
            observers.append(Observer(signal, on_steps, on_impacts, initial, of_paths=("times",)))
            ways.append(Way(levels, places, middle))
        return cls((*observers,), name, unit, listed, at_once, (*ways,))

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        found = dict[int, PassageTimes]()
        settings, motion, (low, high) = simulation.settings, simulation.motion, simulation.settings.window_steps
        begin = 0.0 if self.at_once else (low + 1) * settings.step
        horizon = high * settings.step - begin
        settling = motion.settled_after(settings.start, SETTLED) if motion.settles else math.inf
        for observer, way in zip(self.observers, self.ways, strict=True):
            times = ensemble.observed[observer]["times"].T
            for place, level, passed in zip(way.places, way.levels, times, strict=True):
                since = np.where(passed - begin < 1e-9 * settings.step, 0.0, np.minimum(passed - begin, horizon))
                since = np.where(passed < 0.0, np.inf, since)
                found[place] = PassageTimes(
                    self.quantity, level, way.reference, self.unit, begin, horizon, settling, since
                )
        of_levels = tuple(found[place] for place in sorted(found))
        return {"first_passages": {self.quantity: PassagesOfLevels(of_levels) if self.listed else found[0]}}


def _initial(
    plan: Plan, signal: Signal, quantity: str, levels: tuple[float, ...], sign: float, reference: float, at_once: bool
) -> Callable[[Parts], npt.NDArray[np.void]]:
    """The array for the levels of a way, once the kernel's arguments are known."""
    motion, settings, frequency = plan.motion, plan.settings, math.nan
    if not motion.arguments:
        frequency = motion.system.resonance if quantity == "amplitude" else motion.system.natural_frequency
    if quantity in ("amplitude", "energy") and not frequency > 0.0:
        raise ValueError(
            f"first_passage of {quantity} needs a linear spring: use x, v, speed, distance or an observable."
        )
    kernels = np.array([0.5 * (frequency * level) ** 2 for level in levels] if quantity == "amplitude" else levels)
    middle = 0.0 if math.isnan(reference) else reference

    def initial(parts: Parts) -> npt.NDArray[np.void]:
        shares = roughness_in_steps(plan, parts.outputs, signal) if motion.is_modulated else np.zeros(0)
        kind = _layout(len(levels), shares.size)
        array = np.zeros((), kind)
        array["level"], array["levels"], array["times"], array["shares"] = kernels[0], kernels, -1.0, shares
        if at_once:
            x, v = motion.start_of(signal, settings.initial_position, settings.initial_velocity)
            array["known"], array["x"], array["v"] = 1.0, x, v
        array["count"], array["sign"], array["reference"], array["omega"] = len(levels), sign, middle, frequency
        array["root"] = 1.0 if signal.outputs else SHIFT * math.sqrt(motion.intensity_of(signal) * settings.step)
        array["side"], array["slack"] = signal.side, ROUNDED * (np.abs(kernels).max() + abs(middle))
        array["times_at"], shares_at = begins(kind, "times", "shares")
        array["shares_at"] = shares_at if shares.size else 0
        return array

    return initial


def _level(name: str, quantity: str, given: Any) -> float:
    signed, given = quantity in (*_SIZES, ""), without_axis(given)
    if isinstance(given, tuple | list | np.ndarray):
        pair = ", or (low, high) for an interval that is left" if quantity in _SIZES else ""
        raise TypeError(f"first_passage of {name} must be a level or a list of levels{pair}, not {shown(given)}.")
    low = -LARGEST if signed else 0.0
    return finite_number(given, f"first_passage level of {name}", low=low, high=LARGEST, open_low=not signed)


def _interval(name: str, signal: Signal, given: tuple[Any, ...]) -> tuple[float, float]:
    """Middle and half width of an interval."""
    if len(given) != 2:
        raise ValueError(
            f"first_passage of {name} must be levels in a list, or an interval (low, high), not {shown(given)}."
        )
    low, high = (finite_number(end, f"first_passage level of {name}", low=-LARGEST, high=LARGEST) for end in given)
    if not low < high:
        raise ValueError(f"first_passage of {name} must have its interval from low to high, not {shown(given)}.")
    for end in (low, high):
        _in_reach(name, signal, end)
    return 0.5 * (low + high), 0.5 * (high - low)


def _in_reach(name: str, signal: Signal, level: float) -> None:
    if not signal.low <= level <= signal.high:
        raise ValueError(
            f"first_passage level of {name} is {level:g} m, behind a wall: {name} lies between {signal.low:g} and "
            f"{signal.high:g}."
        )


def _direction(plan: Plan, name: str, quantity: str, signal: Signal, level: float) -> float:
    """1 if the level is passed upwards: it lies above the start of the run (in the stationary state, above rest).

    Of a force or an acceleration, which no start has: if it is not negative.
    """
    if signal.outputs:
        return 1.0 if level >= 0.0 else -1.0
    motion, settings = plan.motion, plan.settings
    x, v = motion.start_of(signal, settings.initial_position, settings.initial_velocity)
    if quantity == "v":
        return 1.0 if level > v or (level == v >= 0.0) else -1.0
    _in_reach(name, signal, level)
    if level == x:
        return {signal.low: -1.0, signal.high: 1.0}.get(level, motion.sign)
    return 1.0 if level > x else -1.0


# --- compiled ------------------------------------------------------------------------------------------------------


def _observable(plan: Plan, name: object, given: Any) -> tuple[Callable[..., float], Any]:
    """The function and the level of an observable."""
    known = ", ".join(LEVELS)
    name = checked_name(name, "first_passage", f"name {known} or an observable in one word")
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
    if (own := python_of(function)) is None:
        raise TypeError(f"first_passage of {name!r} must be of a function of (t, x, v), not {shown(function)}.")
    return own, level


def _compiled_of_observable(name: str, function: Callable[..., float]) -> tuple[Code, Code]:
    inner = njit(**OF_USER)(function)

    @njit(**INLINE)
    def value(t, x, v, level, sign, reference, omega):
        return inner(t, x, v) - level

    @njit(**INLINE)
    def shift(t, x, v, sign, omega, root):
        return 0.5 * abs(inner(t, x, v + root) - inner(t, x, v - root))

    with compiled_of(f"first_passage of {name!r} must be of a function of (t, x, v)"):
        return _compiled(value, shift, None, timed=True)


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
    return abs(v - reference) - level


@njit(**INLINE)
def _energy(t, x, v, level, sign, reference, omega):
    return 0.5 * (v * v + (omega * x) ** 2) - level


@cache
def _compiled_of(name: str) -> tuple[Code, Code]:
    value, shift, slope = {
        "x": (_x, _no_shift, _x_slope),
        "force": (_x, _noise_in_v, None),
        "size of force": (_distance, _noise_in_v, None),
        "distance": (_distance, _no_shift, _distance_slope),
        "v": (_v, _noise_in_v, None),
        "speed": (_speed, _noise_in_v, None),
        "amplitude": (_energy, _noise_in_energy, None),
        "energy": (_energy, _noise_in_energy, None),
    }[name]
    return _compiled(value, shift, slope, is_output="force" in name)


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


def _compiled(value: Any, shift: Any, slope: Any, *, timed: bool = False, is_output: bool = False) -> tuple[Code, Code]:
    """``on_steps`` and ``on_impacts`` for a quantity that has passed the level if ``value`` is not negative.

    ``timed``: whether it depends on the time; ``is_output``: whether it is a force or an acceleration.
    """
    smooth = slope is not None
    slope = _x_slope if slope is None else slope

    @njit(**INLINE)
    def follow(x, v, h, n, low, high, array, lane):
        """Look at each step of a group for one lane."""
        count, times = int(array[_COUNT]), int(array[_TIMES_AT])
        sign, reference, root, omega = array[_SIGN], array[_REFERENCE], array[_ROOT], array[_OMEGA]
        whole = root * abs(array[_LENGTH] * array[_WALL]) if is_output else root
        in_steps, last = int(array[_SHARES_AT]), min(high - n, GROUP) - 1
        number, level = int(array[_NEXT + lane]), array[_LEVEL + lane]
        for j in range(GROUP):
            if not low <= n + j < high:
                continue
            t, root = h * (n + j + 1), whole * array[in_steps + n + j] if in_steps > 0 else whole
            here, speed = array[_LENGTH] * x[j * LANES + lane], array[_SPEED] * v[j * LANES + lane]
            before, speed_before = array[_X + lane], array[_V + lane]
            known = array[_KNOWN + lane] > 0.0
            struck = array[_STRUCK + lane]
            away = array[_SIDE] * array[_SPEED]  # from the wall
            turned = struck > 0.0 and known and (away * speed_before < 0.0 < away * speed or j == last)
            while number < count:
                after = value(t, here, speed, level, sign, reference, omega)
                at = -1.0
                if not known:
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
                if turned and at < 0.0:
                    wall = array[_LENGTH] * array[_WALL]
                    if value(t, wall, -away * struck, level, sign, reference, omega) >= 0.0:
                        at = t - 0.5 * h
                if at < 0.0:
                    break
                array[times + LANES * number + lane] = at
                number += 1
                level = array[_LEVELS + number] if number < count else sign * math.inf
            if turned:
                array[_STRUCK + lane] = 0.0
            array[_KNOWN + lane], array[_X + lane], array[_V + lane] = 1.0, here, speed
        array[_NEXT + lane], array[_LEVEL + lane] = number, level

    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        h, in_steps = array[_TIME] * step, int(array[_SHARES_AT])
        if not (low < n and n + GROUP <= high) or (timed and in_steps > 0):
            for lane in range(LANES):
                follow(x, v, h, n, low, high, array, lane)
            return
        # most groups of most lanes stay below the level: vector code tells which do not
        length, scale = array[_LENGTH], array[_SPEED]
        sign, reference, root, omega = array[_SIGN], array[_REFERENCE], array[_ROOT], array[_OMEGA]
        root = root * abs(length * array[_WALL]) if is_output else root
        if in_steps > 0:
            begin = in_steps + n
            root *= max(max(array[begin], array[begin + 1]), max(array[begin + 2], array[begin + 3]))
        slack, wall, away = -array[_SLACK], length * array[_WALL], array[_SIDE] * scale
        near = 0
        for lane in range(LANES):
            before, fastest = array[_X + lane], abs(array[_V + lane])
            most = value(0.0, before, 0.0, 0.0, sign, reference, omega) if smooth else -math.inf
            for j in range(GROUP):
                t, here, speed = h * (n + j + 1), length * x[j * LANES + lane], scale * v[j * LANES + lane]
                one = value(t, here, speed, 0.0, sign, reference, omega)
                one += shift(t, here, speed, sign, omega, root) if timed else 0.0
                most = one if one > most else most
                fastest = abs(speed) if abs(speed) > fastest else fastest
            # of x the most that the cubic of a step exceeds its ends by
            most += 0.0 if timed else 0.51 * h * fastest if smooth else shift(0.0, 0.0, fastest, sign, omega, root)
            struck = array[_STRUCK + lane]
            one = value(0.0, wall, -away * struck, 0.0, sign, reference, omega)
            most = one if struck > 0.0 and one > most else most
            most -= sign * array[_LEVEL + lane]
            most = 0.0 if timed and struck > 0.0 else most
            array[_NEAR + lane] = most
            near += 1 if most >= slack else 0
        if near > 0:
            for lane in range(LANES):
                if array[_NEAR + lane] >= slack:
                    follow(x, v, h, n, low, high, array, lane)
        for lane in range(LANES):
            array[_X + lane] = length * x[(GROUP - 1) * LANES + lane]
            array[_V + lane] = scale * v[(GROUP - 1) * LANES + lane]
            array[_STRUCK + lane] = 0.0

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        array[_STRUCK + lane] = max(array[_STRUCK + lane], speed)

    return on_steps, on_impacts
