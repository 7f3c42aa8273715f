"""What the page does with a file of measured data: it is read, and ticked numbers of the system are fitted to it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from springpot.explorer.sliders import Slider, numbers, sliders
from springpot.explorer.tolerances import check_known
from springpot.explorer.views import sizes
from springpot.figures.fits import PLACES, driven_parts, is_driven, some_periods
from springpot.machine.arguments import Free
from springpot.machine.plain import plain
from springpot.problem.free_numbers import free, free_numbers, with_values
from springpot.problem.numbers import ROOT, with_numbers
from springpot.problem.system import System

if TYPE_CHECKING:
    from springpot.fitting.likelihood import Table
    from springpot.fitting.reading import Data

FARTHER = 1000.0  # beyond the ends of a logarithmic slider, on either side
FARTHER_SIMULATED = 10.0  # the same, where every place between the bounds may be simulated
INSIDE = 1e-3  # of a linear slider, from its ends
MOST_POINTS = 2000  # that are drawn


def freed(system: System, names: Sequence[str], farther: float = FARTHER) -> System:
    """The system with some of its numbers free, by the names of their sliders.

    Those that are free in the file keep their bounds if they are ticked, and are held if not.  The bounds of the others
    are the ends of linear sliders, and ``farther`` times beyond those of logarithmic ones.

    Raises
    ------
    ValueError
        If there is no such number, or one cannot be free.

    Examples
    --------
    >>> from springpot.problem.free_numbers import free_numbers
    >>> from springpot.problem.parts import Spring, Springpot, WhiteNoise
    >>> system = System(Spring(80.0), Springpot(0.4, 2.0), WhiteNoise(1.0))
    >>> free_numbers(freed(system, ["springpot-order", "springpot-coefficient"]))["springpot_order"].low
    0.001
    """
    known = numbers(system)
    check_known("free", names, known)
    own = {one.name: one for one in sliders(system, sizes(system))}
    held = with_values(system, {name: float(number) for name, number in free_numbers(system).items()})
    return with_numbers(held, {ROOT + name.replace("-", "."): _free(own[name], known[name], farther) for name in names})


def _free(slider: Slider, value: float, farther: float) -> float:
    """A free number that starts where the slider is."""
    low, high = slider.begin, slider.end
    if isinstance(value, Free):
        pass
    elif slider.log:
        low, high = low / farther, high * farther
    else:
        low, high = low + INSIDE * (high - low), high - INSIDE * (high - low)
    return free(_word(slider.name), min(max(float(value), low), high), (low, high))


def _word(name: str) -> str:
    return name.replace("-", "_")


def described(data: Data) -> str:
    """What a file has, in words."""
    kind = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(data).__name__.removeprefix("Measured")).lower()
    count = next((len(values) for values in vars(data).values() if hasattr(values, "__len__")), 0)
    kind = f"{kind} with its input" if is_driven(data) else kind
    return f"{kind}, {count} points" if count else kind


def fitted(
    system: System,
    names: Sequence[str],
    data: Data,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> dict[str, Any]:
    """The fit of ticked numbers, for the page: values with errors, the points, and what there is to doubt.

    Raises
    ------
    TypeError, ValueError, Stopped
        As `springpot.fit`.
    """
    from springpot.fitting import MeasuredModuli, MeasuredStatistics, fit

    if not names:
        raise ValueError("free: tick the numbers that are to be found.")
    farther = FARTHER_SIMULATED if isinstance(data, MeasuredStatistics) or is_driven(data) else FARTHER
    model = freed(system, names, farther)
    if is_driven(data):
        model = _without_noise(model, names)
    found = fit(model, data, progress=progress, stop=stop)
    table = found.table
    axis = str(table.axis)
    of_statistics = axis == "statistic"  # of many units: no chart shows them together
    return plain(
        {
            "values": [
                {
                    "name": name,
                    "value": found.values[_word(name)],
                    "error": found.errors[_word(name)],
                    "interval": found.interval(_word(name)),
                    "bound": found.at_bounds.get(_word(name), ""),
                    "adds": isinstance(data, MeasuredModuli) and _adds(name),
                }
                for name in names
            ],
            "axis": PLACES.get(axis, axis.replace("_", " ")),
            "logarithmic": axis == "frequency_hz",
            "groups": [] if of_statistics else _paths(table, data) if is_driven(data) else _groups(table),
            "statistics": _rows(table) if of_statistics else [],
            "warnings": found.warnings,
        }
    )


def _without_noise(model: System, names: Sequence[str]) -> System:
    """The model without the excitation of the page, in whose place the measured input is.

    Raises
    ------
    ValueError
        If a ticked number is of it.
    """
    kept = {name: part for name, part in model.stated() if name not in model.excitations or name in model.constants}
    found = System(**kept)
    if gone := [name for name in names if _word(name) not in free_numbers(found)]:
        raise ValueError(f"free: {gone[0]} is of the excitation, and the input was measured: untick it.")
    return found


def _adds(name: str) -> bool:
    """Whether several equal parts side by side have the sum of this number.

    Examples
    --------
    >>> [_adds(name) for name in ("spring-stiffness", "springpot-order", "cubic-coefficients-3")]
    [True, False, True]
    """
    return not {"stiffness", "coefficient", "coefficients"}.isdisjoint(name.split("-")[1:])


def _groups(table: Table) -> list[dict[str, Any]]:
    """Points for a chart, group by group."""
    found = []
    for group in dict.fromkeys(table.group.tolist()):
        own = (table.group == group).nonzero()[0][:MOST_POINTS]
        columns = {"at": table.at, "data": table.data, "fitted": table.fitted}
        found.append({"name": str(group)} | {name: column[own].tolist() for name, column in columns.items()})
    return found


def _paths(table: Table, data: Any) -> list[dict[str, Any]]:
    """Some periods of each measured point: measured, simulated and what is left."""
    at = data.time[some_periods(data)].tolist()
    return [
        {
            "name": f"{of} of {mass}" if mass else of,
            "unit": {"x": "m", "v": "m/s", "a": "m/s²"}[of],
            "at": at,
            **{name: own.tolist() for name, own in zip(("data", "fitted", "residual"), rows, strict=True)},
        }
        for of, mass, rows in driven_parts(table, data)
    ]


def _rows(table: Table) -> list[dict[str, Any]]:
    """Statistics for a table: name, measured value and error, fitted value, difference in errors."""
    error = table.error if table.error is not None else table.data * math.nan
    columns = table.group, table.data, error, table.fitted, table.residual
    names = "name", "data", "error", "fitted", "residual"
    return [dict(zip(names, row, strict=True)) for row in zip(*(own.tolist() for own in columns), strict=True)]
