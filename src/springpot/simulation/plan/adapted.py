"""The start of a stationary run, as pilot runs found it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Adapted:
    """A stationary start: x(0) and its error.  Made by `springpot.simulation.estimate.stationary_start.adapt`.

    Attributes
    ----------
    position : float, or dict of float
        x(0), in m; with several masses that of each.
    residual, residual_se : float or None
        |E[x] - x(0)| over the root mean square displacement, and its standard error, measured by an independent pilot
        run before the last correction of x(0); of several masses the largest.  None if pilot runs would take too long;
        x(0) is then that of averaging, or of rest.
    error : float or None
        Standard error of x(0), over the root mean square displacement; None without pilot runs.  With slopes it is that
        along the way by which they were measured.
    pilots : int
        Number of pilot runs.
    slopes : dict of float
        How much each result changes with x(0), over the root mean square displacement, in size: measured by pilot runs
        from places apart.  Empty where the error of x(0) fades, or no pilots were far enough apart.
    """

    position: float | dict[str, float]
    residual: float | None
    residual_se: float | None
    error: float | None
    pilots: int
    slopes: Mapping[str, float] = field(default_factory=dict)
