"""Means of independent paths and their standard errors.

The standard error of a mean over paths of time averages is their standard deviation over sqrt(paths), whatever the
correlation within a path.  Ratios (impact speeds) are linearized: numerator minus ratio times denominator.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats

NORMAL = 1.959964  # half-width of a 95 % interval, in standard errors
DOUBTFUL = 4.0  # standard errors from 0 at which the mean of a control variate is not 0
PATHS_A_CONTROL = 10
_FEWEST_LOGARITHMS, _MOST_SPREAD = 3, 50.0
UPPER = 3.0  # events that are expected at most, with a probability of 95 %, if none is seen: exp(-3) = 0.05


def residual(out: Floats, supplied: float, initial: Floats) -> Floats:
    """1 - out / supplied; without supply, -out over the initial energy of each path (NaN if that is 0)."""
    if supplied > 0.0:
        return 1.0 - out / supplied
    return np.divide(-out, initial, out=np.full_like(out, np.nan), where=initial > 0.0)


def ratio(above: Floats, below: Floats) -> tuple[float, Floats]:
    """Ratio of two sums over the paths, and linearized samples with this mean; NaN if the lower sum is 0."""
    if not below.sum() > 0.0:
        return math.nan, np.full_like(above, np.nan)
    value = float(above.sum() / below.sum())
    return value, value + (above - value * below) / float(below.mean())


def standard_error(samples: Floats, fitted: int = 0, strata: int = 1) -> float:
    """Standard error of the mean of independent samples; NaN for a single one.

    ``strata``: sample n is of the stratum n modulo this.  Strata have equal shares, and how they differ is no error;
    with fewer than two samples of each it counts as one.

    ``fitted``: the number of control variates.  Each counts twice: their regression takes out spread by chance, and its
    slopes have errors.
    """
    with np.errstate(invalid="ignore", over="ignore"):  # of a user's function that is infinite the error is NaN
        if strata > 1 and samples.size >= 2 * strata:
            own = [samples[n::strata] for n in range(strata)]
            return math.sqrt(math.fsum(each.size * each.var(ddof=1) for each in own)) / samples.size
        lost = 1 + 2 * fitted
        return float(samples.std(ddof=lost) / math.sqrt(samples.size)) if samples.size > lost else math.nan


def spread_by_logarithms(samples: Floats) -> float:
    """Standard deviation over the mean of the law whose logarithms are normal with the spread of those of the samples;
    some are 0 with the share of those that are.

    Few samples of a skew law seldom have the large ones that make most of its spread: theirs is then too small, and
    this one is not.  With fewer than three samples above 0 it is 0.

    Examples
    --------
    >>> samples = np.exp(np.random.default_rng(1).normal(size=32))  # 1.31 of their law
    >>> round(float(samples.std() / samples.mean()), 2), round(spread_by_logarithms(samples), 2)
    (1.04, 1.16)
    """
    positive = samples[samples > 0.0]
    if positive.size < _FEWEST_LOGARITHMS:
        return 0.0
    square = math.exp(min(float(np.log(positive).var(ddof=1)), _MOST_SPREAD))
    return math.sqrt(max(square * samples.size / positive.size - 1.0, 0.0))


def controlled(samples: Floats, controls: Floats) -> Floats:
    """Samples less their regression on control variates of mean zero, so that the expected mean does not change.

    Parameters
    ----------
    samples : ndarray, shape (paths,)
    controls : ndarray, shape (paths, controls)
        One that does not vary is left out.

    Examples
    --------
    >>> control = np.array([[1.0], [-2.0], [4.0]])
    >>> controlled(3.0 + 2.0 * control[:, 0], control).round(12)
    array([3., 3., 3.])
    """
    spread = controls.std(axis=0) if controls.size else np.zeros(0)
    if not np.isfinite(samples).all() or not (spread > 0.0).any():
        return samples
    kept = controls[:, spread > 0.0] / spread[spread > 0.0]
    apart = kept - kept.mean(axis=0)
    # sums in NumPy's own order: those of a linear algebra library depend on its number of threads
    squares = np.einsum("ij,ik->jk", apart, apart)
    slopes = np.linalg.lstsq(squares, np.einsum("ij,i->j", apart, samples - samples.mean()), rcond=1e-12)[0]
    return np.asarray(samples - np.einsum("ij,j->i", kept, slopes))


def without_doubtful(controls: Floats) -> Floats:
    """Those of some control variates whose mean is 0 as far as the paths tell; none of so few paths that none does.

    Parameters
    ----------
    controls : ndarray, shape (paths, controls)

    Examples
    --------
    >>> gains = np.random.default_rng(0).normal([0.0, 1.0], 1.0, (100, 2))
    >>> without_doubtful(gains).shape, without_doubtful(gains[:15]).shape
    ((100, 1), (15, 0))
    """
    paths, count = controls.shape
    if paths < PATHS_A_CONTROL * count:
        return controls[:, :0]
    error = controls.std(axis=0, ddof=1) / math.sqrt(paths) if paths > 1 else np.full(count, np.nan)
    return controls[:, ~(np.abs(controls.mean(axis=0)) > DOUBTFUL * error)]


def error_of_unseen(time: float) -> float:
    """The error of the rate of events of which none was seen in this time: 1.96 of it are the bound 3 / time.

    Examples
    --------
    >>> round(1.959964 * error_of_unseen(2000.0), 6)
    0.0015
    """
    return UPPER / (NORMAL * time)


def poisson_interval(count: int) -> tuple[float, float]:
    """The 95 % interval of the mean of a number that follows Poisson's law (F. Garwood, Biometrika 28, 1936).

    If there is none, an upper bound.

    Examples
    --------
    >>> [round(end, 3) for end in poisson_interval(3)], poisson_interval(0)
    ([0.619, 8.767], (0.0, 3.0))
    """
    if not count:
        return 0.0, UPPER
    from scipy.special import gammaincinv  # most runs need none of it

    return float(gammaincinv(count, 0.025)), float(gammaincinv(count + 1, 0.975))


def binomial_interval(count: npt.ArrayLike, number: int) -> tuple[Floats, Floats]:
    """The 95 % intervals of probabilities, from counts in a number of trials (Clopper, Pearson, Biometrika 26, 1934).

    If none or all are counted, a bound.

    Examples
    --------
    >>> low, high = binomial_interval([0, 5, 100], 100)
    >>> low.round(3), high.round(3)
    (array([0.   , 0.016, 0.97 ]), array([0.03 , 0.113, 1.   ]))
    """
    from scipy.special import betaincinv  # most runs need none of it

    k = np.asarray(count, dtype=float)
    bound = math.exp(-UPPER / number)  # of all, if all are counted
    low = np.where(k >= number, bound, betaincinv(np.maximum(k, 1.0), number - np.maximum(k, 1.0) + 1.0, 0.025))
    high = betaincinv(np.minimum(k, number - 1.0) + 1.0, number - np.minimum(k, number - 1.0), 0.975)
    return np.where(k > 0.0, low, 0.0), np.where(k <= 0.0, 1.0 - bound, np.where(k >= number, 1.0, high))
