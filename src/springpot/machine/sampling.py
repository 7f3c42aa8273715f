"""Times of samples: the rate at which they follow each other, also where they were printed with few decimals."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from springpot.machine.arguments import positive_number
from springpot.machine.arrays import Floats

_MOST_DIGITS = 15  # that a number of a file can have
_WHOLE = 1e-3  # how far a multiple of a last digit may be from a whole number, where numbers have rounding
_LOOKED_AT = 10_000  # times whose digits are counted
_SIMPLE = 9  # digits of a rate or a step that somebody has chosen
_DRIFT = 1e-6  # of a step: what adding up many steps leaves
_EVEN = 1e-3  # of a step: how far a time may be from its place
_REACH, _SHAPE = 32, 8.0  # of the window, in samples on either side, and its parameter beta
_COARSEST = 0.25  # of a step, of half a last digit: a sample that is missing is no rounding
_MORE = 1.5
_EXACT = 2**53


def checked_rate(rate: float | None) -> float | None:
    """A number of samples per second, where one is given.

    Raises
    ------
    TypeError, ValueError
        If it is none.

    Examples
    --------
    >>> checked_rate(256)
    256.0
    """
    if rate is None:
        return None
    hint = "It is in samples per second."
    return positive_number(rate, "rate", hint)


def are_even(time: Floats) -> bool:
    """Whether times follow at equal steps, within a thousandth of one.

    Examples
    --------
    >>> are_even(np.array([0.0, 0.5, 1.0])), are_even(np.array([0.0, 0.5, 0.9]))
    (True, False)
    """
    gaps = np.diff(time)
    typical = float(np.median(gaps))
    return bool((np.abs(gaps - typical) <= max(_EVEN * typical, 4e-15 * np.abs(time).max())).all())


def even_times(time: Floats) -> Floats | None:
    """Times at equal steps: these, or those that were printed as these; None where there are no such.

    Parameters
    ----------
    time : ndarray
        Increasing, in s, two or more.

    Examples
    --------
    >>> even_times(np.array([0.0, 0.5, 1.0])).tolist(), even_times(np.array([0.0, 0.5, 0.6]))
    ([0.0, 0.5, 1.0], None)
    """
    return time if are_even(time) else equal_steps(time)


def band_limited(values: Floats, fold: int) -> Floats:
    """Samples of a signal without content above half of its sampling rate, so many times as dense.

    The sum of sinc functions under a Kaiser window over 32 samples on either side: up to 0.9 of half of the sampling
    rate it is off by 2e-4 at most.  Beyond its ends the signal goes on as its reflection in the point at the end.

    Parameters
    ----------
    values : ndarray
        At equal steps, two or more.
    fold : int

    Returns
    -------
    ndarray
        From the first sample to the last; the samples themselves are among them.

    Examples
    --------
    >>> band_limited(np.array([0.0, 1.0, 2.0]), 2).round(9).tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    padded = np.pad(values, _REACH, mode="reflect", reflect_type="odd")
    places = np.arange(1 - _REACH, _REACH + 1)
    dense = np.empty((values.size - 1, fold))
    dense[:, 0] = values[:-1]
    for phase in range(1, fold):
        apart = phase / fold - places
        weights = np.sinc(apart) * np.i0(_SHAPE * np.sqrt(1.0 - (apart / _REACH) ** 2))
        weights /= weights.sum()
        between = np.zeros(values.size - 1)
        for place, weight in zip(places.tolist(), weights.tolist(), strict=True):  # in this order on every processor
            first = _REACH + place
            between += weight * padded[first : first + between.size]
        dense[:, phase] = between
    return np.append(dense.ravel(), values[-1])


def equal_steps(time: Floats) -> Floats | None:
    """The times of samples at equal steps that were printed as these, if there are such; else None.

    Each time must lie within the rounding of its last digit from equal steps.  Among the steps of which that is true
    is taken the one that has the fewest digits, or whose rate has; else that of the least squares.

    Parameters
    ----------
    time : ndarray
        Increasing, in s, two or more.

    Examples
    --------
    >>> equal_steps(np.round(np.arange(200) / 256.0, 5))[:4].tolist()
    [0.0, 0.00390625, 0.0078125, 0.01171875]
    >>> equal_steps(np.array([0.0, 0.1, 0.25])) is None
    True
    """
    places, since = np.arange(time.size), time - time[0]
    centred = places - 0.5 * (time.size - 1)
    usual = float(centred @ since) / float(centred @ centred)
    near = np.clip((1.0 + _WHOLE) * _rounding(time), _DRIFT * usual, _COARSEST * usual)

    def is_near(step: float, times: float = 1.0) -> bool:
        """Whether some line of this slope goes through all times within their rounding."""
        left = since - step * places
        return bool((left - times * near).max() <= (left + times * near).min())

    if not is_near(usual, _MORE):  # of the least squares the farthest time is farther than of the nearest line
        return None
    for digits in range(1, _SIMPLE + 1):
        for step in (1 / _rounded(1.0 / usual, digits), _rounded(usual, digits)):
            if is_near(float(step)):
                above, below = step.as_integer_ratio()
                exact = above * time.size < _EXACT and below < _EXACT
                return np.asarray(time[0] + (places * above / below if exact else places * float(step)))
    return np.asarray(time[0] + usual * places)


def _rounded(number: float, digits: int) -> Fraction:
    return Fraction(f"{number:.{digits - 1}e}")


def _rounding(time: Floats) -> Floats:
    """Half of the last digit of each time: all have as many decimals, or as many digits, as one has at most."""
    sizes = np.abs(time)
    some = sizes[:: max(1, time.size // _LOOKED_AT)]
    some = some[some > 0.0]
    powers = np.floor(np.log10(np.where(sizes > 0.0, sizes, some.min()))) + 1.0
    digits = _decimals(some / 10.0 ** (np.floor(np.log10(some)) + 1.0))
    return np.asarray(np.maximum(0.5 * 10.0 ** -_decimals(some), 0.5 * 10.0 ** (powers - digits)))


def _decimals(numbers: Floats) -> float:
    """How many decimals numbers have; infinite where they have all that a number can have."""
    eps, largest = float(np.finfo(float).eps), float(numbers.max())
    for count in range(_MOST_DIGITS):
        scaled = numbers * 10.0**count
        if (np.abs(scaled - np.rint(scaled)) <= _WHOLE).all():
            return count
        if 8.0 * eps * largest * 10.0**count > _WHOLE:
            break
    return math.inf
