"""Excitations made of what shakers and standards state: sweeps, motions of the ground, noise that is not Gaussian."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import check_plain, finite_array, finite_number, one_of, positive_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown
from springpot.machine.sampling import even_times
from springpot.problem.parts.excitations import RmsUnit, SpectralExcitation, driven
from springpot.problem.parts.records import RecordedExcitation
from springpot.problem.spectral_density import STANDARD_GRAVITY

Motion = Literal["displacement", "velocity"]

_IN_A_CYCLE = 8  # points of a sweep, at its highest frequency
_MOST_POINTS = 4_000_000
_RATE = 2.5  # points in a period of the highest frequency of noise: up to 0.8 of half of the rate
_FEWEST = 32  # points of a motion, least
_LARGEST_KURTOSIS = 30.0


def sweep(
    amplitude: float, unit: RmsUnit, low: float, high: float, *, octaves_per_minute: float | None = None,
    duration: float | None = None, linear: bool = False, on: str = "",
) -> RecordedExcitation:  # fmt: skip
    """A sine sweep of constant amplitude: its frequency goes from one to another, and it ends there.

    Parameters
    ----------
    amplitude : float
        Of the ground's acceleration, or of a force: the largest value, not the rms.
    unit : {"g", "m/s2", "N"}
        Of the amplitude.
    low, high : float
        The first and the last frequency in Hz; a sweep may go down.
    octaves_per_minute : float, optional
        How fast the frequency changes, or
    duration : float, optional
        how long the sweep is, in s.
    linear : bool
        Whether the frequency changes by as many Hz in each second, not by as many octaves; it needs ``duration``.
    on : str
        The mass on which a force acts, by its name, where there are several.

    Returns
    -------
    RecordedExcitation
        Band-limited, with eight points in a cycle of the highest frequency.

    Raises
    ------
    TypeError, ValueError
        If a number or a word is not what it must be, or the sweep has more than four million points.

    Examples
    --------
    >>> slow = sweep(0.5, "g", 5.0, 80.0, octaves_per_minute=4.0)
    >>> slow.duration, slow.count, round(slow.mean_square**0.5 / 9.80665, 3)
    (60.0, 1, 0.354)
    """
    given = {"amplitude": amplitude, "low": low, "high": high, "duration": duration}
    for name, value in (given | {"octaves_per_minute": octaves_per_minute}).items():
        check_plain(value, name, "mark the scale of the record instead")
    size = positive_number(amplitude, "amplitude")
    one_of(unit, "unit", get_args(RmsUnit))
    ends = [positive_number(each, name, "It is a frequency in Hz.") for each, name in ((low, "low"), (high, "high"))]
    if (octaves_per_minute is None) == (duration is None) or (linear and duration is None):
        more = " for a linear sweep" if linear else " or octaves_per_minute, and not both"
        raise ValueError(f"duration must be given{more}.")
    octaves = math.log2(ends[1] / ends[0])
    if octaves == 0.0:
        raise ValueError(f"high must not be the frequency from which the sweep begins, {ends[0]:g} Hz.")
    if octaves_per_minute is not None:
        rate = positive_number(octaves_per_minute, "octaves_per_minute")
        length = 60.0 * abs(octaves) / rate
    else:
        length = positive_number(duration, "duration", "It is in s.")
    points = math.ceil(_IN_A_CYCLE * max(ends) * length) + 1
    _check_points(points, "duration", "a lower frequency or a faster sweep")
    t = np.linspace(0.0, length, points)
    share = t / length
    if linear:
        cycles = ends[0] * t + 0.5 * (ends[1] - ends[0]) * t * share
    else:
        cycles = ends[0] * length / (octaves * math.log(2.0)) * np.expm1(octaves * math.log(2.0) * share)
    values = size * (STANDARD_GRAVITY if unit == "g" else 1.0) * np.sin(2.0 * math.pi * cycles)
    return _record(t, values, driven(unit, on, "a sweep"))


def ground_motion(time: ArrayLike, values: ArrayLike, of: Motion = "displacement") -> RecordedExcitation:
    """The acceleration of ground whose displacement or velocity was recorded.

    Parameters
    ----------
    time : array_like, shape (points,)
        At equal steps, in s; at least 32.
    values : array_like, shape (points,) or (records, points)
        In m or m/s: of one record, or of several.
    of : {"displacement", "velocity"}

    Returns
    -------
    RecordedExcitation
        Band-limited, as samples of a signal are.  The ground is at rest before: where the values begin with a step or a
        speed, this is left out.

    Raises
    ------
    TypeError, ValueError
        If a number or a word is not what it must be, or times are not at equal steps.

    Notes
    -----
    Derivatives are those of a spline of the seventh degree through the points.  With nine of them in a period the
    acceleration of a displacement is right to 1e-5, with five to 5e-4; only the first and the last few points need a
    motion that is at rest there.  What rounding and noise of a displacement have at high frequency becomes larger with
    the square of the frequency: filter it before.

    Examples
    --------
    >>> t = np.arange(401) * 0.01
    >>> found = ground_motion(t, 1e-3 * np.sin(2.0 * np.pi * 5.0 * t) ** 2)
    >>> round(max(found.values), 3), round(2e-3 * (2.0 * np.pi * 5.0) ** 2, 3)
    (1.974, 1.974)
    """
    from scipy.interpolate import make_interp_spline

    one_of(of, "of", get_args(Motion))
    t, own = finite_array(time, "time"), finite_array(values, "values")
    if t.ndim != 1 or t.size < _FEWEST or not (np.diff(t) > 0.0).all() or (even := even_times(t)) is None:
        raise ValueError(f"time must increase at equal steps, {_FEWEST} points or more.")
    if own.ndim not in (1, 2) or own.shape[-1] != t.size or not own.size:
        raise ValueError(f"values must have the {t.size} points of time, in one row or several, not {own.shape}.")
    found = make_interp_spline(even, own, k=7, axis=-1).derivative(2 if of == "displacement" else 1)(even)
    return _record(even, found, "ground")


def ground_motion_psd(
    frequency: Sequence[float], psd: Sequence[float], of: Motion = "displacement", *, scale: float = 1.0
) -> SpectralExcitation:
    """The noise of ground whose displacement or velocity has a density: straight lines in the log-log plane stay such.

    Parameters
    ----------
    frequency : sequence of float
        Increasing, in Hz.
    psd : sequence of float
        One-sided, in m^2/Hz of a displacement or (m/s)^2/Hz of a velocity.
    of : {"displacement", "velocity"}
    scale : float
        Factor on the density.

    Returns
    -------
    SpectralExcitation

    Raises
    ------
    TypeError, ValueError
        If a number or a word is not what it must be.

    Examples
    --------
    >>> noise = ground_motion_psd((1.0, 10.0), (1e-6, 1e-8))
    >>> round(noise.one_sided(3.0) / (1e-6 / 9.0 * (6.0 * np.pi) ** 4), 12)
    1.0
    """
    one_of(of, "of", get_args(Motion))
    f, own = finite_array(frequency, "frequency"), finite_array(psd, "psd")
    if f.shape != own.shape:
        raise ValueError(f"psd must have a density for each of {f.size} frequencies, not {own.size}.")
    power = 4 if of == "displacement" else 2
    return SpectralExcitation((*f.tolist(),), (*(own * (2.0 * math.pi * f) ** power).tolist(),), scale)


def noise_records(
    noise: SpectralExcitation, duration: float, count: int, *, kurtosis: float = 3.0,
    correlation_time: float | None = None, seed: int = 1,
) -> RecordedExcitation:  # fmt: skip
    """Records of noise of a given density, Gaussian or with a larger kurtosis.

    Parameters
    ----------
    noise : SpectralExcitation
    duration : float
        Of each record, in s.
    count : int
        How many records.
    kurtosis : float
        From 3, that of Gaussian noise, to 30: the fourth moment over the square of the second.
    correlation_time : float, optional
        Of the random envelope in s, needed with a kurtosis above 3: some periods of the response or longer, since a
        response that is slower than the envelope becomes Gaussian.
    seed : int
        Of the records; the same seed gives the same ones.

    Returns
    -------
    RecordedExcitation
        With ``taken="in turn"``: a run has one path for each record.

    Raises
    ------
    TypeError, ValueError
        If a number is not what it must be, or the records have more than four million points.

    Notes
    -----
    A record is Gaussian noise g(t) times exp(s z(t) - s^2), where z is slow Gaussian noise of variance 1 and
    correlation exp(-(t / tau)^2 / 2).  The mean square is that of g and the kurtosis 3 exp(4 s^2), both exactly, as
    means over all records; the density is that of g, blurred by the inverse of tau.  Of records of finite length and
    number the sample kurtosis scatters much.

    Examples
    --------
    >>> band = SpectralExcitation.from_psd((5.0, 50.0), 0.01, "g2/Hz")
    >>> made = noise_records(band, 20.0, 8, kurtosis=6.0, correlation_time=2.0)
    >>> made.count, made.duration, abs(made.mean_square / band.mean_square - 1.0) < 0.4
    (8, 20.0, True)
    """
    if not isinstance(noise, SpectralExcitation) or noise.envelope is not None:
        raise TypeError(f"noise must be a SpectralExcitation without an envelope, not {shown(noise)}.")
    length = positive_number(duration, "duration", "It is in s.")
    for name, value, least in (("count", count, 1), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise ValueError(f"{name} must be a whole number, {least} or more, not {shown(value)}.")
    kurtosis = finite_number(kurtosis, "kurtosis", low=3.0, high=_LARGEST_KURTOSIS, hint="3 is Gaussian.")
    if (kurtosis > 3.0) != (correlation_time is not None):
        raise ValueError("correlation_time must be given with a kurtosis above 3, and only then.")
    points = math.ceil(_RATE * noise.frequency[-1] * length) + 1
    _check_points(points * count, "duration", "fewer or shorter records")
    step = length / (points - 1)
    rng = np.random.default_rng([seed, 0x5EED])
    # of a period of four times the length a quarter is taken: its ends do not know of each other
    frequency = np.fft.rfftfreq(4 * points, step)
    values = _gaussian(rng, np.array([noise.one_sided(f) for f in frequency.tolist()]), step, count)[:, :points]
    if correlation_time is not None:
        tau = positive_number(correlation_time, "correlation_time")
        if tau < 4.0 * step:
            raise ValueError(f"correlation_time must be at least {4.0 * step:.3g} s, four steps of the records.")
        w = 2.0 * math.pi * frequency
        slow = np.exp(-0.5 * (w * tau) ** 2)
        slow[0] *= 0.5  # which counts once, not on both sides
        shares = slow / slow.sum() / (frequency[1] - frequency[0])
        z = _gaussian(rng, shares, step, count)[:, :points]
        spread = math.sqrt(0.25 * math.log(kurtosis / 3.0))
        values = values * np.exp(spread * z - spread**2)
    return _record(np.arange(points) * step, values if count > 1 else values[0], noise.on)


def _gaussian(rng: np.random.Generator, density: Floats, step: float, count: int) -> Floats:
    """Periodic records of noise with a one-sided density at the frequencies of their Fourier transform."""
    size = 2 * (density.size - 1)
    normals = rng.normal(size=(2, count, density.size))
    # a line has the variance of its band, which its real and its imaginary part share
    lines = np.sqrt(0.25 * density * size / step) * (normals[0] + 1j * normals[1])
    lines[:, [0, -1]] = np.sqrt(density[[0, -1]] * size / step) * normals[0][:, [0, -1]]
    return np.fft.irfft(lines, size, axis=1)


def _check_points(points: int, name: str, advice: str) -> None:
    if points > _MOST_POINTS:
        raise ValueError(f"{name} takes {points:.2g} points, and at most {_MOST_POINTS:.2g} are kept: use {advice}.")


def _record(time: Any, values: Any, on: str) -> RecordedExcitation:
    own = tuple(values.tolist()) if values.ndim == 1 else tuple(map(tuple, values.tolist()))
    return RecordedExcitation(tuple(time.tolist()), own, on, interpolation="band-limited")
