"""Quantities that are quick to compute, for a search: by one method of theory, or by surfaces through short runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from springpot.designing.pooling import RoundValue
from springpot.designing.quantities import (
    MONTE_CARLO,
    chosen_method,
    if_allowed,
    if_stationary,
    samples_of,
    theory_values,
)
from springpot.designing.rounds import Simulated
from springpot.designing.search import Approximation, DesignProgress, Found
from springpot.designing.statement import Space
from springpot.designing.surfaces import surface_through
from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP, trust
from springpot.machine.arrays import Floats
from springpot.machine.progress import OutOfTimeError
from springpot.problem.free_numbers import with_values
from springpot.problem.outputs import output_squares
from springpot.problem.system import System
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.plan.plan import plan_of
from springpot.theory.registry import METHODS

Quantities = Callable[[Mapping[str, float]], dict[str, float]]
"""From numbers by name to quantities by name; empty where there is no answer."""

PILOT_PATHS = 500  # where Monte Carlo takes the place of theory
LARGEST_GAP = 30.0  # per cent on the validity map, up to which a method leads a search
_OF_RTOL = "rtol_not_reached", "uncontrolled_impacts"  # warnings of a run that a design has its own words for
SECONDS_OF_A_RUN, SECONDS_OF_A_STEP = 0.05, 2e-8  # of a path; nominal, for a choice must not depend on the machine


@dataclass(frozen=True, eq=False)
class OneDevice:
    """Quantities of a system with free numbers.

    Attributes
    ----------
    system : System
    names : tuple of str
        Of the quantities that are needed.
    threads : int or None
    """

    system: System
    names: tuple[str, ...]
    threads: int | None

    def quick(
        self, space: Space, places: Floats, method: str | None, seed: int, work: DesignProgress
    ) -> tuple[str, Quantities]:
        """The method of the search, and quantities by it.

        If ``method`` is None, one that is trusted and has the quantities: see `leading`.
        """
        work.step()
        system = self.system
        if method is None:
            models = [if_stationary(partial(with_values, system, space.values(place)), "design") for place in places]
            name = leading([model for model in models if model is not None], self.names, work)
        else:
            name = chosen_method(with_values(system, space.values(places[0])), method)[0]
        if name != MONTE_CARLO:

            def by_theory(values: Mapping[str, float]) -> dict[str, float]:
                work.step()
                return if_allowed(lambda: theory_values(with_values(system, values), name, self.names)[0]) or {}

            return name, by_theory
        forces = [of for square, of in output_squares(system).items() if square in self.names]
        settings = plan_of(system, paths=PILOT_PATHS, seed=seed, threads=self.threads).settings  # common random numbers

        def run(values: Mapping[str, float], progress: Progress) -> dict[str, float]:
            found = samples_of(with_values(system, values), settings, progress, forces=forces)
            return {name: value for name, (value, _, _) in found.items()}

        path_steps = float(len(places) * settings.paths * settings.steps)
        return name, by_short_runs(system, space, places, run, path_steps, work)

    def measured(
        self, approximation: Approximation, seeds: Sequence[int], work: DesignProgress
    ) -> Callable[[Found, float, int], Simulated]:
        """Monte Carlo of what a search found: every round has random numbers of its own."""

        def measure(found: Found, rtol: float, number: int) -> Simulated:
            work.round(number, 0.0)
            wanted: dict[str, Any] = {"quantities": self.names} if self.names else {}
            try:
                result = simulated(
                    with_values(self.system, found.values),
                    rtol=rtol, max_time=work.left, seed=seeds[number], threads=self.threads,
                    progress=lambda fraction: work.round(number, fraction), **wanted,
                )  # fmt: skip
            except TimeoutError:
                raise OutOfTimeError from None
            theory = approximation.at(found.u)
            measured = dict[str, RoundValue]()
            for name, own in result.estimates.items():
                if name not in theory and name not in self.names:
                    continue
                budget = own.budget
                bounds = (budget.step_bias, budget.memory_bias, budget.transient) if budget is not None else ()
                bias = math.hypot(*bounds) / math.sqrt(3.0)  # uniform between the bounds: the sd of GUM, type B
                measured[name] = RoundValue(found.u, theory.get(name, math.nan), own.value, own.error, bias)
            # what is controlled, and for how long, is the design's business
            return measured, tuple(each for each in result.warnings if getattr(each, "name", "") not in _OF_RTOL)

        return measure


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


def by_short_runs(
    system: System, space: Space, places: Floats, run: Callable[[dict[str, float], Progress], dict[str, float]],
    path_steps: float, work: DesignProgress,
) -> Quantities:  # fmt: skip
    """Smooth surfaces through what short runs give at all places that the parts allow.

    Parameters
    ----------
    system : System
    space : Space
    places : ndarray, shape (places, numbers)
    run : callable
        From the numbers of a place, and what is told the fraction done, to quantities.
    path_steps : float
        Of all runs.
    work : DesignProgress

    Raises
    ------
    TypeError, ValueError
        If no place is allowed.
    """
    at, found, faults = list[Floats](), list[dict[str, float]](), list[Exception]()
    for n, place in enumerate(places):

        def told(fraction: float, n: int = n) -> None:
            work.short_run(fraction, n, len(places), path_steps)

        try:
            found.append(run(space.values(place), told))
            at.append(place)
        except (TypeError, ValueError) as fault:
            faults.append(fault)
    if not found:
        raise faults[0]
    surfaces = smooth(np.array(at), {name: np.array([each[name] for each in found]) for name in found[0]})

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
