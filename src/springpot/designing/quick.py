"""Quantities that are quick to compute, for a search: by one method of theory, or by surfaces through short runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from springpot.designing.numbers import as_simulated
from springpot.designing.quantities import MONTE_CARLO, chosen_method, theory_values
from springpot.designing.samples import samples_of
from springpot.designing.statement import Space
from springpot.designing.surfaces import surface_through
from springpot.faults import NotCovered
from springpot.free_numbers import with_values
from springpot.oscillator import Oscillator
from springpot.simulation.settings import resolve
from springpot.system import System

__all__ = ["places_of", "quick_quantities", "smooth"]

Floats = NDArray[np.float64]

PILOT_PATHS = 500  # where Monte Carlo takes the place of theory


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
    surfaces = smooth(np.array(at), {name: np.array([each[name] for each in found]) for name in (found or [{}])[0]})

    def quantities(values: Mapping[str, float]) -> dict[str, float]:
        try:
            with_values(problem, values)
        except (ValueError, TypeError):
            return {}
        return surfaces(space.place(values))

    return quantities


def smooth(places: Floats, values: Mapping[str, Floats]) -> Callable[[Floats], dict[str, float]]:
    """Splines near values at places, of their logarithms if none is negative; zeros are then left out.

    Parameters
    ----------
    places : ndarray, shape (n, numbers)
        Between 0 and 1.
    values : dict of ndarray, shape (n,)
        By name, NaN where there is none; a name with too few has no surface.

    Examples
    --------
    >>> u = np.linspace(0.0, 1.0, 9)[:, None]
    >>> surfaces = smooth(u, {"rate": np.exp(3.0 * u[:, 0])})
    >>> round(surfaces(np.array([0.3]))["rate"] / float(np.exp(0.9)), 3)
    1.0
    """
    together: dict[bytes, list[str]] = {}  # those that are known at the same places
    for name, own in values.items():
        known = np.isfinite(own) & (_is_signed(own) | (own > 0.0))
        if known.sum() >= places.shape[1] + 2:
            together.setdefault(known.tobytes(), []).append(name)
    surfaces = []
    for key, names in together.items():
        kept = np.frombuffer(key, np.bool_)
        surfaces.append((names, surface_through(
            places[kept], np.stack([values[name][kept] for name in names], axis=-1), np.zeros(places.shape[1]),
            np.ones(places.shape[1]), form="spline",
            logarithmic=np.array([not _is_signed(values[name]) for name in names]),
        )))  # fmt: skip

    def at(u: Floats) -> dict[str, float]:
        inside = np.clip(u, 0.0, 1.0)
        return {name: value for names, own in surfaces for name, value in zip(names, own(inside).tolist(), strict=True)}

    return at


def _is_signed(values: Floats) -> bool:
    return bool((values < 0.0).any())


def places_of(space: Space, seed: int) -> Floats:
    """The start, and places spread evenly (Sobol's sequence)."""
    from scipy.stats import qmc

    many = {1: 3, 2: 4, 3: 5}.get(len(space.free), 6)
    spread = qmc.Sobol(len(space.free), rng=seed).random_base2(many)
    return np.vstack([space.start, spread])
