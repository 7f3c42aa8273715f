"""What a sampler needs of a fit: the likelihood at any numbers, a prior, and where its chains start."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from springpot.fitting.likelihood import Coordinates, Likelihood
from springpot.machine.arguments import real_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, listed, shown

_TRIES = 1000  # of a draw, to fall between the bounds


def numbers_in(own: Coordinates, given: ArrayLike | Mapping[str, float]) -> Floats:
    """Numbers in the order of their names.

    Raises
    ------
    TypeError, ValueError
        If they are not as many numbers, or have other names.

    Examples
    --------
    >>> from springpot.machine.arguments import Free
    >>> numbers_in(Coordinates((Free(1.0, "C", 0.1, 10.0), Free(0.0, "b", -1.0, 1.0))), {"b": 0.5, "C": 2.0}).tolist()
    [2.0, 0.5]
    """
    if isinstance(given, Mapping):
        if set(given) != set(own.names):
            raise ValueError(f"numbers must have a value for each of {listed(own.names)}, not {shown(dict(given))}.")
        given = [given[name] for name in own.names]
    found = real_array(given, "numbers")
    if found.shape != (len(own.names),):
        raise ValueError(f"numbers must be {len(own.names)}, {listed(own.names)}, not of the shape {found.shape}.")
    return found


def log_likelihood(likelihood: Likelihood, numbers: Floats) -> float:
    """Logarithm of the likelihood; -inf beyond the bounds, and where the model cannot be.

    Raises
    ------
    NotCoveredError
        If the data are simulated statistics.
    """
    if likelihood.is_local:
        raise NotCoveredError(
            "a fit to MeasuredStatistics has no likelihood for a sampler: it knows simulated results near its solution "
            "alone; use its errors and correlations."
        )
    if not math.isfinite(log_prior(likelihood.coordinates, numbers)):
        return -math.inf
    try:
        found = -0.5 * likelihood.whole(likelihood.deviance(numbers))
    except ValueError:
        return -math.inf
    return found if math.isfinite(found) else -math.inf


def log_prior(own: Coordinates, numbers: Floats) -> float:
    """Logarithm of the density that is flat between the bounds: in the logarithm of numbers with positive bounds.

    Examples
    --------
    >>> from springpot.machine.arguments import Free
    >>> own = Coordinates((Free(1.0, "C", 1.0, math.e), Free(0.0, "b", 0.0, 1.0)))
    >>> log_prior(own, np.array([2.0, 0.5])) == -math.log(2.0), log_prior(own, np.array([2.0, 1.5]))
    (True, -inf)
    """
    low, high = ([getattr(number, end) for number in own.free] for end in ("low", "high"))
    if not ((numbers >= low) & (numbers <= high)).all():
        return -math.inf
    return -float(np.log(own.high - own.low).sum() + np.log(own.slope(numbers)).sum())


def start_ensemble(own: Coordinates, u: Floats, covariance: Floats, walkers: int, seed: int) -> Floats:
    """Numbers drawn from the normal law of a fit, between the bounds: shape (walkers, numbers).

    ``covariance`` is of the coordinates; what has no error there gets one of a twentieth of its range.
    """
    wide = 0.05 * (own.high - own.low)
    known = np.isfinite(np.diag(covariance)) & (np.diag(covariance) > 0.0)
    whole = np.diag(wide**2)
    whole[np.ix_(known, known)] = covariance[np.ix_(known, known)]
    values, vectors = np.linalg.eigh(whole)
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T  # symmetric: it has no signs to be chosen
    rng, found = np.random.default_rng(seed), []
    for _ in range(walkers):
        for _ in range(_TRIES):
            draw = u + root @ rng.standard_normal(u.size)
            if ((draw > own.low) & (draw < own.high)).all():
                break
        else:  # a law far wider than the bounds
            draw = own.low + rng.random(u.size) * (own.high - own.low)
        found.append(own.outer(draw))
    return np.array(found)
