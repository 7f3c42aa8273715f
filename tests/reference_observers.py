"""What is observed of a path, in plain Python: read `tests/reference.py` before it.

An observer sees the states at the ends of the steps of a window, and the impacts between them.  Of a run from the step
``low`` to the step ``high`` the first state that it sees is that at the time (low + 1) h, and the last one that at
high h.  A displacement u and its rate w are given as they are at 0, h, 2h, ...: of a path, or along one row of it.

The kernel tells its observers of four steps at once, and of the impacts in these before them.  Where that can be seen
in a result, it is said here: a **group** is four steps, of which the first is a multiple of four.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

import springpot as sp
from tests.reference import Impact, Kick, Path, Touch

Floats = np.ndarray
GROUP = 4


@dataclass(frozen=True)
class Window:
    """From step ``low`` to step ``high``, of the length h each."""

    low: int
    high: int
    h: float

    @property
    def length(self) -> float:
        return (self.high - self.low) * self.h

    def states(self, every: int = 1) -> range:
        """The steps at whose ends a state is seen: all, or the first one of a group, in every so many groups."""
        first = self.low - self.low % GROUP
        return range(self.low, self.high) if every == 1 else range(first, self.high, every)

    def of(self, values: Any) -> Any:
        """What was seen at the ends of the steps."""
        return values[self.low + 1 : self.high + 1]

    def holds(self, step: int, late: bool) -> bool:
        """Whether the observation that comes next is of it: the second half of a drift is that of the next step."""
        return self.low <= step + late < self.high

    def impacts(self, path: Path, wall: str = "") -> list[Impact]:
        """Those on a wall, or on all."""
        inside = [each for each in path.impacts if self.holds(each.step, each.late) and not each.rests]
        return [each for each in inside if wall in ("", each.wall)]


# ------------------------------------------------------------------------------------------------------------- means
def mean_of(function: Callable[[float, float, float], float], u: Floats, w: Floats, window: Window) -> float:
    """Of a function of the user, of t, x and v."""
    return float(np.mean([function(window.h * (n + 1), u[n + 1], w[n + 1]) for n in window.states()]))


def per_second(function: Callable[[float], float], impacts: Iterable[Impact], window: Window) -> float:
    """The sum of a function of the user, of the speed of an impact."""
    return sum(function(each.speed) for each in impacts) / window.length


def counted(sizes: Iterable[float], least: float, window: Window) -> tuple[float, float, float]:
    """Of impacts with at least this speed: how many there are per second, mean speed and mean square.

    In the place of speeds there may be impulses, or the largest forces of touches.
    """
    own = np.array([size for size in sizes if size >= least])
    return own.size / window.length, float(own.mean()), float((own**2).mean())


def peaks(path: Path, contact: str, window: Window) -> list[float]:
    """The largest forces of the touches that end in the window."""
    return [each.force for each in path.touches if each.wall == contact and each.ended and window.holds(*each.ended)]


def extremes(u: Floats, w: Floats, impacts: Sequence[Impact | Touch], place: float, window: Window) -> dict[str, float]:
    """The largest and smallest values; the state just before an impact, at the place of the wall, is one, too."""
    speeds, places = [each.speed for each in impacts], [place] * len(impacts)
    return {
        "x_minimum": min(*window.of(u), *places),
        "x_maximum": max(*window.of(u), *places),
        "v_largest": max(*np.abs(window.of(w)), *speeds),
        "impact_speed_largest": max(speeds, default=math.nan),
    }


def force_of(part: Any, g: Floats, kick: Kick, dashpots: float) -> float:
    """Of a part along its row, in a kick; all memory of a row counts as one, beside its dashpots of a coefficient."""
    u, rate, pull = (each[tuple(g)] for each in (kick.elongation, kick.rate, kick.pull))
    if isinstance(part, sp.Spring | sp.PolynomialSpring):
        return sum(k * u**power for power, k in enumerate(part.force_coefficients()))
    if isinstance(part, sp.Dashpot | sp.PolynomialDashpot):
        return linear(part) * rate
    if isinstance(part, sp.Contact):
        depth = max(part.inwards * (part.position - u), 0.0)
        return -part.inwards * part.stiffness * depth**part.exponent * (1.0 - part.inwards * part.dissipation * rate)
    return pull - dashpots * rate


def linear(part: sp.Dashpot | sp.PolynomialDashpot) -> float:
    """The coefficient of its linear force."""
    return float(part.coefficients[0] if isinstance(part, sp.PolynomialDashpot) else part.coefficient)


def forces(system: sp.System, path: Path, h: float) -> dict[str, Floats]:
    """That of each part in each kick, of a stop how hard it is pressed, and the accelerations of the masses.

    White noise is not in an acceleration, and neither are impacts.
    """
    at, parts = system.coordinates, dict(system.named())
    dashpots = dict.fromkeys(map(tuple, at.elongations.values()), 0.0)
    for name, g in at.elongations.items():
        if isinstance(parts[name], sp.Dashpot | sp.PolynomialDashpot):
            dashpots[tuple(g)] += linear(parts[name])
    own = {
        name: np.array([
            kick.yielding[name] if name in kick.yielding else force_of(parts[name], g, kick, dashpots[tuple(g)])
            for kick in path.kicks
        ])
        for name, g in at.elongations.items() if not isinstance(parts[name], sp.Barrier)
    }  # fmt: skip
    whole = -sum(np.outer(force, at.elongations[name]) for name, force in own.items())
    for name in (name for name in at.forces if not parts[name].of_ground):
        part = parts[name]
        pushed = [part.force if isinstance(part, sp.Constant) else kick.given.get(name, 0.0) / h for kick in path.kicks]
        whole = whole + np.outer(pushed, at.forces[name])
    for name in (name for name in own if isinstance(parts[name], sp.Contact)):
        own[name] = -parts[name].inwards * own[name]
    return own | {f"acceleration of {point}": each for point, each in
                  zip(at.names, np.linalg.solve(at.mass, whole.T), strict=True)}  # fmt: skip


# ----------------------------------------------------------------------------------------------------- distributions
def bin_of(value: float) -> float:
    """The lower end of the bin of a number: each octave has 64; the bits of a number in single precision decide."""
    part, power = math.frexp(np.float32(abs(value)))
    return math.copysign(math.ldexp(math.floor(128.0 * part) / 128.0, power), value)


def distribution(values: Callable[[int], float], window: Window, every: int) -> Counter[float]:
    """How many numbers are in each bin, of the values at the ends of steps: of one in so many groups.

    Displacements are counted as they are seen from their wall.
    """
    return Counter(bin_of(values(max(n, window.low))) for n in window.states(GROUP * every))


# ---------------------------------------------------------------------------------------------------------- spectrum
def spectrum(paths: Sequence[Floats], frequencies: Floats, window: Window, every: int) -> Floats:
    """Two-sided density of a displacement about its mean over all paths: one segment of each, with a Hann taper."""
    n = np.array([n for n in window.states(GROUP * every) if n >= window.low])
    taper = np.sin(np.pi * (n + 0.5 - window.low) / (window.high - window.low)) ** 2
    mean = np.mean([taper @ u[n + 1] for u in paths]) / taper.sum()
    waves = taper * np.exp(-1j * window.h * np.outer(frequencies, n))
    squares = np.mean([np.abs(waves @ (u[n + 1] - mean)) ** 2 for u in paths], axis=0)
    return squares * GROUP * every * window.h / (2.0 * np.pi * (taper**2).sum())


# ----------------------------------------------------------------------------------------------------- first passage
@dataclass(frozen=True)
class Quantity:
    """Something that passes a level once its value is not negative.

    What white noise drives exceeds, between two states, what is seen at both: on average by ``shift``, so much is
    added.  What moves smoothly has a slope instead, and may come and go between two states.
    """

    value: Callable[[float, float, float], float]  # of t, x, v
    shift: Callable[..., float] = lambda t, x, v, root: 0.0  # of the root, too: 0.5826 times what noise brings to v
    slope: Callable[[float, float], float] | None = None  # of x, v

    @classmethod
    def of(cls, name: str, level: float, *, above: bool = True, w: float = 1.0, middle: float = 0.0) -> Quantity:
        """By its name, with the frequency w of the spring; of a force its value stands for x."""
        sign = 1.0 if above else -1.0
        if name == "x":
            return cls(lambda t, x, v: sign * (x - level), slope=lambda x, v: sign * v)
        if name == "distance":
            return cls(lambda t, x, v: abs(x - middle) - level, slope=lambda x, v: v if x > middle else -v)
        if name in ("v", "force"):
            number = 1 if name == "v" else 0
            return cls(lambda t, *state: sign * (state[number] - level), lambda t, x, v, root: root)
        if name == "speed":
            return cls(lambda t, x, v: abs(v - middle) - level, lambda t, x, v, root: root)
        most = level if name == "energy" else 0.5 * (w * level) ** 2  # or the amplitude
        return cls(lambda t, x, v: 0.5 * (v * v + (w * x) ** 2) - most, lambda t, x, v, root: root * abs(v))

    @classmethod
    def of_user(cls, function: Callable[[float, float, float], float], level: float) -> Quantity:
        """A function of t, x and v."""
        return cls(
            lambda t, x, v: function(t, x, v) - level,
            lambda t, x, v, root: 0.5 * abs(function(t, x, v + root) - function(t, x, v - root)),
        )


def first_passage(
    quantity: Quantity, u: Floats, w: Floats, window: Window, roots: Floats, *, from_start: bool,
    impacts: Sequence[Impact | Touch] = (), place: float = 0.0, inwards: float = 1.0,
) -> float:  # fmt: skip
    """When a quantity first passes its level, since the first state that counts; infinite if it does not.

    ``from_start``: the state at time 0 counts; ``roots``: of each step.  Of a group the hardest impact counts, in the
    step in which the velocity turns from the wall, or at the end of the group: the state just before it is that of the
    middle of the step.
    """
    h, begin = window.h, 0.0 if from_start else window.h * (window.low + 1)
    for n in window.states():
        t, i = h * (n + 1), n + 1
        now = quantity.value(t, u[i], w[i])
        if n == window.low and not from_start:
            if now >= 0.0:
                return 0.0
            continue
        before = quantity.value(t - h, u[n], w[n])
        if n == 0 and before >= 0.0:
            return 0.0
        before += quantity.shift(t - h, u[n], w[n], roots[n])
        shifted = now + quantity.shift(t, u[i], w[i], roots[n])
        if shifted >= 0.0:
            return t - begin - (h * shifted / (shifted - before) if before < 0.0 else h)
        if quantity.slope is not None:
            inside = _inside(before, now, quantity.slope(u[n], w[n]), quantity.slope(u[i], w[i]), h)
            if inside is not None:
                return t - h + inside - begin
        speed = hardest(n, w, window, impacts, inwards)
        if speed > 0.0 and quantity.value(t, place, -inwards * speed) >= 0.0:
            return t - 0.5 * h - begin
    return math.inf


def hardest(n: int, w: Floats, window: Window, impacts: Sequence[Impact | Touch], inwards: float) -> float:
    """The speed of the hardest impact of a group, if step n is the one in which it is looked at."""
    first = n - n % GROUP
    speeds = [each.speed for each in impacts if first <= max(each.step, 0) < first + GROUP]
    last = min(first + GROUP, window.high) - 1
    turns = [k for k in range(max(first, window.low), last) if inwards * w[k] < 0.0 < inwards * w[k + 1]]
    return max(speeds, default=0.0) if n == [*turns, last][0] else 0.0


def _inside(before: float, now: float, rises: float, falls: float, h: float) -> float | None:
    """When a quantity first reaches 0 within a step at whose ends it is negative, by the cubic through both states.

    Its top is near that of the parabola which the slopes alone make, and it comes there as a parabola does.
    """
    if not rises > 0.0 > falls:
        return None
    s = rises / (rises - falls)
    missing = now - before - 0.5 * h * (rises + falls)
    top = before + 0.5 * h * rises * s + missing * s * s * (3.0 - 2.0 * s)
    return None if top < 0.0 else h * s * (1.0 - math.sqrt(top / (top - before)))


def watched(times: Floats, since: float, until: float) -> float:
    """For how long all paths together, after a time and until another one, had not passed yet."""
    return float(np.maximum(np.minimum(times, until) - since, 0.0).sum())


def passage_rate(times: Floats, since: float, horizon: float) -> tuple[int, float, Floats]:
    """Passages after a time, and their number per time of all paths until they pass; and when they were in this time.

    As shares of the whole, these are uniform if the rate is constant.
    """
    late = np.sort(times[(times > since) & (times < math.inf)])
    whole = watched(times, since, horizon)
    return late.size, late.size / whole, np.array([watched(times, since, time) / whole for time in late])


# ---------------------------------------------------------------------------------------------------------- profiles
def profile(values: Callable[[int], float], edges: Sequence[int], window: Window) -> list[float]:
    """Means over bins of whole steps, by the trapezoidal rule; ``values`` are those at the ends of the steps.

    Where the window begins, the first state stands for the one before it.
    """
    found = []
    for begin, end in pairwise(edges):
        ends = values(begin - 1 if begin > window.low else begin), values(end - 1)
        total = sum(values(n) for n in range(begin, end)) + 0.5 * (ends[0] - ends[1])
        found.append(total / (end - begin))
    return found


def impacts_in_bins(impacts: Sequence[Impact], edges: Sequence[int]) -> list[list[float]]:
    """Speeds of those in the drifts of the steps of each bin: the last of them end half a step after it."""
    return [[each.speed for each in impacts if begin <= max(each.step, 0) < end] for begin, end in pairwise(edges)]


def powers(system: sp.System, path: Path, edges: Sequence[int], h: float, solve: Floats) -> list[tuple[float, float]]:
    """What dashpots and memory take and what excitations give in bins of time.

    What white noise gives is its expected value; a part of it is taken at once, within the kicks that bring it: by
    ``solve`` for the inverse of the masses, which has the answer of dashpots and memory in it.
    """
    at, parts, free = system.coordinates, dict(system.named()), np.linalg.inv(system.coordinates.mass)
    rough = [part.intensity * np.outer(at.forces[name], at.forces[name]) for name, part in parts.items()
             if isinstance(part, sp.WhiteNoise | sp.PoissonImpulses)]  # fmt: skip
    expected = 0.5 * float((sum(rough, 0.0 * free) * free).sum())
    at_once = expected - 0.5 * float((sum(rough, 0.0 * free) * solve).sum())
    found = []
    for begin, end in pairwise(edges):
        own = path.kicks[begin:end]
        taken = np.mean([sum(kick.pull[g] * kick.rate[g] for g in kick.pull) for kick in own])
        found.append((float(taken) + at_once, float(np.mean([kick.work for kick in own])) / h + expected))
    return found


# ---------------------------------------------------------------------------------------------------------- rainflow
@dataclass
class Cycles:
    """Ranges that are cycles, or half of one (with their weights), and the turning points."""

    ranges: list[tuple[float, float]]
    maxima: list[float]
    minima: list[float]

    @property
    def count(self) -> float:
        return sum(weight for _, weight in self.ranges)

    def damage(self, curve: sp.Basquin) -> float:
        """By Miner's sum."""
        return sum(weight / curve.cycles_at(0.5 * size) for size, weight in self.ranges)


def cycles(turns: Sequence[tuple[float, bool]], first: float, last: float) -> Cycles:
    """The three-point rule of ASTM E1049; the ends of the window turn, too."""
    found = Cycles([], [x for x, upper in turns if upper], [x for x, upper in turns if not upper])
    stack = [first]
    for point in [*(x for x, _ in turns), last]:
        if point == stack[-1]:
            continue
        if len(stack) > 1 and (point > stack[-1]) == (stack[-1] > stack[-2]):
            stack.pop()  # it goes on in this direction
        while len(stack) > 1 and abs(point - stack[-1]) >= abs(stack[-1] - stack[-2]):
            closed = abs(stack[-1] - stack[-2])
            if len(stack) == 2:  # it begins where the window does
                found.ranges.append((closed, 0.5))
                stack.pop(0)
            else:
                found.ranges.append((closed, 1.0))
                del stack[-2:]
        stack.append(point)
    found.ranges += [(abs(b - a), 0.5) for a, b in pairwise(stack)]
    return found


def turns_of(
    u: Floats, w: Floats, impacts: Sequence[Impact], low: float, high: float, window: Window
) -> list[tuple[float, bool]]:
    """Where a displacement between two walls turns, and whether it is a maximum: its rate is positive no longer.

    At the height of the cubic through both states.  In the group of an impact, and in the next one, the rate may have
    jumped: then where the straight lines through both states meet, or at the wall if that is near.
    """
    found, h = [], window.h
    struck = {max(each.step, 0) // GROUP for each in impacts}
    for n in range(window.low + 1, window.high):
        x0, v0, x, v = u[n], w[n], u[n + 1], w[n + 1]
        if (v0 > 0.0) == (v > 0.0):
            continue
        upper = bool(v0 > 0.0)
        if {n // GROUP, n // GROUP - 1} & struck:
            point = x0 + v0 * min(max((x - v * h - x0) / (v0 - v), 0.0), h)
            wall = high if upper else low
            if abs(wall - point) < 0.5 * h * (abs(v0) + abs(v)):
                point = wall
        else:
            s = v0 / (v0 - v)
            missing = x - x0 - 0.5 * h * (v0 + v)
            point = x0 + 0.5 * h * v0 * s + missing * s * s * (3.0 - 2.0 * s)
        found.append((max(point, x0, x) if upper else min(point, x0, x), upper))
    return found


def turns_of_force(force: Floats, window: Window) -> list[tuple[float, bool]]:
    """Where a force or an acceleration turns, as it is in the kicks: at the height of the parabola through three."""
    found = []
    for n in range(window.low + 2, window.high):
        rise, fall = force[n - 1] - force[n - 2], force[n] - force[n - 1]
        if (rise > 0.0) != (fall > 0.0):
            top = (rise + fall) ** 2 / (8.0 * (rise - fall)) if rise * fall < 0.0 else 0.0
            found.append((force[n - 1] + top, bool(rise > 0.0)))
    return found
