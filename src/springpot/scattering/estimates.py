"""What differs from device to device, from some paths of each: mean, scatter, quantiles and Sobol indices, with errors.

All intervals are by a jackknife over independent scramblings of Sobol's sequence, with everything made again without
each of them.  The variance of the paths of one device is taken out everywhere, by what they differ among themselves.

The formulas and how well they cover are those of this module's tests: an oscillator with exact results.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from springpot.machine.arrays import Floats
from springpot.scattering.surface import Surface, logarithmic_surface_of, polynomials, surface_of

SCRAMBLINGS = 16
T_OF_15 = 2.131  # half-width of a 95 % interval in standard errors, of 16 values
_ONE_SIDED = 1.753  # the same of a bound
SHARES = 0.05, 0.5, 0.95
BELOW = 0.99  # share of the devices of a tolerance
PREDICTED = 4096


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
    new : ndarray, shape (draws, inputs)
        Scores at which surfaces are looked at, and in the last column normal ones of what they leave.
    """

    scores: Floats
    normal: tuple[bool, ...]
    values: Floats
    new: Floats

    def without(self, scrambling: int) -> Means:
        """Without one scrambling; neighbouring draws are of one."""
        kept = np.arange(len(self.values)) // (len(self.values) // SCRAMBLINGS) != scrambling
        return Means(self.scores[kept], self.normal, self.values[kept], self.new)

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
    def of_devices(self) -> Floats:
        """The results of many devices, without paths: for quantiles and limits, in ascending order."""
        mean, new = float(self.means.mean()), self.new[:, :-1]
        if (self.means >= 0.0).all() and mean > 0.0:
            surface = logarithmic_surface_of(self.scores, self.normal, self.means, self.noise)
            line = polynomials(new, self.normal, surface.powers) @ surface.coefficients
            square = float((surface.coefficients[1:] ** 2).sum())
            shrunk = math.sqrt(max(float(surface.squares.sum()), 0.0) / square) if square > 0.0 else 0.0
            line = shrunk * (line - line.mean()) + math.sqrt(max(surface.left, 0.0)) * self.new[:, -1]
            found = np.exp(line)
            return np.sort(mean * found / found.mean())
        surface = self.surface
        line = polynomials(new, self.normal, surface.powers) @ surface.coefficients
        spread = float(line.std())
        wider = math.sqrt(max(surface.variance, 0.0)) / spread if spread > 0.0 else 0.0
        return np.sort(mean + wider * (line - line.mean()))


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
    unexplained : float
        Share of the variance that the surface leaves.
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
    unexplained: float
    above: dict[float, Interval]
    of_devices: Floats


def estimated(
    means: Means, names: Sequence[str], groups: Sequence[Sequence[int]], limits: Sequence[float]
) -> Estimates:
    """All of them.

    Parameters
    ----------
    means : Means
    names : sequence of str
        Of the groups of inputs.
    groups : sequence of sequence of int
    limits : sequence of float
    """
    parts = [means.without(number) for number in range(SCRAMBLINGS)]

    def interval(of: Callable[[Means], float], *, logarithmic: bool = False) -> Interval:
        return _jackknifed(of(means), np.array([of(part) for part in parts]), logarithmic)

    def below(share: float) -> Interval:
        return interval(lambda own: float(np.quantile(own.of_devices, share)))

    def beyond(limit: float) -> Interval:
        return interval(lambda own: float((own.of_devices > limit).mean()))

    mean = interval(lambda own: float(own.means.mean()))
    paths = float(means.noise.mean()) * means.values.shape[1]
    quantiles, top = {share: below(share) for share in SHARES}, below(BELOW)
    above = {limit: beyond(limit) for limit in limits}
    scatter = _scatter(means, interval)
    alone, together = dict[str, Interval](), dict[str, Interval]()
    if scatter.value > 0.0:
        whole, left_out = means.surface.indices(groups), [part.surface.indices(groups) for part in parts]
        for kind, found in enumerate((alone, together)):
            for place, name in enumerate(names):
                found[name] = _jackknifed(
                    float(whole[kind][place]), np.array([each[kind][place] for each in left_out]), False
                )
    return Estimates(
        mean=mean, scatter=scatter, path_scatter=math.sqrt(paths), quantiles=quantiles,
        tolerance=top.value + _ONE_SIDED * top.error, alone=alone, together=together,
        unexplained=means.surface.left / means.surface.variance if scatter.value > 0.0 else math.nan, above=above,
        of_devices=means.of_devices,
    )  # fmt: skip


def _scatter(means: Means, interval: Callable[..., Interval]) -> Interval:
    """By the surface; where it is not seen, a bound by the analysis of variance."""
    if all(own.surface.variance > 0.0 for own in (means, *map(means.without, range(SCRAMBLINGS)))):
        return interval(lambda own: math.sqrt(own.surface.variance), logarithmic=True)
    from scipy.special import fdtri

    draws, paths = means.values.shape
    between, within = float(means.means.var(ddof=1)), float(means.noise.mean())
    if not within > 0.0:
        return Interval(math.sqrt(between), 0.0, math.sqrt(between), math.sqrt(between))
    bound = within * max(between / within / float(fdtri(draws - 1, draws * (paths - 1), 0.05)) - 1.0, 0.0)
    return Interval(0.0, math.nan, 0.0, math.sqrt(bound))


def _jackknifed(value: float, others: Floats, logarithmic: bool) -> Interval:
    if logarithmic and (others > 0.0).all() and value > 0.0:
        own = _jackknifed(math.log(value), np.log(others), False)
        return Interval(value, value * own.error, math.exp(own.low), math.exp(own.high))
    count = others.size
    error = math.sqrt((count - 1) / count * float(((others - others.mean()) ** 2).sum()))
    return Interval(value, error, value - T_OF_15 * error, value + T_OF_15 * error)
