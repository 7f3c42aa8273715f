"""The numbers of a result, by name: what a store keeps of each task."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.problem.catalogue import OF_A_LEVEL, OF_A_WALL, numbers_on_request, possible_results, unit_of_result
from springpot.problem.outputs import output_squares
from springpot.problem.system import System
from springpot.theory.result import names_of_results

if TYPE_CHECKING:
    from springpot.simulation import Run
    from springpot.simulation.rare.search import ExceedanceCurve

SAID = {
    "": "",
    "_se": "standard error of ",
    "_error": "half-width of the 95 % interval of ",
    "_low": "low end of the 95 % interval of ",
    "_high": "high end of the 95 % interval of ",
}
"""Endings of names, in words."""
_EXCEEDED = {
    "probability": ("1", ("", "_se", "_low", "_high")),
    "exceedance_rate": ("s-1", ("", "_se")),
    "return_period": ("s", ("", "_se")),
}
_PASSED = {f"first_passage_{what}": (unit, endings) for what, (unit, _, endings) in OF_A_LEVEL.items()}
_OF_LEVELS = {
    "exceedance": ("levels", "level", _EXCEEDED),
    "monte_carlo": ("first_passage", "first_passage_level", _PASSED),
}
"""Of a method the setting with levels, their dimension, and the numbers of each, with their units and endings."""


@dataclass(frozen=True)
class Column:
    """One number of a method's result.

    Attributes
    ----------
    name : str
        In stores and tables.
    unit : str
    quantity, ending : str
        Of a data set's variable; the ending is a key of `SAID`.
    dimension : str
        Over which the variable has one such column for each wall or level; empty if it has this one.
    """

    name: str
    unit: str
    quantity: str
    ending: str = ""
    dimension: str = ""

    @property
    def variable(self) -> str:
        """Its name in data sets."""
        return self.quantity + self.ending


def _of_names(system: System, names: Iterable[str], endings: Sequence[str]) -> Iterator[Column]:
    walls = {f"{wall}_{what}": f"barrier_{what}" for wall in system.stops for what in OF_A_WALL}
    for name in names:
        for ending in endings:
            unit, dimension = unit_of_result(system, name), "barrier" if name in walls else ""
            yield Column(name + ending, unit, walls.get(name, name), ending, dimension)


def levels_of(method: str, settings: Mapping[str, Any]) -> dict[str, tuple[str, Sequence[float]]]:
    """Of each dimension of levels in a method's results its quantity and the levels.

    Examples
    --------
    >>> levels_of("exceedance", {"levels": {"x": [0.5, 1.0]}})
    {'x_level': ('x', [0.5, 1.0])}
    """
    setting, dimension, _ = _OF_LEVELS[method]
    return {f"{name}_{dimension}": (name, own) for name, own in settings.get(setting, {}).items()}


def _of_levels(method: str, settings: Mapping[str, Any]) -> Iterator[Column]:
    for dimension, (name, levels) in levels_of(method, settings).items():
        for level in levels:
            for what, (unit, endings) in _OF_LEVELS[method][2].items():
                for ending in endings:
                    yield Column(f"{_at(name, level)}{what}{ending}", unit, f"{name}_{what}", ending, dimension)


def _at(name: str, level: float) -> str:
    return f"{name}_{float(level)!r}_"


def columns_of(
    method: str, system: System, settings: Mapping[str, Any] | None = None, controlled: Sequence[str] = ()
) -> tuple[Column, ...]:
    """The numbers in a method's result: they depend on the parts of the system and what its settings ask for.

    ``controlled`` are the names that ``rtol`` controls, some of which only then have results.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> [column.name for column in columns_of("envelope", System(Spring(1.0)))][:2]
    ['amplitude_mean_square', 'x_mean']
    >>> columns_of("exceedance", System(Spring(1.0)), {"levels": {"x": [0.5]}})[-1]
    Column(name='x_0.5_return_period_se', unit='s', quantity='x_return_period', ending='_se', dimension='x_level')
    """
    given = settings or {}
    if method == "exceedance":
        return tuple(_of_levels(method, given))
    outputs = numbers_on_request(system, "forces", given.get("forces", ()))
    if method != "monte_carlo":
        return tuple(_of_names(system, (*names_of_results(system), *outputs), ("",)))
    cycles = numbers_on_request(system, "rainflow", given.get("rainflow", ()))
    counted = numbers_on_request(system, "slowest_counted_impact") if "slowest_counted_impact" in given else ()
    squares = [name for name in output_squares(system) if name in controlled] if "rtol" in given else []
    names = dict.fromkeys((*possible_results(system), *outputs, *squares, *cycles, *counted))
    return (*_of_names(system, names, ("", "_se", "_error")), *_of_levels(method, given))


def scalars_of(system: System) -> tuple[str, ...]:
    """The quantities of a system that some method gives, by name."""
    return tuple(dict.fromkeys((*names_of_results(system), *possible_results(system))))


def names_in_results(columns: Iterable[Column]) -> set[str]:
    """Names in data sets and tables that no axis may have."""
    own = {name for each in columns for name in (each.name, each.variable, each.dimension)}
    return own | {"barrier", "theory", "method", "done", "said"}


def numbers_of_curves(curves: Mapping[str, ExceedanceCurve]) -> dict[str, float]:
    """The numbers of exceedance, by the names of their columns."""
    found = dict[str, float]()
    for name, curve in curves.items():
        again = curve.return_period
        seen = np.where(curve.rate > 0.0, again, math.nan)
        error = curve.rate_error * seen * seen
        numbers = {
            "probability": curve.probability, "probability_se": curve.error, "probability_low": curve.low,
            "probability_high": curve.high, "exceedance_rate": curve.rate, "exceedance_rate_se": curve.rate_error,
            "return_period": again, "return_period_se": error,
        }  # fmt: skip
        for what, own in numbers.items():
            found |= {_at(name, level) + what: number for level, number in zip(curve.levels, own, strict=True)}
    return found


def numbers_of_run(run: Run) -> dict[str, float]:
    """The numbers of a run, by the names of their columns."""
    found = dict[str, float]()
    for name, own in run.estimates.items():
        total = math.nan if own.budget is None else own.budget.total
        found |= {name: own.value, f"{name}_se": own.error, f"{name}_error": total}
    for name, levels in run.first_passages.items():
        for each in levels if isinstance(levels, Sequence) else (levels,):
            found |= {f"{_at(name, each.level)}first_passage_{what}": own for what, own in each.numbers.items()}
    return found
