"""Read a run that `springpot.simulation.result.save` wrote, and verify its checksum."""

from __future__ import annotations

import base64
import collections.abc
import dataclasses
import json
import math
import types
import typing
import zlib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import checked_path
from springpot.machine.installed import need
from springpot.problem.file import read_system
from springpot.problem.messages import MESSAGES, Message
from springpot.problem.system import System
from springpot.simulation.error.budget import Budget
from springpot.simulation.result.results import Run
from springpot.simulation.result.save import FORMAT, GROUP, RECORD, SUFFIXES, WORDS, Arrays, checksum_of
from springpot.simulation.watch.distributions import Distribution
from springpot.simulation.watch.passage_times import PassagesOfLevels, PassageTimes
from springpot.simulation.watch.profiles import Profile
from springpot.simulation.watch.spectrum import Spectrum

_MOST_EXPANDED = 1100  # times the size of the file: zlib cannot make an array smaller than that
_DAMAGED = "its content was damaged"
_NOT_OURS = "it was not written by springpot"
# what is in a run only where it was asked for: `springpot.simulation.result.results` does not load these kinds
_ASKED_FOR = {kind.__name__: kind for kind in (
    Budget, Distribution, PassagesOfLevels, PassageTimes, Profile, Spectrum
)}  # fmt: skip


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
        If the file has no run in it, was damaged, or is a table.

    Examples
    --------
    >>> import tempfile
    >>> import springpot as sp
    >>> run = sp.simulate(sp.Oscillator(), paths=640, duration=1.0, distributions=True, record=2)
    >>> again = sp.load_run(run.save(Path(tempfile.mkdtemp()) / "run.nc"))
    >>> again.settings == run.settings, bool((again.record == run.record).all())
    (True, True)
    >>> float(again.distributions["x"].quantile(0.5)[0]) == float(run.distributions["x"].quantile(0.5)[0])
    True
    """
    place = checked_path(path, "path")
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
        value = _put_together(words, arrays)
        if not isinstance(value, Run):
            raise _Foreign("it does not hold one")
        with np.errstate(all="ignore"):  # whatever does not belong together fails here rather than later
            json.dumps(value.to_dict())
            _check_sizes(value)
    except _Foreign as reason:
        raise ValueError(f"{str(path)!r} cannot be read as a run: {reason}.") from None
    except Exception:  # whatever somebody has written into the file
        raise ValueError(f"{str(path)!r} cannot be read as a run: {_DAMAGED}.") from None
    return value


def _check_sizes(run: Run) -> None:
    """Refuse arrays that do not have the lengths of their axes."""
    sizes: dict[str, int] = {}
    for columns in run.columns():
        for axes, values, *_ in columns.values():
            names, shape = (axes,) if isinstance(axes, str) else axes, np.shape(values)
            lengths = dict(zip(names, shape, strict=True))
            if any(sizes.setdefault(name, length) != length for name, length in lengths.items()):
                raise _Foreign(_DAMAGED)


class _Foreign(ValueError):
    """The file is not one that `save_run` wrote; the message says why."""


@cache
def _classes() -> dict[str, type]:
    """Dataclasses that a run can contain, by name: the types of the fields of `Run`, and of their fields."""
    classes: dict[str, type] = {}

    def look(kind: Any) -> None:
        if dataclasses.is_dataclass(kind) and isinstance(kind, type) and kind is not System:
            if kind.__name__ not in classes:
                classes[kind.__name__] = kind
                for part in _kinds(kind).values():
                    look(part)
        else:
            for part in typing.get_args(kind):
                look(part)

    look(Run)
    return classes


@cache
def _kinds(parent: type) -> dict[str, Any]:
    return typing.get_type_hints(parent, localns=_ASKED_FOR)


def _fits(value: object, kind: Any) -> bool:
    """Whether a value is what the hint of a field says."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any:
        return True
    if origin in (typing.Union, types.UnionType):
        return any(_fits(value, one) for one in inner)
    if origin is typing.Literal:
        return value in inner
    if origin is tuple and inner[1:] != (...,):
        return isinstance(value, tuple) and len(value) == len(inner) and all(map(_fits, value, inner))
    if origin in (tuple, list, collections.abc.Sequence):
        return isinstance(value, tuple | list) and all(_fits(part, inner[0]) for part in value)
    if origin in (dict, collections.abc.Mapping):
        return isinstance(value, dict) and all(_fits(part, inner[1]) for part in value.values())
    if kind is float:
        return isinstance(value, float) or (type(value) is int and abs(value) < 2**1000)
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, origin or kind) if isinstance(origin or kind, type) else True


def _put_together(words: Any, arrays: Mapping[str, npt.NDArray[Any]]) -> Any:
    """The inverse of `_taken_apart`.

    Raises
    ------
    _Foreign
        If the words have another form.
    """
    match words:
        case None | bool() | int() | float() | str():
            return words
        case {"number": "nan" | "inf" | "-inf" as number}:
            return float(number)
        case {"array": str() as name} if name in arrays:
            return arrays[name]
        case {"empty": [*shape], "kind": str() as kind} if math.prod(shape) == 0:
            return np.zeros(shape, np.dtype(kind))
        case {"dict": dict() as parts}:
            return {key: _put_together(part, arrays) for key, part in parts.items()}
        case {"tuple": list() as parts}:
            return tuple(_put_together(part, arrays) for part in parts)
        case {"list": list() as parts}:
            return [_put_together(part, arrays) for part in parts]
        case {"message": str() as name, "sentence": str() as sentence} if name in MESSAGES:
            return Message(sentence, name)
        case {"system": dict() as parts}:
            try:
                return read_system(parts)
            except (TypeError, ValueError):
                raise _Foreign("it is from another version of springpot") from None
        case {"class": str() as name, "fields": dict() as parts} if name in _classes():
            given = {key: _put_together(part, arrays) for key, part in parts.items()}
            kinds = _kinds(_classes()[name])
            if not all(_fits(part, kinds[key]) for key, part in given.items() if key in kinds):
                raise _Foreign(_DAMAGED)
            try:
                return _classes()[name](**given)
            except (TypeError, ValueError):
                raise _Foreign("it is from another version of springpot") from None
    raise _Foreign(_NOT_OURS)


def _checked(words: str, arrays: Arrays, checksum: object) -> tuple[Any, Arrays]:
    if checksum_of(words, arrays) != checksum:
        raise _Foreign(_DAMAGED)
    return json.loads(words), arrays


def _read_netcdf(path: Path) -> tuple[Any, Arrays]:
    need("files", "a netCDF file (.nc)")
    import h5py

    # h5py itself rather than xarray: its errors are clear, and it decodes nothing
    largest = _largest(path)
    try:
        with h5py.File(path, "r") as file:
            own = file.get(GROUP)
            if not isinstance(own, h5py.Group) or not isinstance(own.get(WORDS), h5py.Dataset):
                raise _Foreign(_NOT_OURS)
            _check_format(int(np.ravel(own.attrs.get("format", 0))[0]))
            words = _numbers(own[WORDS], largest).tobytes().decode()
            names = _array_names(words)
            arrays = {name: _numbers(own[name], largest) for name in names if name != RECORD}
            if RECORD in names:
                arrays[RECORD] = np.stack([_numbers(file["x"], largest), _numbers(file["v"], largest)], axis=-1)
            checksum = own.attrs.get("checksum")
    except OSError as reason:
        raise _Foreign(_NOT_OURS if "file signature not found" in str(reason) else _DAMAGED) from None
    return _checked(words, arrays, checksum.decode() if isinstance(checksum, bytes) else checksum)


def _largest(path: Path) -> int:
    """The most bytes that an array in a file of this size can have."""
    return _MOST_EXPANDED * path.stat().st_size


def _numbers(dataset: Any, largest: int) -> npt.NDArray[Any]:
    if dataset.size * dataset.dtype.itemsize > largest or dataset.dtype.kind not in "fiub":
        raise _Foreign(_DAMAGED)
    return np.asarray(dataset[()])


def _array_names(words: str) -> set[str]:
    """Names of the arrays that the words refer to."""

    def walk(part: Any) -> Iterator[str]:
        if isinstance(part, dict):
            if isinstance(part.get("array"), str):
                yield part["array"]
            for inner in part.values():
                yield from walk(inner)
        elif isinstance(part, list):
            for inner in part:
                yield from walk(inner)

    return set(walk(json.loads(words)))


def _check_format(version: int) -> None:
    if version > FORMAT:
        raise _Foreign("it was written by a newer version of springpot")
    if version != FORMAT:
        raise _Foreign(_NOT_OURS)


def _unpacked(packed: Any, largest: int) -> npt.NDArray[Any]:
    kind, shape = np.dtype(packed["kind"]), tuple(packed["shape"])
    if kind.kind not in "fiub" or not all(isinstance(n, int) and n >= 0 for n in shape):
        raise _Foreign(_DAMAGED)
    size = math.prod(shape) * kind.itemsize
    if size > largest:
        raise _Foreign(_DAMAGED)
    content = zlib.decompressobj().decompress(base64.b64decode(packed["zlib_base64"], validate=True), size + 1)
    if len(content) != size:
        raise _Foreign(_DAMAGED)
    return np.frombuffer(content, kind).reshape(shape).copy()


def _read_json(path: Path) -> tuple[Any, Arrays]:
    try:
        content = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        raise _Foreign("it is not JSON, or was cut short") from None
    own = content.get(GROUP) if isinstance(content, dict) else None
    if not isinstance(own, dict) or not isinstance(own.get(WORDS), str):
        raise _Foreign(_NOT_OURS)
    _check_format(int(own["format"]))
    arrays = {name: _unpacked(packed, _largest(path)) for name, packed in own["arrays"].items()}
    return _checked(own[WORDS], arrays, own.get("checksum"))
