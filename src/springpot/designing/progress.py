"""The time that a design may take, and how far it is: asked between the steps of a search, and within runs."""

from __future__ import annotations

import math

from springpot.machine.progress import Clock, Estimate, FractionDone
from springpot.simulation.paths.simulation import Progress

SEARCH = 0.2  # of the whole: what comes before the first round of Monte Carlo
LITTLE = 0.01  # of what is left of the search: one step of it, whose number is not known beforehand


class DesignProgress:
    """Says that the work goes on, and ends it when the time is over.

    Parameters
    ----------
    limit : float or None
        In s, of the whole.
    progress : callable or None
    rounds : int
        Of Monte Carlo, at most.

    Examples
    --------
    >>> told = []
    >>> work = DesignProgress(None, told.append, 6)
    >>> work.step()
    >>> work.round(5, 1.0)
    >>> told
    [0.002, 1.0]
    """

    def __init__(self, limit: float | None, progress: Progress | None, rounds: int) -> None:
        self.clock, self._progress, self._rounds = Clock(limit), progress, rounds
        self._done = 0.0
        self._second: tuple[float, float] | None = None  # when the second short run began, and the share done then

    @property
    def left(self) -> float | None:
        """Seconds that are left; None without a limit."""
        return self.clock.left if math.isfinite(self.clock.limit) else None

    def say(self) -> None:
        """At the beginning."""
        self._tell(0.0)

    def step(self) -> None:
        """Between two steps of a search.

        Raises
        ------
        OutOfTimeError
            If the time is over.
        """
        self._tell(self._done + LITTLE * max(SEARCH - self._done, 0.0))

    def short_run(self, fraction: float, run: int, runs: int, path_steps: float) -> None:
        """Within one of the short runs that take the place of theory."""
        share, seconds = (run + fraction) / runs, math.nan
        if run and self._second is None:  # the first one may have compiled the kernel
            self._second = self.clock.elapsed, share
        elif self._second is not None and share > self._second[1]:
            begun, before = self._second
            seconds = (self.clock.elapsed - begun) * (1.0 - share) / (share - before)
        self._tell(SEARCH * share, Estimate(path_steps, seconds, f"short runs at {runs} places", math.nan))

    def round(self, number: int, fraction: float) -> None:
        """Within one round of Monte Carlo."""
        estimate = getattr(fraction, "estimate", None)
        self._tell(SEARCH + (1.0 - SEARCH) * (number + fraction) / self._rounds, estimate)

    def end(self) -> None:
        """All is done; what is asked of the result later has its own time."""
        self.clock.limit, progress, self._progress = math.inf, self._progress, None
        if progress is not None:
            progress(1.0)

    def _tell(self, fraction: float, estimate: Estimate | None = None) -> None:
        self.clock.check()
        self._done = max(self._done, min(fraction, 1.0))
        if self._progress is not None:
            self._progress(FractionDone(self._done, estimate))
