"""Impacts on each wall, from a result."""

from __future__ import annotations

from springpot.theory import Result

__all__ = ["rates_of", "speeds_of"]


def rates_of(result: Result) -> tuple[float, ...]:
    """The impact rate of each wall and contact, in the order of the parts."""
    return tuple(result.moments[f"{wall}_impact_rate"] for wall in result.system.stops)


def speeds_of(result: Result) -> tuple[float, ...]:
    """The mean impact speed at each wall and contact, in the order of the parts."""
    return tuple(result.moments[f"{wall}_impact_speed_mean"] for wall in result.system.stops)
