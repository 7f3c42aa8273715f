"""Distributions of x, v, amplitude and impact speed, counted during the run, and their quantiles.

They are streaming sketches: counts in bins of 1/64 of an octave (Masson, Rim and Lee, "DDSketch", PVLDB 12, 2019, with
bins linear in each octave).  Bins of x begin at the wall.  The bins do not depend on the data, so counts of different
paths can be added in any order.  A quantile is interpolated in its bin, with a relative error below 0.1 % where the
density is smooth.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.machine.arguments import LARGEST, finite_number, real_array
from springpot.machine.arrays import Columns, Floats
from springpot.machine.faults import shown
from springpot.problem.catalogue import unit_of_result
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, beyond, bits_of, f32, i32, stack_array
from springpot.simulation.kernel.watching import HEADER, ON_IMPACTS, ON_STEPS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.forces import signals_of_forces
from springpot.simulation.watch.requested import Observed, Request

_PARTS = 64  # bins in an octave
_LOWEST, _HIGHEST = -24, 24  # octaves, in powers of two of the kernel's units, which are near the problem's scales
BINS = _PARTS * (_HIGHEST - _LOWEST) + 1  # of one sign; the first holds everything below the lowest octave
_OFFSET = (127 + _LOWEST) * _PARTS - 1
FEWEST_BEYOND = 4.0  # samples beyond a quantile, for a standard error of it
FEWEST_BATCHES = 10  # for a usable standard error
SAMPLING = 0.1  # between two samples of a sketch, in units of the shortest time scale
FINE = 0.01  # step over the fastest rate, of laws of the speeds of impacts, of which the slowest lack most

_LAYOUT = layout(x=2 * BINS, v=2 * BINS, amplitude=BINS, impact_speed=BINS)
_OF_FORCE = layout(x=2 * BINS)
_FREQUENCY, _WALL, _LANES, _X, _V, _AMPLITUDE, _SPEED = begins(
    _LAYOUT, "frequency", "wall", "lanes", "x", "v", "amplitude", "impact_speed"
)


@dataclass(frozen=True, eq=False)
class Sketch(Request):
    """The distributions that a displacement has by its names; of a force or an acceleration its own."""

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[Sketch]:
        if wishes["distributions"] is not True:
            raise TypeError(f"distributions must be True or False, not {shown(wishes['distributions'])}.")
        for signal in (*plan.motion.signals, *signals_of_forces(plan, wishes)):
            yield cls.of(signal, plan.motion, plan.settings)

    @classmethod
    def of(cls, signal: Signal, motion: Motion, settings: Settings) -> Sketch:
        """Of this one; samples are about ``SAMPLING`` of the shortest time scale apart."""
        every = max(1, int(SAMPLING / (GROUP * settings.step * motion.scales.fastest_rate)))
        on_steps, on_impacts = (_compiled_of_force(), None) if signal.outputs else _compiled()
        initial = np.zeros((), _OF_FORCE if signal.outputs else _LAYOUT)
        return cls((Observer(signal, on_steps, on_impacts, initial, of_batches=(*signal.names,), every=every),))

    @classmethod
    def longest_step(cls, motion: Motion, wishes: Mapping[str, Any]) -> float:
        return FINE / motion.scales.fastest_rate if motion.crowded else math.inf

    def in_full(self, settings: Settings) -> bool:
        return True

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        return {"distributions": self.distributions(simulation, ensemble.observed[self.observer])}

    def distributions(self, simulation: Simulation, counts: Mapping[str, Floats]) -> dict[str, Distribution]:
        """From counts of batches, shape (batches, bins), by the names of one mass."""
        units, signal, motion = simulation.parts.units, self.observer.signal, simulation.motion
        header = dict(zip(HEADER, simulation.parts.header_of(self.observer), strict=True))
        place = 0.0 if signal.outputs else units.state[0] * header["wall"] + 0.0  # of a single wall
        x, v = units.state
        x = x / header["frequency"] if signal.outputs else x
        scale = {"x": x, "v": v, "amplitude": units.length, "impact_speed": header["speed"]}
        distributions = {}
        for name, called in signal.names.items():
            unit, per_unit = (unit_of_result(motion.system, f"{called}_{end}") for end in ("quantile", "density"))
            own = np.zeros_like(counts[name]) if motion.is_undefined(signal) else counts[name]
            found = distribution_of(unit, per_unit, scale[name], own)
            distributions[called] = replace(found, edges=found.edges + place) if name == "x" else found
        return distributions


_numbers, _places = stack_array(LANES), stack_array(LANES)


@njit(**INLINE)
def bin_of(value):
    """Bin of a value without sign, by the bits of its single-precision number."""
    place = (bits_of(f32(value)) >> i32(17)) - i32(_OFFSET)
    return min(max(place, i32(0)), i32(BINS - 1))


@njit(**INLINE)
def _count(array, first, values, lanes, places):
    """Add the numbers of all lanes to the counts from ``first`` on: vector code finds the bins."""
    for lane in range(LANES):
        places[lane] = bin_of(abs(values[lane])) + (BINS if values[lane] < 0.0 else 0)
    for lane in range(lanes):
        array[first + places[lane]] += 1.0


@cache
def _compiled() -> tuple[Any, Any]:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        j, lanes = max(low - n, 0), int(array[_LANES])
        away, reach, places = _numbers(0.0), _numbers(0.0), _places(i32(0))
        if n + j < min(high, n + GROUP):
            for lane in range(LANES):
                here, fast = x[j * LANES + lane], v[j * LANES + lane] / array[_FREQUENCY]
                away[lane], reach[lane] = here - array[_WALL], np.sqrt(here * here + fast * fast)
            _count(array, _X, away, lanes, places)
            _count(array, _V, beyond(v, j * LANES), lanes, places)
            _count(array, _AMPLITUDE, reach, lanes, places)

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        if lane < array[_LANES]:
            array[_SPEED + bin_of(speed)] += count

    return on_steps, on_impacts


@cache
def _compiled_of_force() -> Any:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        j, scale = max(low - n, 0), array[_FREQUENCY]
        scaled, places = _numbers(0.0), _places(i32(0))
        if n + j < min(high, n + GROUP):
            for lane in range(LANES):
                scaled[lane] = scale * x[j * LANES + lane]
            _count(array, _X, scaled, int(array[_LANES]), places)

    return on_steps


@dataclass(frozen=True, eq=False)
class Distribution:
    """An estimated distribution: counts in bins, separately for each batch of paths.

    Attributes
    ----------
    unit, density_unit : str
    edges : ndarray, shape (bins + 1,)
    counts : ndarray, shape (batches, bins)
    """

    unit: str
    density_unit: str
    edges: Floats
    counts: Floats

    @property
    def size(self) -> float:
        """Number of samples."""
        return float(self.counts.sum())

    def density(self, bins: int = 80) -> tuple[Floats, Floats, Floats]:
        """Density from the 0.01 % to the 99.99 % quantile.

        Parameters
        ----------
        bins : int
            Approximate number of bins.

        Returns
        -------
        edges : ndarray, shape (n + 1,)
            A subset of the edges of the counts.
        density, standard_error : ndarray, shape (n,)
            In one over the unit.

        Examples
        --------
        >>> Distribution("m", "m-1", np.array([0.0, 1.0, 2.0]), np.array([[3.0, 1.0], [1.0, 3.0]])).density(2)[1]
        array([0.5, 0.5])
        """
        finite_number(bins, "bins", low=1.0, high=LARGEST)
        if not self.size > 0.0:
            return np.zeros(1), np.zeros(0), np.zeros(0)
        shares = np.cumsum(self.counts.sum(axis=0)) / self.size
        begin, end = int(np.searchsorted(shares, 1e-4)), int(np.searchsorted(shares, 1.0 - 1e-4)) + 1
        edges = self.edges[begin : end + 1]
        kept, width = [0], (edges[-1] - edges[0]) / bins
        for i in range(1, edges.size):
            if edges[i] >= edges[kept[-1]] + 0.999 * width or i == edges.size - 1:
                kept.append(i)
        counts = np.add.reduceat(self.counts[:, begin:end], kept[:-1], axis=1)
        widths = np.diff(edges[kept])
        return edges[kept], counts.sum(axis=0) / self.size / widths, self._error(counts) / widths

    def quantile(self, probability: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Quantiles and their standard errors, in the unit; NaN where nothing was counted.

        Parameters
        ----------
        probability : array_like
            In [0, 1], any shape.

        Returns
        -------
        quantile, standard_error : ndarray
            Of that shape.

        Raises
        ------
        ValueError
            If a probability is outside [0, 1].

        Examples
        --------
        >>> distribution = Distribution("m", "m-1", np.array([0.0, 1.0, 2.0]), np.array([[3.0, 1.0], [1.0, 3.0]]))
        >>> float(distribution.quantile(0.5)[0])
        1.0
        """
        p = real_array(probability, "probability")
        if np.any(~((p >= 0.0) & (p <= 1.0))):
            raise ValueError(f"probability must be in [0, 1], not {shown(probability)}.")
        if not self.size > 0.0:
            return np.full(p.shape, np.nan), np.full(p.shape, np.nan)
        below = np.concatenate([np.zeros((len(self.counts), 1)), np.cumsum(self.counts, axis=1)], axis=1)
        shares = below.sum(axis=0) / self.size
        bins = np.clip(np.searchsorted(shares, p, side="left") - 1, 0, self.edges.size - 2)
        inside = shares[bins + 1] - shares[bins]
        part = np.clip(np.divide(p - shares[bins], inside, out=np.zeros_like(p), where=inside > 0.0), 0.0, 1.0)
        width = np.diff(self.edges)[bins]
        reached = below[:, bins] + part * self.counts[:, bins]
        error = np.divide(self._error(reached) * width, inside, out=np.full_like(p, np.nan), where=inside > 0.0)
        return np.asarray(self.edges[bins] + part * width), error

    def share_above(self, value: npt.ArrayLike) -> tuple[Floats, Floats]:
        """The share of the samples above each value, and its standard error.

        Parameters
        ----------
        value : array_like
            In the unit, any shape.

        Returns
        -------
        share, standard_error : ndarray
            Of that shape; NaN without samples.

        Examples
        --------
        >>> distribution = Distribution("m", "m-1", np.array([0.0, 1.0, 2.0]), np.array([[3.0, 1.0], [1.0, 3.0]]))
        >>> float(distribution.share_above(1.5)[0])
        0.25
        """
        x = real_array(value, "value")
        if not self.size > 0.0:
            return np.full(x.shape, np.nan), np.full(x.shape, np.nan)
        above = np.concatenate([np.cumsum(self.counts[:, ::-1], axis=1)[:, ::-1], np.zeros((len(self.counts), 1))], 1)
        at = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, self.edges.size - 2)
        with np.errstate(over="ignore"):  # of a value far beyond the last edge
            part = np.clip((x - self.edges[at]) / np.diff(self.edges)[at], 0.0, 1.0)
        there = above[:, at] - part * self.counts[:, at]
        return np.asarray(there.sum(axis=0) / self.size), self._error(there)

    def columns(self, name: str, probabilities: Sequence[float]) -> Columns:
        """Everything for tables and files."""
        edges, density, error = self.density()
        at, its_error = self.quantile(probabilities)
        where, unit, per_unit = (f"{name}_bin",), {"units": self.unit}, {"units": self.density_unit}
        return {
            "probability": (("probability",), [*probabilities], {"units": "1"}),
            f"{name}_quantile": (("probability",), at, unit),
            f"{name}_quantile_se": (("probability",), its_error, unit),
            f"{name}_bin": (where, 0.5 * (edges[1:] + edges[:-1]), unit),
            f"{name}_bin_width": (where, np.diff(edges), unit),
            f"{name}_density": (where, density, per_unit),
            f"{name}_density_se": (where, error, per_unit),
        }

    def _error(self, counts: Floats) -> Floats:
        """Standard error of the ratio of sums of counts to the number of samples; batches are independent."""
        batches = self.counts[self.counts.sum(axis=1) > 0.0].sum(axis=1)
        if batches.size < FEWEST_BATCHES:
            return np.full(counts.shape[1:], np.nan)
        share = counts.sum(axis=0) / self.size
        apart = counts[self.counts.sum(axis=1) > 0.0] - share * batches.reshape(-1, *(1,) * (counts.ndim - 1))
        return np.asarray(np.sqrt(batches.size / (batches.size - 1.0) * (apart**2).sum(axis=0)) / self.size)


def distribution_of(unit: str, density_unit: str, scale: float, counts: Floats) -> Distribution:
    """A distribution from counts in the bins of `bin_of`, of one sign, or of positive numbers and then of negative.

    Parameters
    ----------
    scale : float
        The unit in which the numbers were counted.
    counts : ndarray, shape (batches, BINS or 2 * BINS)
    """
    octaves = np.exp2(np.arange(_LOWEST, _HIGHEST))
    edges = np.concatenate([[0.0], np.outer(octaves, 1.0 + np.arange(_PARTS) / _PARTS).ravel(), [2.0**_HIGHEST]])
    if counts.shape[1] > BINS:
        counts = np.concatenate([counts[:, : BINS - 1 : -1], counts[:, :BINS]], axis=1)
        edges = np.concatenate([-edges[:0:-1], edges])
    filled = np.flatnonzero(counts.any(axis=0))
    begin, end = (filled[0], filled[-1] + 1) if filled.size else (0, 0)
    counts, edges = counts[:, begin:end], scale * edges[begin : end + 1]
    return Distribution(unit, density_unit, edges, counts)


def sample_quantiles(samples: Floats, probability: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Quantiles of independent samples, and their standard errors from the binomial law of the ranks.

    NaN samples are ignored.  A quantile with fewer than four samples beyond it has no error.

    Examples
    --------
    >>> at, error = sample_quantiles(np.arange(101.0), [0.5, 0.99])
    >>> at, error.round(1)
    (array([50., 99.]), array([ 5., nan]))
    """
    p = np.asarray(probability, dtype=float)
    samples = samples[~np.isnan(samples)]
    if samples.size == 0:
        return np.full(p.shape, np.nan), np.full(p.shape, np.nan)
    away = np.sqrt(p * (1.0 - p) / samples.size)
    low, at, high = np.quantile(samples, np.clip([p - away, p, p + away], 0.0, 1.0))
    return at, np.where(samples.size * p * (1.0 - p) < FEWEST_BEYOND, np.nan, 0.5 * (high - low))
