"""Theory of a system for the page: every method that may cover it, in the form of `springpot.explorer.answers`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from springpot.evidence.recommendation import recommended
from springpot.evidence.reliability import warnings_of
from springpot.explorer.answers import POINTS, Floats, densities_of, plain, plain_number
from springpot.problem.system import System
from springpot.theory.registry import METHODS
from springpot.theory.solve import solve_one

__all__ = ["lines", "names", "solve", "table"]


def names(system: System) -> tuple[str, ...]:
    """The methods that may cover a system."""
    return tuple(METHODS)


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
    choice = recommended(system, answers)
    best, shown = choice.method, choice.guess
    places = _places(system, answers[shown]) if hasattr(answers.get(shown), "x_density") else {}
    return {
        "recommended": best or None,
        "shown": shown or None,
        "drawn": [shown] if shown else [],
        "statements": statements,
        "places": {name: plain(place) for name, place in places.items()},
        "methods": {
            name: {
                "moments": {moment: plain_number(value) for moment, value in answer.numbers.items()},
                "warnings": list(warnings_of(answer)),
                "assumptions": list(answer.assumptions),
                "densities": densities_of(answer, places),
            }
            for name, answer in answers.items()
        },
    }


def lines(answers: Mapping[str, Any], count: int) -> dict[str, list[float | None]]:
    """<x^2> of each method as a line over time: its stationary value."""
    return {name: [plain_number(answer.x_mean_square)] * count for name, answer in answers.items()}


def _places(system: System, answer: Any) -> dict[str, Floats]:
    """Where the densities of x and v are drawn."""
    mean, potential = answer.x_mean, system.potential
    spread = math.sqrt(max(answer.x_mean_square - mean**2, 1e-12 * answer.x_mean_square))
    fastest = 4.0 * math.sqrt(answer.v_mean_square)
    low, high = max(mean - 4.5 * spread, potential.low), min(mean + 4.5 * spread, potential.high)
    if not (low < high and fastest > 0.0):
        return {}
    return {"x": np.linspace(low, high, POINTS), "v": np.linspace(-fastest, fastest, POINTS)}
