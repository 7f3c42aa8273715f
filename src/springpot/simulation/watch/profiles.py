"""Profiles: means, mean squares, impacts and powers in bins of time, for motions that are not stationary.

Each path adds its means over a bin, by the trapezoidal rule, to a sum and to a sum of squares, so that nothing is kept
of a path.  Bins are made of whole groups of four steps, in which the kernel shows states and impacts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from numbers import Real
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.machine.arguments import finite_number, items_of, without_axis
from springpot.machine.arrays import Columns, Floats
from springpot.machine.faults import shown
from springpot.problem.catalogue import possible_results, unit_of_result
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES
from springpot.simulation.kernel.watching import ON_IMPACTS, ON_STEPS
from springpot.simulation.lowering.compose import Parts
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.paths.statistics import NORMAL, UPPER
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.forces import signals_of_forces
from springpot.simulation.watch.requested import Observed, Request

MOST_SUMS = 30_000_000  # stored numbers, 0.24 GB
_KINDS = 7  # x, x^2, v^2, impacts, squares of their speeds, speeds, and impacts and speeds together
_X, _XX, _VV, _HITS, _SQUARES, _SPEEDS, _BOTH = range(_KINDS)
_POWERS = 2  # of dampers and memory, and of excitations

# the present bin, the number of ends, and where those and the sums of all lanes begin
_HEAD: dict[str, tuple[int, ...]] = dict.fromkeys(("place", "count", "ends_at", "totals_at"), ())


def _layout(ends: int) -> np.dtype[np.void]:
    """With the least speed of an impact that counts, x and v before the step, and the sums of each lane."""
    return layout(
        **_HEAD, least=(), before=(2, LANES), sums=(_KINDS, LANES), ends=ends, totals=(ends, _KINDS, 2)
    )  # fmt: skip


def _layout_of_powers(ends: int, channels: int) -> np.dtype[np.void]:
    """With the number of the kernel's sums, and their factors in each power."""
    return layout(
        **_HEAD, channels=(), weights_at=(), sums=(_POWERS, LANES), ends=ends, totals=(ends, _POWERS, 2),
        weights=(_POWERS, channels),
    )  # fmt: skip


_LENGTH, _SPEED, _PATHS, _PLACE, _COUNT, _ENDS_AT, _TOTALS_AT, _LEAST, _BEFORE, _SUMS = begins(
    _layout(0), "length", "speed", "lanes", *_HEAD, "least", "before", "sums"
)
_CHANNELS, _WEIGHTS_AT, _SUMS_OF_POWERS = begins(_layout_of_powers(0, 0), "channels", "weights_at", "sums")


@dataclass(frozen=True, eq=False)
class Profile:
    """The means of a quantity in bins of time, over all paths.

    Attributes
    ----------
    edges : ndarray, shape (bins + 1,)
        In s.
    value, standard_error : ndarray, shape (bins,)
        In ``unit``.
    unit : str

    Examples
    --------
    >>> Profile(np.array([0.0, 1.0, 3.0]), np.ones(2), np.zeros(2), "m2").time
    array([0.5, 2. ])
    """

    edges: Floats
    value: Floats
    standard_error: Floats
    unit: str

    @property
    def time(self) -> Floats:
        """The middle of each bin, in s."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])

    def columns(self, name: str, probabilities: Sequence[float]) -> Columns:
        """Everything for tables and files."""
        axes, unit = ("time_bin",), {"units": self.unit}
        return {
            "time_bin": (axes, self.time, {"units": "s"}),
            "time_bin_width": (axes, np.diff(self.edges), {"units": "s"}),
            name: (axes, self.value, unit),
            f"{name}_se": (axes, self.standard_error, unit),
        }

    def __str__(self) -> str:
        known = self.value[np.isfinite(self.value)]
        found = f"{known.min():.3g} to {known.max():.3g} {self.unit}" if known.size else "none"
        return f"{found} in {self.value.size} bins, {self.edges[0]:g} to {self.edges[-1]:g} s"


@dataclass(frozen=True, eq=False)
class Bins(Request):
    """The profiles of a displacement, or of a force or an acceleration, and of the impacts that belong to it.

    Attributes
    ----------
    edges : ndarray of int
        Ends of the bins, in steps.
    """

    edges: npt.NDArray[np.int64]

    over_time: ClassVar[bool] = True

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[Bins]:
        motion, slowest = plan.motion, wishes.get("slowest_counted_impact")
        moved = [*motion.signals, *(signal for signal in signals_of_forces(plan, wishes) if signal.outputs)]
        fast = {} if slowest is None else motion.speeds
        edges = _checked_edges(wishes["profile"], plan.settings, len(moved) + len(fast) + 1)
        for signal in moved:
            yield cls.of(signal, edges, plan.settings)
        for name, signal in fast.items():  # the same, but not slow ones
            own = {"counted_impact_speed": f"{name.removesuffix('impact_speed')}counted_impact_speed"}
            yield cls.of(replace(signal, names=own), edges, plan.settings, slowest or 0.0)

    @classmethod
    def of(cls, signal: Signal, edges: npt.NDArray[np.int64], settings: Settings, slowest: float = 0.0) -> Bins:
        """Of this one, with its impacts that are not slower than a speed in m/s."""
        initial = _begun(_layout(edges.size), edges, settings)
        initial["least"] = slowest
        # impacts alone have no states, but the steps must tell the bins
        signal = replace(signal, number=signal.number or 0)
        return cls((Observer(signal, *_compiled(), initial, of_blocks=("totals",)),), edges)

    def in_full(self, settings: Settings) -> bool:
        return True

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        motion, settings, edges = simulation.motion, simulation.settings, self.edges
        sums = ensemble.observed[self.observer]["totals"].sum(axis=0)[1:]
        steps, width = np.diff(edges), np.diff(edges) * settings.step
        over = {_X: steps, _XX: steps, _VV: steps, _HITS: width, _SQUARES: width}
        found = dict[str, tuple[Floats, Floats]]()
        for name, kind, factor in _wanted(motion, self.observer.signal):
            if kind == _SPEEDS:  # the ratio of the sums of speeds and of impacts, and its error, linearized
                hits, speeds, both = (sums[:, of] for of in (_HITS, _SPEEDS, _BOTH))
                struck = hits[:, 0] > 0.0
                below = np.where(struck, hits[:, 0], 1.0)
                value = np.where(struck, speeds[:, 0] / below, np.nan)
                together = 0.5 * (both[:, 1] - hits[:, 1] - speeds[:, 1])
                spread = np.maximum(speeds[:, 1] - 2.0 * value * together + value**2 * hits[:, 1], 0.0)
                found[name] = value, np.sqrt(spread * settings.paths / max(settings.paths - 1, 1)) / below
                continue
            mean, error = _over_paths(sums[:, kind], motion, settings)
            if kind in (_HITS, _SQUARES):
                unseen = sums[:, _HITS, 0] == 0.0
                error = np.where(unseen, UPPER / NORMAL / settings.paths if kind == _HITS else np.nan, error)
                if kind == _HITS and motion.uncounted_because(name):
                    mean, error = np.full_like(mean, np.nan), np.full_like(mean, np.nan)
            per_bin = np.asarray(factor / over[kind], float)
            found[name] = np.asarray(mean * per_bin), np.asarray(error * per_bin)
        return _profiles(simulation, edges, found)


@dataclass(frozen=True, eq=False)
class PowersInBins(Request):
    """The profiles of the power that dampers and memory take, and of what excitations feed in.

    Attributes
    ----------
    edges : ndarray of int
        As of `Bins`.
    """

    edges: npt.NDArray[np.int64]

    over_time: ClassVar[bool] = True

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[PowersInBins]:
        edges = _checked_edges(wishes["profile"], plan.settings, 1)

        def initial(parts: Parts) -> npt.NDArray[np.void]:
            """With the factors of the kernel's sums; what excitations feed in is beyond an expected power."""
            names = [("power", ""), *(("work", each.name) for each in parts.named)]
            does = ["", *(each.does for each in parts.named)]
            kind = _layout_of_powers(edges.size, len(names))
            array = _begun(kind, edges, plan.settings)
            array["channels"], (array["weights_at"],) = len(names), begins(kind, "weights")
            array["weights"] = (
                [parts.damped.get(name, 0.0) * parts.columns[name] for name in names],
                [
                    parts.columns[name] / plan.settings.step if what in ("feeds", "expected") else 0.0
                    for name, what in zip(names, does, strict=True)
                ],
            )
            return array

        signal = Signal(number=plan.motion.displacements_shown)
        yield cls((Observer(signal, _compiled_of_powers(), None, initial, of_blocks=("totals",)),), edges)

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        motion, settings, parts, edges = simulation.motion, simulation.settings, simulation.parts, self.edges
        sums = ensemble.observed[self.observer]["totals"].sum(axis=0)[1:]
        expected = parts.expected_in_bins(edges)
        share = parts.taken_at_once / parts.expected_power if parts.expected_power > 0.0 else 0.0
        found = dict[str, tuple[Floats, Floats]]()
        for kind, (name, beside) in enumerate((("damping_power", share * expected), ("input_power", expected))):
            if name in possible_results(motion.system):
                mean, error = (each / np.diff(edges) for each in _over_paths(sums[:, kind], motion, settings))
                found[name] = mean + beside, error
        return _profiles(simulation, edges, found)


def _begun(kind: np.dtype[np.void], edges: npt.NDArray[np.int64], settings: Settings) -> npt.NDArray[np.void]:
    """An array with the ends of the bins; the time before the first is a bin too, the one of number 0."""
    array = np.zeros((), kind)
    array["place"] = 1.0 if edges[0] == settings.window_steps[0] else 0.0
    array["count"], array["ends"] = edges.size, edges
    array["ends_at"], array["totals_at"] = begins(kind, "ends", "totals")
    return array


def _profiles(
    simulation: Simulation, edges: npt.NDArray[np.int64], found: Mapping[str, tuple[Floats, Floats]]
) -> Observed:
    times, system = np.asarray(edges * simulation.settings.step, np.float64), simulation.plan.system
    own = {f"{name}_profile": both for name, both in found.items()}
    return {"profiles": {name: Profile(times, *both, unit_of_result(system, name)) for name, both in own.items()}}


def _checked_edges(wanted: Any, settings: Settings, displacements: int) -> npt.NDArray[np.int64]:
    """The ends of the bins in steps, of so many equal bins in the window or between the times given.

    Raises
    ------
    TypeError, ValueError
        If it is neither, or a bin would be shorter than four steps.
    """
    low, high = settings.window_steps
    must = "profile must be a number of bins, or times in s between them"
    wanted = without_axis(wanted)
    if isinstance(wanted, bool):
        raise TypeError(f"{must}, not {shown(wanted)}.")
    if isinstance(wanted, Real):
        count = finite_number(wanted, "profile", low=1.0, high=1e6, hint="It is a number of bins, or times in s.")
        if count != int(count):
            raise ValueError(f"profile must be a whole number of bins, not {count:g}.")
        times = settings.step * np.linspace(low, high, int(count) + 1)
    else:
        times = np.array(
            [finite_number(t, "profile time", low=0.0, hint="It is in s.") for t in items_of(wanted, must)]
        )
        if times.size < 2 or (np.diff(times) <= 0.0).any():
            raise ValueError("profile must be two or more times that increase, or a number of bins.")
        begin, end = settings.window
        if times[0] < begin - 0.5 * settings.step or times[-1] > end + 0.5 * settings.step:
            raise ValueError(f"profile must lie in the window from {begin:g} s to {end:g} s; window may begin earlier.")
    steps = GROUP * np.rint(times / (GROUP * settings.step)).astype(np.int64)
    steps[times < (low + 0.5) * settings.step] = low  # an end of the window need not be one of a group
    steps[times > (high - 0.5) * settings.step] = high
    if (np.diff(steps) <= 0).any() or (steps < low).any() or (steps > high).any():
        raise ValueError(
            f"profile has bins that are shorter than {GROUP} steps, {GROUP * settings.step:.3g} s: use fewer, or a "
            "shorter step."
        )
    blocks = -(-settings.paths // LANES)
    numbers = blocks * displacements * 2 * _KINDS * steps.size
    if numbers > MOST_SUMS:
        raise ValueError(
            f"profile of {steps.size - 1} bins and {settings.paths:,} paths would keep {numbers:,} numbers, but at "
            f"most {MOST_SUMS:,} are kept: use fewer bins."
        )
    return steps


def _over_paths(sums: Floats, motion: Motion, settings: Settings) -> tuple[Floats, Floats]:
    """Mean and standard error of one sum from totals and squares."""
    total, square, paths = sums[..., 0], sums[..., 1], settings.paths
    mean = total / paths
    if paths == 1:
        return mean, np.full_like(mean, 0.0 if motion.different_paths == 1 else np.nan)
    return mean, np.sqrt(np.maximum(square / paths - mean * mean, 0.0) / (paths - 1))


def _wanted(motion: Motion, signal: Signal) -> Iterator[tuple[str, int, float]]:
    """Name, sum and factor of each result of a displacement."""
    if "x" in signal.names:
        yield f"{signal.names['x']}_mean", _X, 1.0
        yield f"{signal.names['x']}_mean_square", _XX, 1.0
    if "v" in signal.names:
        yield f"{signal.names['v']}_mean_square", _VV, 1.0
    if "impact_speed" in signal.names and motion.touched:
        start = signal.names["impact_speed"].removesuffix("impact_speed")
        yield f"{start}impact_rate", _HITS, 1.0
        if not motion.uncounted_because(mean := f"{start}impact_speed_mean"):
            yield mean, _SPEEDS, 1.0
        if not math.isnan(taken := _taken(motion, signal)):
            yield f"{start}impact_power", _SQUARES, taken
    if "counted_impact_speed" in signal.names:
        mean = f"{signal.names['counted_impact_speed']}_mean"
        yield f"{mean.removesuffix('speed_mean')}rate", _HITS, 1.0
        yield mean, _SPEEDS, 1.0


def _taken(motion: Motion, signal: Signal) -> float:
    """Energy that walls take from an impact, over the square of its speed; NaN if that is no number.

    What comes to rest counts as one more impact: it leaves with no speed, which is r times its own to the order of a
    step.
    """
    stops, walls = [signal.stop] if signal.stop else [*motion.system.stops], motion.system.walls
    laws = {walls[name].restitution for name in stops if name in walls}
    if len(laws) != 1 or callable(*laws) or not {*stops} <= {*walls}:
        return math.nan
    at = motion.system.coordinates
    row = at.elongations[signal.stop] if signal.stop else np.ones(1)  # of one mass all walls
    mass = 1.0 / float(row @ at.accelerations(row))
    (restitution,) = laws
    return 0.5 * mass * (1.0 - float(restitution) ** 2)  # type: ignore[arg-type]


# --- compiled ------------------------------------------------------------------------------------------------------


@cache
def _compiled() -> tuple[Any, Any]:
    """The time before the first end is a bin too, the one of number 0."""

    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        place, count = int(array[_PLACE]), int(array[_COUNT])
        if place >= count:
            return
        if n <= low:  # the state before the window is not shown
            for lane in range(LANES):
                array[_BEFORE + lane] = x[(low - n) * LANES + lane]
                array[_BEFORE + LANES + lane] = v[(low - n) * LANES + lane]
        if low <= n and n + GROUP <= high:
            for lane in range(LANES):
                total = square = moving = 0.0
                for j in range(GROUP):
                    total += x[j * LANES + lane]
                    square += x[j * LANES + lane] * x[j * LANES + lane]
                    moving += v[j * LANES + lane] * v[j * LANES + lane]
                array[_SUMS + _X * LANES + lane] += total
                array[_SUMS + _XX * LANES + lane] += square
                array[_SUMS + _VV * LANES + lane] += moving
        else:
            for i in range(max(low - n, 0) * LANES, min(high - n, GROUP) * LANES):
                array[_SUMS + _X * LANES + i % LANES] += x[i]
                array[_SUMS + _XX * LANES + i % LANES] += x[i] * x[i]
                array[_SUMS + _VV * LANES + i % LANES] += v[i] * v[i]
        if n + GROUP < array[int(array[_ENDS_AT]) + place] and n + GROUP < high:
            return
        # of the trapezoidal rule, by which only the ends of a bin count in another way than in a plain sum
        length, speed, last = array[_LENGTH], array[_SPEED], (min(high - n, GROUP) - 1) * LANES
        for lane in range(LANES):
            was, moved = array[_BEFORE + lane], array[_BEFORE + LANES + lane]
            here, moving = x[last + lane], v[last + lane]
            array[_SUMS + _X * LANES + lane] = length * (array[_SUMS + _X * LANES + lane] + 0.5 * (was - here))
            square = array[_SUMS + _XX * LANES + lane] + 0.5 * (was * was - here * here)
            array[_SUMS + _XX * LANES + lane] = length * length * square
            square = array[_SUMS + _VV * LANES + lane] + 0.5 * (moved * moved - moving * moving)
            array[_SUMS + _VV * LANES + lane] = speed * speed * square
            array[_BEFORE + lane], array[_BEFORE + LANES + lane] = here, moving
        _end_bin(array, _SUMS, _KINDS)

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        before = array[_SPEED] * speed
        if before < array[_LEAST]:
            return
        array[_SUMS + _HITS * LANES + lane] += count
        array[_SUMS + _SQUARES * LANES + lane] += count * before * before
        array[_SUMS + _SPEEDS * LANES + lane] += count * before
        array[_SUMS + _BOTH * LANES + lane] += count * (1.0 + before)

    return on_steps, on_impacts


@njit(**INLINE)
def _end_bin(array, sums, kinds):
    """Add the sums of each lane to those of the present bin, and go to the next."""
    place, totals = int(array[_PLACE]), int(array[_TOTALS_AT])
    for kind in range(kinds):
        total = square = 0.0
        for lane in range(LANES):
            own = array[sums + kind * LANES + lane]
            if lane < array[_PATHS]:
                total += own
                square += own * own
            array[sums + kind * LANES + lane] = 0.0
        at = totals + 2 * (place * kinds + kind)
        array[at] = total
        array[at + 1] = square
    array[_PLACE] = place + 1.0


@cache
def _compiled_of_powers() -> Any:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        place, count, channels = int(array[_PLACE]), int(array[_COUNT]), int(array[_CHANNELS])
        if place >= count:
            return
        ends, weights, sums = int(array[_ENDS_AT]), int(array[_WEIGHTS_AT]), _SUMS_OF_POWERS
        for kind in range(_POWERS):
            for k in range(channels):
                weight = array[weights + kind * channels + k]
                for lane in range(LANES if weight != 0.0 else 0):
                    array[sums + kind * LANES + lane] += weight * v[k * LANES + lane]
        if n + GROUP >= array[ends + place] or n + GROUP >= high:
            _end_bin(array, sums, _POWERS)

    return on_steps
