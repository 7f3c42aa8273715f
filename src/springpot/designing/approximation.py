"""Quantities that are quick to compute, for a search: by one method of theory, or by surfaces through short runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from springpot.designing.quantities import MONTE_CARLO, chosen_method, if_allowed, samples_of, theory_values
from springpot.designing.search import DesignProgress
from springpot.designing.statement import Space
from springpot.designing.surfaces import surface_through
from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP, trust
from springpot.machine.arrays import Floats
from springpot.problem.free_numbers import with_values
from springpot.problem.outputs import output_squares
from springpot.problem.system import System
from springpot.simulation.plan.plan import check_stationary, plan_of
from springpot.theory.registry import METHODS

Quantities = Callable[[Mapping[str, float]], dict[str, float]]
"""From numbers by name to quantities by name; empty where there is no answer."""

PILOT_PATHS = 500  # where Monte Carlo takes the place of theory
LARGEST_GAP = 30.0  # per cent on the validity map, up to which a method leads a search
SECONDS_OF_A_RUN, SECONDS_OF_A_STEP = 0.05, 2e-8  # of a path; nominal, for a choice must not depend on the machine


def approximated(
    system: System, space: Space, places: Floats, method: str | None, needed: Sequence[str], seed: int,
    threads: int | None, work: DesignProgress,
) -> tuple[str, Quantities]:  # fmt: skip
    """The method of the search, and quantities by it.

    If ``method`` is None, one that is trusted and has the ``needed`` quantities: see `leading`.
    """
    work.step()
    if method is None:
        there = (if_allowed(lambda: _stationary(system, space.values(place))) for place in places)  # noqa: B023
        models = [model for model in there if model is not None]
        name = leading(models, needed, work)
    else:
        name = chosen_method(with_values(system, space.values(places[0])), method)[0]
    if name == MONTE_CARLO:
        forces = [of for square, of in output_squares(system).items() if square in needed]
        return name, _by_chance(system, space, places, seed, threads, work, forces)

    def by_theory(values: Mapping[str, float]) -> dict[str, float]:
        work.step()
        return if_allowed(lambda: theory_values(with_values(system, values), name, needed)[0]) or {}

    return name, by_theory


def leading(systems: Sequence[System], needed: Sequence[str], work: DesignProgress) -> str:
    """The method that may lead a search through all of these; Monte Carlo if there is none.

    It has the ``needed`` quantities, and is exact, or the validity map has cells near all of them, with gaps up to
    `LARGEST_GAP`, and an answer takes no longer than a short run.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, Springpot, WhiteNoise
    >>> work, held = DesignProgress(None, None, 1), (Spring(4.0), Springpot(0.5, 0.2), WhiteNoise(1.0))
    >>> [leading([System(*held, Barrier(-gap, 0.9))], (), work) for gap in (0.1, 5.0)]
    ['envelope', 'monte_carlo']
    """
    if not systems:
        return MONTE_CARLO

    def answers(name: str) -> bool:
        work.step()
        known = [theory_values(system, name, needed)[0] for system in systems[:4]]
        return all(known) and all(wanted in each for each in known for wanted in needed)

    for name in [name for name, method in METHODS.items() if method.exact][::-1]:  # the most exact first
        if answers(name):
            return name
    steps = plan_of(systems[0], paths=PILOT_PATHS).settings.steps
    run = SECONDS_OF_A_RUN + SECONDS_OF_A_STEP * PILOT_PATHS * steps
    worst = {}
    for name in dict.fromkeys((*PAPER_MAP.methods, *SYSTEMS_MAP.methods)):
        trusted = [trust(system, name) for system in systems] if METHODS[name].seconds <= run else []
        if trusted and all(each.judges and each.largest <= LARGEST_GAP for each in trusted):
            worst[name] = max(each.worst for each in trusted)
    return next((name for name in sorted(worst, key=lambda each: worst[each]) if answers(name)), MONTE_CARLO)


def _stationary(system: System, values: Mapping[str, float]) -> System:
    """The system with these numbers; a ValueError where there is no stationary state."""
    other = with_values(system, values)
    check_stationary(other, "design")
    return other


def _by_chance(
    system: System, space: Space, places: Floats, seed: int, threads: int | None, work: DesignProgress,
    forces: Sequence[str],
) -> Quantities:  # fmt: skip
    """Smooth surfaces through short runs at all places, on common random numbers."""
    settings = plan_of(system, paths=PILOT_PATHS, seed=seed, threads=threads).settings
    whole = float(len(places) * settings.paths * settings.steps)
    at, found = [], []
    for n, place in enumerate(places):

        def part(fraction: float, n: int = n) -> None:
            work.short_run(fraction, n, len(places), whole)

        own = if_allowed(
            lambda: samples_of(with_values(system, space.values(place)), settings, part, forces=forces)  # noqa: B023
        )
        if own is not None:
            at.append(place)
            found.append({name: value for name, (value, _, _) in own.items()})
    surfaces = smooth(np.array(at), {name: np.array([each[name] for each in found]) for name in (found or [{}])[0]})

    def quantities(values: Mapping[str, float]) -> dict[str, float]:
        work.step()
        return {} if if_allowed(lambda: with_values(system, values)) is None else surfaces(space.place(values))

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
