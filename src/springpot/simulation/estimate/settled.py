"""Whether a run is stationary, and what a start still does to its means, from the run itself.

Each mean square of a mass is averaged over the first and over the second half of the window.  The paths are
independent, and in a stationary state the difference of the two is symmetric about 0 however slowly a path forgets: so
Student's law holds for its mean over the paths.  The gain of the energy over the window is another such difference.

A slow transient hardly changes within a window, and few paths do not show it.  Where masses may wait long, runs from
two starts on either side of the stationary state are compared as well.

A springpot whose elongation started at m and has the mean x pulls back with C (x - m) t^-alpha / Gamma(1 - alpha).  In
equilibrium a small force moves a mean by the variance of the elongation over its temperature, m <v^2>: so far is x from
its stationary value.  Walls and nonlinear springs are in the variance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import per_cent
from springpot.problem.messages import Message, say
from springpot.simulation.kernel.sizes import LANES, middle_of
from springpot.simulation.paths.simulation import Progress, Simulation, simulation_of
from springpot.simulation.paths.statistics import standard_error
from springpot.simulation.plan.plan import MOST_TRANSIENT, Plan

UNLIKELY = 0.01  # probability that a stationary run is doubted, by all its differences together
LIKELY = 2.5  # standard errors within which a difference has more than that probability, however many paths there are
MATTERS = 0.01  # change over the mean
MATTERS_ALIKE = 0.04  # where all paths are alike: of a cycle, too
FARTHEST = 10.0  # ends of the window to which the time that is needed is extrapolated
ENERGY = "the mean energy"
_STREAM, _PATHS = 4, LANES  # of runs that are only compared


@dataclass(frozen=True, eq=False)
class Change:
    """A mean at two times, or from two starts: the difference of the first from the second.

    Attributes
    ----------
    name : str
        What it is the mean of.
    mean, difference, error : float
        The last is the standard error of the difference.
    freedom : float
        Degrees of freedom of that.
    compared : str
        What is compared, as in a sentence.
    later : float
        Time in s at which a window may begin.
    """

    name: str
    mean: float
    difference: float
    error: float
    freedom: float
    compared: str
    later: float

    @property
    def share(self) -> float:
        """The size of the difference over the mean."""
        return abs(self.difference) / abs(self.mean) if self.mean else 0.0

    @property
    def chance(self) -> float:
        """The probability of such a difference, or a larger one, in a stationary state."""
        from scipy.special import stdtr  # most runs do without it

        return float(2.0 * stdtr(self.freedom, -abs(self.difference) / self.error)) if self.error > 0.0 else 0.0

    @property
    def said(self) -> Message:
        """The warning."""
        share = per_cent(self.share)
        if self.error > 0.0:
            share += f" ({min(abs(self.difference) / self.error, 999.0):.0f} standard errors)"
        return say(
            "still_changes", name=self.name, share=share, compared=self.compared, later=rounded_up(self.later)
        )  # fmt: skip


def change_in_window(
    simulation: Simulation, rows: Floats, matters: float = MATTERS, wanted: Sequence[str] = ()
) -> Change | None:
    """What is not stationary in a run; None where no change is both unlikely by chance and large enough to matter.

    Parameters
    ----------
    simulation : Simulation
    rows : ndarray, shape (paths, columns)
        Of `Simulation.advance`.
    matters : float
        Over the mean.
    wanted : sequence of str
        The results that matter; all if left out.  Slow displacements change no mean square of a velocity.
    """
    if simulation.motion.not_stationary or len(rows) < 3:
        return None
    names = _changing_with(simulation, wanted)
    if not simulation.motion.is_random:  # all paths are alike, and no difference is by chance
        names, matters = {ENERGY}, max(matters, MATTERS_ALIKE)
    return _unlikely([each for each in _changes(simulation, rows) if each.name in names], matters)


def _changing_with(simulation: Simulation, wanted: Sequence[str]) -> set[str]:
    """The means that change where a transient changes one of some results."""
    every = {ENERGY, *simulation.parts.halves}
    placed = [name for name in wanted if not name.endswith(("v_mean_square", "_power"))]
    squares = {simulation.motion.mean_square_of(name) for name in placed}
    if not wanted or not squares <= every:
        return every
    return squares | {name for name in every if name.endswith("v_mean_square") or (squares and name == ENERGY)}


def _unlikely(changes: list[Change], matters: float) -> Change | None:
    """The most unlikely of the changes that matter."""
    large = [each for each in changes if each.share > matters and abs(each.difference) > LIKELY * each.error]
    worst = min(large, key=lambda each: each.chance, default=None)
    return worst if worst is not None and worst.chance < UNLIKELY / len(changes) else None


def _changes(simulation: Simulation, rows: Floats) -> Iterator[Change]:
    """Of each mean square between the halves of the window, and of the energy between its ends."""
    (low, high), step = simulation.settings.window_steps, simulation.settings.step
    middle = middle_of(low, high)
    sums = simulation.parts.sums(rows)
    freedom = len(rows) - 1.0
    first, last = sums["energy", "first"], sums["energy", "last"]
    gained = float((last - first).mean())
    yield Change(
        ENERGY, float((last + first).mean()) / 2.0, gained, standard_error(last - first), freedom,
        "from the beginning of the window to its end", high * step,
    )  # fmt: skip
    if not low < middle < high:
        return
    for name, (whole, early) in simulation.parts.halves.items():
        before, after = sums[early] / (middle - low), (sums[whole] - sums[early]) / (high - middle)
        one, other = float(before.mean()), float(after.mean())
        later = high * step
        if simulation.settings.start == "rest" or simulation.parts.law is None:  # it begins without motion
            later = max(later, _settled_from(one, other, step * low, step * middle, step * high))
        yield Change(
            name, 0.5 * (one + other), other - one, standard_error(after - before), freedom,
            "from the first half of the window to the second", later,
        )  # fmt: skip


def _settled_from(first: float, second: float, begin: float, middle: float, end: float) -> float:
    """When MOST_TRANSIENT is left of a mean that grows from 0 as 1 - exp(-t / T), from its means in two intervals."""
    if not second > first > 0.0:
        return 0.0

    def ratio(rate: float) -> float:
        left = [math.exp(-rate * time) for time in (begin, middle, end)]
        grown = [
            1.0 - (left[n] - left[n + 1]) / (rate * width) for n, width in enumerate((middle - begin, end - middle))
        ]
        return grown[1] / grown[0]

    slow, fast = 0.1 / end, 50.0 / end  # the ratio falls to 1 with the rate
    for _ in range(40):
        rate = 0.5 * (slow + fast)
        slow, fast = (rate, fast) if ratio(rate) > second / first else (slow, rate)
    return min(-math.log(MOST_TRANSIENT) / fast, FARTHEST * end)


def change_of_start(plan: Plan, matters: float, progress: Progress | None = None) -> Change | None:
    """What a run from rest has otherwise in its window than one from the start of the plan; None as above."""
    plans = plan.but(paths=_PATHS), plan.from_rest.but(paths=_PATHS)
    simulations = [simulation_of(each) for each in plans]
    rows = [each.advance(stream=_STREAM + n, progress=progress).rows for n, each in enumerate(simulations)]
    parts, (low, high) = simulations[0].parts, plan.settings.window_steps
    sums, changes = [parts.sums(each) for each in rows], []
    for name, (whole, _) in parts.halves.items():
        one, other = (each[whole] / (high - low) for each in sums)
        errors = standard_error(one), standard_error(other)
        error = math.hypot(*errors)
        freedom = error**4 / sum(each**4 for each in errors) * (_PATHS - 1.0) if error > 0.0 else math.inf
        mean, apart = 0.5 * float(one.mean() + other.mean()), float(other.mean() - one.mean())
        compared = "between a start from rest and the usual one"
        changes.append(Change(name, mean, apart, error, freedom, compared, plan.settings.window[1]))
    return _unlikely(changes, matters)


def rounded_up(time: float) -> float:
    """A time to three digits, not rounded down: a window that begins there is late enough.

    Examples
    --------
    >>> rounded_up(230.2585), rounded_up(7.0)
    (231.0, 7.0)
    """
    if not 0.0 < time < math.inf:
        return time
    unit = 10.0 ** (math.floor(math.log10(time)) - 2)
    return float(math.ceil(time / unit * (1.0 - 1e-12)) * unit)


@dataclass(frozen=True)
class Left:
    """What is left of a start in a mean.

    Attributes
    ----------
    name : str
        How the names of its results begin.
    off, error : float
        How far it is from its stationary value, about, and the standard error of that; over its root mean square.
    order : float
        Of the springpot.
    """

    name: str
    off: float
    error: float
    order: float


def left_of_start(plan: Plan, values: Mapping[str, float], errors: Mapping[str, float]) -> Iterator[Left]:
    """What is left in the mean of each elongation with a springpot, where that need not be 0."""
    motion, (begin, end) = plan.motion, plan.settings.window
    if not motion.searched:
        return
    start = motion.system.coordinates.places_of(plan.settings.initial_position)
    speeds = np.array([values[f"{name.removesuffix('x_mean')}v_mean_square"] for name in motion.mean_names])
    for kept in motion.kept_means:
        mean, square = (values[f"{kept.name}_{of}"] for of in ("mean", "mean_square"))
        speed = float(kept.row**2 @ speeds)
        if not (square > 0.0 and speed > 0.0 and f"{kept.name}_mean" not in motion.zeros):
            continue
        later = 1.0 - kept.order
        fading = (end**later - begin**later) / ((end - begin) * later * math.gamma(later))
        size = math.sqrt(motion.square_about_origin(values, f"{kept.name}_mean"))
        moved = kept.coefficient * fading * (square - mean * mean) / speed / size
        off, error = abs(mean - float(kept.row @ start)), errors[f"{kept.name}_mean"]
        yield Left(kept.name, moved * off, moved * error, kept.order)
