"""The excitation as the page draws it: one-sided spectral densities and envelopes, and tables of densities taken in."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from springpot.explorer.sliders import titled
from springpot.files.table import Stated
from springpot.machine.plain import plain
from springpot.problem.parts import (
    CloughPenzienNoise,
    ColoredNoise,
    KanaiTajimiNoise,
    RecordedExcitation,
    SpectralExcitation,
    WhiteNoise,
)
from springpot.problem.parts.excitations import densities_in
from springpot.problem.spectral_density import STANDARD_GRAVITY
from springpot.problem.system import System

POINTS, POINTS_OF_TABLE = 241, 41
WIDE = 30.0  # of the natural frequency, on both sides: what is drawn of a density that has no ends
FEWER = 3  # digits, by which a table must be shorter in g²/Hz to have been stated so
DECADES = 1e-6  # of the largest density: what is drawn
_REPLACED = SpectralExcitation, WhiteNoise, ColoredNoise, KanaiTajimiNoise, CloughPenzienNoise
"""What a table may take the place of, the first there is."""


def chart(
    title: str, x: tuple[str, str], y: tuple[str, str], at: Any, lines: Sequence[dict[str, Any]] = (), **more: Any
) -> dict[str, Any]:
    """A chart for the page: words and unit of its axes, and values of its lines at the same places.

    Examples
    --------
    >>> chart("e(t)", ("t", "s"), ("e", ""), [0.0, 1.0], [{"name": "e", "values": [0.0, math.nan]}])["lines"]
    [{'name': 'e', 'values': [0.0, None]}]
    """
    return {"title": title, "x": x, "y": y, **plain({"at": at, "lines": lines, **more})}


def charts_of_excitation(system: System, frequency: float) -> Iterator[dict[str, Any]]:
    """The one-sided density of each noise that is not white, envelopes, and records.

    Parameters
    ----------
    system : System
    frequency : float
        Of the motion, in rad/s, which is marked.

    Examples
    --------
    >>> band = SpectralExcitation.from_psd((10.0, 2000.0), 0.02, "g2/Hz")
    >>> from springpot.problem.parts import Spring
    >>> [(one["title"], one["note"]) for one in charts_of_excitation(System(Spring(4e4), band), 200.0)]
    [('spectral excitation', 'Overall rms 61.87 m/s² (6.309 g). Dashed: the frequency of the motion.')]
    """
    natural = frequency / (2.0 * math.pi)
    for name, part in system.excitations.items():
        if part.noise in ("filtered", "impulses"):
            yield _density(system, name, part, natural)
        if name in system.records:
            yield _record(system, name, system.records[name])
        if envelope := getattr(part, "envelope", None):
            time = np.linspace(0.0, envelope.duration, POINTS)
            line = {"name": "envelope", "values": envelope.at(time)}
            yield chart(f"{titled(name)}: envelope", ("t", "s"), ("e", ""), time, [line])


def _record(system: System, name: str, part: RecordedExcitation) -> dict[str, Any]:
    """The first record: of a long one the smallest and the largest value of each piece."""
    time, values = (np.array(own) for own in part.records[0])
    pieces = np.array_split(np.arange(time.size), min(POINTS, time.size))
    kept = np.unique([piece[find(values[piece])] for piece in pieces for find in (np.argmin, np.argmax)])
    y = ("F", "N") if system.has_mass and not part.of_ground else ("a", "m/s²")
    line = {"name": "record", "values": part.scale * values[kept]}
    note = f"The first of {part.count} records." if part.count > 1 else ""
    return chart(titled(name), ("t", "s"), y, time[kept] - time[0], [line], note=note)


def _density(system: System, name: str, part: Any, natural: float) -> dict[str, Any]:
    force = system.has_mass and not part.of_ground
    unit, note = "N²/Hz" if force else "(m/s²)²/Hz", "Dashed: the frequency of the motion."
    low, high = natural / WIDE, natural * WIDE
    places: Any = ()
    if name in system.densities:
        low, high, places = part.frequency[0], part.frequency[-1], part.frequency
        rms = f"{part.rms:.4g} N" if force else f"{part.rms:.4g} m/s² ({part.rms / STANDARD_GRAVITY:.4g} g)"
        note = f"Overall rms {rms}. {note}"
    f = np.unique([*np.geomspace(low, high, POINTS)[1:-1], low, high, *places])
    density = np.array([4.0 * math.pi * part.density(2.0 * math.pi * one) for one in f])
    density[density < DECADES * density.max()] = math.nan
    line = {"name": "one-sided density", "values": density}
    return chart(titled(name), ("f", "Hz"), ("G", unit), f, [line], logarithmic=True, note=note, mark=natural)


def _replaced(system: System) -> str:
    """The name of the excitation that a table takes the place of; empty if there is none."""
    return next((name for kind in _REPLACED for name, part in system.stated() if type(part) is kind), "")


def table_of(system: System, frequency: float) -> str:
    """The table of densities of a system as CSV; of other noise in a band about a frequency in rad/s; empty without.

    It is in g²/Hz where this takes fewer digits, since the densities were stated so then.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> print(table_of(System(Spring(4e4), SpectralExcitation((10.0, 2000.0), (2.0, 1.0))), 200.0))
    frequency_Hz,psd_m2/s4/Hz
    10,2
    2000,1
    >>> print(table_of(System(Spring(4e4), SpectralExcitation.from_psd((10.0, 2000.0), (0.04, 0.01), "g2/Hz")), 200.0))
    frequency_Hz,psd_g2/Hz
    10,0.04
    2000,0.01
    """
    if not (name := _replaced(system)):
        return ""
    part: Any = dict(system.stated())[name]
    if name in system.densities:
        points = [(f, part.scale * value) for f, value in zip(part.frequency, part.psd, strict=True)]
    else:
        middle, count = frequency / (2.0 * math.pi), 2 if part.noise == "white" else POINTS_OF_TABLE
        band = [float(f"{f:.4g}") for f in np.geomspace(middle / WIDE, middle * WIDE, count)]
        points = [(f, 4.0 * math.pi * part.density(2.0 * math.pi * f)) for f in band]
    unit, of_one = "N2/Hz" if system.has_mass and not part.of_ground else "m2/s4/Hz", 1.0
    if unit != "N2/Hz" and _digits(points, STANDARD_GRAVITY**2) <= _digits(points) - FEWER:
        unit, of_one = "g2/Hz", STANDARD_GRAVITY**2
    return "\n".join([f"frequency_Hz,psd_{unit}", *(f"{f:.6g},{value / of_one:.6g}" for f, value in points)])


def _digits(points: Sequence[tuple[float, float]], of_one: float = 1.0) -> int:
    """How many digits the longest density has in a unit of so many (m/s²)²/Hz."""
    return max(len(f"{value / of_one:.9e}".split("e")[0].rstrip("0")) for _, value in points)


def with_table(system: System, content: bytes, title: str = "the table", unit: str = "") -> tuple[System, list[str]]:
    """The same system with another table of densities, in the place of its own or of another noise; what was assumed.

    Parameters
    ----------
    system : System
    content : bytes
        Of a file of densities, of any kind that is read.
    title : str
        Names it in what is said of its faults.
    unit : str
        Of the densities, where the file does not say it.

    Raises
    ------
    ValueError
        One sentence that says what is wrong in the table, or that there is nothing that it can replace.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> given = b"frequency_Hz,psd_g2/Hz\\n10,0.02\\n2000,0.02"
    >>> with_table(System(Spring(4e4), shake=WhiteNoise(1.0, on="ground")), given)[0].parts[1].frequency
    (10.0, 2000.0)
    """
    if not (name := _replaced(system)):
        raise ValueError(
            "table: this system has neither a table of densities nor another noise, which it could replace."
        )
    old: Any = dict(system.stated())[name]
    frequency, psd, of_force, notes = densities_in(content, title, Stated(unit=unit))
    on = old.on if of_force and not old.of_ground else ""
    made = SpectralExcitation.from_psd(
        frequency, psd, "N2/Hz" if of_force else "m2/s4/Hz", on=on, envelope=getattr(old, "envelope", None)
    )
    return system.but(**{name: made}), notes
