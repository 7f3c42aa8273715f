"""The error budget: "this quantity to 1 %", and where the per cent goes.

The run starts adapted.  Two levels estimate each quantity: many paths at a coarse step h, and fewer pairs of paths at h
and h/2 on the same noise, whose mean difference D is added (Giles, "Multilevel Monte Carlo methods", Acta Numerica 24,
2015).  D also tells the step's bias: a method of order p that changes by D from h to h/2 is still off by D/(2^p - 1).
Paths that strike a wall soon part whatever noise they share, so the difference keeps a fifth to a half of the variance
and more levels would not pay; the budget needs the pairs all the same.

The energy balance is a control variate: what springpot and wall took out and the motion gained, less what the noise is
expected to feed in, has mean zero exactly, at every step of the default scheme.  A path that was fed more than its
share swings wider, so its part in the balance explains nine tenths of the variance of energies, and half or more of
that of the mean; what is left of each estimate is its regression's residual.

Paths are added until the sum of the parts is below what was asked for, and the step is halved where its bias stands in
the way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.faults import meant
from springpot.oscillator import Oscillator, finite_number
from springpot.simulation.adapted import Adapted, adapt, owed_to_the_start
from springpot.simulation.ensemble import Floats, Progress, Tables, advance, tables
from springpot.simulation.lanes import LANES
from springpot.simulation.settings import Settings, fastest_rate, impacts_are_countable, relaxation_time, resolve
from springpot.simulation.slow_impacts import even_step, slow_impact_order
from springpot.simulation.statistics import controlled, linearised, standard_error
from springpot.theory.result import MOMENTS

__all__ = ["CONTROLLED", "Budget", "Reached", "checked_quantities", "reach"]

CONTROLLED = MOMENTS
"""Quantities that have a budget."""

NORMAL = 1.959964  # half-width of a 95 % interval, in standard errors
COARSEST_STEP = 0.1  # first step tried, in units of the shortest time scale
FINEST_STEP = 1e-3
EXTRAPOLATED = 0.1  # of a difference that has been taken to step 0
FORGOTTEN = 101.0  # the start, at least, before the window: what a run does not warn of
FIRST_PATHS = 2048
SURE = 4.0  # standard errors beyond which a difference between steps is bias
PILOT_PATHS = 2048
MOST_PATH_STEPS = 3e11
SINGLE_PRECISION = 1e-4  # largest relative effect of memory in single precision that was ever seen, twice over


@dataclass(frozen=True)
class Budget:
    """What one estimate may be off by, in its own unit.

    Attributes
    ----------
    standard_error : float
        Of the value, from the spread between independent paths.
    step_bias, memory_bias, transient : float
        Bounds on what the step, the memory's approximation and the start leave.
    """

    standard_error: float
    step_bias: float
    memory_bias: float
    transient: float

    @property
    def total(self) -> float:
        """Half-width of the total interval: 95 % of the sampling error plus the three bounds."""
        return NORMAL * self.standard_error + self.step_bias + self.memory_bias + self.transient


@dataclass(frozen=True, eq=False)
class Reached:
    """Outcome of `reach`.

    Attributes
    ----------
    settings : Settings
        Of the coarse level; ``paths`` counts the coarse level and both members of the pairs.
    adapted : Adapted
    values : dict
        Every estimate, extrapolated to half the coarse step, with the energy balance as its control.
    errors : dict
        Their standard errors.
    budgets : dict
        A `Budget` for each of CONTROLLED.
    made : Tables
        Of the coarse level.
    rows : ndarray
        Of the coarse level.
    pairs : int
        Number of pairs of paths.
    shortfall : str
        Empty, or one sentence that says what could not be reached and why.
    """

    settings: Settings
    adapted: Adapted
    values: dict[str, float]
    errors: dict[str, float]
    budgets: dict[str, Budget]
    made: Tables
    rows: Floats
    pairs: int
    shortfall: str


class _Level:
    """Paths of one step size, in one stream, extended as needed."""

    def __init__(self, oscillator: Oscillator, settings: Settings, stream: int, halved: bool) -> None:
        self.oscillator, self.settings, self.stream, self.halved = oscillator, settings, stream, halved
        self.made = tables(oscillator, settings)
        self.rows: list[Floats] = []

    @property
    def paths(self) -> int:
        return sum(len(rows) for rows in self.rows)

    def extend(self, paths: int, alive: Progress | None = None) -> None:
        more = -(-(paths - self.paths) // LANES) * LANES
        if more > 0:
            settings = replace(self.settings, paths=more)
            found = advance(
                self.oscillator,
                settings,
                self.made,
                stream=self.stream,
                skipped=self.paths,
                halved=self.halved,
                progress=alive,
            )
            self.rows.append(found.rows)

    def samples(self) -> dict[str, Floats]:
        """What each path contributes to each estimate."""
        found = linearised(self.oscillator, self.settings, self.made, np.concatenate(self.rows))
        return {name: samples for name, (_, samples) in found.items()}


@dataclass(frozen=True, eq=False)
class _Levels:
    coarse: _Level
    pair_coarse: _Level
    pair_fine: _Level

    @property
    def path_steps(self) -> float:
        levels = (self.coarse, self.pair_coarse, self.pair_fine)
        return sum(float(level.paths) * level.settings.steps for level in levels)


def reach(
    oscillator: Oscillator,
    rtol: float,
    *,
    quantities: Sequence[str] = ("amplitude_mean_square",),
    seed: int = 1,
    threads: int | None = None,
    most_path_steps: float = MOST_PATH_STEPS,
    progress: Progress | None = None,
) -> Reached:
    """Estimate quantities so that the total error of each is below ``rtol`` of its value.

    Parameters
    ----------
    oscillator : Oscillator
        With a stationary state.
    rtol : float
        In [1e-4, 0.5].
    quantities : sequence of str
        Names from CONTROLLED.
    seed, threads
        As in `springpot.simulate`.
    most_path_steps : float
        Work after which the run ends with a shortfall.
    progress : callable
        Called with an estimate of the fraction done, after every block of paths.

    Returns
    -------
    Reached

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong or there is no stationary state.
    """
    rtol = finite_number(rtol, "rtol", low=1e-4, high=0.5, hint="It is the relative error asked for.")
    wanted = checked_quantities(oscillator, quantities)
    fastest = fastest_rate(oscillator)
    base = resolve(oscillator, seed=seed, threads=threads, start="stationary")
    adapted = adapt(oscillator, base, paths=PILOT_PATHS)
    base = replace(base, initial_position=adapted.position)
    step = max(min(COARSEST_STEP / fastest, 4.0 * even_step(oscillator)), FINEST_STEP / fastest)
    levels = _levels(oscillator, base, step, rtol)
    spent = 0.0
    targets = (FIRST_PATHS, FIRST_PATHS // 2)
    done = 0.0

    def alive(_: float) -> None:  # called block by block, so that whoever asks can end it by raising
        if progress is not None:
            progress(done)

    while True:
        levels.coarse.extend(targets[0], alive)
        levels.pair_coarse.extend(targets[1], alive)
        levels.pair_fine.extend(targets[1], alive)
        samples = _with_slow_impacts(oscillator, _samples(levels))
        values, errors, budgets = _combine(oscillator, levels, adapted, samples)
        worst = max(wanted, key=lambda name: budgets[name].total / abs(values[name]))
        reached = budgets[worst].total / abs(values[worst])
        done = max(done, min(1.0, (rtol / reached) ** 2))
        alive(done)
        if reached <= rtol:
            shortfall = ""
            break
        difference = samples[worst].difference
        if abs(difference.mean()) > SURE * standard_error(difference) and budgets[worst].step_bias > 0.5 * rtol * abs(
            values[worst]
        ):
            if step * fastest <= FINEST_STEP:
                shortfall = _sentence(worst, reached, rtol, f"its bias at a step of {step:.2g} s is still too large")
                break
            spent += levels.path_steps
            step *= 0.5
            levels = _levels(oscillator, base, step, rtol)
            targets = (FIRST_PATHS, FIRST_PATHS // 2)
            continue
        if budgets[worst].memory_bias + budgets[worst].transient > 0.9 * rtol * abs(values[worst]):
            shortfall = _sentence(worst, reached, rtol, "what its start and its memory leave does not average out")
            break
        targets = _targets(samples, wanted, values, budgets, rtol)
        more = targets[0] - levels.coarse.paths + 3 * (targets[1] - levels.pair_coarse.paths)
        if spent + levels.path_steps + more * levels.coarse.settings.steps > most_path_steps:
            shortfall = _sentence(worst, reached, rtol, f"it would take more than {most_path_steps:.0e} path-steps")
            break
    return Reached(
        settings=replace(levels.coarse.settings, paths=levels.coarse.paths + 2 * levels.pair_coarse.paths),
        adapted=adapted,
        values=values,
        errors=errors,
        budgets=budgets,
        made=levels.coarse.made,
        rows=np.concatenate(levels.coarse.rows),
        pairs=levels.pair_coarse.paths,
        shortfall=shortfall,
    )


def checked_quantities(oscillator: Oscillator, quantities: Sequence[str]) -> tuple[str, ...]:
    """The names of quantities that can be controlled for this oscillator, or a sentence that says which could be."""
    names = (quantities,) if isinstance(quantities, str) else tuple(quantities)
    allowed = tuple(
        name
        for name in CONTROLLED
        if (impacts_are_countable(oscillator) or not name.startswith("impact"))
        and (oscillator.barrier is not None or name != "x_mean")
    )
    if not names or not set(names) <= set(allowed):
        given = ", ".join(map(str, names)) or "nothing"
        wrong = next((str(name) for name in names if name not in allowed), "")
        hint = meant(wrong, allowed) or "."
        raise ValueError(f"quantities must be among {', '.join(allowed)}, not {given}{hint}")
    return names


def _levels(oscillator: Oscillator, base: Settings, step: float, rtol: float) -> _Levels:
    """A window of ten relaxation times that begins when the start is forgotten to a thirtieth of ``rtol``."""
    relaxation = max(relaxation_time(oscillator), 2.0 / oscillator.natural_frequency)
    begin = relaxation * math.log(max(3.0 / rtol, FORGOTTEN))
    begin, length = (step * math.ceil(time / step) for time in (begin, 10.0 * relaxation))
    coarse = replace(base, step=step, duration=begin + length, window=(begin, begin + length))
    fine = replace(coarse, step=0.5 * step)
    return _Levels(
        _Level(oscillator, coarse, 0, False), _Level(oscillator, coarse, 3, True), _Level(oscillator, fine, 3, False)
    )


@dataclass(frozen=True, eq=False)
class _Samples:
    """Of one estimate: what paths of the coarse level contribute, and pairs to the difference fine less coarse."""

    many: Floats
    difference: Floats


def _samples(levels: _Levels) -> dict[str, _Samples]:
    """The samples of every estimate, with what the energy balance explains of their spread taken out."""
    many, coarse, fine = (level.samples() for level in (levels.coarse, levels.pair_coarse, levels.pair_fine))
    control = "energy_residual"
    controls = np.stack([coarse[control], fine[control]], axis=1)
    found = {
        name: _Samples(controlled(many[name], many[control][:, None]), controlled(fine[name] - coarse[name], controls))
        for name in many
    }
    return found | {control: _Samples(many[control], fine[control] - coarse[control])}


def _with_slow_impacts(oscillator: Oscillator, samples: dict[str, _Samples]) -> dict[str, _Samples]:
    """Samples in which the differences of impact rate and speeds reach to step 0 behind a lossy wall.

    The rate lacks a share that goes like a known power of the step (see `springpot.simulation.scaled`), so a difference
    of two steps says the whole of it.  What the missing impacts hand over is next to nothing, so mean speeds are too
    high by the same share.
    """
    if not oscillator.restitution < 1.0 or not impacts_are_countable(oscillator):
        return samples
    beyond = 1.0 / (2.0 ** slow_impact_order(oscillator.restitution) - 1.0)
    rate = samples["impact_rate"]
    fine = float(rate.many.mean() + rate.difference.mean())
    there = fine + beyond * float(rate.difference.mean())
    share = fine / there
    found = samples | {"impact_rate": _Samples(rate.many, (1.0 + beyond) * rate.difference)}
    for name in ("impact_speed_mean", "impact_speed_mean_square"):
        speed = samples[name]
        level = float(speed.many.mean() + speed.difference.mean())
        drawn = beyond * level * share / there * (rate.difference - rate.difference.mean())
        found[name] = _Samples(speed.many, share * speed.difference + (share - 1.0) * speed.many.mean() - drawn)
    return found


def _combine(
    oscillator: Oscillator, levels: _Levels, adapted: Adapted, samples: dict[str, _Samples]
) -> tuple[dict[str, float], dict[str, float], dict[str, Budget]]:
    """Values, standard errors and budgets of all quantities."""
    values, errors, budgets = {}, {}, {}
    settings = levels.coarse.settings
    memory = 3.0 * settings.memory_tolerance + (SINGLE_PRECISION if settings.precision == "float32" else 0.0)
    energy = _left_of_the_energy(oscillator, settings)
    for name, found in samples.items():
        values[name] = float(found.many.mean() + found.difference.mean())
        errors[name] = math.hypot(standard_error(found.many), standard_error(found.difference))
    owed = owed_to_the_start(oscillator, settings, adapted, values)
    for name in CONTROLLED:
        difference = samples[name].difference
        bias = abs(float(difference.mean())) + standard_error(difference)
        budgets[name] = Budget(
            standard_error=errors[name],
            step_bias=bias * _left_of_the_difference(oscillator, name, levels.pair_fine.settings.step),
            memory_bias=memory * abs(values[name]),
            transient=energy * abs(values[name]) + NORMAL * owed[name],
        )
    return values, errors, budgets


def _left_of_the_difference(oscillator: Oscillator, name: str, step: float) -> float:
    """Bound on the bias of the fine step over the difference: all of it at order 1, or what extrapolation leaves.

    Where slow impacts crowd, the known power was found to describe what is missing within a twentieth; behind a
    preload only for short steps, see `even_step`.
    """
    if not (oscillator.restitution < 1.0 and name.startswith("impact")):
        return 1.0
    return max(EXTRAPOLATED, 0.3 * (step / even_step(oscillator)) ** 2)


def _left_of_the_energy(oscillator: Oscillator, settings: Settings) -> float:
    """Share of the energy's transient in the average over the window."""
    relaxation = relaxation_time(oscillator)
    begin, end = settings.window
    return relaxation / (end - begin) * math.exp(-begin / relaxation)


def _targets(
    samples: dict[str, _Samples],
    wanted: Sequence[str],
    values: dict[str, float],
    budgets: dict[str, Budget],
    rtol: float,
) -> tuple[int, int]:
    """Paths of the coarse level and pairs that should do: the cheapest split for the standard error still allowed.

    At least a fifth more than there is, and at most eight times as many, for the variances are estimates themselves.
    """
    paths, pairs = samples[wanted[0]].many.size, samples[wanted[0]].difference.size
    best = [int(1.2 * paths), int(1.2 * pairs)]
    for name in wanted:
        budget, found = budgets[name], samples[name]
        difference, its_error = abs(float(found.difference.mean())), standard_error(found.difference)
        weight = budget.step_bias / (difference + its_error)  # of the difference in the budget
        free = rtol * abs(values[name]) - budget.memory_bias - budget.transient
        if free <= 0.0:
            continue
        # what is surely bias counts, but no more than leaves room for more paths to tell
        free = max(0.3 * free, free - weight * max(difference - 2.0 * its_error, 0.0))
        goal = free / (NORMAL + 1.6 * weight)
        variances = found.many.var(), found.difference.var()
        spread = math.sqrt(variances[0]) + math.sqrt(3.0 * variances[1])
        needed = (spread * math.sqrt(variances[0]) / goal**2, spread * math.sqrt(variances[1] / 3.0) / goal**2)
        best = [max(b, int(n) + 1) for b, n in zip(best, needed, strict=True)]
    return min(best[0], 8 * paths), min(best[1], 8 * pairs)


def _sentence(name: str, reached: float, rtol: float, why: str) -> str:
    return f"{name} is known to {100.0 * reached:.2g} %, not to the {100.0 * rtol:.2g} % asked for: {why}."
