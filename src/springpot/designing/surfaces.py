"""Smooth surfaces through runs at several places: what simulated numbers are as functions of the model's numbers.

Impacts separate paths that have the same random numbers, so a simulated number is rough as a function of the model's
numbers, on scales far below its standard error.  A surface through runs all over a region is smooth, and its errors are
smaller than those of one run: a polynomial in a small region, a spline in a large one.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from springpot.machine.arrays import Floats

Form = Literal["plane", "quadratic", "spline"]

_CORNER = 0.8  # of the way to a corner of the region
_SMOOTHING = 1e-4  # of a spline, whose runs have errors of some per cent
_DIFFERENCE = 1e-4  # of the region, for the slopes of a spline


@dataclass(frozen=True, eq=False)
class Surface:
    """A smooth function for each of several numbers, in coordinates relative to a region.

    Attributes
    ----------
    centre, reach : ndarray, shape (numbers,)
        Of the region, in the coordinates of the search.
    logarithmic : ndarray of bool, shape (n,)
        Which numbers are fitted by their logarithms.
    heights : ndarray, shape (runs, n)
        The numbers of the runs, or their logarithms.
    weights
        Of the runs at a place.
    samples : ndarray, shape (runs, groups, n)
        Means of groups of paths of each run, as they were fitted: their deviations from the mean of all.
    misfit : ndarray, shape (n,)
        Root mean square of what the surface leaves of the runs, beyond what the error of simulation explains.
    """

    centre: Floats
    reach: Floats
    logarithmic: NDArray[np.bool_]
    heights: Floats
    weights: _Polynomial | _Spline
    samples: Floats
    misfit: Floats

    def local(self, u: Floats) -> Floats:
        """Coordinates relative to the region: 1 at its ends."""
        return np.asarray((u - self.centre) / self.reach)

    def __call__(self, u: Floats) -> Floats:
        """The numbers at a place, shape (n,)."""
        found = self.weights.at(self.local(u)) @ self.heights
        return np.asarray(np.where(self.logarithmic, np.exp(np.where(self.logarithmic, found, 0.0)), found))

    def slope(self, u: Floats) -> Floats:
        """Derivatives by the coordinates, shape (n, numbers)."""
        found = (self.weights.slopes(self.local(u)) @ self.heights).T / self.reach
        return np.asarray(found * np.where(self.logarithmic, self(u), 1.0)[:, None])

    def slope_samples(self, u: Floats) -> Floats:
        """What each group of paths adds to the error of the slopes, shape (groups, n, numbers)."""
        own = np.tensordot(self.weights.slopes(self.local(u)), self.samples, axes=1)
        scaled = own * np.where(self.logarithmic, self(u), 1.0) / self.reach[:, None, None]
        groups = scaled.shape[1]
        return np.asarray(np.moveaxis(scaled, 0, -1) / np.sqrt(groups * (groups - 1.0)))

    def covariance(self, u: Floats) -> Floats:
        """Of the error of simulation at a place, shape (n, n), group by group of paths."""
        own = np.tensordot(self.weights.at(self.local(u)), self.samples, axes=1)
        own = own * np.where(self.logarithmic, self(u), 1.0)
        groups = len(own)
        return np.asarray(own.T @ own / (groups * (groups - 1.0)))


def surface_through(
    u: Floats,
    values: Floats,
    centre: Floats,
    reach: Floats,
    *,
    form: Form,
    logarithmic: NDArray[np.bool_],
    samples: Floats | None = None,
) -> Surface:
    """The surface with the least squares of what it leaves of the runs.

    Parameters
    ----------
    u : ndarray, shape (runs, numbers)
    values : ndarray, shape (runs, n)
    centre, reach : ndarray, shape (numbers,)
    form : {"plane", "quadratic", "spline"}
        Polynomials of the first and second degree; a thin plate spline, which is smoothed.
    logarithmic : ndarray of bool, shape (n,)
    samples : ndarray, shape (runs, groups, n), optional
        Means of groups of paths, for the errors; without them there are none.

    Examples
    --------
    >>> u = np.array([[-1.0], [0.0], [1.0], [2.0]])
    >>> for form in ("plane", "spline"):
    ...     own = surface_through(
    ...         u, np.exp(u), np.zeros(1), np.ones(1), form=form, logarithmic=np.array([True])
    ...     )
    ...     print(own(np.array([0.5])).round(9).tolist() == [round(float(np.exp(0.5)), 9)])
    True
    True
    """
    z = np.asarray((u - centre) / reach)
    weights = _Spline(z) if form == "spline" else _Polynomial(z, form == "quadratic")
    heights = np.where(logarithmic, np.log(np.where(logarithmic, values, 1.0)), values)
    given = np.zeros((len(u), 2, values.shape[1])) if samples is None else samples
    apart = given - given.mean(axis=1, keepdims=True)
    apart = apart / np.asarray(np.where(logarithmic, values, 1.0))[:, None, :]
    off = np.eye(len(z)) - np.stack([weights.at(each) for each in z])
    spare = max(float(np.trace(off)), 1.0)
    left = np.asarray((off @ heights) ** 2).sum(axis=0)
    groups = apart.shape[1]
    own = np.tensordot(off, apart, axes=1)
    left = left - (own**2).sum(axis=(0, 1)) / (groups * (groups - 1.0))
    misfit = np.sqrt(np.maximum(left, 0.0) / spare)
    return Surface(centre, reach, logarithmic, np.asarray(heights), weights, apart, np.asarray(misfit))


class _Polynomial:
    """What the runs count for at a place, by least squares; the solver leads from their numbers to the terms."""

    def __init__(self, z: Floats, quadratic: bool) -> None:
        self._quadratic = quadratic
        self._solver = np.linalg.pinv(np.stack([_row(each, quadratic) for each in z]))

    def at(self, z: Floats) -> Floats:
        """Shape (runs,)."""
        return np.asarray(_row(z, self._quadratic) @ self._solver)

    def slopes(self, z: Floats) -> Floats:
        """Derivatives by the coordinates, shape (numbers, runs)."""
        return np.asarray(_slopes(z, self._quadratic) @ self._solver)


class _Spline:
    """A thin plate spline: the surfaces through runs of which one is 1 and the others are 0."""

    def __init__(self, z: Floats) -> None:
        from scipy.interpolate import RBFInterpolator

        self._of_each = RBFInterpolator(z, np.eye(len(z)), kernel="thin_plate_spline", degree=1, smoothing=_SMOOTHING)

    def at(self, z: Floats) -> Floats:
        return np.asarray(self._of_each(z[None, :])[0])

    def slopes(self, z: Floats) -> Floats:
        steps = _DIFFERENCE * np.eye(z.size)
        return np.asarray((self._of_each(z + steps) - self._of_each(z - steps)) / (2.0 * _DIFFERENCE))


def fewest(numbers: int, *, quadratic: bool) -> int:
    """Number of terms of a polynomial.

    Examples
    --------
    >>> fewest(4, quadratic=False), fewest(4, quadratic=True)
    (5, 15)
    """
    return 1 + numbers + (numbers * (numbers + 1) // 2 if quadratic else 0)


def places(numbers: int, *, quadratic: bool, seed: int) -> Floats:
    """Where to run, relative to a region: its centre, the middles of its sides, and near its corners.

    For terms of the second degree this is a central composite design (G. E. P. Box and K. B. Wilson, Journal of the
    Royal Statistical Society B 13, 1951): all corners of up to four numbers, half of them of five; of more a sample.
    For the first degree a Latin hypercube takes the place of the corners.

    Parameters
    ----------
    numbers : int
    quadratic : bool
    seed : int

    Returns
    -------
    ndarray, shape (places, numbers)

    Examples
    --------
    >>> places(2, quadratic=False, seed=1).shape, places(4, quadratic=True, seed=1).shape
    ((7, 2), (25, 4))
    """
    from scipy.stats import qmc

    rng = np.random.default_rng(seed)
    axes = np.concatenate([np.zeros((1, numbers)), np.eye(numbers), -np.eye(numbers)])
    if not quadratic:
        more = max(2 * fewest(numbers, quadratic=False) - len(axes), 2)
        return np.concatenate([axes, 2.0 * qmc.LatinHypercube(numbers, rng=rng).random(more) - 1.0])
    if numbers > 5:
        return np.concatenate([axes, _CORNER * rng.choice([-1.0, 1.0], (fewest(numbers, quadratic=True), numbers))])
    corners = np.array([*itertools.product([-1.0, 1.0], repeat=numbers)])
    if numbers == 5:
        corners = corners[corners.prod(axis=1) > 0.0]
    return np.concatenate([axes, _CORNER * corners])


def _row(z: Floats, quadratic: bool) -> Floats:
    products = [z[i] * z[j] for i, j in _pairs(z.size)] if quadratic else []
    return np.array([1.0, *z, *products])


def _slopes(z: Floats, quadratic: bool) -> Floats:
    """Derivatives of each term by each coordinate, shape (numbers, terms)."""
    unit = np.eye(z.size)
    columns = [np.zeros(z.size), *unit]
    if quadratic:
        columns += [z[i] * unit[j] + z[j] * unit[i] for i, j in _pairs(z.size)]
    return np.stack(columns, axis=-1)


def _pairs(count: int) -> list[tuple[int, int]]:
    return [*itertools.combinations_with_replacement(range(count), 2)]
