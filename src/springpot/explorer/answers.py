"""Theory for the page: a table of all methods, their curves, and <A^2> over the order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.evidence.recommendation import recommended
from springpot.evidence.reliability import warnings_of
from springpot.explorer.question import papers_of
from springpot.explorer.requests import followed
from springpot.machine.arrays import Floats
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import ColoredNoise, Constant, KanaiTajimiNoise, Springpot, ThermalNoise, WhiteNoise
from springpot.problem.system import System
from springpot.simulation.plan.signals import signals_of
from springpot.theory import NoConvergenceError, NoStationaryStateError, NotCoveredError
from springpot.theory.distributions import normal
from springpot.theory.registry import METHODS
from springpot.theory.solve import solve_one

POINTS = 161  # of a density's curve
ORDERS = tuple(float(order) for order in np.linspace(0.04, 1.0, 33).round(6))
"""Orders at which <A^2> is drawn."""
_GAUSSIAN = (WhiteNoise, ColoredNoise, KanaiTajimiNoise, ThermalNoise, Constant)
AVERAGING = ("averaging", "averaging_printed")
"""The paper's method: drawn with the recommended one, and used where there is no stationary state."""

_UNKNOWN = NotCoveredError, NoStationaryStateError, NoConvergenceError


@lru_cache(maxsize=256)
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
    shown = choice.guess
    places = _places(system, answers[shown]) if shown else {}
    beside = AVERAGING[1] if shown == AVERAGING[0] else AVERAGING[0]
    return {
        "recommended": choice.method or None,
        "shown": shown or None,
        "drawn": [name for name in (shown, beside) if name in answers],
        "statements": statements,
        "places": {name: plain(place) for name, place in places.items()},
        "methods": {
            name: {
                "moments": {moment: plain_number(value) for moment, value in answer.numbers.items()},
                "warnings": list(warnings_of(answer)),
                "assumptions": list(answer.assumptions),
                "densities": _densities(answer, places),
            }
            for name, answer in answers.items()
        },
    }


def _places(system: System, answer: Any) -> dict[str, Floats]:
    """The arguments at which the densities are drawn: of x, v and impact speed, and A of the paper's problem."""
    found, places = answer.numbers, dict[str, Floats]()
    for own, signal in zip(system.coordinates.beginnings, signals_of(system), strict=False):
        mean, square = found[f"{own}x_mean"], found[f"{own}x_mean_square"]
        spread = math.sqrt(max(square - mean**2, 1e-12 * square))
        low, high = max(mean - 4.5 * spread, signal.low), min(mean + 4.5 * spread, signal.high)
        fastest = 4.0 * math.sqrt(found[f"{own}v_mean_square"])
        if low < high and fastest > 0.0:
            places[f"{own}x"] = np.linspace(low, high, POINTS)
            places[f"{own}v"] = np.linspace(-fastest, fastest, POINTS)
    for paper in papers_of(system) if places else ():
        # with a preload A is at least the wall's distance, and A^2 minus its square varies
        least = 0.0 if paper.barrier is None else max(paper.direction * paper.barrier.position, 0.0)
        above = max(answer.amplitude_mean_square - least**2, 1e-6 * answer.amplitude_mean_square)
        places["amplitude"] = np.linspace(least, math.sqrt(least**2 + 9.0 * above), POINTS)
    fast = found.get("impact_speed_mean_square", math.nan)
    if places and len(system.stops) == 1 and fast > 0.0:  # of several walls, methods have a law for each
        places["impact_speed"] = np.linspace(0.0, 3.0 * math.sqrt(fast), POINTS)
    return places


def _densities(answer: Any, places: Mapping[str, Floats]) -> dict[str, list[float | None]]:
    """The densities that a method has, at these places; None where one is not a number."""
    curves = {}
    for name, place in places.items():
        if (curve := getattr(answer, f"{name}_density", None) or _gaussian(answer, name)) is not None:
            with suppress(*_UNKNOWN):
                curves[name] = plain(curve(place))
    return curves


def _gaussian(answer: Any, name: str) -> Callable[[Floats], Floats] | None:
    """The density of a displacement or velocity of a linear system under Gaussian noise; None of anything else."""
    excitations = answer.system.excitations.values()
    if answer.method != "linear" or not all(isinstance(part, _GAUSSIAN) for part in excitations):
        return None
    found, (of, what) = answer.numbers, (name[:-1], name[-1])
    square = found.get(f"{of}{what}_mean_square", 0.0)
    mean = found[f"{of}x_mean"] if what == "x" else 0.0
    if not (variance := square - mean**2) > 0.0:  # no displacement or velocity, or at rest
        return None
    return lambda place: normal(place - mean, variance)


def growth(
    system: System, answers: Mapping[str, Any], times: Floats, *, from_rest: bool
) -> dict[str, dict[str, list[float | None]]]:
    """<A^2> of the paper's problem, or <x^2> of all that is followed in another, of each method at times from rest.

    By the names of what is followed, and of the methods.  A method without a transient has its stationary value.
    Without a stationary state averaging still has the growing response.
    """
    papers = papers_of(system)
    moment = "amplitude_mean_square" if papers else "x_mean_square"
    names = {one["name"]: one["name"] + ("mean_square" if one["pair"] else moment) for one in followed(system)}
    whole = {
        begin: {method: [plain_number(answer.numbers[name])] * times.size for method, answer in answers.items()}
        for begin, name in names.items()
    }
    if not from_rest:
        return whole
    for begin, name in names.items():
        for method, answer in answers.items():
            if curve := getattr(answer, f"{name}_at", None):
                with suppress(*_UNKNOWN):
                    whole[begin][method] = plain(curve(times))
    for method in AVERAGING * len(papers):
        with suppress(NotCoveredError):
            growing: Any = METHODS[method].solve(system)
            whole[""][method] = plain(growing.mean_square(times))
    return whole


def along_the_order(paper: Dimensionless) -> Iterator[dict[str, Any]]:
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
    >>> first = next(along_the_order(Dimensionless()))
    >>> len(first["methods"]["averaging"]), len(first["missing"])
    (33, 33)
    """
    here = replace(paper, springpot=Springpot(0.5, paper.springpot.coefficient))  # the same for all its orders
    values: dict[str, list[float | None]] = {
        name: [_amplitude(name, here, order) if method.over_order == "at once" else None for order in ORDERS]
        for name, method in METHODS.items()
        if method.over_order
    }
    slow = [name for name in values if METHODS[name].over_order == "one by one"]
    waiting = _ends_first(len(ORDERS))
    while True:
        yield {"orders": ORDERS, "methods": {name: values[name][:] for name in values}, "missing": sorted(waiting)}
        if not waiting:
            return
        index = waiting.pop(0)
        for name in slow:
            values[name][index] = _amplitude(name, here, ORDERS[index])


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


@lru_cache(maxsize=64 * len(ORDERS) * sum(bool(method.over_order) for method in METHODS.values()))
def _amplitude(method: str, paper: Dimensionless, order: float) -> float | None:
    """Kept of 64 curves, for all tabs: the number only, for a system that was solved is large."""
    springpot = Springpot(order, paper.springpot.coefficient)
    system = Oscillator(paper.natural_frequency, springpot, paper.barrier, paper.excitation)
    with suppress(*_UNKNOWN):
        return plain_number(METHODS[method].solve(system).amplitude_mean_square)
    return None


def plain_number(value: float) -> float | None:
    """A number for JSON; None if it is not finite."""
    return float(f"{value:.7g}") if math.isfinite(value) else None


def plain(values: npt.ArrayLike) -> list[float | None]:
    """Numbers for JSON."""
    return [plain_number(float(value)) for value in np.asarray(values)]
