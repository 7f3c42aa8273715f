"""Largest values of one mass on a spring and a dashpot under straight lines between points: an exact recursion.

Within a step the excitation is a straight line, so the state at its end is a matrix times the state before and two
vectors times the excitation at both ends (Nigam and Jennings, Bulletin of the Seismological Society of America 59,
1969).  With so many steps in a period that cubics through values and slopes are exact to 3e-5, what is between the
points counts too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.linalg import expm

from springpot.machine.arrays import Floats
from springpot.machine.sampling import are_even, band_limited

Kind = Literal["maximax", "primary", "residual"]
"""Which times count: all, those until the last point of a record, or those after it."""

OF_ONE = "displacement", "velocity", "acceleration"
_IN_A_PERIOD = 24  # steps, least
_BETWEEN_SAMPLES = 4  # steps, least, of a signal between samples, which is no straight line
_CUBIC = 3e-5  # of a largest value: what a cubic lacks at so many steps
_MOST_AT_ONCE = 4_000_000  # points
_FREE = 1.05  # periods of free vibration, which has its largest values within one


@dataclass(frozen=True, eq=False)
class Oscillator:
    """x'' + 2 z w x' + w^2 x = u; of the ground's acceleration -u the acceleration is x'' - u.

    Attributes
    ----------
    frequency, ratio : float
        w in rad/s, and z.
    of_ground : bool
        Whether u is that of the ground.
    outputs : tuple of str
        Of OF_ONE: those whose largest sizes are wanted.
    """

    frequency: float
    ratio: float
    of_ground: bool
    outputs: Sequence[str] = OF_ONE

    @property
    def matrix(self) -> Floats:
        """Of x and v: their rates without u."""
        return np.array([[0.0, 1.0], [-(self.frequency**2), -2.0 * self.ratio * self.frequency]])

    def over(self, steps: Floats) -> tuple[Floats, Floats, Floats]:
        """Over each step: the matrix of the state, and what u at its beginning and at its end add."""
        whole = np.zeros((steps.size, 4, 4))
        whole[:, :2, :2] = self.matrix * steps[:, None, None]
        whole[:, 1, 2], whole[:, 2, 3] = steps, 1.0
        found = expm(whole)
        return found[:, :2, :2], found[:, :2, 2] - found[:, :2, 3], found[:, :2, 3]

    def states(self, u: Floats, steps: Floats) -> Floats:
        """x and v at all points, shape (2, records, points), from rest; ``steps`` has one step, or one for each gap."""
        from scipy.signal import lfilter  # slow to import

        found = np.zeros((2, *u.shape))
        if steps.size > 1:
            state = np.zeros((2, len(u)))
            for n, (own, first, last) in enumerate(zip(*self.over(steps), strict=True)):
                state = own @ state + np.outer(first, u[:, n]) + np.outer(last, u[:, n + 1])
                found[:, :, n + 1] = state
            return found
        (own,), (first,), (last,) = self.over(steps)
        other = own - np.trace(own) * np.eye(2)  # the adjugate of q - own is q + this
        below = [1.0, -np.trace(own), np.linalg.det(own)]
        for row, above in enumerate(np.array([last, first + other @ last, other @ first]).T):
            started = np.stack([-last[row] * u[:, 0], -(other @ last)[row] * u[:, 0]], axis=1)  # so that it is 0
            found[row] = lfilter(above, below, u, axis=1, zi=started)[0]
        return found

    def largest(self, u: Floats, steps: Floats, kind: Kind) -> dict[str, Floats]:
        """The largest sizes of the outputs, of each record; u is 0 after its last point."""
        x, v = self.states(u, steps)
        found = self._extremes(x, v, u, steps) if kind != "residual" else {}
        if kind != "primary":
            step = 2.0 * math.pi / self.frequency / _IN_A_PERIOD
            count = math.ceil(_FREE * _IN_A_PERIOD)
            one = self.over(np.array([step]))[0][0]
            powers = np.stack([np.linalg.matrix_power(one, n) for n in range(count)])
            free = np.einsum("nij,jr->irn", powers, np.stack([x[:, -1], v[:, -1]]))
            after = self._extremes(free[0], free[1], np.zeros(free.shape[1:]), np.array([step]))
            found = {name: np.maximum(own, found.get(name, 0.0)) for name, own in after.items()}
        return found

    def _extremes(self, x: Floats, v: Floats, u: Floats, steps: Floats) -> dict[str, Floats]:
        pull = -(self.frequency**2) * x - 2.0 * self.ratio * self.frequency * v
        rate, found = u + pull, dict[str, Floats]()
        if "displacement" in self.outputs:
            found["displacement"] = _largest(x, v[:, :-1], v[:, 1:], steps)
        if "velocity" in self.outputs:
            found["velocity"] = _largest(v, rate[:, :-1], rate[:, 1:], steps)
        if "acceleration" in self.outputs:
            jerk = -(self.frequency**2) * v - 2.0 * self.ratio * self.frequency * rate
            before, after = jerk[:, :-1], jerk[:, 1:]
            if not self.of_ground:
                slope = np.diff(u, axis=1) / steps
                before, after = before + slope, after + slope
            found["acceleration"] = _largest(pull if self.of_ground else rate, before, after, steps)
        return found


def _largest(values: Floats, before: Floats, after: Floats, steps: Floats) -> Floats:
    """The largest size of cubics through values with these slopes at the beginning and the end of each step."""
    found = np.abs(values).max(axis=1)
    rows, places = np.nonzero(before * after < 0.0)
    wide = np.broadcast_to(steps, before.shape[1:])[places]
    first, last = wide * before[rows, places], wide * after[rows, places]
    low = values[rows, places]
    rise = values[rows, places + 1] - low
    square, cube = 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise
    # where first + 2 square s + 3 cube s^2 = 0, between 0 and 1: its ends have different signs
    root = np.sqrt(np.maximum(square**2 - 3.0 * cube * first, 0.0))
    s = first / (np.copysign(root, first) - square)
    inside = low + s * (first + s * (square + s * cube))
    np.maximum.at(found, rows, np.abs(inside))
    return np.asarray(found)


@dataclass(frozen=True, eq=False)
class Lines:
    """Records with the same times.

    Attributes
    ----------
    members : tuple of int
        Their numbers.
    time : ndarray
    values : ndarray, shape (records, points)
    sampled : bool
        Whether they are samples of a signal, which is no straight line between them.
    """

    members: tuple[int, ...]
    time: Floats
    values: Floats
    sampled: bool

    def largest(self, oscillator: Oscillator, kind: Kind) -> tuple[dict[str, Floats], dict[str, Floats]]:
        """By output, of each record: the largest sizes, and bounds on their errors."""
        in_a_step = _IN_A_PERIOD * oscillator.frequency / (2.0 * math.pi) * float(np.diff(self.time).max())
        if not self.sampled:
            found = self._in_steps(oscillator, kind, math.ceil(in_a_step))
            return found, {name: _CUBIC * own for name, own in found.items()}
        fold = 2 ** math.ceil(math.log2(max(in_a_step, _BETWEEN_SAMPLES)))
        coarse, fine = (self._in_steps(oscillator, kind, each) for each in (fold, 2 * fold))
        lack = {name: (own - coarse[name]) / 3.0 for name, own in fine.items()}  # of lines: of second order
        return (
            {name: own + lack[name] for name, own in fine.items()},
            {name: np.abs(own) + _CUBIC * fine[name] for name, own in lack.items()},
        )

    def _in_steps(self, oscillator: Oscillator, kind: Kind, fold: int) -> dict[str, Floats]:
        if (count := len(self.values)) > 1 and self.values.size * fold > _MOST_AT_ONCE:
            some = [replace(self, values=own)._in_steps(oscillator, kind, fold) for own in _halves(self.values, count)]
            return {name: np.concatenate([each[name] for each in some]) for name in oscillator.outputs}
        steps = np.diff(self.time)
        own = np.array([steps.mean()]) if are_even(self.time) else np.repeat(steps, fold)
        return oscillator.largest(_dense(self, fold), own / fold, kind)


def _halves(values: Floats, count: int) -> tuple[Floats, Floats]:
    return values[: count // 2], values[count // 2 :]


@lru_cache(maxsize=4)
def _dense(lines: Lines, fold: int) -> Floats:
    """The values of records, so many times as dense."""
    if lines.sampled:
        return np.stack([band_limited(own, fold) for own in lines.values])
    between = lines.values[:, :-1, None] + np.diff(lines.values, axis=1)[:, :, None] * (np.arange(fold) / fold)
    return np.concatenate([between.reshape(len(lines.values), -1), lines.values[:, -1:]], axis=1)


def grouped(records: Sequence[tuple[Sequence[float], Sequence[float]]], sampled: bool) -> list[Lines]:
    """Records of the same times together."""
    found = dict[tuple[float, ...], list[int]]()
    for number, (time, _) in enumerate(records):
        found.setdefault(tuple(time), []).append(number)
    return [
        Lines((*members,), np.array(time), np.array([records[n][1] for n in members]), sampled)
        for time, members in found.items()
    ]


def largest_of_all(
    groups: Sequence[Lines], oscillator: Oscillator, kind: Kind, count: int
) -> tuple[Mapping[str, Floats], Mapping[str, Floats]]:
    """By output, of all records in their order: the largest sizes, and bounds on their errors."""
    values = {name: np.zeros(count) for name in oscillator.outputs}
    errors = {name: np.zeros(count) for name in oscillator.outputs}
    for lines in groups:
        found, off = lines.largest(oscillator, kind)
        for name in oscillator.outputs:
            values[name][[*lines.members]], errors[name][[*lines.members]] = found[name], off[name]
    return values, errors
