"""Measured data: frozen, checked when they are made, in SI units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.arguments import LARGEST, finite_number
from springpot.faults import listed, shown
from springpot.parts.checks import put

__all__ = ["Impacts", "Moduli", "Of", "PointFault", "Record", "Spectrum"]

FloatArray = NDArray[np.float64]
Of = Literal["x", "v", "a"]

_EVEN = 1e-3  # of a sampling step: how far a time may be from its place
_OF = {"x": "the displacement", "v": "the velocity", "a": "the acceleration"}


class PointFault(ValueError):
    """One point of the data is not right.

    Parameters
    ----------
    name : str
        Of the column.
    place : int
        Of the point, from 0.
    what : str
        The rest of the sentence.

    Examples
    --------
    >>> print(PointFault("loss", 3, "must be greater than 0, not -1."))
    loss[3] must be greater than 0, not -1.
    """

    def __init__(self, name: str, place: int, what: str) -> None:
        super().__init__(f"{name}[{place}] {what}")
        self.name, self.place, self.what = name, place, what


@dataclass(frozen=True, eq=False)
class Moduli:
    """Storage and loss modulus against frequency, from a rheometer, a DMA or a test of stiffness.

    Parameters
    ----------
    frequency_hz : array_like, shape (n,)
        Positive, in ascending order, in Hz.
    storage, loss : array_like, shape (n,), optional
        Positive; one of them at least.  In Pa they give the numbers of a material, in N/m those of a part.
    relative_error : float, optional
        Standard deviation of each number, relative to it: 0.02 for 2 %.  If it is not given, it is estimated from
        the scatter about the fit, as one number for all points.

    Raises
    ------
    TypeError, ValueError
        If the columns are no numbers, have different lengths or fewer than three points, or a number is out of its
        range.

    Examples
    --------
    >>> Moduli([0.1, 1.0, 10.0], storage=[1.0, 2.0, 4.0], loss=[0.3, 0.6, 1.2]).size
    6
    """

    frequency_hz: Any
    storage: Any = None
    loss: Any = None
    relative_error: float | None = None

    def __post_init__(self) -> None:
        frequency = frequencies(self.frequency_hz)
        put(self, frequency_hz=frequency)
        if self.storage is None and self.loss is None:
            raise ValueError("storage or loss must be given: there are no moduli without them.")
        for name in ("storage", "loss"):
            if getattr(self, name) is not None:
                put(self, **{name: _positive(getattr(self, name), name, frequency.size)})
        if self.relative_error is not None:
            error = finite_number(
                self.relative_error, "relative_error", low=0.0, high=1.0, open_low=True, hint="2 % is 0.02."
            )
            put(self, relative_error=error)

    @property
    def size(self) -> int:
        """Of all moduli."""
        return sum(column.size for _, column in self.columns())

    def columns(self) -> Iterator[tuple[str, FloatArray]]:
        """Each modulus that was measured, with its name."""
        return ((name, getattr(self, name)) for name in ("storage", "loss") if getattr(self, name) is not None)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The spectral density of a response, an average of several periodograms.

    Parameters
    ----------
    frequency_hz : array_like, shape (n,)
        Positive, in ascending order, in Hz.
    density : array_like, shape (n,)
        One-sided, per Hz: in m^2/Hz for a displacement, (m/s)^2/Hz for a velocity, (m/s^2)^2/Hz for an acceleration.
    averages : float
        Number of independent periodograms in the average, at least 1.  Each number is then gamma distributed with a
        relative standard deviation of 1 / sqrt(averages).
    of : {"x", "v", "a"}
        Displacement, velocity, or the acceleration that an accelerometer on the mass shows.
    noise : float or None
        One-sided density of the measurement noise, in the unit of ``density``.  None: it is found with the rest.
    sampling_rate : float, optional
        In Hz.  With it the model has the aliasing that sampling brings; without it there is none.
    window : {"boxcar", "hann"}, optional
        Of each periodogram, with ``segment``: the model then has the leakage of the window, and the errors take into
        account that neighbouring points are correlated.
    segment : int, optional
        Samples of each periodogram.  Frequencies must then be multiples of sampling_rate / segment.

    Raises
    ------
    TypeError, ValueError
        If the columns are no numbers, have different lengths or fewer than three points, a number is out of its range,
        or ``window``, ``segment`` and ``sampling_rate`` do not fit together.

    Examples
    --------
    >>> Spectrum([1.0, 2.0, 3.0], [0.5, 0.9, 0.2], averages=20).size
    3
    """

    frequency_hz: Any
    density: Any
    averages: float
    of: Of = "x"
    noise: float | None = 0.0
    sampling_rate: float | None = None
    window: Literal["boxcar", "hann"] | None = None
    segment: int | None = None

    def __post_init__(self) -> None:
        frequency = frequencies(self.frequency_hz)
        put(self, frequency_hz=frequency, density=_positive(self.density, "density", frequency.size))
        averages = finite_number(
            self.averages, "averages", low=1.0, hint="It is the number of independent periodograms."
        )
        put(self, averages=averages, noise=_noise(self.noise))
        check_of(self.of)
        if self.sampling_rate is not None:
            self._check_sampled()
        if (self.window is None) != (self.segment is None):
            raise ValueError("window and segment must be given together: leakage depends on both.")
        if self.window is not None:
            self._check_window()

    def _check_sampled(self) -> None:
        rate = finite_number(
            self.sampling_rate, "sampling_rate", low=0.0, high=LARGEST, open_low=True, hint="It is in Hz."
        )
        put(self, sampling_rate=rate)
        if self.frequency_hz[-1] > 0.5 * rate * (1.0 + 1e-9):
            place = int(np.argmax(self.frequency_hz > 0.5 * rate))
            raise PointFault(
                "frequency_hz", place, f"must be at most half of sampling_rate, {0.5 * rate:g} Hz, not "
                f"{self.frequency_hz[place]:g}.",
            )  # fmt: skip

    def _check_window(self) -> None:
        if self.window not in ("boxcar", "hann"):
            raise ValueError(f"window must be 'boxcar' or 'hann', not {shown(self.window)}.")
        if self.sampling_rate is None:
            raise ValueError("sampling_rate must be given with window and segment.")
        if isinstance(self.segment, bool) or not isinstance(self.segment, int | np.integer) or self.segment < 8:
            raise ValueError(f"segment must be a whole number of samples, at least 8, not {shown(self.segment)}.")
        places = self.frequency_hz * self.segment / self.sampling_rate
        off = np.abs(places - np.round(places)) > 1e-3
        if off.any():
            place = int(np.argmax(off))
            raise PointFault(
                "frequency_hz", place, "must be a multiple of sampling_rate / segment, "
                f"{self.sampling_rate / self.segment:g} Hz, not {self.frequency_hz[place]:g}.",
            )  # fmt: skip

    @property
    def size(self) -> int:
        """Number of points."""
        return int(self.density.size)


@dataclass(frozen=True, eq=False)
class Record:
    """A sampled motion: one path, or several of the same device.

    Parameters
    ----------
    time : array_like, shape (n,)
        In s, at equal steps; at least 32.
    values : array_like, shape (n,) or (paths, n)
        In m, m/s or m/s^2.
    of : {"x", "v", "a"}
        Displacement, velocity, or the acceleration that an accelerometer on the mass shows.
    noise : float or None
        Standard deviation of the measurement noise, in the unit of ``values``.  None: it is found with the rest.

    Raises
    ------
    TypeError, ValueError
        If something is no number, the steps are not equal, or there are too few samples.

    Examples
    --------
    >>> import numpy as np
    >>> time = 0.1 * np.arange(64)
    >>> round(Record(time, np.sin(time), noise=0.01).step, 9)
    0.1
    """

    time: Any
    values: Any
    of: Of = "x"
    noise: float | None = None

    def __post_init__(self) -> None:
        time = column(self.time, "time")
        check_of(self.of)
        if time.size < _FEWEST_SAMPLES:
            raise ValueError(f"time must have at least {_FEWEST_SAMPLES} samples, not {time.size}.")
        values = _rows(self.values, time.size)
        gaps = np.diff(time)
        if (gaps <= 0.0).any():
            place = int(np.argmax(gaps <= 0.0)) + 1
            raise PointFault("time", place, f"must be later than the time before, not {time[place]:g}.")
        typical = float(np.median(gaps))
        if (np.abs(gaps - typical) > max(_EVEN * typical, 4e-15 * np.abs(time).max())).any():
            place = int(np.argmax(np.abs(gaps - typical))) + 1
            raise PointFault(
                "time", place, f"must follow at equal steps of {typical:.6g} s, not after {gaps[place - 1]:.6g} s."
            )
        if not np.ptp(values) > 0.0:
            raise ValueError("values must not all be equal: there is no motion.")
        put(self, time=time, values=values, noise=_noise(self.noise))

    @property
    def step(self) -> float:
        """The sampling step, in s."""
        return float((self.time[-1] - self.time[0]) / (self.time.size - 1))

    @property
    def paths(self) -> int:
        """Number of paths."""
        return int(self.values.shape[0])

    @property
    def size(self) -> int:
        """Number of samples of all paths."""
        return int(self.values.size)

    def spectrum(self, segment: int | None = None, window: Literal["boxcar", "hann"] = "hann") -> Spectrum:
        """Its spectral density: Welch's average of periodograms that overlap by half.

        Parameters
        ----------
        segment : int, optional
            Samples of each periodogram; an eighth of the record if not given.
        window : {"boxcar", "hann"}

        Returns
        -------
        Spectrum
            With the sampling rate and the window, so that a fit has aliasing and leakage in its model.  Its
            ``averages`` are fewer than the periodograms, because those overlap.  The frequencies 0 and half of the
            sampling rate are left out.

        Raises
        ------
        ValueError
            If a segment is longer than the record or too short.

        Notes
        -----
        Variances of overlapping periodograms: P. D. Welch, IEEE Transactions on Audio and Electroacoustics 15 (1967).

        Examples
        --------
        >>> import numpy as np
        >>> rng = np.random.default_rng(1)
        >>> found = Record(0.1 * np.arange(4096), rng.standard_normal(4096)).spectrum(segment=256)
        >>> found.size, round(found.averages, 1)
        (127, 29.4)
        """
        from scipy import signal

        samples = self.time.size
        length = max(samples // 8, 16) if segment is None else segment
        if isinstance(length, bool) or not isinstance(length, int) or not 16 <= length <= samples:
            raise ValueError(f"segment must be a whole number from 16 to the record's {samples}, not {shown(length)}.")
        shape = window_samples(window, length)
        hop = length // 2 if window == "hann" else length
        welch: Any = signal.welch  # its stubs do not know windows as arrays
        frequency, density = welch(
            self.values, 1.0 / self.step, shape, length, length - hop, detrend=False, scaling="density"
        )
        kept = slice(1, -1 if length % 2 == 0 else None)
        return Spectrum(
            frequency[kept], density.mean(axis=0)[kept], self.paths * _independent(shape, hop, samples), self.of,
            None if self.noise is None else 2.0 * self.step * self.noise**2, 1.0 / self.step, window, length,
        )  # fmt: skip


_FEWEST_SAMPLES = 32


@dataclass(frozen=True, eq=False)
class Impacts:
    """Speeds before and after each impact on one wall.

    Parameters
    ----------
    before, after : array_like, shape (n,)
        Positive, in m/s; the wall is at rest.
    error : float, optional
        Standard deviation of each measured speed, in m/s: of both, before and after.  If it is not given, the ratio of
        the speeds is taken to scatter by the same relative amount at every impact, which is estimated.

    Raises
    ------
    TypeError, ValueError
        If the columns are no numbers, have different lengths or fewer than three points, or a number is not positive.

    Examples
    --------
    >>> Impacts([1.0, 0.8, 0.5], [0.7, 0.57, 0.34]).size
    3
    """

    before: Any
    after: Any
    error: float | None = None

    def __post_init__(self) -> None:
        before = _positive(self.before, "before")
        _enough(before, "before")
        put(self, before=before, after=_positive(self.after, "after", before.size))
        if self.error is not None:
            error = finite_number(self.error, "error", low=0.0, high=LARGEST, open_low=True, hint="It is in m/s.")
            put(self, error=error)

    @classmethod
    def from_times(cls, times: ArrayLike, gravity: float = 9.80665) -> Impacts:
        """A ball that bounces on a floor, from the times of its impacts.

        Parameters
        ----------
        times : array_like, shape (n,)
            In s, ascending; at least five.  A flight of duration T begins and ends at the speed g T / 2.
        gravity : float
            In m/s^2.

        Returns
        -------
        Impacts
            One for each impact between two flights.

        Raises
        ------
        TypeError, ValueError
            If the times do not ascend or are too few.

        Notes
        -----
        The errors of neighbouring impacts are not independent, because each time is used twice.

        Examples
        --------
        >>> found = Impacts.from_times([0.0, 1.0, 1.7, 2.19, 2.533])
        >>> (found.after / found.before).round(3).tolist()
        [0.7, 0.7, 0.7]
        """
        at = column(times, "times")
        g = finite_number(gravity, "gravity", low=0.0, high=LARGEST, open_low=True, hint="It is in m/s^2.")
        if at.size < 5:
            raise ValueError(f"times must have at least 5 impacts, not {at.size}.")
        flights = np.diff(at)
        if (flights <= 0.0).any():
            place = int(np.argmax(flights <= 0.0)) + 1
            raise PointFault("times", place, f"must be later than the impact before, not {at[place]:g}.")
        speeds = 0.5 * g * flights
        return cls(speeds[:-1], speeds[1:])

    @property
    def size(self) -> int:
        """Number of impacts."""
        return int(self.before.size)


def column(values: object, name: str) -> FloatArray:
    """A column of finite numbers, which cannot be changed.

    Raises
    ------
    TypeError, ValueError, PointFault
        If it is none.

    Examples
    --------
    >>> column((1, 2.5), "time").tolist()
    [1.0, 2.5]
    """
    try:
        found = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a list of numbers, not {shown(values)}.") from None
    if found.ndim != 1:
        raise ValueError(f"{name} must be a list of numbers, not an array of {found.ndim} dimensions.")
    wrong = ~np.isfinite(found) | (np.abs(found) > LARGEST)
    if wrong.any():
        place = int(np.argmax(wrong))
        raise PointFault(name, place, f"must be a finite number, not {found[place]:g}.")
    found.flags.writeable = False
    return found


def check_of(of: object) -> None:
    """What a measurement is of.

    Raises
    ------
    ValueError
        If it is another word.
    """
    if not isinstance(of, str) or of not in _OF:
        words = listed([f"{word!r} ({text})" for word, text in _OF.items()], "or")
        raise ValueError(f"of must be {words}, not {shown(of)}.")


def window_samples(window: str, length: int) -> FloatArray:
    """The window at its samples.

    Raises
    ------
    ValueError
        If it is not known.

    Examples
    --------
    >>> window_samples("hann", 4).round(9).tolist()
    [0.0, 0.5, 1.0, 0.5]
    """
    if window not in ("boxcar", "hann"):
        raise ValueError(f"window must be 'boxcar' or 'hann', not {shown(window)}.")
    turns = 2.0 * math.pi * np.arange(length) / length
    return np.ones(length) if window == "boxcar" else 0.5 - 0.5 * np.cos(turns)


def _independent(shape: FloatArray, hop: int, samples: int) -> float:
    """Number of independent periodograms with the variance of the average of overlapping ones (Welch 1967)."""
    length = shape.size
    count = 1 + (samples - length) // hop
    power = float(shape @ shape)
    lags = range(1, min(count, -(-length // hop)))
    shared = [(float(shape[k * hop :] @ shape[: length - k * hop]) / power) ** 2 for k in lags]
    return count / (1.0 + 2.0 * sum((1.0 - k / count) * s for k, s in zip(lags, shared, strict=True)))


def _positive(values: object, name: str, length: int | None = None) -> FloatArray:
    found = column(values, name)
    if length is not None and found.size != length:
        raise ValueError(f"{name} must have a number for each of the {length} points, not {found.size}.")
    if (found <= 0.0).any():
        place = int(np.argmax(found <= 0.0))
        raise PointFault(name, place, f"must be greater than 0, not {found[place]:g}.")
    return found


def frequencies(values: object) -> FloatArray:
    """At least three frequencies in ascending order.

    Raises
    ------
    TypeError, ValueError, PointFault
        If they are none.

    Examples
    --------
    >>> frequencies([1, 2, 4]).tolist()
    [1.0, 2.0, 4.0]
    """
    found = _positive(values, "frequency_hz")
    _enough(found, "frequency_hz")
    if (np.diff(found) <= 0.0).any():
        place = int(np.argmax(np.diff(found) <= 0.0)) + 1
        raise PointFault("frequency_hz", place, f"must be above the frequency before it, not {found[place]:g}.")
    return found


def _enough(found: FloatArray, name: str) -> None:
    if found.size < 3:
        raise ValueError(f"{name} must have at least 3 points, not {found.size}.")


def _rows(values: object, samples: int) -> FloatArray:
    """The paths, each of so many samples."""
    try:
        found = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"values must be numbers, one for each time, not {shown(values)}.") from None
    found = found[np.newaxis] if found.ndim == 1 else found
    if found.ndim != 2 or found.shape[0] == 0 or found.shape[1] != samples:
        raise ValueError(f"values must have one number for each of the {samples} times, or rows of them, not an array "
                         f"of shape {found.shape}.")  # fmt: skip
    wrong = ~np.isfinite(found) | (np.abs(found) > LARGEST)
    if wrong.any():
        place = int(np.argwhere(wrong)[0, 1])
        raise PointFault("values", place, f"must be a finite number, not {found[wrong][0]:g}.")
    found.flags.writeable = False
    return found


def _noise(noise: object) -> float | None:
    hint = "It is of the measurement; None finds it."
    return None if noise is None else finite_number(noise, "noise", low=0.0, high=LARGEST, hint=hint)
