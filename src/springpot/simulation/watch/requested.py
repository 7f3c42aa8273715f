"""What a run is asked to observe: what every observer has, the list of them, and their results."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Self

from springpot.problem.messages import Message, say
from springpot.problem.system import System
from springpot.simulation.lowering.observers import Observer
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan, plan_of
from springpot.simulation.plan.settings import Settings

OBSERVERS = {
    "observables": ("observables.MeanOfOwn",),
    "impact_observables": ("observables.MeanOfOwn",),
    "distributions": ("distributions.Sketch", "extremes.Extremes"),
    "spectrum": ("spectrum.FourierSums",),
    "slowest_counted_impact": ("counted_impacts.CountedImpacts",),
    "forces": ("forces.Moments",),
    "profile": ("profiles.Bins", "profiles.PowersInBins"),
    "rainflow": ("rainflow.Cycles",),
    "first_passage": ("first_passage.FirstPassages",),
}
"""The arguments of `springpot.simulate` that ask for observers, and the classes of these in the files beside this one,
in the order of their results.

They are loaded where they are asked for: an ordinary run has none.
"""


Observed = Mapping[str, dict[str, Any]]
"""Results by what they are, and by name.

``means`` are those of functions of the user: of each path, over the window, or its sum over impacts per second;
``estimates`` all other numbers, each with its value and its samples, one per path; ``errors`` those that samples do not
tell, of impacts that were not seen.  All else is by the field of `springpot.simulation.Run` that has it.
"""


@dataclass(frozen=True, eq=False)
class Request(ABC):
    """Something that a run observes: how it is asked for, what the kernel calls, and how its arrays are read.

    Attributes
    ----------
    observers : tuple of Observer
        What the kernel calls.
    over_time : bool
        Whether a run from rest is observed from its beginning.
    counts_fast_impacts : bool
        Whether it counts those impacts that have a rate where all of them have none.
    """

    observers: tuple[Observer, ...]

    over_time: ClassVar[bool] = False
    counts_fast_impacts: ClassVar[bool] = False

    @classmethod
    @abstractmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[Self]:
        """What the arguments of `springpot.simulate` ask for, checked and compiled.

        Raises
        ------
        TypeError, ValueError
            One sentence, before any work.
        """

    @classmethod
    def longest_step(cls, motion: Motion, wishes: Mapping[str, Any]) -> float:
        """The longest step in s that resolves it; what is wrong with the wishes is not said here."""
        return math.inf

    @property
    def observer(self) -> Observer:
        """The only one."""
        (own,) = self.observers
        return own

    @abstractmethod
    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        """The results after a run."""

    def in_full(self, settings: Settings) -> bool:
        """Whether more is shown of what is seen than moments."""
        return False


@dataclass(frozen=True, eq=False)
class Requested:
    """All that a run is asked to observe, in the order of the results."""

    requests: tuple[Request, ...] = ()

    @property
    def observers(self) -> tuple[Observer, ...]:
        """What the kernel calls."""
        return tuple(observer for request in self.requests for observer in request.observers)

    @property
    def output_names(self) -> list[str]:
        """Forces and accelerations of which anything is wanted."""
        return _outputs(self.observers)

    def seen_in_full(self, settings: Settings) -> list[str]:
        """Those with more than moments."""
        return _outputs(own for each in self.requests if each.in_full(settings) for own in each.observers)

    def counts_instead(self, motion: Motion) -> bool:
        """Whether all that is asked of impacts without a rate is of those that are not slow, which have one."""
        counted = any(each.counts_fast_impacts for each in self.requests)
        return counted and not any(motion.is_undefined(observer.signal) for observer in self.observers)

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        """The results after a run."""
        found: dict[str, dict[str, Any]] = {"means": {}, "estimates": {}, "errors": {}}
        for request in self.requests:
            for kind, own in request.read(simulation, ensemble).items():
                found.setdefault(kind, {}).update(own)
        return found


def _outputs(observers: Iterable[Observer]) -> list[str]:
    signals = (observer.signal for observer in observers)
    return [*dict.fromkeys(own.names["x"] for own in signals if own.outputs and "x" in own.names)]


def _asked_for(arguments: Container[str]) -> list[type[Request]]:
    """The classes of observers that some arguments ask for."""
    places = dict.fromkeys(place for name, own in OBSERVERS.items() if name in arguments for place in own)
    found = (place.split(".") for place in places)
    return [getattr(import_module(f"springpot.simulation.watch.{module}"), name) for module, name in found]


def requested(plan: Plan, wishes: Mapping[str, Any]) -> Requested:
    """Check and compile the observers that some arguments of `springpot.simulate` ask for.

    Raises
    ------
    TypeError, ValueError
        One sentence, before the simulation: an invalid name or frequency, or a function that cannot be compiled.
    """
    found = Requested(tuple(request for kind in _asked_for(wishes) for request in kind.asked(plan, wishes)))
    if plan.settings.scheme == "grunwald" and any(observer.signal.outputs for observer in found.observers):
        raise ValueError("forces and accelerations are seen with the default scheme only: leave out scheme.")
    return found


def plan_for(system: System, options: Mapping[str, Any], wishes: Mapping[str, Any]) -> Plan:
    """The plan of a run; where its step is not given, it resolves what the run is asked for.

    Raises
    ------
    TypeError, ValueError
        Of `springpot.simulation.plan.plan.plan_of`.  What is wrong with the wishes is not said here.
    """
    plan = plan_of(system, **options)
    longest = min((kind.longest_step(plan.motion, wishes) for kind in _asked_for(wishes)), default=math.inf)
    if options.get("step") is None and plan.settings.step > longest:
        plan = plan_of(system, **{**options, "step": longest})
    return plan


def from_the_start(plan: Plan, wishes: Mapping[str, Any], window: object) -> tuple[Plan, list[Message]]:
    """The plan of a run with first passages or profiles: from rest the window is the whole run if none is given.

    Where the motion becomes stationary, one sentence says so: the means of the run are then others.
    """
    settings = plan.settings
    given = {name: wish for name, wish in wishes.items() if not isinstance(wish, Mapping) or wish}
    asked = [name for name in OBSERVERS if name in given and any(each.over_time for each in _asked_for([name]))]
    if not asked or window is not None or settings.start != "rest" or settings.window[0] == 0.0:
        return plan, []
    whole = plan.but(window=(0.0, settings.duration))
    if plan.motion.not_stationary:
        return whole, []
    begin, end = settings.window
    return whole, [say("window_from_rest", asked=" and ".join(f"{name}=" for name in asked), begin=begin, end=end)]
