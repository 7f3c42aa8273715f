"""How results are read from the sums of the paths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from springpot.problem.system import System

Sum = tuple[str, str]
"""A sum over the steps of a path: of which quantity, and whose: of a coordinate, a row, a force, a wall, a circuit."""


@dataclass(frozen=True)
class Reading:
    """One result as sums over steps, time or other sums.

    Attributes
    ----------
    name : str
        Of the result.
    above : dict
        The sums, each with its factor.
    over : {"steps", "time", "groups", "one"} or tuple of Sum
        What they are divided by: the steps, the time or the groups of steps of the window, nothing, or other sums (a
        ratio of two means over all paths).
    added : float
        To the quotient.
    power : int
        Of the whole of each path.
    squares : dict
        Sums whose squares are added to that, each with its factor.
    """

    name: str
    above: Mapping[Sum, float]
    over: Literal["steps", "time", "groups", "one"] | tuple[Sum, ...] = "steps"
    added: float = 0.0
    power: int = 1
    squares: Mapping[Sum, float] = field(default_factory=dict)


def has_damping(system: System) -> bool:
    """Whether the sums of springpots, dashpots, arms and circuits are of anything."""
    linear = (part.dissipates and part.is_linear and "damping" in part.powers for part in system.parts)
    return bool(system.damping) or any(linear)
