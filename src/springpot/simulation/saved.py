"""Runs in files: written whole or not at all, and read back equal to what was written.

=======  ===========================================================================================================
suffix   what the file holds
=======  ===========================================================================================================
``.nc``  netCDF 4.  At the top what `springpot.simulate` returns, for any program that reads netCDF; in the group
         ``run`` what `load_run` needs beyond that.
``.json``  What ``springpot simulate --json`` prints, and under ``run`` what `load_run` needs.
``.csv``  A table for spreadsheets: a row for each number with its error and unit.  Recorded paths are a table of their
         own beside it, ``NAME_paths.csv``.  It cannot be read back.
=======  ===========================================================================================================

A run is a tree of frozen dataclasses, dicts, tuples, plain numbers and arrays.  `_taken_apart` turns it into words that
JSON can hold and arrays by name, and `_put_together` back, with the classes that the fields of `Run` name and no
others, so that a file can never make anything else.  A checksum over both finds damage.
"""

from __future__ import annotations

import base64
import binascii
import csv
import dataclasses
import hashlib
import io
import json
import math
import typing
import zlib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.files import write
from springpot.places import place_for, replacing
from springpot.simulation.results import Run

__all__ = ["SUFFIXES", "load_run", "places", "save_run"]

SUFFIXES = (".nc", ".json", ".csv")
FORMAT = 1
_GROUP = "run"
_WORDS = "words"
_RECORD = "record"
_MOST_BYTES = 8 * 2**30  # of one array that is read back

Arrays = dict[str, npt.NDArray[Any]]


def places(path: str | Path, run_or_paths: Run | int) -> tuple[Path, ...]:
    """The files that `save_run` writes: one, or two for a table with recorded paths.

    Parameters
    ----------
    path : str or Path
    run_or_paths : Run or int
        What is to be saved, or how many paths it records.

    Returns
    -------
    tuple of Path

    Raises
    ------
    ValueError
        If the name ends otherwise than in one of SUFFIXES.

    Examples
    --------
    >>> [place.name for place in places("one.csv", 3)]
    ['one.csv', 'one_paths.csv']
    """
    place = Path(path)
    if place.suffix not in SUFFIXES:
        raise ValueError(
            f"the file to save to must end in .nc (netCDF), .json or .csv (for spreadsheets), not {place.name!r}."
        )
    recorded = run_or_paths.settings.record if isinstance(run_or_paths, Run) else run_or_paths
    return (place, place.with_name(f"{place.stem}_paths.csv")) if place.suffix == ".csv" and recorded else (place,)


def save_run(run: Run, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a run to a file; the suffix says how.

    Parameters
    ----------
    run : Run
    path : str or Path
        Ends in ``.nc`` or ``.json``, which `load_run` reads, or in ``.csv``, a table for spreadsheets (recorded paths
        are a second table beside it, ``NAME_paths.csv``).
    overwrite : bool
        Whether to replace a file that is there.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the name ends otherwise, its folder does not exist, or the file is there and ``overwrite`` was not given.
    OSError
        If it cannot be written; what was there before is left as it was.

    Examples
    --------
    >>> import tempfile
    >>> import springpot as sp
    >>> found = sp.run(sp.Oscillator(), paths=64, duration=1.0)
    >>> place = found.save(Path(tempfile.mkdtemp()) / "run.nc")
    >>> sp.load_run(place).values == found.values
    True
    """
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


def load_run(path: str | Path) -> Run:
    """Read a run that was saved as netCDF or JSON.

    Parameters
    ----------
    path : str or Path
        Ends in ``.nc`` or ``.json``.

    Returns
    -------
    Run
        Equal to the one that was saved, to the last bit.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file holds no run, was damaged, or is a table.

    Examples
    --------
    >>> import tempfile
    >>> import springpot as sp
    >>> found = sp.run(sp.Oscillator(), paths=640, duration=1.0, distributions=True, record=2)
    >>> again = sp.load_run(found.save(Path(tempfile.mkdtemp()) / "run.nc"))
    >>> again.settings == found.settings, bool((again.record == found.record).all())
    (True, True)
    >>> float(again.distributions["x"].quantile(0.5)[0]) == float(found.distributions["x"].quantile(0.5)[0])
    True
    """
    place = Path(path)
    if place.suffix == ".csv":
        raise ValueError(f"{str(path)!r} is a table for spreadsheets: only .nc and .json can be read back.")
    if place.suffix not in SUFFIXES:
        raise ValueError(f"the file to read must end in .nc or .json, not {place.name!r}.")
    if not place.exists():
        raise FileNotFoundError(f"There is no file {str(path)!r}.")
    if not place.is_file():
        raise ValueError(f"{str(path)!r} is not a file.")
    try:
        words, arrays = _read_netcdf(place) if place.suffix == ".nc" else _read_json(place)
        found = _put_together(words, arrays)
    except _Foreign as reason:
        raise ValueError(f"{str(path)!r} cannot be read as a run: {reason}.") from None
    if not isinstance(found, Run):
        raise ValueError(f"{str(path)!r} cannot be read as a run: it holds something else.")
    return found


class _Foreign(ValueError):
    """A file does not hold what `save_run` writes; the message says what is wrong."""


_DAMAGED = "its content was damaged"
_NOT_OURS = "it was not written by springpot"


# --- a run as words and arrays --------------------------------------------------------------------------------------


@cache
def _classes() -> dict[str, type]:
    """Dataclasses that a run can hold, by name: those that the fields of `Run` name, and their fields in turn."""
    found: dict[str, type] = {}

    def look(kind: Any) -> None:
        if dataclasses.is_dataclass(kind) and isinstance(kind, type):
            if kind.__name__ not in found:
                found[kind.__name__] = kind
                for part in typing.get_type_hints(kind).values():
                    look(part)
        else:
            for part in typing.get_args(kind):
                look(part)

    look(Run)
    return found


def _taken_apart(value: object, name: str, arrays: Arrays) -> Any:
    """A value as words that JSON can hold; arrays go to ``arrays``, under names that say where they stand."""
    if isinstance(value, np.ndarray):
        if value.size == 0:
            return {"empty": list(value.shape), "kind": value.dtype.str}
        arrays[name] = value
        return {"array": name}
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
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a run cannot hold {value!r}.")


def _put_together(words: Any, arrays: Mapping[str, npt.NDArray[Any]]) -> Any:
    """The inverse of `_taken_apart`.

    Raises
    ------
    _Foreign
        If the words are not such as it makes.
    """
    match words:
        case None | bool() | int() | float() | str():
            return words
        case {"number": "nan" | "inf" | "-inf" as number}:
            return float(number)
        case {"array": str() as name} if name in arrays:
            return arrays[name]
        case {"empty": [*shape], "kind": str() as kind}:
            return np.zeros(shape, np.dtype(kind))
        case {"dict": dict() as parts}:
            return {key: _put_together(part, arrays) for key, part in parts.items()}
        case {"tuple": list() as parts}:
            return tuple(_put_together(part, arrays) for part in parts)
        case {"list": list() as parts}:
            return [_put_together(part, arrays) for part in parts]
        case {"class": str() as name, "fields": dict() as parts} if name in _classes():
            given = {key: _put_together(part, arrays) for key, part in parts.items()}
            try:
                return _classes()[name](**given)
            except (TypeError, ValueError):
                raise _Foreign("it is from another version of springpot") from None
    raise _Foreign(_NOT_OURS)


def _checksum(words: str, arrays: Mapping[str, npt.NDArray[Any]]) -> str:
    found = hashlib.sha256(words.encode())
    for name in sorted(arrays):
        array = arrays[name]
        found.update(f"\n{name} {array.dtype.str} {array.shape}\n".encode())
        found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()


def _stated(run: Run) -> tuple[str, Arrays]:
    arrays: Arrays = {}
    words = json.dumps(_taken_apart(run, "", arrays), allow_nan=False)
    return words, arrays


def _checked(words: str, arrays: Arrays, checksum: object) -> tuple[Any, Arrays]:
    if _checksum(words, arrays) != checksum:
        raise _Foreign(_DAMAGED)
    return json.loads(words), arrays


# --- netCDF ---------------------------------------------------------------------------------------------------------


def _write_netcdf(run: Run, path: Path) -> None:
    import xarray

    words, arrays = _stated(run)
    own = xarray.Dataset(attrs={"format": FORMAT, "checksum": _checksum(words, arrays)})
    own[_WORDS] = (("character",), np.frombuffer(words.encode(), np.uint8))
    for name, array in arrays.items():
        if name != _RECORD:  # it is x and v at the top
            own[name] = (tuple(f"{name}.{axis}" for axis in range(array.ndim)), array)
    packed = {name: {"zlib": True, "complevel": 2, "shuffle": True} for name in own.data_vars}
    with replacing(str(path)) as partial:
        run.to_dataset().to_netcdf(partial, engine="h5netcdf")
        own.to_netcdf(partial, engine="h5netcdf", mode="a", group=_GROUP, encoding=packed)


def _read_netcdf(path: Path) -> tuple[Any, Arrays]:
    import h5py

    # with h5py itself: it says plainly what it cannot read, and decodes nothing
    try:
        with h5py.File(path, "r") as file:
            own = file.get(_GROUP)
            if not isinstance(own, h5py.Group) or not isinstance(own.get(_WORDS), h5py.Dataset):
                raise _Foreign(_NOT_OURS)
            _check_format(int(np.ravel(own.attrs.get("format", 0))[0]))
            words = _numbers(own[_WORDS]).tobytes().decode()
            names = _array_names(words)
            arrays = {name: _numbers(own[name]) for name in names if name != _RECORD}
            if _RECORD in names:
                arrays[_RECORD] = np.stack([_numbers(file["x"]), _numbers(file["v"])], axis=-1)
            checksum = own.attrs.get("checksum")
    except _Foreign:
        raise
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, AttributeError) as reason:
        raise _Foreign(_NOT_OURS if "file signature not found" in str(reason) else _DAMAGED) from None
    return _checked(words, arrays, checksum.decode() if isinstance(checksum, bytes) else checksum)


def _numbers(dataset: Any) -> npt.NDArray[Any]:
    if dataset.size * dataset.dtype.itemsize > _MOST_BYTES:
        raise _Foreign("an array in it is too large")
    return np.asarray(dataset[()])


def _array_names(words: str) -> set[str]:
    """Names of the arrays that the words speak of."""

    def walk(part: Any) -> Iterator[str]:
        if isinstance(part, dict):
            if isinstance(part.get("array"), str):
                yield part["array"]
            for inner in part.values():
                yield from walk(inner)
        elif isinstance(part, list):
            for inner in part:
                yield from walk(inner)

    try:
        return set(walk(json.loads(words)))
    except RecursionError:
        raise _Foreign(_DAMAGED) from None


def _check_format(found: int) -> None:
    if found > FORMAT:
        raise _Foreign("it was written by a newer version of springpot")
    if found != FORMAT:
        raise _Foreign(_NOT_OURS)


# --- JSON -----------------------------------------------------------------------------------------------------------


def _as_json(run: Run) -> bytes:
    words, arrays = _stated(run)
    own = {
        "format": FORMAT,
        "checksum": _checksum(words, arrays),
        _WORDS: words,
        "arrays": {name: _packed(array) for name, array in arrays.items()},
    }
    return (json.dumps({**run.to_dict(), _GROUP: own}, indent=2, allow_nan=False) + "\n").encode()


def _packed(array: npt.NDArray[Any]) -> dict[str, Any]:
    content = base64.b64encode(zlib.compress(np.ascontiguousarray(array).tobytes(), 6)).decode()
    return {"kind": array.dtype.str, "shape": list(array.shape), "zlib_base64": content}


def _unpacked(found: Any) -> npt.NDArray[Any]:
    kind, shape = np.dtype(found["kind"]), tuple(found["shape"])
    if kind.kind not in "fiub" or not all(isinstance(n, int) and n >= 0 for n in shape):
        raise _Foreign(_DAMAGED)
    size = math.prod(shape) * kind.itemsize
    if size > _MOST_BYTES:
        raise _Foreign("an array in it is too large")
    content = zlib.decompressobj().decompress(base64.b64decode(found["zlib_base64"], validate=True), size + 1)
    if len(content) != size:
        raise _Foreign(_DAMAGED)
    return np.frombuffer(content, kind).reshape(shape).copy()


def _read_json(path: Path) -> tuple[Any, Arrays]:
    try:
        found = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        raise _Foreign("it is not JSON, or was cut short") from None
    own = found.get(_GROUP) if isinstance(found, dict) else None
    if not isinstance(own, dict) or not isinstance(own.get(_WORDS), str):
        raise _Foreign(_NOT_OURS)
    try:
        _check_format(int(own["format"]))
        arrays = {name: _unpacked(packed) for name, packed in own["arrays"].items()}
    except _Foreign:
        raise
    except (KeyError, TypeError, ValueError, AttributeError, binascii.Error, zlib.error):
        raise _Foreign(_DAMAGED) from None
    return _checked(own[_WORDS], arrays, own.get("checksum"))


# --- tables ---------------------------------------------------------------------------------------------------------

_PARTS = ("standard_error", "step_bias", "memory_bias", "transient", "total_error")
_ENDINGS = ("_se", "_step_bias", "_memory_bias", "_transient", "_error")


def _table(run: Run) -> bytes:
    """A row for each number: its name, the probability of a quantile, its value, its errors and its unit."""
    dataset = run.to_dataset()
    rows = []
    for name in dataset.data_vars:
        found = dataset[name]
        if found.ndim > 1 or any(
            str(name).endswith(end) and str(name).removesuffix(end) in dataset for end in _ENDINGS
        ):
            continue
        along = [np.nan] if found.ndim == 0 else np.asarray(found[found.dims[0]], dtype=float)
        errors = [dataset.get(f"{name}{ending}") for ending in _ENDINGS]
        for i, place in enumerate(along):
            value, *cells = (None if part is None else float(np.atleast_1d(part)[i]) for part in (found, *errors))
            unit = found.attrs.get("units", "")
            rows.append([name, _cell(place), *([found.dims[0]] if found.ndim else [""]), value, *cells, unit])
    kept = [i for i, _ in enumerate(_PARTS) if i == 0 or any(row[4 + i] is not None for row in rows)]
    header = ["quantity", "at", "along", "value", *(_PARTS[i] for i in kept), "unit"]
    lines = [[*row[:3], *map(_cell, (row[3], *(row[4 + i] for i in kept))), row[-1]] for row in rows]
    return _csv(header, lines)


def _paths_table(run: Run) -> bytes:
    """Time, then x and v of each recorded path, in columns."""
    header = ["time (s)"]
    for path in range(len(run.record)):
        header += [f"x of path {path} (m)", f"v of path {path} (m/s)"]
    numbers = np.column_stack([run.time, np.moveaxis(run.record, 0, 1).reshape(run.time.size, -1)])
    return _csv(header, ([repr(number) for number in row] for row in numbers.tolist()))


def _csv(header: list[str], rows: Any) -> bytes:
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue().encode()


def _cell(number: float | None) -> str:
    return "" if number is None or math.isnan(number) else repr(float(number))
