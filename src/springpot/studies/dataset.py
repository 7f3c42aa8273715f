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

from springpot.problem.catalogue import is_controlled
from springpot.problem.numbers import label_of, unit_of
from springpot.studies.columns import OF_WALLS, bare, column_of_level, per_level, unit_of_column
from springpot.studies.question import Study
from springpot.studies.store import Store, document
from springpot.studies.tables import PARAMETERS, SIMULATED
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
        return self.store.study.columns_of(self.method)

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
    theories = [method for method in study.methods if method not in SIMULATED]
    if theories:
        answers = [Results(store, method) for method in theories]
        coordinates = {"theory": ("theory", theories), **_coordinates(study)}
        variables = _variables(answers, {"theory": len(theories), **shape}, "", study)
        parts["/theory"] = xarray.Dataset(variables, coordinates)
    if "monte_carlo" in study.methods:
        variables = _variables([Results(store, "monte_carlo")], shape, "Monte Carlo: ", study)
        parts["/simulation"] = xarray.Dataset(variables, _coordinates(study))
    if "exceedance" in study.methods:
        variables = _variables([Results(store, "exceedance")], shape, "exceedance: ", study)
        parts["/exceedance"] = xarray.Dataset(variables, _coordinates(study) | _levels(study))
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


def _levels(study: Study) -> dict[str, Any]:
    """The levels of each quantity as coordinates."""
    from springpot.simulation.plan.motions import motion_of  # slow to import
    from springpot.simulation.rare.asked import quantity_of

    motion = motion_of(study.system)
    return {
        f"{name}_level": (f"{name}_level", list(levels), {"units": quantity_of(motion, name).unit, "long_name": name})
        for name, levels in study.levels.items()
    }


def result_columns(study: Study, method: str) -> tuple[str, ...]:
    """The columns that can have a number, with the study's settings of Monte Carlo."""
    names = study.columns_of(method)
    if study.monte_carlo is not None and study.monte_carlo.rtol is not None:
        return tuple(name for name in names if not name.endswith("_error") or is_controlled(bare(name)))
    return tuple(name for name in names if not name.endswith("_error"))


def _variables(answers: list[Results], shape: Mapping[str, int], prefix: str, study: Study) -> dict[str, Any]:
    def lazily(read: Callable[[Results], npt.NDArray[Any]], kind: Any, *more: int) -> Any:
        whole = (*shape.values(), *more)
        return _lazy(lambda: np.concatenate([read(part) for part in answers]).reshape(whole), whole, kind)

    columns, method = {}, answers[0].method
    joined = _of_levels(study) if method == "exceedance" else _with_walls_joined(result_columns(study, method), study)
    for column, (sources, dimension) in joined.items():
        name = bare(column)
        text = {name: "", f"{name}_se": "standard error of ", f"{name}_error": "half-width of the 95 % interval of "}
        words = f"{name.removeprefix('barrier_')} of each wall" if dimension == "barrier" else name
        long_name = prefix + text[column] + words.replace("_", " ")
        attributes = {"units": unit_of_column(method, study.system, sources[0]), "long_name": long_name}
        if column == name and f"{name}_se" in joined:
            attributes["ancillary_variables"] = f"{name}_se"

        def read(part: Results, sources: tuple[str, ...] = sources) -> npt.NDArray[np.float64]:
            return np.stack([part.numbers(source) for source in sources], axis=-1)

        more = {dimension: len(sources)} if dimension else {}
        columns[column] = ((*shape, *more), lazily(read, "f8", *more.values()), attributes)
    columns["done"] = (tuple(shape), lazily(Results.done, "?"), {"long_name": "whether there is an answer"})
    reasons = {"long_name": "warnings, or why there is no answer"}
    columns["said"] = (tuple(shape), lazily(Results.sentences, "O"), reasons)
    return columns


def _of_levels(study: Study) -> dict[str, tuple[tuple[str, ...], str]]:
    """Each variable of exceedance with its columns, one for each level, and the dimension of these."""
    return {
        f"{name}_{what}": (tuple(column_of_level(name, level, what) for level in levels), f"{name}_level")
        for name, levels in study.levels.items()
        for what in per_level()
    }


def _with_walls_joined(columns: tuple[str, ...], study: Study) -> dict[str, tuple[tuple[str, ...], str]]:
    """Each variable of a data set with its columns, and the dimension of these if they are of all walls."""
    walls = study.system.stops
    found: dict[str, tuple[tuple[str, ...], str]] = {}
    for column in columns:
        name = bare(column)
        quantity = next((what for what in OF_WALLS if name in {f"{wall}_{what}" for wall in walls}), "")
        ending = column.removeprefix(name)
        joined = tuple(f"{wall}_{quantity}{ending}" for wall in walls)
        if quantity and set(joined) <= set(columns):
            found[f"barrier_{quantity}{ending}"] = joined, "barrier"
        else:
            found[column] = (column,), ""
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
