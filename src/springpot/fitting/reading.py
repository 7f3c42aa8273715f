"""Data from a CSV file whose header has the units."""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from springpot.fitting.columns import PointFault, column
from springpot.fitting.frequency_response import MeasuredFrequencyResponse
from springpot.fitting.motion_data import MeasuredRecord, MeasuredSpectrum
from springpot.fitting.part_data import MeasuredImpacts, MeasuredModuli
from springpot.fitting.reading_statistics import HEADER, statistics_in
from springpot.fitting.statistics import MeasuredStatistics
from springpot.machine.arguments import checked_path
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, listed, meant, shown
from springpot.machine.files import open_text
from springpot.machine.rows import rows_of, table_in
from springpot.machine.sampling import checked_rate
from springpot.problem.spectral_density import FREQUENCY_UNITS, STANDARD_GRAVITY

Data = (
    MeasuredModuli
    | MeasuredSpectrum
    | MeasuredFrequencyResponse
    | MeasuredRecord
    | MeasuredImpacts
    | MeasuredStatistics
)
"""Every kind of measured data."""

UNITS: dict[str, dict[str, float]] = {
    "frequency": FREQUENCY_UNITS,
    "storage": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3},
    "density": {"m2/Hz": 1.0, "mm2/Hz": 1e-6, "m2/s2/Hz": 1.0, "mm2/s2/Hz": 1e-6, "m2/s4/Hz": 1.0,
                "g2/Hz": STANDARD_GRAVITY**2, "N2/Hz": 1.0, "kN2/Hz": 1e6},
    "time": {"s": 1.0, "ms": 1e-3},
    "x": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "v": {"m/s": 1.0, "mm/s": 1e-3},
    "a": {"m/s2": 1.0, "g": STANDARD_GRAVITY},
    "before": {"m/s": 1.0, "mm/s": 1e-3},
    "magnitude": {},
    "phase": {"deg": np.pi / 180.0, "rad": 1.0},
    "coherence": {"1": 1.0},
}  # fmt: skip
"""What a column may be, and the units it may have."""
UNITS["loss"], UNITS["after"] = UNITS["storage"], UNITS["before"]

_RESPONSES: dict[str, tuple[float, str, str]] = {
    "m/N": (1.0, "x", "mass"), "mm/N": (1e-3, "x", "mass"), "um/N": (1e-6, "x", "mass"), "m/s/N": (1.0, "v", "mass"),
    "mm/s/N": (1e-3, "v", "mass"), "m/s2/N": (1.0, "a", "mass"), "g/N": (STANDARD_GRAVITY, "a", "mass"),
    "s2": (1.0, "x", "ground"), "s": (1.0, "v", "ground"), "1": (1.0, "a", "ground"), "g/g": (1.0, "a", "ground"),
}  # fmt: skip
"""Units of a response: their size, and what such a response is of, and on."""
UNITS["magnitude"] = UNITS["real"] = UNITS["imaginary"] = {unit: size for unit, (size, _, _) in _RESPONSES.items()}

_COLUMNS: dict[str, set[str]] = {
    "a record": {"time", "x", "v", "a"}, "impacts": {"before", "after"}, "a spectrum": {"frequency", "density"},
    "a frequency response": {"frequency", "magnitude", "phase", "real", "imaginary", "coherence"},
    "moduli": {"frequency", "storage", "loss"},
}  # fmt: skip
_SETTINGS = {
    "relative_error": ("moduli", "a frequency response"), "averages": ("a spectrum", "a frequency response"),
    "sampling_rate_hz": ("a spectrum", "a record"), "window": ("a spectrum",), "segment": ("a spectrum",),
    "noise": ("a spectrum", "a record"), "of": ("a spectrum",), "error": ("impacts",), "on": ("a frequency response",),
    "at": ("a spectrum", "a record", "a frequency response"),
}  # fmt: skip
"""What each kind of data may have, columns and settings."""
MOST_BYTES = 200_000_000
_SETTING = re.compile(r"#\s*([A-Za-z_]+)\s*[=:](.+)")


@dataclass(frozen=True, eq=False)
class _Column:
    """A column of the file in SI units."""

    header: str
    name: str
    unit: str
    values: Floats


def read_data(path: str | Path, *, rate: float | None = None) -> Data:
    """Measured data from a CSV file.

    Parameters
    ----------
    rate : float, optional
        Samples per second, of a record without a column of the time.
    path : str or Path
        A header with the units, then a row for each point, separated by commas, semicolons or tabs:

        - moduli: ``frequency_hz``, ``storage_Pa`` and ``loss_Pa``, or one of them;
        - a spectrum: ``frequency_hz`` and ``density_m2/Hz`` (of x), ``density_m2/s2/Hz`` (of v), ``density_m2/s4/Hz``
          or ``density_g2/Hz`` (of an acceleration), ``density_N2/Hz`` (of a force, with ``# of = mount_force``);
        - a frequency response: ``frequency_hz``, ``magnitude_m/N`` and ``phase_deg``, or ``real_m/N`` and
          ``imaginary_m/N``, perhaps ``coherence_1``; of the velocity ``m/s/N``, of the acceleration ``m/s2/N`` or
          ``g/N``; to the ground's acceleration ``s2``, ``s`` and ``1`` (or ``g/g``);
        - a record: ``time_s`` and ``x_m``, ``v_m/s``, ``a_m/s2`` or ``a_g``; a column for each path; without a column
          of the time with the setting ``# sampling_rate_hz = 256``, or ``rate``;
        - impacts: ``before_m/s`` and ``after_m/s``;
        - statistics: the header ``quantity,value,error``, then lines such as ``x_rms (mm),2.41,0.03`` or
          ``impact_rate (1/min),97,2``.

        Other units are ``rad/s``, ``kHz``, ``kPa``, ``MPa``, ``GPa``, ``N/m``, ``N/mm``, ``ms``, ``mm``, ``um`` and
        ``mm/s``.  Lines that begin with ``#`` are comments, or settings such as ``# averages = 64``:
        ``relative_error``, ``averages``, ``sampling_rate_hz``, ``window``, ``segment``, ``noise`` and ``error`` (both
        in SI units).  Of several masses ``at`` is the one that was measured, and ``on`` the one that the force acts on.
        The file may have 200 MB, 1000 columns and 20 million numbers.

    Returns
    -------
    one of the ``Measured...`` classes
        In SI units.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        One sentence that says what is wrong in it, and in which line.

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
    rate = checked_rate(rate)
    with open_text(path, title, MOST_BYTES) as file:
        return _read(file, title, rate=rate)


def data_of(text: str, title: str, stop: Callable[[], bool] | None = None) -> Data:
    """Measured data from the text of such a file.

    Parameters
    ----------
    text : str
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
    >>> data_of("before_m/s,after_m/s\\n1,0.7\\n2,1.4\\n3,2.1\\n", "impacts.csv").after.tolist()
    [0.7, 1.4, 2.1]
    """
    return _read(io.StringIO(text, newline=None), title, stop)


def _read(file: TextIO, title: str, stop: Callable[[], bool] | None = None, rate: float | None = None) -> Data:
    settings: dict[str, str] = {}
    rows = rows_of(file, title, partial(_note, settings=settings, title=title), stop)
    line, cells = next(rows)
    if tuple(" ".join(cell.split()).lower() for cell in cells) == HEADER:
        found = statistics_in(rows, title)
        if rate is not None:
            raise FileError(f"rate is of a record, and {title} has statistics: leave it out.")
        if settings:
            name = next(iter(settings))
            raise FileError(
                f"{title} is not right: {name} is a setting of {listed(_SETTINGS[name], 'or')}, not of statistics."
            )
        return found
    table = table_in(chain([(line, cells)], rows), UNITS, title)
    each = zip(table.heads, table.columns, table.values.T, strict=True)
    columns = [_Column(head, *own, values) for head, own, values in each]
    try:
        return _made(columns, settings, rate)
    except PointFault as fault:
        header = _header_of(columns, fault.name)
        raise FileError(f"{title}, line {table.lines[fault.place]}: {header} {fault.what}") from None
    except (TypeError, ValueError) as fault:
        raise FileError(f"{title} is not right: {fault}") from None


def _note(line: str, number: int, *, settings: dict[str, str], title: str) -> None:
    """A comment, which may be a setting."""
    match = _SETTING.fullmatch(line.strip())
    if match is None:
        return
    name = match[1]
    if name not in _SETTINGS:
        if near := meant(name, _SETTINGS):
            raise FileError(f"{title}, line {number}: {shown(name)} is not a setting{near}")
        return
    if name in settings:
        raise FileError(f"{title}, line {number}: {name} must be given only once.")
    settings[name] = match[2].strip()


def _made(columns: list[_Column], settings: Mapping[str, str], rate: float | None) -> Data:
    names = [column.name for column in columns]
    if names and {*names} <= {"x", "v", "a"} and (rate is not None or "sampling_rate_hz" in settings):
        return _record(None, columns, settings, rate)
    if rate is not None:
        kind = "with a column of the time" if "time" in names else "of another kind"
        raise ValueError(f"rate must be left out of data {kind}: it is that of a record without one.")
    first = next((name for name in ("frequency", "time", "before") if name in names), None)
    if first is None:
        raise ValueError("it must have a column frequency_hz (moduli, a spectrum or a frequency response), time_s (a "
                         "record; or give its rate) or before_m/s (impacts), or the header quantity,value,error "
                         "(statistics).")  # fmt: skip
    for name, count in Counter(names).items():
        if count > 1 and name not in ("x", "v", "a"):
            raise ValueError(f"{name} must be one column, not {count}.")
    own = {column.name: column for column in columns}
    if first == "time":
        return _record(own["time"], [column for column in columns if column.name != "time"], settings)
    if first == "before":
        given = _given(own, settings, "impacts")
        if "after" not in own:
            raise ValueError("it must have a column after_m/s beside that of the speeds before.")
        return MeasuredImpacts(own["before"].values, own["after"].values, **given)
    if "density" in own:
        return _spectrum(own, settings)
    if {"magnitude", "phase", "real", "imaginary", "coherence"} & {*own}:
        return _response(own, settings)
    given = _given(own, settings, "moduli")
    moduli: dict[str, Any] = {name: own[name].values for name in ("storage", "loss") if name in own}
    if not moduli:
        raise ValueError("it must have a column storage_Pa, loss_Pa, density_m2/Hz or magnitude_m/N beside that of the "
                         "frequencies.")  # fmt: skip
    areal = {"Pa" in own[name].unit for name in moduli}
    if len(areal) > 1:
        raise ValueError("storage and loss must both be moduli in Pa, or both stiffnesses in N/m.")
    return MeasuredModuli(own["frequency"].values, **moduli, **given)


def _record(
    time: _Column | None, others: list[_Column], settings: Mapping[str, str], rate: float | None = None
) -> MeasuredRecord:
    given = _given((), settings, "a record")
    stated = checked_rate(given.pop("sampling_rate_hz", None))
    if stated is not None and (time is not None or rate is not None):
        other = "rate" if time is None else "the column of the time"
        raise ValueError(f"sampling_rate_hz must be left out beside {other}.")
    kinds = {column.name for column in others}
    if len(kinds) != 1 or not kinds <= _COLUMNS["a record"]:
        have = listed([*dict.fromkeys(column.header for column in others)]) if others else "nothing"
        raise ValueError(f"a record must have columns of one kind beside the time, such as x_m, not {have}.")
    of: Any = kinds.pop()
    values = np.array([column.values for column in others])
    times = np.arange(values.shape[1]) / (rate or stated or 1.0) if time is None else time.values
    return MeasuredRecord(times, values, of, **given)


def _spectrum(own: Mapping[str, _Column], settings: Mapping[str, str]) -> MeasuredSpectrum:
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


def _response(own: Mapping[str, _Column], settings: Mapping[str, str]) -> MeasuredFrequencyResponse:
    given = _given(own, settings, "a frequency response")
    pairs = [pair for pair in (("magnitude", "phase"), ("real", "imaginary")) if {*pair} & {*own}]
    if len(pairs) != 1 or not {*pairs[0]} <= {*own}:
        raise ValueError("a frequency response must have columns magnitude_m/N and phase_deg, or real_m/N and "
                         "imaginary_m/N.")  # fmt: skip
    first, second = (own[name] for name in pairs[0])
    if pairs[0] == ("real", "imaginary") and first.unit != second.unit:
        raise ValueError(f"real and imaginary must have the same unit, not {first.unit} and {second.unit}.")
    a, b = column(first.values, first.name), column(second.values, second.name)
    response = a * np.exp(1j * b) if pairs[0] == ("magnitude", "phase") else a + 1j * b
    if "coherence" in own:
        given["coherence"] = own["coherence"].values
    _, of, on = _RESPONSES[first.unit]
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
        if name in ("window", "at", "on", "of"):
            found[name] = text.strip("'\"")
            continue
        try:
            found[name] = int(text) if name == "segment" else float(text)
        except ValueError:
            raise ValueError(f"{name} must be a {'whole ' * (name == 'segment')}number, not {shown(text)}.") from None
    return found


def _header_of(columns: list[_Column], name: str) -> str:
    """The header of the column that a fault of the data names."""
    plain = {"frequency_hz": ("frequency",), "values": ("x",), "response": ("magnitude", "real")}.get(name, (name,))
    found = [column.header for column in columns if column.name in plain]
    moved = [column.header for column in columns if column.name in ("x", "v", "a")]
    return (found or moved or [name])[0]
