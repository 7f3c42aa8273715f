"""Run a study in one call, and open its results as a labelled data set."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springpot.studies.dataset import to_xarray
from springpot.studies.question import Study, read_study
from springpot.studies.running import run_study
from springpot.studies.store import open_store

if TYPE_CHECKING:
    import xarray


def open_study(store: str | Path) -> xarray.DataTree:
    """Open a store: all results of a study so far, labelled, read from disk at first use.

    Parameters
    ----------
    store : str or Path
        The folder that `study` or ``springpot study run`` has written.

    Returns
    -------
    xarray.DataTree
        ``/theory`` has the dimension ``theory`` (the method) and the study's axes, ``/simulation`` the axes alone,
        ``/exceedance`` the axes and ``<quantity>_level``.  First passages in ``/simulation`` have the dimension
        ``<quantity>_first_passage_level``.
        All have all quantities by name, with units, and NaN where there is none; ``done`` says whether there is a
        result, ``said`` has its warnings or the reason why there is none.  Results of Monte Carlo also have ``_se``
        (standard error) and, where ``rtol`` controls them, ``_error`` (half-width of the total 95 % interval).
        Of a system the results of each wall have the dimension ``barrier``.

    Raises
    ------
    ValueError
        If it is not a store, or was written by a newer version.

    Examples
    --------
    >>> try:
    ...     open_study("nowhere.store")
    ... except ValueError as error:
    ...     print(str(error).partition(":")[0])
    there is no store 'nowhere.store'
    """
    return to_xarray(open_store(store))


def study(
    source: str | Path | Mapping[str, Any] | Study,
    store: str | Path | None = None,
    *,
    threads: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> xarray.DataTree:
    """Compute a grid of oscillators or systems by one or more methods, and keep the results.

    Parameters
    ----------
    source : str, Path, mapping or Study
        A study file (``springpot study new`` writes an example), or its content: ``name``, ``methods``, ``axes``
        and, as needed, ``fixed``, ``zipped``, ``monte_carlo``, ``quantities``, ``seed``; or ``system``, a
        `springpot.System` or the place of its file, whose numbers ``parts.<name>.<number>`` are then the axes.
    store : str or Path, optional
        Folder of the store: created if missing; results in it are not computed again.  Without one all results are kept
        in memory only.
    threads, workers, scheduler
        Where the tasks run: threads of this process (all processors if left out), that many worker processes of a Dask
        cluster, or the Dask scheduler at that address.  The numbers are the same, to the bit.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    xarray.DataTree
        As from `open_study`.

    Raises
    ------
    TypeError, ValueError
        If the study or an argument is wrong, or the store is another study's.
    OSError
        If the store cannot be written; what was written stays.

    Warns
    -----
    UserWarning
        If tasks failed; their numbers are NaN.

    Examples
    --------
    >>> tree = study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.5, 1.0], "restitution": [1.0]}})
    >>> tree["theory"]["amplitude_mean_square"].sel(theory="averaging", restitution=1.0).values.round(3).tolist()
    [2.296, 1.0]

    The impact rate at an elastic stop, and how it falls with the gap:

    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.4), stop=sp.Barrier(0.0))
    >>> tree = study({"name": "gaps", "system": device, "methods": ["exact"],
    ...               "axes": {"parts.stop.position": [0.0, -1.0]}})
    >>> tree["theory"]["barrier_impact_rate"].sel(theory="exact", barrier="stop").values.round(3).tolist()
    [0.318, 0.115]
    """
    content = read_study(source)
    with tempfile.TemporaryDirectory(prefix="springpot-") if store is None else nullcontext("") as folder:
        place = Path(folder) / "study" if store is None else store
        outcome = run_study(
            content, place, threads=threads, workers=workers, scheduler=scheduler, progress=progress,
            labelled=store is not None,
        )  # fmt: skip
        if outcome.failures:
            task, reason = outcome.failures[0]
            warnings.warn(
                f"{len(outcome.failures)} tasks failed, the first of them {task.method}: {reason}",
                UserWarning,
                stacklevel=2,
            )
        tree = open_study(place)
        return tree.load() if store is None else tree
