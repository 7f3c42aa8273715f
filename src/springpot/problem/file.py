"""A system of parts in a TOML file: read, written, and its JSON schema.

Files, `System.to_dict` and saved runs have one form of parts and laws, that of `springpot.problem.parts.checks.plain`.
It follows from what their classes state, in fewer lines than a library would take: free numbers, sentences that name
the place and what was meant, and densities in place of intensities would each need its own code beside it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING
from pathlib import Path
from types import UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

from springpot.files.units import Decimal
from springpot.machine.arguments import LARGEST, Free, Uncertain, checked_name, checked_path, finite_number
from springpot.machine.faults import FileError, listed, meant, shown
from springpot.machine.plain import read_toml
from springpot.problem.free_numbers import free
from springpot.problem.parts import RecordedExcitation, SpectralExcitation, WhiteNoise
from springpot.problem.parts.checks import Checked, fields_of, plain
from springpot.problem.parts.envelopes import Envelope
from springpot.problem.parts.records import Interpolation, Taken
from springpot.problem.parts.registration import Ends, Form, kind_of
from springpot.problem.parts.walls import Restitution
from springpot.problem.spectral_density import DensityUnit, FrequencyUnit, Sides
from springpot.problem.system import KINDS, System, checked_system, usual_names
from springpot.problem.uncertain import uncertain

_KINDS = {name: kind for name, kind in KINDS.items() if "function" not in kind.numbers}  # it has no place in a file
_FAMILIES: tuple[type[Form], ...] = (Restitution, Envelope)
"""Families of laws, the key that tells one from another in a file, and all of each by name."""


def _table_schema(said: str, keys: dict[str, Any], needed: list[str], **more: str) -> dict[str, Any]:
    """Of a table with these keys and no others."""
    table = {"type": "object", **more, "description": said, "properties": keys, "required": needed}
    return table | {"additionalProperties": False}


_A_NAME = {"type": "string", "pattern": "^[A-Za-z_][A-Za-z0-9_]*$"}
_A_NUMBER = {"$ref": "#/$defs/number"}
_OF_FREE = "start", "low", "high", "times", "plus", "power"
_OF_UNCERTAIN = "cov", "sd", "log_sd", "low", "high", "times", "plus", "power"
_NUMBER = {
    "oneOf": [
        {"type": "number"},
        _table_schema(
            "A number to be found between low and high, or times it plus something; elsewhere it has the value of "
            "start.",
            {"free": _A_NAME, **{name: {"type": "number"} for name in _OF_FREE}},
            ["free", "start", "low", "high"],
            title="free",
        ),
        _table_schema(
            "A number that differs from device to device, by a mean and its variation (cov) or standard deviation "
            "(sd), by ends (low and high) or by measured values; or times it plus something.",
            {
                "uncertain": _A_NAME,
                **{name: {"type": "number"} for name in _OF_UNCERTAIN},
                "value": _A_NUMBER,
                "values": {"type": "array", "items": {"type": "number"}, "minItems": 3},
                "correlation": {"type": "object", "additionalProperties": {"type": "number"}},
            },
            ["uncertain"],
            title="uncertain",
        ),
    ]
}
_FREE = {"free": str, **dict.fromkeys(_OF_FREE, float)}
_UNCERTAIN = {
    "uncertain": str, "correlation": dict, **dict.fromkeys(
        ("value", "cov", "sd", "log_sd", "low", "high", "values", "times", "plus", "power"), float
    )
}  # fmt: skip
_MARKED: dict[str, Any] = {"free": _FREE, "uncertain": _UNCERTAIN}
_TABLE = tuple[float, ...]
_UNIT: dict[str, Any] = {"psd_unit": DensityUnit, "sides": Sides, "on": str}
_OF_FILE: dict[str, Any] = {"unit": str, "columns": tuple[str, ...], "decimal": Decimal}
_BY_DENSITY: tuple[tuple[Callable[..., object], str, str, str, dict[str, Any], set[str]], ...] = (
    (
        WhiteNoise.from_psd, "white_noise", "psd", "White noise by its spectral density.",
        {"psd": float, **_UNIT}, {"psd", "psd_unit"},
    ),
    (
        SpectralExcitation.from_slopes, "spectral_excitation", "slopes",
        "A noise by its break points, the slopes between them in dB per octave, and its density at a frequency.",
        {"frequency": _TABLE, "slopes": _TABLE, "psd": float, "psd_unit": DensityUnit, "at": float, "scale": float,
         "level": float, "on": str},
        {"frequency", "slopes", "psd", "psd_unit", "at"},
    ),
    (
        SpectralExcitation.from_psd, "spectral_excitation", "psd_unit",
        "A noise by the points of its spectral density, or one number for all of them.",
        {"frequency": _TABLE, "psd": float | _TABLE, **_UNIT, "frequency_unit": FrequencyUnit, "scale": float,
         "level": float},
        {"frequency", "psd", "psd_unit"},
    ),
    (
        SpectralExcitation.from_file, "spectral_excitation", "path",
        "A noise by the table of its spectral density in a file, beside the system's own.",
        {"path": str, "tolerance": float, **_OF_FILE, "scale": float, "level": float, "on": str}, {"path"},
    ),
    (
        RecordedExcitation.from_file, "recorded_excitation", "path", "Records in files, beside the system's own.",
        {"path": str | tuple[str, ...], "rate": float, **_OF_FILE, "scale": float, "on": str, "taken": Taken,
         "interpolation": Interpolation}, {"path"},
    ),
)  # fmt: skip
"""Noises by their densities, and records by their files: what makes them, the kind, the key that marks this form, its
words, keys and needs."""


def read_system(source: str | Path | Mapping[str, Any], folder: str | Path | None = None) -> System:
    """A system from a TOML file, or from the same content as a mapping.

    Parameters
    ----------
    source : str, Path or mapping
        The file's place, or its content: a table ``[[parts]]`` for each part, with its ``kind`` (the name of the class
        in small letters, such as ``polynomial_spring``), its numbers under their names in Python and, if you like, a
        ``name``.  A ``white_noise`` takes ``psd``, ``psd_unit`` and ``sides`` instead of ``intensity``.  A
        ``spectral_excitation`` takes ``psd_unit`` beside ``frequency`` and ``psd``, or ``slopes`` and ``at`` too, or
        ``path``, the place of its table, and ``tolerance``.  A ``recorded_excitation`` takes ``path``, the place of a
        file or of several, and ``rate``; both take ``unit``, ``columns`` and ``decimal``.
    folder : str or Path, optional
        Where such places begin; that of the file if left out.

    Returns
    -------
    System

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        One sentence that says what is wrong in it, and where.

    Examples
    --------
    >>> read_system({"parts": [{"kind": "spring", "stiffness": 80.0}, {"kind": "dashpot", "coefficient": 0.4}]}).names
    ('spring', 'dashpot')
    """
    if isinstance(source, Mapping):
        title, content = "the system", dict(source)
        folder = None if folder is None else checked_path(folder, "folder")
    else:
        place = checked_path(source, "source")
        title = f"system file {str(place)!r}"
        content = read_toml(place, title)
        folder = place.parent if folder is None else checked_path(folder, "folder")
    try:
        for key in content:
            if key != "parts":
                raise ValueError(f"{shown(key)} is not a key of it: a system has [[parts]] and nothing else.")
        tables = content.get("parts")
        if not isinstance(tables, list) or not tables:
            raise ValueError('it must have a table [[parts]] for each part, such as kind = "spring", stiffness = 80.0.')
        return System(**_named_parts(tables, folder))
    except (TypeError, ValueError) as fault:
        raise FileError(f"{title} is not right: {fault}") from None


def to_toml(system: System) -> str:
    """The text of a file that `read_system` reads as the same system.

    Parameters
    ----------
    system : System

    Returns
    -------
    str

    Raises
    ------
    TypeError
        If it is not a System.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> print(to_toml(System(Mass(0.2), Spring(80.0))))
    [[parts]]
    name = "mass"
    kind = "mass"
    value = 0.2
    <BLANKLINE>
    [[parts]]
    name = "spring"
    kind = "spring"
    stiffness = 80.0
    <BLANKLINE>
    """
    check_writable(checked_system(system))
    tables = ({"name": name, "kind": kind_of(part), **plain(part, free=True)} for name, part in system.stated())
    return "\n".join("\n".join(["[[parts]]", *map(_line, table.items()), ""]) for table in tables)


def check_writable(system: System) -> None:
    """Raise an error if a part cannot be written to a file.

    Raises
    ------
    ValueError
        If it has a function.
    """
    for name in system.with_functions:
        raise ValueError(f"{name} cannot be written to a file, because it has a function.")


def schema() -> dict[str, Any]:
    """The JSON schema of a system file.

    Examples
    --------
    >>> schema()["properties"]["parts"]["minItems"]
    1
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "System",
        "description": "One mass on one coordinate, or several, with the parts that act on them.",
        "type": "object",
        "properties": {"parts": {"type": "array", "minItems": 1, "items": {"oneOf": [*_schemas()]}}},
        "required": ["parts"],
        "additionalProperties": False,
        "$defs": {"number": _NUMBER},
    }


def _named_parts(tables: list[Any], folder: Path | None) -> dict[str, object]:
    """The parts by name: that in the file, or the kind with a number where there are several."""
    made = [(table, *_part(table, f"parts[{place}]", folder)) for place, table in enumerate(tables)]
    usual = usual_names([kind for _, kind, _ in made])
    parts: dict[str, object] = {}
    for place, (table, _, part) in enumerate(made):
        name = checked_name(table.get("name", usual[place]), f"parts[{place}].name")
        if name in parts:
            raise ValueError(f"{name} is the name of two parts: give one of them another name.")
        parts[name] = part
    return parts


def _part(table: object, place: str, folder: Path | None) -> tuple[str, object]:
    """The kind of a table, and the part that it states."""
    if not isinstance(table, Mapping):
        raise ValueError(f"{place} must be a table with a kind, not {shown(table)}.")
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in _KINDS:
        near = meant(kind, _KINDS) or "."
        raise ValueError(f"{place}.kind must be one of {listed([*_KINDS], 'or')}, not {shown(kind)}{near}")
    numbers = {key: value for key, value in table.items() if key not in ("kind", "name")}
    where = f"{place} ({kind})"
    for make, own, mark, _, keys, needed in _BY_DENSITY:
        if kind == own and mark in numbers:
            _check_keys(numbers, keys, needed, where)
            read = _all_read(keys, numbers, where)
            if mark == "path":
                read["path"] = _places(read["path"], folder, where, several=keys["path"] is not str)
            return kind, _made(make, read, where)
    return kind, _build(_KINDS[kind], numbers, where)


def _places(given: Any, folder: Path | None, where: str, several: bool) -> Path | list[Path]:
    """The places of files beside that of the system; what has no place, as a text of the page, reads no others."""
    if folder is None:
        raise ValueError(f"{where}.path is read from a system's file only: give the points themselves.")
    paths = given if several and isinstance(given, list) else [given]
    if not all(isinstance(path, str) for path in paths):
        more = ", or a list of them" if several else ""
        raise ValueError(f"{where}.path must be the place of a file{more}, not {shown(given)}.")
    found = [folder / path for path in paths]
    return found if several else found[0]


def _build(kind: type[Checked], numbers: Mapping[str, Any], where: str) -> object:
    """A part of that kind; parts of a part, and laws, are tables of their own."""
    hints = _hints(kind)
    needed = {field.name for field in fields_of(kind) if field.default is MISSING}
    usual = [own.name for own in fields_of(kind) if own.repr]
    _check_keys(numbers, hints, needed, where, usual)
    return _made(kind, _all_read(hints, numbers, where), where)


def _all_read(hints: Mapping[str, Any], numbers: Mapping[str, Any], where: str) -> dict[str, Any]:
    return {name: _read(hints[name], value, f"{where}.{name}") for name, value in numbers.items()}


def _read(hint: Any, value: Any, where: str) -> Any:
    if isinstance(value, list):
        return [_marked(one, f"{where}[{n}]") if isinstance(one, Mapping) else one for n, one in enumerate(value)]
    if _is_a(hint, Checked) and not isinstance(value, Mapping):
        raise ValueError(f"{where} must be a table of its numbers, not {shown(value)}.")
    if not isinstance(value, Mapping):
        return value
    if _is_a(hint, Checked) and _MARKED.keys().isdisjoint(value):
        return _build(hint, value, where)
    for family in _FAMILIES:
        if any(_is_a(one, family) for one in get_args(hint)) and _MARKED.keys().isdisjoint(value):
            key, known, numbers = family.key, family.known, dict(value)
            named = numbers.pop(key, None)
            if not isinstance(named, str) or named not in known:
                raise ValueError(f"{where}.{key} must be one of {listed([*known], 'or')}, not {shown(named)}.")
            return _build(known[named], numbers, where)
    return _marked(value, where)


def _hints(kind: type[Checked]) -> dict[str, Any]:
    """The types of the fields."""
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields_of(kind)}


def _is_a(hint: Any, kind: type) -> bool:
    return isinstance(hint, type) and issubclass(hint, kind)


def _marked(table: Mapping[str, Any], where: str) -> Free:
    """A free number, or an uncertain one, from its table."""
    kind = "uncertain" if "uncertain" in table else "free"
    needed = {"uncertain"} if kind == "uncertain" else {*_FREE} - {"times", "plus", "power"}
    _check_keys(table, _MARKED[kind], needed, where)
    try:
        number = _uncertain(table) if kind == "uncertain" else free(
            table["free"], table["start"], (table["low"], table["high"])
        )  # fmt: skip
        times = finite_number(table.get("times", 1.0), "times", low=-LARGEST, high=LARGEST)
        plus = finite_number(table.get("plus", 0.0), "plus", low=-LARGEST, high=LARGEST)
        power = finite_number(table.get("power", 1.0), "power", low=-10.0, high=10.0)
        if times == 0.0 or power == 0.0:
            raise ValueError(f"{'times' if times == 0.0 else 'power'} must not be 0: then the number is not {kind}.")
        if power != 1.0 and not number.low > 0.0:
            raise ValueError("low must be greater than 0 of a number with a power.")
        raised: Any = number if power == 1.0 else number**power
        found: Free = raised if (times, plus) == (1.0, 0.0) else times * raised + plus
        return found
    except (TypeError, ValueError) as fault:
        raise ValueError(f"{where}.{fault}") from None


def _uncertain(table: Mapping[str, Any]) -> Uncertain:
    given = {name: table[name] for name in ("cov", "sd", "log_sd", "values", "correlation") if name in table}
    if ("low" in table) != ("high" in table):
        raise ValueError("low and high must be given together.")
    bounds = (table["low"], table["high"]) if "low" in table else None
    value = table.get("value")
    centre = _marked(value, "value") if isinstance(value, Mapping) else value
    return uncertain(table["uncertain"], centre, bounds=bounds, **given)


def _made(make: Any, values: Mapping[str, Any], where: str) -> object:
    try:
        return make(**values)
    except (FileNotFoundError, FileError) as fault:
        raise FileError(f"{where}: {fault}") from None
    except (TypeError, ValueError) as fault:
        raise ValueError(f"{where}.{fault}") from None


def _check_keys(
    numbers: Mapping[str, Any], known: Mapping[str, Any], needed: set[str], where: str, usual: list[str] | None = None
) -> None:
    for key in numbers:
        if key not in known:
            hint = meant(str(key), known) or f": its keys are {listed(usual or [*known])}."
            raise ValueError(f"{shown(key)} is not a key of {where}{hint}")
    if missing := [name for name in known if name in needed and name not in numbers]:
        raise ValueError(f"{where} needs {listed(missing)}.")


def _line(item: tuple[str, Any]) -> str:
    return f"{item[0]} = {_value(item[1])}"


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(map(_line, value.items()))} }}"
    if isinstance(value, tuple):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value) if isinstance(value, str) else repr(value)


def _schemas() -> Iterator[dict[str, Any]]:
    for kind, part in _KINDS.items():
        table = _schema(part)
        table["title"] = part.__name__
        head = {"kind": {"const": kind}, "name": _A_NAME}
        table["properties"] = head | table["properties"]
        table["required"] = ["kind", *table["required"]]
        yield table
    for make, kind, _, said, keys, needed in _BY_DENSITY:
        own = head | {"kind": {"const": kind}} | {name: _schema_of(hint) for name, hint in keys.items()}
        required = ["kind", *(name for name in keys if name in needed)]
        yield _table_schema(said, own, required, title=make.__qualname__)


def _schema(kind: type[Checked], within: bool = False) -> dict[str, Any]:
    described = (kind.__doc__ or "").partition("\n")[0].replace("\\", "")
    tag = {name: {"const": value} for name, value in kind.tag.items()}
    needed = [field.name for field in fields_of(kind) if field.default is MISSING]
    hints = {name: hint for name, hint in _hints(kind).items() if not (within and name in ("between", "count"))}
    own = {name: _schema_of(hint) for name, hint in hints.items()}
    return _table_schema(described, tag | own, [*tag, *needed])


def _schema_of(hint: Any) -> dict[str, Any]:
    if _is_a(hint, Checked):
        return _schema(hint, within=True)
    if hint == Ends:
        return {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
    if hint is str:
        return {"type": "string"}
    if hint is int:
        return {"type": "integer", "minimum": 1}
    for family in _FAMILIES:
        if any(_is_a(one, family) for one in get_args(hint)):
            return {"anyOf": [*([_A_NUMBER] if float in get_args(hint) else []), *map(_schema, family.known.values())]}
    if get_origin(hint) is UnionType:
        return {"anyOf": [*map(_schema_of, get_args(hint))]}
    if get_origin(hint) is Literal:
        return {"enum": [*get_args(hint)]}
    if get_origin(hint) is tuple:
        return {"type": "array", "items": _schema_of(get_args(hint)[0]), "minItems": 1}
    return _A_NUMBER
