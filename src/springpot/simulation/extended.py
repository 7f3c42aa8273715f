"""More paths for a run that is there already: the bits of one run of them all."""

from __future__ import annotations

from collections.abc import Sequence

from springpot.machine.faults import shown
from springpot.simulation.extended_to import extended_to
from springpot.simulation.more_paths import with_paths
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.result.results import Run

__all__ = ["extend"]


def extend(
    run: Run,
    *,
    paths: int | None = None,
    rtol: float | None = None,
    quantities: Sequence[str] = ("amplitude_mean_square",),
    threads: int | None = None,
    progress: Progress | None = None,
) -> Run:
    """Add paths to a run, which may come from a file: so many, or as many as a relative error needs.

    The paths that are there are not computed again, but for the first 64, which show that this machine and this version
    of springpot give the same bits.  A stationary start stays that of the run.

    Parameters
    ----------
    run : Run
        Of `springpot.run`, or of `springpot.load_run` if it was saved with ``path_sums=True``.
    paths : int
        Number of paths afterwards.
    rtol : float
        Instead of ``paths``: the total relative error of ``quantities`` afterwards, in [1e-4, 0.5].  Step, window and
        start stay those of the run: what they leave is bounded, that of the step with pairs of paths at the step and
        at half of it.
    quantities : sequence of str
        With ``rtol``: the results that it controls.
    threads : int
        Those of the run if left out; the result does not depend on it.
    progress : callable
        Called with the fraction done, from any thread.

    Returns
    -------
    Run
        To the last bit that of one run of so many paths with the same x(0).  With ``rtol`` it also has ``budgets`` of
        the quantities; their number of paths depends on the run and on ``rtol`` alone.

    Raises
    ------
    TypeError
        If ``run`` is not a run, or ``paths`` or ``threads`` no whole number.
    ValueError
        If neither or both of ``paths`` and ``rtol`` are given, or ``threads`` is below 1; or the run has as many paths
        already, has results that need every step of each path (distributions, spectrum, observables, first passages),
        was made with ``rtol``, was saved without the sums of its paths, or its bits cannot be had again here.  With
        ``rtol`` also if no number of paths reaches it: the sentence says what is in the way.

    Notes
    -----
    A run that was made with ``rtol`` chose step, window and start for that error.  A smaller one needs others, so that
    such a run is not continued: run it with the smaller ``rtol``.

    Examples
    --------
    >>> import springpot as sp
    >>> first = sp.run(sp.Oscillator(), paths=100, duration=2.0, start="rest")
    >>> sp.extend(first, paths=200).values == sp.run(sp.Oscillator(), paths=200, duration=2.0, start="rest").values
    True
    """
    _check(run)
    if progress is not None and not callable(progress):
        raise TypeError(f"progress must be a function of the fraction done, not {shown(progress)}.")
    if (paths is None) == (rtol is None):
        raise ValueError("paths or rtol must be given, and not both.")
    if rtol is not None:
        return extended_to(run, rtol, quantities, threads, progress)
    return with_paths(run, paths, threads, progress)


def _check(run: object) -> None:
    if not isinstance(run, Run):
        raise TypeError(f"run must be a Run, not {shown(run)}.")
    if run.budgets and not run.path_sums.size:
        raise ValueError("run must not be made with rtol, whose paths have several steps: run it with another rtol.")
    more = {
        "distributions": run.distributions,
        "a spectrum": run.spectrum is not None,
        "first passages": run.first_passages,
        "observables": [name for name, unit in run.units.items() if not unit or name.startswith("counted_")],
    }
    if there := [name for name, value in more.items() if value]:
        raise ValueError(f"run must have moments only, but it has {there[0]}, which need every step of each path.")
    if not run.path_sums.size:
        raise ValueError("run was saved without the sums of its paths: save it with path_sums=True.")
