"""The common result of all analytical methods."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from springpot.machine.faults import NotCoveredError
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts.checks import put
from springpot.problem.system import System
from springpot.theory.walls import about_walls

__all__ = [
    "MOMENTS",
    "ROUNDED",
    "Moments",
    "NoConvergenceError",
    "NoStationaryStateError",
    "NotCoveredError",
    "Result",
    "no_answer",
]

ROUNDED = 1.0 + 1e-9
"""Factor on limits of what is covered, so that rounding errors do not exceed them."""

MOMENTS = (
    "amplitude_mean_square",
    "x_mean",
    "x_mean_square",
    "v_mean_square",
    "impact_rate",
    "impact_speed_mean",
    "impact_speed_mean_square",
)
"""Names of the stationary moments, the same in every method, in the simulation and in files."""


class NoStationaryStateError(ValueError):
    """The oscillator has no stationary state."""


class NoConvergenceError(ArithmeticError):
    """An iteration did not reach its tolerance; there is no result."""


@dataclass(frozen=True)
class Moments:
    """Stationary moments.

    Parameters
    ----------
    x_mean, x_mean_square, v_mean_square : float
        In m, m^2 and m^2 s^-2.
    amplitude_mean_square : float
        <A^2> with A^2 = x^2 + v^2 / Omega^2, in m^2.
    impact_rate : float
        Impacts per second; 0 without impacts.
    impact_speed_mean, impact_speed_mean_square : float
        Of the speed just before an impact, in m/s and m^2 s^-2; NaN without impacts.
    """

    amplitude_mean_square: float
    x_mean: float
    x_mean_square: float
    v_mean_square: float
    impact_rate: float
    impact_speed_mean: float
    impact_speed_mean_square: float


def about_walls_of(problem: Oscillator | System, moments: Moments, rates: Mapping[str, float]) -> tuple[str, ...]:
    """What `springpot.theory.walls` says of the walls where these are the moments."""
    said = about_walls(problem, moments.x_mean, moments.x_mean_square, moments.v_mean_square, rates)
    return tuple(said.values())


@dataclass(frozen=True)
class Result:
    """The result of one method for one oscillator.

    Parameters
    ----------
    method : str
        Name of the method.
    oscillator : Oscillator
        The oscillator that was solved.
    stationary : Moments or str
        The stationary moments, or the sentence that says why there are none.
    assumptions : tuple of str
        The assumptions of the method, one sentence each.
    warnings : tuple of str
        Reasons to doubt the result, one sentence each.

    Notes
    -----
    The moments are attributes of the result (``result.x_mean`` ...).  Without a stationary state they raise
    `NoStationaryStateError`; they are never infinite.
    """

    method: str
    oscillator: Oscillator
    stationary: Moments | str
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]

    def __post_init__(self) -> None:
        if isinstance(self.stationary, Moments):
            said = about_walls_of(self.oscillator, self.stationary, {"": self.stationary.impact_rate})
            put(self, warnings=(*self.warnings, *said))

    @property
    def moments(self) -> Moments:
        """The stationary moments, all together.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        """
        if isinstance(self.stationary, str):
            raise NoStationaryStateError(self.stationary)
        return self.stationary

    @property
    def amplitude_mean_square(self) -> float:
        """<A^2> with A^2 = x^2 + v^2 / Omega^2, in m^2."""
        return self.moments.amplitude_mean_square

    @property
    def x_mean(self) -> float:
        """Mean displacement, in m."""
        return self.moments.x_mean

    @property
    def x_mean_square(self) -> float:
        """Mean square displacement, in m^2."""
        return self.moments.x_mean_square

    @property
    def v_mean_square(self) -> float:
        """Mean square velocity, in m^2 s^-2."""
        return self.moments.v_mean_square

    @property
    def impact_rate(self) -> float:
        """Impacts per second."""
        return self.moments.impact_rate

    @property
    def impact_speed_mean(self) -> float:
        """Mean speed just before an impact, in m/s; NaN without impacts."""
        return self.moments.impact_speed_mean

    @property
    def impact_speed_mean_square(self) -> float:
        """Mean square of the speed just before an impact, in m^2 s^-2; NaN without impacts."""
        return self.moments.impact_speed_mean_square

    def to_dict(self) -> dict[str, object]:
        """The result as plain numbers, strings and lists, ready for JSON.

        Returns
        -------
        dict
            The `MOMENTS`, ``assumptions`` and ``warnings``; a number that does not exist is None.  Without a stationary
            state every moment is None and ``statement`` says why.
        """
        if isinstance(self.stationary, str):
            numbers = no_answer(self.stationary)
        else:
            values = {name: getattr(self.stationary, name) for name in MOMENTS}
            numbers = {name: None if math.isnan(value) else value for name, value in values.items()}
        return {**numbers, "assumptions": list(self.assumptions), "warnings": list(self.warnings)}


def no_answer(statement: str) -> dict[str, object]:
    """Every moment as None, and the sentence that says why.

    Examples
    --------
    >>> no_answer("Nothing to say.")["statement"]
    'Nothing to say.'
    """
    return {**dict.fromkeys(MOMENTS, None), "statement": statement}
