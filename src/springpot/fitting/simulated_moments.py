"""What a run gives for measured statistics: one vector for all models, with its samples group by group of paths."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.designing.quantities import SampledRun, sampled_run
from springpot.fitting.statistics import QUANTILE, MeasuredStatistics
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, meant
from springpot.problem.free_numbers import with_values
from springpot.problem.outputs import output_squares
from springpot.problem.system import System
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.kernel.watching import BATCHES
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.paths.statistics import controlled
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import Adapted, Plan, check_motion, plan_of
from springpot.simulation.plan.settings import Settings
from springpot.simulation.watch.distributions import Distribution

Measured = tuple[System, MeasuredStatistics]
"""A model, and what was measured of it."""

_GROUPS = 128
_PILOT_PATHS = 1024
_COARSER = 4.0  # steps of the rough runs
_BINS = 4  # on each side of a quantile, for the density there
_OF_FORCES = "_mean", "_mean_square", "_rms", "_standard_deviation"


@dataclass(frozen=True, eq=False)
class Case:
    """One model beside what was measured of it.

    Attributes
    ----------
    system : System
        With free numbers.
    data : MeasuredStatistics
    settings, rough : Settings
        Of its runs, and of those that only lead there, at a coarser step: all have the same step, duration and random
        numbers.
    start : Adapted or None
        Its stationary start; x(0) of other numbers is moved from there.
    """

    system: System
    data: MeasuredStatistics
    settings: Settings
    rough: Settings
    start: Adapted | None = None

    @property
    def has_quantiles(self) -> bool:
        """Whether a distribution must be counted."""
        return any(QUANTILE.fullmatch(name) for name in self.data.names)

    @property
    def forces(self) -> list[str]:
        """Forces and accelerations among what was measured."""
        of = {name.removesuffix(end) for name in self.data.names for end in _OF_FORCES}
        return [name for name in output_squares(self.system).values() if name in of]

    def steps_at(self, named: Mapping[str, float]) -> int:
        """Of a path of a rough run that is made for these numbers."""
        return _settings(_motion(self.system, named), self.settings.seed, self.settings.threads)[1].steps


@dataclass(frozen=True, eq=False)
class Moments:
    """What one run gives.

    Attributes
    ----------
    values : ndarray, shape (n,)
    samples : ndarray, shape (groups, n)
    mean : float
        Of x.
    """

    values: Floats
    samples: Floats
    mean: float


def case_of(
    model: Measured, named: Mapping[str, float], seed: int, threads: int | None, check: Progress | None
) -> Case:
    """A case with step, duration and start for these numbers; ``check`` is called again and again.

    Raises
    ------
    ValueError
        If there is no stationary state.
    """
    motion = _motion(model[0], named)
    settings, rough = _settings(motion, seed, threads)
    found = Case(*model, settings, rough)
    if settings.start == "rest":
        return found
    return replace(found, start=adapt(Plan(motion, settings), paths=_PILOT_PATHS, progress=check).adapted)


def _motion(system: System, named: Mapping[str, float]) -> Motion:
    motion = motion_of(with_values(system, named))
    check_motion(motion, "a fit to MeasuredStatistics")
    return motion


def _settings(motion: Motion, seed: int, threads: int | None) -> tuple[Settings, Settings]:
    """With the default step, and with a coarser one."""
    fine = plan_of(motion.system, paths=_PILOT_PATHS, seed=seed, threads=threads).settings
    step = fine.duration / max(round(fine.steps / _COARSER), 1)
    rough = plan_of(motion.system, paths=_PILOT_PATHS, seed=seed, threads=threads, step=step, duration=fine.duration)
    return fine, rough.settings


def moments_of(
    case: Case,
    named: Mapping[str, float],
    paths: int,
    groups: int,
    mean: float | None,
    *,
    rough: bool,
    progress: Progress | None,
) -> Moments:
    """Run a model.

    Parameters
    ----------
    case : Case
    named : dict
        The free numbers.
    paths : int
        A power of two.
    groups : int
        Of `groups_of`.
    rough : bool
        At a coarser step.
    mean : float or None
        Where the run starts: the mean of x, as well as it is known; None is that of ``case.start``.
    progress : callable or None

    Raises
    ------
    ValueError
        If a part refuses its number, there is no stationary state, or no such result.
    """
    motion, start = _motion(case.system, named), case.start
    if start is not None and (start.pilots == 0 or isinstance(start.position, dict)):  # of several masses it is anew
        start = adapt(Plan(motion, case.settings), paths=_PILOT_PATHS, progress=progress).adapted
    elif start is not None and mean is not None:
        start = replace(start, position=min(max(mean, motion.low), motion.high))
    plan = Plan(motion, replace(case.rough if rough else case.settings, paths=paths))
    plan = plan if start is None else plan.started_at(start)
    run = sampled_run(plan, distributions=case.has_quantiles, forces=case.forces, progress=progress)
    outputs = [name for name in output_squares(case.system) if name not in run.samples]
    found = [_statistic(name, run, groups, outputs) for name in case.data.names]
    mean = run.samples["x_mean"][0] if "x_mean" in run.samples else 0.0  # of one mass only
    return Moments(np.array([value for value, _ in found]), np.stack([own for _, own in found], axis=-1), mean)


def groups_of(paths: int, *, quantiles: bool) -> int:
    """Groups of paths whose means are the samples: those of the sketches where there are quantiles.

    Examples
    --------
    >>> groups_of(2048, quantiles=True), groups_of(2048, quantiles=False)
    (32, 128)
    """
    return min(paths // 64, BATCHES) if quantiles else min(paths, _GROUPS)


def _statistic(name: str, run: SampledRun, groups: int, outputs: Sequence[str] = ()) -> tuple[float, Floats]:
    """Its value, and samples with this mean, one for each group; ``outputs``: what another run would have."""
    if match := QUANTILE.fullmatch(name):
        return _quantile(run.distributions.get(match[1]), float(match[2]), groups, name)
    if name.endswith("_standard_deviation"):
        of = name.removesuffix("_standard_deviation")
        square, own = _of_paths(f"{of}_mean_square", run, outputs, name)
        mean, sides = _of_paths(f"{of}_mean", run, outputs, name)
        root = math.sqrt(max(square - mean * mean, 0.0))
        slope = (own - square - 2.0 * mean * (sides - mean)) / (2.0 * root) if root > 0.0 else own * 0.0
        return root, _grouped(root + slope, groups)
    if name.endswith("_rms") and name not in run.samples:
        square, own = _of_paths(f"{name.removesuffix('_rms')}_mean_square", run, outputs, name)
        root = math.sqrt(square) if square > 0.0 else math.nan
        return root, _grouped(root + (own - square) / (2.0 * root), groups)
    value, own = _of_paths(name, run, outputs)
    return value, _grouped(own, groups)


def _of_paths(name: str, run: SampledRun, outputs: Sequence[str], asked: str = "") -> tuple[float, Floats]:
    """A result with its samples, less their regression on the energy that the noise fed by chance."""
    if name not in run.samples:
        known = [*(own for own in run.samples if not own.endswith("_end")), *outputs]
        wrong = asked or name
        raise ValueError(f"data must be of results of the model, which are {listed(known)}, not {wrong}"
                         f"{meant(wrong, known) or '.'}")  # fmt: skip
    value, samples = run.samples[name]
    control = run.samples.get("energy_residual", (0.0, np.full(samples.size, math.nan)))[1]
    if not math.isfinite(value) or not np.isfinite(control).all() or name == "energy_residual":
        return value, samples
    better = controlled(samples, control[:, None])
    return float(better.mean()), better


def _grouped(samples: Floats, groups: int) -> Floats:
    """Means of groups of paths: blocks of 64 in turn, as the sketches have them, or neighbours."""
    if groups <= BATCHES:
        return np.asarray(samples.reshape(-1, groups, 64).mean(axis=(0, 2)))
    return np.asarray(samples.reshape(groups, -1).mean(axis=1))


def _quantile(own: Distribution | None, p: float, groups: int, name: str) -> tuple[float, Floats]:
    if own is None:
        raise ValueError(f"data must be of results of the model, and it has no {name}.")
    if not own.size > 0.0:
        return math.nan, np.full(groups, math.nan)
    at = float(own.quantile(p)[0])
    below = np.concatenate([np.zeros((len(own.counts), 1)), np.cumsum(own.counts, axis=1)], axis=1)
    place = int(np.searchsorted(own.edges, at))
    low, high = max(place - _BINS, 0), min(place + _BINS, own.edges.size - 1)
    density = (below[:, high] - below[:, low]).sum() / (own.edges[high] - own.edges[low])
    under = np.array([np.interp(at, own.edges, each) for each in below])
    missed = (under - p * below[:, -1]) * len(below) / density
    return at, at - (missed - missed.mean())
