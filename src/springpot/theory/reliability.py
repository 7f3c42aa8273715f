"""How far to trust a method here: its gaps to Monte Carlo at the nearest cells of the validity map.

The map (``validity.csv``, made by :mod:`springpot.validity`) holds adapted Monte Carlo over order, c, restitution and
wall position, and the gap of every method to it.  Between cells the worst of the neighbouring gaps is taken.
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
    """What the map says of one method here.

    Attributes
    ----------
    gaps : dict
        Largest gap in per cent, without sign, of each moment in GOOD at the cells on either side; infinite where the
        method has no answer or the map has no cell near, NaN where the map's Monte Carlo cannot judge any of them.
    unjudged : tuple of str
        Moments that it cannot judge at one of these cells at least.
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
        """The largest gap that is known over what is thought good of its moment, of the moments in JUDGED."""
        return max((self.gaps[name] / GOOD[name] for name in JUDGED if not math.isnan(self.gaps[name])), default=0.0)


@cache
def read_map(path: Path = MAP_FILE) -> dict[str, Floats]:
    """The columns of the map: place of each cell, Monte Carlo, and gaps in per cent under ``method:moment``.

    A gap is infinite where the method has no answer and NaN where Monte Carlo cannot judge it.
    """
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def trust(oscillator: Oscillator, method: str) -> Trust:
    """What the map says of a method for this oscillator.

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
    if oscillator.springpot.order == 0.0:  # a spring, of which small orders tell nothing
        return unknown
    found = read_map()
    lightest = float(found["c"].min())  # below the map every method is better than on it
    near = np.ones(found["c"].size, bool)
    for name, value, slack in (
        ("position", oscillator.dimensionless_position, 0.25),
        ("restitution", oscillator.restitution, 0.15),
        ("order", oscillator.springpot.order, 0.1),
        ("c", max(c, lightest), 0.3),
    ):
        beside = _beside(np.unique(found[name][near]), value, slack)
        if not beside:
            return unknown
        near &= np.isin(found[name], beside)
    gaps = {name: np.abs(found[f"{method}:{name}"][near]) for name in GOOD}
    unjudged = tuple(name for name in GOOD if np.isnan(gaps[name]).any())
    return Trust({name: _worst(gaps[name]) for name in GOOD}, mapped=True, unjudged=unjudged)


def _beside(values: Floats, here: float, slack: float) -> tuple[float, ...]:
    """The values of the map next to a number on either side; nothing if it lies off them by more than ``slack``."""
    within = 1e-9 * max(1.0, abs(here))
    below, above = values[values <= here + within], values[values >= here - within]
    found = {float(side) for side in (below[-1:], above[:1]) for side in side}
    one_sided = not (below.size and above.size)
    return () if one_sided and min(abs(value - here) for value in found) > slack else tuple(found)


def _worst(gaps: Floats) -> float:
    """The largest gap where there is an answer and Monte Carlo can judge it; infinite if there is no answer at all."""
    if np.isinf(gaps).all():
        return math.inf
    return float(np.max(gaps[np.isfinite(gaps)], initial=-math.inf)) if np.isfinite(gaps).any() else math.nan


def map_warnings(oscillator: Oscillator, method: str) -> tuple[str, ...]:
    """One sentence if the map says that a method is off here, or says nothing; none if it is good.

    Without a wall, and without a springpot, the map has nothing to say.
    """
    if oscillator.barrier is None or not oscillator.dimensionless_coefficient > 0.0:
        return ()
    found = trust(oscillator, method)
    if not found.mapped:
        return ("The validity map has no cell near these numbers: compare with Monte Carlo before you trust them.",)
    off = [f"{_WORDS[name]} {gap:.1f} %" for name, gap in found.gaps.items() if GOOD[name] < gap < math.inf]
    said = [f"Near here the validity map found gaps to Monte Carlo of up to: {', '.join(off)}."] if off else []
    if found.unjudged and min(found.gaps.values()) < math.inf:
        unknown = listed([_WORDS[name] for name in found.unjudged])
        said.append(f"At a cell of the map near here Monte Carlo is too uncertain to judge {unknown}.")
    return (" ".join(said),) if said else ()


def recommended(oscillator: Oscillator, answers: Mapping[str, Result]) -> str:
    """The method to trust here, among those that have an answer.

    Exact answers first; then the method with the smallest worst gap on the map.  Where the map has no cell near, or its
    Monte Carlo can judge none of the methods, nothing is known of their errors and none is recommended:
    `why_none_is_recommended` says so, and `best_guess` names the one most likely to be near.

    Parameters
    ----------
    oscillator : Oscillator
    answers : dict
        Name of a method to its result, as from `springpot.theory.solve_all`.

    Returns
    -------
    str
        Name of the method; empty if there is none to trust.

    Examples
    --------
    >>> recommended(Oscillator(), {})
    ''
    """
    if exact := [method.name for method in METHODS.values() if method.exact and method.name in answers]:
        return exact[-1]  # the list rises to the surest
    judged = {name: trust(oscillator, name) for name in MAPPED if name in answers}
    known = [name for name, found in judged.items() if found.judges]
    return min(known, key=lambda name: judged[name].worst) if known else ""


def best_guess(oscillator: Oscillator, answers: Mapping[str, Result]) -> str:
    """The method that is recommended, or the one most likely to be near where nothing is known of the errors.

    Away from the map the closure, or the envelope, or averaging up to the largest c of the map (beyond, its <A^2> is
    wrong by half and more).

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
    """One sentence that says why no method is recommended here, and which is the best guess; empty if one is.

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
    why = "Monte Carlo on the validity map cannot judge them" if mapped else "the validity map has no cell near"
    guess = best_guess(oscillator, answers)
    hint = f"The best guess is {guess}: compare" if guess else "Compare"
    return f"no method is recommended here, for {why}. {hint} with Monte Carlo before you use a number."
