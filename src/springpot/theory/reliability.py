"""Reliability of a method for an oscillator: its gaps to Monte Carlo at the nearest cells of the validity map.

The map (``validity.csv``, written by :mod:`springpot.validity`) has stationary Monte Carlo over order, c, restitution
and wall position, and the gap of every method to it.  Between cells the largest of the neighbouring gaps is used.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from springpot.faults import listed
from springpot.oscillator import Oscillator
from springpot.theory.problem import checked
from springpot.theory.registry import MAPPED, METHODS
from springpot.theory.result import MOMENTS, Result

__all__ = [
    "JUDGED",
    "MAP_FILE",
    "Trust",
    "best_guess",
    "map_warnings",
    "read_map",
    "recommended",
    "trust",
    "why_none_is_recommended",
]

MAP_FILE = Path(__file__).with_name("validity.csv")
JUDGED = ("amplitude_mean_square", "x_mean", "impact_rate")
"""Moments by which methods are ranked."""
GOOD = dict.fromkeys(MOMENTS, 4.0) | {"amplitude_mean_square": 2.0}
"""Moments whose gaps are on the map, and the gaps in per cent up to which no warning is given."""

_WORDS = {
    "amplitude_mean_square": "<A^2>",
    "x_mean": "<x>",
    "x_mean_square": "<x^2>",
    "v_mean_square": "<v^2>",
    "impact_rate": "impact rate",
    "impact_speed_mean": "mean impact speed",
    "impact_speed_mean_square": "mean square impact speed",
}

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trust:
    """Errors of one method near an oscillator, from the map.

    Attributes
    ----------
    gaps : dict
        Largest gap in per cent, without sign, of each moment in GOOD at the cells on either side; infinite if the
        method has no result or the map has no cell near, NaN if the map's Monte Carlo is too uncertain at all of them.
    unjudged : tuple of str
        Moments for which it is too uncertain at one of these cells at least.
    mapped : bool
        Whether the map has a cell near.
    """

    gaps: Mapping[str, float]
    mapped: bool
    unjudged: tuple[str, ...] = ()

    @property
    def judges(self) -> bool:
        """Whether the map has a finite gap of one moment at least, among those by which methods are ranked."""
        return self.mapped and any(math.isfinite(self.gaps[name]) for name in JUDGED)

    @property
    def worst(self) -> float:
        """The largest known gap over the limit in GOOD, of the moments in JUDGED."""
        return max((self.gaps[name] / GOOD[name] for name in JUDGED if not math.isnan(self.gaps[name])), default=0.0)


@cache
def read_map(path: Path = MAP_FILE) -> dict[str, Floats]:
    """The columns of the map: coordinates of the cells, Monte Carlo, and gaps in per cent under ``method:moment``.

    A gap is infinite if the method has no result and NaN if Monte Carlo is too uncertain.
    """
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def trust(oscillator: Oscillator, method: str) -> Trust:
    """Errors of a method for this oscillator, from the map.

    Parameters
    ----------
    oscillator : Oscillator
        With a wall.
    method : str
        One of `springpot.theory.registry.MAPPED`.

    Returns
    -------
    Trust

    Raises
    ------
    TypeError
        If ``oscillator`` is not an Oscillator.
    ValueError
        If ``method`` is another word.

    Examples
    --------
    >>> trust(Oscillator(), "averaging").mapped
    True
    """
    checked(oscillator)
    if method not in MAPPED:
        raise ValueError(f"method must be one of {', '.join(MAPPED)}, not {method!r}.")
    unknown = Trust(dict.fromkeys(GOOD, math.inf), mapped=False)
    c = oscillator.dimensionless_coefficient
    if oscillator.barrier is None or not c > 0.0 or not math.isfinite(oscillator.dimensionless_position):
        return unknown
    if oscillator.springpot.order == 0.0:  # a spring, to which small orders do not apply
        return unknown
    columns = read_map()
    lightest = float(columns["c"].min())  # below it every method is better than on the map
    near = np.ones(columns["c"].size, bool)
    for name, value, slack in (
        ("position", oscillator.dimensionless_position, 0.25),
        ("restitution", oscillator.restitution, 0.15),
        ("order", oscillator.springpot.order, 0.1),
        ("c", max(c, lightest), 0.3),
    ):
        beside = _beside(np.unique(columns[name][near]), value, slack)
        if not beside:
            return unknown
        near &= np.isin(columns[name], beside)
    gaps = {name: np.abs(columns[f"{method}:{name}"][near]) for name in GOOD}
    unjudged = tuple(name for name in GOOD if np.isnan(gaps[name]).any())
    return Trust({name: _worst(gaps[name]) for name in GOOD}, mapped=True, unjudged=unjudged)


def _beside(values: Floats, here: float, slack: float) -> tuple[float, ...]:
    """The values of the map next to a number on either side; empty if it is outside by more than ``slack``."""
    within = 1e-9 * max(1.0, abs(here))
    below, above = values[values <= here + within], values[values >= here - within]
    nearest = {float(side) for side in (below[-1:], above[:1]) for side in side}
    one_sided = not (below.size and above.size)
    return () if one_sided and min(abs(value - here) for value in nearest) > slack else tuple(nearest)


def _worst(gaps: Floats) -> float:
    """The largest finite gap; infinite if there is no result at any cell, NaN if Monte Carlo is too uncertain."""
    if np.isinf(gaps).all():
        return math.inf
    return float(np.max(gaps[np.isfinite(gaps)], initial=-math.inf)) if np.isfinite(gaps).any() else math.nan


def map_warnings(oscillator: Oscillator, method: str) -> tuple[str, ...]:
    """One sentence if a method has large errors near here, or no cell of the map is near; otherwise none.

    The map does not apply without a wall or without a springpot.
    """
    if oscillator.barrier is None or not oscillator.dimensionless_coefficient > 0.0:
        return ()
    here = trust(oscillator, method)
    if not here.mapped:
        return ("The validity map has no cell near these numbers: compare with Monte Carlo before you trust them.",)
    off = [f"{_WORDS[name]} {gap:.1f} %" for name, gap in here.gaps.items() if GOOD[name] < gap < math.inf]
    sentences = [f"Near here the validity map has gaps to Monte Carlo of up to: {', '.join(off)}."] if off else []
    if here.unjudged and min(here.gaps.values()) < math.inf:
        unknown = listed([_WORDS[name] for name in here.unjudged])
        sentences.append(f"Near here the Monte Carlo of the validity map is too uncertain to judge {unknown}.")
    return (" ".join(sentences),) if sentences else ()


def recommended(oscillator: Oscillator, answers: Mapping[str, Result]) -> str:
    """The most reliable method here, among those that have a result.

    Exact methods first; then the method with the smallest of the largest gaps on the map.  If the map has no cell near,
    or its Monte Carlo is too uncertain, the errors are unknown and none is recommended: `why_none_is_recommended` says
    so, and `best_guess` names the one most likely to be accurate.

    Parameters
    ----------
    oscillator : Oscillator
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
    if exact := [method.name for method in METHODS.values() if method.exact and method.name in answers]:
        return exact[-1]  # the list ends with the most exact
    judged = {name: trust(oscillator, name) for name in MAPPED if name in answers}
    known = [name for name, trusted in judged.items() if trusted.judges]
    return min(known, key=lambda name: judged[name].worst) if known else ""


def best_guess(oscillator: Oscillator, answers: Mapping[str, Result]) -> str:
    """The recommended method, or the one most likely to be accurate if the errors are unknown.

    Away from the map: the closure, or the envelope, or averaging up to the largest c of the map (beyond, the error of
    its <A^2> is 50 % and more).

    Parameters
    ----------
    oscillator, answers
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
    strong = oscillator.dimensionless_coefficient > float(read_map()["c"].max())
    usual = ("closure", "envelope") if strong else ("closure", "envelope", "averaging")
    return recommended(oscillator, answers) or next((name for name in usual if name in answers), "")


def why_none_is_recommended(oscillator: Oscillator, answers: Mapping[str, Result]) -> str:
    """Why no method is recommended here, and which is the best guess, in one sentence; empty if one is recommended.

    Parameters
    ----------
    oscillator, answers
        As in `recommended`.

    Returns
    -------
    str

    Examples
    --------
    >>> why_none_is_recommended(Oscillator(), {})
    'no method is recommended here: none has an answer.'
    """
    if recommended(oscillator, answers):
        return ""
    if not answers:
        return "no method is recommended here: none has an answer."
    mapped = any(trust(oscillator, name).mapped for name in MAPPED)
    why = "the validity map has no cell near this oscillator"
    if mapped:
        why = "the Monte Carlo of the validity map is too uncertain to judge them"
    guess = best_guess(oscillator, answers)
    hint = f"The best guess is {guess}: compare" if guess else "Compare"
    return f"no method is recommended here, because {why}. {hint} with Monte Carlo before you use a number."
