"""The start of a stationary run, as pilot runs found it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Adapted:
    """A stationary start: x(0) and its error.  Made by `springpot.simulation.estimate.stationary_start.adapt`.

    Attributes
    ----------
    position : float
        x(0), in m.
    residual, residual_se : float or None
        |E[x] - x(0)| over the root mean square displacement, and its standard error, measured by an independent pilot
        run before the last correction of x(0).  None if pilot runs would take too long; x(0) is then that of averaging.
    error : float or None
        Standard error of x(0), over the root mean square displacement; None without pilot runs.
    pilots : int
        Number of pilot runs.
    """

    position: float
    residual: float | None
    residual_se: float | None
    error: float | None
    pilots: int
