"""What differs from device to device, from some paths of each: mean, scatter, quantiles and Sobol indices, with errors.

All intervals are by a jackknife over independent scramblings of Sobol's sequence, with everything made again without
each of them.  The variance of the paths of one device is taken out everywhere, by what they differ among themselves.

The formulas and how well they cover are those of this module's tests: an oscillator with exact results.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from springpot.machine.arrays import Floats
from springpot.scattering.surface import Surface, logarithmic_surface_of, polynomials, surface_of

SCRAMBLINGS = 16
SHARES = 0.05, 0.5, 0.95
BELOW = 0.99  # share of the devices of a tolerance
PREDICTED = 4096
_ROUNDED = 1e-10  # of a result: what devices that are alike may differ by


@dataclass(frozen=True)
class Interval:
    """A number with its standard error and the ends of its 95 % interval.

    Attributes
    ----------
    value, error, low, high : float
    """

    value: float
    error: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Means:
    """The paths of all devices, as far as the estimates need them.

    Attributes
    ----------
    scores : ndarray, shape (draws, inputs)
    normal : tuple of bool
    values : ndarray, shape (draws, paths)
        A result of each path.
    new : ndarray, shape (devices, inputs)
        Scores of other devices, which surfaces are asked of.
    beside : ndarray, shape (devices,)
        Normal scores of what surfaces leave in them.
    logarithmic : bool, optional
        Whether the logarithm has the surface that quantiles come from; if not given, that which misses less.
    """

    scores: Floats
    normal: tuple[bool, ...]
    values: Floats
    new: Floats
    beside: Floats
    logarithmic: bool | None = None

    def without(self, scrambling: int) -> Means:
        """Without one scrambling; neighbouring draws are of one.  Its surfaces are of the same kind."""
        kept = np.arange(len(self.values)) // (len(self.values) // SCRAMBLINGS) != scrambling
        return replace(
            self, scores=self.scores[kept], values=self.values[kept], logarithmic=self.of_logarithm is not None
        )

    @cached_property
    def means(self) -> Floats:
        """Of each device."""
        return np.asarray(self.values.mean(axis=1))

    @cached_property
    def noise(self) -> Floats:
        """Variances of these means; none of exact results, of which each device has one."""
        paths = self.values.shape[1]
        return np.asarray(self.values.var(axis=1, ddof=1) / paths if paths > 1 else np.zeros(len(self.values)))

    @cached_property
    def surface(self) -> Surface:
        """Of the means."""
        return surface_of(self.scores, self.normal, self.means, self.noise)

    @cached_property
    def of_logarithm(self) -> Surface | None:
        """Of the logarithm of the means, where they are not negative and it misses less."""
        if self.logarithmic is False or not self.is_positive or not self.means.any():
            return None
        found = logarithmic_surface_of(self.scores, self.normal, self.means, self.noise)
        return found if self.logarithmic or found.unlikely < self.surface.unlikely else None

    @property
    def unexplained(self) -> float:
        """Share of the variance between devices that the surface leaves."""
        return self.surface.left / self.surface.variance if self.surface.variance > 0.0 else math.nan

    @cached_property
    def of_devices(self) -> Floats:
        """The results of many devices, without paths: for quantiles and limits, in ascending order."""
        mean, surface = float(self.means.mean()), self.of_logarithm or self.surface
        line = polynomials(self.new, self.normal, surface.powers) @ surface.coefficients
        square = float((surface.coefficients[1:] ** 2).sum())
        known = math.sqrt(min(max(float(surface.squares.sum()), 0.0) / square, 1.0)) if square > 0.0 else 0.0
        away = known * (line - line.mean()) + math.sqrt(max(surface.left, 0.0)) * self.beside
        if self.of_logarithm is not None:
            found = np.exp(away)
            return np.sort(mean * found / found.mean())
        spread, wanted = float(away.std()), math.sqrt(max(surface.variance, 0.0))
        found = np.sort(mean + (wanted / spread if spread > 0.0 else 0.0) * away)
        return np.maximum(found, 0.0) if self.is_positive else found

    @property
    def is_positive(self) -> bool:
        """Whether no device has a result below 0."""
        return not (self.means < 0.0).any()

    @property
    def is_seen(self) -> bool:
        """Whether the devices differ by more than their paths explain, with 95 %, and than rounding."""
        from scipy.special import fdtri

        draws, paths = self.values.shape
        between, within = float(self.means.var(ddof=1)), float(self.noise.mean())
        if math.sqrt(between) <= _ROUNDED * float(np.abs(self.means).max()):
            return False
        return not within > 0.0 or between / within > float(fdtri(draws - 1, draws * (paths - 1), 0.95))


@dataclass(frozen=True, eq=False)
class Estimates:
    """What is known of a result over all devices.

    Attributes
    ----------
    mean : Interval
    scatter : Interval
        Standard deviation from device to device; its value is 0 where it is not seen, and ``high`` bounds it.
    path_scatter : float
        Standard deviation from path to path of one device.
    quantiles : dict of Interval
        Below which these shares of the devices are.
    tolerance : float
        Below which 99 % of the devices are, 95 % sure.
    alone, together : dict of Interval
        First-order and total Sobol indices, by the names of the inputs; empty where no scatter is seen.
    unexplained : Interval
        Share of the variance that the surface leaves; it may be below 0 by chance.
    above : dict of Interval
        Shares of the devices above limits.
    of_devices : ndarray
        Results of many devices by the surface, in ascending order.
    """

    mean: Interval
    scatter: Interval
    path_scatter: float
    quantiles: dict[float, Interval]
    tolerance: float
    alone: dict[str, Interval]
    together: dict[str, Interval]
    unexplained: Interval
    above: dict[float, Interval]
    of_devices: Floats


def estimated(
    means: Means, names: Sequence[str], groups: Sequence[Sequence[int]], limits: Sequence[float],
    shares: Sequence[float] = SHARES,
) -> Estimates:  # fmt: skip
    """All of them.

    Parameters
    ----------
    means : Means
    names : sequence of str
        Of the groups of inputs.
    groups : sequence of sequence of int
    limits, shares : sequence of float
    """
    parts = [means.without(number) for number in range(SCRAMBLINGS)]

    def interval(of: Callable[[Means], float], *, logarithmic: bool = False) -> Interval:
        return jackknifed(of(means), np.array([of(part) for part in parts]), logarithmic)

    def below(share: float) -> Interval:
        logarithmic = means.of_logarithm is not None
        found = interval(lambda own: float(np.quantile(own.of_devices, share)), logarithmic=logarithmic)
        return replace(found, low=max(found.low, 0.0)) if means.is_positive else found

    def beyond(limit: float) -> Interval:
        found = interval(lambda own: float((own.of_devices > limit).mean()))
        if found.value in (0.0, 1.0):  # of none, or all, of so many devices: three of them could be beyond by chance
            bound = 3.0 / len(means.means)
            return replace(found, low=max(found.value - bound, 0.0), high=min(found.value + bound, 1.0))
        return replace(found, low=max(found.low, 0.0), high=min(found.high, 1.0))

    mean = interval(lambda own: float(own.means.mean()))
    paths = float(means.noise.mean()) * means.values.shape[1]
    quantiles, top = {share: below(share) for share in shares}, below(BELOW)
    above = {limit: beyond(limit) for limit in limits}
    alone, together = dict[str, Interval](), dict[str, Interval]()
    if not means.is_seen:
        scatter, unexplained = _unseen(means), Interval(math.nan, math.nan, math.nan, math.nan)
    else:
        scatter = interval(lambda own: math.sqrt(max(own.surface.variance, 0.0)), logarithmic=True)
        unexplained = interval(lambda own: own.unexplained)
        alone, together = indices_of([own.surface for own in (means, *parts)], names, groups)
    return Estimates(
        mean=mean, scatter=scatter, path_scatter=math.sqrt(paths), quantiles=quantiles,
        tolerance=top.value + one_sided(SCRAMBLINGS, 0.95) * top.error, alone=alone, together=together,
        unexplained=unexplained, above=above, of_devices=means.of_devices,
    )  # fmt: skip


def indices_of(
    surfaces: Sequence[Surface], names: Sequence[str], groups: Sequence[Sequence[int]]
) -> tuple[dict[str, Interval], dict[str, Interval]]:
    """First-order and total Sobol indices of groups of inputs, by their names.

    The first surface is of all data, the others are without each of some independent parts of them.
    """
    found = np.array([each.indices(groups) for each in surfaces])  # (surfaces, 2, groups)
    alone, together = (
        {name: jackknifed(float(own[0]), own[1:]) for name, own in zip(names, kind.T, strict=True)}
        for kind in (found[:, 0], found[:, 1])
    )
    return alone, together


def _unseen(means: Means) -> Interval:
    """Of a scatter that is not seen: 0, with a bound by the analysis of variance."""
    from scipy.special import fdtri

    draws, paths = means.values.shape
    between, within = float(means.means.var(ddof=1)), float(means.noise.mean())
    if not within > 0.0:
        return Interval(0.0, math.nan, 0.0, math.sqrt(between))
    bound = within * max(between / within / float(fdtri(draws - 1, draws * (paths - 1), 0.05)) - 1.0, 0.0)
    return Interval(0.0, math.nan, 0.0, math.sqrt(bound))


def jackknifed(value: float, others: Floats, logarithmic: bool = False) -> Interval:
    """An estimate with its interval; ``others`` are those without each of so many independent parts of the data."""
    if logarithmic and (others > 0.0).all() and value > 0.0:
        own = jackknifed(math.log(value), np.log(others))
        return Interval(value, value * own.error, math.exp(own.low), math.exp(own.high))
    count = others.size
    error = math.sqrt((count - 1) / count * float(((others - others.mean()) ** 2).sum()))
    wide = error * one_sided(count, 0.975)
    return Interval(value, error, value - wide, value + wide)


def one_sided(count: int, share: float) -> float:
    """A bound in standard errors that holds with this share, of an estimate from so many independent parts."""
    from scipy.special import stdtrit

    return float(stdtrit(count - 1, share))
