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
the way; `springpot.simulation.decision` decides which.  Behind a lossy wall the impact rate is that of
`springpot.simulation.completed_rate`, in which the slow impacts that a step cannot resolve are put back.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.faults import meant
from springpot.oscillator import Oscillator, finite_number
from springpot.simulation.adapted import Adapted, adapt, owed_to_the_start
from springpot.simulation.completed_rate import are_crowded, completed_rate, counts_of_fast_impacts
from springpot.simulation.compose import Floats, Tables, tables
from springpot.simulation.cost import Clock, Estimate, FractionDone, OutOfTime, in_words, per_cent
from springpot.simulation.decision import NORMAL, Known, Move, Standing, decide
from springpot.simulation.ensemble import Progress, advance
from springpot.simulation.forgetting import forgetting_time, shares_missing
from springpot.simulation.lanes import LANES
from springpot.simulation.scales import creep_time, energy_time, fastest_rate
from springpot.simulation.settings import Settings, check_stationary, resolve
from springpot.simulation.slow_impacts import even_step, impacts_are_countable, slow_impact_order
from springpot.simulation.statistics import controlled, linearised, standard_error
from springpot.theory import exact
from springpot.theory.result import MOMENTS

__all__ = ["CONTROLLED", "Budget", "Reached", "checked_quantities", "reach"]

CONTROLLED = MOMENTS
"""Quantities that have a budget."""

COARSEST_STEP = 0.1  # first step tried, in units of the shortest time scale
LONGER_STEP, LONG_MEMORY = 3.0, 300.0  # times longer, for a loose tolerance, where the energy is remembered so long
FINEST_STEP = 1e-3
WITH_MEMORY = 1.5  # bound on the fine step's bias over the difference, with a wall and an order below 1
RESTORED = 0.03  # bound on the error of what is put back of slow impacts, over what is put back
UNCERTAIN_ORDER = 0.4  # what the bias left behind a lossy wall has, at least, beyond the order of the plain rate
FORGET = 20.0  # the start, at least, before the window begins
SLOWLY = 0.2  # share of the tolerance that slow displacements may lack when the window begins
RELAXATIONS = 10.0  # in the window, at least
FIRST_RELAXATIONS = 2.0  # rtol^2 of the relaxations in the first round's windows
FIRST_PATHS, FEWEST_PATHS = (512, 2048), 128  # in the first round; the fewest where each is dear
FIRST_PATH_STEPS = 1e9
PILOT_PATHS = (2048, 262_144)
PILOTS_DO = 2e-3  # rtol down to which the fewest pilots do
PRECISE = 1e-3  # rtol below which the memory is kept in double precision
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
    estimate : Estimate
        What was expected when the first round was over.
    path_steps : float
        What was done in whole rounds.  How many paths a round has depends on the clock only where there is a
        ``max_time``: it may make the first round smaller, and ends the run.
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
    estimate: Estimate
    path_steps: float


class _Level:
    """Paths of one step size, in one stream, extended as needed."""

    def __init__(self, oscillator: Oscillator, settings: Settings, stream: int, halved: bool) -> None:
        self.oscillator, self.settings, self.stream, self.halved = oscillator, settings, stream, halved
        self.made = tables(oscillator, settings)
        crowded = are_crowded(oscillator)
        self.observers = (counts_of_fast_impacts(oscillator, settings, self.made),) if crowded else ()
        self.rows: list[Floats] = []
        self.counted: list[Floats] = []

    @property
    def paths(self) -> int:
        return sum(len(rows) for rows in self.rows)

    def extend(self, paths: int, alive: Progress | None = None) -> None:
        more = -(-(paths - self.paths) // LANES) * LANES
        if more > 0:
            found = advance(
                self.oscillator,
                replace(self.settings, paths=more),
                self.made,
                stream=self.stream,
                skipped=self.paths,
                halved=self.halved,
                observers=self.observers,
                progress=alive,
            )
            self.rows.append(found.rows)
            self.counted.extend(found.observed)

    def samples(self) -> dict[str, Floats]:
        """What each path contributes to each estimate."""
        rows = np.concatenate(self.rows)
        found = {
            name: samples for name, (_, samples) in linearised(self.oscillator, self.settings, self.made, rows).items()
        }
        if not self.observers:
            return found
        low, high = self.settings.window_steps
        completed = completed_rate(self.oscillator, np.concatenate(self.counted), (high - low) * self.settings.step)
        rates, rate = found["impact_rate"], float(completed.mean())
        if not rate > 0.0:
            return found | {"impact_rate": completed, "plain_rate": rates}
        # what the impacts put back hand over is next to nothing
        for name in ("impact_speed_mean", "impact_speed_mean_square"):
            plain = float(found[name].mean())
            flux = plain * rates + float(rates.mean()) * (found[name] - plain)  # its mean is rate times speed
            speed = float(flux.mean()) / rate
            found[name] = speed + (flux - speed * completed) / rate
        return found | {"impact_rate": completed, "plain_rate": rates}


@dataclass(frozen=True, eq=False)
class _Levels:
    coarse: _Level
    pair_coarse: _Level
    pair_fine: _Level

    @property
    def path_steps(self) -> float:
        levels = (self.coarse, self.pair_coarse, self.pair_fine)
        return sum(float(level.paths) * level.settings.steps for level in levels)

    def extend(self, paths: int, pairs: int, alive: Progress | None) -> None:
        self.coarse.extend(paths, alive)
        self.pair_coarse.extend(pairs, alive)
        self.pair_fine.extend(pairs, alive)


@dataclass(frozen=True, eq=False)
class _Outcome:
    """What is known after a round."""

    settings: Settings
    values: dict[str, float]
    errors: dict[str, float]
    budgets: dict[str, Budget]
    known: tuple[Known, ...]
    made: Tables
    rows: Floats
    paths: int
    pairs: int

    @property
    def off(self) -> float:
        """The largest relative total error of what was asked for."""
        return max(known.off for known in self.known)


def reach(
    oscillator: Oscillator,
    rtol: float,
    *,
    quantities: Sequence[str] = ("amplitude_mean_square",),
    seed: int = 1,
    threads: int | None = None,
    most_path_steps: float = MOST_PATH_STEPS,
    max_time: float | None = None,
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
        Work after which the run ends with a shortfall; the first round is made whatever it takes.
    max_time : float
        Seconds after which the run ends with what the whole rounds so far have reached.
    progress : callable
        Called with an estimate of the fraction done, a `FractionDone`, after every block of paths.

    Returns
    -------
    Reached

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong or there is no stationary state.
    TimeoutError
        If ``max_time`` is too short for the smallest run that gives an error.
    """
    rtol = finite_number(rtol, "rtol", low=1e-4, high=0.5, hint="It is the relative error asked for.")
    wanted = checked_quantities(oscillator, quantities)
    if max_time is not None:
        max_time = finite_number(max_time, "max_time", low=0.0, open_low=True, hint="It is in seconds.")
    check_stationary(oscillator, "rtol")
    base = resolve(oscillator, seed=seed, threads=threads, start="stationary")
    if rtol < PRECISE:
        base = replace(base, memory_tolerance=1e-8)
    return _Search(oscillator, rtol, wanted, base, most_path_steps, Clock(max_time), progress).run()


class _Search:
    """The rounds of one run to a tolerance."""

    def __init__(
        self,
        oscillator: Oscillator,
        rtol: float,
        wanted: tuple[str, ...],
        base: Settings,
        most_path_steps: float,
        clock: Clock,
        progress: Progress | None,
    ) -> None:
        self.oscillator, self.rtol, self.wanted, self.base = oscillator, rtol, wanted, base
        self.most_path_steps, self.clock, self.progress = most_path_steps, clock, progress
        self.targets = (0, 0)
        self.spent = 0.0  # path-steps of whole rounds
        self.halvings = 0
        self.estimate: Estimate | None = None
        self.best: _Outcome | None = None

    def run(self) -> Reached:
        shortest = FINEST_STEP / fastest_rate(self.oscillator)
        step = max(_first_step(self.oscillator, self.rtol), shortest)
        try:
            self.alive(0.0)
            adapted = adapt(self.oscillator, self.base, paths=self._pilots(), progress=self.alive)
            self.base = replace(self.base, initial_position=adapted.position)
            levels = _levels(self.oscillator, self.base, step, self.rtol, self.wanted)
            self._rehearse(levels)
            self._expect(levels)
            while True:
                outcome = self._round(levels, adapted)
                move = self._decide(outcome, step > shortest)
                same_step = self.best is not None and outcome.settings == self.best.settings
                if self.best is None or same_step or move.kind == "done" or outcome.off <= self.best.off:
                    self.best = outcome
                if move.kind in ("done", "stop"):
                    break
                if move.kind == "halve":
                    finer = _levels(self.oscillator, self.base, 0.5 * step, self.rtol, self.wanted)
                    targets = _first_targets(self.oscillator, finer.coarse.settings, self.rtol)
                    if self.spent + _work(finer, targets) > self.most_path_steps:
                        move = replace(move, kind="stop")
                        break
                    self.halvings += 1
                    step, levels, self.targets = 0.5 * step, finer, targets
                else:
                    self.targets = move.paths, move.pairs
            if move.kind == "stop" and math.isinf(outcome.off):
                why = f"in {self.spent:.1e} path-steps there was not enough to see"
            elif move.kind == "stop":
                why = f"it would take more than {self.most_path_steps:.1e} path-steps"
            else:
                why = self._why_no_better(outcome, move.worst)
        except OutOfTime:
            if self.best is None:
                raise TimeoutError(self._too_short()) from None
            left = self.estimate.seconds if self.estimate is not None else math.nan
            more = f" (about {in_words(left)} more would be needed)" if math.isfinite(left) else ""
            why = f"max_time of {self.clock.limit:g} s is over{more}"
        return self._reached(self.best, adapted, why)

    def alive(self, _: float) -> None:
        """Called block by block, so that whoever asks, and the clock, can end the work by raising."""
        self.clock.check()
        self._tell()

    def _tell(self) -> None:
        if self.progress is not None:
            done = 0.0 if self.best is None else min(1.0, (self.rtol / self.best.off) ** 2)
            self.progress(FractionDone(done, self.estimate))

    def _pilots(self) -> int:
        """Paths of the pilot runs: more for a small tolerance, fewer where each is long beside the energy's memory."""
        fewest, most = PILOT_PATHS
        cycles = 5.0 / self.oscillator.natural_frequency
        longest = max(energy_time(self.oscillator), cycles)
        length = max(longest, min(creep_time(self.oscillator), 20.0 * cycles))
        wanted = fewest * max(1.0, (PILOTS_DO / self.rtol) ** 2) * longest / length
        return int(min(max(wanted, 256.0), most))

    def _rehearse(self, levels: _Levels) -> None:
        """Measure how many path-steps a second there are, by a few that are thrown away."""
        settings = levels.coarse.settings
        steps = min(settings.steps, 8192)
        length = steps * settings.step
        few = replace(settings, paths=LANES * settings.threads, duration=length, window=(0.0, length))
        made = tables(self.oscillator, few)
        for _ in range(2):  # the first may have to load or compile the kernel
            begun = time.perf_counter()
            advance(self.oscillator, few, made, stream=levels.coarse.stream, progress=self.alive)
        self.clock.measure(float(few.paths * steps), time.perf_counter() - begun)

    def _expect(self, levels: _Levels) -> None:
        """What the first round will take, and the whole run at least."""
        settings = levels.coarse.settings
        self.targets = _first_targets(self.oscillator, settings, self.rtol)
        work = _work(levels, self.targets)
        if self.clock.seconds(work) > 0.25 * self.clock.left:  # little time: the smallest round first
            self.targets = FEWEST_PATHS, FEWEST_PATHS // 2
            work = _work(levels, self.targets)
        reason = _length_reason(self.oscillator, settings) or "the first round is small"
        self._say(work, work, reason, self.rtol, self.wanted[0])

    def _say(self, whole: float, left: float, reason: str, aim: float, worst: str) -> None:
        unreachable = ""
        if aim > self.rtol:
            unreachable = (
                f"{per_cent(self.rtol)} cannot be reached for {worst}; the run goes on to the best that can be "
                f"reached, {per_cent(aim)}"
            )
        self.estimate = Estimate(whole, self.clock.seconds(left), reason, aim, unreachable)
        self._tell()

    def _round(self, levels: _Levels, adapted: Adapted) -> _Outcome:
        before, begun = levels.path_steps, time.perf_counter()
        work = _work(levels, self.targets)
        if self.clock.seconds(work) > (1.0 if self.best is not None else 3.0) * self.clock.left:
            raise OutOfTime
        levels.extend(*self.targets, self.alive)
        self.spent += levels.path_steps - before
        self.clock.measure(levels.path_steps - before, time.perf_counter() - begun)
        samples = _samples(levels)
        values, errors, budgets, known = _combine(self.oscillator, levels, adapted, samples)
        return _Outcome(
            settings=levels.coarse.settings,
            values=values,
            errors=errors,
            budgets=budgets,
            known=tuple(known[name] for name in self.wanted),
            made=levels.coarse.made,
            rows=np.concatenate(levels.coarse.rows),
            paths=levels.coarse.paths,
            pairs=levels.pair_coarse.paths,
        )

    def _decide(self, outcome: _Outcome, can_be_halved: bool) -> Move:
        standing = Standing(
            rtol=self.rtol,
            known=outcome.known,
            paths=outcome.paths,
            pairs=outcome.pairs,
            steps=outcome.settings.steps,
            spent=self.spent,
            most_path_steps=self.most_path_steps,
            step_can_be_halved=can_be_halved,
        )
        move = decide(standing)
        reason = _length_reason(self.oscillator, outcome.settings)
        if self.halvings or move.kind == "halve":
            slow = are_crowded(self.oscillator) and move.worst.startswith("impact")
            what = "slow impacts behind the lossy wall need" if slow else f"the step's bias of {move.worst} needs"
            reason = f"{what} a step below {outcome.settings.step:.2g} s"
        elif not reason:
            reason = f"the sampling error of {move.worst} falls like 1 / sqrt(paths)"
        self._say(standing.spent + move.path_steps, move.path_steps, reason, move.aim, move.worst)
        return move

    def _why_no_better(self, outcome: _Outcome, worst: str) -> str:
        known = next(known for known in outcome.known if known.name == worst)
        if known.fixed > 0.5 * self.rtol * abs(known.value):
            return "more paths do not reduce the bias from start and memory"
        return f"its bias at a step of {outcome.settings.step:.2g} s is still too large"

    def _too_short(self) -> str:
        needed = ": the pilot runs for the stationary start were not over"
        if self.estimate is not None:
            needed = f": the smallest run takes about {in_words(self.estimate.seconds)}"
        return f"max_time of {self.clock.limit:g} s is too short for any result{needed}."

    def _reached(self, best: _Outcome, adapted: Adapted, why: str) -> Reached:
        shortfall = ""
        if best.off > self.rtol:
            worst = max(best.known, key=lambda known: known.off)
            reached = f"known to {per_cent(best.off)}" if math.isfinite(best.off) else "not known at all"
            shortfall = f"{worst.name} is {reached}, not to the {per_cent(self.rtol)} asked for: {why}."
        return Reached(
            settings=replace(best.settings, paths=best.paths + 2 * best.pairs),
            adapted=adapted,
            values=best.values,
            errors=best.errors,
            budgets=best.budgets,
            made=best.made,
            rows=best.rows,
            pairs=best.pairs,
            shortfall=shortfall,
            estimate=self.estimate or Estimate(self.spent, math.nan, "", self.rtol),
            path_steps=self.spent,
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


def _levels(oscillator: Oscillator, base: Settings, step: float, rtol: float, wanted: Sequence[str]) -> _Levels:
    """A window of ten relaxation times, or as long as the time before it, that begins when the start is forgotten."""
    relaxation = forgetting_time(oscillator)
    begin = max(relaxation * math.log(max(3.0 / rtol, FORGET)), _slow_time(oscillator, rtol, wanted))
    length = max(RELAXATIONS * relaxation, 0.5 * begin)
    begin, length = (step * math.ceil(time / step) for time in (begin, length))
    coarse = replace(base, step=step, duration=begin + length, window=(begin, begin + length))
    fine = replace(coarse, step=0.5 * step)
    return _Levels(
        _Level(oscillator, coarse, 0, False), _Level(oscillator, coarse, 3, True), _Level(oscillator, fine, 3, False)
    )


def _work(levels: _Levels, targets: tuple[int, int]) -> float:
    """Path-steps that are still to do for so many paths and pairs."""
    paths, pairs = targets[0] - levels.coarse.paths, targets[1] - levels.pair_coarse.paths
    return float(levels.coarse.settings.steps * (paths + 3.0 * pairs))


def _first_step(oscillator: Oscillator, rtol: float) -> float:
    """The longest step worth trying; longer where a loose tolerance meets paths that are dear."""
    fastest = fastest_rate(oscillator)
    longest = COARSEST_STEP / fastest
    if forgetting_time(oscillator) * fastest > LONG_MEMORY and not are_crowded(oscillator):
        longest *= min(max(rtol / 0.01, 1.0), LONGER_STEP)
    return min(longest, 4.0 * even_step(oscillator))


def _slow_time(oscillator: Oscillator, rtol: float, wanted: Sequence[str]) -> float:
    """When what slow displacements lack is a small part of the tolerance, in s, by the variances without a wall."""
    try:
        free = exact(replace(oscillator, barrier=None))
    except ValueError:  # no springpot: the wall alone dissipates
        return 0.0
    time, last = 1.0 / oscillator.natural_frequency, 100.0 * max(creep_time(oscillator), energy_time(oscillator))
    while time < last:
        shares = shares_missing(oscillator, time, free.x_mean_square, free.amplitude_mean_square)
        if max(shares[name] for name in wanted) <= SLOWLY * rtol:
            break
        time *= 1.1
    return time


def _first_targets(oscillator: Oscillator, settings: Settings, rtol: float) -> tuple[int, int]:
    """Paths and pairs of the first round: about what the tolerance needs, fewer where each path is dear."""
    begin, end = settings.window
    relaxations = (end - begin) / forgetting_time(oscillator)
    fewest, most = FIRST_PATHS
    few = min(max(FIRST_PATH_STEPS / (2.5 * settings.steps), FEWEST_PATHS), fewest)
    paths = int(min(max(FIRST_RELAXATIONS / rtol**2 / relaxations, few), most))
    paths = -(-paths // (2 * LANES)) * 2 * LANES
    return paths, paths // 2


def _length_reason(oscillator: Oscillator, settings: Settings) -> str:
    """Why each path is long, if it is."""
    begin, end = settings.window
    if settings.steps < 20_000:
        return ""
    lasting = f"each path runs for {end:.2g} s, {settings.steps:.1e} steps"
    if begin > 8.0 * forgetting_time(oscillator):
        return f"the springpot is strong, so slow displacements creep: {lasting}"
    return f"the damping is light: {lasting}"


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


def _combine(
    oscillator: Oscillator, levels: _Levels, adapted: Adapted, samples: dict[str, _Samples]
) -> tuple[dict[str, float], dict[str, float], dict[str, Budget], dict[str, Known]]:
    """Values, standard errors and budgets of all quantities, and what decides on the next round."""
    values, errors, budgets, known = {}, {}, {}, {}
    settings = levels.coarse.settings
    memory = 3.0 * settings.memory_tolerance + (SINGLE_PRECISION if settings.precision == "float32" else 0.0)
    energy = _left_of_the_energy(oscillator, settings)
    for name, found in samples.items():
        values[name] = float(found.many.mean() + found.difference.mean())
        errors[name] = math.hypot(standard_error(found.many), standard_error(found.difference))
    plain = values.pop("plain_rate", math.nan)
    errors.pop("plain_rate", None)
    restored = 1.0 - plain / values["impact_rate"] if math.isfinite(plain) and values["impact_rate"] > 0.0 else 0.0
    slow = shares_missing(oscillator, settings.window[0], values["x_mean_square"], values["amplitude_mean_square"])
    owed = owed_to_the_start(oscillator, settings, adapted, values)
    for name in CONTROLLED:
        many, difference = samples[name].many, samples[name].difference
        size, its_error = abs(float(difference.mean())), standard_error(difference)
        weight = _bias_weight(oscillator, name)
        other = RESTORED * abs(restored * values[name]) if name.startswith("impact") else 0.0
        budgets[name] = Budget(
            standard_error=errors[name],
            step_bias=weight * size + max(weight, 1.0) * its_error + other,
            memory_bias=memory * abs(values[name]),
            transient=(energy + slow[name]) * abs(values[name]) + NORMAL * owed[name],
        )
        known[name] = Known(
            name=name,
            value=values[name],
            total=budgets[name].total,
            variance=float(many.var()),
            difference_variance=float(difference.var()),
            difference=size,
            difference_error=its_error,
            bias_weight=weight,
            other_bias=other,
            fixed=budgets[name].memory_bias + budgets[name].transient,
        )
    return values, errors, budgets, known


def _bias_weight(oscillator: Oscillator, name: str) -> float:
    """Bound on the bias of the fine step over the difference of the two steps: 1 / (2^order - 1).

    The order is 1 at order alpha = 1 and without a wall.  A wall and a memory together were seen to leave somewhat more
    than order 1 says.  Where slow impacts have been put back, the order is that of the next term: about half an order
    more than the plain rate's.
    """
    if name.startswith("impact") and are_crowded(oscillator):
        order = min(1.0, slow_impact_order(oscillator.restitution) + UNCERTAIN_ORDER)
        return float(1.0 / (2.0**order - 1.0))
    if oscillator.barrier is not None and oscillator.springpot.order < 1.0:
        return WITH_MEMORY
    return 1.0


def _left_of_the_energy(oscillator: Oscillator, settings: Settings) -> float:
    """Share of the energy's transient in the average over the window."""
    relaxation = energy_time(oscillator)
    begin, end = settings.window
    return float(relaxation / (end - begin) * math.exp(-begin / relaxation))
