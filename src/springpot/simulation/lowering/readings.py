"""How results are read from the sums of the paths, where the kernel's sums have names of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from springpot.problem.system import System


@dataclass(frozen=True)
class Reading:
    """One result as a sum of columns over steps, time or other columns.

    Attributes
    ----------
    name : str
        Of the result.
    above : dict
        The columns of the sum, each with its factor.
    over : {"steps", "time", "groups", "one"} or sequence of str
        What it is divided by: the steps, the time or the groups of steps of the window, nothing, or the sum of columns
        (a ratio of two means over all paths).
    added : float
        To the quotient.
    power : int
        Of the sum of each path.
    squares : dict
        Columns whose squares are added to that, each with its factor.
    """

    name: str
    above: Mapping[str, float]
    over: Literal["steps", "time", "groups", "one"] | tuple[str, ...] = "steps"
    added: float = 0.0
    power: int = 1
    squares: Mapping[str, float] = field(default_factory=dict)


def has_damping(system: System) -> bool:
    """Whether the sums of springpots, dashpots, arms and circuits are of anything."""
    linear = (part.dissipates and part.is_linear and "damping" in part.powers for part in system.parts)
    return bool(system.damping) or any(linear)
