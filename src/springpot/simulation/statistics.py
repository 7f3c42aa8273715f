"""Means of independent paths and their standard errors.

Paths are independent, so the standard error of a mean over paths of time averages is the spread between paths over
sqrt(paths), whatever the correlation within one path.  Ratios (impact speeds) use the linearised spread of
numerator minus ratio times denominator.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

__all__ = ["controlled", "ratio", "residual", "standard_error"]

Floats = npt.NDArray[np.float64]


def residual(out: Floats, fed: float, held: Floats) -> Floats:
    """1 - out / fed; without noise, what came out of nowhere over what was there at first (NaN if nothing was)."""
    if fed > 0.0:
        return 1.0 - out / fed
    return np.divide(-out, held, out=np.full_like(out, np.nan), where=held > 0.0)


def ratio(above: Floats, below: Floats) -> tuple[float, Floats]:
    """Ratio of two sums over the paths, and samples whose mean it is; NaN where the lower sum is 0."""
    if not below.sum() > 0.0:
        return math.nan, np.full_like(above, np.nan)
    value = float(above.sum() / below.sum())
    return value, value + (above - value * below) / float(below.mean())


def standard_error(samples: Floats) -> float:
    """Standard error of the mean of independent samples; NaN for a single one."""
    return float(samples.std(ddof=1) / math.sqrt(samples.size)) if samples.size > 1 else math.nan


def controlled(samples: Floats, controls: Floats) -> Floats:
    """Samples less their regression on controls of mean zero; their mean stays what it is expected to be.

    Examples
    --------
    >>> control = np.array([[1.0], [-2.0], [4.0]])
    >>> controlled(3.0 + 2.0 * control[:, 0], control).round(12)
    array([3., 3., 3.])
    """
    if not np.isfinite(samples).all():
        return samples
    apart = controls - controls.mean(axis=0)
    slopes = np.linalg.lstsq(apart, samples - samples.mean(), rcond=None)[0]
    return np.asarray(samples - controls @ slopes)
