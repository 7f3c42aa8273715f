"""The paper's oscillator, as a user writes it."""

from __future__ import annotations

from typing import Any

from springpot.problem.dimensionless import Dimensionless
from springpot.problem.parts import Barrier, Spring, Springpot, WhiteNoise
from springpot.problem.system import System

__all__ = ["Barrier", "Oscillator", "Springpot", "WhiteNoise", "as_system"]

Oscillator = Dimensionless


def as_system(problem: Any) -> Any:
    """The problem as a sum of parts; what is no oscillator is left as it is."""
    if not isinstance(problem, Dimensionless):
        return problem
    wall = () if problem.barrier is None else (problem.barrier,)
    # sqrt(fl(w^2)) = w in binary arithmetic: the frequency comes back without a rounding error
    return System(Spring(problem.natural_frequency**2), problem.springpot, *wall, problem.excitation)
