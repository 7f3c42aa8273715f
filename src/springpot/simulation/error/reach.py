"""Runs to a tolerance (``rtol``): total errors are estimated and reduced until they are small enough.

The start is stationary.  Pairs of paths at a step 2 h and at h with the same noise measure what the step does: with a
scheme of order p their mean difference D leaves the bias D 2^(-n p) / (2^p - 1) at the step h / 2^n.  The values come
from paths at such a finer step, so that the noise of D counts for a small part only.  The order is known within a
range; the middle of the range of the bias is added to the value, and its half is the bound.

Multilevel Monte Carlo (Giles, Acta Numerica 24, 2015) would sum differences over the levels instead.  That does not pay
here: impacts soon separate two paths with the same noise, so that a difference has a third of the variance or more.

The balances of energy, momentum and virial are control variates (`springpot.simulation.estimate.controls`).  Paths and
pairs are added until the total errors are below the tolerance; `springpot.simulation.error.decision` chooses their
numbers and the step.  With a lossy wall the impact rate is that of `springpot.simulation.estimate.slow_impacts`,
which adds the slow impacts that a step cannot resolve.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.machine.arguments import MOST_LETTERS, finite_number, items_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import few, meant, per_cent, shown
from springpot.machine.progress import COMPILATION, Clock, Estimate, FractionDone, OutOfTimeError, in_words
from springpot.problem.catalogue import is_controlled, possible_results
from springpot.problem.outputs import output_squares
from springpot.problem.system import System
from springpot.simulation.error.budget import Budget, Estimates, combine
from springpot.simulation.error.decision import MOST_FINER, Known, Move, Standing, decide
from springpot.simulation.error.levels import (
    FEWEST_PAIRS,
    Levels,
    first_pairs,
    first_step,
    level_plan,
    levels_of,
)
from springpot.simulation.estimate.samples import watched
from springpot.simulation.estimate.settled import Change, change_of_start
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.lowering.compose import has_damping
from springpot.simulation.paths.simulation import Progress, Simulation
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import Plan, check_motion
from springpot.simulation.plan.settings import Settings, checked_seed, checked_threads

FINEST_STEP = 1e-3  # in units of the shortest time scale
PILOT_PATHS = (2048, 262_144)
PILOTS_DO, KEPT_PILOTS_DO = 2e-3, 2e-2  # smallest rtol for which the fewest do; where the error of x(0) does not fade
MOST_PATH_STEPS = 3e11
LATEST = 32.0  # times the time that was planned, after which a window may begin at most


@dataclass(frozen=True, eq=False)
class Reached:
    """Result of `reach`.

    Attributes
    ----------
    wanted : tuple of str
        The quantities that were to be known.
    settings : Settings
        Of the paths that give the values; ``paths`` counts these and both members of the pairs.
    values, errors, budgets : dict
        As in `springpot.simulation.error.budget.Estimates`.
    simulation : Simulation
    rows : ndarray
        Of the paths that give the values.
    pairs : int
        Number of pairs of paths.
    shortfall : str
        Empty, or one sentence: what could not be reached, and why.
    reason : str
        What took the time.
    path_steps : float
        Steps of all paths in whole rounds.  The sizes of the rounds depend on elapsed time only with ``max_time``,
        which may make the first round smaller, and ends the run.
    change : Change or None
        What is not stationary in spite of a longer and later window; there are then no budgets.
    """

    wanted: tuple[str, ...]
    settings: Settings
    values: dict[str, float]
    errors: dict[str, float]
    budgets: dict[str, Budget]
    simulation: Simulation
    rows: Floats
    pairs: int
    shortfall: str
    reason: str
    path_steps: float
    change: Change | None


@dataclass(frozen=True)
class _Request:
    """The arguments of `reach`, checked."""

    motion: Motion
    rtol: float
    wanted: tuple[str, ...]
    seed: int
    threads: int
    most_path_steps: float
    later: float = 1.0

    @property
    def forces(self) -> list[str]:
        """Forces and accelerations that are seen for the sake of their mean squares."""
        return [name for square, name in output_squares(self.motion.system).items() if square in self.wanted]

    def plan(self, step: float) -> Plan:
        """The plan of the coarser members of the pairs at this step, without x(0)."""
        return level_plan(
            self.motion, step, self.rtol, self.wanted, seed=self.seed, threads=self.threads, later=self.later
        )


@dataclass(frozen=True, eq=False)
class _Outcome:
    """Estimates after a round, and the next move."""

    levels: Levels
    estimates: Estimates
    known: tuple[Known, ...]  # of the controlled quantities
    move: Move

    @property
    def simulation(self) -> Simulation:
        return self.levels.best.simulation

    @property
    def off(self) -> float:
        """The largest relative total error of the controlled quantities."""
        return max(known.off for known in self.known)


class _Report:
    """Calls ``progress`` after each block, and ends the run when the time is over or ``progress`` raises."""

    def __init__(self, clock: Clock, rtol: float, progress: Progress | None) -> None:
        self.clock, self.rtol, self.progress = clock, rtol, progress
        self.latest = FractionDone(0.0)

    @property
    def time_left(self) -> str:
        """Estimated time left, in words; empty before there is an estimate."""
        return in_words(self.latest.estimate.seconds) if self.latest.estimate is not None else ""

    def block(self, _: float) -> None:
        """After a block of paths."""
        self.clock.check()
        self._pass_on()

    def say(self, fraction: float, spent: float, left: float, reason: str, aim: float, worst: str) -> None:
        """After a round: path-steps spent and left, what takes the time, and the error aimed at, of which quantity."""
        unreachable = ""
        if aim > self.rtol:
            wanted, best = per_cent(self.rtol), per_cent(aim)
            unreachable = (
                f"{wanted} cannot be reached for {worst}, by the paths so far; the run continues to the best possible, "
                f"{best if best != wanted else 'just above that'}"
            )
        self.latest = FractionDone(fraction, Estimate(spent + left, self.clock.seconds(left), reason, aim, unreachable))
        self._pass_on()

    def _pass_on(self) -> None:
        if self.progress is not None:
            self.progress(self.latest)


def reach(
    system: System,
    rtol: float,
    *,
    quantities: Sequence[str] | None = None,
    seed: int = 1,
    threads: int | None = None,
    most_path_steps: float = MOST_PATH_STEPS,
    max_time: float | None = None,
    progress: Progress | None = None,
) -> Reached:
    """Estimate quantities so that the total error of each is below ``rtol`` of its value.

    Parameters
    ----------
    system : System
        With a stationary state.
    rtol : float
        In [1e-4, 0.5].
    quantities : sequence of str
        Names of `controllable`; the mean square amplitude if left out, or v^2 without a linear spring, and of several
        masses all mean square displacements and velocities.
    seed, threads
        As in `springpot.simulate`.
    most_path_steps : float
        Work after which the run ends with a shortfall; the first round is always run.
    max_time : float
        Seconds after which the run ends with the result of the whole rounds so far.
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
    motion = motion_of(system)
    wanted = checked_quantities(motion, motion.usual_quantities if quantities is None else quantities)
    if max_time is not None:
        max_time = finite_number(max_time, "max_time", low=0.0, open_low=True, hint="It is in seconds.")
    check_motion(motion, "rtol")
    request = _Request(motion, rtol, wanted, checked_seed(seed), checked_threads(threads), most_path_steps)
    report = _Report(Clock(max_time), rtol, progress)
    shortest = FINEST_STEP / motion.scales.fastest_rate
    step = max(first_step(motion, rtol, wanted), shortest)
    spent, reason = 0.0, ""
    halved, stale, best = False, False, None
    try:
        report.block(0.0)
        request, plan, differs = _with_start(request, step, report)
        levels = levels_of(plan, request.forces)
        first = levels.pair_coarse
        report.clock.measure(*first.simulation.timed(stream=first.stream, halved=True, progress=report.block))
        pairs = first_pairs(levels.pair_coarse.simulation, rtol)
        if report.clock.seconds(levels.work(0, pairs)) > 0.25 * report.clock.left:
            pairs = FEWEST_PAIRS
        paths = 0
        reason = _length_reason(levels.pair_coarse.simulation) or "the first round is small"
        report.say(0.0, 0.0, levels.work(paths, pairs), reason, rtol, wanted[0])
        while True:
            before = levels.path_steps
            patience, begun = 3.0 if best is None else 1.0, time.perf_counter()
            if report.clock.seconds(levels.work(paths, pairs)) > patience * report.clock.left:
                raise OutOfTimeError
            levels = levels.extended(paths, pairs, report.block)
            report.clock.measure(levels.path_steps - before, time.perf_counter() - begun)
            spent += levels.path_steps - before
            outcome = _outcome(request, levels, spent, shortest)
            move = outcome.move
            same_step = best is not None and best.simulation is outcome.simulation
            if best is None or same_step or move.kind == "done" or outcome.off <= best.off or stale:
                best, stale = outcome, False
            reason = _reason(outcome, halved)
            report.say(min(1.0, (rtol / best.off) ** 2), spent, move.path_steps, reason, move.aim, move.worst)
            if move.kind == "more":
                levels, paths, pairs = levels.with_step(move.finer), move.paths, move.pairs
                continue
            if move.kind == "halve":
                step, halved = 0.5 * step, True
            elif move.kind == "stop" or request.later >= LATEST or not levels.best.unsettled(rtol, wanted):
                break
            else:  # done, but in a window that was too early
                request, stale = replace(request, later=2.0 * request.later), True
            plan = replace(request.plan(step), adapted=plan.adapted).but(
                initial_position=plan.settings.initial_position
            )
            anew = levels_of(plan, request.forces)
            paths, pairs = 0, first_pairs(anew.pair_coarse.simulation, rtol)
            if spent + anew.work(paths, pairs) > most_path_steps:
                outcome = replace(outcome, move=replace(move, kind="stop"))
                break
            levels = anew
        why = _why_no_better(request, outcome, spent)
    except OutOfTimeError:
        if best is None:
            needed = "the pilot runs for the stationary start were not finished"
            if report.time_left:
                needed = f"the smallest run takes about {report.time_left}"
            raise TimeoutError(
                f"max_time of {report.clock.limit:g} s is too short for any result: {needed}. {COMPILATION}"
            ) from None
        why = f"max_time of {report.clock.limit:g} s is over (about {report.time_left} more would be needed)"
    paths, pairs = best.levels.many.paths, best.levels.pair_coarse.paths
    change = differs or best.levels.best.unsettled(rtol, wanted)
    shortfall = ""
    if best.off > rtol and not change:
        reached = f"known to {per_cent(best.off)}" if math.isfinite(best.off) else "not known at all"
        worst = max(best.known, key=lambda known: known.off)
        shortfall = f"{worst.name} is {reached}, not to the {per_cent(rtol)} asked for: {why}."
    return Reached(
        wanted=wanted,
        settings=replace(best.simulation.settings, paths=paths + 2 * pairs),
        values=best.estimates.values,
        errors=best.estimates.errors,
        budgets={} if change else best.estimates.budgets,
        simulation=best.simulation,
        rows=best.levels.best.rows,
        pairs=pairs,
        shortfall=shortfall,
        reason=reason,
        path_steps=spent,
        change=change,
    )


def checked_quantities(motion: Motion, quantities: Sequence[str]) -> tuple[str, ...]:
    """The names of the quantities as a tuple; a ValueError if one cannot be controlled for this motion.

    Those of impacts that cannot be counted are NaN, and so left out; where none is left, the usual ones are controlled.
    """
    must = "quantities must be names of quantities"
    named = (quantities,) if isinstance(quantities, str) else items_of(quantities, must)
    if not all(isinstance(name, str) for name in named):
        raise TypeError(f"{must}, not {shown(quantities)}.")
    names = tuple(name for name in named if not motion.uncounted_because(name))
    names = names or (motion.usual_quantities if named else ())
    allowed = controllable(motion)
    if not names or not set(names) <= set(allowed):
        given = few(name if len(name) < MOST_LETTERS else shown(name) for name in names) or "nothing"
        wrong = next((name for name in names if name not in allowed), "")
        hint = meant(wrong, allowed) or "."
        if wrong in motion.zeros:
            hint = ": it is 0."
        elif (output := motion.outputs.get(wrong.removesuffix("_square").removesuffix("_mean"))) is not None:
            hint = (
                f": {output.reason}." if output.reason else ": of forces and accelerations rtol controls mean squares."
            )
        raise ValueError(f"quantities must be among {few(allowed)}, not {given}{hint}")
    return names


def controllable(motion: Motion) -> tuple[str, ...]:
    """The quantities whose errors can be controlled.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring, WhiteNoise
    >>> controllable(motion_of(System(Spring(1.0), Dashpot(0.1), WhiteNoise(1.0))))[:3]
    ('x_mean_square', 'v_mean_square', 'amplitude_mean_square')
    """
    moments = (
        name
        for name in filter(is_controlled, possible_results(motion.system))
        if not motion.uncounted_because(name)
        and name not in motion.zeros
        and (name != "amplitude_mean_square" or motion.system.stiffness > 0.0)
        and (not name.startswith("damping_") or has_damping(motion.system))
    )
    return (*moments, *output_squares(motion.system))


def _pilots(motion: Motion, rtol: float) -> int:
    """Paths of the pilot runs: more for a small tolerance, fewer if each is much longer than the energy time."""
    (fewest, most), scales = PILOT_PATHS, motion.scales
    longest = max(scales.energy_time, 5.0 / scales.frequency)
    enough = KEPT_PILOTS_DO if motion.left_of_start(1.0, 0.0) is None else PILOTS_DO
    wanted = fewest * max(1.0, (enough / rtol) ** 2) * longest / motion.pilot_time
    return int(min(max(wanted, 256.0), most))


def _with_start(request: _Request, step: float, report: _Report) -> tuple[_Request, Plan, Change | None]:
    """The plan with its start.

    Where masses wait for impacts, the window begins so late that it makes no difference whether they start on their
    way or at rest; what still differs then is the last of the results.
    """
    pilots = _pilots(request.motion, request.rtol)
    while True:
        plan, differs = adapt(request.plan(step), paths=pilots, progress=report.block), None
        if request.motion.waiting_time("rest") > 0.0:
            differs = change_of_start(plan, request.rtol / 3.0, report.block)
        if differs is None or request.later >= LATEST:
            return request, plan, differs
        request = replace(request, later=2.0 * request.later)


def _outcome(request: _Request, levels: Levels, spent: float, shortest: float) -> _Outcome:
    """Estimates from the levels, and the next move."""
    estimates = combine(levels)
    known = tuple(estimates.known[name] for name in request.wanted)
    coarse, fine = levels.pair_coarse.simulation.settings, levels.pair_fine.simulation.settings
    halvings = math.floor(math.log2(fine.step / shortest)) if fine.step > shortest else 0
    low, high = fine.window_steps
    impacts = watched(levels.pair_fine.simulation, levels.pair_fine.rows).impacts
    counted = impacts.get("", sum(impacts.values(), np.zeros(1)))
    standing = Standing(
        rtol=request.rtol,
        known=known,
        paths=levels.many.paths,
        pairs=levels.pair_coarse.paths,
        finer=levels.finer,
        steps=coarse.steps,
        impacts=float(counted.mean()) * fine.steps / (high - low),
        spent=spent,
        most_path_steps=request.most_path_steps,
        most_finer=min(halvings, MOST_FINER),
        step_can_be_halved=coarse.step > shortest,
    )
    return _Outcome(levels, estimates, known, decide(standing))


def _length_reason(simulation: Simulation) -> str:
    """Why each path is long, if it is."""
    settings, (begin, end) = simulation.settings, simulation.settings.window
    if settings.steps < 20_000:
        return ""
    lasting = f"each path runs for {end:.2g} s, {settings.steps:.1e} steps"
    if begin > 8.0 * simulation.motion.scales.forgetting_time:
        return f"the springpot is strong, so the displacement changes slowly: {lasting}"
    return f"the damping is light: {lasting}"


def _reason(outcome: _Outcome, halved: bool) -> str:
    """What takes the time."""
    simulation, move = outcome.simulation, outcome.move
    if halved or move.kind == "halve":
        slow = any(move.worst.startswith(f"{before}impact") for before in simulation.motion.completed)
        what = "slow impacts behind the lossy wall need" if slow else f"the step's bias of {move.worst} needs"
        return f"{what} a step below {simulation.settings.step:.2g} s"
    return _length_reason(simulation) or f"the sampling error of {move.worst} falls like 1 / sqrt(paths)"


def _why_no_better(request: _Request, outcome: _Outcome, spent: float) -> str:
    """Why the run ends before the tolerance is reached."""
    known = outcome.estimates.known[outcome.move.worst]
    if outcome.move.kind == "stop":
        if math.isinf(outcome.off):
            return f"in {spent:.1e} path-steps there were too few events to estimate it"
        return f"it would take more than {request.most_path_steps:.1e} path-steps"
    if known.fixed > 0.5 * request.rtol * abs(known.value):
        return "more paths do not reduce the bias from start and memory"
    return f"its bias at a step of {outcome.simulation.settings.step:.2g} s is still too large"
