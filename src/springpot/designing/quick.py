"""Quantities that are quick to compute, for a search: by one method of theory, or by Monte Carlo with few paths."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from springpot.designing.numbers import as_simulated
from springpot.designing.quantities import MONTE_CARLO, chosen_method, theory_values
from springpot.designing.samples import samples_of
from springpot.designing.statement import Space
from springpot.faults import NotCovered
from springpot.free_numbers import with_values
from springpot.oscillator import Oscillator
from springpot.simulation.settings import resolve
from springpot.system import System

__all__ = ["places_of", "quick_quantities"]

Floats = NDArray[np.float64]

PILOT_PATHS = 1000  # where Monte Carlo takes the place of theory


def quick_quantities(
    problem: Oscillator | System, space: Space, places: Floats, method: str | None, seed: int, threads: int | None
) -> tuple[str, Callable[[Mapping[str, float]], dict[str, float]]]:
    """The method of the search, and quantities by it; the one with an answer at most of the first places."""
    models = [with_values(problem, space.values(place)) for place in places[:4]]
    names: list[str] = []
    for model in models[:3] if method is None else models[:1]:
        try:
            names.append(chosen_method(model, "theory" if method is None else method)[0])
        except ValueError:
            if method is not None:
                raise
    names = [*dict.fromkeys(names)]
    name = names[0] if len(names) == 1 else MONTE_CARLO
    if len(names) > 1:
        name = max(names, key=lambda each: sum(bool(theory_values(model, each)[0]) for model in models))
    if name != MONTE_CARLO:

        def by_theory(values: Mapping[str, float]) -> dict[str, float]:
            try:
                return theory_values(with_values(problem, values), name)[0]
            except (ValueError, TypeError, NotCovered):
                return {}

        return name, by_theory
    settings = resolve(as_simulated(problem), paths=PILOT_PATHS, seed=seed, threads=threads)

    def by_chance(values: Mapping[str, float]) -> dict[str, float]:
        try:
            found = samples_of(as_simulated(with_values(problem, values)), settings, None, 0, 1)
        except (ValueError, TypeError):
            return {}
        return {name: value for name, (value, _, _) in found.items() if math.isfinite(value)}

    return name, by_chance


def places_of(space: Space, seed: int) -> Floats:
    """The start, and places spread evenly (Sobol's sequence)."""
    from scipy.stats import qmc

    many = {1: 3, 2: 4, 3: 5}.get(len(space.free), 6)
    spread = qmc.Sobol(len(space.free), rng=seed).random_base2(many)
    return np.vstack([space.start, spread])
