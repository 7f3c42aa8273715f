"""Theory of a system for the page: every method that may cover it, in the form of `springpot.explorer.answers`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from springpot.explorer.answers import POINTS, Floats, densities_of, plain, plain_number
from springpot.problem.system import System
from springpot.theory.reliability import best_guess
from springpot.theory.result import MOMENTS
from springpot.theory.solve import methods_for, solve_one, trusted

__all__ = ["lines", "names", "solve", "table"]


def names(system: System) -> tuple[str, ...]:
    """The methods that may cover a system.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> names(System(Spring(1.0)))[-1]
    'exact'
    """
    return tuple(methods_for(system))


@lru_cache(maxsize=128)
def solve(system: System, method: str) -> tuple[Any, str]:
    """The answer of one method, or None and why there is none."""
    return solve_one(system, method)


def table(system: System, answers: Mapping[str, Any], statements: Mapping[str, str]) -> dict[str, Any]:
    """Every method's moments, warnings and densities, ready for JSON.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring, WhiteNoise
    >>> device = System(Spring(4.0), Dashpot(0.1), WhiteNoise(2.0))
    >>> found = table(device, {"exact": solve(device, "exact")[0]}, {})
    >>> found["recommended"], round(found["methods"]["exact"]["moments"]["x_mean_square"], 3)
    ('exact', 2.5)
    """
    best, _ = trusted(system, answers)
    shown = best or best_guess(system, answers)
    places = _places(system, answers[shown]) if hasattr(answers.get(shown), "x_density") else {}
    return {
        "recommended": best or None,
        "shown": shown or None,
        "drawn": [shown] if shown else [],
        "statements": statements,
        "places": {name: plain(place) for name, place in places.items()},
        "methods": {
            name: {
                "moments": _moments(system, answer),
                "warnings": list(answer.warnings),
                "assumptions": list(answer.assumptions),
                "densities": densities_of(answer, places),
            }
            for name, answer in answers.items()
        },
    }


def lines(answers: Mapping[str, Any], count: int) -> dict[str, list[float | None]]:
    """<x^2> of each method as a line over time: its stationary value."""
    return {name: [plain_number(answer.x_mean_square)] * count for name, answer in answers.items()}


def _moments(system: System, answer: Any) -> dict[str, float | None]:
    """The moments by name, those of each wall with the wall's name."""
    found = {name: getattr(answer, name) for name in MOMENTS}
    moments = answer.moments
    walls = [*system.stops]
    rates = getattr(moments, "barrier_impact_rate", ()) or (found["impact_rate"],) * (len(walls) == 1)
    found |= {f"{name}_impact_rate": rate for name, rate in zip(walls, rates, strict=False)}
    found["harvested_power"] = getattr(moments, "harvested_power", math.nan)
    return {name: plain_number(value) for name, value in found.items()}


def _places(system: System, answer: Any) -> dict[str, Floats]:
    """Where the densities of x and v are drawn."""
    mean, potential = answer.x_mean, system.potential
    spread = math.sqrt(max(answer.x_mean_square - mean**2, 1e-12 * answer.x_mean_square))
    fastest = 4.0 * math.sqrt(answer.v_mean_square)
    low, high = max(mean - 4.5 * spread, potential.low), min(mean + 4.5 * spread, potential.high)
    if not (low < high and fastest > 0.0):
        return {}
    return {"x": np.linspace(low, high, POINTS), "v": np.linspace(-fastest, fastest, POINTS)}
