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

from springpot.problem.catalogue import is_controlled, unit_of_result
from springpot.problem.numbers import label_of, unit_of
from springpot.studies.columns import OF_WALLS, bare, columns_of
from springpot.studies.question import Study
from springpot.studies.store import Store, document
from springpot.studies.tables import PARAMETERS
from springpot.studies.tasks import Answer, tasks

if TYPE_CHECKING:
    import xarray

__all__ = ["Results", "open_tree", "result_columns"]


@dataclass(frozen=True)
class Results:
    """All results of one method on the grid; the files are read at first use."""

    store: Store
    method: str

    @cached_property
    def all(self) -> list[Answer | None]:
        only = self.store.study.model_copy(update={"methods": (self.method,)})
        return [self.store.found(task) for task in tasks(only)]

    @cached_property
    def columns(self) -> tuple[str, ...]:
        return columns_of(self.method, self.store.study.system, self.store.study.asked)

    def numbers(self, column: str) -> npt.NDArray[np.float64]:
        place = self.columns.index(column)
        return np.array([math.nan if answer is None else answer.numbers[place] for answer in self.all])

    def done(self) -> npt.NDArray[np.bool_]:
        return np.array([answer is not None for answer in self.all])

    def sentences(self) -> npt.NDArray[np.object_]:
        return np.array(["" if answer is None else answer.said for answer in self.all], object)


def open_tree(store: Store) -> xarray.DataTree:
    """The grid with all numbers of the store, as `springpot.open_study` describes it."""
    import xarray

    study = store.study
    shape, parts = study.shape, {}
    theories = [method for method in study.methods if method != "monte_carlo"]
    if theories:
        answers = [Results(store, method) for method in theories]
        coordinates = {"theory": ("theory", theories), **_coordinates(study)}
        variables = _variables(answers, {"theory": len(theories), **shape}, "", study)
        parts["/theory"] = xarray.Dataset(variables, coordinates)
    if "monte_carlo" in study.methods:
        variables = _variables([Results(store, "monte_carlo")], shape, "Monte Carlo: ", study)
        parts["/simulation"] = xarray.Dataset(variables, _coordinates(study))
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


def result_columns(study: Study, method: str) -> tuple[str, ...]:
    """The columns that can have a number, with the study's settings of Monte Carlo."""
    names = columns_of(method, study.system, study.asked)
    if study.monte_carlo is not None and study.monte_carlo.rtol is not None:
        return tuple(name for name in names if not name.endswith("_error") or is_controlled(bare(name)))
    return tuple(name for name in names if not name.endswith("_error"))


def _variables(answers: list[Results], shape: Mapping[str, int], prefix: str, study: Study) -> dict[str, Any]:
    def lazily(read: Callable[[Results], npt.NDArray[Any]], kind: Any, *walls: int) -> Any:
        whole = (*shape.values(), *walls)
        return _lazy(lambda: np.concatenate([read(part) for part in answers]).reshape(whole), whole, kind)

    columns = {}
    for column, (sources, of_walls) in _with_walls_joined(result_columns(study, answers[0].method), study).items():
        name = bare(column)
        text = {name: "", f"{name}_se": "standard error of ", f"{name}_error": "half-width of the 95 % interval of "}
        words = f"{name.removeprefix('barrier_')} of each wall" if of_walls else name
        long_name = prefix + text[column] + words.replace("_", " ")
        attributes = {"units": unit_of_result(study.system, bare(sources[0])), "long_name": long_name}
        if column == name and prefix:
            attributes["ancillary_variables"] = f"{name}_se"

        def read(part: Results, sources: tuple[str, ...] = sources) -> npt.NDArray[np.float64]:
            return np.stack([part.numbers(source) for source in sources], axis=-1)

        walls = {"barrier": len(sources)} if of_walls else {}
        columns[column] = ((*shape, *walls), lazily(read, "f8", *walls.values()), attributes)
    columns["done"] = (tuple(shape), lazily(Results.done, "?"), {"long_name": "whether there is an answer"})
    reasons = {"long_name": "warnings, or why there is no answer"}
    columns["said"] = (tuple(shape), lazily(Results.sentences, "O"), reasons)
    return columns


def _with_walls_joined(columns: tuple[str, ...], study: Study) -> dict[str, tuple[tuple[str, ...], bool]]:
    """Each variable of a data set with its columns, and whether these are of all walls."""
    walls = study.system.stops
    found: dict[str, tuple[tuple[str, ...], bool]] = {}
    for column in columns:
        name = bare(column)
        quantity = next((what for what in OF_WALLS if name in {f"{wall}_{what}" for wall in walls}), "")
        ending = column.removeprefix(name)
        joined = tuple(f"{wall}_{quantity}{ending}" for wall in walls)
        if quantity and set(joined) <= set(columns):
            found[f"barrier_{quantity}{ending}"] = joined, True
        else:
            found[column] = (column,), False
    return found


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
