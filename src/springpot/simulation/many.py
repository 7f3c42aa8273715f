"""`simulate_many`: simulations of many systems at once, each with the numbers that `simulate` gives it alone."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate
from typing import Any, Concatenate, ParamSpec

from springpot.machine.faults import shown
from springpot.problem.system import System, checked_system
from springpot.simulation.monte_carlo import Arguments, arguments_of, door, planned, run_to, simulate
from springpot.simulation.paths.simulation import Ensemble, Progress
from springpot.simulation.paths.together import advance_together
from springpot.simulation.result.results import Run

P = ParamSpec("P")


def _of_many(
    one: Callable[Concatenate[System, P], Run],
) -> Callable[[Callable[..., list[Run]]], Callable[Concatenate[Iterable[System], P], list[Run]]]:
    """Give a function the signature of that of one system, also for help and completion."""
    own = inspect.signature(one)
    first, *others = own.parameters.values()
    systems = first.replace(name="systems", annotation="Iterable[System]")

    def signed(many: Callable[..., list[Run]]) -> Callable[Concatenate[Iterable[System], P], list[Run]]:
        many.__signature__ = own.replace(  # type: ignore[attr-defined]
            parameters=[systems, *others], return_annotation="list[Run]"
        )
        return many

    return signed


@door
@_of_many(simulate)
def simulate_many(systems: Iterable[System], **given: Any) -> list[Run]:
    """Monte Carlo of many systems, with the same settings: the runs that `springpot.simulate` gives of each, together.

    All systems share the threads, and those of one structure (the same parts, with other numbers) the calls of the
    compiled code, so that many systems of few paths keep all threads busy.

    Parameters
    ----------
    systems : sequence of System
        They may differ in all numbers and in all parts.
    paths, duration, step, window, seed, threads, scheme, start, derivative : optional
        As in `springpot.simulate`, for each of the systems.  What is left out, such as the step, is chosen for each.
    initial_position, initial_velocity, memory_tolerance, contact_tolerance : optional
        The same.
    rtol, quantities, max_time : optional
        The same; ``max_time`` is that of each system.  One system runs after another, on all threads.
    record, record_every : optional
        The same.  With a record too one system runs after another, and so do systems with a function of your own.
    observables, impact_observables, distributions, spectrum, first_passage, slowest_counted_impact : optional
        The same, one system after another.
    profile, forces, rainflow : optional
        The same, one system after another.
    progress : callable
        Called with the fraction done of all systems, from any thread.

    Returns
    -------
    list of Run
        In the order of the systems.  Each has the bits that it has alone: with one ``seed`` all systems have the same
        random numbers, so that their differences are known better than the results themselves.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, for any of the systems; nothing has been computed then.  A note of the exception says
        of which system it is.

    Warns
    -----
    SpringpotWarning
        For each sentence of ``warnings`` of each run.

    See Also
    --------
    springpot.simulate : One system; says all of the arguments and results.
    springpot.study : A grid of systems, in a store on disk that a run goes on from.

    Examples
    --------
    What a gap changes, with the same excitation for all gaps:

    >>> import springpot as sp
    >>> def device(gap):
    ...     return sp.System(sp.Mass(0.2), sp.Spring(80.0), sp.Springpot(0.5, 1.2), sp.WhiteNoise(1e-3),
    ...                      stop=sp.Barrier(-gap, restitution=0.8))
    >>> runs = sp.simulate_many([device(gap) for gap in (0.001, 0.002, 0.004)], paths=64, duration=10.0, step=0.002)
    >>> rates = [run["stop_impact_rate"].value for run in runs]
    >>> rates[0] > rates[1] > rates[2]
    True
    """
    return _simulated(_checked(systems), arguments_of(given))


def _checked(systems: Iterable[System]) -> list[System]:
    if isinstance(systems, str) or not isinstance(systems, Iterable):
        raise TypeError(f"systems must be a list of systems, not {shown(systems)}.")
    return [checked_system(system, f"systems[{number}]") for number, system in enumerate(systems)]


def _simulated(systems: Sequence[System], arguments: Arguments) -> list[Run]:
    def each(do: Callable[[int], Any]) -> list[Any]:
        return [_noted(do, number) for number in range(len(systems))]

    if arguments.rtol is not None:
        shares = _shares(arguments.progress, [1.0] * len(systems))
        return each(lambda number: run_to(systems[number], replace(arguments, progress=shares[number])))
    plans = each(lambda number: planned(systems[number], arguments))
    [begun] = _shares(arguments.progress, [0.0])
    ready = each(lambda number: plans[number].ready(begun))
    # the paths of each system, and the seconds that they took: of those together each has its part
    work = [float(each.simulation.settings.paths) * each.simulation.settings.steps for each in ready]
    alone = [number for number, each in enumerate(ready) if each.is_alone]
    others = sorted({*range(len(ready))} - {*alone})
    shared = sum(work[number] for number in others)
    told, *tellers = _shares(arguments.progress, [shared, *(work[number] for number in alone)])
    flown, begun_at = dict[int, tuple[Ensemble, float]](), time.perf_counter()
    ensembles = advance_together([ready[number].simulation for number in others], told)
    seconds = time.perf_counter() - begun_at
    for number, ensemble in zip(others, ensembles, strict=True):
        flown[number] = ensemble, seconds * work[number] / shared
    for number, tell in zip(alone, tellers, strict=True):
        begun_at = time.perf_counter()
        ensemble = _noted(lambda number, tell=tell: ready[number].alone(tell), number)  # type: ignore[misc]
        flown[number] = ensemble, time.perf_counter() - begun_at
    return each(lambda number: ready[number].run(*flown[number]))


def _shares(progress: Progress | None, work: Sequence[float]) -> list[Progress | None]:
    """What tells the progress of each of several parts of the work, one after another, as one of the whole."""
    if progress is None:
        return [None] * len(work)
    ends = [0.0, *accumulate(work)]
    whole = ends[-1] or 1.0
    return [partial(_tell, progress, begin / whole, own / whole) for begin, own in zip(ends, work, strict=False)]


def _tell(progress: Progress, begin: float, own: float, fraction: float) -> None:
    progress(min(begin + own * fraction, 1.0))


def _noted(do: Callable[[int], Any], number: int) -> Any:
    """What it gives of a system; an error says in a note of which."""
    try:
        return do(number)
    except Exception as fault:
        fault.add_note(f"This is about systems[{number}].")
        raise
