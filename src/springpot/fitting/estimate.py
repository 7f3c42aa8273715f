"""The search for the numbers that agree best with data, and for those that agree at a fixed value of one."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.fitting.likelihood import Likelihood
from springpot.machine.arrays import Floats
from springpot.machine.faults import Stopped

STRONG = 0.95
"""Correlation from which numbers may not be told apart: each is three times as certain if the others are known."""

_STRONG_AT_BOUND = 0.9
_WHOLLY = 1.0 - 1e-9  # correlation from which rounding hides how well a combination is known

VAGUE = 0.25
"""Relative error from which numbers of strong correlation are said not to be told apart."""

_PLACES, _STARTS = 40, 2  # drawn between the bounds, and those of them from which the search is repeated
_FIRST = 0.7  # step of a logarithm, of a number that is hardly known
_SECANTS, _CLOSE = 12, 0.02  # steps to the end of a profile, and how close its rise is to the level
_AT_BOUND = 1e-3  # of the range, in the coordinates of the search
_NEAR_BOUND, _LOST = 0.1, 1.0  # of the deviance, by which a number is not on a bound, or is found: one standard error


@dataclass(frozen=True, eq=False)
class Solution:
    """The best numbers.

    Attributes
    ----------
    u : ndarray
        Coordinates of the search.
    deviance : float
    moves : ndarray of bool
        False for numbers that are held at a bound.
    """

    u: Floats
    deviance: float
    moves: NDArray[np.bool_]


@dataclass(frozen=True)
class Confusion:
    """Numbers that the data do not tell apart.

    Attributes
    ----------
    names : tuple of str
    correlation : float
        Of their errors: of several, the strongest, or that of the first with the best combination of the others.
    """

    names: tuple[str, ...]
    correlation: float


def search(likelihood: Likelihood, seed: int) -> Solution:
    """The minimum of the deviance: from the start, and from places drawn between the bounds.

    Parameters
    ----------
    likelihood : Likelihood
    seed : int

    Returns
    -------
    Solution

    Raises
    ------
    ValueError
        If the model cannot be computed at its start.
    Stopped
        If it was stopped before that.
    """
    own = likelihood.coordinates
    every = np.ones(len(own.free), bool)
    likelihood.deviance(own.outer(own.start))  # a model that cannot be computed is an error here
    best: tuple[float, Floats] | None = None
    fault: ValueError | None = None
    for begin in _starts(likelihood, seed):
        try:
            u = likelihood.solve(begin, every)
            found = likelihood.deviance(own.outer(u))
        except ValueError as error:  # a place between the bounds where the model cannot be
            fault = error
            continue
        except Stopped:
            if likelihood.least is None:
                raise
            return Solution(own.inner(likelihood.least[1]), likelihood.least[0], every)
        if np.isfinite(found) and (best is None or found < best[0]):
            best = found, u
    if best is None:
        raise fault or ValueError("model has no likelihood between its bounds.")
    try:
        return _held(likelihood, *best)
    except Stopped:
        return Solution(best[1], best[0], every)


def _starts(likelihood: Likelihood, seed: int) -> Iterator[Floats]:
    """The start, and the best of many places between the bounds."""
    from scipy.stats import qmc

    own = likelihood.coordinates
    yield own.start
    if likelihood.smooth_start:
        return
    places = qmc.LatinHypercube(len(own.free), rng=np.random.default_rng(seed)).random(_PLACES)
    drawn = [own.low + place * (own.high - own.low) for place in places]
    fits = [_deviance_at(likelihood, u) for u in drawn]
    yield from (drawn[n] for n in np.argsort(fits)[:_STARTS] if np.isfinite(fits[n]))


def _deviance_at(likelihood: Likelihood, u: Floats) -> float:
    """Infinite where the model cannot be."""
    try:
        return likelihood.deviance(likelihood.coordinates.outer(u))
    except ValueError:
        return np.inf


def _held(likelihood: Likelihood, deviance: float, u: Floats) -> Solution:
    """Numbers that have come to a bound, or that the data do not find, are put on it; the others are found again."""
    own = likelihood.coordinates
    near = _AT_BOUND * (own.high - own.low)
    low, high = u - own.low < near, own.high - u < near
    scale = likelihood.scatter(own.outer(u), u.size)
    lost = likelihood.lost(u, deviance)
    for held, more in ((low | lost, _LOST), (low, _NEAR_BOUND)) if lost.any() else ((low, _NEAR_BOUND),):
        moves = ~(held | high)
        begin = np.where(held, own.low, np.where(high, own.high, u))
        again = likelihood.solve(begin, moves) if moves.any() and not moves.all() else begin
        found = likelihood.deviance(own.outer(again))
        if found <= deviance + more * scale:
            return Solution(again, found, moves)
    return Solution(u, deviance, np.ones(u.size, bool))  # near the bound, not on it


def profile_along(likelihood: Likelihood, best: Solution, place: int, values: Floats) -> Floats:
    """The least deviance at each of these coordinates of one number.

    Parameters
    ----------
    likelihood : Likelihood
    best : Solution
    place : int
        Of the number.
    values : ndarray
        Ascending.

    Returns
    -------
    ndarray
    """
    moves = np.ones(best.u.size, bool)
    moves[place] = False
    found = np.full(values.size, np.inf)
    split = int(np.searchsorted(values, best.u[place]))
    for order in (range(split, values.size), range(split - 1, -1, -1)):
        u = best.u.copy()
        for n in order:
            u[place] = values[n]
            try:
                u = likelihood.solve(u, moves) if moves.any() else u
                found[n] = likelihood.deviance(likelihood.coordinates.outer(u))
            except ValueError:
                break
    return found


def profile_ends(
    likelihood: Likelihood, best: Solution, place: int, covariance: Floats, level: float
) -> tuple[float, float]:
    """Where the least deviance has risen by a level on each side of one number; the bound where it does not.

    The root of the rise is nearly linear, so a secant finds each end in a few steps; where it is not, and a secant
    comes to the same side again, the middle is taken.  Each step begins where the numbers would be if all errors were
    normal.

    Parameters
    ----------
    likelihood : Likelihood
    best : Solution
    place : int
        Of the number.
    covariance : ndarray, shape (numbers, numbers)
        Of the coordinates, all of them free.
    level : float

    Returns
    -------
    low, high : float
        Coordinates.
    """
    own, moves = likelihood.coordinates, np.arange(best.u.size) != place
    variance, target = float(covariance[place, place]), math.sqrt(level)
    follows = covariance[:, place] / variance if 0.0 < variance < math.inf else np.zeros(best.u.size)
    follows = np.where(np.isfinite(follows), follows, 0.0)

    def end_on(side: float) -> float:
        last = float(own.high[place] if side > 0.0 else own.low[place])
        reach = abs(last - best.u[place])
        if reach == 0.0:
            return last
        inside, outside = (0.0, 0.0), (math.inf, math.inf)  # distances, and roots of the rise there
        side_before: bool | None = None
        first = _FIRST if own.logarithmic[place] else 0.3 * float(own.high[place] - own.low[place])
        at, u = min(target * math.sqrt(variance) if variance > 0.0 else reach, reach, first), best.u
        for _ in range(_SECANTS):
            guess = u + follows * (best.u[place] + side * at - u[place])
            guess[place] = best.u[place] + side * at
            try:
                found = likelihood.solve(np.clip(guess, own.low, own.high), moves) if moves.any() else guess
                root = math.sqrt(max(likelihood.deviance(own.outer(found)) - best.deviance, 0.0))
            except ValueError:
                found, root = u, math.inf
            if abs(root - target) < _CLOSE * target or (at == reach and root < target):
                break
            again = side_before == (root < target)
            side_before = root < target
            if root < target:
                inside, u = (at, root), found
            else:
                outside = at, root
            if math.isinf(outside[0]):
                at = min(at + (target - root) * at / max(root, 0.2 * target), reach)
            else:
                at = 0.5 * (inside[0] + outside[0]) if again else _between(inside, outside, target)
        else:
            at = min(outside[0], reach)  # not found closely: rather too wide than too narrow
        return float(np.clip(best.u[place] + side * at, own.low[place], own.high[place]))

    return end_on(-1.0), end_on(1.0)


def _between(inside: tuple[float, float], outside: tuple[float, float], target: float) -> float:
    """Where a line through two points has the target; their middle where one has no value."""
    share = (target - inside[1]) / (outside[1] - inside[1]) if math.isfinite(outside[1]) else 0.5
    return inside[0] + min(max(share, 0.05), 0.95) * (outside[0] - inside[0])


def correlation_of(covariance: Floats) -> Floats:
    """Correlations from a covariance.

    Examples
    --------
    >>> correlation_of(np.array([[4.0, 1.0], [1.0, 1.0]])).tolist()
    [[1.0, 0.5], [0.5, 1.0]]
    """
    size = np.sqrt(np.diag(covariance))
    return np.asarray(np.clip(covariance / np.outer(size, size), -1.0, 1.0))


def known_together(names: tuple[str, ...], logarithmic: NDArray[np.bool_], covariance: Floats) -> tuple[str, ...]:
    """Of numbers whose errors have a strong correlation: which combination of two is known, and how well.

    Parameters
    ----------
    names : tuple of str
    logarithmic : ndarray of bool, shape (numbers,)
        Whether the coordinate of each is its logarithm.
    covariance : ndarray, shape (numbers, numbers)
        Of the coordinates; NaN for numbers that are held.

    Returns
    -------
    tuple of str
        A sentence for each pair, the strongest first; each number is in one of them.

    Examples
    --------
    >>> whole = 0.01 * np.array([[1.0, 1.98], [1.98, 4.0]])
    >>> known_together(("C", "q"), np.array([True, True]), whole)[0]
    'The errors of C and q have a correlation of 0.990: C q^-0.495 is known to 1.4 %, C alone to 10 %.'
    """
    rho = correlation_of(covariance)
    pairs = [pair for pair in itertools.combinations(range(len(names)), 2) if abs(rho[pair]) >= STRONG]
    said, told = [], set[int]()
    for i, j in sorted(pairs, key=lambda pair: -abs(rho[pair])):
        if told & {i, j} or abs(rho[i, j]) > _WHOLLY:
            continue
        told |= {i, j}
        alone = float(np.sqrt(covariance[i, i]))
        together, power = alone * float(np.sqrt(1.0 - rho[i, j] ** 2)), -float(covariance[i, j] / covariance[j, j])
        one, other = (f"ln {names[n]}" if logarithmic[n] else names[n] for n in (i, j))
        what = f"{one} {'-' if power < 0.0 else '+'} {abs(power):.3g} {other}"
        errors = [f"+- {error:.2g}" for error in (together, alone)]
        if logarithmic[i] and logarithmic[j]:
            one, what = names[i], f"{names[i]} {names[j]}^{power:.3g}"
            errors = [f"{100.0 * error:.2g} %" for error in (together, alone)]
        said.append(
            f"The errors of {names[i]} and {names[j]} have a correlation of {rho[i, j]:.3f}: {what} is known to "
            f"{errors[0]}, {one} alone to {errors[1]}."
        )
    return tuple(said)


def confusions(
    names: tuple[str, ...], covariance: Floats, vague: NDArray[np.bool_], held: NDArray[np.bool_]
) -> tuple[Confusion, ...]:
    """Numbers of strong correlation and large errors, in groups; and those that follow from several others.

    Parameters
    ----------
    names : tuple of str
    covariance : ndarray, shape (numbers, numbers)
        Of the coordinates of the search.
    vague : ndarray of bool, shape (numbers,)
        Whether the error of each is large.
    held : ndarray of bool, shape (numbers,)
        Whether each is held at a bound, so that its correlation at a better place is not known: 0.9 is enough then.

    Returns
    -------
    tuple of Confusion

    Examples
    --------
    >>> free = np.array([False, False])
    >>> confusions(("C", "order"), np.array([[1.0, -0.98], [-0.98, 1.0]]), ~free, free)
    (Confusion(names=('C', 'order'), correlation=-0.98),)
    """
    from scipy.sparse.csgraph import connected_components

    rho, count = np.nan_to_num(correlation_of(covariance)), len(names)  # of what has no influence it is not a number
    np.fill_diagonal(rho, 1.0)
    strong = np.abs(rho) >= np.where(held | held[:, None], _STRONG_AT_BOUND, STRONG)
    _, group_of = connected_components(strong & (vague | vague[:, None]), directed=False)
    found, told = [], set[int]()
    for group in np.unique(group_of):
        own = np.flatnonzero(group_of == group).tolist()
        if len(own) > 1:
            most = max((float(rho[i, j]) for i, j in itertools.combinations(own, 2)), key=abs)
            found.append(Confusion(tuple(names[n] for n in own), most))
            told.update(own)
    inverse = np.linalg.pinv(rho, rcond=1e-12)
    partial = -inverse / np.sqrt(np.outer(np.diag(inverse), np.diag(inverse)))
    for i in range(count):
        multiple = np.sqrt(max(1.0 - 1.0 / max(inverse[i, i], 1.0), 0.0))
        if i in told or multiple < STRONG:
            continue
        others = [j for j in range(count) if j != i and abs(partial[i, j]) > 0.5]
        if others and vague[[i, *others]].any():
            found.append(Confusion((names[i], *(names[j] for j in others)), float(multiple)))
            told |= {i, *others}
    return tuple(found)
