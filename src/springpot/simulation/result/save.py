"""Save runs to files.  A file is written completely or not at all, and reading it gives an equal run.

=======  ===========================================================================================================
suffix   content of the file
=======  ===========================================================================================================
``.nc``  netCDF 4.  At the top the dataset of `springpot.simulate`, for any program that reads netCDF; in the group
         ``run`` what `load_run` needs in addition.
``.json``  The output of ``springpot simulate --json``, and under ``run`` what `load_run` needs.
``.csv``  A table for spreadsheets: a row for each number with its error and unit.  Recorded paths are a second table,
         ``NAME_paths.csv``.  It cannot be read back.
=======  ===========================================================================================================

A run is a tree of frozen dataclasses, dicts, tuples, plain numbers and arrays.  `_taken_apart` turns it into JSON text
(``words``) and named arrays; `springpot.simulation.result.load` does the inverse.  It makes only the classes that the
fields of `Run` name, so that a file cannot create other objects.  A checksum over both detects damage.
"""

from __future__ import annotations

import base64
import csv
import dataclasses
import hashlib
import io
import itertools
import json
import math
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import checked_path, place_for, switch
from springpot.machine.files import netcdf_of, write
from springpot.machine.installed import need
from springpot.problem.catalogue import PARTS_OF_ERROR, unit_of_result
from springpot.problem.file import check_writable
from springpot.problem.messages import Message
from springpot.problem.system import System

if TYPE_CHECKING:
    Run = Any  # its class is in `springpot.simulation.result.results`, which writes its files with this module

SUFFIXES = (".nc", ".json", ".csv")
FORMAT = 1
GROUP = "run"
WORDS = "words"
RECORD = "record"

Arrays = dict[str, npt.NDArray[Any]]


def places(path: str | Path, run_or_paths: Run | int) -> tuple[Path, ...]:
    """The files that `save_run` writes: one, or two for a table with recorded paths.

    Parameters
    ----------
    path : str or Path
    run_or_paths : Run or int
        The run, or its number of recorded paths.

    Returns
    -------
    tuple of Path

    Raises
    ------
    ValueError
        If the name ends otherwise than in one of SUFFIXES.
    MissingExtraError
        If it ends in ``.nc`` and the libraries for netCDF are not installed.

    Examples
    --------
    >>> [place.name for place in places("one.csv", 3)]
    ['one.csv', 'one_paths.csv']
    """
    place = checked_path(path, "path")
    if place.suffix not in SUFFIXES:
        raise ValueError(
            f"the file to save to must end in .nc (netCDF), .json or .csv (for spreadsheets), not {place.name!r}."
        )
    if place.suffix == ".nc":
        need("files", "a netCDF file (.nc)")
    recorded = run_or_paths if isinstance(run_or_paths, int) else run_or_paths.settings.record
    return (place, place.with_name(f"{place.stem}_paths.csv")) if place.suffix == ".csv" and recorded else (place,)


def save_run(run: Run, path: str | Path, *, overwrite: bool = False, path_sums: bool = False) -> Path:
    """Write a run to a file in the format of its suffix.

    Parameters
    ----------
    run : Run
    path : str or Path
        Ends in ``.nc`` or ``.json``, which `load_run` reads, or in ``.csv``, a table for spreadsheets (recorded paths
        are a second table beside it, ``NAME_paths.csv``).
    overwrite : bool
        Whether to replace an existing file.
    path_sums : bool
        Whether to keep the sums of each path, some 100 bytes a path, so that `springpot.extend` can add paths.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the name ends otherwise, its folder does not exist, or the file exists and ``overwrite`` is False.
    OSError
        If it cannot be written; an existing file is then unchanged.

    Examples
    --------
    >>> import tempfile
    >>> import springpot as sp
    >>> run = sp.simulate(sp.Oscillator(), paths=64, duration=1.0)
    >>> place = run.save(Path(tempfile.mkdtemp()) / "run.nc")
    >>> sp.load_run(place).estimates == run.estimates
    True
    """
    if not switch(path_sums, "path_sums"):
        run = dataclasses.replace(run, path_sums=np.zeros((0, 0)))
    first, *others = (place_for(place, overwrite=overwrite) for place in places(path, run))
    if first.suffix == ".nc":
        _write_netcdf(run, first)
    elif first.suffix == ".json":
        write(str(first), _as_json(run))
    else:
        write(str(first), _table(run))
        for place in others:
            write(str(place), _paths_table(run))
    return first


# --- a run as words and arrays --------------------------------------------------------------------------------------


def _taken_apart(value: object, name: str, arrays: Arrays) -> Any:
    """A value in a form that JSON can represent; arrays go to ``arrays``, named by their path in the tree."""
    if isinstance(value, np.ndarray):
        if value.size == 0:
            return {"empty": list(value.shape), "kind": value.dtype.str}
        arrays[name] = value
        return {"array": name}
    if isinstance(value, System):
        check_writable(value)
        return {"system": value.to_dict()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        return {"class": type(value).__name__, "fields": _taken_apart(parts, name, arrays)["dict"]}
    if isinstance(value, Mapping):
        return {"dict": {key: _taken_apart(part, f"{name}.{key}".lstrip("."), arrays) for key, part in value.items()}}
    if isinstance(value, tuple | list):
        kind = "tuple" if isinstance(value, tuple) else "list"
        return {kind: [_taken_apart(part, f"{name}.{i}", arrays) for i, part in enumerate(value)]}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return {"number": repr(value)}
    if isinstance(value, Message):
        return {"message": value.name, "sentence": str(value)}
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a run cannot hold {value!r}.")


def checksum_of(words: str, arrays: Mapping[str, npt.NDArray[Any]]) -> str:
    digest = hashlib.sha256(words.encode())
    for name in sorted(arrays):
        array = arrays[name]
        digest.update(f"\n{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def _stated(run: Run) -> tuple[str, Arrays]:
    arrays: Arrays = {}
    words = json.dumps(_taken_apart(run, "", arrays), allow_nan=False)
    return words, arrays


# --- netCDF ---------------------------------------------------------------------------------------------------------


def _write_netcdf(run: Run, path: Path) -> None:
    import xarray

    words, arrays = _stated(run)
    own = xarray.Dataset(attrs={"format": FORMAT, "checksum": checksum_of(words, arrays)})
    own[WORDS] = (("character",), np.frombuffer(words.encode(), np.uint8))
    for name, array in arrays.items():
        if name != RECORD:  # it is stored as x and v at the top
            own[name] = (tuple(f"{name}.{axis}" for axis in range(array.ndim)), array)
    packed = {name: {"zlib": True, "complevel": 2, "shuffle": True} for name in own.data_vars}
    tree = xarray.DataTree.from_dict({"/": run.to_xarray(), f"/{GROUP}": own})
    write(str(path), netcdf_of(tree, {f"/{GROUP}": packed}))


# --- JSON -----------------------------------------------------------------------------------------------------------


def _as_json(run: Run) -> bytes:
    words, arrays = _stated(run)
    packed = {}
    for name, array in arrays.items():
        content = base64.b64encode(zlib.compress(np.ascontiguousarray(array).tobytes(), 6)).decode()
        packed[name] = {"kind": array.dtype.str, "shape": list(array.shape), "zlib_base64": content}
    own = {"format": FORMAT, "checksum": checksum_of(words, arrays), WORDS: words, "arrays": packed}
    return (json.dumps({**run.to_dict(), GROUP: own}, indent=2, allow_nan=False) + "\n").encode()


# --- tables ---------------------------------------------------------------------------------------------------------

_PARTS = ("standard_error", "step_bias", "memory_bias", "transient", "total_error")


def _table(run: Run) -> bytes:
    """A row for each number: its name, the probability of a quantile, its value, its errors and its unit."""
    data, coordinates = run.columns()
    rows = []
    for name, (axes, column, words) in data.items():
        if np.ndim(column) > 1 or any(name.endswith(end) and name.removesuffix(end) in data for end in PARTS_OF_ERROR):
            continue
        along = np.asarray(coordinates[axes][1]).tolist() if axes else [np.nan]
        columns = (column, *(data.get(f"{name}{ending}", (axes, None))[1] for ending in PARTS_OF_ERROR))
        for i, place in enumerate(along):
            value, *cells = (None if each is None else float(np.atleast_1d(each)[i]) for each in columns)
            rows.append([name, _cell(place), axes or "", value, *cells, words.get("units", "")])
    kept = [i for i, _ in enumerate(_PARTS) if i == 0 or any(row[4 + i] is not None for row in rows)]
    header = ["quantity", "at", "along", "value", *(_PARTS[i] for i in kept), "unit"]
    lines = [[*row[:3], *map(_cell, (row[3], *(row[4 + i] for i in kept))), row[-1]] for row in rows]
    return _csv(header, lines)


def _paths_table(run: Run) -> bytes:
    """Time, then x and v of each recorded path, of several masses those of each point, and forces, in columns."""
    points = [f"{point}, " for point in run.system.points] if run.record.ndim > 3 else [""]
    header = ["time (s)"]
    for path, point in itertools.product(range(len(run.record)), points):
        header += [f"x of {point}path {path} (m)", f"v of {point}path {path} (m/s)"]
    for name, path in itertools.product(run.forces, range(len(run.record))):
        header.append(f"{name.replace('_', ' ')} of path {path} ({unit_of_result(run.system, name)})")
    moved = np.moveaxis(run.record, 0, 1).reshape(run.time.size, -1)
    numbers = np.column_stack([run.time, moved, *(column.T for column in run.forces.values())])
    return _csv(header, ([repr(number) for number in row] for row in numbers.tolist()))


def _csv(header: list[str], rows: Any) -> bytes:
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue().encode()


def _cell(value: float | str | None) -> str:
    if isinstance(value, str):  # a wall's name
        return value
    return "" if value is None or math.isnan(value) else repr(float(value))
