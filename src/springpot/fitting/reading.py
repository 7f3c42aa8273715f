"""Data from a file of measurements."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, get_args

import numpy as np

from springpot.files.reading import contents
from springpot.files.table import Column, Stated, Table
from springpot.files.text import Sheet, table_of
from springpot.files.units import OF_GROUND, OF_INPUT, Decimal, is_called
from springpot.fitting.columns import PointFault, column
from springpot.fitting.frequency_response import MeasuredFrequencyResponse
from springpot.fitting.motion_data import MeasuredRecord, MeasuredSpectrum, Start
from springpot.fitting.part_data import MeasuredCreep, MeasuredImpacts, MeasuredModuli, MeasuredRelaxation
from springpot.fitting.reading_statistics import HEADER, statistics_in
from springpot.fitting.statistics import MeasuredStatistics
from springpot.machine.arguments import checked_path
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, listed, meant, shown
from springpot.machine.sampling import checked_rate
from springpot.problem.messages import warn_of_file

Data = (
    MeasuredModuli
    | MeasuredRelaxation
    | MeasuredCreep
    | MeasuredSpectrum
    | MeasuredFrequencyResponse
    | MeasuredRecord
    | MeasuredImpacts
    | MeasuredStatistics
)
"""Every kind of measured data."""

_RESPONSES: dict[str, tuple[str, str]] = {
    "m/N": ("x", "mass"), "mm/N": ("x", "mass"), "um/N": ("x", "mass"), "m/s/N": ("v", "mass"), "mm/s/N": ("v", "mass"),
    "m/s2/N": ("a", "mass"), "g/N": ("a", "mass"), "s2": ("x", "ground"), "s": ("v", "ground"), "1": ("a", "ground"),
    "g/g": ("a", "ground"),
}  # fmt: skip
"""What a response is of, and on, by its unit."""

_COLUMNS: dict[str, set[str]] = {
    "a record": {"time", "x", "v", "a", "force"}, "impacts": {"before", "after"},
    "a spectrum": {"frequency", "density"},
    "a frequency response": {"frequency", "magnitude", "phase", "real", "imaginary", "coherence"},
    "moduli": {"frequency", "storage", "loss", "tan_delta"},
    "relaxation": {"time", "modulus"}, "creep": {"time", "compliance"},
}  # fmt: skip
_SETTINGS = {
    "relative_error": ("moduli", "a frequency response", "relaxation", "creep"),
    "averages": ("a spectrum", "a frequency response"),
    "sampling_rate_hz": ("a spectrum", "a record"), "window": ("a spectrum",), "segment": ("a spectrum",),
    "noise": ("a spectrum", "a record"), "of": ("a spectrum",), "error": ("impacts",),
    "on": ("a frequency response", "a record"), "interpolation": ("a record",), "start": ("a record",),
    "skip": ("a record",), "delay": ("a record",), "at": ("a spectrum", "a record", "a frequency response"),
}  # fmt: skip
"""What each kind of data may have, columns and settings."""
_SETTING = re.compile(r"([A-Za-z_]+)\s*([=:])(.+)")
_MOTION = ("x", "v", "a")
_AGREES = 0.05  # tan delta with loss / storage, as a share


def read_data(
    path: str | Path, *, rate: float | None = None, unit: str = "",
    columns: Sequence[str] | Mapping[str, str] | None = None, decimal: Decimal = "",
) -> Data:  # fmt: skip
    """Measured data from a file, whose kind is found from its content.

    Parameters
    ----------
    rate : float, optional
        Samples per second, of a record without a column of the time.
    unit : str, optional
        Of the values, where the file does not say it.
    columns : sequence of str or mapping, optional
        A header for each column of a file without one, such as ``["time_s", "x_mm"]``, empty for one that is left out;
        or headers by the names in the file, of the columns that are wanted.
    decimal : {".", ","}, optional
        The decimal mark, where it cannot be told.
    path : str or Path
        Records of PEER (.AT2) and in the SMC or COSMOS format, universal files (dataset 58), MATLAB files, or a table
        in text: a header with names and units, then a row for each point:

        - moduli: ``frequency_hz``, ``storage_Pa`` and ``loss_Pa``, or one of them; or ``tan delta`` for one of them;
        - relaxation: ``time_s`` and ``modulus_Pa``; creep: ``time_s`` and ``compliance_1/Pa``; also of a whole part, in
          ``N/m`` and ``m/N``.  A line at time 0 is left out;
        - a spectrum: ``frequency_hz`` and ``density_m2/Hz`` (of x), ``density_m2/s2/Hz`` (of v), ``density_m2/s4/Hz``
          or ``density_g2/Hz`` (of an acceleration), ``density_N2/Hz`` (of a force, with ``# of = mount_force``);
        - a frequency response: ``frequency_hz``, ``magnitude_m/N`` and ``phase_deg``, or ``real_m/N`` and
          ``imaginary_m/N``, perhaps ``coherence_1``; of the velocity ``m/s/N``, of the acceleration ``m/s2/N`` or
          ``g/N``; to the ground's acceleration ``s2``, ``s`` and ``1`` (or ``g/g``);
        - a record: ``time_s`` and ``x_m``, ``v_m/s``, ``a_m/s2`` or ``a_g``; a column for each path; without a column
          of the time with the setting ``# sampling_rate_hz = 256``, or ``rate``;
        - a record with its measured input: beside these ``force_N`` or ``input_N`` (on the mass, or on that of a line
          ``# on = box``), ``ground_acceleration_g`` or ``input_m/s2`` (on the ground);
        - impacts: ``before_m/s`` and ``after_m/s``;
        - statistics: the header ``quantity,value,error``, then lines such as ``x_rms (mm),2.41,0.03`` or
          ``impact_rate (1/min),97,2``.

        Other names and units in use are understood too, such as ``Time (sec)``, ``Acc (G)``, ``E' (MPa)``.  Lines that
        begin with ``#``, ``%`` or ``//`` are comments, or settings such as ``# averages = 64``: ``relative_error``,
        ``averages``, ``sampling_rate_hz``, ``window``, ``segment``, ``noise`` and ``error`` (both in SI units).  Of
        several masses ``at`` is the one that was measured, and ``on`` the one that the force acts on.  A record with
        its input may have ``interpolation``, ``start``, ``skip`` and ``delay`` (``found`` or in s) of `MeasuredRecord`,
        and ``at = box, lid`` for several columns.  The file may have 200 MB, 1000 columns and 20 million numbers.

    Returns
    -------
    one of the ``Measured...`` classes
        In SI units.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        One sentence that says what is wrong in it, in which line, and what to do.

    Warns
    -----
    FileWarning
        With what was assumed, in one line.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "rubber.csv"
    >>> _ = place.write_text("frequency_hz,storage_MPa,loss_MPa\\n0.1,1.0,0.2\\n1,1.5,0.4\\n10,2.3,0.7\\n")
    >>> read_data(place).storage.tolist()
    [1000000.0, 1500000.0, 2300000.0]
    """
    path = checked_path(path, "path")
    title = f"data file {str(path)!r}"
    data, notes = _read(path, title, Stated(unit, columns, rate, decimal))
    warn_of_file(title, notes)
    return data


def data_of(content: bytes, title: str, stop: Callable[[], bool] | None = None) -> tuple[Data, list[str]]:
    """Measured data from the content of such a file, and what was assumed.

    Parameters
    ----------
    content : bytes
    title : str
        Names it in what is said of its faults.
    stop : callable, optional
        Asked at each line whether to stop.

    Raises
    ------
    ValueError
        As `read_data`.
    springpot.machine.faults.Stopped
        If reading was stopped.

    Examples
    --------
    >>> data_of(b"before_m/s,after_m/s\\n1,0.7\\n2,1.4\\n3,2.1\\n", "impacts.csv")[0].after.tolist()
    [0.7, 1.4, 2.1]
    """
    return _read(content, title, Stated(), stop)


def _read(
    source: Path | bytes, title: str, stated: Stated, stop: Callable[[], bool] | None = None
) -> tuple[Data, list[str]]:
    settings: dict[str, str] = {}
    note = partial(_note, settings=settings, title=title)
    with contents(source, title, stated, note, HEADER, stop) as found:
        if isinstance(found, Sheet) and found.names == [*HEADER]:
            statistics = statistics_in(found.rows, title, found.decimal)
            if stated.rate is not None:
                raise FileError(f"rate is of a record, and {title} has statistics: leave it out.")
            if settings:
                name = next(iter(settings))
                raise FileError(f"{title} is not right: {name} is a setting of {listed(_SETTINGS[name], 'or')}, not of "
                                "statistics.")  # fmt: skip
            return statistics, found.notes
        table = found if isinstance(found, Table) else table_of(found, stated)
    try:
        return _made(table, settings, stated), table.notes
    except PointFault as fault:
        raise FileError(f"{table.where(fault.place)}: {_header_of(table.columns, fault.name)} {fault.what}") from None
    except FileError:
        raise
    except (TypeError, ValueError) as fault:
        raise FileError(f"{title} is not right: {fault}") from None


def _note(line: str, number: int, *, settings: dict[str, str], title: str) -> None:
    """A comment, which may be a setting."""
    match = _SETTING.fullmatch(line.strip())
    if match is None:
        return
    name, sign, text = match[1], match[2], match[3].strip()
    if name.lower() == "start" and sign == ":" and text not in get_args(Start):
        return  # of a logger, that says when it began
    if name not in _SETTINGS:
        if near := meant(name, _SETTINGS):
            raise FileError(f"{title}, line {number}: {shown(name)} is not a setting{near}")
        return
    if name in settings:
        raise FileError(f"{title}, line {number}: {name} must be given only once.")
    settings[name] = text


def _made(table: Table, settings: Mapping[str, str], stated: Stated) -> Data:
    columns, names = table.columns, [column.quantity for column in table.columns]
    rate = stated.rate
    if names and {*names} <= {*_MOTION, "force"} and (rate or table.rate or "sampling_rate_hz" in settings):
        return _record(table, settings, stated)
    if rate is not None:
        kind = "with a column of the time" if "time" in names else "of another kind"
        raise ValueError(f"rate must be left out of data {kind}: it is that of a record without one.")
    first = next((name for name in ("frequency", "time", "before") if name in names), None)
    if first is None:
        raise ValueError("it must have a column frequency_hz (moduli, a spectrum or a frequency response), time_s (a "
                         "record, relaxation or creep; or give the rate of a record) or before_m/s (impacts), or the "
                         "header quantity,value,error (statistics).")  # fmt: skip
    for name, count in Counter(names).items():
        if count > 1 and name not in (*_MOTION, *(("force",) if first == "time" else ())):
            raise ValueError(f"{name} must be one column, not {count}: columns= takes the one that is meant.")
    own = {column.quantity: column for column in columns}
    if first == "time" and ({*_MOTION, "force"} & {*own} or not {"modulus", "compliance"} & {*own}):
        return _record(table, settings, stated)
    if first == "time":
        own = _without_zero(table, "time")
        if "modulus" in own:
            return MeasuredRelaxation(own["time"].values, own["modulus"].values, **_given(own, settings, "relaxation"))
        return MeasuredCreep(own["time"].values, own["compliance"].values, **_given(own, settings, "creep"))
    if first == "before":
        given = _given(own, settings, "impacts")
        if "after" not in own:
            raise ValueError("it must have a column after_m/s beside that of the speeds before.")
        return MeasuredImpacts(own["before"].values, own["after"].values, **given)
    if "density" in own:
        return _spectrum(_without_zero(table), settings)
    if {"magnitude", "phase", "real", "imaginary", "coherence"} & {*own}:
        return _response(_without_zero(table), settings)
    given = _given(own, settings, "moduli")
    moduli: dict[str, Any] = {name: own[name].values for name in ("storage", "loss") if name in own}
    if not moduli:
        raise ValueError("it must have a column storage_Pa, loss_Pa, density_m2/Hz or magnitude_m/N beside that of the "
                         "frequencies.")  # fmt: skip
    areal = {"Pa" in own[name].unit for name in moduli}
    if len(areal) > 1:
        raise ValueError("storage and loss must both be moduli in Pa, or both stiffnesses in N/m.")
    if "tan_delta" in own:
        _complete(moduli, own["tan_delta"].values, table)
    return MeasuredModuli(own["frequency"].values, **moduli, **given)


def _complete(moduli: dict[str, Any], tangent: Floats, table: Table) -> None:
    """The modulus that is missing, by tan delta; where none is, the three must agree."""
    with np.errstate(all="ignore"):
        if "loss" not in moduli:
            moduli["loss"] = moduli["storage"] * tangent
        elif "storage" not in moduli:
            moduli["storage"] = moduli["loss"] / tangent
        elif (wrong := ~(np.abs(moduli["storage"] * tangent / moduli["loss"] - 1.0) <= _AGREES)).any():
            point = int(wrong.argmax()) + 1
            raise ValueError(f"tan delta must be loss / storage, but is not at point {point}: columns= leaves it out.")


def _without_zero(table: Table, name: str = "frequency") -> dict[str, Column]:
    """The columns by what they are, without the line at 0, of which no model says anything."""
    at = table.of(name)[0].values
    first = int(at.size > 1 and at[0] == 0.0)
    if first:
        table.notes.append(f"its line at 0 {'s' if name == 'time' else 'Hz'} is left out")
    return {column.quantity: replace(column, values=column.values[first:]) for column in table.columns}


def _record(table: Table, settings: Mapping[str, str], stated: Stated) -> MeasuredRecord:
    time, rate = next(iter(table.of("time")), None), stated.rate
    given = _given((), settings, "a record")
    in_file = checked_rate(given.pop("sampling_rate_hz", None))
    if in_file is not None and (time is not None or rate is not None):
        other = "rate" if time is None else "the column of the time"
        raise ValueError(f"sampling_rate_hz must be left out beside {other}.")
    if time is None:
        rate = in_file or table.sampled_at(rate)
    drive, own = _driven(table, given.get("on"))
    if drive is not None:
        given |= _responses(drive, own, given)
    else:
        kinds = {column.quantity for column in own}
        if len(kinds) != 1 or not kinds <= {*_MOTION}:
            raise ValueError("a record must have columns of one kind beside the time, such as x_m, not "
                             f"{_headers(own)}: columns= takes those that are meant.")  # fmt: skip
        own = table.alike(own[0].quantity, stated)
        given["of"] = own[0].quantity
    values = np.array([column.values for column in own])
    times = np.arange(values.shape[1]) / (rate or 1.0) if time is None else time.values
    return MeasuredRecord(times, values, **given)


def _driven(table: Table, on: str | None) -> tuple[Column | None, list[Column]]:
    """The column of the input, if there is one, and the other ones beside the time.

    It is a force, or an acceleration by its name; or, where a setting says that it acts on the ground, the only
    acceleration beside a displacement or a velocity.
    """
    own = [column for column in table.columns if column.quantity != "time"]
    found = [column for column in own if _is_input(column)]
    moved = [column for column in own if column not in found]
    accelerations = [column for column in moved if column.quantity == "a"]
    if not found and accelerations and len(accelerations) < len(moved):
        if on != "ground" or len(accelerations) > 1:
            raise ValueError(f"it has {_headers(moved)}, and one may be the input: call that ground_acceleration_g, or "
                             "leave out columns by columns=, which takes those that are meant.")  # fmt: skip
        found, moved = accelerations, [column for column in moved if column not in accelerations]
    if len(found) > 1:
        raise ValueError(f"it must have one input, not {_headers(found)}: columns= takes those that are meant.")
    if found and not moved:
        raise ValueError(f"it must have a column of the response, such as x_m, beside its input, {found[0].header}.")
    return (found[0] if found else None), moved


def _is_input(column: Column) -> bool:
    """Whether a column is an input by what it is, or by its name."""
    return column.quantity == "force" or (column.quantity == "a" and is_called(column.header, (*OF_INPUT, *OF_GROUND)))


def _headers(columns: Iterable[Column]) -> str:
    return listed([*dict.fromkeys(column.header for column in columns)] or ["nothing"])


def _responses(drive: Column, own: Sequence[Column], given: Mapping[str, Any]) -> dict[str, Any]:
    """What a record with its input is of, where, and what drove it."""
    on = given.get("on", "mass" if drive.quantity == "force" else "ground")
    is_force, of_ground = drive.quantity == "force", is_called(drive.header, OF_GROUND)
    if is_force if on == "ground" else of_ground:
        acts = "a mass" if is_force else "the ground"
        raise ValueError(f"on must not be {shown(on)}: {drive.header} acts on {acts}.")
    of, at = tuple(column.quantity for column in own), given.get("at")
    places = tuple(name.strip() for name in at.split(",")) if at else (None,) * len(own)
    if len(places) != len(own) or (not at and len({*of}) < len(of)):
        raise ValueError(f"at must name the mass of each column, {_headers(own)}, in a line such as: # at = "
                         f"{', '.join(['box', 'lid', 'plate'][: len(own)])}")  # fmt: skip
    alone = len(own) == 1
    return {"input": drive.values, "on": on, "of": of[0] if alone else of, "at": places[0] if alone else places}


def _spectrum(own: Mapping[str, Column], settings: Mapping[str, str]) -> MeasuredSpectrum:
    given = _given(own, settings, "a spectrum")
    if "averages" not in given:
        raise ValueError("it must state the number of averages in a line such as: # averages = 64")
    if "sampling_rate_hz" in given:
        given["sampling_rate"] = given.pop("sampling_rate_hz")
    density = own["density"]
    of: Any = {"m2/Hz": "x", "mm2/Hz": "x", "m2/s2/Hz": "v", "mm2/s2/Hz": "v"}.get(density.unit, "a")
    is_force, named = density.unit.startswith(("N", "kN")), given.get("of", of)
    if is_force and "of" not in given:
        raise ValueError("a density of a force must state of which in a line such as: # of = mount_force")
    seen = "a" if named.endswith("acceleration") else named if named in ("x", "v", "a") else ""
    fitting = ("",) if is_force else (of,) if of != "a" else ("a", "")  # without a mass a force is in m/s^2
    if seen not in fitting:
        raise ValueError(f"{density.header} is no density of {shown(named)[1:-1]}: its unit is another.")
    return MeasuredSpectrum(own["frequency"].values, density.values, **{"of": of, **given})


def _response(own: Mapping[str, Column], settings: Mapping[str, str]) -> MeasuredFrequencyResponse:
    given = _given(own, settings, "a frequency response")
    pairs = [pair for pair in (("magnitude", "phase"), ("real", "imaginary")) if {*pair} & {*own}]
    if len(pairs) != 1 or not {*pairs[0]} <= {*own}:
        raise ValueError("a frequency response must have columns magnitude_m/N and phase_deg, or real_m/N and "
                         "imaginary_m/N.")  # fmt: skip
    first, second = (own[name] for name in pairs[0])
    if pairs[0] == ("real", "imaginary") and first.unit != second.unit:
        raise ValueError(f"real and imaginary must have the same unit, not {first.unit} and {second.unit}.")
    a, b = column(first.values, first.quantity), column(second.values, second.quantity)
    response = a * np.exp(1j * b) if pairs[0] == ("magnitude", "phase") else a + 1j * b
    if "coherence" in own:
        given["coherence"] = own["coherence"].values
    of, on = _RESPONSES[first.unit]
    if on == "ground" and "on" in given:
        raise ValueError(f"on is of a force, and {first.header} is of the ground's acceleration.")
    given = {"of": of, "on": on, **given}
    return MeasuredFrequencyResponse(own["frequency"].values, response, **given)


def _given(columns: Iterable[str], settings: Mapping[str, str], kind: str) -> dict[str, Any]:
    """The settings as numbers; columns and settings must be those of the kind."""
    for name in columns:
        if name not in _COLUMNS[kind]:
            raise ValueError(f"{name} cannot be a column of {kind}.")
    found: dict[str, Any] = {}
    for name, text in settings.items():
        if kind not in _SETTINGS[name]:
            raise ValueError(f"{name} is a setting of {listed(_SETTINGS[name], 'or')}, not of {kind}.")
        if name in ("window", "at", "on", "of", "interpolation", "start"):
            found[name] = text.strip("'\"")
            continue
        if name == "delay" and text.strip("'\"") == "found":
            found[name] = None
            continue
        try:
            found[name] = int(text) if name == "segment" else float(text)
        except ValueError:
            raise ValueError(f"{name} must be a {'whole ' * (name == 'segment')}number, not {shown(text)}.") from None
    return found


def _header_of(columns: list[Column], name: str) -> str:
    """The header of the column that a fault of the data names."""
    plain = {"frequency_hz": ("frequency",), "values": ("x",), "response": ("magnitude", "real")}.get(name, (name,))
    if name == "input":  # of a name, or by the setting that it acts on the ground
        inputs = [column.header for column in columns if _is_input(column)]
        return (inputs or [column.header for column in columns if column.quantity == "a"])[0]
    found = [column.header for column in columns if column.quantity in plain]
    moved = [column.header for column in columns if column.quantity in _MOTION and not _is_input(column)]
    return (found or moved or [name])[0]
