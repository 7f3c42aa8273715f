"""More paths for a run that is there already: the bits of one run of them all."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.machine.arguments import check_called, finite_number
from springpot.machine.faults import per_cent, shown
from springpot.machine.progress import Estimate, FractionDone
from springpot.problem.catalogue import results_on_request
from springpot.problem.outputs import output_squares
from springpot.simulation.error.budget import Budget, combine
from springpot.simulation.error.decision import bias_range
from springpot.simulation.error.levels import Levels, levels_of
from springpot.simulation.error.reach import checked_quantities
from springpot.simulation.estimate.samples import estimates_of, samples_of, watched
from springpot.simulation.estimate.settled import change_in_window
from springpot.simulation.estimate.step_biases import step_biases
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.monte_carlo import diagnostics_of, door
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.paths.statistics import NORMAL, standard_error
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import Plan, check_motion
from springpot.simulation.plan.settings import MOST_PATHS, checked_threads, whole_number
from springpot.simulation.result.results import KINDS, PROBABILITIES, Run, estimates_from
from springpot.simulation.result.warnings import doubts

FIRST_PAIRS = 256
HOPELESS = 0.8  # share of the allowed error that may surely be bias
FOR_CHANCE = 0.7  # share of the rest that is left to the sampling error
LEAST_GROWTH, MOST_GROWTH = 1.2, 8.0


@door
def extend(
    run: Run,
    *,
    paths: int | None = None,
    rtol: float | None = None,
    quantities: Sequence[str] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Run:
    """Add paths to a run, which may come from a file: so many, or as many as a relative error needs.

    The paths that are there are not computed again, but for the first 64, which show that this machine and this version
    of springpot give the same bits.  A stationary start stays that of the run.

    Parameters
    ----------
    run : Run
        Of `springpot.simulate`, or of `springpot.load_run` if it was saved with ``path_sums=True``.
    paths : int
        Number of paths afterwards.
    rtol : float
        Instead of ``paths``: the total relative error of ``quantities`` afterwards, in [1e-4, 0.5].  Step, window and
        start stay those of the run: what they leave is bounded, that of the step with pairs of paths at the step and
        at half of it.
    quantities : sequence of str
        With ``rtol``: the results that it controls; if left out, those of `springpot.simulate`.
    threads : int
        Those of the run if left out; the result does not depend on it.
    progress : callable
        Called with the fraction done, from any thread.

    Returns
    -------
    Run
        To the last bit that of one run of so many paths with the same x(0).  With ``rtol`` each of
        the quantities also has a ``budget``; their number of paths depends on the run and on ``rtol`` alone.

    Raises
    ------
    TypeError
        If ``run`` is not a run, or ``paths`` or ``threads`` no whole number.
    ValueError
        If neither or both of ``paths`` and ``rtol`` are given, or ``threads`` is below 1.  If the run has as many paths
        already, has results that need every step of each path (distributions, spectrum, observables, first passages,
        profiles), was made with ``rtol``, or was saved without the sums of its paths.  If this machine or version gives
        other bits.  With ``rtol`` also if no number of paths reaches it: the sentence says what is in the way.

    Notes
    -----
    A run that was made with ``rtol`` chose step, window and start for that error.  A smaller one needs others, so that
    such a run is not continued: run it with the smaller ``rtol``.

    Examples
    --------
    >>> import springpot as sp
    >>> first = sp.simulate(sp.Oscillator(), paths=100, duration=2.0, start="rest")
    >>> whole = sp.simulate(sp.Oscillator(), paths=200, duration=2.0, start="rest")
    >>> sp.extend(first, paths=200).estimates == whole.estimates
    True
    """
    _check(run)
    check_called(progress, "progress")
    if (paths is None) == (rtol is None):
        raise ValueError("paths or rtol must be given, and not both.")
    if rtol is not None:
        return _extended_to(run, rtol, quantities, threads, progress)
    return _with_paths(run, paths, threads, progress)


def _check(run: object) -> None:
    if not isinstance(run, Run):
        raise TypeError(f"run must be a Run, not {shown(run)}.")
    if any(each.budget for each in run.estimates.values()) and not run.path_sums.size:
        raise ValueError("run must not be made with rtol, whose paths have several steps: run it with another rtol.")
    asked = results_on_request(run.system)
    there = [words for kind, words in KINDS.items() if getattr(run, kind)]
    there += ["observables"] * any(not unit or name in asked for name, unit in run.units.items())
    if there:
        raise ValueError(f"run must have moments only, but it has {there[0]}, which need every step of each path.")
    if not run.path_sums.size:
        raise ValueError("run was saved without the sums of its paths: save it with path_sums=True.")


def _with_paths(run: Run, paths: object, threads: int | None, progress: Progress | None) -> Run:
    """The run with so many paths, without budgets."""
    before = run.settings.paths
    wanted = whole_number(paths, "paths", before + 1, MOST_PATHS, f" The run has {before} paths.")
    settings = replace(
        run.settings, paths=wanted, threads=run.settings.threads if threads is None else checked_threads(threads)
    )
    simulation = simulation_of(Plan(motion_of(run.system), settings, run.adapted))
    begun = time.perf_counter()
    few = min(LANES, before)  # another version, processor or library would give other bits
    again = simulation.but(paths=few, record=min(few, run.settings.record)).advance()
    there = run.path_sums[:few]
    if again.rows.shape != there.shape or not np.array_equal(again.rows, there, equal_nan=True):
        made = run.diagnostics.get("versions", {}).get("springpot", "?")
        raise ValueError(
            f"run cannot be extended here: it was made by springpot {made} on another machine or with other libraries, "
            "and its first paths come out with other bits; run it anew."
        )
    whole = before // LANES * LANES
    skipped = whole if settings.record <= whole else 0
    later = simulation.but(paths=wanted - skipped, record=0 if skipped else settings.record)
    ensemble = later.advance(skipped=skipped, progress=progress)
    rows = np.concatenate([run.path_sums[:skipped], ensemble.rows])
    seen = watched(simulation, rows)
    values, errors = estimates_of(simulation, rows, seen)
    biases = step_biases(simulation.motion, settings.step, values, {}, {}, PROBABILITIES)
    first = simulation.but(paths=before)
    known, doubtful = ({name: getattr(own, what) for name, own in run.estimates.items()} for what in ("value", "error"))
    old = {*doubts(first, known, doubtful, run.path_sums, watched(first, run.path_sums))}
    kept = (sentence for sentence in run.warnings if sentence not in old)
    return replace(
        run,
        settings=settings,
        estimates=estimates_from(run.system, values, errors, step_biases=biases),
        diagnostics=diagnostics_of(simulation, rows, run.diagnostics["seconds"] + time.perf_counter() - begun),
        warnings=(*kept, *doubts(simulation, values, errors, rows, seen)),
        record=run.record if skipped else ensemble.record,
        path_sums=rows,
    )


@dataclass(frozen=True)
class _Standing:
    """One quantity of a run: its error, and what would be enough."""

    name: str
    value: float
    budget: Budget
    paths: float
    pairs: float

    @property
    def off(self) -> float:
        """The relative total error."""
        return self.budget.total / abs(self.value)


def _extended_to(
    run: Run, rtol: float, quantities: Sequence[str] | None, threads: int | None, progress: Progress | None
) -> Run:
    """The run with as many paths as the total error needs, and with budgets."""
    rtol = finite_number(rtol, "rtol", low=1e-4, high=0.5, hint="It is the relative error asked for.")
    motion = motion_of(run.system)
    wanted = checked_quantities(motion, motion.usual_quantities if quantities is None else quantities)
    if outputs := [name for name in wanted if name in output_squares(run.system)]:
        raise ValueError(f"quantities must not have {outputs[0]} here: only a run by simulate(rtol=) sees it.")
    check_motion(motion, "rtol")
    if run.settings.scheme == "grunwald":
        raise ValueError(f"run must have the default scheme, not {run.settings.scheme!r}, whose bias is not measured.")
    if run.settings.record:
        raise ValueError("run must not have recorded paths if it is extended to an rtol.")
    if run.adapted is None:
        raise ValueError(
            "run must have a stationary start if it is extended to an rtol: the bias of others is not known."
        )
    if slow := [name for name in wanted if "impact" in name and name.startswith((*motion.completed,))]:
        raise ValueError(
            f"quantities must not have {slow[0]} behind a lossy wall: its slow impacts are added only in a run "
            "that was made with rtol."
        )
    # its pairs have the run's step and half of it; the paths are those of the run
    pairs = levels_of(Plan(motion, run.settings, run.adapted))
    targets = (run.settings.paths, FIRST_PAIRS)
    while True:
        if change := change_in_window(pairs.pair_coarse.simulation, run.path_sums, rtol / 3.0, wanted):
            raise ValueError(f"run must be stationary if it is extended to an rtol. {change.said}")
        if targets[0] > run.settings.paths:
            run = _with_paths(run, targets[0], threads, None)
        pairs = pairs.extended(0, targets[1], None)
        standings = _standings(run, pairs, wanted, rtol)
        if all(each.off <= rtol for each in standings):
            break
        targets = _targets(run, pairs, standings)
        if progress is not None:
            progress(_done(run, pairs, standings, rtol))
    budgets = {each.name: each.budget for each in standings}
    more = {"pairs": pairs.pair_coarse.paths, "reached": True}
    known = {name: replace(own, budget=budgets.get(name)) for name, own in run.estimates.items()}
    return replace(run, estimates=known, diagnostics={**run.diagnostics, **more})


def _standings(run: Run, levels: Levels, wanted: Sequence[str], rtol: float) -> list[_Standing]:
    """The budgets of the run's own values."""
    simulation = levels.pair_coarse.simulation
    estimates = combine(levels)
    samples = {name: per_path for name, (_, per_path) in samples_of(simulation, run.path_sums).items()}
    found = []
    for name in wanted:
        known, value = estimates.known[name], run[name].value
        if not (math.isfinite(value) and value != 0.0):
            raise ValueError(f"run must have seen enough to estimate {name}: extend it by paths first.")
        chance = standard_error(samples[name])
        # of the coarse step, whose values are not extrapolated: the difference to half of it, and what remains there
        middle, half = bias_range(known.orders, 0)
        weight = 1.0 + middle + half  # bound on the bias of the run's step over the difference of the pairs
        step_bias = weight * (known.difference + known.difference_error) + known.other_bias
        budget = replace(estimates.budgets[name], standard_error=chance, step_bias=step_bias)
        allowed = rtol * abs(value)
        of_step = weight * max(known.difference - 2.0 * known.difference_error, 0.0) + known.other_bias
        sure = of_step + known.fixed
        if sure > HOPELESS * allowed:
            what = f"its step of {run.settings.step:.3g} s" if of_step > known.fixed else "its start, window and memory"
            raise ValueError(
                f"rtol of {per_cent(rtol)} cannot be reached with more paths: {known.name} of this run has a bias of "
                f"up to {per_cent(sure / abs(value))} from {what}; make a run with rtol."
            )
        room = allowed - sure
        goal, pairs_goal = FOR_CHANCE * room / NORMAL, (1.0 - FOR_CHANCE) * room / (3.0 * weight)
        paths = run.settings.paths * (budget.standard_error / goal) ** 2
        pairs = levels.pair_coarse.paths * (known.difference_error / pairs_goal) ** 2
        found.append(_Standing(known.name, value, budget, paths, pairs))
    return found


def _targets(run: Run, levels: Levels, standings: Sequence[_Standing]) -> tuple[int, int]:
    """Paths and pairs of the next round."""
    now = run.settings.paths, levels.pair_coarse.paths
    needed = max(each.paths for each in standings), max(each.pairs for each in standings)
    growth = [min(goal / number, MOST_GROWTH) for goal, number in zip(needed, now, strict=True)]
    if max(growth) < LEAST_GROWTH:
        growth = [LEAST_GROWTH, LEAST_GROWTH]
    paths, pairs = (
        -(-math.ceil(number * max(share, 1.0)) // LANES) * LANES for number, share in zip(now, growth, strict=True)
    )
    if paths > MOST_PATHS:
        raise ValueError(f"rtol needs more than {MOST_PATHS} paths in the window of this run; make a run with rtol.")
    return max(paths, now[0]), max(pairs, now[1])


def _done(run: Run, levels: Levels, standings: Sequence[_Standing], rtol: float) -> FractionDone:
    """How far it is, with the work that is still to come."""
    worst = max(standings, key=lambda each: each.off)
    steps, spent = run.settings.steps, run.settings.paths + 3.0 * levels.pair_coarse.paths
    whole = steps * max(worst.paths + 3.0 * worst.pairs, spent)
    rate = run.settings.paths * steps / max(run.diagnostics["seconds"], 1e-3)
    reason = f"the sampling error of {worst.name} falls like 1 / sqrt(paths)"
    left = Estimate(whole, (whole - steps * spent) / rate, reason, rtol)
    return FractionDone(min(1.0, steps * spent / whole), left)
