"""What every method for systems answers with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from springpot.machine.faults import shown
from springpot.problem.parts.checks import put
from springpot.problem.parts.walls import Stop
from springpot.problem.system import System
from springpot.theory.result import MOMENTS, Moments, NoStationaryStateError, about_walls_of, no_answer
from springpot.theory.walls import named_walls

__all__ = ["SYSTEM_MOMENTS", "SystemMoments", "SystemResult", "at_all_walls", "checked_system", "walls_of"]

SYSTEM_MOMENTS = (*MOMENTS, "rarest_impact_rate")
"""Names of the moments of systems on the validity map."""


@dataclass(frozen=True)
class SystemMoments(Moments):
    """Stationary moments of a system.

    Parameters
    ----------
    amplitude_mean_square : float
        <x^2> + <v^2> / Omega^2 in m^2, with Omega the root of the linear stiffness over the mass; NaN where that is not
        positive.
    impact_rate : float
        Of all walls and contacts together, per second.
    barrier_impact_rate, barrier_impact_speed_mean : tuple of float
        Of each wall and contact, in the order of the parts.
    harvested_power : float
        Mean power in the resistors of the circuits, in W; NaN without one.
    """

    barrier_impact_rate: tuple[float, ...] = ()
    barrier_impact_speed_mean: tuple[float, ...] = ()
    harvested_power: float = math.nan

    @property
    def rarest_impact_rate(self) -> float:
        """The impact rate of the wall or contact that is struck least often; NaN without one."""
        return min(self.barrier_impact_rate, default=math.nan)


def at_all_walls(rates: Sequence[float], means: Sequence[float], squares: Sequence[float]) -> dict[str, Any]:
    """The moments of impacts, from rate, mean speed and mean square speed at each wall; NaN where a rate is NaN.

    Examples
    --------
    >>> at_all_walls([1.0, 3.0], [2.0, 4.0], [5.0, 17.0])["impact_speed_mean"]
    3.5
    """
    total = math.nan if any(map(math.isnan, rates)) else math.fsum(rates)
    struck = [(r, s, q) for r, s, q in zip(rates, means, squares, strict=True) if r > 0.0]
    return {
        "impact_rate": total,
        "impact_speed_mean": sum(r * s for r, s, _ in struck) / total if total > 0.0 else math.nan,
        "impact_speed_mean_square": sum(r * q for r, _, q in struck) / total if total > 0.0 else math.nan,
        "barrier_impact_rate": tuple(rates),
        "barrier_impact_speed_mean": tuple(means),
    }


@dataclass(frozen=True)
class SystemResult:
    """The answer of one method to one system.

    Parameters
    ----------
    method : str
        Name of the method.
    system : System
        What was asked.
    stationary : SystemMoments or str
        The stationary moments, or the sentence that says why there are none.
    assumptions : tuple of str
        What the method assumes, one sentence each.
    warnings : tuple of str
        Where this system strains the assumptions, one sentence each.

    Notes
    -----
    The moments are read as attributes of the result (``result.x_mean`` ...).  Reading one where there is no stationary
    state raises `NoStationaryStateError`.
    """

    method: str
    system: System
    stationary: SystemMoments | str
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]

    def __post_init__(self) -> None:
        if isinstance(self.stationary, SystemMoments):
            walls = [*named_walls(self.system)]
            rates = self.stationary.barrier_impact_rate or (self.stationary.impact_rate,) * (len(walls) == 1)
            said = about_walls_of(self.system, self.stationary, dict(zip(walls, rates, strict=False)))
            put(self, warnings=(*self.warnings, *said))

    @property
    def moments(self) -> SystemMoments:
        """The stationary moments, all together."""
        if isinstance(self.stationary, str):
            raise NoStationaryStateError(self.stationary)
        return self.stationary

    def __getattr__(self, name: str) -> object:
        if name in _NAMES:
            return getattr(self.moments, name)
        raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *_NAMES})

    def to_dict(self) -> dict[str, object]:
        """The result as plain numbers, strings and lists, ready for JSON; a number that does not exist is None."""
        if isinstance(self.stationary, str):
            numbers = no_answer(self.stationary)
        else:
            numbers = {name: _plain(getattr(self.stationary, name)) for name in _NAMES}
        return {**numbers, "assumptions": list(self.assumptions), "warnings": list(self.warnings)}


_NAMES = (*SYSTEM_MOMENTS, "barrier_impact_rate", "barrier_impact_speed_mean", "harvested_power")


def _plain(value: float | tuple[float, ...]) -> object:
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return None if math.isnan(value) else value


def checked_system(system: object) -> System:
    """What was asked, if it is a system.

    Raises
    ------
    TypeError
        If it is something else.
    """
    if not isinstance(system, System):
        raise TypeError(f"system must be a System, not {shown(system)}.")
    return system


def walls_of(system: System) -> tuple[Stop, ...]:
    """Walls and contacts in the order of the parts."""
    return system.of(Stop)
