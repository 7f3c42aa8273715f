"""The shortest exponential sum for the memory weights: best approximation in the relative maximum norm.

A sum of n terms with the error e(t) = sum_k w_k exp(-s_k t) / c(t) - 1 is the best one with n terms or fewer if |e| has
its maximum at 2 n + 1 lags with alternating signs: a better sum would differ from it by a combination of at most 2 n
exponentials with 2 n changes of sign, but such a combination has at most 2 n - 1.  For the same reason 2 n + 1
alternating errors of size m or more prove that no sum of n terms has an error below m.  Where this proof succeeds, the
number of terms is the smallest possible.

Remez's exchange makes the extremes equal: Newton's method for e(t_j) = (-1)^j E at the current extremes t_j.  It works
in double precision because of three measures:

* The unknowns are log s_k and log(w_k / spacing_k), with spacing_k the distance of log s_k's neighbours.  Rates and
  weights stay positive, and directions in which the problem is nearly singular (all rates move together with the
  weights) are nearly straight lines in these variables.
* The number of terms grows one by one: at a fixed place from either end of the row of rates, the unknowns are smooth
  functions of the number of terms and are extrapolated.
* Damped least squares come first if the extrapolation is not accurate enough for the exchange.

The smallest singular values of the Jacobian are of order E^2, so the exchange works down to errors of about 1e-9, and
least squares alone down to about 1e-11.

References
----------
D. Braess and W. Hackbusch, "Approximation of 1/x by exponential sums in [1, oo)", IMA Journal of Numerical Analysis 25
(2005) 685-697; W. Hackbusch, "Computation of best L-infinity exponential sums for 1/x by Remez' algorithm", Computing
and Visualization in Science 20 (2019) 1-11; G. Beylkin and L. Monzon, "Approximation by exponential sums revisited",
Applied and Computational Harmonic Analysis 28 (2010) 131-149, for powers.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats

Places = npt.NDArray[np.intp]

_MOST_TERMS = 43  # so many unknowns that a matrix of them stays below _ONE_THREAD
_GRID = 2000
_PER_TERM = 8  # lags per term in the least-squares problem: four in each lobe of the error
_DAMPING = (0.0, 1e-15, 1e-13, 1e-11, 1e-9)  # of the exchange, relative to the norm of the matrix
_LEVEL = 1.001
_ONE_THREAD = 8191  # entries of a matrix; OpenBLAS starts threads beyond
_GUESSED = 16  # up to so many terms, guesses of these stretches are tried where there is nothing better
_STRETCHES = (0.0, 0.7, 1.5, 2.5)


@dataclass(frozen=True, eq=False)
class Minimax:
    """A sum and its error.

    Attributes
    ----------
    rates, weights : ndarray
        Positive, in the order of increasing rates.
    error : float
        Largest relative error on the grid of the fit.
    fewest : bool
        Whether it is proved that fewer terms do not reach the tolerance.
    """

    rates: Floats
    weights: Floats
    error: float
    fewest: bool


@dataclass(frozen=True, eq=False)
class _Sum:
    unknowns: Floats
    error: float
    least: float  # smallest extreme of a complete alternation: a lower bound for every sum of this length


@dataclass(frozen=True, eq=False)
class _Problem:
    lags: Floats
    exact: Floats

    def errors(self, unknowns: Floats) -> Floats:
        """Relative errors on the grid; infinite where two rates have changed places."""
        if (np.diff(_halves(unknowns)[0]) <= 0.0).any():
            return np.full(self.lags.size, np.inf)
        rates, logarithms = _sum(unknowns)
        return np.asarray(np.exp(logarithms - np.multiply.outer(self.lags, rates)).sum(axis=1) / self.exact - 1.0)

    def jacobian(self, unknowns: Floats) -> tuple[Floats, Floats]:
        """Relative errors and their derivatives."""
        rates, logarithms = _sum(unknowns)
        decay = np.multiply.outer(self.lags, rates)
        terms = np.exp(logarithms - decay) / self.exact[:, None]
        # the weights are spacing times density, and a spacing changes with the rates on either side
        by_spacings = terms / _spacings(_halves(unknowns)[0])
        by_rates = -decay * terms
        if rates.size > 1:
            inner = by_spacings[:, 1:-1] / 2.0
            by_rates[:, 2:] += inner
            by_rates[:, :-2] -= inner
            for this, near, far in ((by_spacings[:, 0], 0, 1), (by_spacings[:, -1], -2, -1)):
                by_rates[:, near] -= this
                by_rates[:, far] += this
        return terms.sum(axis=1) - 1.0, np.hstack([by_rates, terms])

    def some(self, chosen: slice | Places) -> _Problem:
        return _Problem(self.lags[chosen], self.exact[chosen])


def lag_grid(longest: float, size: int) -> Floats:
    """Lags from 1 to ``longest``, evenly in log t but twice as dense at both ends, where the error is quickest.

    Examples
    --------
    >>> lag_grid(100.0, 3).round(6)
    array([  1.,  10., 100.])
    """
    u = np.linspace(-1.0, 1.0, size)
    position = 0.5 + 0.25 * u + 0.25 * np.sin(0.5 * math.pi * u)
    grid: Floats = np.exp(math.log(longest) * position)
    grid[0], grid[-1] = 1.0, longest
    return grid


def fewest_terms(
    exact: Callable[[Floats], Floats],
    guess: Callable[[int, float], tuple[Floats, Floats]],
    longest: float,
    tolerance: float,
) -> Minimax | None:
    """The shortest sum whose error relative to ``exact`` is within a tolerance on [1, longest].

    Parameters
    ----------
    exact : callable
        The function at some lags; completely monotone, so that positive sums can approximate it.
    guess : callable
        Rates and weights of a rough sum with a given number of terms; the row of rates stretched at both ends by a
        given factor, as a logarithm.
    longest : float
        Longest lag, above 1.
    tolerance : float
        Relative.

    Returns
    -------
    Minimax or None
        None if it is not reached in double precision.

    Examples
    --------
    >>> def guess(terms, stretch):
    ...     edges = np.geomspace(0.05 * np.exp(-stretch), 3.0 * np.exp(stretch), terms + 1)
    ...     return np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)
    >>> minimax = fewest_terms(lambda t: 1.0 / t, guess, 10.0, 1e-3)
    >>> minimax.rates.size, minimax.error < 1e-3, minimax.fewest
    (4, True, True)
    """
    lags = lag_grid(longest, _GRID)
    problem = _Problem(lags, exact(lags))

    def best(terms: int, solved: dict[int, _Sum]) -> _Sum:
        """The best sum of this length, from an extrapolation of shorter sums, or from the best guess."""
        current = None
        starts = [_extrapolated(solved, terms, most) for most in (2, 3, 4)]
        if known := [start for start in starts if start is not None]:
            current = _improve(problem, min(known, key=lambda start: float(np.abs(problem.errors(start)).max())))
        for stretch in _STRETCHES if terms <= _GUESSED else ():
            if current is not None and current.least > 0.99 * current.error:
                break
            rates, weights = guess(terms, stretch)
            y = np.log(rates)
            other = _improve(problem, np.concatenate([y, np.log(weights / _spacings(y))]))
            if current is None or other.error < current.error:
                current = other
        assert current is not None
        return current

    # a step in a wrong direction may overflow; it is then rejected
    with np.errstate(all="ignore"), contextlib.suppress(np.linalg.LinAlgError):
        terms = min(max(1, round(math.log(longest) / 2.2)), _GUESSED)
        current = best(terms, {})
        if current.error <= tolerance:
            while terms > 1 and (shorter := best(terms - 1, {})).error <= tolerance:
                terms, current = terms - 1, shorter
            return _result(current, terms == 1 or shorter.least > tolerance)
        solved, stalled = {terms: current}, 0
        while terms < _MOST_TERMS:
            terms += 1
            previous, current = current, best(terms, solved)
            if current.error <= tolerance:
                return _result(current, previous.least > tolerance)
            stalled = stalled + 1 if not current.error < 0.95 * previous.error else 0
            if stalled == 2:
                return None
            solved[terms] = current
    return None


def _result(best: _Sum, fewest: bool) -> Minimax:
    rates, logarithms = _sum(best.unknowns)
    return Minimax(rates, np.exp(logarithms), best.error, fewest)


def _halves(unknowns: Floats) -> tuple[Floats, Floats]:
    return unknowns[: unknowns.size // 2], unknowns[unknowns.size // 2 :]


def _spacings(log_rates: Floats) -> Floats:
    """The spacing at each rate: half the distance of its neighbours, at the ends the distance of the one."""
    if log_rates.size == 1:
        return np.ones(1)
    steps = np.diff(log_rates)
    return np.concatenate([steps[:1], 0.5 * (steps[1:] + steps[:-1]), steps[-1:]])


def _sum(unknowns: Floats) -> tuple[Floats, Floats]:
    """Rates and logarithms of the weights."""
    log_rates, log_densities = _halves(unknowns)
    return np.exp(log_rates), log_densities + np.log(_spacings(log_rates))


def _extremes(errors: Floats) -> Places:
    """Where the error is largest in each run of errors of one sign."""
    cuts = np.flatnonzero((errors[1:] > 0.0) != (errors[:-1] > 0.0)) + 1
    return np.array([run[np.abs(errors[run]).argmax()] for run in np.split(np.arange(errors.size), cuts)])


def _improve(problem: _Problem, unknowns: Floats) -> _Sum:
    full = unknowns.size + 1
    if _extremes(problem.errors(unknowns)).size != full:
        stride = max(1, problem.lags.size // (_PER_TERM * unknowns.size // 2))
        unknowns = _least_squares(problem.some(slice(None, None, stride)), unknowns)
    unknowns = _levelled(problem, unknowns)
    errors = problem.errors(unknowns)
    sizes = np.abs(errors[_extremes(errors)])
    largest = float(sizes.max())
    return _Sum(unknowns, largest if math.isfinite(largest) else math.inf, float(sizes.min()) * (sizes.size == full))


def _least_squares(problem: _Problem, unknowns: Floats) -> Floats:
    """Levenberg's and Marquardt's damped steps, until one gains less than two per cent."""
    errors, jacobian = problem.jacobian(unknowns)
    damping, left = 1e-3, 60
    while left and np.isfinite(jacobian).all():
        triangle = _triangle(np.column_stack([jacobian, errors]))
        while left:
            left -= 1
            step = _damped(triangle, math.sqrt(damping))
            tried = problem.errors(unknowns - step)
            if np.abs(step).max() < 3.0 and tried @ tried < errors @ errors:
                break
            damping *= 3.0
        else:
            break
        gained = 1.0 - (tried @ tried) / (errors @ errors)
        unknowns = unknowns - step
        if gained < 0.02:
            break
        errors, jacobian = problem.jacobian(unknowns)
        damping /= 8.0
    return unknowns


def _levelled(problem: _Problem, unknowns: Floats) -> Floats:
    """Remez's exchange, as long as the largest error falls and the errors alternate in full."""
    errors = problem.errors(unknowns)
    places = _extremes(errors)
    for _ in range(8):
        sizes = np.abs(errors[places])
        largest = sizes.max()
        if places.size != unknowns.size + 1 or not largest > _LEVEL * sizes.min():
            break
        at_places, jacobian = problem.some(places).jacobian(unknowns)
        rows = np.column_stack([jacobian, -largest * np.sign(at_places), at_places])
        for damping in _DAMPING:
            step = _damped(rows, damping)[:-1]
            if not np.abs(step).max() < 1.0:
                continue
            tried = problem.errors(unknowns - step)
            tried_places = _extremes(tried)
            if tried_places.size == places.size and np.abs(tried[tried_places]).max() < largest:
                unknowns, errors, places = unknowns - step, tried, tried_places
                break
        else:
            break
    return unknowns


def _damped(rows: Floats, damping: float) -> Floats:
    """The step x of least |A x - b|^2 + (damping |A|)^2 |x|^2, rows = (A, b)."""
    count = rows.shape[1] - 1
    size = damping * math.sqrt((rows[:, :-1] ** 2).sum())
    triangle = _triangle(np.vstack([rows, np.eye(count, count + 1) * size]) if size else rows)
    return np.asarray(np.linalg.solve(triangle[:count, :count], triangle[:count, count]))


def _triangle(rows: Floats) -> Floats:
    """The triangular factor of a matrix, a few rows at a time.

    The blocks are so small that the linear algebra library uses one thread: several threads gain nothing for a matrix
    of this size, and on a busy machine they mostly wait for each other.
    """
    count = rows.shape[1]
    height = max(1, _ONE_THREAD // count - count)
    triangle = rows[:count]
    for first in range(count, rows.shape[0], height):
        triangle = np.asarray(np.linalg.qr(np.vstack([triangle, rows[first : first + height]]), mode="r"))
    return triangle if rows.shape[0] > count else np.asarray(np.linalg.qr(rows, mode="r"))


def _extrapolated(solved: dict[int, _Sum], terms: int, most: int) -> Floats | None:
    """The unknowns of the next sum from those of some before it, polynomials in 1 / terms, from either end."""
    known = [n for n in sorted(solved)[-most:] if n > terms // 2]
    if len(known) < 2:
        return None
    inverse = 1.0 / np.array(known)
    middle = (terms + 1) // 2  # each half is indexed from its end
    halves = []
    for half in (0, 1):
        row = np.zeros(terms)
        for n, q in zip(known, inverse, strict=True):
            others = inverse[inverse != q]
            share = float(np.prod((1.0 / terms - others) / (q - others)))
            values = _halves(solved[n].unknowns)[half]
            row[:middle] += share * values[:middle]
            row[middle:] += share * values[n - (terms - middle) :]
        halves.append(row)
    return np.concatenate(halves)
