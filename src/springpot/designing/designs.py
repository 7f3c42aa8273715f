"""Numbers chosen so that limits hold and a cost is least: by theory first, then corrected by Monte Carlo."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from springpot.arguments import finite_number
from springpot.designing.numbers import as_simulated, checked_model
from springpot.designing.promises import each_probability
from springpot.designing.quantities import MONTE_CARLO
from springpot.designing.quick import places_of, quick_quantities
from springpot.designing.results import Curve, Design, Promise, Round, per_cent
from springpot.designing.rounds import is_exact, measured_by, rounds
from springpot.designing.search import Model, search
from springpot.designing.statement import Cost, Limit, Space, checked_cost, checked_limits, cost_of
from springpot.faults import meant
from springpot.free_numbers import free_numbers, with_values
from springpot.oscillator import Oscillator
from springpot.simulation.accuracy import checked_quantities
from springpot.simulation.settings import check_stationary, checked_seed
from springpot.system import System

__all__ = ["Curve", "Design", "Promise", "Round", "design"]

Floats = NDArray[np.float64]

AT_BOUND = 1e-4  # of the whole range


def design(
    model: System | Oscillator,
    minimise: Cost,
    subject_to: Mapping[str, tuple[float | None, float | None]],
    *,
    seed: int = 1,
    rtol: float = 0.02,
    probability: float = 0.95,
    method: str | None = None,
    max_time: float | None = None,
    threads: int | None = None,
) -> Design:
    """Choose the free numbers of a model so that limits hold and a cost is least.

    Parameters
    ----------
    model : System or Oscillator
        With numbers marked by `springpot.free`, and a stationary state.
    minimise : str or callable
        The name of a quantity (``"v_mean_square"``) or of a free number, or a function of all of them by name.
    subject_to : dict
        For each limited quantity ``(low, high)``, None where there is no limit.
    seed : int
        Of the places where the search starts, and of Monte Carlo.
    rtol : float
        Relative error of the limited quantities by Monte Carlo, in [1e-4, 0.5], as in `springpot.run`.
    probability : float
        With which all limits must hold, in [0.5, 0.999].
    method : str
        Of the search: the name of an analytical method, or ``"monte_carlo"``.  If left out, the recommended method or
        the best guess; Monte Carlo where there is none.
    max_time : float
        Of each run by Monte Carlo, in s.
    threads : int

    Returns
    -------
    Design

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, or no numbers satisfy the limits: the sentence says by how much they are missed.

    Notes
    -----
    The search is on theory.  Monte Carlo at its end gives the ratio of each quantity to that of theory, and the search
    is repeated with theory times this ratio, and with a distance to each limit that the error of Monte Carlo needs.
    All rounds have the same random numbers.

    Examples
    --------
    The least damping at which a wall is struck less than once in five seconds:

    >>> import springpot as sp
    >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
    >>> device = sp.System(sp.Spring(4.0), damper, sp.Barrier(-1.0), sp.WhiteNoise(1.0))
    >>> found = sp.design(device, minimise="c", subject_to={"impact_rate": (None, 0.2)}, rtol=0.05)
    >>> found.promises[0].probability > 0.95, 0.15 < found.values["c"] < 0.18
    (True, True)
    """
    problem = checked_model(model, "model")
    free = free_numbers(problem)
    if not free:
        raise ValueError("model must have a free number, such as Spring(sp.free('k', 80.0, (10.0, 200.0))).")
    limits = checked_limits(subject_to, free)
    checked_seed(seed)
    finite_number(rtol, "rtol", low=1e-4, high=0.5)
    finite_number(probability, "probability", low=0.5, high=0.999)
    check_stationary(as_simulated(problem), "design")
    space = Space(free)
    places = places_of(space, seed)
    chosen, quick = quick_quantities(problem, space, places, method, seed, threads)
    known = quick({name: float(number) for name, number in free.items()})
    if not known:  # no answer where the numbers start, but there are others
        known = next((found for place in places if (found := quick(space.values(place)))), {})
    cost = checked_cost(minimise, free, known)
    for limit in limits:
        if limit.name not in known:
            near = meant(limit.name, known) or "."
            raise ValueError(f"subject_to must limit quantities among {', '.join(known)}, not {limit.name}{near}")
    controlled = tuple(dict.fromkeys([*(limit.name for limit in limits), *([cost] if cost in known else [])]))
    if controlled:
        checked_quantities(as_simulated(problem), controlled)
    pilot = Model(space, quick, cost, 2e-2 if chosen == MONTE_CARLO else 1e-4)
    measured = measured_by(problem, pilot.at, limits, cost, controlled, rtol, max_time, seed, threads)
    history, factors = rounds(pilot, limits, places, measured, seed, probability, rtol, is_exact(chosen))
    return _chosen(problem, space, pilot, limits, places, history, factors, cost, chosen, seed, probability)


def _chosen(
    problem: Oscillator | System,
    space: Space,
    pilot: Model,
    limits: tuple[Limit, ...],
    places: Floats,
    history: list[Round],
    factors: dict[str, float],
    cost: Cost,
    method: str,
    seed: int,
    probability: float,
) -> Design:
    """The cheapest round at which the limits hold, or the most probable one."""
    wanted = each_probability(probability, len(limits))
    held = [each for each in history if each.probability >= wanted]
    best = min(held, key=lambda each: each.cost) if held else max(history, key=lambda each: each.probability)
    said = []
    if not held:
        said.append(
            f"The limits hold with a probability of {per_cent(best.probability)} only, not {per_cent(wanted)}: a "
            "smaller rtol helps."
        )
    ends = {}
    for name, number in free_numbers(problem).items():
        width = AT_BOUND * (number.high - number.low)
        if abs(best.values[name] - number.low) <= width or abs(best.values[name] - number.high) <= width:
            ends[name] = "low" if abs(best.values[name] - number.low) <= width else "high"
            said.append(
                f"{name} is at its {'lower' if ends[name] == 'low' else 'upper'} bound, {best.values[name]:.6g}."
            )
    return Design(
        with_values(problem, best.values),
        best.values,
        best.quantities,
        best.errors,
        best.cost,
        _cost_error(cost, best),
        best.promises,
        ends,
        method,
        tuple(history),
        tuple(said),
        lambda other: search(pilot, other, places, factors, seed),
        limits,
        cost,
    )


def _cost_error(cost: Cost, best: Round) -> float:
    """The error of the cost, from those of the quantities that it depends on."""
    if isinstance(cost, str):
        return best.errors.get(cost, 0.0)
    whole = {**best.expected, **best.quantities, **best.values}
    total = 0.0
    for name, error in best.errors.items():
        change = cost_of(cost, {**whole, name: whole[name] + error}) - best.cost if math.isfinite(error) else 0.0
        total = math.hypot(total, change)
    return total
