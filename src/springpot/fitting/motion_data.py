"""Measured motion: a record of samples, and its spectral density; frozen, checked when they are made, in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

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
from springpot.machine.arguments import LARGEST, check_whole, finite_number, one_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, shown
from springpot.machine.sampling import even_times
from springpot.problem.parts.checks import put
from springpot.problem.parts.records import Interpolation

Of = Literal["x", "v", "a"]
Start = Literal["free", "rest"]
Weights = Literal["noise", "equal"]

_FEWEST_SAMPLES = 32
_LONGEST_SEGMENT = 2**20
_OF_NOISE = "It is of the measurement; None finds it."
MOST_DELAY = 20  # samples
MOST_PIECES = 32
_OF_AN_INPUT: dict[str, object] = {
    "on": "mass",
    "interpolation": None,
    "start": "free",
    "skip": 0.0,
    "delay": 0.0,
    "weights": "noise",
    "offset": None,
}
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
        if is_output(self.of) and self.at is not None:
            raise ValueError(f"at must be left out for {self.of}, whose name says where it is.")
        if not is_output(self.of):
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
    input : array_like, shape (n,) or (paths, n), optional
        What drove the device, measured at the same times: the force in N (per unit mass, if the model has no mass, in
        m/s^2), or the acceleration of the ground in m/s^2.  The model then has no noise of its own, and may have
        walls, contacts and nonlinear parts.
    on : str
        Where the input acts: on the ``"mass"``, on one of several by its name, or on the ``"ground"``.
    interpolation : {"linear", "band-limited"}, optional
        What the input is between its samples: straight lines, or the signal without content above half of the sampling
        rate.  If it is left out, a fit tries both and takes the one that agrees better.
    start : {"free", "rest"}
        Whether x and v at the first sample are found with the rest, or are 0.
    skip : float
        In s: as much of the beginning is not compared.
    delay : float or None
        In s, by which the response is recorded later than the input.  None: it is found with the rest.
    offset : float or None
        What the sensor shows at x = 0 (or v, or a), in the unit of ``values``.  None: it is found with the rest; give 0
        where the model has a constant force and a spring with even powers, which do the same.

    weights : {"noise", "equal"}
        Whether what is left is filtered by its own colour, which has the smallest errors if the model is right; or all
        samples count alike, which leaves least of the record where the model is not complete.  Errors hold in both.

    Raises
    ------
    TypeError, ValueError
        If something is no number, the steps are not equal, or there are too few samples; if an input is all 0, or a
        record is clipped or stands still for a while.

    Notes
    -----
    ``values`` of several points of one device, under one input, are given as several records in ``values`` with a tuple
    in ``at``, and in ``of`` where they differ: shape (points, n).

    Examples
    --------
    >>> import numpy as np
    >>> time = 0.1 * np.arange(64)
    >>> round(MeasuredRecord(time, np.sin(time), noise=0.01).step, 9)
    0.1
    >>> MeasuredRecord(time, np.sin(time), input=np.cos(time), on="ground").has_input
    True
    """

    time: Any
    values: Any
    of: Of | tuple[Of, ...] = "x"
    noise: float | None = None
    at: str | tuple[str, ...] | None = None
    input: Any = None
    on: str = "mass"
    interpolation: Interpolation | None = None
    start: Start = "free"
    skip: float = 0.0
    delay: float | None = 0.0
    offset: float | None = None
    weights: Weights = "noise"

    def __post_init__(self) -> None:
        time = column(self.time, "time")
        for of, at in self.channels:
            check_of(of, at)
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
        if self.input is not None:
            self._check_input()
        elif changed := [name for name, usual in _OF_AN_INPUT.items() if getattr(self, name) != usual]:
            raise ValueError(f"{changed[0]} must be left out of a record without an input.")
        elif isinstance(self.at, tuple) or isinstance(self.of, tuple):
            raise ValueError("input must be given where several points were measured together.")

    def _check_input(self) -> None:
        """The input, and what is said of it."""
        paths, samples = self.values.shape
        own = rows(self.input, samples, "input")
        count = 1 if len(self.channels) > 1 else paths
        if len(self.channels) not in (1, paths):
            raise ValueError(f"values must have a row for each of the {len(self.channels)} points, not {paths}.")
        if len(own) not in (1, count):
            many = f", or {count}, as many as values have" if count > 1 else ""
            raise ValueError(f"input must have one row{many}, not {len(own)}.")
        if count > MOST_PIECES:
            raise ValueError(f"values must have at most {MOST_PIECES} rows with an input, not {count}.")
        if not np.ptp(own, axis=1).all():
            raise ValueError("input must not be constant: nothing drove the device.")
        put(self, input=fixed(np.broadcast_to(own, (count, samples)).copy()))
        if not isinstance(self.on, str) or not self.on:
            raise TypeError(f"on must be 'mass', 'ground' or the name of a mass, not {shown(self.on)}.")
        if self.interpolation is not None:
            one_of(self.interpolation, "interpolation", get_args(Interpolation))
        one_of(self.start, "start", get_args(Start))
        one_of(self.weights, "weights", get_args(Weights))
        duration = float(self.time[-1] - self.time[0])
        hint = "It is the part of the beginning that is not compared, in s."
        check_number(self, "skip", low=0.0, high=0.5 * duration, hint=hint)
        reach = MOST_DELAY * self.step
        check_number(self, "offset", low=-LARGEST, high=LARGEST, hint="None finds it.")
        check_number(self, "delay", low=-reach, high=reach, hint="It is in s; None finds it.")

    def in_pieces(self, count: int) -> MeasuredRecord:
        """A long record with its input as several of the same length, one after another; what is left over is left out.

        Each begins with an x and v of its own, so that errors do not add up over all of it.

        Parameters
        ----------
        count : int

        Returns
        -------
        MeasuredRecord

        Raises
        ------
        ValueError
            If it has no input or several rows, or the pieces are too short.

        Examples
        --------
        >>> import numpy as np
        >>> time = 0.1 * np.arange(128)
        >>> record = MeasuredRecord(time, np.sin(time), input=np.cos(time))
        >>> record.in_pieces(3).values.shape
        (3, 42)
        """
        if not self.has_input or len(self.values) > 1:
            raise ValueError("a record must have one row and an input to be cut in pieces.")
        check_whole(count, "count", 1, MOST_PIECES)
        length = self.time.size // count
        values, inputs = (own[0, : count * length].reshape(count, length) for own in (self.values, self.input))
        return replace(self, time=self.time[:length] - self.time[0], values=values, input=inputs)

    @property
    def first(self) -> int:
        """The first sample that is compared."""
        return round(self.skip / self.step)

    @property
    def has_input(self) -> bool:
        """Whether the input was measured too."""
        return self.input is not None

    @property
    def channel(self) -> tuple[Of, str | None]:
        """What was measured and where, of one point.

        Raises
        ------
        ValueError
            If several were measured together.
        """
        if len(self.channels) > 1:
            raise ValueError("record must be of one point.")
        return self.channels[0]

    @property
    def channels(self) -> tuple[tuple[Of, str | None], ...]:
        """What was measured and where, of each point that was measured together with others."""
        size = max((len(own) for own in (self.of, self.at) if isinstance(own, tuple)), default=1)
        of = self.of if isinstance(self.of, tuple) else (self.of,) * size
        at = self.at if isinstance(self.at, tuple) else (self.at,) * size
        if len(of) != len(at):
            raise ValueError(f"of and at must be of as many points, not {len(of)} and {len(at)}.")
        return tuple(zip(of, at, strict=True))

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
        (of, at), shape = self.channel, window_samples(window, length)
        hop = length // 2 if window == "hann" else length
        welch: Any = signal.welch  # its stubs do not know windows as arrays
        frequency, density = welch(
            self.values, 1.0 / self.step, shape, length, length - hop, detrend=False, scaling="density"
        )
        kept = slice(1, -1 if length % 2 == 0 else None)
        return MeasuredSpectrum(
            frequency[kept], density.mean(axis=0)[kept], self.paths * _independent(shape, hop, samples), of,
            None if self.noise is None else 2.0 * self.step * self.noise**2, 1.0 / self.step, window, length, at,
        )  # fmt: skip


def is_output(of: object) -> bool:
    """Whether a measurement is said to be of a force or absolute acceleration of a model, by its name.

    Examples
    --------
    >>> is_output("mount_force"), is_output("a")
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
