"""Results of a run with the samples of each path.

Runs of one seed, step and duration have the same normals in path n, whatever the numbers of the model are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.kernel.lanes import GROUP
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.start import Adapted
from springpot.simulation.watch.distributions import Distribution, distributions_in, sketches

__all__ = ["SampledRun", "as_simulated", "sampled_run", "samples_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SampledRun:
    """Results of one run.

    Attributes
    ----------
    samples : dict
        Value and samples of every result, one sample per path; their mean is the value.
    start : dict
        The standard error that each value has from the error of the stationary start.
    adapted : Adapted or None
        That start.
    distributions : dict of Distribution
        Of x, v, amplitude and impact speed, if they were asked for; otherwise empty.
    """

    samples: dict[str, tuple[float, Floats]]
    start: Mapping[str, float]
    adapted: Adapted | None
    distributions: Mapping[str, Distribution]


def as_simulated(system: System) -> Any:
    """The problem as the engine takes it, which knows the paper's oscillator by another type."""
    try:
        return Dimensionless.of(system)
    except NotCoveredError:
        return system


def sampled_run(
    system: System,
    settings: Settings,
    *,
    adapted: Adapted | None = None,
    distributions: bool = False,
    progress: Progress | None = None,
) -> SampledRun:
    """Run a model.

    Parameters
    ----------
    system : System
    settings : Settings
    adapted : Adapted, optional
        A stationary start that is known already; if left out, approximation runs find it.
    distributions : bool
    progress : callable
        Called with the fraction of this run.

    Returns
    -------
    SampledRun

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, PolynomialSpring, WhiteNoise
    >>> from springpot.simulation.plan.settings import resolve
    >>> system = System(PolynomialSpring((1.0, 0.0, 1.0)), Dashpot(0.5), WhiteNoise(1.0))
    >>> found = sampled_run(system, resolve(system, paths=64, duration=20.0, seed=1, threads=1))
    >>> value, samples = found.samples["x_mean_square"]
    >>> samples.size, bool(abs(samples.mean() - value) < 1e-12)
    (64, True)
    """
    problem = as_simulated(system)
    if adapted is None and settings.start == "stationary":
        adapted = adapt(problem, settings, progress=progress)
    simulation = simulation_of(problem, settings, adapted)
    observers = (sketches(GROUP * settings.step * simulation.scales.fastest_rate),) if distributions else ()
    ensemble = simulation.advance(observers=observers, progress=progress)
    samples = simulation.samples(ensemble.rows)
    start = simulation.errors_of_the_start({name: value for name, (value, _) in samples.items()})
    counted = distributions_in(simulation, ensemble.observed[0]) if distributions else {}
    return SampledRun(samples, start, adapted, counted)


def samples_of(
    system: System, settings: Settings, progress: Progress | None = None, done: int = 0, runs: int = 1
) -> dict[str, tuple[float, Floats, float]]:
    """Value, samples path by path and error of the start of every result; ``done`` of ``runs`` runs are done."""
    part = None if progress is None else (lambda fraction: progress((done + fraction) / runs))
    run = sampled_run(system, settings, progress=part)
    return {name: (value, own, run.start[name]) for name, (value, own) in run.samples.items()}
