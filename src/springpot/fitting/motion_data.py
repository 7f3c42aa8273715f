"""Measured motion: a record of samples, and its spectral density; frozen, checked when they are made, in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from springpot.fitting.columns import (
    Measured,
    PointFault,
    check_number,
    check_points,
    column,
    falls,
    fixed,
    frequencies,
    positive,
    rows,
)
from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, shown
from springpot.machine.sampling import even_times
from springpot.problem.parts.checks import put

Of = Literal["x", "v", "a"]

_FEWEST_SAMPLES = 32
_LONGEST_SEGMENT = 2**20
_OF_NOISE = "It is of the measurement; None finds it."
_OF = {"x": "the displacement", "v": "the velocity", "a": "the acceleration"}


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredSpectrum(Measured):
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
    of : str
        ``"x"``, ``"v"`` or ``"a"``: displacement, velocity, or what an accelerometer on the mass shows.  Or a force
        or absolute acceleration by its name in ``forces`` of `springpot.simulate`, ``"mount_force"`` (N^2/Hz).
    noise : float or None
        One-sided density of the measurement noise, in the unit of ``density``.  None: it is found with the rest.
    sampling_rate : float, optional
        In Hz.  With it the model has the aliasing that sampling brings; without it there is none.
    window : {"boxcar", "hann"}, optional
        Of each periodogram, with ``segment``: the model then has the leakage of the window, and the errors take into
        account that neighbouring points are correlated.
    segment : int, optional
        Samples of each periodogram.  Frequencies must then be multiples of sampling_rate / segment.
    at : str, optional
        The mass whose motion it is, by its name, where the model has several.

    Raises
    ------
    TypeError, ValueError
        If the columns are no numbers, have different lengths or fewer than three points, a number is out of its range,
        or ``window``, ``segment`` and ``sampling_rate`` do not fit together.

    Examples
    --------
    >>> MeasuredSpectrum([1.0, 2.0, 3.0], [0.5, 0.9, 0.2], averages=20).size
    3
    """

    frequency_hz: Any
    density: Any
    averages: float
    of: str = "x"
    noise: float | None = 0.0
    sampling_rate: float | None = None
    window: Literal["boxcar", "hann"] | None = None
    segment: int | None = None
    at: str | None = None

    def __post_init__(self) -> None:
        frequency = frequencies(self.frequency_hz)
        put(self, frequency_hz=frequency, density=positive(self.density, "density", frequency.size))
        hint = "It is the number of independent periodograms."
        put(self, averages=finite_number(self.averages, "averages", low=1.0, hint=hint))
        check_number(self, "noise", low=0.0, high=LARGEST, hint=_OF_NOISE)
        if is_felt(self.of) and self.at is not None:
            raise ValueError(f"at must be left out for {self.of}, whose name says where it is.")
        if not is_felt(self.of):
            check_of(self.of, self.at)
        check_number(self, "sampling_rate", low=0.0, high=LARGEST, open_low=True, hint="It is in Hz.")
        if self.sampling_rate is not None:
            above = self.frequency_hz > 0.5 * self.sampling_rate * (1.0 + 1e-9)
            words = f"must be at most half of sampling_rate, {0.5 * self.sampling_rate:g} Hz, not "
            check_points(above, self.frequency_hz, "frequency_hz", words + "{:g}.")
        if (self.window is None) != (self.segment is None):
            raise ValueError("window and segment must be given together: leakage depends on both.")
        if self.window is not None:
            self._check_window()

    def _check_window(self) -> None:
        if self.window not in ("boxcar", "hann"):
            raise ValueError(f"window must be 'boxcar' or 'hann', not {shown(self.window)}.")
        if self.sampling_rate is None:
            raise ValueError("sampling_rate must be given with window and segment.")
        segment = self.segment
        whole = isinstance(segment, int | np.integer) and not isinstance(segment, bool)
        if not whole or segment is None or not 8 <= segment <= _LONGEST_SEGMENT:
            raise ValueError(
                f"segment must be a whole number of samples from 8 to {_LONGEST_SEGMENT:,}, not {shown(segment)}."
            )
        places = self.frequency_hz * segment / self.sampling_rate
        off = np.abs(places - np.round(places)) > 1e-3
        words = f"must be a multiple of sampling_rate / segment, {self.sampling_rate / segment:g} Hz, not "
        check_points(off, self.frequency_hz, "frequency_hz", words + "{:g}.")

    @property
    def size(self) -> int:
        """Number of points."""
        return int(self.density.size)


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredRecord(Measured):
    """A sampled motion: one path, or several of the same device.

    Parameters
    ----------
    time : array_like, shape (n,)
        In s, at equal steps; at least 32.  Times that are rounded to some decimals are taken for those of the rate.
    values : array_like, shape (n,) or (paths, n)
        In m, m/s or m/s^2.
    of : {"x", "v", "a"}
        Displacement, velocity, or the acceleration that an accelerometer on the mass shows.
    noise : float or None
        Standard deviation of the measurement noise, in the unit of ``values``.  None: it is found with the rest.
    at : str, optional
        The mass whose motion it is, by its name, where the model has several.

    Raises
    ------
    TypeError, ValueError
        If something is no number, the steps are not equal, or there are too few samples.

    Examples
    --------
    >>> import numpy as np
    >>> time = 0.1 * np.arange(64)
    >>> round(MeasuredRecord(time, np.sin(time), noise=0.01).step, 9)
    0.1
    """

    time: Any
    values: Any
    of: Of = "x"
    noise: float | None = None
    at: str | None = None

    def __post_init__(self) -> None:
        time = column(self.time, "time")
        check_of(self.of, self.at)
        if time.size < _FEWEST_SAMPLES:
            raise ValueError(f"time must have at least {_FEWEST_SAMPLES} samples, not {time.size}.")
        values = rows(self.values, time.size)
        check_points(falls(time), time, "time", "must be later than the time before, not {:g}.")
        if (even := even_times(time)) is None:
            gaps = np.diff(time)
            typical = float(np.median(gaps))
            place = int(np.argmax(np.abs(gaps - typical))) + 1
            raise PointFault(
                "time", place, f"must follow at equal steps of {typical:.6g} s, not after {gaps[place - 1]:.6g} s."
            )
        if not np.ptp(values) > 0.0:
            raise ValueError("values must not all be equal: there is no motion.")
        check_number(self, "noise", low=0.0, high=LARGEST, hint=_OF_NOISE)
        put(self, time=fixed(even), values=values)

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

    def spectrum(self, segment: int | None = None, window: Literal["boxcar", "hann"] = "hann") -> MeasuredSpectrum:
        """Its spectral density: Welch's average of periodograms that overlap by half.

        Parameters
        ----------
        segment : int, optional
            Samples of each periodogram; an eighth of the record if not given.
        window : {"boxcar", "hann"}

        Returns
        -------
        MeasuredSpectrum
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
        >>> found = MeasuredRecord(0.1 * np.arange(4096), rng.standard_normal(4096)).spectrum(segment=256)
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
        return MeasuredSpectrum(
            frequency[kept], density.mean(axis=0)[kept], self.paths * _independent(shape, hop, samples), self.of,
            None if self.noise is None else 2.0 * self.step * self.noise**2, 1.0 / self.step, window, length, self.at,
        )  # fmt: skip


def is_felt(of: object) -> bool:
    """Whether a measurement is said to be of a force or absolute acceleration of a model, by its name.

    Examples
    --------
    >>> is_felt("mount_force"), is_felt("a")
    (True, False)
    """
    return isinstance(of, str) and of.endswith(("force", "force_of_one", "force_on_ground", "acceleration"))


def check_of(of: object, at: object) -> None:
    """What a measurement is of, and of which mass.

    Raises
    ------
    TypeError, ValueError
        If it is another word, or the mass is no name.
    """
    if at is not None and not isinstance(at, str):
        raise TypeError(f"at must be the name of a mass, not {shown(at)}.")
    if not isinstance(of, str) or of not in _OF:
        words = listed([f"{word!r} ({text})" for word, text in _OF.items()], "or")
        raise ValueError(f"of must be {words}, not {shown(of)}.")


def window_samples(window: str, length: int) -> Floats:
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


def _independent(shape: Floats, hop: int, samples: int) -> float:
    """Number of independent periodograms with the variance of the average of overlapping ones (Welch 1967)."""
    length = shape.size
    count = 1 + (samples - length) // hop
    power = float(shape @ shape)
    lags = range(1, min(count, -(-length // hop)))
    shared = [(float(shape[k * hop :] @ shape[: length - k * hop]) / power) ** 2 for k in lags]
    return count / (1.0 + 2.0 * sum((1.0 - k / count) * s for k, s in zip(lags, shared, strict=True)))
