"""Rainflow counts: the cycles of a displacement, a force or an acceleration, counted during the run, and their damage.

The turning points of each path go to a stack, from which cycles are taken as soon as they are closed (ASTM E1049, the
three-point rule; the four-point rule gives the same cycles).  What is left at the end of the window, and each range
that begins at its first point, is half a cycle.  The ends of the window are turning points.

A displacement turns where its velocity changes sign between two steps: at the height of the cubic through both states
(of the step the error is of fourth order), or at the wall in an impact.  If other walls make it jump, at the crossing
of the tangents.  A force or an acceleration is seen in the middle of each step; it turns at the height of the
parabola through three of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numba import njit

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, shown
from springpot.problem.basquin import Basquin
from springpot.problem.catalogue import unit_of_result
from springpot.problem.parts import Dashpot, PolynomialDashpot, Springpot
from springpot.problem.parts.registration import unit_times
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import (
    GROUP,
    INLINE,
    LANES,
    beyond,
    greater,
    i8,
    i32,
    lesser,
    lowest_bit,
    marked_lanes,
    stack_array,
    u64,
)
from springpot.simulation.kernel.watching import ON_IMPACTS, ON_STEPS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.distributions import BINS, FINE, Distribution, bin_of, distribution_of
from springpot.simulation.watch.requested import Observed, Request

MOST_CURVES = 9
DEPTH = 72  # turning points on the stack of a path; of more, as in a long decay, the oldest range is half a cycle
_MOST_WAITING = (DEPTH + GROUP) * LANES  # all that may be closed in four steps
_LAYOUT = layout(
    cycles=LANES, damage=(MOST_CURVES, LANES),  # of each path, the latter by each curve
    ranges=BINS, peaks=2 * BINS, valleys=2 * BINS,  # counts
    exponents=MOST_CURVES, is_output=(), low=(), high=(),  # whether it is a force or an acceleration; walls
    last=LANES, rate=LANES,  # x and v after the last step, or an output in the last two
    struck=LANES,  # how long an impact is remembered
    size=LANES, stack=(LANES, DEPTH),
    waiting=(), range=_MOST_WAITING, weight=_MOST_WAITING, whose=_MOST_WAITING,  # closed ranges, not counted yet
)  # fmt: skip
(_LENGTH, _SCALE, _PATHS, _CYCLES, _DAMAGE, _RANGES, _PEAKS, _VALLEYS, _EXPONENTS, _IS_OUTPUT, _LOW, _HIGH, _LAST,
 _RATE, _STRUCK, _SIZE, _STACK, _WAITING, _RANGE, _WEIGHT, _WHOSE) = begins(
    _LAYOUT, "length", "frequency", "lanes", "cycles", "damage", "ranges", "peaks", "valleys", "exponents", "is_output",
    "low", "high", "last", "rate", "struck", "size", "stack", "waiting", "range", "weight", "whose",
)  # fmt: skip
_REMEMBERED = 2.0  # groups in which an impact may show


def longer_cycles(ranges: Distribution, rate: float, bars: int = 30) -> tuple[Floats, Floats, Floats]:
    """Some ranges, and the rate of the cycles that are longer, with its standard error.

    Most cycles of rough motion are tiny, so that a density of the ranges shows little else; these do no damage.

    Parameters
    ----------
    ranges : Distribution
    rate : float
        Of all cycles.

    Examples
    --------
    >>> place, longer, _ = longer_cycles(Distribution("m", "m-1", np.arange(3.0), np.array([[30.0, 10.0]])), 8.0, 4)
    >>> place, longer
    (array([0.5, 1. , 1.5]), array([5., 2., 1.]))
    """
    place = np.linspace(0.0, ranges.edges[-1], bars + 1)[1:-1]
    share, error = ranges.share_above(place)
    seen = share > 0.0
    return place[seen], rate * share[seen], rate * error[seen]


@dataclass(frozen=True, eq=False)
class Cycles(Request):
    """The cycles of a displacement, a force or an acceleration, and their damage.

    Attributes
    ----------
    curves : tuple of Basquin
    """

    curves: tuple[Basquin, ...]

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[Cycles]:
        motion, given = plan.motion, wishes["rainflow"]
        if not isinstance(given, Mapping) or not given:
            words = "rainflow must be a dict of names and Basquin curves"
            raise TypeError(f"{words}, such as {{'x': sp.Basquin(5.0, strength=0.01)}}, not {shown(given)}.")
        for name, wanted in given.items():
            signal = motion.signal_by_name(name, "rainflow")
            curves = wanted if isinstance(wanted, Sequence) else (wanted,)
            if not curves or not all(isinstance(curve, Basquin) for curve in curves):
                raise TypeError(f"rainflow of {name} must be a Basquin curve, or a list of them, not {shown(wanted)}.")
            if len(curves) > MOST_CURVES:
                raise ValueError(f"rainflow of {name} must have at most {MOST_CURVES} curves, not {len(curves)}.")
            _check_smooth(motion, name, curves)
            yield cls.of(motion, signal, (*curves,))

    @classmethod
    def of(cls, motion: Motion, signal: Signal, curves: tuple[Basquin, ...]) -> Cycles:
        """Of this one; the impacts on any wall make velocities jump, not only those on its own."""
        hard = not signal.outputs and bool(motion.system.walls)
        initial = np.zeros((), _LAYOUT)
        initial["exponents"][: len(curves)] = [curve.exponent for curve in curves]
        initial["is_output"], initial["low"], initial["high"] = bool(signal.outputs), signal.low, signal.high
        own = Observer(
            replace(signal, stop="" if hard else None), *_compiled(), initial,
            of_paths=("cycles", "damage"), of_batches=("ranges", "peaks", "valleys"),
        )  # fmt: skip
        return cls((own,), curves)

    @classmethod
    def longest_step(cls, motion: Motion, wishes: Mapping[str, Any]) -> float:
        """A force is behind a wall as steep as an impact."""
        given = wishes["rainflow"]
        of_forces = isinstance(given, Mapping) and any(name in motion.outputs for name in given)
        return FINE / motion.scales.fastest_rate if of_forces else math.inf

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        """Cycles, damage and life, each with the samples of the paths; distributions of ranges and turning points."""
        signal, sums = self.observer.signal, ensemble.observed[self.observer]
        settings, parts = simulation.settings, simulation.parts
        name, system = signal.names["x"], simulation.plan.system
        low, high = settings.window_steps
        time = (high - low) * settings.step
        unit = parts.units.length / (parts.outputs.scale if signal.outputs else 1.0)
        rate = sums["cycles"] / time
        found = {f"{name}_cycle_rate": (float(rate.mean()), rate)}
        for number, curve in enumerate(self.curves):
            end = f"_{number + 1}" if len(self.curves) > 1 else ""
            damage = sums["damage"][:, number] * curve.damage_per_hour(1.0 / time, unit)
            mean = float(damage.mean())
            life = 1.0 / mean if mean > 0.0 else math.nan
            found[f"{name}_damage_rate{end}"] = mean, damage
            found[f"{name}_life{end}"] = life, life + (mean - damage) * life**2
        units = (called := unit_of_result(system, f"{name}_range_quantile")), unit_times("1", called, -1)
        distributions = {
            f"{name}_{end}": distribution_of(*units, unit, sums[counts])
            for end, counts in (("range", "ranges"), ("peak", "peaks"), ("valley", "valleys"))
        }
        return {"estimates": found, "distributions": distributions}


def _check_smooth(motion: Motion, name: str, curves: Sequence[Basquin]) -> None:
    """The sum of powers of the ranges of a rough force grows without limit as the step shrinks, if they are small.

    Under white noise v is Brownian, so that the force of a springpot is Hölder continuous of the order 3/2 - alpha.
    """
    parts, rows = dict(motion.system.named()), motion.system.coordinates.elongations
    for part in motion.outputs[name].shares if name in motion.outputs else ():
        own = parts[part]  # of the derivative in its force:
        order = own.order if isinstance(own, Springpot) else float(isinstance(own, Dashpot | PolynomialDashpot))
        least, lowest = 1.0 / (1.5 - order), min(curve.exponent for curve in curves)
        if order > 0.5 and lowest <= least and motion.intensity_of(Signal(row=rows[part])) > 0.0:
            raise NotCoveredError(
                f"rainflow of {name} needs exponents above {least:.3g}: under white noise the force of {part} turns "
                "the more often the shorter the step, and with a smaller exponent so does its damage."
            )


# --- compiled ------------------------------------------------------------------------------------------------------


_powers, _places = stack_array(LANES), stack_array(LANES)


@njit(**INLINE)
def _wait(array, lane, size, weight, waiting, closed):
    """Keep a range that is a cycle, or half of one, if it is ``closed``; returns how many are kept now."""
    array[_RANGE + waiting], array[_WEIGHT + waiting], array[_WHOSE + waiting] = size, weight, lane
    return waiting + (1 if closed else 0)


@njit(**INLINE)
def _count(array, waiting):
    """Count the ranges that are kept: vector code finds their bins and powers."""
    power, factor, places = _powers(0.0), _powers(0.0), _places(i32(0))
    for begin in range(0, waiting, LANES):
        end = min(waiting - begin, LANES)
        for i in range(end):
            places[i] = bin_of(array[_RANGE + begin + i])
        for i in range(end):
            lane, weight = int(array[_WHOSE + begin + i]), array[_WEIGHT + begin + i]
            array[_CYCLES + lane] += weight
            if lane < array[_PATHS]:
                array[_RANGES + places[i]] += weight
        for c in range(MOST_CURVES):
            exponent = array[_EXPONENTS + c]
            if exponent == 0.0:
                break
            whole = int(exponent)
            for i in range(end):
                power[i], factor[i] = 1.0, 0.5 * array[_RANGE + begin + i]
            if whole != exponent:
                for i in range(end):
                    power[i] = math.exp(exponent * math.log(factor[i])) if factor[i] > 0.0 else 0.0
                whole = 0
            while whole > 0:
                for i in range(end if whole % 2 == 1 else 0):
                    power[i] *= factor[i]
                for i in range(end):
                    factor[i] *= factor[i]
                whole //= 2
            for i in range(end):
                lane, weight = int(array[_WHOSE + begin + i]), array[_WEIGHT + begin + i]
                array[_DAMAGE + c * LANES + lane] += weight * power[i]


@njit(**INLINE)
def _put(array, lane, point, waiting):
    """Put a turning point on the stack, and keep the cycles that it closes; returns how many are kept now.

    A range that is not shorter than the one before it closes that one, which is half a cycle if it begins at the first
    point.  A point in the direction of the last range makes it longer.
    """
    s, size = _STACK + lane * DEPTH, int(array[_SIZE + lane])
    if size > 0 and point == array[s + size - 1]:
        return waiting
    if size > 1 and (point - array[s + size - 1] > 0.0) == (array[s + size - 1] - array[s + size - 2] > 0.0):
        size -= 1
    elif size == DEPTH:
        waiting = _wait(array, lane, abs(array[s + 1] - array[s]), 0.5, waiting, True)
        for i in range(1, size):
            array[s + i - 1] = array[s + i]
        size -= 1
    if size > 2:  # whether a range closes one falls as a coin does, so no branch depends on it
        last, before = abs(point - array[s + size - 1]), abs(array[s + size - 1] - array[s + size - 2])
        closed = last >= before
        waiting = _wait(array, lane, before, 1.0, waiting, closed)
        size -= 2 if closed else 0
        while size > 2 and abs(point - array[s + size - 1]) >= abs(array[s + size - 1] - array[s + size - 2]):
            waiting = _wait(array, lane, abs(array[s + size - 1] - array[s + size - 2]), 1.0, waiting, True)
            size -= 2
    if size == 2 and abs(point - array[s + 1]) >= abs(array[s + 1] - array[s]):
        waiting = _wait(array, lane, abs(array[s + 1] - array[s]), 0.5, waiting, True)
        array[s] = array[s + 1]
        size = 1
    array[s + size] = point
    array[_SIZE + lane] = size + 1
    return waiting


@njit(**INLINE)
def _moved(array, lane, x0, v0, x, v, h):
    """Where a displacement turns in a step, and whether at a maximum: its velocity is positive no longer."""
    upper = v0 > 0.0
    if array[_STRUCK + lane] > 0.0:
        at = (x - v * h - x0) / (v0 - v)
        point = x0 + v0 * min(max(at, 0.0), h)
        wall = array[_HIGH if upper else _LOW] / abs(array[_LENGTH])
        if abs(wall - point) < 0.5 * h * (abs(v0) + abs(v)):
            point = wall
    else:
        share = v0 / (v0 - v)
        missing = x - x0 - 0.5 * h * (v0 + v)
        point = x0 + 0.5 * h * v0 * share + missing * share * share * (3.0 - 2.0 * share)
    most, least = greater(greater(point, x0), x), lesser(lesser(point, x0), x)
    return most if upper else least, upper


@njit(**INLINE)
def _bent(before, last, now):
    """Where a force or an acceleration turns, and whether at a maximum: it rises no longer."""
    rise, fall = last - before, now - last
    top = (rise + fall) ** 2 / (8.0 * (rise - fall)) if rise * fall < 0.0 else 0.0
    return last + top, rise > 0.0


@njit(**INLINE)
def _earlier(x, array, kept, j, begin):
    """Where x before step j is: in this group, or what was kept of the one before."""
    return beyond(x, (j - 1) * LANES) if j > begin else beyond(array, kept)


_marks = stack_array(LANES)


@cache
def _compiled() -> tuple[Any, Any]:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        is_output = array[_IS_OUTPUT] > 0.0
        sign = math.copysign(1.0, array[_LENGTH])
        scale = sign * array[_SCALE] if is_output else sign
        begin, end, waiting = max(low - n, 0), min(high - n, GROUP), int(array[_WAITING])
        if n <= low:
            for lane in range(LANES):
                here = x[begin * LANES + lane]
                array[_STACK + lane * DEPTH], array[_SIZE + lane] = scale * here, 1.0
                array[_LAST + lane], array[_RATE + lane] = here, here if is_output else v[begin * LANES + lane]
        # vector code marks the steps in which a lane turns
        turned = _marks(i8(0))
        for lane in range(LANES):
            turned[lane] = 0
        for j in range(begin, end):
            last = _earlier(x if is_output else v, array, _RATE, j, begin)
            if is_output:
                before = _earlier(x, array, _RATE if j > begin else _LAST, j - 1, begin)
                for lane in range(LANES if n + j > low + 1 else 0):  # the first value has none before it
                    a, b, c = scale * before[lane], scale * last[lane], scale * x[j * LANES + lane]
                    turned[lane] |= (1 << j) if (b > a) != (c > b) else 0
            else:
                for lane in range(LANES):
                    a, b = sign * last[lane], sign * v[j * LANES + lane]
                    turned[lane] |= (1 << j) if (a > 0.0) != (b > 0.0) else 0
        lanes = marked_lanes(turned)
        while lanes != u64(0):
            lane = lowest_bit(lanes)
            lanes &= lanes - u64(1)
            steps = u64(turned[lane])
            while steps != u64(0):
                j = lowest_bit(steps)
                steps &= steps - u64(1)
                here, last = x[j * LANES + lane], _earlier(x if is_output else v, array, _RATE, j, begin)[lane]
                if is_output:
                    before = _earlier(x, array, _RATE if j > begin else _LAST, j - 1, begin)[lane]
                    point, upper = _bent(scale * before, scale * last, scale * here)
                else:
                    before = _earlier(x, array, _LAST, j, begin)[lane]
                    speed = sign * v[j * LANES + lane]
                    point, upper = _moved(array, lane, sign * before, sign * last, sign * here, speed, step)
                if lane < array[_PATHS]:
                    at = (_PEAKS if upper else _VALLEYS) + (BINS if point < 0.0 else 0)
                    array[at + bin_of(abs(point))] += 1.0
                waiting = _put(array, lane, point, waiting)
        if end == GROUP:
            for lane in range(LANES):
                array[_LAST + lane] = x[(2 if is_output else 3) * LANES + lane]
                array[_RATE + lane] = x[3 * LANES + lane] if is_output else v[3 * LANES + lane]
        for lane in range(LANES):
            array[_STRUCK + lane] = greater(array[_STRUCK + lane] - 1.0, 0.0)
        if n + GROUP >= high:
            for lane in range(LANES):
                waiting = _put(array, lane, scale * x[(end - 1) * LANES + lane], waiting)
                s, size = _STACK + lane * DEPTH, int(array[_SIZE + lane])
                for i in range(1, size):
                    waiting = _wait(array, lane, abs(array[s + i] - array[s + i - 1]), 0.5, waiting, True)
        if waiting >= LANES or n + GROUP >= high:
            _count(array, waiting)
            waiting = 0
        array[_WAITING] = waiting

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        array[_STRUCK + lane] = _REMEMBERED

    return on_steps, on_impacts
