"""Reliability of a method for a problem: its gaps to Monte Carlo at the nearest cells of a validity map.

There are two maps, written by :mod:`springpot.evidence.validity`: ``validity.csv`` of oscillators, over order, c,
restitution and wall position, and ``validity_systems.csv`` of systems, over the numbers of
`springpot.theory.cells.Cell`. Both have stationary Monte Carlo and the gap of every method to it.  Between cells the
gap is taken halfway from what is interpolated to the largest of the neighbours: those alone are mostly three times too
large.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.faults import NotCoveredError, listed, shown
from springpot.problem.oscillator import Oscillator
from springpot.problem.system import System
from springpot.theory.cells import cell_of
from springpot.theory.problem import checked
from springpot.theory.registry import MAPPED, METHODS, SYSTEM_MAPPED, SYSTEM_METHODS
from springpot.theory.result import MOMENTS

__all__ = [
    "GOOD",
    "JUDGED",
    "MAP_FILE",
    "SYSTEMS_FILE",
    "SYSTEMS_GOOD",
    "Trust",
    "best_guess",
    "exists",
    "map_warnings",
    "mapped_methods",
    "read_map",
    "recommended",
    "trust",
    "why_none_is_recommended",
]

MAP_FILE = Path(__file__).with_name("validity.csv")
SYSTEMS_FILE = Path(__file__).with_name("validity_systems.csv")
JUDGED = ("amplitude_mean_square", "x_mean", "impact_rate")
"""Moments by which methods are ranked, for an oscillator."""
SYSTEMS_JUDGED = ("x_mean_square", "v_mean_square", "impact_rate", "rarest_impact_rate")
"""The same for a system."""
GOOD = dict.fromkeys(MOMENTS, 4.0) | {"amplitude_mean_square": 2.0}
"""Moments whose gaps are on the map of oscillators, and the gaps in per cent up to which no warning is given."""
SYSTEMS_GOOD = {
    "x_mean": 3.0, "x_mean_square": 3.0, "v_mean_square": 3.0,
    "impact_rate": 5.0, "impact_speed_mean": 5.0, "impact_speed_mean_square": 5.0, "rarest_impact_rate": 10.0,
}  # fmt: skip
"""The same of the map of systems."""

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

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class _Map:
    """One of the two maps.

    Parameters
    ----------
    file : Path
    axes : tuple of (name, slack)
        Its coordinates in the order in which neighbours are looked for, each with the distance beyond the last cell up
        to which that cell still counts as near.
    methods : tuple of str
    good : dict
        Moments, and the gaps in per cent up to which no warning is given.
    judged : tuple of str
        Moments by which methods are ranked.
    guesses : tuple of str
        Methods by how likely they are to be accurate away from the map.
    """

    file: Path
    axes: tuple[tuple[str, float], ...]
    methods: tuple[str, ...]
    good: Mapping[str, float]
    judged: tuple[str, ...]
    guesses: tuple[str, ...]


_OSCILLATORS = _Map(
    file=MAP_FILE,
    axes=(("position", 0.25), ("restitution", 0.15), ("order", 0.1), ("c", 0.3)),
    methods=MAPPED,
    good=GOOD,
    judged=JUDGED,
    guesses=("closure", "envelope", "averaging"),
)
_SYSTEMS = _Map(
    file=SYSTEMS_FILE,
    axes=(
        ("walls", 0.0), ("color", 0.2), ("position", 0.25), ("apart", 3.0), ("restitution", 0.05),
        ("hardening", 0.1), ("order", 0.1), ("c", 0.1),
    ),
    methods=SYSTEM_MAPPED,
    good=SYSTEMS_GOOD,
    judged=SYSTEMS_JUDGED,
    guesses=("path_integration", "half_cycles", "envelope", "linearization", "averaging_amplitude"),
)  # fmt: skip


@dataclass(frozen=True)
class Trust:
    """Errors of one method near an oscillator or system, from the map.

    Attributes
    ----------
    gaps : dict
        Gap in per cent, without sign, of each moment of the map: halfway from what is interpolated between the cells on
        either side to the largest of them; infinite if the method has no result or the map has no cell near, NaN if the
        map's Monte Carlo is too uncertain at all of them.
    unjudged : tuple of str
        Moments for which it is too uncertain, or there is no result, at one of these cells at least.
    mapped : bool
        Whether the map has a cell near.
    limits : dict
        Of the moments by which methods are ranked: the gaps in per cent up to which no warning is given.
    """

    gaps: Mapping[str, float]
    mapped: bool
    unjudged: tuple[str, ...] = ()
    limits: Mapping[str, float] = field(default_factory=lambda: {name: GOOD[name] for name in JUDGED})

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
def read_map(path: Path = MAP_FILE) -> dict[str, Floats]:
    """The columns of the map: coordinates of the cells, Monte Carlo, and gaps in per cent under ``method:moment``.

    A gap is infinite if the method has no result and NaN if Monte Carlo is too uncertain.
    """
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def trust(problem: Oscillator | System, method: str) -> Trust:
    """Errors of a method for this oscillator or system, from the map.

    Parameters
    ----------
    problem : Oscillator or System
        An oscillator with a wall, or a system; one that is an `Oscillator` is taken as such.
    method : str
        One of `springpot.theory.registry.MAPPED`; of a system that is none, of ``SYSTEM_MAPPED``.

    Returns
    -------
    Trust

    Raises
    ------
    TypeError
        If ``problem`` is neither.
    ValueError
        If ``method`` is another word.

    Examples
    --------
    >>> trust(Oscillator(), "averaging").mapped
    True
    """
    atlas, here = _place(problem)
    if method not in atlas.methods:
        raise ValueError(f"method must be one of {', '.join(atlas.methods)}, not {shown(method)}.")
    unknown = Trust(dict.fromkeys(atlas.good, math.inf), mapped=False, limits=_limits(atlas, here))
    if here is None:
        return unknown
    columns = read_map(atlas.file)
    weights = _near(atlas, columns, here)
    near = weights > 0.0
    if not near.any():
        return unknown
    names = [name for name in atlas.good if exists(name, here)]
    gaps = {name: np.abs(columns[f"{method}:{name}"][near]) for name in names}
    unjudged = tuple(name for name in names if not np.isfinite(gaps[name]).all())
    expected = {name: _expected(gaps[name], weights[near]) for name in names}
    return Trust(expected, mapped=True, unjudged=unjudged, limits=_limits(atlas, here))


def mapped_methods(problem: Oscillator | System) -> tuple[str, ...]:
    """The methods that are on the validity map to which a problem belongs."""
    return _place(problem)[0].methods


def _place(problem: Oscillator | System) -> tuple[_Map, dict[str, float] | None]:
    """The map that a problem belongs to, and its coordinates there; None if the map has none."""
    if isinstance(problem, System):
        found = _canonical(problem)
        if found is None:
            return _SYSTEMS, _place_of_system(problem)
        problem = found
    c, order = checked(problem).dimensionless_coefficient, problem.springpot.order
    known = problem.barrier is not None and c > 0.0 and math.isfinite(problem.dimensionless_position)
    if not known or order == 0.0:  # a spring, to which small orders do not apply
        return _OSCILLATORS, None
    lightest = float(read_map()["c"].min())  # below it every method is better than on the map
    place = problem.dimensionless_position, problem.restitution, order, max(c, lightest)
    return _OSCILLATORS, dict(zip(("position", "restitution", "order", "c"), place, strict=True))


def _place_of_system(system: System) -> dict[str, float] | None:
    try:
        cell = cell_of(system)
    except NotCoveredError:
        return None
    lightest = float(read_map(SYSTEMS_FILE)["c"].min())  # below it the envelope is better than on the map
    return {name: float(value) for name, value in cell._replace(c=max(cell.c, lightest))._asdict().items()}


def _canonical(system: System) -> Oscillator | None:
    try:
        return system.canonical()
    except NotCoveredError:
        return None


def _near(atlas: _Map, columns: Mapping[str, Floats], here: Mapping[str, float]) -> Floats:
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


def _limits(atlas: _Map, here: Mapping[str, float] | None) -> dict[str, float]:
    return {name: atlas.good[name] for name in atlas.judged if here is None or exists(name, here)}


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


def map_warnings(problem: Oscillator | System, method: str) -> tuple[str, ...]:
    """One sentence if a method has large errors near here, or no cell of the map is near; otherwise none.

    The map of oscillators does not apply without a wall or without a springpot.
    """
    atlas, _ = _place(problem)
    if isinstance(problem, Oscillator) and (problem.barrier is None or not problem.dimensionless_coefficient > 0.0):
        return ()
    if method not in atlas.methods:  # of a system that is an oscillator
        return ()
    here = trust(problem, method)
    if not here.mapped:
        return ("The validity map has no cell near these numbers: compare with Monte Carlo before you trust them.",)
    off = [f"{_WORDS[name]} {gap:.1f} %" for name, gap in here.gaps.items() if atlas.good[name] < gap < math.inf]
    sentences = [f"Near here the validity map has gaps to Monte Carlo of up to: {', '.join(off)}."] if off else []
    if here.unjudged and any(gap < math.inf for gap in here.gaps.values()):
        unknown = listed([_WORDS[name] for name in here.unjudged])
        why = "Monte Carlo is too uncertain or the method has no result"
        sentences.append(f"At a cell near here the validity map cannot judge {unknown}: {why}.")
    return (" ".join(sentences),) if sentences else ()


def recommended(problem: Oscillator | System, answers: Mapping[str, Any]) -> str:
    """The most reliable method here, among those that have a result.

    Exact methods first; then the method with the smallest of the largest gaps on the map.  If the map has no cell near,
    or its Monte Carlo is too uncertain, the errors are unknown and none is recommended: `why_none_is_recommended` says
    so, and `best_guess` names the one most likely to be accurate.

    Parameters
    ----------
    problem : Oscillator or System
    answers : dict
        Name of a method to its result, as from `springpot.theory.solve_all`.

    Returns
    -------
    str
        Name of the method; empty if none is recommended.

    Examples
    --------
    >>> recommended(Oscillator(), {})
    ''
    """
    methods = {**METHODS, **SYSTEM_METHODS} if isinstance(problem, System) else METHODS
    if exact := [name for name, method in methods.items() if method.exact and name in answers]:
        return exact[-1]  # the list ends with the most exact
    judged = {name: trust(problem, name) for name in _place(problem)[0].methods if name in answers}
    known = [name for name, trusted in judged.items() if trusted.judges]
    return min(known, key=lambda name: judged[name].worst) if known else ""


def best_guess(problem: Oscillator | System, answers: Mapping[str, Any]) -> str:
    """The recommended method, or the one most likely to be accurate if the errors are unknown.

    Away from the map of oscillators: the closure, or the envelope, or averaging up to the largest c of the map (beyond,
    the error of its <A^2> is 50 % and more).  Away from that of systems: path integration, or the half
    cycles, or the envelope, or statistical linearization, or averaging of the amplitude.

    Parameters
    ----------
    problem, answers
        As in `recommended`.

    Returns
    -------
    str
        Name of the method; empty if there is none.

    Examples
    --------
    >>> best_guess(Oscillator(), {})
    ''
    """
    atlas, _ = _place(problem)
    guesses = atlas.guesses
    if atlas is _OSCILLATORS and checked(problem).dimensionless_coefficient > float(read_map()["c"].max()):
        guesses = guesses[:2]
    return recommended(problem, answers) or next((name for name in guesses if name in answers), "")


def why_none_is_recommended(problem: Oscillator | System, answers: Mapping[str, Any]) -> str:
    """Why no method is recommended here, and which is the best guess, in one sentence; empty if one is recommended.

    Parameters
    ----------
    problem, answers
        As in `recommended`.

    Returns
    -------
    str

    Examples
    --------
    >>> why_none_is_recommended(Oscillator(), {})
    'no method is recommended here: none has an answer.'
    """
    if recommended(problem, answers):
        return ""
    if not answers:
        return "no method is recommended here: none has an answer."
    atlas, _ = _place(problem)
    mapped = any(trust(problem, name).mapped for name in atlas.methods)
    why = f"the validity map has no cell near this {'oscillator' if atlas is _OSCILLATORS else 'system'}"
    if mapped:
        why = "the Monte Carlo of the validity map is too uncertain to judge them"
    guess = best_guess(problem, answers)
    hint = f"The best guess is {guess}: compare" if guess else "Compare"
    return f"no method is recommended here, because {why}. {hint} with Monte Carlo before you use a number."
