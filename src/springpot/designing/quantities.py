"""Quantities by name: the moments of one method of theory, or the results of a run with the samples of each path.

Runs of one seed, step and duration have the same normals in path n, whatever the numbers of the model are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from springpot.evidence.recommendation import recommended
from springpot.machine.arrays import Floats
from springpot.machine.faults import known_word
from springpot.problem.outputs import output_squares
from springpot.problem.system import System
from springpot.simulation.estimate import samples as estimate
from springpot.simulation.estimate.stationary_start import ENOUGH_PATHS, adapt, pilot_paths
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import Plan, check_stationary
from springpot.simulation.plan.settings import Settings
from springpot.simulation.watch.distributions import Distribution, Sketch
from springpot.simulation.watch.forces import Moments
from springpot.simulation.watch.requested import Requested
from springpot.theory import NotCoveredError, solve_all, solve_one
from springpot.theory.methods.systems.linear import LinearResponse
from springpot.theory.registry import METHODS

Answer = TypeVar("Answer")

MONTE_CARLO = "monte_carlo"


def theory_values(system: System, method: str, outputs: Collection[str] = ()) -> tuple[dict[str, float], str]:
    """Every moment of one method that is a number, by name; and why there is none.

    ``outputs``: the names among `output_squares` that are wanted too.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Dashpot, Spring, WhiteNoise
    >>> system = System(Spring(1.0), Dashpot(0.5), Barrier(0.0), WhiteNoise(1.0))
    >>> theory_values(system, "envelope")[0]["impact_rate"] > 0.1
    True
    """
    result, statement = solve_one(system, method)
    if result is None:
        return {}, statement
    found = {name: float(value) for name, value in result.numbers.items() if not math.isnan(value)}
    if isinstance(result, LinearResponse):
        try:
            found |= {name: result.mean_square(of) for name, of in output_squares(system).items() if name in outputs}
        except NotCoveredError as refusal:
            return {}, str(refusal)
    return found, ""


def if_allowed(ask: Callable[[], Answer]) -> Answer | None:
    """What a function gives; None where a part refuses its number, or a method does not cover a system.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> if_allowed(lambda: Spring(2.0)), if_allowed(lambda: Spring(float("nan")))
    (Spring(stiffness=2.0), None)
    """
    try:
        return ask()
    except (ValueError, TypeError):
        return None


def if_stationary(make: Callable[[], System], what: str) -> System | None:
    """A system; None where its parts do not allow its numbers, or it has no stationary state."""
    try:
        check_stationary(found := make(), what)
    except (ValueError, TypeError):
        return None
    return found


def chosen_method(system: System, method: str | None) -> tuple[str, str]:
    """The method to use, and one sentence if it is not a recommended one.

    Parameters
    ----------
    system : System
    method : str or None
        ``"theory"``: the recommended method, or the best guess.  ``"monte_carlo"``, or the name of a method, is used as
        it is.  None: the recommended method, or Monte Carlo.

    Raises
    ------
    ValueError
        If there is no such method, or no theory has an answer.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> chosen_method(System(Spring(1.0)), "envelope")
    ('envelope', '')
    """
    known = [*METHODS, "theory", MONTE_CARLO]
    if method is not None:
        known_word(method, known, "method")
    if method not in (None, "theory"):
        return str(method), ""
    answers, statements = solve_all(system)
    best = recommended(system, answers)
    if best.method:
        return best.method, ""
    if method is None:
        return MONTE_CARLO, ""
    if not answers:
        reason = next(iter(statements.values()), "")
        raise ValueError(f"method 'theory' has no answer for this problem: {reason}")
    guess = best.guess or next(iter(answers))
    return guess, f"{guess} is a guess: {best.why_none}"


@dataclass(frozen=True, eq=False)
class SampledRun:
    """Results of one run.

    Attributes
    ----------
    samples : dict
        Value and samples of every result, one sample per path; their mean is the value.
    start : dict
        The standard error that each value has from the error of the stationary start.
    distributions : dict of Distribution
        Of x, v, amplitude and impact speed, if they were asked for; otherwise empty.
    """

    samples: dict[str, tuple[float, Floats]]
    start: Mapping[str, float]
    distributions: Mapping[str, Distribution]


def sampled_run(
    plan: Plan, *, distributions: bool = False, forces: Sequence[str] = (), progress: Progress | None = None
) -> SampledRun:
    """Run a system.

    Parameters
    ----------
    plan : Plan
        Pilot runs find its stationary start where it has none yet.
    distributions : bool
    forces : sequence of str
        As in `springpot.simulate`.
    progress : callable
        Called with the fraction of this run.

    Returns
    -------
    SampledRun

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring, WhiteNoise
    >>> from springpot.simulation.plan.plan import plan_of
    >>> system = System(Spring(1.0), Dashpot(0.5), WhiteNoise(1.0))
    >>> found = sampled_run(plan_of(system, paths=64, duration=20.0, seed=1, threads=1))
    >>> value, samples = found.samples["x_mean_square"]
    >>> samples.size, bool(abs(samples.mean() - value) < 1e-12)
    (64, True)
    """
    if plan.adapted is None:  # runs are compared, and the error of x(0) is not the same in both
        plan = adapt(plan, paths=pilot_paths(max(plan.settings.paths, ENOUGH_PATHS)), progress=progress)
    simulation = simulation_of(plan)
    sketches = [Sketch.of(signal, plan.motion, plan.settings) for signal in plan.motion.signals if distributions]
    outputs = [plan.motion.signal_by_name(name, "forces", forces_only=True) for name in forces]
    wanted = Requested((*sketches, *map(Moments.of, outputs)))
    ensemble = simulation.advance(observers=wanted.observers, progress=progress)
    samples, observed = estimate.samples_of(simulation, ensemble.rows), wanted.read(simulation, ensemble)
    start = estimate.errors_of_the_start(plan, {name: value for name, (value, _) in samples.items()})
    return SampledRun({**samples, **observed["estimates"]}, start, observed.get("distributions", {}))


def samples_of(
    system: System,
    settings: Settings,
    progress: Progress | None = None,
    done: int = 0,
    runs: int = 1,
    forces: Sequence[str] = (),
) -> dict[str, tuple[float, Floats, float]]:
    """Value, samples path by path and error of the start of every result; ``done`` of ``runs`` runs are done."""
    part = None if progress is None else (lambda fraction: progress((done + fraction) / runs))
    run = sampled_run(Plan(motion_of(system), settings), forces=forces, progress=part)
    return {name: (value, own, run.start.get(name, 0.0)) for name, (value, own) in run.samples.items()}
