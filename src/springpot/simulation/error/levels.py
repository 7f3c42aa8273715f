"""The levels of a run with ``rtol``: pairs of paths at a step and at half of it, and many paths at a finer step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.machine.arrays import Floats
from springpot.simulation.error.decision import FEWEST_PATHS
from springpot.simulation.estimate.controls import controls_of
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.estimate.settled import Change, change_in_window
from springpot.simulation.estimate.slow_impacts import counts_of_fast_impacts, extrapolation_step, with_completed_rate
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.paths.simulation import Progress, Simulation, simulation_of
from springpot.simulation.plan.creep import Creep
from springpot.simulation.plan.creep_of_paper import CreepOfPaper
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.options import Options
from springpot.simulation.plan.plan import MOST_TRANSIENT, Plan, default_start, shares_missing
from springpot.simulation.plan.schemes import scheme_of
from springpot.simulation.plan.settings import MOST_STEPS, Settings
from springpot.simulation.watch.forces import Moments

LONGEST = 100 * MOST_STEPS  # path with rtol
LONGER_STEP, LONG_MEMORY = 3.0, 300.0  # factor on the first step for a loose tolerance, if the energy time is so long
FORGET = 20.0  # least decay of the transient before the window begins
SLOWLY = 0.2  # share of the tolerance that may be missing from slow displacements when the window begins
RELAXATIONS = (10.0, 20.0)  # in the window, at least; the more, the less is the share of the time before it
MANY_RELAXATIONS = 0.2  # over rtol
FIRST_RELAXATIONS = 1.0  # rtol^2 of the relaxations in the first round's windows
FIRST_PAIRS, FEWEST_PAIRS = (256, 1024), 128  # in the first round; the fewest if each is long
FIRST_PATH_STEPS = 1e9
PRECISE = 1e-3  # rtol below which the memory is kept in double precision


@dataclass(frozen=True, eq=False)
class Level:
    """Paths of one step size, in one stream of normals.

    Attributes
    ----------
    simulation : Simulation
    stream : int
    halved : bool
        Whether the noise is that of half the step, summed in pairs.
    rows : ndarray, shape (paths, columns)
    counted : ndarray, shape (paths, 2 times the walls that are completed)
        Counts of `counts_of_fast_impacts`.
    forces : tuple of Moments
        Forces and accelerations that are seen.
    outputs : dict of ndarray, shape (paths,)
        Their samples, by the names of the estimates.
    """

    simulation: Simulation
    stream: int
    halved: bool
    rows: Floats
    counted: Floats
    forces: tuple[Moments, ...] = ()
    outputs: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def paths(self) -> int:
        """Number of paths."""
        return len(self.rows)

    def extended(self, paths: int, progress: Progress | None) -> Level:
        """The same with so many paths, rounded up to whole blocks."""
        more = -(-(paths - self.paths) // LANES) * LANES
        if more <= 0:
            return self
        counts = counts_of_fast_impacts(self.simulation)
        ensemble = self.simulation.but(paths=more).advance(
            stream=self.stream,
            skipped=self.paths,
            halved=self.halved,
            observers=(*counts, *(each.observer for each in self.forces)),
            progress=progress,
        )
        numbers = [ensemble.observed[own]["number"] for own in counts]
        counted = np.stack([np.empty(more), *numbers], axis=1)[:, 1:]
        seen = (each.read(self.simulation, ensemble)["estimates"] for each in self.forces)
        outputs = {name: samples for own in seen for name, (_, samples) in own.items()}
        return replace(
            self,
            rows=np.concatenate([self.rows, ensemble.rows]),
            counted=np.concatenate([self.counted, counted]),
            outputs={name: np.concatenate([self.outputs.get(name, np.empty(0)), own]) for name, own in outputs.items()},
        )

    def samples(self) -> dict[str, Floats]:
        """Samples of each estimate, one per path."""
        per_path = {name: samples for name, (_, samples) in samples_of(self.simulation, self.rows).items()}
        return with_completed_rate(self.simulation, per_path, self.counted) | dict(self.outputs)

    def controls(self, samples: dict[str, Floats]) -> Floats:
        """The control variates of each path, from its samples, shape (paths, controls)."""
        return controls_of(self.simulation, self.rows, samples.get("energy_residual"))

    def unsettled(self, rtol: float, wanted: Sequence[str]) -> Change | None:
        """What still changes in the window by more than a third of a tolerance; None if nothing does."""
        return change_in_window(self.simulation, self.rows, rtol / 3.0, wanted)


@dataclass(frozen=True, eq=False)
class Levels:
    """Pairs of paths at a step and at half of it with the same noise, and many paths at that half or a finer step.

    Attributes
    ----------
    many : Level
        Without paths at first; the finer members of the pairs then stand for them.
    pair_coarse, pair_fine : Level
    finer : int
        Halvings from the finer step of the pairs to that of ``many``.
    """

    many: Level
    pair_coarse: Level
    pair_fine: Level
    finer: int = 0

    @property
    def best(self) -> Level:
        """The paths whose means are the values: ``many`` if there are any, else the finer members of the pairs."""
        return self.many if self.many.paths else self.pair_fine

    @property
    def path_steps(self) -> float:
        """Steps of all paths together."""
        levels = (self.many, self.pair_coarse, self.pair_fine)
        return sum(float(level.paths) * level.simulation.settings.steps for level in levels)

    def work(self, paths: int, pairs: int) -> float:
        """Path-steps still needed for so many paths and pairs."""
        paths, pairs = paths - self.many.paths, pairs - self.pair_coarse.paths
        many, coarse = self.many.simulation.settings.steps, self.pair_coarse.simulation.settings.steps
        return float(many * paths + 3.0 * coarse * pairs)

    def with_step(self, finer: int) -> Levels:
        """The same with paths so much finer, which begin anew if they were not."""
        if finer == self.finer:
            return self
        plan = self.pair_fine.simulation.plan
        many = _without_paths(simulation_of(plan.but(step=plan.settings.step * 0.5**finer)), 0, self.many.forces)
        return replace(self, many=many, finer=finer)

    def extended(self, paths: int, pairs: int, progress: Progress | None) -> Levels:
        """The same with so many paths and pairs."""
        return replace(
            self,
            many=self.many.extended(paths, progress),
            pair_coarse=self.pair_coarse.extended(pairs, progress),
            pair_fine=self.pair_fine.extended(pairs, progress),
        )


def levels_of(plan: Plan, forces: Sequence[str] = ()) -> Levels:
    """Levels without paths, which see some forces; ``plan`` is that of the coarser members of the pairs."""
    coarse = simulation_of(plan, halved=True)
    fine = simulation_of(plan.but(step=0.5 * plan.settings.step))
    seen = tuple(Moments.asked(plan, {"forces": forces}))
    pair_coarse = replace(_without_paths(coarse, 3, seen), halved=True)
    return Levels(_without_paths(fine, 0, seen), pair_coarse, _without_paths(fine, 3, seen))


def _without_paths(simulation: Simulation, stream: int, forces: tuple[Moments, ...]) -> Level:
    return Level(
        simulation,
        stream,
        False,
        np.empty((0, len(simulation.parts.columns))),
        np.empty((0, 2 * len(simulation.motion.completed))),
        forces,
    )


def level_plan(
    motion: Motion, step: float, rtol: float, wanted: Sequence[str], *, seed: int, threads: int, later: float = 1.0
) -> Plan:
    """The plan of the coarser members of the pairs.

    The window begins after the transient; its length is ten to twenty relaxation times, or half the time before it if
    that is longer.  Both are ``later`` times as long where runs have shown that this was not enough.
    """
    relaxation = motion.scales.forgetting_time
    waiting = -math.log(MOST_TRANSIENT) * motion.waiting_time("rest")
    late = max(waiting, *(_slow_time(creep, motion, rtol, wanted) for creep in motion.slow), relaxation)
    begin = max(relaxation * math.log(max(3.0 / rtol, FORGET)), late)
    if motion.is_thermal:
        begin = 0.0  # it starts from the stationary law
    fewest, most = RELAXATIONS
    length = later * max(min(max(MANY_RELAXATIONS / rtol, fewest), most) * relaxation, 0.5 * begin)
    begin *= later
    if begin + length > LONGEST * step:
        raise ValueError(
            f"rtol cannot be reached: the motion forgets its start only after {late:.2g} s, and a path has at "
            f"most {LONGEST:,} steps of {step:.2g} s; give paths and duration instead."
        )
    begin, length = (step * math.ceil(time / step) for time in (begin, length))
    start, _ = default_start(motion)
    settings = Settings(
        paths=FEWEST_PATHS,
        duration=begin + length,
        step=step,
        window=(begin, begin + length),
        seed=seed,
        threads=threads,
        scheme=motion.scheme_for("default"),
        start=start,
        initial_position=motion.placed(None) if start == "rest" else None,
        initial_velocity=motion.moving(None),
        memory_tolerance=1e-8 if rtol < PRECISE else Options.memory_tolerance,
    )
    return Plan(motion, settings)


def first_step(motion: Motion, rtol: float, wanted: Sequence[str]) -> float:
    """The step of the first round; longer for a loose tolerance and long paths, if the times are no guess."""
    scales = motion.scales
    longest = scheme_of(motion.scheme_for("default")).coarsest_step / scales.fastest_rate
    long_paths = scales.forgetting_time * scales.fastest_rate > LONG_MEMORY
    if long_paths and not scales.guessed and not motion.struck.crowded:
        longest *= min(max(rtol / 0.01, 1.0), LONGER_STEP)
    struck = [wall for name, wall in motion.struck_alone.items() if any(q.startswith(f"{name}_impact") for q in wanted)]
    return min(longest, *(4.0 * extrapolation_step(wall) for wall in (motion.struck, *struck)))


def first_pairs(simulation: Simulation, rtol: float) -> int:
    """Pairs of the first round: about what a loose tolerance needs, fewer if each path is long."""
    begin, end = simulation.settings.window
    relaxations = (end - begin) / simulation.motion.scales.forgetting_time
    fewest, most = FIRST_PAIRS
    few = min(max(FIRST_PATH_STEPS / (3.0 * simulation.settings.steps), FEWEST_PAIRS), fewest)
    pairs = int(min(max(FIRST_RELAXATIONS / rtol**2 / relaxations, few), most))
    return -(-pairs // (2 * LANES)) * 2 * LANES


def _slow_time(creep: Creep | CreepOfPaper, motion: Motion, rtol: float, wanted: Sequence[str]) -> float:
    """Time in s after which the missing slow displacements are negligible, from variances without a wall."""
    if not creep.free:
        return 0.0
    values = dict.fromkeys(wanted, 1.0) | creep.free
    alone = replace(motion, slow=(creep,))
    time, last = creep.times
    while time < last:
        shares = shares_missing(alone, time, values)
        if max(shares[name] for name in wanted) <= SLOWLY * rtol:
            break
        time *= 1.1
    return time
