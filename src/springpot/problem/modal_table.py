"""A modal model from a table: frequency, generalised mass, damping ratio, and the shape at each point."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from springpot.files.reading import contents
from springpot.files.table import Stated, Table
from springpot.files.text import numbers_of
from springpot.files.units import FREQUENCY_UNITS, Decimal
from springpot.machine.arguments import checked_path
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, listed, shown
from springpot.problem.messages import warn_of_file
from springpot.problem.modes import parts_of_modes
from springpot.problem.system import System

_UNITS = {
    "frequency": FREQUENCY_UNITS,
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3},
    "damping ratio": {"": 1.0, "1": 1.0, "-": 1.0, "%": 0.01},
    "participation": {"": 1.0, "1": 1.0, "-": 1.0},
    "mode": {"": 1.0},
}
"""The columns that are no shapes, and their units."""
_NAMES = {
    "freq": "frequency", "generalised mass": "mass", "generalized mass": "mass", "modal mass": "mass",
    "damping": "damping ratio", "participation factor": "participation", "no": "mode", "number": "mode",
}  # fmt: skip
_HEADER = re.compile(r"(.*?)[\s_]*(?:[(\[]([^)\]]*)[)\]]|_(hz|khz|rad/s|kg|g|t|%))?", re.IGNORECASE)


def read_modes(
    path: str | Path, *, columns: Sequence[str] | Mapping[str, str] | None = None, decimal: Decimal = ""
) -> System:
    """A structure by its modes, from a table in text with a row for each.

    Parameters
    ----------
    path : str or Path
        The header has ``frequency_hz`` (or ``_rad/s``), ``mass_kg``, the generalised mass of the shapes in the table,
        perhaps ``damping_ratio`` (or ``damping_%``) and ``participation``, and the name of each point, below which are
        its shapes.  Other separators and spellings are those of `RecordedExcitation.from_file`.
    columns : sequence of str or mapping, optional
        A header for each column of a file without one, empty for one that is left out; or headers by the names in the
        file, of the columns that are wanted.
    decimal : {".", ","}, optional
        The decimal mark, where it cannot be told.

    Returns
    -------
    System
        As `System.from_modes` has it.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    TypeError, ValueError
        One sentence that says what is wrong in it, and what to do.

    Warns
    -----
    FileWarning
        With what was assumed, in one line.
    StationarityWarning
        If a frequency is 0.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "modes.csv"
    >>> _ = place.write_text("frequency_hz,mass_kg,damping_%,tip,middle\\n6.0,2.0,1,1,0.4\\n40,1.5,1,-1,0.7\\n")
    >>> read_modes(place).points
    ('mode_1', 'mode_2', 'tip', 'middle')
    """
    place, title = checked_path(path, "path"), f"file of modes {str(path)!r}"
    stated = Stated(columns=columns, decimal=decimal)
    with contents(place, title, stated) as sheet:
        if isinstance(sheet, Table):
            raise FileError(f"{title} must be a table in text, with a row for each mode: save it as CSV.")
        where = f"{title}, line {sheet.line}"
        if isinstance(stated.columns, dict):
            if unknown := [name for name in stated.columns if sheet.names.count(name) != 1]:
                names = listed([*map(shown, sheet.names)])
                raise FileError(f"{where}: columns has {shown(unknown[0])}, and one such column is needed, of {names}.")
            headers = [stated.columns.get(name, "") for name in sheet.names]
        else:
            headers = [*(stated.columns or sheet.names)]
        if len(headers) != len(sheet.names):
            raise FileError(f"{where}: columns must have a header for each of the {len(sheet.names)} columns.")
        taken = [place for place, header in enumerate(headers) if header.strip()]
        numbers, lines = numbers_of(sheet.rows, sheet.names, taken, title, sheet.decimal)
    if not len(lines):
        raise FileError(f"{title} has no numbers below its header.")
    known, shapes = dict[str, Floats](), dict[str, Floats]()
    for header, values in zip((headers[place].strip() for place in taken), numbers.T, strict=True):
        match = _HEADER.fullmatch(header)
        name, unit = (match[1], match[2] or match[3] or "") if match else (header, "")
        name = " ".join(name.lower().replace("_", " ").split())
        if (kind := _NAMES.get(name, name)) not in _UNITS:
            if header in shapes:
                raise FileError(f"{where}: {header} has two columns, and one is needed.")
            shapes[header] = values
            continue
        units = {each.lower(): size for each, size in _UNITS[kind].items()}
        if unit.lower() not in units:
            known_units = listed([each for each in _UNITS[kind] if each not in ("", "hz")], "or")
            raise FileError(f"{where}: the unit of {kind} must be {known_units}, not {shown(unit)}.")
        if kind in known:
            raise FileError(f"{where}: {kind} has two columns, and one is needed.")
        known[kind] = values * units[unit.lower()]
    for kind, such in (("frequency", "frequency_hz"), ("mass", "mass_kg, 1 where shapes have unit modal mass")):
        if kind not in known:
            raise FileError(f"{where}: a column of the {kind} is needed, {such}.")
    if not shapes:
        raise FileError(f"{where}: a column with the shapes of each point is needed, whose header is its name.")
    warn_of_file(title, sheet.notes)
    try:
        given = known["frequency"], known["mass"], shapes
        return System(*parts_of_modes(*given, known.get("damping ratio", 0.0), known.get("participation", 0.0), "Hz"))
    except (TypeError, ValueError) as fault:
        raise FileError(f"{title}: {fault}") from None
