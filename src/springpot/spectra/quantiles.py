"""Quantiles over records or paths, with intervals that hold for every distribution."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from springpot.machine.arrays import Floats

_CHANCE = 0.025  # on either side of a 95 % interval


def quantiles_of(values: Floats, shares: Sequence[float]) -> Floats:
    """Quantiles of the last axis, and the ends of their 95 % intervals, shape (3, shares, ...).

    The ends are values of the sample: how many of them lie below a quantile has a binomial law.  Where the sample is
    too small for an end it is 0 or infinite.

    Examples
    --------
    >>> quantiles_of(np.arange(1.0, 12.0), [0.5]).ravel().tolist()
    [6.0, 2.0, 10.0]
    >>> quantiles_of(np.array([1.0, 2.0]), [0.5]).ravel().tolist()
    [1.5, 0.0, inf]
    """
    from scipy.stats import binom  # slow to import

    count = values.shape[-1]
    ordered = np.concatenate(
        [np.zeros((*values.shape[:-1], 1)), np.sort(values, axis=-1), np.full((*values.shape[:-1], 1), math.inf)],
        axis=-1,
    )
    low = [int(binom.ppf(_CHANCE, count, share)) for share in shares]
    high = [int(binom.ppf(1.0 - _CHANCE, count, share)) + 1 for share in shares]
    middle = np.quantile(values, shares, axis=-1)
    return np.stack([middle, np.moveaxis(ordered[..., low], -1, 0), np.moveaxis(ordered[..., high], -1, 0)])
