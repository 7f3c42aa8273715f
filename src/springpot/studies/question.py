"""The study file: a grid of systems, the methods, and the settings of Monte Carlo.

A file is TOML; its content is the model `Study` below, whose JSON schema `springpot study schema` prints.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    ConfigDict,
    FailFast,
    Field,
    PrivateAttr,
    ValidationError,
    model_validator,
)

from springpot.machine.faults import FileError, listed, meant, shown
from springpot.machine.plain import read_toml
from springpot.problem.catalogue import stated_in
from springpot.problem.file import read_system
from springpot.problem.numbers import ROOT, check_number, label_of, numbers_of, with_numbers
from springpot.problem.oscillator import Oscillator
from springpot.problem.outputs import output_squares
from springpot.problem.parts.checks import put
from springpot.problem.system import System, checked_system
from springpot.studies.axes import MOST_VALUES, Axis, flattened, some_points, with_draws
from springpot.studies.columns import Column, columns_of, names_in_results, scalars_of
from springpot.studies.tables import (
    PARAMETERS,
    SIMULATED,
    Device,
    Exceeding,
    Fixed,
    Method,
    MonteCarlo,
    Strict,
    of_either,
    sentence,
    unknown_key,
)
from springpot.theory.registry import METHODS

MOST_TASKS = 10_000_000
SYSTEMS_CHECKED = 1000  # points of a grid at which a system is made when the study is read, and all corners

Point = dict[str, float | str | bool]


class Study(Strict):
    """A grid of systems, and the methods by which they are solved.

    Attributes
    ----------
    name : str
        Names the study; a store holds one study only.
    seed : int
        Every point's own seed is made from it and from the point's numbers.
    methods : tuple of str
        Methods of the theory, ``monte_carlo``, and ``exceedance`` for rare events.
    system : System
        Whose numbers vary: if none is given, the paper's oscillator with the numbers of ``fixed``.
    quantities : tuple of str
        Quantities that ``rtol`` controls, and that tables and charts show.  The store keeps all quantities.
    fixed : Fixed
        The numbers of the oscillator, where no system is named.
    axes : dict
        Name of a parameter to its values: the grid is their product.  Of a system the names are those of its numbers,
        ``parts.<name>.<number>``.
    zipped : dict
        Name of an axis of your own to columns of equal length, which run together.
    monte_carlo : MonteCarlo or None
        Needed if ``methods`` has ``monte_carlo``.
    exceedance : Exceeding or None
        Needed if ``methods`` has ``exceedance``.

    Examples
    --------
    >>> study = Study.model_validate({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5]}})
    >>> study.shape, [point["order"] for point in study.points()]
    ({'order': 2}, [0.25, 0.5])
    """

    model_config = ConfigDict(json_schema_extra=of_either)

    name: str = Field(min_length=1, max_length=200)
    methods: Annotated[
        tuple[Method, ...], Field(strict=False, min_length=1, max_length=len(METHODS) + len(SIMULATED)), FailFast()
    ]
    seed: int = Field(1, ge=0, le=2**63 - 1)
    system: Device = None  # type: ignore[assignment]  # found below, if none is given
    quantities: Annotated[tuple[str, ...], Field(strict=False, min_length=1, max_length=100), FailFast()] = (
        "amplitude_mean_square",
    )
    fixed: Fixed = Field(default_factory=Fixed)
    axes: dict[str, Axis] = Field(default_factory=dict)
    zipped: dict[str, dict[str, Axis]] = Field(default_factory=dict)
    monte_carlo: MonteCarlo | None = None
    exceedance: Exceeding | None = None

    _constants: Point = PrivateAttr(default_factory=dict)

    @model_validator(mode="after")
    def _consistent(self) -> Study:
        self._find_system()
        self._check_names()
        for method in SIMULATED:
            if (method in self.methods) != (getattr(self, method) is not None):
                raise ValueError(f'methods must name "{method}" if, and only if, there is a table [{method}]')
        parameters = [*self.axes, *(name for columns in self.zipped.values() for name in columns)]
        if not parameters:
            some = next(iter({**self._constants, **numbers_of(self.system)}), "parts.spring.stiffness")
            raise ValueError(f"there must be an axis, such as [axes] {some} = [0.25, 0.5]")
        if len(set(parameters)) < len(parameters):
            raise ValueError(f"{_twice(parameters)} is on two axes: leave out one of the two")
        for name in parameters:
            if name in self.fixed.model_fields_set:
                raise ValueError(f"{name} is fixed and is also on an axis: leave out one of the two")
        taken = names_in_results(each for method in ("linear", *SIMULATED) for each in self.columns_of(method))
        labels = [label_of(name) for name in parameters]
        for name, label in zip(parameters, labels, strict=True):
            if label in taken or labels.count(label) > 1:
                raise ValueError(f"{name} would be {label} in the results, as another number is: rename the part")
        for title, columns in self.zipped.items():
            if title in {*taken, *labels, *PARAMETERS} or not title.isidentifier():
                raise ValueError(f"zipped axis {title!r} needs a name of its own, such as case")
            if len({len(column) for column in columns.values()}) != 1:
                raise ValueError(f"zipped axis {title} needs at least one column, and columns of equal length")
        if sum(len(values) for _, values in self.columns.values()) > MOST_VALUES:
            raise ValueError(f"the axes have more than {MOST_VALUES:,} values together: make them shorter")
        for title, part in self._grid.items():
            rows = [*zip(*part.values(), strict=True)]
            if len(set(rows)) < len(rows):
                again = _twice(rows)
                raise ValueError(f"axis {title} holds {again[0] if len(again) == 1 else again} twice")
        if math.prod(self.shape.values()) * len(self.methods) > MOST_TASKS:
            raise ValueError(f"there are more than {MOST_TASKS:,} tasks: make the axes shorter")
        self._check_points()
        return self

    def _find_system(self) -> None:
        """The one door: a study that names no system is of the paper's oscillator, whose numbers have short names.

        From here on it has a system, and constants that are in each of its points.  What its parts refuse is said by
        the place in the file.  Their ranges are intervals, so the ends of each column are tried.
        """
        columns = [("axes", name, values) for name, values in self.axes.items()]
        for title, part in self.zipped.items():
            columns += [(f"zipped.{shown(title)[1:-1]}", name, values) for name, values in part.items()]
        if self.system is not None:
            if "fixed" in self.model_fields_set:
                raise ValueError("fixed is for oscillators: the system has its numbers, so change them there")
            for place, name, _ in columns:
                try:
                    check_number(self.system, name)
                except ValueError as fault:
                    raise ValueError(f"{place}: {fault}") from None
            return
        for place, name, _ in columns:
            if name.startswith("parts"):
                raise ValueError(f"{shown(name)} is a number of a system: name its file too, as system = 'device.toml'")
            if name not in PARAMETERS:
                raise ValueError(unknown_key(name, place, PARAMETERS))
        self._constants = self.fixed.model_dump()
        put(self, system=_oscillator(self._constants, {name: f"fixed.{name}" for name in self._constants}))
        for place, name, values in columns:
            for value in (min(values), max(values)):
                _oscillator({**self._constants, name: value}, {name: f"{place}.{name}"})

    def _check_names(self) -> None:
        """Raise an error if a name of a method or quantity is there twice, or is not for this system."""
        for what, names in (("methods", self.methods), ("quantities", self.quantities)):
            if len(set(names)) < len(names):
                raise ValueError(f"{what} names {_twice(names)} twice")
        own = (column for method in SIMULATED for column in self.columns_of(method) if not column.ending)
        named = (column.name if column.dimension in ("", "barrier") else column.quantity for column in own)
        known = dict.fromkeys((*scalars_of(self.system), *named))
        for number, name in enumerate(self.quantities, start=1):
            if name not in known:
                near = meant(name, known)
                must = f"must be {listed([*map(repr, known)], 'or')}, not {shown(name)}{near}"
                raise ValueError(f"quantities, number {number}: {must}")
        for name in self.system.with_functions:
            raise ValueError(f"system: {name} has a function, which cannot be kept in a store")

    def settings(self, method: str) -> dict[str, Any]:
        """What the file says of a method, which may add to its results: to those of linear theory, forces."""
        table = getattr(self, method if method in SIMULATED else "monte_carlo")
        given: dict[str, Any] = {} if table is None else table.given()
        if method in SIMULATED:
            return given
        squares = output_squares(self.system) if "rtol" in given else {}
        forces = (*given.get("forces", ()), *(squares[name] for name in self.quantities if name in squares))
        return {"forces": forces} if forces and method == "linear" else {}

    def columns_of(self, method: str) -> tuple[Column, ...]:
        """The numbers in a method's result."""
        return columns_of(method, self.system, self.settings(method), self.quantities)

    @property
    def _grid(self) -> dict[str, dict[str, tuple[float, ...]]]:
        """The columns of each axis of the grid, by parameter."""
        return {label_of(name): {name: axis} for name, axis in self.axes.items()} | self.zipped

    @property
    def shape(self) -> dict[str, int]:
        """Length of each axis of the grid, by name."""
        return {title: len(next(iter(columns.values()))) for title, columns in self._grid.items()}

    @property
    def columns(self) -> dict[str, tuple[str, tuple[float, ...]]]:
        """Axis and values of each parameter that varies."""
        return {name: (title, axis) for title, columns in self._grid.items() for name, axis in columns.items()}

    @cached_property
    def unvaried(self) -> dict[str, Any]:
        """What the points do not say of the system, and a store's results depend on: its parts, by name."""
        if self._constants:
            return {}
        parts = {str(part.pop("name")): part for part in self.system.to_dict()["parts"]}
        for name in self.columns:
            _, owner, *path, last = name.split(".")
            table = parts[owner]
            for key in path:
                if not isinstance(table[key], dict):
                    table[key] = dict(enumerate(table[key], start=1))
                table = table[key]
            table[int(last) if last.isdigit() else last] = None
        return parts

    def points(self) -> Iterator[Point]:
        """All points of the grid, the last axis fastest: the numbers that vary, and all others of an oscillator."""
        return map(self.point, range(math.prod(self.shape.values())))

    def point(self, index: int) -> Point:
        """The point with this index in `points`."""
        point = dict(self._constants)
        for values in reversed(self._grid.values()):
            index, place = divmod(index, len(next(iter(values.values()))))
            point.update((name, column[place]) for name, column in values.items())
        return point

    @property
    def constants(self) -> Point:
        """The numbers that all points have, and no axis."""
        return {name: value for name, value in self._constants.items() if name not in self.columns}

    def where(self, point: Mapping[str, Any]) -> str:
        """A point in words: the parameters that vary."""
        return ", ".join(f"{name} = {point[name]:g}" for name in self.columns)

    def _check_points(self) -> None:
        """Raise an error, with the point, if a part or the whole refuses its numbers at some point of the grid."""
        for place in some_points(tuple(self.shape.values()), SYSTEMS_CHECKED):
            point = self.point(place)
            try:
                system_at(point, self.system)
            except ValueError as fault:
                raise ValueError(f"at {self.where(point)}: {fault}") from None


def _oscillator(numbers: Mapping[str, Any], places: Mapping[str, str]) -> System:
    """The paper's oscillator; in errors the name of a number is replaced by its place in the file."""
    try:
        found: System = Oscillator.from_numbers(**numbers)
        return found
    except ValueError as error:
        name, space, rest = str(error).partition(" ")
        raise ValueError(places.get(name, name) + space + rest) from None


def _twice(names: Iterable[Any]) -> Any:
    """The first name that is there again."""
    return next(name for name, count in Counter(names).items() if count > 1)


def system_at(point: Mapping[str, Any], base: System) -> System:
    """A system with the numbers of a point.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> system_at({"natural_frequency": 3.0}, System(Spring(1.0))).stiffness
    9.0
    """
    known = numbers_of(base)
    named = ((*PARAMETERS[name], value) for name, value in point.items() if name in PARAMETERS)
    ours = {number: value**power for number, power, value in named if number in known}  # without a wall it has none
    return with_numbers(base, ours | {name: value for name, value in point.items() if name.startswith(ROOT)})


def read_study(source: str | Path | Mapping[str, Any] | Study) -> Study:
    """A study from a file, or from the same content as a mapping.

    Parameters
    ----------
    source : str, Path, mapping or Study
        A TOML file's place, or its content, in which ``system`` may be a `springpot.System`, too.

    Returns
    -------
    Study

    Raises
    ------
    TypeError
        If it is something else.
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
    elif not isinstance(source, str | os.PathLike):
        content_of = "{'name': ..., 'methods': ..., 'axes': ..., 'system': ...}"
        raise TypeError(f"source must be a study file or its content, {content_of}, not {shown(source)}.")
    else:
        title = f"study file {str(source)!r}"
        content = read_toml(source, title)
    asked, methods = content.get("exceedance"), content.get("methods")
    alone = isinstance(methods, list) and methods == ["exceedance"]
    if "quantities" not in content and alone and isinstance(asked, Mapping):
        content = {**content, "quantities": [f"{name}_return_period" for name in asked.get("levels") or ["x"]]}
    if "system" in content:
        folder = Path() if isinstance(source, Mapping) else Path(source).parent
        system = _read_system(content["system"], folder, title)
        # <A^2>, or <v^2> where there is no frequency and so no amplitude; of several masses <x^2> of the first
        amplitude = ["amplitude_mean_square"] if system.stiffness > 0.0 else []
        usual = stated_in(system, (*amplitude, "v_mean_square", f"{system.points[0]}_x_mean_square"))[:1]
        content = with_draws({"quantities": [*usual], **content, "system": system}, system, title)
    elif "draws" in content:
        raise FileError(f"{title} is not right: draws are of a system's uncertain numbers: name its file as system.")
    try:
        axes, zipped = content.get("axes"), content.get("zipped")  # in one form: a name for each axis
        if isinstance(axes, Mapping):
            content = {**content, "axes": flattened(axes)}
        if isinstance(zipped, Mapping):
            names = {name: flattened(part) if isinstance(part, Mapping) else part for name, part in zipped.items()}
            content = {**content, "zipped": names}
        _check_keys(content)
        return Study.model_validate(content)
    except ValidationError as error:
        raise FileError(f"{title} is not right: {' '.join(sentence(error).split())}") from None
    except FileError as fault:
        raise FileError(f"{title} is not right: {fault}") from None


def _read_system(given: object, folder: Path, title: str) -> System:
    """The system of a study, from a file of its own or a table; an error of that file is said as its own."""
    place: Any = folder / given if isinstance(given, str | Path) else given
    try:
        if isinstance(place, Mapping):
            return read_system(place, folder)
        return read_system(place) if isinstance(place, Path) else checked_system(place)
    except FileNotFoundError:
        raise FileError(f"{title} is not right: system: there is no file {str(place)!r}.") from None
    except TypeError as fault:
        hint = "In a file it is the place of the system's file, in quotes."
        raise FileError(f"{title} is not right: {fault} {hint}") from None


def _check_keys(content: Mapping[str, Any]) -> None:
    """Raise an error if a table has an unknown key."""
    tables: list[tuple[str, Any, Iterable[str]]] = [
        ("", content, Study.model_fields),
        ("fixed", content.get("fixed"), Fixed.model_fields),
        ("monte_carlo", content.get("monte_carlo"), MonteCarlo.model_fields),
        ("exceedance", content.get("exceedance"), Exceeding.model_fields),
    ]
    for place, table, known in tables:
        for key in table if isinstance(table, Mapping) else ():
            if key not in known:
                raise FileError(unknown_key(key, place, known))
