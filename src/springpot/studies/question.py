"""The study file: a grid of oscillators, the methods to answer them by, and how well Monte Carlo must know.

A file is TOML; what it may hold is the model `Study` below, whose JSON schema `springpot study schema` prints.
"""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, WithJsonSchema, model_validator

from springpot.oscillator import Barrier, Oscillator, Springpot, WhiteNoise, finite_number
from springpot.units import UNITS

__all__ = ["PARAMETERS", "QUANTITIES", "Axis", "MonteCarlo", "Study", "read_study"]

MOST_TASKS = 10_000_000

Method = Literal[
    "averaging_printed",
    "averaging",
    "averaging_shifted",
    "envelope",
    "closure",
    "fokker_planck",
    "exact",
    "monte_carlo",
]
Parameter = Literal["order", "coefficient", "natural_frequency", "intensity", "position", "restitution"]
Quantity = Literal[
    "amplitude_mean_square", "x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean",
    "impact_speed_mean_square",
]  # fmt: skip
PARAMETERS: tuple[str, ...] = get_args(Parameter)
"""Numbers of the oscillator that an axis can run over."""
QUANTITIES: tuple[str, ...] = get_args(Quantity)
"""The stationary numbers that every method answers with."""
_TAKEN = {name + part for name in UNITS for part in ("", "_se", "_error")} | {
    *PARAMETERS, "theory", "method", "done", "said",
}  # fmt: skip
Point = dict[str, float | str | bool]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


def _axis(value: object) -> tuple[float, ...]:
    """The values of an axis, from a list (from Python, an array as well) or from one of the two short forms."""
    if isinstance(value, np.ndarray) and value.ndim == 1:
        value = value.tolist()
    if isinstance(value, list | tuple):
        if not value:
            raise ValueError("an axis must have at least one value")
        return tuple(_number(number, "every value") for number in value)
    if isinstance(value, Mapping) and len(value) == 1:
        (form, numbers), *_ = value.items()
        if form in ("linspace", "geomspace"):
            return _spaced(str(form), numbers)
    raise ValueError(
        "an axis must be a list of numbers, {linspace = [start, end, count]} or {geomspace = [start, end, count]}, "
        f"not {value!r}"
    )


def _number(value: object, name: str) -> float:
    try:
        return finite_number(value, name)
    except TypeError as error:  # a fault of the file like any other
        raise ValueError(str(error)) from None


def _spaced(form: str, numbers: object) -> tuple[float, ...]:
    if not isinstance(numbers, list | tuple) or len(numbers) != 3:
        raise ValueError(f"{form} must be [start, end, count], not {numbers!r}")
    start, end = (_number(number, f"{form}'s start and end") for number in numbers[:2])
    count = numbers[2]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST_TASKS:
        raise ValueError(f"{form}'s count must be a whole number from 1 to {MOST_TASKS:,}, not {count!r}")
    if form == "geomspace" and not min(start, end) > 0.0:
        raise ValueError("geomspace's start and end must be positive")
    values = np.linspace(start, end, count) if form == "linspace" else np.geomspace(start, end, count)
    # twelve digits: 0.3, not 0.30000000000000004, so that a finer axis meets the points of a coarser one
    return tuple(float(f"{value:.12g}") for value in values)


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
    """What is the same at every point; an axis of the same name may not be there as well."""

    order: float = 0.5
    coefficient: float = 1.0
    natural_frequency: float = 1.0
    intensity: float = 1.0
    position: float = 0.0
    restitution: float = 1.0
    side: Literal["above", "below"] = "above"
    barrier: bool = True


class MonteCarlo(_Strict):
    """How Monte Carlo is run: one of ``rtol``, ``path_times`` or the settings of a run.

    ``rtol`` is the total relative error wanted of the study's quantities.  ``path_times`` (adapted runs scaled to each
    point, see `springpot.simulation.scaled`) gives every point about the same standard error.  All others are the
    arguments of `springpot.simulate`; without ``start`` and an initial state, the start is stationary.
    """

    rtol: float | None = Field(None, ge=1e-4, le=0.5)
    path_times: float | None = Field(None, ge=1e3, le=1e9)
    paths: int | None = Field(None, ge=1)
    duration: float | None = Field(None, gt=0.0)
    step: float | None = Field(None, gt=0.0)
    window: Annotated[tuple[float, float] | None, Field(strict=False)] = None
    scheme: Literal["default", "grunwald"] | None = None
    start: Literal["rest", "stationary"] | None = None
    initial_position: float | None = None
    initial_velocity: float | None = None
    derivative: Literal["caputo", "riemann-liouville"] | None = None
    memory_tolerance: float | None = None
    contact_tolerance: float | None = None

    @model_validator(mode="after")
    def _one_way(self) -> MonteCarlo:
        given = self.given()
        alone = [name for name in ("rtol", "path_times") if name in given]
        if not given:
            raise ValueError("say how: rtol = 0.02, path_times = 1e5, or settings such as paths and duration")
        if alone and len(given) > 1:
            other = next(name for name in given if name != alone[0])
            raise ValueError(f"{alone[0]} decides on everything, so {other} cannot be given with it")
        return self

    def given(self) -> dict[str, Any]:
        """What the file says, without what it leaves out."""
        return {name: value for name, value in self.model_dump().items() if value is not None}


class Study(_Strict):
    """A grid of questions.

    Attributes
    ----------
    name : str
        Names the study; a store holds one study only.
    seed : int
        Every point's own seed is made from it and from the point's numbers.
    methods : tuple of str
        Methods of the theory, and ``monte_carlo``.
    quantities : tuple of str
        What ``rtol`` controls, and what tables and charts show.  The store keeps every number.
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
    methods: Annotated[tuple[Method, ...], Field(strict=False, min_length=1)]
    seed: int = Field(1, ge=0, le=2**63 - 1)
    quantities: Annotated[tuple[Quantity, ...], Field(strict=False, min_length=1)] = ("amplitude_mean_square",)
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
            raise ValueError(f"{_twice(parameters)} runs along two axes")
        for name in parameters:
            if name in self.fixed.model_fields_set:
                raise ValueError(f"{name} is fixed and runs along an axis: leave out one of the two")
        for title, columns in self.zipped.items():
            if title in _TAKEN or not title.isidentifier():
                raise ValueError(f"zipped axis {title!r} needs a name of its own, such as case")
            if len({len(column) for column in columns.values()}) != 1:
                raise ValueError(f"zipped axis {title} needs at least one column, and columns of equal length")
        for title, values in self._coordinates():
            if len(set(values)) < len(values):
                raise ValueError(f"axis {title} holds {_twice(values)} twice")
        if math.prod(self.shape.values()) * len(self.methods) > MOST_TASKS:
            raise ValueError(f"there are more than {MOST_TASKS:,} tasks: make the axes shorter")
        self._check_oscillators()
        return self

    def _coordinates(self) -> Iterator[tuple[str, tuple[float | tuple[float, ...], ...]]]:
        """Each axis of the grid: its name and its values (tuples where columns are zipped)."""
        yield from self.axes.items()
        for title, columns in self.zipped.items():
            yield title, tuple(zip(*columns.values(), strict=True))

    @property
    def shape(self) -> dict[str, int]:
        """Length of each axis of the grid, by name."""
        return {name: len(values) for name, values in self._coordinates()}

    @property
    def columns(self) -> dict[str, tuple[str, tuple[float, ...]]]:
        """Each parameter that varies: the axis it runs along, and its values."""
        found = {str(name): (str(name), axis) for name, axis in self.axes.items()}
        for title, columns in self.zipped.items():
            found |= {str(name): (title, axis) for name, axis in columns.items()}
        return found

    def points(self) -> Iterator[Point]:
        """Every point of the grid, the last axis fastest: all numbers that make its oscillator."""
        fixed = self.fixed.model_dump()
        names = [[str(name)] for name in self.axes] + [[*map(str, c)] for c in self.zipped.values()]
        rows = [values for _, values in self._coordinates()]
        for chosen in itertools.product(*rows):
            point = dict(fixed)
            for axis, value in zip(names, chosen, strict=True):
                point.update(zip(axis, value if isinstance(value, tuple) else (value,), strict=True))
            yield point

    def _check_oscillators(self) -> None:
        """Every value of every axis makes an oscillator: what is wrong is said before any work."""
        base = self.fixed.model_dump()
        oscillator_of(base)
        for name, (_, values) in self.columns.items():
            for value in values:
                oscillator_of({**base, name: value})


def _twice(names: tuple[Any, ...] | list[Any]) -> Any:
    return next(name for number, name in enumerate(names) if name in names[:number])


def oscillator_of(point: Mapping[str, Any]) -> Oscillator:
    """The oscillator at a point of a grid."""
    wall = Barrier(point["position"], point["restitution"], point["side"])
    if not point["barrier"] and wall != Barrier():
        raise ValueError("barrier = false leaves no wall for position, restitution or side to describe")
    return Oscillator(
        natural_frequency=point["natural_frequency"],
        springpot=Springpot(point["order"], point["coefficient"]),
        barrier=wall if point["barrier"] else None,
        excitation=WhiteNoise(point["intensity"]),
    )


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
        One sentence that says what is wrong in it, and where.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> read_study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.5, 1.5]}})
    Traceback (most recent call last):
        ...
    ValueError: the study is not right: order must be in [0, 1], not 1.5. It runs from 0 (a spring) to 1 (a dashpot).
    """
    if isinstance(source, Study):
        return source
    if isinstance(source, Mapping):
        title, content = "the study", dict(source)
    else:
        title = f"study file {str(source)!r}"
        try:
            content = tomllib.loads(Path(source).read_text(encoding="utf-8"))
        except UnicodeDecodeError:
            raise ValueError(f"{title} is not text in UTF-8.") from None
        except tomllib.TOMLDecodeError as error:
            raise ValueError(f"{title} is not TOML: {error}.") from None
    try:
        return Study.model_validate(content)
    except ValidationError as error:
        raise ValueError(f"{title} is not right: {_sentence(error)}") from None


_WORDS = (
    ("Input should be ", "must be "),
    ("a valid dictionary or instance of Fixed", "a table"),
    ("a valid dictionary or instance of MonteCarlo", "a table"),
    ("a valid dictionary", "a table"),
    ("a valid integer", "a whole number"),
    ("a valid number", "a number"),
    ("a valid string", "a text in quotes"),
    ("a valid tuple", "a list"),
    ("String should have at least 1 character", "must not be empty"),
    ("Tuple should have at least 1 item after validation, not 0", "must not be empty"),
    ("String should have", "must have"),
)
"""What pydantic says, and what the reader of a TOML file understands."""


def _sentence(error: ValidationError) -> str:
    """The first fault, told in the words of the file."""
    fault = error.errors(include_url=False)[0]
    place = ".".join(str(part) for part in fault["loc"] if part != "[key]")
    if fault["type"] == "extra_forbidden":
        return f"{place} is not known there."
    if fault["type"] == "missing":
        return f"{place} is missing."
    text = str(fault.get("ctx", {}).get("error", ""))
    if not text:
        text = fault["msg"]
        for theirs, ours in _WORDS:
            text = text.replace(theirs, ours)
        if isinstance(fault["input"], str | int | float) and text.startswith("must be"):
            text += f", not {fault['input']!r}"
    text = text if text.endswith(".") else f"{text}."
    return f"{place}: {text}" if place else text
