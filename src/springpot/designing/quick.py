"""Quantities that are quick to compute, for a search: by one method of theory, or by surfaces through short runs."""

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

__all__ = ["places_of", "quick_quantities", "smooth"]

Floats = NDArray[np.float64]

PILOT_PATHS = 500  # where Monte Carlo takes the place of theory
SMOOTHING = 1e-4  # of the surfaces through such runs, whose values have errors of some per cent


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
    return name, _by_chance(problem, space, places, seed, threads)


def _by_chance(
    problem: Oscillator | System, space: Space, places: Floats, seed: int, threads: int | None
) -> Callable[[Mapping[str, float]], dict[str, float]]:
    """Smooth surfaces through short runs at all places, on common random numbers."""
    settings = resolve(as_simulated(problem), paths=PILOT_PATHS, seed=seed, threads=threads)
    at, found = [], []
    for place in places:
        try:
            own = samples_of(as_simulated(with_values(problem, space.values(place))), settings)
        except (ValueError, TypeError):
            continue
        at.append(place)
        found.append({name: value for name, (value, _, _) in own.items()})
    surfaces: dict[str, Callable[[Floats], float]] = {}
    for name in found[0] if found else ():
        surface = smooth(np.array(at), np.array([each[name] for each in found]))
        if surface is not None:
            surfaces[name] = surface

    def quantities(values: Mapping[str, float]) -> dict[str, float]:
        try:
            with_values(problem, values)
        except (ValueError, TypeError):
            return {}
        u = space.place(values)
        return {name: surface(u) for name, surface in surfaces.items()}

    return quantities


def smooth(places: Floats, values: Floats) -> Callable[[Floats], float] | None:
    """A thin plate spline near values at places, of their logarithm if none is negative; zeros are then left out.

    None if there are too few.

    Parameters
    ----------
    places : ndarray, shape (n, numbers)
    values : ndarray, shape (n,)
        NaN where there is none.

    Examples
    --------
    >>> u = np.linspace(0.0, 1.0, 9)[:, None]
    >>> surface = smooth(u, np.exp(3.0 * u[:, 0]))
    >>> float(round(surface(np.array([0.3])) / np.exp(0.9), 3))
    1.0
    """
    from scipy.interpolate import RBFInterpolator

    signed = bool((values < 0.0).any())
    known = np.isfinite(values) & (signed | (values > 0.0))
    if known.sum() < places.shape[1] + 2:
        return None
    heights = values[known] if signed else np.log(values[known])
    surface = RBFInterpolator(places[known], heights, kernel="thin_plate_spline", degree=1, smoothing=SMOOTHING)

    def at(u: Floats) -> float:
        height = float(surface(np.clip(u, 0.0, 1.0)[None, :])[0])
        return height if signed else math.exp(height)

    return at


def places_of(space: Space, seed: int) -> Floats:
    """The start, and places spread evenly (Sobol's sequence)."""
    from scipy.stats import qmc

    many = {1: 3, 2: 4, 3: 5}.get(len(space.free), 6)
    spread = qmc.Sobol(len(space.free), rng=seed).random_base2(many)
    return np.vstack([space.start, spread])
