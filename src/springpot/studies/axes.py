"""An axis of a grid: a list of numbers, or evenly or geometrically spaced ones; tables of axes; a sample of devices."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, WithJsonSchema

from springpot.machine.arguments import Uncertain, finite_number
from springpot.machine.faults import FileError, listed, shown
from springpot.problem.free_numbers import nominal, uncertain_numbers
from springpot.problem.numbers import numbers_of
from springpot.problem.system import System

MOST_VALUES = 1_000_000  # on all axes together
_FORMS = ("linspace", "geomspace")
AXIS = "draw"  # of a sample of devices
_MOST = 2**16  # devices


def flattened(table: Mapping[Any, Any]) -> dict[Any, Any]:
    """A table of axes with one name for each: TOML reads ``parts.stop.position = [...]`` as tables in tables.

    Examples
    --------
    >>> flattened({"order": [0.5], "parts": {"stop": {"position": {"linspace": [0, 1, 5]}}}})
    {'order': [0.5], 'parts.stop.position': {'linspace': [0, 1, 5]}}
    """
    return dict(_leaves(table, ""))


def _leaves(table: Mapping[Any, Any], before: str) -> Iterator[tuple[Any, Any]]:
    for key, value in table.items():
        name = f"{before}{key}" if before else key
        inside = isinstance(value, Mapping) and bool(value) and (bool(before) or key == "parts")
        if inside and (name.count(".") < 2 or not set(value) <= {*_FORMS}):
            yield from _leaves(value, f"{name}.")
        else:
            yield name, value


def spread(count: int, most: int) -> list[int]:
    """Up to ``most`` numbers below ``count``, in an order whose first few cover the range.

    Examples
    --------
    >>> spread(5, 12), spread(1000, 4)
    ([0, 2, 4, 1, 3], [309, 927, 545, 163])
    """
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    if count <= most:
        return sorted(range(count), key=lambda number: number * golden % 1.0)
    return [*dict.fromkeys(int(((number + 0.5) * golden) % 1.0 * count) for number in range(most))]


def some_points(shape: Sequence[int], most: int, axes: int = 8) -> list[int]:
    """Numbers of up to ``most`` points of a grid, and of its corners, in order; of so many axes at most.

    Examples
    --------
    >>> some_points((2, 3), 100), some_points((1000, 1000), 1)
    ([0, 1, 2, 3, 4, 5], [0, 999, 309016, 999000, 999999])
    """
    chosen = set(spread(math.prod(shape), most))
    ends = [{0, length - 1} if number < axes else {0} for number, length in enumerate(shape)]
    return sorted(chosen.union(int(np.ravel_multi_index(corner, shape)) for corner in itertools.product(*ends)))


def _axis(value: object) -> tuple[float, ...]:
    """The values of an axis, from a list (in Python also an array), ``linspace`` or ``geomspace``."""
    if isinstance(value, np.ndarray) and value.ndim == 1:
        value = value.tolist()
    if isinstance(value, list | tuple):
        if not value:
            raise ValueError("an axis must have at least one value")
        if len(value) > MOST_VALUES:
            raise ValueError(f"an axis must have at most {MOST_VALUES:,} values, not {len(value):,}")
        return tuple(_number(number, "every value") for number in value)
    if isinstance(value, Mapping) and len(value) == 1:
        (form, numbers), *_ = value.items()
        if form in _FORMS:
            return _spaced(str(form), numbers)
    raise ValueError(
        "an axis must be a list of numbers, {linspace = [start, end, count]} or {geomspace = [start, end, count]}, "
        f"not {shown(value)}"
    )


def _number(value: object, name: str) -> float:
    if type(value) is float and math.isfinite(value):  # the usual case, made fast
        return value
    try:
        return finite_number(value, name)
    except TypeError as error:  # in a file every error is a ValueError
        raise ValueError(str(error)) from None


def _spaced(form: str, numbers: object) -> tuple[float, ...]:
    if not isinstance(numbers, list | tuple) or len(numbers) != 3:
        raise ValueError(f"{form} must be [start, end, count], not {shown(numbers)}")
    start, end = (_number(number, f"{form}'s start and end") for number in numbers[:2])
    count = numbers[2]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST_VALUES:
        raise ValueError(f"{form}'s count must be a whole number from 1 to {MOST_VALUES:,}, not {shown(count)}")
    if not math.isfinite(end - start):
        raise ValueError(f"{form}'s start and end are too far apart for double precision")
    if form == "geomspace" and not min(start, end) > 0.0:
        raise ValueError("geomspace's start and end must be positive")
    values = np.linspace(start, end, count) if form == "linspace" else np.geomspace(start, end, count)
    # twelve digits: 0.3, not 0.30000000000000004, so that a finer axis meets the points of a coarser one
    return tuple(float(f"{value:.12g}") for value in values.tolist())


_SPACED = {"type": "array", "prefixItems": [{"type": "number"}, {"type": "number"}, {"type": "integer", "minimum": 1}],
           "minItems": 3, "maxItems": 3}  # fmt: skip
Axis = Annotated[
    tuple[float, ...],
    BeforeValidator(_axis),
    WithJsonSchema(
        {
            "description": "A list of numbers, or start, end and count of evenly or geometrically spaced ones.",
            "anyOf": [
                {"type": "array", "items": {"type": "number"}, "minItems": 1},
                *(
                    {"type": "object", "properties": {form: _SPACED}, "required": [form], "additionalProperties": False}
                    for form in _FORMS
                ),
            ],
        }
    ),
]


def with_draws(content: dict[str, Any], system: System, title: str) -> dict[str, Any]:
    """The content of a study, with the devices of ``draws`` as the columns of a zipped axis.

    The devices are those that `springpot.scatter` draws with the same seed and as many devices.  More draws hold those
    of fewer.

    Parameters
    ----------
    content : dict
    system : System
    title : str
        Of the study, for messages.

    Raises
    ------
    FileError
        If there are uncertain numbers and no ``draws``, or the other way round, or it is no such number.
    """
    numbers, draws = uncertain_numbers(system), content.get("draws")
    if not numbers and draws is None:
        return content
    from springpot.scattering.devices import correlated, drawn  # brings the whole engine
    from springpot.scattering.estimates import SCRAMBLINGS

    told = f"{title} is not right: draws must be a power of two from {SCRAMBLINGS} to {_MOST}"
    if not numbers:
        raise FileError(f"{title} is not right: draws are of uncertain numbers, and the system has none.")
    if draws is None:
        raise FileError(f"{told}, for {listed([*numbers])} {'is' if len(numbers) == 1 else 'are'} uncertain.")
    whole = isinstance(draws, int) and not isinstance(draws, bool)
    if not whole or not SCRAMBLINGS <= draws <= _MOST or draws & (draws - 1):
        raise FileError(f"{told}, not {shown(draws)}.")
    zipped, seed = content.get("zipped", {}), content.get("seed", 1)
    if not isinstance(zipped, Mapping) or not isinstance(seed, int) or seed < 0:
        return {name: each for name, each in content.items() if name != "draws"}  # which is refused with its reason
    if AXIS in zipped:
        raise FileError(f"{title} is not right: zipped axis {AXIS!r} must have another name beside draws.")
    values = drawn(numbers, draws, seed, correlated({}, numbers)).values
    own = dict(zip(numbers, values.T.tolist(), strict=True))
    columns = {
        name: [number.at(value) for value in own[number.name]]
        for name, number in numbers_of(system).items() if isinstance(number, Uncertain)
    }  # fmt: skip
    rest = {name: each for name, each in content.items() if name != "draws"}
    return {**rest, "system": nominal(system), "zipped": {**zipped, AXIS: columns}}
