"""Results of a run with the samples of each path."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.oscillator import Oscillator
from springpot.simulation.adapted import adapt
from springpot.simulation.settings import Settings
from springpot.simulation.simulation import Progress, simulation_of
from springpot.system import System

__all__ = ["samples_of"]

Floats = NDArray[np.float64]


def samples_of(
    problem: Oscillator | System, settings: Settings, progress: Progress | None = None, done: int = 0, runs: int = 1
) -> dict[str, tuple[float, Floats, float]]:
    """Value, samples path by path and error of the start of every result; ``done`` of ``runs`` runs are done."""
    part = None if progress is None else (lambda fraction: progress((done + fraction) / runs))
    adapted = adapt(problem, settings, progress=part) if settings.start == "stationary" else None
    simulation = simulation_of(problem, settings, adapted)
    samples = simulation.samples(simulation.advance(progress=part).rows)
    start = simulation.errors_of_the_start({name: value for name, (value, _) in samples.items()})
    return {name: (value, own, start[name]) for name, (value, own) in samples.items()}
