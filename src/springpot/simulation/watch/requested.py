"""Requests for observables, distributions, spectrum and first passages, and their results."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import few, shown
from springpot.problem.catalogue import possible_results, unit_of_result
from springpot.problem.messages import Message, say
from springpot.problem.system import System
from springpot.simulation.kernel.lanes import GROUP
from springpot.simulation.kernel.watching import Observer
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.paths.statistics import ratio
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.options import Observable
from springpot.simulation.plan.plan import MOST_RECORDED, Plan, plan_of
from springpot.simulation.plan.seen import Seen
from springpot.simulation.plan.settings import Settings

if TYPE_CHECKING:
    from springpot.simulation.watch.distributions import Distribution
    from springpot.simulation.watch.first_passage import Passage
    from springpot.simulation.watch.passage_times import PassagesOfLevels, PassageTimes
    from springpot.simulation.watch.profiles import Profile
    from springpot.simulation.watch.rainflow import Counted
    from springpot.simulation.watch.spectrum import Spectrum

# What each observer is made of is loaded where one is asked for: an ordinary run has none.

# Over the fastest rate: of cycles of a force, which behind a wall is as steep as an impact, and of laws of the speeds
# of impacts, of which the slowest lack most.
_FINE = 0.01


@dataclass(frozen=True, eq=False)
class Requested:
    """The observers of a run, compiled: the user's functions, then of each displacement sketches, extremes, spectra.

    Attributes
    ----------
    observables, impact_observables : dict
        Names and observers.
    sketches, extremes : tuple of (Seen, Observer)
        Of each displacement, or nothing.
    frequencies : ndarray
        In rad/s; empty without a spectrum.
    spectra : tuple of (Seen, Observer)
        Of each displacement, or nothing.
    passages : tuple of Passage
        Levels whose first passage is wanted.
    counted : dict of Observer
        Of the impacts that are not slow, by the wall; by an empty name on several walls of one mass; or nothing.
    edges : ndarray of int
        Ends of the bins of the profiles, in steps; empty without them.
    profiles : tuple of (Seen, Observer)
        Of each displacement, or nothing.
    powers : tuple of Observer
        Of the profiles of powers, once the kernel's parts are known.
    felt : tuple of (Seen, Observer)
        Of forces and accelerations.
    cycles : tuple of (Seen, tuple of Basquin, Observer)
        Of each displacement, force or acceleration whose cycles are counted.
    """

    observables: Mapping[str, Observer] = field(default_factory=dict)
    impact_observables: Mapping[str, Observer] = field(default_factory=dict)
    sketches: tuple[tuple[Seen, Observer], ...] = ()
    extremes: tuple[tuple[Seen, Observer], ...] = ()
    frequencies: Floats = field(default_factory=lambda: np.zeros(0))
    spectra: tuple[tuple[Seen, Observer], ...] = ()
    passages: tuple[Passage, ...] = ()
    counted: Mapping[str, Observer] = field(default_factory=dict)
    edges: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    profiles: tuple[tuple[Seen, Observer], ...] = ()
    powers: tuple[Observer, ...] = ()
    felt: tuple[tuple[Seen, Observer], ...] = ()
    cycles: tuple[Counted, ...] = ()

    @property
    def observers(self) -> tuple[Observer, ...]:
        """All observers, in the order in which `read` takes their results."""
        return (
            *self.observables.values(), *self.impact_observables.values(),
            *(observer for _, observer in (*self.sketches, *self.extremes, *self.spectra)),
            *(passage.observer for passage in self.passages), *self.counted.values(),
            *(observer for _, observer in (*self.felt, *self.profiles)), *self.powers,
            *(observer for *_, observer in self.cycles),
        )  # fmt: skip

    def seen_in_full(self, settings: Settings) -> list[str]:
        """Forces and accelerations with more than moments."""
        whole = {*(seen.feels for seen, _ in self.sketches), *(seen.feels for seen, _ in self.profiles)}
        return [seen.names["x"] for seen, _ in self.felt if seen.feels and (settings.record or seen.feels in whole)]

    @property
    def felt_names(self) -> list[str]:
        """Forces and accelerations of which anything is wanted."""
        seen = [own for own, _ in (*self.sketches, *self.spectra, *self.felt, *self.profiles)]
        seen += [own for own, _, _ in self.cycles]
        names = [*(own.names["x"] for own in seen if own.feels), *(passage.quantity for passage in self.passages)]
        return [*dict.fromkeys(names)]

    def counts_instead(self, motion: Motion) -> bool:
        """Whether all that is asked of impacts without a rate is of those that are not slow, which have one."""
        return bool(self.counted) and not any(motion.is_undefined(seen) for seen, _ in self.felt)

    def completed(self, simulation: Simulation) -> Requested:
        """With the powers of the profiles, whose factors are those of the kernel's parts."""
        if not self.edges.size:
            return self
        from springpot.simulation.watch.profiles import powers_of

        powers = powers_of(simulation.parts, simulation.motion, self.edges, simulation.settings)
        return replace(self, powers=(powers,))

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        """The results of the observers after a run."""
        if not self.observers:
            return Observed()
        from springpot.simulation.watch.distributions import distributions_in
        from springpot.simulation.watch.first_passage import passage_times
        from springpot.simulation.watch.observables import extremes_in
        from springpot.simulation.watch.profiles import Profile, powers_in, profiles_in
        from springpot.simulation.watch.rainflow import fatigue_in
        from springpot.simulation.watch.spectrum import spectrum_in

        left, settings = iter(ensemble.observed), simulation.settings
        low, high = settings.window_steps
        time = (high - low) * settings.step
        means = {name: next(left)[:, 0] / (high - low) for name in self.observables}
        means |= {name: next(left)[:, 0] / time for name in self.impact_observables}
        distributions: dict[str, Distribution] = {}
        for seen, observer in self.sketches:
            counts = next(left)
            if simulation.motion.is_undefined(seen):
                counts = np.zeros_like(counts)
            distributions |= distributions_in(simulation, observer, seen, counts)
        largest: dict[str, Floats] = {}
        for seen, _ in self.extremes:
            largest |= extremes_in(seen, next(left))
        spectra = {
            seen.names["x"]: spectrum_in(self.frequencies, settings, next(left), observer.every)
            for seen, observer in self.spectra
        }
        passed = passage_times(simulation, self.passages, [next(left) for _ in self.passages])
        counted = _counted({wall: next(left)[:, :3] for wall in self.counted}, time)
        for seen, _ in self.felt:
            counted |= moments_felt(simulation, seen, next(left))
        columns = dict[str, tuple[Floats, Floats, Floats]]()
        for seen, _ in self.profiles:
            columns |= profiles_in(simulation.motion, settings, seen, self.edges, next(left))
        for _ in self.powers:
            columns |= powers_in(simulation.parts, simulation.motion, settings, self.edges, next(left))
        system = simulation.plan.system
        profiles = {name: Profile(*own, unit_of_result(system, name)) for name, own in columns.items()}
        for each in self.cycles:
            fatigue, more = fatigue_in(simulation, each, next(left), next(left))
            counted, distributions = counted | fatigue, distributions | more
        felt = {seen.names["x"]: seen.feels[0] for seen, _ in self.felt if seen.feels}
        recorded = {name: ensemble.felt[number] for name, number in felt.items() if settings.record}
        return Observed(means, distributions, largest, spectra, passed, counted, profiles, recorded)


def moments_felt(simulation: Simulation, seen: Seen, sums: Floats) -> dict[str, tuple[float, Floats]]:
    """Mean and mean square of a force or acceleration, with what the latter lacks; or of what impacts have.

    The mean force of a contact is among the results of every run, by its momentum.
    """
    (name,), (low, high) = seen.names.values(), simulation.settings.window_steps
    means = sums / (high - low)
    if simulation.motion.is_undefined(seen):
        means = np.full_like(means, np.nan)
    if not seen.feels:
        return {f"{name}_{end}": ratio(means[:, n], means[:, 0]) for n, end in ((1, "mean"), (2, "mean_square"))}
    mean, square = means[:, 0], means[:, 1] + simulation.parts.felt.lacking[name]
    found = {f"{name}_mean": (float(mean.mean()), mean), f"{name}_mean_square": (float(square.mean()), square)}
    return {own: each for own, each in found.items() if own not in possible_results(simulation.motion.system)}


def _counted(sums: dict[str, Floats], time: float) -> dict[str, tuple[float, Floats]]:
    """COUNTED of each wall and of all together, from numbers, speeds and squares of each path."""
    if sums and "" not in sums:
        sums = {"": sum(sums.values(), np.zeros(3)), **sums}
    from springpot.simulation.watch.observables import COUNTED

    found: dict[str, tuple[float, Floats]] = {}
    for wall, columns in sums.items():
        number, speeds, squares = columns.T
        rate = number / time
        of_fast = (float(rate.mean()), rate), ratio(speeds, number), ratio(squares, number)
        found |= {f"{wall}_{name}" if wall else name: each for name, each in zip(COUNTED, of_fast, strict=True)}
    return found


@dataclass(frozen=True, eq=False)
class Observed:
    """Results of the observers of a run.

    Attributes
    ----------
    means : dict
        Samples of each observable, one per path: its mean over the window, or its sum over impacts per second.
    distributions : dict
    extremes : dict
    spectra : dict
    first_passages : dict
        As in `springpot.simulation.Run`.
    counted_impacts : dict
        Value and samples of each of `springpot.simulation.watch.observables.COUNTED`, also of each wall,
        and of the moments of forces and accelerations, and of cycles and damage, if they were asked for.
    profiles, forces : dict
        As in `springpot.simulation.Run`.
    """

    means: dict[str, Floats] = field(default_factory=dict)
    distributions: dict[str, Distribution] = field(default_factory=dict)
    extremes: dict[str, Floats] = field(default_factory=dict)
    spectra: dict[str, Spectrum] = field(default_factory=dict)
    first_passages: dict[str, PassageTimes | PassagesOfLevels] = field(default_factory=dict)
    counted_impacts: dict[str, tuple[float, Floats]] = field(default_factory=dict)
    profiles: dict[str, Profile] = field(default_factory=dict)
    forces: dict[str, Floats] = field(default_factory=dict)


def from_the_start(plan: Plan, wanted: Sequence[str], window: object) -> tuple[Plan, list[Message]]:
    """The plan of a run with first passages or profiles: from rest the window is the whole run if none is given.

    Where the motion becomes stationary, one sentence says so: the means of the run are then others.
    """
    settings = plan.settings
    if not wanted or window is not None or settings.start != "rest" or settings.window[0] == 0.0:
        return plan, []
    whole = plan.but(window=(0.0, settings.duration))
    if plan.motion.not_stationary:
        return whole, []
    begin, end = settings.window
    return whole, [say("window_from_rest", asked=" and ".join(f"{name}=" for name in wanted), begin=begin, end=end)]


def requested(
    plan: Plan,
    *,
    observables: Mapping[str, Observable] | None = None,
    impact_observables: Mapping[str, Observable] | None = None,
    distributions: bool = False,
    spectrum: npt.ArrayLike | None = None,
    first_passage: Mapping[str, Any] | None = None,
    slowest_counted_impact: float | None = None,
    profile: Any = None,
    forces: Sequence[str] | None = None,
    rainflow: Any = None,
) -> Requested:
    """Check and compile the requested observers.

    Raises
    ------
    TypeError, ValueError
        One sentence, before the simulation: an invalid name or frequency, or a function that cannot be compiled.
    """
    from springpot.simulation.watch.distributions import sketches
    from springpot.simulation.watch.first_passage import checked
    from springpot.simulation.watch.observables import extremes, is_taken, mean_of, of_impacts, squares
    from springpot.simulation.watch.profiles import checked_edges, profile_of
    from springpot.simulation.watch.rainflow import wanted_cycles
    from springpot.simulation.watch.spectrum import checked_frequencies, spectral

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
    settings, motion, fastest = plan.settings, plan.motion, plan.motion.scales.fastest_rate
    felt = () if forces is None else _felt(plan, forces)
    counted = (*motion.seen, *felt) if distributions else ()
    moving = () if spectrum is None else tuple(seen for seen in (*motion.seen, *felt) if "x" in seen.names)
    moved = () if profile is None else (*motion.seen, *(seen for seen in felt if seen.feels))
    fast = () if profile is None or slowest_counted_impact is None else motion.speeds.items()
    edges = np.zeros(0, np.int64) if profile is None else checked_edges(profile, settings, len(moved) + len(fast) + 1)
    frequencies = np.zeros(0) if spectrum is None else checked_frequencies(spectrum, settings, fastest, len(moving))
    wanted = Requested(
        observables={name: mean_of(motion, name, function, "state") for name, function in state.items()},
        impact_observables={name: mean_of(motion, name, function, "impact") for name, function in impact.items()},
        sketches=tuple((seen, sketches(seen, GROUP * settings.step * fastest)) for seen in counted),
        extremes=tuple((seen, extremes(seen)) for seen in counted),
        frequencies=frequencies,
        spectra=tuple((seen, spectral(seen, frequencies, settings, fastest)) for seen in moving),
        passages=checked(plan, first_passage),
        counted={} if slowest_counted_impact is None else _fast(plan, slowest_counted_impact),
        edges=edges,
        profiles=(
            *((seen, profile_of(seen, edges, settings)) for seen in moved),
            *(
                (seen, profile_of(seen, edges, settings, float(slowest_counted_impact or 0.0)))
                for seen in (_counted_of(name, own) for name, own in fast)
            ),
        ),
        felt=tuple((seen, squares(seen) if seen.feels else of_impacts(seen)) for seen in felt),
        cycles=wanted_cycles(motion, rainflow),
    )
    if settings.scheme == "grunwald" and any(each.feels for each in wanted.observers):
        raise ValueError("forces and accelerations are seen with the default scheme only: leave out scheme.")
    return wanted


def plan_for(system: System, options: Mapping[str, Any], wishes: Mapping[str, Any]) -> Plan:
    """The plan of a run; where its step is not given, it resolves what the run is asked for.

    Raises
    ------
    TypeError, ValueError
        Of `springpot.simulation.plan.plan.plan_of`.  What is wrong with the wishes is not said here.
    """
    plan = plan_of(system, **options)
    if options.get("step") is None and plan.settings.step > (longest := _longest_step(plan.motion, wishes)):
        plan = plan_of(system, **{**options, "step": longest})
    return plan


def _longest_step(motion: Motion, wishes: Mapping[str, Any]) -> float:
    fastest, steps = motion.scales.fastest_rate, [math.inf]
    if "spectrum" in wishes:
        from springpot.simulation.watch.spectrum import step_for

        with contextlib.suppress(TypeError, ValueError):
            steps.append(step_for(max(fastest, *map(float, wishes["spectrum"]))))
    cycles = wishes.get("rainflow")
    of_forces = isinstance(cycles, Mapping) and any(name in motion.felt for name in cycles)
    if of_forces or (motion.crowded and "distributions" in wishes):
        steps.append(_FINE / fastest)
    return min(steps)


def _felt(plan: Plan, names: Sequence[str]) -> tuple[Seen, ...]:
    motion, settings = plan.motion, plan.settings
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise TypeError(
            f"forces must be a list of names of forces and accelerations, not {shown(names)}: "
            f"{few(motion.seen_by_force)}."
        )
    found = [motion.seen_by_name(name, "forces", forces_only=True) for name in names]
    found = [*{(*seen.names.values(),): seen for seen in found}.values()]
    points = settings.record * settings.recorded_points * sum(bool(seen.feels) for seen in found)
    if points > MOST_RECORDED:
        raise ValueError(
            f"record asks for {points:,} points of forces, but at most {MOST_RECORDED:,} are stored: use a larger "
            "record_every."
        )
    return tuple(found)


def _counted_of(name: str, seen: Seen) -> Seen:
    """The same impacts, by the name of those that are not slow."""
    return replace(seen, names={"counted_impact_speed": f"{name.removesuffix('impact_speed')}counted_impact_speed"})


def _fast(plan: Plan, slowest: float) -> dict[str, Observer]:
    if not plan.motion.touched:
        raise ValueError("slowest_counted_impact needs a wall or a contact: there are no impacts to count.")
    from springpot.simulation.watch.observables import faster_than

    speed = finite_number(slowest, "slowest_counted_impact", low=0.0, hint="It is a speed in m/s.")
    # of all walls of one mass together they are added in the order of the impacts
    together = [""] if len(plan.motion.touched) > 1 and not plan.motion.arguments else []
    return {wall: faster_than(speed, wall) for wall in (*together, *plan.motion.touched)}
