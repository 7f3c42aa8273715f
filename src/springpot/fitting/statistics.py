"""Measured stationary numbers of a motion, with their errors: frozen, checked when they are made, in SI units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.fitting.columns import Measured, PointFault, fixed
from springpot.machine.arguments import LARGEST, finite_number, numbers_in_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown
from springpot.problem.parts.checks import put

MOST_STATISTICS = 1000

QUANTILE = re.compile(r"((?:\w+_)?(?:x|v|amplitude|elongation|impact_speed))_quantile_(0\.\d+)")
"""The name of a quantile: of what, and its probability."""

_POSITIVE = re.compile(
    r".*(mean_square|_rms|standard_deviation|_rate|impact_speed_mean|(impact_speed|amplitude)_quantile_.*)"
)
_EXAMPLE = "impact_rate=(1.7, 0.03)"


class _StatisticFault(PointFault):
    """One statistic is not right; it has a name, so its place is not in the sentence."""

    def __init__(self, name: str, place: int, sentence: str) -> None:
        super().__init__(name, place, sentence)
        self.args = (sentence,)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class MeasuredStatistics(Measured):
    """Stationary numbers of a motion that were measured, such as a mean square or an impact rate.

    Parameters
    ----------
    correlation : array_like, shape (n, n), optional
        Of the errors, in the order of the statistics; independent if it is not given.  Numbers from one record are
        correlated: the mean square of x with that of v, the impact rate with the mean of x.
    **measured : (value, error)
        Each statistic by the name that a result of `springpot.simulate` has (``x_mean``, ``x_mean_square``,
        ``v_mean_square``, ``impact_rate``, ``impact_speed_mean``, ``<wall>_impact_rate``, ``<wall>_power``, of several
        masses ``<point>_x_mean_square``, ...), with its standard error, in SI units.  Besides: ``x_rms``, ``v_rms``,
        ``impact_speed_rms``, ``<point>_x_rms``, ... (roots of mean squares), ``x_standard_deviation``,
        and ``x_quantile``, ``v_quantile``, ``amplitude_quantile``, ``impact_speed_quantile`` as
        ``{probability: (value, error)}``.

    Attributes
    ----------
    names : tuple of str
        A quantile of probability 0.9 has the name ``x_quantile_0.9``.
    values, errors : ndarray, shape (n,)
    correlation : ndarray, shape (n, n)

    Raises
    ------
    TypeError, ValueError
        If a statistic is no pair of numbers, an error is not positive, a number is out of its range, or the correlation
        is none.

    Examples
    --------
    >>> speed = {0.9: (0.41, 0.01)}
    >>> found = MeasuredStatistics(x_rms=(2.4e-3, 3e-5), impact_rate=(1.7, 0.03), impact_speed_quantile=speed)
    >>> found.names
    ('x_rms', 'impact_rate', 'impact_speed_quantile_0.9')
    """

    names: tuple[str, ...]
    values: Floats
    errors: Floats
    correlation: Floats

    def __init__(self, *, correlation: Any = None, **measured: Any) -> None:
        self._fill({name: pair for given in measured.items() for name, pair in _named(*given)}, correlation)

    @classmethod
    def of(cls, pairs: Mapping[str, Any], correlation: Any = None) -> MeasuredStatistics:
        """From whole names, those of quantiles included.

        Parameters
        ----------
        pairs : mapping
            ``(value, error)`` for each name.
        correlation : array_like, optional

        Examples
        --------
        >>> MeasuredStatistics.of({"x_quantile_0.9": (2e-3, 1e-5)}).names
        ('x_quantile_0.9',)
        """
        made = cls.__new__(cls)
        made._fill(pairs, correlation)
        return made

    def _fill(self, pairs: Mapping[str, Any], correlation: Any) -> None:
        if not pairs:
            raise ValueError(f"MeasuredStatistics must have at least one statistic, such as {_EXAMPLE}.")
        if len(pairs) > MOST_STATISTICS:
            raise ValueError(f"MeasuredStatistics must have at most {MOST_STATISTICS:,} statistics.")
        numbers = [_pair(place, name, pair) for place, (name, pair) in enumerate(pairs.items())]
        values, errors = np.array(numbers).T
        put(self, names=tuple(pairs), values=fixed(values), errors=fixed(errors))
        put(self, correlation=fixed(_correlation(correlation, self.names)))

    @property
    def size(self) -> int:
        """Number of statistics."""
        return len(self.names)

    @property
    def covariance(self) -> Floats:
        """Of the errors, shape (n, n)."""
        return np.asarray(self.correlation * np.outer(self.errors, self.errors))


def _named(name: str, given: Any) -> list[tuple[str, Any]]:
    """One statistic, or several quantiles, by their whole names."""
    if not QUANTILE.fullmatch(f"{name}_0.5"):
        return [(name, given)]
    if not isinstance(given, dict) or not given:
        raise TypeError(f"{name} must be a dict such as {{0.9: (0.41, 0.01)}}, not {shown(given)}.")
    found = []
    for probability, pair in given.items():
        p = finite_number(probability, f"the probability of {name}", low=1e-4, high=1.0 - 1e-4)
        found.append((f"{name}_{format(round(p, 6), 'f').rstrip('0')}", pair))
    return found


def _pair(place: int, name: str, pair: Any) -> tuple[float, float]:
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise TypeError(f"{name} must be a pair (value, error), as {_EXAMPLE}, not {shown(pair)}.")
    try:
        value = finite_number(pair[0], name, low=-LARGEST, high=LARGEST)
        error = finite_number(pair[1], f"the error of {name}", low=0.0, high=LARGEST, open_low=True)
    except ValueError as fault:
        raise _StatisticFault(name, place, str(fault)) from None
    if _POSITIVE.fullmatch(name) and not value > 0.0:
        raise _StatisticFault(name, place, f"{name} must be greater than 0, not {value:g}.")
    return float(value), float(error)


def _correlation(given: Any, names: tuple[str, ...]) -> Floats:
    count = len(names)
    if given is None:
        return np.eye(count)
    found = numbers_in_array(given, "correlation must be numbers in rows")
    if found.shape != (count, count):
        raise ValueError(f"correlation must have {count} rows of {count} numbers, one for each statistic, not "
                         f"the shape {found.shape}.")  # fmt: skip
    if not np.isfinite(found).all() or not np.allclose(found, found.T, atol=1e-9) or (np.diag(found) != 1.0).any():
        raise ValueError("correlation must be symmetric, with 1 on its diagonal.")
    if not np.linalg.eigvalsh(found)[0] > 1e-9:
        raise ValueError("correlation must be positive definite: some statistics follow from the others exactly.")
    return found
