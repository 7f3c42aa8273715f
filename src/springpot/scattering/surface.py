"""A result of a device as a polynomial of its uncertain numbers, from noisy means of draws: polynomial chaos.

The polynomials are products of orthonormal ones: Legendre's in the probability of a number, Hermite's in its normal
score where its law is normal or lognormal.  So squares of coefficients add up to variances, and those of one number
alone over all are its Sobol index.  A squared coefficient has the variance of the coefficient in it, which is taken
out; so is the noise of paths in what the surface leaves, since each draw has several paths.

References
----------
B. Sudret, "Global sensitivity analysis using polynomial chaos expansions", Reliability Engineering and System Safety
93, 2008; G. Blatman and B. Sudret, "Adaptive sparse polynomial chaos expansion based on least angle regression",
Journal of Computational Physics 230, 2011 (hyperbolic sets); J. MacKinnon and H. White, "Some
heteroskedasticity-consistent covariance matrix estimators", Journal of Econometrics 29, 1985 (HC2).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from numpy.polynomial.hermite_e import hermevander

from springpot.machine.arrays import Floats

SETS = (1, 1.0), (2, 0.5), (2, 1.0), (3, 0.75), (3, 1.0), (4, 0.5)
"""Degrees and norms of the sets of polynomials that are tried."""
_DRAWS_A_TERM = 4
_MOST_TURNS, _FARTHEST = 60, 60.0  # of a logarithm of a probability, and how far it may lie from that of the mean
_RIDGE = 1e-3
_TURNS = 6  # of the weights of a logarithmic surface, which converge quickly

Powers = npt.NDArray[np.int64]


@lru_cache(maxsize=64)
def powers_of(inputs: int, degree: int, norm: float) -> Powers:
    """The powers of the polynomials of a set, the constant first, shape (terms, inputs).

    Examples
    --------
    >>> [len(powers_of(5, degree, norm)) for degree, norm in SETS]
    [6, 11, 21, 26, 56, 31]
    """
    found = [np.zeros(inputs, np.int64)]
    for total in range(1, degree + 1):
        for places in itertools.combinations_with_replacement(range(inputs), total):
            own = np.bincount(places, minlength=inputs)
            if (own.astype(float) ** norm).sum() ** (1.0 / norm) <= degree + 1e-9:
                found.append(own)
    return np.array(found)


def polynomials(scores: Floats, normal: Sequence[bool], powers: Powers) -> Floats:
    """Their values, shape (draws, terms).

    Parameters
    ----------
    scores : ndarray, shape (draws, inputs)
    normal : sequence of bool
        Of each input whether its scores are normal; otherwise they are uniform.
    powers : ndarray, shape (terms, inputs)
    """
    whole = np.ones((len(scores), len(powers)))
    for column, is_normal, own in zip(scores.T, normal, powers.T, strict=True):
        most = int(own.max(initial=0))
        alone = _hermite(column, most) if is_normal else _legendre(column, most)
        whole *= alone[:, own]
    return whole


def _legendre(u: Floats, most: int) -> Floats:
    x, found = 2.0 * u - 1.0, [np.ones(u.size), 2.0 * u - 1.0]
    for n in range(1, most):
        found.append(((2 * n + 1) * x * found[n] - n * found[n - 1]) / (n + 1))
    return np.stack([math.sqrt(2 * n + 1) * each for n, each in enumerate(found[: most + 1])], axis=1)


def _hermite(z: Floats, most: int) -> Floats:
    return np.asarray(hermevander(z, most) / np.sqrt([math.factorial(n) for n in range(most + 1)]))


@dataclass(frozen=True, eq=False)
class Surface:
    """A polynomial through the means of draws.

    Attributes
    ----------
    powers : ndarray, shape (terms, inputs)
    coefficients, noise : ndarray, shape (terms,)
        And the variances that they have from the paths.
    left : float
        Variance that the surface leaves, without that of the paths; it may be below 0 by chance.
    unlikely : float
        Mean square of what it misses at a draw that is left out.
    """

    powers: Powers
    coefficients: Floats
    noise: Floats
    left: float
    unlikely: float

    @property
    def squares(self) -> Floats:
        """Of the coefficients but the first, without noise."""
        return np.asarray(self.coefficients[1:] ** 2 - self.noise[1:])

    @property
    def variance(self) -> float:
        """Of the result from device to device."""
        return float(self.squares.sum()) + self.left

    def indices(self, groups: Sequence[Sequence[int]]) -> tuple[Floats, Floats]:
        """First-order and total Sobol indices of groups of inputs."""
        touched = self.powers[1:] > 0
        alone, total = [], []
        for group in groups:
            own = touched[:, list(group)].any(axis=1)
            others = np.delete(touched, list(group), axis=1).any(axis=1)
            alone.append(float(self.squares[own & ~others].sum()))
            total.append(float(self.squares[own].sum()))
        return np.array(alone) / self.variance, np.array(total) / self.variance


def surface_of(scores: Floats, normal: Sequence[bool], means: Floats, noise: Floats) -> Surface:
    """The surface that misses least of draws that are left out.

    Parameters
    ----------
    scores : ndarray, shape (draws, inputs)
    normal : sequence of bool
    means : ndarray, shape (draws,)
        Of the paths of each draw.
    noise : ndarray, shape (draws,)
        Variances of these means.
    """
    found = [_fitted(polynomials(scores, normal, own), own, means, noise) for own in _tried(scores)]
    return min(found, key=lambda each: each.unlikely)


def logarithmic_surface_of(scores: Floats, normal: Sequence[bool], means: Floats, noise: Floats) -> Surface:
    """The same of the logarithm of a result that is not negative, by quasi-likelihood: errors are a share of it.

    What it misses of draws that are left out is in the units of the result.
    """
    whole, found = math.log(float(means.mean())), list[Surface]()
    for own in _tried(scores):
        terms = polynomials(scores, normal, own)
        inverse, line = _inverse(terms), np.full(means.size, whole)
        for _ in range(_TURNS):
            line = np.clip(terms @ (inverse @ (line + means * np.exp(-line) - 1.0)), whole - 20.0, whole + 20.0)
        size = np.exp(line)
        surface, share = _fitted(terms, own, line + means / size - 1.0, noise / size**2), _share_left(terms, inverse)
        left_out = line - (means / size - 1.0) * (1.0 - share) / share
        missed = means - np.exp(np.clip(left_out, whole - 20.0, whole + 20.0))
        found.append(replace(surface, unlikely=float((missed**2).mean())))
    return min(found, key=lambda each: each.unlikely)


def probability_surface(terms: Floats, values: Floats) -> Floats:
    """Coefficients of the logarithm of a mean, from values most of which are 0: the likelihood of Poisson's law.

    Parameters
    ----------
    terms : ndarray, shape (draws, terms)
        The constant first.
    values : ndarray, shape (draws,)
        Not negative, and about 1 on average.
    """

    def missed(found: Floats) -> float:
        return surface_missed(terms, values, found) + _RIDGE * float((found[1:] ** 2).sum())

    found, penalty = np.zeros(terms.shape[1]), np.diag([0.0, *[2.0 * _RIDGE] * (terms.shape[1] - 1)])
    found[0] = math.log(float(values.mean()))
    best = missed(found)
    for _ in range(_MOST_TURNS):
        mean = np.exp(np.clip(terms @ found, -_FARTHEST, _FARTHEST))
        slope = terms.T @ (mean - values) + penalty @ found
        step = np.linalg.solve((terms.T * mean) @ terms + penalty + 1e-12 * mean.sum() * np.eye(found.size), slope)
        share = 1.0
        while (now := missed(found - share * step)) > best and share > 1e-3:
            share *= 0.5
        if not now < best - 1e-10 * abs(best):
            break
        found, best = found - share * step, now
    return found


def surface_missed(terms: Floats, values: Floats, coefficients: Floats) -> float:
    """By how much Poisson's law with such a logarithm of its mean misses values, up to a constant: -ln L."""
    line = np.clip(terms @ coefficients, -_FARTHEST, _FARTHEST)
    return float((np.exp(line) - values * line).sum())


def _inverse(terms: Floats) -> Floats:
    """By which least squares take the coefficients from values at the draws."""
    basis, triangle = np.linalg.qr(terms)
    return np.asarray(np.linalg.solve(triangle, basis.T))


def _share_left(terms: Floats, inverse: Floats) -> Floats:
    """What of an error at each draw the surface does not follow."""
    return np.asarray(1.0 - np.minimum(np.einsum("pk,kp->p", terms, inverse), 1.0 - 1e-9))


def _tried(scores: Floats) -> list[Powers]:
    """With as few terms as the draws can tell; the constant and straight lines in any case."""
    draws, inputs = scores.shape
    found = [powers_of(inputs, *own) for own in SETS]
    return [own for n, own in enumerate(found) if n == 0 or len(own) <= draws // _DRAWS_A_TERM]


def _fitted(terms: Floats, powers: Powers, means: Floats, noise: Floats) -> Surface:
    inverse = _inverse(terms)
    coefficients = inverse @ means
    missed, share = means - terms @ coefficients, _share_left(terms, inverse)
    left = float((missed**2).sum() - (share * noise).sum()) / max(means.size - len(powers), 1)
    return Surface(
        powers, coefficients, np.asarray(inverse**2 @ (missed**2 / share)), left,
        float(((missed / share) ** 2).mean()),
    )  # fmt: skip
