"""Theory for the page: a table of all methods, their curves, and <A^2> over the order."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.evidence.recommendation import recommended
from springpot.evidence.reliability import warnings_of
from springpot.problem.oscillator import Oscillator, Springpot
from springpot.theory import (
    Averaging,
    Envelope,
    Exact,
    NoConvergenceError,
    NoStationaryStateError,
    NotCoveredError,
    Result,
    solve_all,
)
from springpot.theory.registry import METHODS, Method

__all__ = ["ORDERS", "POINTS", "along_the_order", "densities_of", "growth", "plain", "plain_number", "solve", "table"]

POINTS = 161  # of a density's curve
ORDERS = tuple(float(order) for order in np.linspace(0.04, 1.0, 33).round(6))
"""Orders at which <A^2> is drawn."""
AVERAGING = ("averaging", "averaging_printed")
"""The paper's method: drawn with the recommended one, and used where there is no stationary state."""

Floats = npt.NDArray[np.float64]


@lru_cache(maxsize=64)
def solve(oscillator: Oscillator) -> tuple[dict[str, Result], dict[str, str], str]:
    """Results, statements of the methods without one, and the name of the recommended method (or "")."""
    results, statements = solve_all(oscillator)
    return results, statements, recommended(oscillator, results).method


def table(oscillator: Oscillator, answers: dict[str, Result], statements: dict[str, str], best: str) -> dict[str, Any]:
    """Every method's moments, warnings and densities, ready for JSON.

    Examples
    --------
    >>> content = table(Oscillator(), *solve(Oscillator()))
    >>> len(content["methods"]["envelope"]["densities"]["x"]) == len(content["places"]["x"])
    True
    """
    near = recommended(oscillator, answers).guess
    beside = AVERAGING[1] if best == AVERAGING[0] else AVERAGING[0]
    places = {} if not near else _places(oscillator, answers[near])
    return {
        "recommended": best or None,
        "drawn": [name for name in (best, beside) if name in answers] if best else [],
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


def _places(oscillator: Oscillator, answer: Result) -> dict[str, Floats]:
    """The arguments at which the densities are drawn."""
    mean = answer.x_mean
    spread = math.sqrt(max(answer.x_mean_square - mean**2, 1e-12 * answer.x_mean_square))
    low, high, least = mean - 4.0 * spread, mean + 4.5 * spread, 0.0
    if oscillator.barrier is not None:
        low, least = max(low, oscillator.barrier.position), max(oscillator.barrier.position, 0.0)
    # with a preload A is at least the wall's distance, and A^2 minus its square varies
    above = max(answer.amplitude_mean_square - least**2, 1e-6 * answer.amplitude_mean_square)
    fastest = 4.0 * math.sqrt(answer.v_mean_square)
    places = {
        "x": np.linspace(low, high, POINTS),
        "v": np.linspace(-fastest, fastest, POINTS),
        "amplitude": np.linspace(least, math.sqrt(least**2 + 9.0 * above), POINTS),
    }
    if answer.impact_rate > 0.0 and answer.impact_speed_mean_square > 0.0:
        places["impact_speed"] = np.linspace(0.0, 3.0 * math.sqrt(answer.impact_speed_mean_square), POINTS)
    return places


def densities_of(answer: Any, places: Mapping[str, Floats]) -> dict[str, list[float | None]]:
    """The densities that a method has, at these places; None where one is not a number."""
    curves = {}
    for name, place in places.items():
        curve = getattr(answer, f"{name}_density", None)
        if curve is None:
            continue
        try:
            curves[name] = plain(curve(place))
        except (NotCoveredError, NoStationaryStateError, NoConvergenceError):
            continue
    return curves


def growth(
    oscillator: Oscillator, answers: dict[str, Result], times: Floats, *, from_rest: bool
) -> dict[str, list[float | None]]:
    """<A^2> of each method at these times from rest, or its stationary value if it has no transient.

    Without a stationary state averaging still has the growing response.
    """
    curves = {name: [plain_number(answer.amplitude_mean_square)] * times.size for name, answer in answers.items()}
    if not from_rest:
        return curves
    for name, answer in answers.items():
        if isinstance(answer, Envelope | Exact):
            with suppress(NotCoveredError, NoStationaryStateError, NoConvergenceError):
                curves[name] = plain(answer.amplitude_mean_square_at(times))
    for name in AVERAGING:
        with suppress(NotCoveredError):
            growing = METHODS[name].solve(oscillator)
            assert isinstance(growing, Averaging)
            curves[name] = plain(growing.mean_square(times))
    return curves


def along_the_order(oscillator: Oscillator) -> Iterator[dict[str, Any]]:
    """<A^2> over the order, by the methods with ``over_order``.

    The fast methods come first, for all orders. The slow ones come one order after the other, first the ends, then
    the middles of the gaps.

    Yields
    ------
    dict
        ``orders``; ``methods``, by name, with a value for each order (None if there is none); and ``missing``, the
        indices at which the slow ones are still missing.

    Examples
    --------
    >>> first = next(along_the_order(Oscillator()))
    >>> len(first["methods"]["averaging"]), len(first["missing"])
    (33, 33)
    """
    here = [replace(oscillator, springpot=Springpot(order, oscillator.springpot.coefficient)) for order in ORDERS]
    values: dict[str, list[float | None]] = {
        name: [_amplitude(method, one) if method.over_order == "at once" else None for one in here]
        for name, method in METHODS.items()
        if method.over_order
    }
    slow = [name for name in values if METHODS[name].over_order == "one by one"]
    waiting = _ends_first(len(here))
    while True:
        yield {"orders": ORDERS, "methods": {name: values[name][:] for name in values}, "missing": sorted(waiting)}
        if not waiting:
            return
        index = waiting.pop(0)
        for name in slow:
            values[name][index] = _amplitude(METHODS[name], here[index])


def _ends_first(count: int) -> list[int]:
    """All indices: first the ends, then the middles of the gaps.

    Examples
    --------
    >>> _ends_first(5)
    [0, 4, 2, 1, 3]
    """
    order, stride = [0, count - 1], count - 1
    while stride > 1:
        stride = (stride + 1) // 2
        order += [index for index in range(0, count, stride) if index not in order]
    return order


def _amplitude(method: Method, oscillator: Oscillator) -> float | None:
    try:
        return plain_number(method.solve(oscillator).amplitude_mean_square)
    except (NotCoveredError, NoStationaryStateError, NoConvergenceError):
        return None


def plain_number(value: float) -> float | None:
    """A number for JSON; None if it is not finite."""
    return float(f"{value:.7g}") if math.isfinite(value) else None


def plain(values: npt.ArrayLike) -> list[float | None]:
    """Numbers for JSON."""
    return [plain_number(float(value)) for value in np.asarray(values)]
