"""Requests for observables, distributions, spectrum and first passages, and their results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import finite_number
from springpot.machine.faults import shown
from springpot.simulation.kernel.lanes import GROUP
from springpot.simulation.kernel.watching import Observer
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.paths.statistics import ratio
from springpot.simulation.plan.options import Observable
from springpot.simulation.plan.plan import Plan, check_observed
from springpot.simulation.watch.distributions import Distribution, distributions_in, sketches
from springpot.simulation.watch.first_passage import Passage, checked, passage_times
from springpot.simulation.watch.observables import COUNTED, EXTREMES, extremes, faster_than, is_taken, mean_of
from springpot.simulation.watch.passage_times import PassageTimes
from springpot.simulation.watch.spectrum import Spectrum, checked_frequencies, spectral, spectrum_in

__all__ = ["Observed", "Requested", "requested"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Requested:
    """The observers of a run, compiled: the user's functions, then sketches and extremes, then the spectrum.

    Attributes
    ----------
    observables, impact_observables : dict
        Names and observers.
    distributions : tuple of Observer
        Sketches and extremes, or nothing.
    frequencies : ndarray
        In rad/s; empty without a spectrum.
    spectrum : tuple of Observer
        One, or nothing.
    passages : tuple of Passage
        Levels whose first passage is wanted.
    counted : tuple of Observer
        Of the impacts that are not slow, or nothing.
    """

    observables: Mapping[str, Observer]
    impact_observables: Mapping[str, Observer]
    distributions: tuple[Observer, ...]
    frequencies: Floats
    spectrum: tuple[Observer, ...]
    passages: tuple[Passage, ...] = ()
    counted: tuple[Observer, ...] = ()

    @property
    def observers(self) -> tuple[Observer, ...]:
        """All observers, in the order in which `read` takes their results."""
        return (
            *self.observables.values(), *self.impact_observables.values(), *self.distributions, *self.spectrum,
            *(passage.observer for passage in self.passages), *self.counted,
        )  # fmt: skip

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        """The results of the observers after a run."""
        left, settings = iter(ensemble.observed), simulation.settings
        low, high = settings.window_steps
        means = {name: next(left)[:, 0] / (high - low) for name in self.observables}
        means |= {name: next(left)[:, 0] / ((high - low) * settings.step) for name in self.impact_observables}
        counted: dict[str, Distribution] = {}
        per_path: dict[str, Floats] = {}
        if self.distributions:
            counted = distributions_in(simulation, next(left))
            largest = next(left)
            # without an impact the largest impact speed is NaN
            per_path = dict(zip(EXTREMES, np.where(np.isfinite(largest), largest, np.nan).T, strict=True))
        spectrum = None
        if self.spectrum:
            spectrum = spectrum_in(self.frequencies, settings, next(left), self.spectrum[0].every)
        passed = {each.quantity: passage_times(simulation, each, next(left)) for each in self.passages}
        if self.counted:
            number, speeds, squares, _ = next(left).T
            rate = number / ((high - low) * settings.step)
            of_fast = (float(rate.mean()), rate), ratio(speeds, number), ratio(squares, number)
            return Observed(means, counted, per_path, spectrum, passed, dict(zip(COUNTED, of_fast, strict=True)))
        return Observed(means, counted, per_path, spectrum, passed)


@dataclass(frozen=True, eq=False)
class Observed:
    """Results of the observers of a run.

    Attributes
    ----------
    means : dict
        Samples of each observable, one per path: its mean over the window, or its sum over impacts per second.
    distributions : dict
    extremes : dict
    spectrum : Spectrum or None
    first_passages : dict
        As in `springpot.simulation.Run`.
    counted_impacts : dict
        Value and samples of each of `springpot.simulation.watch.observables.COUNTED`, if they were asked for.
    """

    means: dict[str, Floats]
    distributions: dict[str, Distribution] = field(default_factory=dict)
    extremes: dict[str, Floats] = field(default_factory=dict)
    spectrum: Spectrum | None = None
    first_passages: dict[str, PassageTimes] = field(default_factory=dict)
    counted_impacts: dict[str, tuple[float, Floats]] = field(default_factory=dict)


def requested(
    plan: Plan,
    *,
    observables: Mapping[str, Observable] | None = None,
    impact_observables: Mapping[str, Observable] | None = None,
    distributions: bool = False,
    spectrum: npt.ArrayLike | None = None,
    first_passage: Mapping[str, Any] | None = None,
    slowest_counted_impact: float | None = None,
) -> Requested:
    """Check and compile the requested observers.

    Raises
    ------
    TypeError, ValueError
        One sentence, before the simulation: an invalid name or frequency, or a function that cannot be compiled.
    """
    asked = {"observables": observables, "impact_observables": impact_observables, "distributions": distributions,
             "spectrum": spectrum is not None, "first_passage": first_passage,
             "slowest_counted_impact": slowest_counted_impact is not None}  # fmt: skip
    for name in (name for name, given in asked.items() if given):
        check_observed(plan.motion, name)
    state, impact = {} if observables is None else observables, {} if impact_observables is None else impact_observables
    for name, given in (("observables", state), ("impact_observables", impact)):
        if not isinstance(given, Mapping):
            raise TypeError(f"{name} must be a dict of names and functions, not {shown(given)}.")
    for name in (*state, *impact):
        if isinstance(name, str) and is_taken(plan.system, name):
            raise ValueError(f"an observable cannot be called {name!r}: the run already has a result of that name.")
    if both := [name for name in state if name in impact]:
        raise ValueError(f"{both[0]!r} cannot name an observable and an impact observable at once.")
    if not isinstance(distributions, bool):
        raise TypeError(f"distributions must be True or False, not {shown(distributions)}.")
    settings, fastest = plan.settings, plan.motion.scales.fastest_rate
    frequencies = np.zeros(0) if spectrum is None else checked_frequencies(spectrum, settings, fastest)
    return Requested(
        observables={name: mean_of(name, function, "state") for name, function in state.items()},
        impact_observables={name: mean_of(name, function, "impact") for name, function in impact.items()},
        distributions=(sketches(GROUP * settings.step * fastest), extremes()) if distributions else (),
        frequencies=frequencies,
        spectrum=() if spectrum is None else (spectral(frequencies, settings, fastest),),
        passages=checked(plan, first_passage),
        counted=() if slowest_counted_impact is None else (faster_than(_speed(plan, slowest_counted_impact)),),
    )


def _speed(plan: Plan, slowest: float) -> float:
    if not plan.motion.touched:
        raise ValueError("slowest_counted_impact needs a wall or a contact: there are no impacts to count.")
    return finite_number(slowest, "slowest_counted_impact", low=0.0, hint="It is a speed in m/s.")
