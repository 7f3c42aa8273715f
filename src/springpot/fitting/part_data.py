"""Measured parts: moduli, relaxation and creep of a material, impacts on a wall; frozen, checked, in SI units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.fitting.columns import Measured, check_number, check_points, column, enough, falls, frequencies, positive
from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.problem.parts.checks import put


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredModuli(Measured):
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
    >>> MeasuredModuli([0.1, 1.0, 10.0], storage=[1.0, 2.0, 4.0], loss=[0.3, 0.6, 1.2]).size
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
                _check_sign(getattr(self, name), name)
                put(self, **{name: positive(getattr(self, name), name, frequency.size)})
        check_number(self, "relative_error", low=0.0, high=1.0, open_low=True, hint="2 % is 0.02.")

    @property
    def size(self) -> int:
        """Of all moduli."""
        return sum(column.size for _, column in self.columns())

    def columns(self) -> Iterator[tuple[str, Floats]]:
        """Each modulus that was measured, with its name."""
        return ((name, getattr(self, name)) for name in ("storage", "loss") if getattr(self, name) is not None)


def _check_sign(values: object, name: str) -> None:
    """Refuse a modulus that is negative throughout: its phase is that of motions like exp(-i w t)."""
    found = column(values, name)
    if found.size and (found < 0.0).all():
        cause = "the sign of the phase is inverted" if name == "loss" else "force and motion have opposite directions"
        raise ValueError(f"{name} must be positive, but all {found.size} points are negative: {cause}, give -{name}.")


class _AfterStep(Measured):
    """What is measured against the time since a step: two columns, checked."""

    time: Any
    relative_error: float | None

    def __post_init__(self) -> None:
        (name,) = {own.name for own in fields(self)} - {"time", "relative_error"}  # type: ignore[arg-type]
        time = positive(self.time, "time")
        enough(time, "time")
        check_points(falls(time), time, "time", "must be later than the point before, not {:g}.")
        put(self, **{"time": time, name: positive(getattr(self, name), name, time.size)})
        check_number(self, "relative_error", low=0.0, high=1.0, open_low=True, hint="2 % is 0.02.")

    @property
    def size(self) -> int:
        """Number of points."""
        return int(self.time.size)


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredRelaxation(_AfterStep):
    """The relaxation modulus: stress after a step of the strain, over that step, against time.

    Parameters
    ----------
    time : array_like, shape (n,)
        Since the step, positive and ascending, in s.
    modulus : array_like, shape (n,)
        Positive; stress over strain in Pa, or force over displacement in N/m.
    relative_error : float, optional
        Standard deviation of each number, relative to it.  If it is not given, it is estimated from the scatter about
        the fit.

    Raises
    ------
    TypeError, ValueError
        If the columns are no numbers, have different lengths or fewer than three points, or a number is out of its
        range.

    Notes
    -----
    The step must be much shorter than the first time: a ramp counts from its middle, and times below ten ramps are
    better left out.

    Examples
    --------
    >>> MeasuredRelaxation([0.1, 1.0, 10.0], [3.0, 2.0, 1.4]).size
    3
    """

    time: Any
    modulus: Any
    relative_error: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredCreep(_AfterStep):
    """The creep compliance: strain after a step of the stress, over that step, against time.

    Parameters
    ----------
    time : array_like, shape (n,)
        Since the step, positive and ascending, in s.
    compliance : array_like, shape (n,)
        Positive; in 1/Pa, or m/N.
    relative_error : float, optional
        Standard deviation of each number, relative to it.  If it is not given, it is estimated from the scatter about
        the fit.

    Raises
    ------
    TypeError, ValueError
        If the columns are no numbers, have different lengths or fewer than three points, or a number is out of its
        range.

    Notes
    -----
    The step must be much shorter than the first time: a ramp counts from its middle, and times below ten ramps are
    better left out.

    Examples
    --------
    >>> MeasuredCreep([0.1, 1.0, 10.0], [0.3, 0.5, 0.9]).size
    3
    """

    time: Any
    compliance: Any
    relative_error: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredImpacts(Measured):
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
    >>> MeasuredImpacts([1.0, 0.8, 0.5], [0.7, 0.57, 0.34]).size
    3
    """

    before: Any
    after: Any
    error: float | None = None

    def __post_init__(self) -> None:
        before = positive(self.before, "before")
        enough(before, "before")
        put(self, before=before, after=positive(self.after, "after", before.size))
        check_number(self, "error", low=0.0, high=LARGEST, open_low=True, hint="It is in m/s.")

    @classmethod
    def from_times(cls, times: ArrayLike, gravity: float = 9.80665) -> MeasuredImpacts:
        """A ball that bounces on a floor, from the times of its impacts.

        Parameters
        ----------
        times : array_like, shape (n,)
            In s, ascending; at least five.  A flight of duration T begins and ends at the speed g T / 2.
        gravity : float
            In m/s^2.

        Returns
        -------
        MeasuredImpacts
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
        >>> found = MeasuredImpacts.from_times([0.0, 1.0, 1.7, 2.19, 2.533])
        >>> (found.after / found.before).round(3).tolist()
        [0.7, 0.7, 0.7]
        """
        at = column(times, "times")
        g = finite_number(gravity, "gravity", low=0.0, high=LARGEST, open_low=True, hint="It is in m/s^2.")
        if at.size < 5:
            raise ValueError(f"times must have at least 5 impacts, not {at.size}.")
        check_points(falls(at), at, "times", "must be later than the impact before, not {:g}.")
        speeds = 0.5 * g * np.diff(at)
        return cls(speeds[:-1], speeds[1:])

    @property
    def size(self) -> int:
        """Number of impacts."""
        return int(self.before.size)
