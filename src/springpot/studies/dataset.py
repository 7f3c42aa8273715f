"""A store as a labelled data set: an xarray DataTree with `/theory` and `/simulation`, read at first use."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.problem.catalogue import is_controlled
from springpot.problem.numbers import label_of, unit_of
from springpot.studies.columns import SAID, Column, levels_of
from springpot.studies.question import Study
from springpot.studies.store import Store, document
from springpot.studies.tables import PARAMETERS, SIMULATED
from springpot.studies.tasks import Answer, tasks

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Results:
    """All results of one method on the grid; the files are read at first use."""

    store: Store
    method: str

    @cached_property
    def all(self) -> list[Answer | None]:
        only = self.store.study.model_copy(update={"methods": (self.method,)})
        return [self.store.find(task) for task in tasks(only)]

    def numbers(self, column: str) -> Floats:
        """Of all points; NaN where there are none."""
        return np.array([math.nan if answer is None else answer.numbers.get(column, math.nan) for answer in self.all])

    def done(self) -> npt.NDArray[np.bool_]:
        return np.array([answer is not None for answer in self.all])

    def sentences(self) -> npt.NDArray[np.object_]:
        return np.array(["" if answer is None else answer.said for answer in self.all], object)


def to_xarray(store: Store) -> xarray.DataTree:
    """The grid with all numbers of the store, as `springpot.open_study` describes it."""
    import xarray

    study = store.study
    shape, parts = study.shape, {}
    theories = [method for method in study.methods if method not in SIMULATED]
    if theories:
        answers = [Results(store, method) for method in theories]
        coordinates = {"theory": ("theory", theories), **_coordinates(study)}
        variables = _variables(answers, {"theory": len(theories), **shape}, "", study)
        parts["/theory"] = xarray.Dataset(variables, coordinates)
    for method, group, words in (
        ("monte_carlo", "/simulation", "Monte Carlo: "),
        ("exceedance", "/exceedance", "exceedance: "),
    ):
        if method in study.methods:
            variables = _variables([Results(store, method)], shape, words, study)
            parts[group] = xarray.Dataset(variables, _coordinates(study) | _levels(study, method))
    tree = xarray.DataTree.from_dict(parts, name=study.name.replace("/", " "))
    tree.attrs = {
        "Conventions": "CF-1.11",
        "title": study.name,
        "study": json.dumps(document(study)),
        "fixed": json.dumps(study.constants),
        "seed": study.seed,
        "versions": json.dumps(store.versions),
    }
    return tree


def _coordinates(study: Study) -> dict[str, Any]:
    coordinates: dict[str, Any] = {}
    for name, (axis, values) in study.columns.items():
        number, power = PARAMETERS.get(name, (name, 1))
        unit = unit_of(study.system, number) if power == 1 else "rad s-1"  # the root of a stiffness
        coordinates[label_of(name)] = axis, list(values), {"units": unit, "long_name": name}  # as in the study file
    if study.system.stops:
        coordinates["barrier"] = ("barrier", list(study.system.stops))
    return coordinates | {axis: (axis, range(1, n + 1)) for axis, n in study.shape.items() if axis not in coordinates}


def _levels(study: Study, method: str) -> dict[str, Any]:
    """The levels of each quantity as coordinates."""
    given = levels_of(method, study.settings(method))
    if not given:
        return {}
    from springpot.simulation.plan.motions import motion_of  # slow to import
    from springpot.simulation.rare.event import quantity_of

    motion = motion_of(study.system)
    return {
        dimension: (dimension, list(levels), {"units": quantity_of(motion, name).unit, "long_name": name})
        for dimension, (name, levels) in given.items()
    }


def result_columns(study: Study, *methods: str) -> dict[str, Column]:
    """The columns of methods that can have a number, by name, with the study's settings of Monte Carlo."""
    of_rtol = study.monte_carlo is not None and study.monte_carlo.rtol is not None
    found = {column.name: column for method in methods for column in study.columns_of(method)}
    return {
        name: column
        for name, column in found.items()
        if column.ending != "_error" or (of_rtol and is_controlled(name.removesuffix("_error")))
    }


def _variables(answers: list[Results], shape: Mapping[str, int], prefix: str, study: Study) -> dict[str, Any]:
    def lazily(read: Callable[[Results], npt.NDArray[Any]], kind: Any, *more: int) -> Any:
        whole = (*shape.values(), *more)
        return _lazy(lambda: np.concatenate([read(part) for part in answers]).reshape(whole), whole, kind)

    variables: dict[str, Any] = {}
    joined: dict[str, list[Column]] = {}
    for column in result_columns(study, *(part.method for part in answers)).values():
        joined.setdefault(column.variable, []).append(column)
    for name, own in joined.items():
        quantity, ending, dimension = own[0].quantity, own[0].ending, own[0].dimension
        words = f"{quantity.removeprefix('barrier_')} of each wall" if dimension == "barrier" else quantity
        attributes = {"units": own[0].unit, "long_name": prefix + SAID[ending] + words.replace("_", " ")}
        if not ending and f"{name}_se" in joined:
            attributes["ancillary_variables"] = f"{name}_se"

        def read(part: Results, own: list[Column] = own) -> Floats:
            return np.stack([part.numbers(column.name) for column in own], axis=-1)

        more = {dimension: len(own)} if dimension else {}
        variables[name] = ((*shape, *more), lazily(read, "f8", *more.values()), attributes)
    variables["done"] = (tuple(shape), lazily(Results.done, "?"), {"long_name": "whether there is an answer"})
    reasons = {"long_name": "warnings, or why there is no answer"}
    variables["said"] = (tuple(shape), lazily(Results.sentences, "O"), reasons)
    return variables


def _lazy(make: Callable[[], npt.NDArray[Any]], shape: tuple[int, ...], kind: Any) -> Any:
    """An array that is computed at first use."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    class _Array(BackendArray):
        def __init__(self) -> None:
            self.shape, self.dtype, self.whole = shape, np.dtype(kind), cache(make)

        def __getitem__(self, key: Any) -> Any:
            basic = indexing.IndexingSupport.BASIC
            return indexing.explicit_indexing_adapter(key, shape, basic, lambda place: self.whole()[place])

    return indexing.LazilyIndexedArray(_Array())
