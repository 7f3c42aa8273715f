"""Statistics from a CSV file: a line for each, with its unit beside its name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import islice

from springpot.files.text import Row, number_of
from springpot.files.units import STANDARD_GRAVITY
from springpot.fitting.columns import PointFault
from springpot.fitting.statistics import MOST_STATISTICS, QUANTILE, MeasuredStatistics
from springpot.machine.faults import FileError, listed, meant, shown
from springpot.problem.catalogue import unit_of as unit_of_quantity

HEADER = ("quantity", "value", "error")

_LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
_UNITS: dict[str, dict[str, float]] = {
    "m": _LENGTH,
    "m2": {"m2": 1.0, "mm2": 1e-6, "um2": 1e-12},
    "m s-1": {"m/s": 1.0, "mm/s": 1e-3},
    "m2 s-2": {"m2/s2": 1.0, "mm2/s2": 1e-6},
    "s-1": {"1/s": 1.0, "1/min": 1.0 / 60.0, "1/h": 1.0 / 3600.0},
    "W": {"W": 1.0, "mW": 1e-3, "uW": 1e-6},
    "N": {"N": 1.0, "kN": 1e3},
    "N2": {"N2": 1.0, "kN2": 1e6},
    "m s-2": {"m/s2": 1.0, "g": STANDARD_GRAVITY},
    "m2 s-4": {"m2/s4": 1.0, "g2": STANDARD_GRAVITY**2},
    "V": {"V": 1.0, "mV": 1e-3},
    "V2": {"V2": 1.0},
    "1": {"1": 1.0},
}
"""Of results in the units of the catalogue."""
_ROOTS = {"m2": "m", "m2 s-2": "m s-1", "V2": "V", "N2": "N", "m2 s-4": "m s-2"}
_KNOWN = (
    "x_mean", "x_mean_square", "x_rms", "x_standard_deviation", "x_quantile_0.9", "v_mean_square", "v_rms",
    "amplitude_mean_square", "impact_rate", "impact_speed_mean", "impact_speed_mean_square",
    "impact_speed_quantile_0.9",
)  # fmt: skip
_QUANTITY = re.compile(r"([A-Za-z_][\w.]*)\s*[\[(]([^\])]+)[\])]")


def unit_of(name: str, unit: str) -> float:
    """The factor from a unit to that of a statistic in SI units.

    Raises
    ------
    ValueError
        If there is no such statistic, or it has no such unit.

    Examples
    --------
    >>> unit_of("x_rms", "mm"), unit_of("stop_impact_rate", "1/min") * 60.0
    (0.001, 1.0)
    """
    units = _UNITS.get(_unit_in_si(name))
    if units is None:
        raise ValueError(f"{shown(name)} is not a statistic: a name is {listed([*_KNOWN], 'or')}, or that of another "
                         f"result of a run{meant(name, _KNOWN) or '.'}")  # fmt: skip
    if unit not in units:
        raise ValueError(f"the unit of {name} must be {listed([*units], 'or')}, not {shown(unit)}.")
    return units[unit]


def _unit_in_si(name: str) -> str:
    """Of a statistic, in the words of the catalogue; empty if there is none."""
    if name.endswith("_rms"):
        return _ROOTS.get(unit_of_quantity(f"{name.removesuffix('_rms')}_mean_square", heavy=True), "")
    if name.endswith("_standard_deviation"):
        return unit_of_quantity(f"{name.removesuffix('_standard_deviation')}_mean", heavy=True)
    quantile = QUANTILE.fullmatch(name)
    return unit_of_quantity(f"{quantile[1]}_quantile" if quantile else name, heavy=True)


def statistics_in(rows: Iterable[Row], title: str, decimal: str = ".") -> MeasuredStatistics:
    """Statistics from the rows below the header.

    Raises
    ------
    FileError
        One sentence with the line.

    Examples
    --------
    >>> statistics_in([(2, ["x_rms (mm)", "2.5", "0.1"])], "data file 'a.csv'").values.tolist()
    [0.0025]
    """
    found: dict[str, tuple[float, float]] = {}
    lines: list[int] = []
    for line, row in islice(rows, MOST_STATISTICS + 1):
        lines.append(line)
        where = f"{title}, line {line}"
        if len(row) == len(HEADER) + 1 and not row[-1].strip():
            del row[-1]
        if len(row) != len(HEADER):
            raise FileError(f"{where}: a quantity, its value and its error are needed, not {len(row)} cells.")
        match = _QUANTITY.fullmatch(row[0].strip())
        if match is None:
            raise FileError(f"{where}: {shown(row[0].strip())} must be a quantity with its unit, as x_rms (mm).")
        try:
            factor = unit_of(match[1], match[2].strip())
        except ValueError as fault:
            raise FileError(f"{where}: {fault}") from None
        if match[1] in found:
            raise FileError(f"{where}: {match[1]} must be given only once.")
        found[match[1]] = (
            _number(row[1], "value", where, decimal) * factor,
            _number(row[2], "error", where, decimal) * factor,
        )
    try:
        return MeasuredStatistics.of(found)
    except PointFault as fault:
        raise FileError(f"{title}, line {lines[fault.place]}: {fault}") from None
    except ValueError as fault:
        raise FileError(f"{title} is not right: {fault}") from None


def _number(cell: str, name: str, where: str, decimal: str) -> float:
    try:
        return number_of(cell, decimal)
    except ValueError:
        text = cell.strip()
        what = f"must be a number, not {shown(text)}" if text else "is missing"
        raise FileError(f"{where}: the {name} {what}.") from None
