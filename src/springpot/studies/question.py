"""The study file: a grid of oscillators, the methods, and the settings of Monte Carlo.

A file is TOML; its content is the model `Study` below, whose JSON schema `springpot study schema` prints.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    FailFast,
    Field,
    ValidationError,
    WithJsonSchema,
    create_model,
    model_validator,
)

from springpot.arguments import finite_number
from springpot.faults import FileFault, shown
from springpot.options import hints
from springpot.oscillator import Oscillator
from springpot.studies.wording import sentence, unknown_key
from springpot.theory.registry import METHODS
from springpot.toml import read_toml
from springpot.units import UNITS

__all__ = ["PARAMETERS", "QUANTITIES", "Axis", "MonteCarlo", "Study", "read_study"]

MOST_TASKS = 10_000_000
MOST_VALUES = 1_000_000  # on all axes together

if TYPE_CHECKING:
    Method = str
else:
    Method = Literal[(*METHODS, "monte_carlo")]
Parameter = Literal["order", "coefficient", "natural_frequency", "intensity", "position", "restitution"]
Quantity = Literal[
    "amplitude_mean_square", "x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean",
    "impact_speed_mean_square",
]  # fmt: skip
PARAMETERS: tuple[str, ...] = get_args(Parameter)
"""Numbers of the oscillator that an axis can run over."""
QUANTITIES: tuple[str, ...] = get_args(Quantity)
"""The stationary moments that every method gives."""
_TAKEN = {name + part for name in UNITS for part in ("", "_se", "_error")} | {
    *PARAMETERS, "theory", "method", "done", "said",
}  # fmt: skip
Point = dict[str, float | str | bool]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


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
        if form in ("linspace", "geomspace"):
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
                    for form in ("linspace", "geomspace")
                ),
            ],
        }
    ),
]


class Fixed(_Strict):
    """Parameters with the same value at every point; an axis must not have the same name."""

    order: float = 0.5
    coefficient: float = 1.0
    natural_frequency: float = 1.0
    intensity: float = 1.0
    position: float = 0.0
    restitution: float = 1.0
    side: Literal["above", "below"] = "above"
    barrier: bool = True


_Settings = create_model(  # a study has a seed of its own, and stores no paths
    "_Settings",
    __base__=_Strict,
    **{
        name: (Annotated[hint, Field(strict=False)] if name == "window" else hint, None)
        for name, hint in hints("seed", "threads", "record", "record_every").items()
    },
)  # type: ignore[call-overload]


class MonteCarlo(_Settings):  # type: ignore[misc, valid-type]
    """How Monte Carlo is run: one of ``rtol``, ``path_times`` or the settings of a run.

    ``rtol`` is the total relative error wanted of the study's quantities.  ``path_times`` (runs scaled to each point,
    see `springpot.simulation.scaled`) gives every point about the same standard error.  All others are the arguments of
    `springpot.simulate`; without ``start`` and an initial state, the start is stationary.
    """

    rtol: float | None = Field(None, ge=1e-4, le=0.5)
    path_times: float | None = Field(None, ge=1e3, le=1e9)

    @model_validator(mode="after")
    def _one_way(self) -> MonteCarlo:
        given = self.given()
        alone = [name for name in ("rtol", "path_times") if name in given]
        if not given:
            raise ValueError("say how: rtol = 0.02, path_times = 1e5, or settings such as paths and duration")
        if alone and len(given) > 1:
            other = next(name for name in given if name != alone[0])
            raise ValueError(f"{alone[0]} chooses all settings, so {other} cannot be given with it")
        return self

    def given(self) -> dict[str, Any]:
        """The settings in the file."""
        return {name: value for name, value in self.model_dump().items() if value is not None}


class Study(_Strict):
    """A grid of oscillators, and the methods by which they are solved.

    Attributes
    ----------
    name : str
        Names the study; a store holds one study only.
    seed : int
        Every point's own seed is made from it and from the point's numbers.
    methods : tuple of str
        Methods of the theory, and ``monte_carlo``.
    quantities : tuple of str
        Quantities that ``rtol`` controls, and that tables and charts show.  The store keeps all quantities.
    fixed : Fixed
    axes : dict
        Name of a parameter to its values: the grid is their product.
    zipped : dict
        Name of an axis of your own to columns of equal length, which run together.
    monte_carlo : MonteCarlo or None
        Needed if ``methods`` has ``monte_carlo``.

    Examples
    --------
    >>> study = Study.model_validate({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5]}})
    >>> study.shape, [point["order"] for point in study.points()]
    ({'order': 2}, [0.25, 0.5])
    """

    name: str = Field(min_length=1, max_length=200)
    methods: Annotated[tuple[Method, ...], Field(strict=False, min_length=1, max_length=len(METHODS) + 1), FailFast()]
    seed: int = Field(1, ge=0, le=2**63 - 1)
    quantities: Annotated[tuple[Quantity, ...], Field(strict=False, min_length=1, max_length=7), FailFast()] = (
        "amplitude_mean_square",
    )
    fixed: Fixed = Field(default_factory=Fixed)
    axes: dict[Parameter, Axis] = Field(default_factory=dict)
    zipped: dict[str, dict[Parameter, Axis]] = Field(default_factory=dict)
    monte_carlo: MonteCarlo | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Study:
        for what, names in (("methods", self.methods), ("quantities", self.quantities)):
            if len(set(names)) < len(names):
                raise ValueError(f"{what} names {_twice(names)} twice")
        if ("monte_carlo" in self.methods) != (self.monte_carlo is not None):
            raise ValueError('methods must name "monte_carlo" if, and only if, there is a table [monte_carlo]')
        parameters = [*self.axes, *(name for columns in self.zipped.values() for name in columns)]
        if not parameters:
            raise ValueError("there must be an axis, such as [axes] order = [0.25, 0.5]")
        if len(set(parameters)) < len(parameters):
            raise ValueError(f"{_twice(parameters)} is on two axes: leave out one of the two")
        for name in parameters:
            if name in self.fixed.model_fields_set:
                raise ValueError(f"{name} is fixed and is also on an axis: leave out one of the two")
        for title, columns in self.zipped.items():
            if title in _TAKEN or not title.isidentifier():
                raise ValueError(f"zipped axis {title!r} needs a name of its own, such as case")
            if len({len(column) for column in columns.values()}) != 1:
                raise ValueError(f"zipped axis {title} needs at least one column, and columns of equal length")
        if sum(len(values) for _, values in self.columns.values()) > MOST_VALUES:
            raise ValueError(f"the axes have more than {MOST_VALUES:,} values together: make them shorter")
        for title, part in zip(self._titles(), self._columns_of_axes(), strict=True):
            rows = [*zip(*part.values(), strict=True)]
            if len(set(rows)) < len(rows):
                again = _twice(rows)
                raise ValueError(f"axis {title} holds {again[0] if title in self.axes else again} twice")
        if math.prod(self.shape.values()) * len(self.methods) > MOST_TASKS:
            raise ValueError(f"there are more than {MOST_TASKS:,} tasks: make the axes shorter")
        self._check_oscillators()
        return self

    @property
    def shape(self) -> dict[str, int]:
        """Length of each axis of the grid, by name."""
        columns = self._columns_of_axes()
        return {name: len(next(iter(part.values()))) for name, part in zip(self._titles(), columns, strict=True)}

    @property
    def columns(self) -> dict[str, tuple[str, tuple[float, ...]]]:
        """Axis and values of each parameter that varies."""
        columns_by_parameter = {str(name): (str(name), axis) for name, axis in self.axes.items()}
        for title, columns in self.zipped.items():
            columns_by_parameter |= {str(name): (title, axis) for name, axis in columns.items()}
        return columns_by_parameter

    def points(self) -> Iterator[Point]:
        """All points of the grid, the last axis fastest, each with all parameters of its oscillator."""
        fixed = self.fixed.model_dump()
        axes = [*self._columns_of_axes()]
        for chosen in itertools.product(*(zip(*columns.values(), strict=True) for columns in axes)):
            point = dict(fixed)
            for columns, values in zip(axes, chosen, strict=True):
                point.update(zip(columns, values, strict=True))
            yield point

    def point(self, index: int) -> Point:
        """The point with this index in `points`."""
        point: Point = self.fixed.model_dump()
        for values in reversed([*self._columns_of_axes()]):
            index, place = divmod(index, len(next(iter(values.values()))))
            point.update((name, column[place]) for name, column in values.items())
        return point

    def _titles(self) -> list[str]:
        return [*map(str, self.axes), *self.zipped]

    def _columns_of_axes(self) -> Iterator[dict[str, tuple[float, ...]]]:
        """The columns of each axis of the grid, by parameter."""
        for name, axis in self.axes.items():
            yield {str(name): axis}
        for columns in self.zipped.values():
            yield {str(name): column for name, column in columns.items()}

    def _check_oscillators(self) -> None:
        """Raise an error if a value of an axis is outside the range of its parameter.

        Ranges are intervals, so the smallest and the largest value of each column are checked.
        """
        base = self.fixed.model_dump()
        _check_oscillator(base, {name: f"fixed.{name}" for name in base})
        for name in self.axes:
            place = {str(name): f"axes.{name}"}
            for value in (min(self.axes[name]), max(self.axes[name])):
                _check_oscillator({**base, name: value}, place)
        for title, columns in self.zipped.items():
            for name, column in columns.items():
                for value in (min(column), max(column)):
                    _check_oscillator({**base, name: value}, {str(name): f"zipped.{title}.{name}"})


def _check_oscillator(point: Point, places: Mapping[str, str]) -> None:
    """Check an oscillator; in errors the name of the parameter is replaced by its place in the file."""
    try:
        oscillator_of(point)
    except ValueError as error:
        name, space, rest = str(error).partition(" ")
        raise ValueError(places.get(name, name) + space + rest) from None


def _twice(names: Iterable[Any]) -> Any:
    """The first name that occurs for the second time."""
    before: set[Any] = set()
    return next(name for name in names if name in before or before.add(name))  # type: ignore[func-returns-value]


def oscillator_of(point: Mapping[str, Any]) -> Oscillator:
    """The oscillator at a point of a grid."""
    return Oscillator.from_numbers(**point)


def read_study(source: str | Path | Mapping[str, Any] | Study) -> Study:
    """A study from a file, or from the same content as a mapping.

    Parameters
    ----------
    source : str, Path, mapping or Study
        A TOML file's place, or its content.

    Returns
    -------
    Study

    Raises
    ------
    ValueError
        One sentence: the error and its place, or why the file cannot be read.
    FileNotFoundError
        If there is no such file.

    Examples
    --------
    >>> try:
    ...     read_study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.5, 1.5]}})
    ... except ValueError as error:
    ...     print(error)
    the study is not right: axes.order must be in [0, 1], not 1.5. It runs from 0 (a spring) to 1 (a dashpot).
    """
    if isinstance(source, Study):
        return source
    if isinstance(source, Mapping):
        title, content = "the study", dict(source)
    else:
        title = f"study file {str(source)!r}"
        content = read_toml(source, title)
    try:
        _check_keys(content)
        return Study.model_validate(content)
    except ValidationError as error:
        raise FileFault(f"{title} is not right: {sentence(error)}") from None
    except FileFault as fault:
        raise FileFault(f"{title} is not right: {fault}") from None


def _check_keys(content: Mapping[str, Any]) -> None:
    """Raise an error if a table has an unknown key."""
    tables: list[tuple[str, Any, Iterable[str]]] = [
        ("", content, Study.model_fields),
        ("fixed", content.get("fixed"), Fixed.model_fields),
        ("axes", content.get("axes"), PARAMETERS),
        ("monte_carlo", content.get("monte_carlo"), MonteCarlo.model_fields),
    ]
    zipped = content.get("zipped")
    if isinstance(zipped, Mapping):
        tables += [(f"zipped.{shown(title)[1:-1]}", columns, PARAMETERS) for title, columns in zipped.items()]
    for place, table, known in tables:
        if isinstance(table, Mapping):
            for key in table:
                if key not in known:
                    raise FileFault(unknown_key(key, place, known))
