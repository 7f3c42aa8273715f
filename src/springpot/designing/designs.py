"""Numbers chosen so that limits hold and a cost is least or greatest: by theory first, then by Monte Carlo."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from springpot.designing.approximation import OneDevice, places_of
from springpot.designing.quantities import MONTE_CARLO
from springpot.designing.results import Design, in_words
from springpot.designing.rounds import MOST_ROUNDS, DesignTask, Searched, rounds
from springpot.designing.search import Approximation, DesignProgress
from springpot.designing.statement import Space, Wanted, check_names, checked_cost, checked_limits
from springpot.designing.tolerances import OverDevices, names_over_devices
from springpot.machine.arguments import Free, Uncertain, check_called, finite_number
from springpot.machine.faults import listed, per_cent
from springpot.machine.progress import OutOfTimeError
from springpot.problem.free_numbers import free_numbers, nominal, uncertain_numbers, with_values
from springpot.problem.numbers import numbers_of, unit_of
from springpot.problem.system import System, checked_system
from springpot.problem.uncertain import centre_of
from springpot.simulation.error.reach import controllable
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import check_stationary
from springpot.simulation.plan.settings import checked_seed
from springpot.theory.registry import METHODS

AT_BOUND = 1e-4  # of the whole range


def design(
    model: System,
    minimize: Wanted | None = None,
    subject_to: Mapping[str, tuple[float | None, float | None]] | None = None,
    *,
    maximize: Wanted | None = None,
    seed: int = 1,
    rtol: float = 0.02,
    cost_rtol: float = 0.02,
    probability: float = 0.99,
    method: str | None = None,
    max_time: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Design:
    """Choose the free numbers of a model so that limits hold and a cost is least, or a gain greatest.

    Parameters
    ----------
    model : System
        With numbers marked by `springpot.free`, and a stationary state.
    minimize : str or callable
        The name of a quantity (``"v_mean_square"``) or of a free number, or a function of some of them: its arguments
        are called as they are, ``lambda x_mean_square, c: x_mean_square + 0.1 * c``.
    subject_to : dict
        For each limited quantity ``(low, high)``, None where there is no limit.  Of the results of ``forces`` the mean
        squares can be limited, ``"mount_force_mean_square"``.  If left out, there are only the bounds of the numbers.
        If the model has numbers that are marked by `springpot.uncertain`, ``"impact_rate"`` is the mean over devices,
        and ``"impact_rate_quantile_0.95"`` is what 95 % of the devices are below; see `springpot.scatter`.
    maximize : str or callable
        In place of ``minimize``: what is to be as great as possible.
    seed : int
        Of the places where the search starts, and of Monte Carlo.
    rtol : float
        Relative error of the limited quantities in the first run by Monte Carlo, in [1e-4, 0.5], as in
        `springpot.simulate`.
    cost_rtol : float
        By how much the distance to the limits may raise the cost, relative to it, in [1e-3, 0.5].  Later runs are as
        precise as this needs, down to a 16th of ``rtol``.
    probability : float
        With which all limits must hold, in [0.5, 0.999].  The default is higher than the usual 0.95, since the cheapest
        design is as close to its limits as this allows, and whoever repeats the simulation has an error too.
    method : str
        Of the search: the name of an analytical method, or ``"monte_carlo"``.  If left out, an exact method, or one
        that the validity map trusts to 30 % between the bounds and that takes no longer than a short run; else smooth
        surfaces through short runs by Monte Carlo.
    max_time : float
        In s, after which the search ends with the best design so far, and a warning; what compiles or a single answer
        of theory is not interrupted.
    threads : int
    progress : callable
        Called with the fraction done, from the beginning and from any thread; it carries an estimate of the time of
        each run, as in `springpot.simulate`.

    Returns
    -------
    Design

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, or no numbers satisfy the limits: the sentence says by how much they are missed.
    TimeoutError
        If ``max_time`` is too short for any result.

    Notes
    -----
    The search is on theory.  Monte Carlo where it ends gives the ratio of each quantity to that of theory, and the
    search is repeated with theory times this ratio, and with a distance to each limit that the error of Monte Carlo
    needs.  Each run has random numbers of its own; all of them together give the ratio and how it changes from place to
    place (kriging), each with a weight for its standard error and for what the ratio may have changed since.  The last
    step, from a place that was simulated to one that is a little cheaper, has no run of its own if this says enough of
    it.  The search ends when the limits hold with the wanted
    probability at a cost that ``cost_rtol`` allows.

    Examples
    --------
    The least damping at which a wall is struck less than once in five seconds:

    >>> import springpot as sp
    >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
    >>> device = sp.System(sp.Spring(4.0), damper, sp.Barrier(-1.0), sp.WhiteNoise(1.0))
    >>> found = sp.design(device, minimize="c", subject_to={"impact_rate": (None, 0.2)}, rtol=0.05)
    >>> found.promises[0].probability > 0.98, 0.15 < found.values["c"] < 0.18
    (True, True)

    A gap of 10 % tolerance, so wide that 95 % of the devices strike their wall less than once in ten seconds, is found
    with ``{"impact_rate_quantile_0.95": (None, 0.1)}`` of this device:

    >>> gap = sp.uncertain("gap", sp.free("centre", 0.8, (0.4, 2.0)), cov=0.1)
    >>> device = sp.System(sp.Spring(4.0), sp.Dashpot(0.5), sp.Barrier(-gap), sp.WhiteNoise(1.0))

    The resistance at which a harvester gives most power, which is known in closed form:

    >>> circuit = sp.PiezoelectricCircuit(coupling=1.0, resistance=sp.free("R", 0.2, (0.05, 20.0)), capacitance=1.0)
    >>> shaken = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), circuit, sp.WhiteNoise(1.0))
    >>> best = sp.design(shaken, maximize="harvested_power", rtol=0.05)
    >>> abs(best.values["R"] * 2.0**0.5 - 1.0) < 0.01
    True
    """
    system = checked_system(model, "model")
    free = free_numbers(system)
    if not free:
        raise ValueError("model must have a free number, such as Spring(sp.free('k', 80.0, (10.0, 200.0))).")
    limits = checked_limits(subject_to, free)
    checked_seed(seed)
    check_called(progress, "progress")
    finite_number(rtol, "rtol", low=1e-4, high=0.5)
    finite_number(cost_rtol, "cost_rtol", low=1e-3, high=0.5)
    finite_number(probability, "probability", low=0.5, high=0.999)
    if max_time is not None:
        max_time = finite_number(max_time, "max_time", low=0.0, open_low=True, hint="It is in seconds.")
    work = DesignProgress(max_time, progress, MOST_ROUNDS)
    scatters = bool(uncertain_numbers(system))
    check_stationary(nominal(system), "design")
    try:
        work.say()
        allowed = (
            names_over_devices(system, [*(limit.name for limit in limits), minimize, maximize]) if scatters
            else controllable(motion_of(system))
        )  # fmt: skip
        check_names(limits, allowed)
        cost = checked_cost(minimize, maximize, free, allowed)
        space = Space(free)
        places = places_of(space, seed)
        needed = dict.fromkeys([*(limit.name for limit in limits), *(name for name in cost.takes if name in allowed)])
        source: OneDevice | OverDevices = OneDevice(system, tuple(needed), threads)
        if scatters:
            source = OverDevices(system, tuple(needed or allowed[:1]), threads)
        chosen, quick = source.quick(space, places, method, seed, work)
        approximation = Approximation(space, quick, cost)
        if missing := set(needed).difference(*(approximation.at(place) for place in places)):
            word, names = cost.word, listed(sorted(missing))
            if chosen == MONTE_CARLO:
                raise ValueError(
                    f"{word} and subject_to must ask for what short runs see, and they see too few events for {names}: "
                    "give a method."
                )
            raise ValueError(
                f"method must have the results that {word} and subject_to ask for, and {chosen} has no {names} there."
            )
        exact = chosen != MONTE_CARLO and METHODS[chosen].exact and not scatters
        task = DesignTask(approximation, limits, places, seed, probability, rtol, cost_rtol, exact)
        seeds = [seed, *np.random.SeedSequence(seed).generate_state(MOST_ROUNDS - 1, np.uint64).tolist()]
        found = rounds(task, source.measured(approximation, seeds, work))
    except OutOfTimeError:
        raise TimeoutError(f"max_time of {max_time:g} s is too short for any result of a design.") from None
    work.end()
    return _told(system, task, found, chosen)


def _told(system: System, task: DesignTask, found: Searched, method: str) -> Design:
    """What was found, with its warnings."""
    cost, wanted, best, margin = task.approximation.cost, task.wanted, found.best, found.margin
    said = [*found.warnings]
    if unseen := [promise.limit for promise in best.promises if math.isnan(promise.probability)]:
        said.append(f"Monte Carlo saw too few events to tell whether {listed(unseen)}.")
    elif not task.holds(best):
        said.append(
            f"The limits hold with a probability of {in_words(best.probability)} only, not {in_words(wanted)}: a "
            "smaller rtol helps."
        )
    elif margin > task.cost_rtol:
        said.append(
            f"The distance to the limits costs {per_cent(margin)}, more than cost_rtol of "
            f"{per_cent(task.cost_rtol)}: a smaller rtol helps."
        )
    ends = {}
    for name, number in free_numbers(system).items():
        for end, bound in (("low", number.low), ("high", number.high)):
            if abs(best.values[name] - bound) <= AT_BOUND * (number.high - number.low):
                ends[name] = end
                said.append(f"{name} is at its {'lower' if end == 'low' else 'upper'} bound, {best.values[name]:.6g}.")
    cost_error = 0.0
    if not task.exact:  # from the errors of the quantities that it depends on
        whole = {**best.expected, **best.quantities, **best.values}
        errors = {name: error for name in cost.takes if math.isfinite(error := best.errors.get(name, 0.0))}
        moved = (cost.of({**whole, name: whole[name] + error}) - best.cost for name, error in errors.items())
        cost_error = math.hypot(*moved)
    return Design(
        model=with_values(system, best.values), values=best.values, quantities=best.quantities, errors=best.errors,
        cost=best.cost, cost_error=cost_error, margin=margin, promises=best.promises, at_bounds=ends, method=method,
        history=found.history, warnings=tuple(said), _search=found.least, _limits=task.limits, _cost=cost,
        _units=units_of_free(system),
    )  # fmt: skip


def units_of_free(system: System) -> dict[str, str]:
    """The unit of each free number; empty for one that stands for numbers of different units.

    Examples
    --------
    >>> import springpot as sp
    >>> units_of_free(sp.System(sp.Mass(2.0), sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), sp.WhiteNoise(1.0)))
    {'k': 'N m-1'}
    >>> units_of_free(sp.System(sp.Spring(sp.free("w", 2.0, (1.0, 3.0)) ** 2)))
    {'w': 'rad s-1'}
    """
    found: dict[str, set[str]] = {}
    for name, stated in numbers_of(system).items():
        value = centre_of(stated) if isinstance(stated, Uncertain) else stated
        if isinstance(value, Free):
            unit = unit_of(system, name)
            if value.power != 1.0:  # the root of a stiffness per unit mass is a frequency
                unit = "rad s-1" if (unit, value.power) == ("s-2", 2.0) else ""
            found.setdefault(value.name, set()).add(unit)
    return {name: units.pop() if len(units) == 1 else "" for name, units in found.items()}
