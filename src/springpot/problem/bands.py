"""Spectral densities in bands: the rms in each, and tables of many lines thinned to break points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arguments import numbers_in_array, positive_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown

FRACTION = 6  # of an octave: the bands in which a thinned table keeps its mean square
_WIDEST = 3  # bands in an octave over which lines are averaged at first; where that is not near enough, over halves
_SHARES = (0.75, 0.5, 0.25, 0.0)  # of the tolerance, by which an average may be off that is left out
_STEP = 10.0**0.3  # an octave of IEC 61260, base 10
_GRID = 256  # places in a band of a response
_ROUNDS = 2
_PLACES = 8  # in a band, at which another begins that is checked
_EVEN = 0.1  # of a step: frequencies are rounded in files
_SMALL = 1e-8


@dataclass(frozen=True, eq=False)
class Bands:
    """The root mean square of a noise in each band of frequencies.

    Attributes
    ----------
    low, high : ndarray
        The ends of each band, in Hz, those at the ends of the table cut there.
    middle : ndarray
        The mid-band frequency of IEC 61260, in Hz.
    rms : ndarray
        In the root of the density's unit times Hz.
    """

    low: Floats
    high: Floats
    middle: Floats
    rms: Floats

    @property
    def overall(self) -> float:
        """Of all bands together."""
        return math.sqrt(math.fsum(self.rms**2))

    def __str__(self) -> str:
        """A line for each band."""
        columns = zip(self.middle, self.low, self.high, self.rms, strict=True)
        rows = (f"{middle:10.5g}  {low:10.5g}  {high:10.5g}  {rms:.5g}" for middle, low, high, rms in columns)
        return "\n".join([f"{'middle, Hz':>10}  {'low':>10}  {'high':>10}  rms", *rows])


def band_rms(
    source: Any, of: str = "", *, fraction: int = 3, low: float | None = None, high: float | None = None
) -> Bands:
    """The root mean square of a table, a spectrum or a response in octave bands or fractions of them.

    The density is integrated exactly along straight lines in the log-log plane between its points.

    Parameters
    ----------
    source : SpectralExcitation, MeasuredSpectrum, spectrum of a run, linear response, or (frequency, density)
        A response is a result with a method ``spectrum``, such as `springpot.theory.linear` gives; of two arrays the
        frequencies are in Hz, and the density is one-sided and per Hz.
    of : str
        Of a response: as ``of`` of its ``spectrum``, such as ``"acceleration"``.
    fraction : int
        Bands in an octave: 1 for octaves, 3 for third-octave bands.
    low, high : float, optional
        In Hz; the ends of the table if not given.  A response needs them.

    Returns
    -------
    Bands

    Raises
    ------
    TypeError, ValueError
        If something is not what it must be, or a density is not above 0.

    Examples
    --------
    >>> import springpot as sp
    >>> profile = sp.SpectralExcitation.from_psd((20.0, 80.0, 2000.0), (0.01, 0.04, 0.04), "m2/s4/Hz")
    >>> found = band_rms(profile, fraction=1)

    >>> found.middle.round(1).tolist(), round(found.overall, 3)
    ([15.8, 31.6, 63.1, 125.9, 251.2, 501.2, 1000.0, 1995.3], 8.849)
    """
    if isinstance(fraction, bool) or not isinstance(fraction, int) or not 1 <= fraction <= 96:
        raise ValueError(f"fraction must be a whole number of bands in an octave, from 1 to 96, not {shown(fraction)}.")
    ends = [None if end is None else positive_number(end, name, "It is in Hz.")
            for end, name in ((low, "low"), (high, "high"))]  # fmt: skip
    if callable(getattr(source, "spectrum", None)) and not hasattr(source, "values"):
        if None in ends:
            raise ValueError("low and high must be given with a response, which has a density at every frequency.")
        frequency = np.geomspace(ends[0], ends[1], max(2, round(_GRID * fraction * math.log2(ends[1] / ends[0]))))  # type: ignore[operator, arg-type]
        named = {"of": of} if of else {}
        density = 4.0 * math.pi * np.asarray(source.spectrum(2.0 * math.pi * frequency, **named), float)
    else:
        frequency, density = _table(source)
    whole = float(frequency[0]), float(frequency[-1])
    first, last = (own if end is None else float(end) for end, own in zip(ends, whole, strict=True))
    if not whole[0] <= first < last <= whole[1]:
        raise ValueError(f"low and high must be in the table, from {whole[0]:g} to {whole[1]:g} Hz, low below high.")
    middles = middles_of(first, last, fraction)
    half = _STEP ** (0.5 / fraction)
    edges = np.clip(np.append(middles / half, middles[-1] * half), first, last)
    areas = np.diff(integral_to(np.log(frequency), np.log(density), np.log(edges)))
    return Bands(edges[:-1], edges[1:], middles, np.sqrt(np.maximum(areas, 0.0)))


def middles_of(low: float, high: float, fraction: int) -> Floats:
    """The mid-band frequencies of IEC 61260 (base 10) whose bands have a part between two frequencies.

    Examples
    --------
    >>> middles_of(100.0, 200.0, 3).round(1).tolist()
    [100.0, 125.9, 158.5, 199.5]
    """
    shift = 0.0 if fraction % 2 else 0.5
    places = [fraction * math.log10(end / 1000.0) / 0.3 - shift for end in (low, high)]
    first, last = math.floor(places[0] + 0.5), math.ceil(places[1] - 0.5)
    return np.asarray(1000.0 * _STEP ** ((np.arange(first, max(first, last) + 1) + shift) / fraction))


def _table(source: Any) -> tuple[Floats, Floats]:
    """Frequencies in Hz and one-sided densities per Hz of a table or a spectrum."""
    frequency: Any
    density: Any
    if hasattr(source, "psd"):
        frequency, density = source.frequency, [source.scale * value for value in source.psd]
    elif hasattr(source, "resolution"):
        frequency, density = source.frequency / (2.0 * math.pi), 4.0 * math.pi * source.density
    elif hasattr(source, "frequency_hz"):
        frequency, density = source.frequency_hz, getattr(source, "density", None)
    elif isinstance(source, tuple | list) and len(source) == 2:
        frequency, density = source
    else:
        must = "source must be a SpectralExcitation, a spectrum, a response, or frequencies and densities"
        raise TypeError(f"{must}, not {shown(source)}.")
    f = numbers_in_array(frequency, "frequency must be a list of numbers")
    g = numbers_in_array(density, "density must be a list of numbers")
    if f.ndim != 1 or f.shape != g.shape or f.size < 2:
        raise ValueError("frequency and density must have the same number of points, two or more.")
    if not (
        np.isfinite(f).all() and np.isfinite(g).all() and f[0] > 0.0 and (np.diff(f) > 0.0).all() and (g > 0.0).all()
    ):
        raise ValueError("frequency must increase from above 0, and density must be finite and above 0.")
    return f, g


def integral_to(u: Floats, logarithm: Floats, at: Floats) -> Floats:
    """The integral of a density from the first point of its table, along straight lines in the log-log plane.

    Parameters
    ----------
    u, logarithm : ndarray
        Logarithms of the frequencies and of the densities.
    at : ndarray
        Logarithms of frequencies in the table, up to which it is integrated.

    Examples
    --------
    >>> u = np.log([1.0, 2.0, 4.0])
    >>> integral_to(u, u, np.log([2.0, 3.0])).round(9).tolist()  # of f from 1
    [1.5, 4.0]
    """
    whole = np.concatenate([[0.0], np.cumsum(_areas(u[:-1], logarithm[:-1], u[1:], logarithm[1:]))])
    piece = np.clip(np.searchsorted(u, at, side="right") - 1, 0, len(u) - 2)
    return np.asarray(whole[piece] + _areas(u[piece], logarithm[piece], at, np.interp(at, u, logarithm)))


def _areas(u: Floats, logarithm: Floats, v: Floats, other: Floats) -> Floats:
    steep = (other - logarithm) + (v - u)
    small = np.abs(steep) < _SMALL
    ratio = np.where(small, 1.0 + 0.5 * steep, np.expm1(steep) / np.where(small, 1.0, steep))
    return np.asarray(np.exp(logarithm + u) * (v - u) * ratio)


def are_lines(frequency: Floats) -> bool:
    """Whether frequencies follow at equal steps but for rounding, as the lines of an analyser or a controller.

    Examples
    --------
    >>> are_lines(np.array([0.62, 1.25, 1.88])), are_lines(np.array([10.0, 40.0, 500.0]))
    (True, False)
    """
    steps = np.diff(frequency)
    return bool(np.ptp(steps) <= _EVEN * steps.mean())


def thinned(frequency: Floats, density: Floats, tolerance: float) -> tuple[Floats, Floats, float]:
    """A table of many lines as few break points, which keep the mean square in each sixth of an octave.

    The table is averaged in bands, in narrower ones where that is not near enough, and averages that lie on straight
    lines in the log-log plane between others are left out.  The overall mean square is kept exactly.

    Parameters
    ----------
    frequency, density : ndarray
        Increasing, above 0; of lines at equal steps some densities may be 0.
    tolerance : float
        Largest change of the mean square in a sixth of an octave, as a share; a band has two lines at least.

    Returns
    -------
    frequency, density : ndarray
    worst : float
        The largest change.

    Raises
    ------
    ValueError
        If a density is 0 over a whole band.

    Examples
    --------
    >>> f = np.arange(20.0, 2001.0)
    >>> found, _, worst = thinned(f, np.minimum(f / 100.0, 1.0), 0.05)
    >>> len(found) < 8, worst < 0.05
    (True, True)
    """
    u = np.log(frequency)
    if lines := are_lines(frequency):  # trapezia: a straight line between logarithms of scattered lines is too low
        pieces = np.diff(frequency) * 0.5 * (density[1:] + density[:-1])
        whole = np.concatenate([[0.0], np.cumsum(pieces)])
    elif not (density > 0.0).all():
        raise ValueError("psd must be above 0: straight lines in the log-log plane never are 0.")

    def integral(at: Floats) -> Floats:
        if not lines:
            return integral_to(u, np.log(density), at)
        f = np.exp(at)
        piece = np.clip(np.searchsorted(frequency, f, side="right") - 1, 0, len(frequency) - 2)
        there = np.interp(f, frequency, density)
        return np.asarray(whole[piece] + 0.5 * (f - frequency[piece]) * (density[piece] + there))

    edges = _edges(u, FRACTION, _PLACES)
    wanted = integral(edges)
    second = np.append(frequency, [math.inf] * 2)[np.searchsorted(frequency, np.exp(edges) * (1.0 - 1e-12)) + 2]
    least = np.searchsorted(np.exp(edges) * (1.0 + 1e-12), second)  # of the ends of bands: where two lines have passed
    ends = np.maximum(np.arange(len(edges)) + _PLACES, least)
    begins = np.flatnonzero(ends < len(edges))
    if not begins.size:
        return frequency, density, 0.0
    ends = ends[begins]
    area = wanted[ends] - wanted[begins]
    if not (area > 0.0).all():
        low, high = (math.exp(edges[each[int(np.argmin(area))]]) for each in (begins, ends))
        raise ValueError(
            f"psd is 0 from {low:.4g} to {high:.4g} Hz, and straight lines in the log-log plane never are: give the "
            "bands on either side as two noises."
        )
    total = float(integral(u[-1:])[0])
    cells = _edges(u, _WIDEST, 1)
    best = frequency, density, math.inf
    while True:
        while len(cells) > 2 and (np.diff(integral(cells)) <= 0.0).any():  # no logarithm: it joins the one before
            cells = np.delete(cells, max(1, int(np.argmin(np.diff(integral(cells))))))
        mean = np.log(np.diff(integral(cells)) / np.diff(np.exp(cells)))
        outer = (1.5 * mean[0] - 0.5 * mean[1], 1.5 * mean[-1] - 0.5 * mean[-2]) if len(mean) > 1 else (mean[0],) * 2
        at = np.concatenate([u[:1], 0.5 * (cells[1:] + cells[:-1]), u[-1:]])
        level = np.concatenate([outer[:1], mean, outer[1:]])
        for share in _SHARES:
            kept = _break_points(at, level, share * tolerance)
            points, values = at[kept], level[kept]  # and the sides of what is nearest to each point
            sides = np.concatenate([u[:1], 0.5 * (points[1:] + points[:-1]), u[-1:]])
            for _ in range(_ROUNDS):
                near = np.diff(integral(sides))
                own = np.diff(integral_to(points, values, sides))
                values = values + np.log(np.where(near > 0.0, near, own) / own)
            values = values + math.log(total / float(integral_to(points, values, u[-1:])[0]))
            found = integral_to(points, values, edges)
            off = np.abs((found[ends] - found[begins]) / area - 1.0)
            if off.max() < best[2]:
                best = np.exp(points), np.exp(values), float(off.max())
            if off.max() <= tolerance:
                return best
        left, right = edges[begins][off > tolerance], edges[ends][off > tolerance]
        middle = 0.5 * (cells[1:] + cells[:-1])
        touched = ((cells[1:, None] > left) & (cells[:-1, None] < right)).any(axis=1)
        inside = np.searchsorted(u, cells[1:]) - np.searchsorted(u, cells[:-1])
        if not (split := touched & (inside >= 2)).any():
            return best
        cells = np.sort(np.append(cells, middle[split]))


def _edges(u: Floats, fraction: int, steps: int) -> Floats:
    """The ends of bands of a fraction of an octave from the first frequency to the last, each in so many steps."""
    count = max(1, round((u[-1] - u[0]) / math.log(2.0) * fraction))
    return np.linspace(u[0], u[-1], count * steps + 1)


def _break_points(u: Floats, level: Floats, tolerance: float) -> Any:
    """The points that are kept: all others are near to the straight lines between these (Douglas and Peucker)."""
    kept = np.zeros(len(u), bool)
    kept[[0, -1]] = True
    left = [(0, len(u) - 1)]
    while left:
        first, last = left.pop()
        between = np.interp(u[first : last + 1], u[[first, last]], level[[first, last]])
        off = np.abs(level[first : last + 1] - between)
        if (place := first + int(off.argmax())) not in (first, last) and off.max() > tolerance:
            kept[place] = True
            left += [(first, place), (place, last)]
    return kept
