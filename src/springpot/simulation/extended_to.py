"""More paths for a run until the total error of some quantities is small enough, in the step and window of the run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.machine.arguments import finite_number
from springpot.machine.faults import per_cent
from springpot.machine.progress import Estimate, FractionDone
from springpot.simulation.error.budget import Budget, combine
from springpot.simulation.error.decision import NORMAL, Known, bias_range
from springpot.simulation.error.levels import Level, Levels, levels_of
from springpot.simulation.error.reach import checked_quantities
from springpot.simulation.estimate.completed_rate import are_crowded
from springpot.simulation.estimate.statistics import standard_error
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.more_paths import with_paths
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.plan.settings import MOST_PATHS, check_stationary
from springpot.simulation.result.results import Run

__all__ = ["extended_to"]

FIRST_PAIRS = 256
HOPELESS = 0.8  # share of the allowed error that may surely be bias
FOR_CHANCE = 0.7  # share of the rest that is left to the sampling error
LEAST_GROWTH, MOST_GROWTH = 1.2, 8.0


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


def extended_to(
    run: Run, rtol: float, quantities: Sequence[str], threads: int | None, progress: Progress | None
) -> Run:
    """The run with as many paths as the total error needs, and with budgets."""
    rtol = finite_number(rtol, "rtol", low=1e-4, high=0.5, hint="It is the relative error asked for.")
    wanted = checked_quantities(run.oscillator, quantities)
    _check(run, wanted)
    pairs = _pairs_of(run)
    targets = (run.settings.paths, FIRST_PAIRS)
    while True:
        if targets[0] > run.settings.paths:
            run = with_paths(run, targets[0], threads, None)
        pairs = _more(pairs, targets[1])
        standings = _standings(run, pairs, wanted, rtol)
        if all(each.off <= rtol for each in standings):
            break
        targets = _targets(run, pairs, standings)
        if progress is not None:
            progress(_done(run, pairs, standings, rtol))
    budgets = {each.name: each.budget for each in standings}
    more = {"pairs": pairs.pair_coarse.paths, "reached": True}
    return replace(run, budgets=budgets, diagnostics={**run.diagnostics, **more})


def _check(run: Run, wanted: Sequence[str]) -> None:
    """What cannot be continued to an error, before work starts."""
    check_stationary(run.oscillator, "rtol")
    if run.settings.scheme != "default":
        raise ValueError(f"run must have the default scheme, not {run.settings.scheme!r}, whose bias is not measured.")
    if run.settings.record:
        raise ValueError("run must not have recorded paths if it is extended to an rtol.")
    if are_crowded(run.oscillator) and (slow := [name for name in wanted if "impact" in name]):
        raise ValueError(
            f"quantities must not have {slow[0]} behind a lossy wall: its slow impacts are added only in a run "
            "that was made with rtol."
        )


def _pairs_of(run: Run) -> Levels:
    """Levels whose pairs have the run's step and half of it; the paths are those of the run."""
    levels = levels_of(run.oscillator, run.settings, run.adapted) if run.adapted is not None else None
    if levels is None:
        raise ValueError(
            "run must have a stationary start if it is extended to an rtol: the bias of others is not known."
        )
    return levels


def _more(levels: Levels, pairs: int) -> Levels:
    return replace(
        levels, pair_coarse=_longer(levels.pair_coarse, pairs), pair_fine=_longer(levels.pair_fine, pairs)
    )  # fmt: skip


def _longer(level: Level, paths: int) -> Level:
    """As `Level.extended`, without the counts of slow impacts."""
    more = -(-(paths - level.paths) // LANES) * LANES
    if more <= 0:
        return level
    ensemble = level.simulation.but(paths=more).advance(
        stream=level.stream, skipped=level.paths, halved=level.halved
    )  # fmt: skip
    return replace(level, rows=np.concatenate([level.rows, ensemble.rows]))


def _standings(run: Run, levels: Levels, wanted: Sequence[str], rtol: float) -> list[_Standing]:
    """The budgets of the run's own values."""
    simulation = levels.pair_coarse.simulation
    estimates = combine(levels)
    samples = {name: per_path for name, (_, per_path) in simulation.samples(run.path_sums).items()}
    found = []
    for name in wanted:
        known, value = estimates.known[name], run.values[name]
        if not (math.isfinite(value) and value != 0.0):
            raise ValueError(f"run must have seen enough to estimate {name}: extend it by paths first.")
        chance = standard_error(samples[name])
        budget = replace(estimates.budgets[name], standard_error=chance, step_bias=_step_bias(known))
        found.append(_standing(run, known, value, budget, levels.pair_coarse.paths, rtol))
    return found


def _step_bias(known: Known) -> float:
    """Of the coarse step, whose values are not extrapolated: the difference to half of it, and what remains there."""
    return _weight(known) * (known.difference + known.difference_error) + known.other_bias


def _weight(known: Known) -> float:
    """Bound on the bias of the run's step over the difference of the pairs."""
    middle, half = bias_range(known.orders, 0)
    return 1.0 + middle + half


def _standing(run: Run, known: Known, value: float, budget: Budget, pairs: int, rtol: float) -> _Standing:
    """Paths and pairs that are enough."""
    allowed, weight = rtol * abs(value), _weight(known)
    of_step = weight * max(known.difference - 2.0 * known.difference_error, 0.0) + known.other_bias
    sure = of_step + known.fixed
    if sure > HOPELESS * allowed:
        what = f"its step of {run.settings.step:.3g} s" if of_step > known.fixed else "its start, window and memory"
        raise ValueError(
            f"rtol of {per_cent(rtol)} cannot be reached with more paths: {known.name} of this run has a bias of up to "
            f"{per_cent(sure / abs(value))} from {what}; make a run with rtol."
        )
    room = allowed - sure
    goal, pairs_goal = FOR_CHANCE * room / NORMAL, (1.0 - FOR_CHANCE) * room / (3.0 * weight)
    return _Standing(
        known.name, value, budget, run.settings.paths * (budget.standard_error / goal) ** 2,
        pairs * (known.difference_error / pairs_goal) ** 2,
    )  # fmt: skip


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
