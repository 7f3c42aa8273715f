"""Rounds of a search and of Monte Carlo, which corrects what the next search is told."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.designing.numbers import as_simulated
from springpot.designing.promises import each_probability, impossible, promise_of, tightened
from springpot.designing.quantities import MONTE_CARLO
from springpot.designing.results import Round
from springpot.designing.search import CLOSE, Found, Model, search
from springpot.designing.statement import Cost, Limit, cost_of
from springpot.free_numbers import with_values
from springpot.oscillator import Oscillator
from springpot.simulation.run import run
from springpot.system import System
from springpot.theory.registry import METHODS, SYSTEM_METHODS

__all__ = ["is_exact", "measured_by", "rounds"]

Floats = NDArray[np.float64]

MOST_ROUNDS = 4
SPARE = 0.25  # errors beyond those that the wanted probability needs
FURTHER = 0.5  # errors more in each round after the second
NEAR = 1.5  # errors between what a search expects and what Monte Carlo then finds


def rounds(
    pilot: Model,
    limits: tuple[Limit, ...],
    places: Floats,
    measured: Callable[[Found], Round],
    seed: int,
    probability: float,
    rtol: float,
    exact: bool,
) -> tuple[list[Round], dict[str, float]]:
    """Searches and runs in turn, until the search stays where it is."""
    from scipy import stats

    wanted = each_probability(probability, len(limits))
    errors_away = float(stats.norm.ppf(wanted)) + SPARE
    history: list[Round] = []
    factors: dict[str, float] = {}
    spread = {limit.name: 0.5 * rtol * abs(limit.bound) for limit in limits}
    for number in range(MOST_ROUNDS):
        away = errors_away + FURTHER * max(number - 1, 0)
        inside = tuple(tightened(limit, away * spread.get(limit.name, 0.0)) for limit in limits)
        found = search(pilot, inside, places, factors, seed)
        if found.excess > CLOSE:
            if number > 0 and search(pilot, limits, places, factors, seed).excess <= CLOSE:
                break  # it holds, but not with the wanted probability: the rounds before tell with which
            raise ValueError(impossible(limits, found))
        latest = measured(found)
        history.append(latest)
        if not exact:
            factors = _factors(history, [*latest.quantities], factors)
        near = all(
            abs(latest.expected[limit.name] - latest.quantities[limit.name]) <= NEAR * latest.errors[limit.name]
            for limit in limits
        )
        spread = {limit.name: latest.errors[limit.name] for limit in limits}
        if not limits or (near and latest.probability >= wanted):
            break
    return history, factors


def is_exact(method: str) -> bool:
    """Whether nothing is approximated, so that Monte Carlo has nothing to correct."""
    return method != MONTE_CARLO and {**METHODS, **SYSTEM_METHODS}[method].exact


def _factors(history: list[Round], names: list[str], now: Mapping[str, float]) -> dict[str, float]:
    """Monte Carlo over theory of each quantity: a mean over the rounds, weighted by their errors."""
    factors = dict(now)
    for name in names:
        ratios, weights = [], []
        for each in history:
            theory, value, error = each.theory.get(name, 0.0), each.quantities[name], each.errors[name]
            if theory != 0.0 and value / theory > 0.0 and error > 0.0:
                ratios.append(math.log(value / theory))
                weights.append((value / error) ** 2)
        if ratios:
            factors[name] = math.exp(float(np.average(ratios, weights=weights)))
    return factors


def measured_by(
    problem: Oscillator | System,
    plain: Callable[[Floats], dict[str, float]],
    limits: tuple[Limit, ...],
    cost: Cost,
    controlled: tuple[str, ...],
    rtol: float,
    max_time: float | None,
    seed: int,
    threads: int | None,
) -> Callable[[Found], Round]:
    """Monte Carlo of what a search found."""

    def at(found: Found) -> Round:
        model = as_simulated(with_values(problem, found.values))
        wanted: dict[str, Any] = {"quantities": controlled} if controlled else {}
        result = run(model, rtol=rtol, max_time=max_time, seed=seed, threads=threads, **wanted)
        errors = {name: math.nan if error is None else float(error) for name, error in result.errors.items()}
        for name, budget in result.budgets.items():
            parts = budget.standard_error, budget.step_bias, budget.memory_bias, budget.transient
            errors[name] = math.hypot(*parts)
        promises = tuple(promise_of(limit, result.values[limit.name], errors[limit.name]) for limit in limits)
        whole = cost_of(cost, {**found.quantities, **result.values, **found.values})
        names = [name for name in result.values if name in found.quantities or name in controlled]
        return Round(
            found.values,
            plain(found.u),
            found.quantities,
            {name: result.values[name] for name in names},
            {name: errors[name] for name in names},
            whole,
            promises,
        )

    return at
