"""The numbers of a result, by name: what a store keeps of each task."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.problem.catalogue import possible_results, unit_of_result
from springpot.problem.system import System
from springpot.theory.result import names_of_results

if TYPE_CHECKING:
    from springpot.simulation import Estimate
    from springpot.simulation.rare.search import ExceedanceCurve

__all__ = [
    "ENDINGS",
    "OF_LEVELS",
    "OF_WALLS",
    "asked_of",
    "bare",
    "column_of_level",
    "columns_of",
    "names_in_results",
    "numbers_of_curves",
    "numbers_of_run",
    "per_level",
    "results_of_run",
    "scalars_of",
    "unit_of_column",
]

ENDINGS = ("", "_se", "_error")
"""Of a value, its standard error, and the half-width of its total 95 % interval."""
OF_WALLS = ("impact_rate", "impact_speed_mean", "power", "force_mean")
"""Quantities of each wall: in a data set they have the dimension ``barrier``."""
OF_LEVELS = {
    "probability": "1",
    "probability_low": "1",
    "probability_high": "1",
    "exceedance_rate": "s-1",
    "return_period": "s",
}
"""Units of the numbers of each level: in a data set they have the dimension ``<quantity>_level``."""
NO_LEVELS: Mapping[str, Sequence[float]] = {}
_WITHOUT_ERROR = "probability_low", "probability_high"


def per_level() -> tuple[str, ...]:
    """Names of the numbers of a level, each followed by its standard error, if it has one."""
    return tuple(what + end for what in OF_LEVELS for end in ENDINGS[: 1 if what in _WITHOUT_ERROR else 2])


def column_of_level(name: str, level: float, what: str) -> str:
    """The column of a number of one level of a quantity.

    Examples
    --------
    >>> column_of_level("x", 0.5, "return_period_se")
    'x_0.5_return_period_se'
    """
    return f"{name}_{level!r}_{what}"


def asked_of(settings: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the results that a run has because its settings ask for them: of forces, and of rainflow cycles.

    Examples
    --------
    >>> asked_of({"forces": ["spring_force"], "rainflow": {"x": {"exponent": 5.0}}})
    ('spring_force_mean', 'spring_force_mean_square', 'x_cycle_rate', 'x_damage_rate', 'x_life')
    """
    endings = {"forces": ("mean", "mean_square"), "rainflow": ("cycle_rate", "damage_rate", "life")}
    return tuple(f"{name}_{end}" for kind, ends in endings.items() for name in settings.get(kind, ()) for end in ends)


def results_of_run(system: System, asked: Sequence[str] = ()) -> tuple[str, ...]:
    """Names of the results of a run, with those that it was asked for.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> results_of_run(System(Spring(1.0)), ["spring_force_mean"])[-1]
    'spring_force_mean'
    """
    return tuple(dict.fromkeys((*possible_results(system), *asked)))


def columns_of(
    method: str, system: System, asked: Sequence[str] = (), levels: Mapping[str, Sequence[float]] = NO_LEVELS
) -> tuple[str, ...]:
    """Names of the numbers in a method's result: they depend on the parts of the system and what is asked.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> columns_of("envelope", System(Spring(1.0)))[:2]
    ('amplitude_mean_square', 'x_mean')
    """
    if method == "exceedance":
        return tuple(
            column_of_level(name, level, what) for name, own in levels.items() for level in own for what in per_level()
        )
    if method != "monte_carlo":
        return names_of_results(system)
    return tuple(name + ending for name in results_of_run(system, asked) for ending in ENDINGS)


def scalars_of(system: System) -> tuple[str, ...]:
    """The quantities of a system that some method gives, by name."""
    return tuple(dict.fromkeys((*columns_of("", system), *possible_results(system))))


def names_in_results(
    system: System, asked: Sequence[str] = (), levels: Mapping[str, Sequence[float]] = NO_LEVELS
) -> set[str]:
    """Names in data sets and tables that no axis may have."""
    taken = {*columns_of("", system), *columns_of("monte_carlo", system, asked), "theory", "method", "done", "said"}
    taken |= {f"{name}_{what}" for name in levels for what in ("level", *per_level())}
    return taken | {"barrier", *(f"barrier_{name}{ending}" for name in OF_WALLS for ending in ENDINGS)}


def bare(column: str) -> str:
    """The quantity of a column.

    Examples
    --------
    >>> bare("x_mean_se")
    'x_mean'
    """
    return column.removesuffix("_se").removesuffix("_error")


def unit_of_column(method: str, system: System, column: str) -> str:
    """The unit of a method's number.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> unit_of_column("exceedance", System(Spring(1.0)), "x_0.5_return_period_se")
    's'
    """
    if method != "exceedance":
        return unit_of_result(system, bare(column))
    return next(unit for what, unit in OF_LEVELS.items() if bare(column).endswith(f"_{what}"))


def numbers_of_curves(curves: Mapping[str, ExceedanceCurve]) -> tuple[float, ...]:
    """The numbers of exceedance, by `columns_of`."""
    found: list[float] = []
    for curve in curves.values():
        again = curve.return_period
        error = np.where(curve.rate > 0.0, curve.rate_error * again * again, math.nan)
        numbers = (curve.probability, curve.error, curve.low, curve.high, curve.rate, curve.rate_error, again, error)
        found += np.stack(numbers, axis=-1).ravel().tolist()
    return tuple(found)


def numbers_of_run(estimates: Mapping[str, Estimate], system: System, asked: Sequence[str] = ()) -> tuple[float, ...]:
    """The numbers of a run: value, standard error and total of each result; NaN where there is none."""
    found: list[float] = []
    for name in results_of_run(system, asked):
        own = estimates.get(name)
        total = math.nan if own is None or own.budget is None else own.budget.total
        found += (math.nan, math.nan, math.nan) if own is None else (own.value, own.error, total)
    return tuple(found)
