"""The levels of a run with ``rtol``: many paths at a step h, and fewer pairs at h and h/2 with the same noise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.options import DEFAULTS
from springpot.oscillator import Oscillator
from springpot.parts import ThermalNoise
from springpot.simulation.adapted_start import Adapted
from springpot.simulation.completed_rate import are_crowded, at_walls, counts_of_fast_impacts, with_completed_rate
from springpot.simulation.compose import Floats
from springpot.simulation.forgetting import oscillators_alike, shares_missing
from springpot.simulation.lanes import LANES
from springpot.simulation.settings import Settings, derivative_at
from springpot.simulation.simulation import Progress, Simulation, simulation_of
from springpot.simulation.slow_impacts import extrapolation_step
from springpot.simulation.system_scales import scales_of_problem
from springpot.system import System
from springpot.theory import exact

__all__ = [
    "Level", "Levels", "first_step", "first_targets", "forgetting_time_of", "level_settings", "levels_of",
]  # fmt: skip

COARSEST_STEP = 0.1  # first step tried, in units of the shortest time scale
LONGER_STEP, LONG_MEMORY = 3.0, 300.0  # factor on it for a loose tolerance, if the energy time is so long
GUESSED = 1.5  # factor on the forgetting time of a system
FORGET = 20.0  # least decay of the transient before the window begins
SLOWLY = 0.2  # share of the tolerance that may be missing from slow displacements when the window begins
RELAXATIONS = 10.0  # in the window, at least
FIRST_RELAXATIONS = 2.0  # rtol^2 of the relaxations in the first round's windows
FIRST_PATHS, FEWEST_PATHS = (512, 2048), 128  # in the first round; the fewest if each is long
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
    rows : ndarray, shape (paths, len(COLUMNS))
    counted : ndarray, shape (paths, 3)
        Counts of `counts_of_fast_impacts`; empty if slow impacts are not frequent.
    """

    simulation: Simulation
    stream: int
    halved: bool
    rows: Floats
    counted: Floats

    @property
    def paths(self) -> int:
        """Number of paths."""
        return len(self.rows)

    def extended(self, paths: int, progress: Progress | None) -> Level:
        """The same with so many paths, rounded up to whole blocks."""
        more = -(-(paths - self.paths) // LANES) * LANES
        if more <= 0:
            return self
        crowded = are_crowded(self.simulation.problem)
        ensemble = self.simulation.but(paths=more).advance(
            stream=self.stream,
            skipped=self.paths,
            halved=self.halved,
            observers=(counts_of_fast_impacts(self.simulation),) if crowded else (),
            progress=progress,
        )
        rows, counted = np.concatenate([self.rows, ensemble.rows]), np.concatenate([self.counted, *ensemble.observed])
        return replace(self, rows=rows, counted=counted)

    def samples(self) -> dict[str, Floats]:
        """Samples of each estimate, one per path."""
        per_path = {name: samples for name, (_, samples) in self.simulation.samples(self.rows).items()}
        return with_completed_rate(self.simulation, per_path, self.counted) if self.counted.size else per_path


@dataclass(frozen=True, eq=False)
class Levels:
    """Paths at the coarse step, and pairs of paths at the coarse and the fine step with the same noise."""

    coarse: Level
    pair_coarse: Level
    pair_fine: Level

    @property
    def path_steps(self) -> float:
        """Steps of all paths together."""
        levels = (self.coarse, self.pair_coarse, self.pair_fine)
        return sum(float(level.paths) * level.simulation.settings.steps for level in levels)

    def work(self, paths: int, pairs: int) -> float:
        """Path-steps still needed for so many paths and pairs."""
        paths, pairs = paths - self.coarse.paths, pairs - self.pair_coarse.paths
        return float(self.coarse.simulation.settings.steps * (paths + 3.0 * pairs))

    def extended(self, paths: int, pairs: int, progress: Progress | None) -> Levels:
        """The same with so many paths and pairs."""
        return Levels(
            self.coarse.extended(paths, progress),
            self.pair_coarse.extended(pairs, progress),
            self.pair_fine.extended(pairs, progress),
        )


def levels_of(problem: Oscillator | System, settings: Settings, adapted: Adapted) -> Levels:
    """Levels without paths; ``settings`` are those of the coarse one."""
    coarse = simulation_of(problem, settings, adapted)
    fine = simulation_of(problem, replace(settings, step=0.5 * settings.step), adapted)
    paired = coarse if isinstance(problem, Oscillator) else simulation_of(problem, settings, adapted, halved=True)
    no_rows, no_counts = np.empty((0, len(coarse.parts.columns))), np.empty((0, 3))
    return Levels(
        Level(coarse, 0, False, no_rows, no_counts),
        Level(paired, 3, True, no_rows, no_counts),
        Level(fine, 3, False, no_rows, no_counts),
    )


def level_settings(
    problem: Oscillator | System, step: float, rtol: float, wanted: Sequence[str], *, seed: int, threads: int
) -> Settings:
    """Settings of the coarse level.

    The window begins after the transient; its length is ten relaxation times, or half the time before it if longer.
    """
    relaxation = forgetting_time_of(problem)
    begin = max(relaxation * math.log(max(3.0 / rtol, FORGET)), _slow_time(problem, rtol, wanted))
    if isinstance(problem, System) and problem.of(ThermalNoise):
        begin = 0.0  # it starts from the stationary law
    length = max(RELAXATIONS * relaxation, 0.5 * begin)
    begin, length = (step * math.ceil(time / step) for time in (begin, length))
    return Settings(
        paths=FEWEST_PATHS,
        duration=begin + length,
        step=step,
        window=(begin, begin + length),
        seed=seed,
        threads=threads,
        derivative=derivative_at(problem, "caputo"),
        memory_tolerance=1e-8 if rtol < PRECISE else DEFAULTS["memory_tolerance"],
    )


def forgetting_time_of(problem: Oscillator | System) -> float:
    """As in the scales; of a system longer, because the energy time of its scales is a rough guess."""
    longer = 1.0 if isinstance(problem, Oscillator) else GUESSED
    return longer * scales_of_problem(problem).forgetting_time


def first_step(problem: Oscillator | System, rtol: float) -> float:
    """The step of the first round; longer for a loose tolerance and long paths."""
    scales = scales_of_problem(problem)
    longest = COARSEST_STEP / scales.fastest_rate
    if isinstance(problem, System):
        walls = at_walls(problem)
        return longest if walls is None else min(longest, 4.0 * extrapolation_step(walls))
    if scales.forgetting_time * scales.fastest_rate > LONG_MEMORY and not are_crowded(problem):
        longest *= min(max(rtol / 0.01, 1.0), LONGER_STEP)
    return min(longest, 4.0 * extrapolation_step(problem))


def first_targets(simulation: Simulation, rtol: float) -> tuple[int, int]:
    """Paths and pairs of the first round: about what the tolerance needs, fewer if each path is long."""
    begin, end = simulation.settings.window
    relaxations = (end - begin) / forgetting_time_of(simulation.problem)
    fewest, most = FIRST_PATHS
    few = min(max(FIRST_PATH_STEPS / (2.5 * simulation.settings.steps), FEWEST_PATHS), fewest)
    paths = int(min(max(FIRST_RELAXATIONS / rtol**2 / relaxations, few), most))
    paths = -(-paths // (2 * LANES)) * 2 * LANES
    return paths, paths // 2


def _slow_time(problem: Oscillator | System, rtol: float, wanted: Sequence[str]) -> float:
    """Time in s after which the missing slow displacements are negligible, from variances without a wall."""
    if isinstance(problem, System):
        return max((_slow_time(alike, rtol, wanted) for alike in oscillators_alike(problem)), default=0.0)
    oscillator = problem
    try:
        free = exact(replace(oscillator, barrier=None))
        x_mean_square, amplitude = free.x_mean_square, free.amplitude_mean_square
    except ValueError:  # no springpot, or one of order 0: the wall alone dissipates
        return 0.0
    scales = scales_of_problem(oscillator)
    time, last = 1.0 / oscillator.natural_frequency, 100.0 * scales.relaxation_time
    while time < last:
        shares = shares_missing(oscillator, time, x_mean_square, amplitude)
        if max(shares.get(name, shares["x_mean"]) for name in wanted) <= SLOWLY * rtol:
            break
        time *= 1.1
    return time
