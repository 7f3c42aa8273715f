"""Reliability of a method for a system: its gaps to Monte Carlo at the nearest cells of a validity map.

There are two maps, written by :mod:`springpot.evidence.validity`: ``validity.csv`` of the paper's problem, over order,
c, restitution and wall position, and ``validity_systems.csv`` of systems, over the numbers of
`springpot.evidence.cells.Cell`. Both have stationary Monte Carlo and the gap of every method to it.  Between cells the
gap is taken halfway from what is interpolated to the largest of the neighbours: those alone are mostly three times too
large.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from springpot.evidence.cells import cell_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, known_word, listed
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system
from springpot.theory.registry import METHODS
from springpot.theory.result import MOMENTS, Result

_WORDS = {
    "amplitude_mean_square": "<A^2>",
    "x_mean": "<x>",
    "x_mean_square": "<x^2>",
    "v_mean_square": "<v^2>",
    "impact_rate": "impact rate",
    "impact_speed_mean": "mean impact speed",
    "impact_speed_mean_square": "mean square impact speed",
    "rarest_impact_rate": "impact rate of the wall that is struck least",
}

_FARTHEST = 4.3  # of the map's walls, in the unit of their place


@dataclass(frozen=True)
class Map:
    """One of the two maps.

    Parameters
    ----------
    file : Path
    axes : tuple of (name, slack)
        Its coordinates in the order in which neighbours are looked for, each with the distance beyond the last cell up
        to which that cell still counts as near.
    methods : tuple of str
        Those whose gaps are on it.
    moments : tuple of str
        Those of the Monte Carlo on it.
    good : dict
        Moments with gaps, and the gaps in per cent up to which no warning is given.
    judged : tuple of str
        Moments by which methods are ranked.
    """

    file: Path
    axes: tuple[tuple[str, float], ...]
    methods: tuple[str, ...]
    moments: tuple[str, ...]
    good: Mapping[str, float]
    judged: tuple[str, ...]


PAPER_MAP = Map(
    file=Path(__file__).with_name("validity.csv"),
    axes=(("position", 0.25), ("restitution", 0.15), ("order", 0.1), ("c", 0.3)),
    methods=("averaging", "averaging_amplitude", "envelope", "memory_closure"),
    moments=MOMENTS,
    good=dict.fromkeys(MOMENTS, 4.0) | {"amplitude_mean_square": 2.0},
    judged=("amplitude_mean_square", "x_mean", "impact_rate"),
)
"""Of the paper's problem."""
SYSTEMS_MAP = Map(
    file=Path(__file__).with_name("validity_systems.csv"),
    axes=(
        ("walls", 0.0), ("color", 0.2), ("position", 0.25), ("apart", 3.0), ("restitution", 0.05),
        ("hardening", 0.1), ("order", 0.1), ("c", 0.1),
    ),
    methods=("averaging_amplitude", "linearization", "envelope", "half_cycles", "path_integration"),
    moments=(*MOMENTS, "rarest_impact_rate"),  # the last is of the wall that is struck least often
    good=dict.fromkeys(("x_mean", "x_mean_square", "v_mean_square"), 3.0)
    | dict.fromkeys(("impact_rate", "impact_speed_mean", "impact_speed_mean_square"), 5.0)
    | {"rarest_impact_rate": 10.0},
    judged=("x_mean_square", "v_mean_square", "impact_rate", "rarest_impact_rate"),
)  # fmt: skip
"""Of systems."""


@dataclass(frozen=True)
class Trust:
    """Errors of one method near a system, from its map.

    Attributes
    ----------
    gaps : dict
        Gap in per cent, without sign, of each moment of the map: halfway from what is interpolated between the cells on
        either side to the largest of them.  It is infinite if the method has no result or the map has no cell near, and
        NaN if the map's Monte Carlo is too uncertain at all of them.
    mapped : bool
        Whether the map has a cell near.
    limits : dict
        Of the moments by which methods are ranked: the gaps in per cent up to which no warning is given.
    unjudged : tuple of str
        Moments for which Monte Carlo is too uncertain, or there is no result, at one of these cells at least.
    warnings : tuple of str
        One sentence if the method has large errors near here, or no cell of the map is near; otherwise none.
    """

    gaps: Mapping[str, float]
    mapped: bool
    limits: Mapping[str, float]
    unjudged: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def judges(self) -> bool:
        """Whether the map has a finite gap of one moment at least, among those by which methods are ranked."""
        return self.mapped and any(math.isfinite(self.gaps[name]) for name in self.limits)

    @property
    def largest(self) -> float:
        """The largest known gap in per cent, of the moments by which methods are ranked."""
        return max((gap for name in self.limits if not math.isnan(gap := self.gaps[name])), default=math.inf)

    @property
    def worst(self) -> float:
        """The largest known gap over its limit, of the moments by which methods are ranked."""
        known = (self.gaps[name] / good for name, good in self.limits.items() if not math.isnan(self.gaps[name]))
        return max(known, default=0.0)


@cache
def read_map(path: Path = PAPER_MAP.file) -> dict[str, Floats]:
    """The columns of the map: coordinates of the cells, Monte Carlo, and gaps in per cent under ``method:moment``.

    A gap is infinite if the method has no result and NaN if Monte Carlo is too uncertain.
    """
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def trust(system: System, method: str) -> Trust:
    """Errors of a method for this system, from the map.

    Parameters
    ----------
    system : System
    method : str
        One of `springpot.theory.registry.METHODS`.

    Returns
    -------
    Trust

    Raises
    ------
    TypeError
        If ``system`` is not a System.
    ValueError
        If ``method`` is another word.

    Examples
    --------
    >>> import springpot as sp
    >>> trust(sp.Oscillator(), "averaging").mapped
    True
    """
    atlas, here, applies = place_of(checked_system(system))
    method = "averaging" if known_word(method, METHODS, "method") == "averaging_printed" else method
    limits = {name: atlas.good[name] for name in atlas.judged if here is None or exists(name, here)}
    known = method in atlas.methods
    columns = read_map(atlas.file)
    weights = np.zeros(0) if here is None or not known else _near(atlas, columns, here)
    if here is None or not (near := weights > 0.0).any():
        far = (FAR,) if known and applies else ()
        return Trust(dict.fromkeys(atlas.good, math.inf), mapped=False, limits=limits, warnings=far)
    names = [name for name in atlas.good if exists(name, here)]
    gaps = {name: np.abs(columns[f"{method}:{name}"][near]) for name in names}
    unjudged = tuple(name for name in names if not np.isfinite(gaps[name]).all())
    expected = {name: _expected(gaps[name], weights[near]) for name in names}
    warnings = tuple(_sentences(atlas, expected, unjudged)) if applies else ()
    return Trust(expected, mapped=True, unjudged=unjudged, limits=limits, warnings=warnings)


FAR = "The validity map has no cell near these numbers: compare with Monte Carlo before you trust them."


def _sentences(atlas: Map, gaps: Mapping[str, float], unjudged: tuple[str, ...]) -> Iterator[str]:
    off = [f"{_WORDS[name]} {gap:.1f} %" for name, gap in gaps.items() if atlas.good[name] < gap < math.inf]
    sentences = [f"Near here the validity map has gaps to Monte Carlo of up to: {', '.join(off)}."] if off else []
    if unjudged and any(gap < math.inf for gap in gaps.values()):
        unknown = listed([_WORDS[name] for name in unjudged])
        why = "Monte Carlo is too uncertain or the method has no result"
        sentences.append(f"At a cell near here the validity map cannot judge {unknown}: {why}.")
    if sentences:
        yield " ".join(sentences)


def place_of(system: System) -> tuple[Map, dict[str, float] | None, bool]:
    """The map that a system belongs to, its coordinates there (None: it has none), and whether the map applies.

    That of the paper's problem does not apply without a wall or without a springpot.
    """
    try:
        paper = Dimensionless.of(system)
    except NotCoveredError:
        return SYSTEMS_MAP, _place_of_system(system), True
    c, order = paper.dimensionless_coefficient, paper.springpot.order
    applies = paper.barrier is not None and c > 0.0
    if not applies or not math.isfinite(paper.dimensionless_position) or order == 0.0:  # a spring: small orders differ
        return PAPER_MAP, None, applies
    lightest = float(read_map()["c"].min())  # below it every method is better than on the map
    place = paper.dimensionless_position, paper.restitution, order, max(c, lightest)
    return PAPER_MAP, dict(zip(("position", "restitution", "order", "c"), place, strict=True)), True


def _place_of_system(system: System) -> dict[str, float] | None:
    try:
        cell = cell_of(system)
    except NotCoveredError:
        return None
    lightest = float(read_map(SYSTEMS_MAP.file)["c"].min())  # below it the envelope is better than on the map
    return {name: float(value) for name, value in cell._replace(c=max(cell.c, lightest))._asdict().items()}


def _near(atlas: Map, columns: Mapping[str, Floats], here: Mapping[str, float]) -> Floats:
    """Weights of the cells beside a place, on either side along every axis; 0 of the others.

    All are 0 if the place is outside along an axis.
    """
    size = columns["c"].size
    corners = [(np.ones(size, bool), 1.0)]
    for name, slack in atlas.axes:
        column = columns[name]
        shared = set.intersection(*(set(column[corner].tolist()) for corner, _ in corners))
        beside = _beside(np.array(sorted(shared)), here[name], slack)
        corners = [(corner & (column == value), w * part) for corner, w in corners for value, part in beside]
        if not corners:
            return np.zeros(size)
    return np.asarray(np.sum([weight * corner for corner, weight in corners], axis=0))


def exists(name: str, here: Mapping[str, float]) -> bool:
    """Whether a moment exists at a place of a map, and is not 0.

    Examples
    --------
    >>> exists("impact_rate", {"walls": 2.0, "restitution": 0.8, "color": 1.0})
    False
    """
    walls = here.get("walls", 1.0)
    if name == "x_mean":
        return walls == 1.0
    countable = here["restitution"] == 1.0 or here.get("color", 0.0) == 0.0
    if name == "rarest_impact_rate":  # of two walls, where Monte Carlo sees the other one struck
        return walls == 2.0 and countable and here["position"] + here["apart"] <= _FARTHEST
    return not name.startswith("impact") or (walls > 0.0 and countable)


def _beside(values: Floats, here: float, slack: float) -> tuple[tuple[float, float], ...]:
    """The values of the map beside a number, with weights; empty if it is outside by more than ``slack``.

    Between two values the weights are those of a straight line, but at least a small part.
    """
    within = 1e-9 * max(1.0, abs(here))
    below, above = values[values <= here + within], values[values >= here - within]
    if not (below.size and above.size):
        nearest = [float(side) for side in (*below[-1:], *above[:1]) if abs(side - here) <= slack]
        return tuple((value, 1.0) for value in nearest)
    low, high = float(below[-1]), float(above[0])
    if high <= low:
        return ((low, 1.0),)
    part = min(max((here - low) / (high - low), 1e-6), 1.0 - 1e-6)
    return (low, 1.0 - part), (high, part)


def _expected(gaps: Floats, weights: Floats) -> float:
    """Halfway from the interpolated to the largest of the finite gaps.

    Without one infinite if there is no result at some cell, NaN if Monte Carlo is too uncertain at all.
    """
    known = np.isfinite(gaps)
    if not known.any():
        return math.inf if np.isinf(gaps).any() else math.nan
    return float(0.5 * (np.average(gaps[known], weights=weights[known]) + gaps[known].max()))


def moment_of(result: Result, name: str) -> float:
    """One of the moments of `SYSTEMS_MAP` of a result."""
    if name != "rarest_impact_rate":
        return result.moments[name]
    rates = [value for of, value in result.moments.of_parts.items() if of.endswith("_impact_rate")]
    return min(rates, default=math.nan)


def warnings_of(result: Result) -> tuple[str, ...]:
    """The warnings of a result, and what the validity map says of its method near its system.

    Examples
    --------
    >>> import springpot as sp
    >>> warnings_of(sp.theory.averaging(sp.Oscillator()))[0][:60]
    'Near here the validity map has gaps to Monte Carlo of up to:'
    """
    if result.is_exact or isinstance(result.stationary, str):
        return result.warnings
    return (*result.warnings, *trust(result.system, result.method).warnings)
