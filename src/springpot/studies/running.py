"""Run a study: compute its missing tasks, and open its results.

Tasks run in threads of this process, in workers of a Dask cluster, or in one shard of a job array.  Each task is a pure
function, and the process that computed it adds its result to the store's record, so the results do not depend on where
it ran.  Several processes may use one store at the same time: each takes the missing tasks in its own random order and
skips those that another has finished.
"""

from __future__ import annotations

import itertools
import logging
import os
import queue
import random
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springpot.machine.arguments import check_called, check_whole, checked_path
from springpot.machine.crew import threads_available, work_together
from springpot.machine.faults import Stopped, shown
from springpot.machine.installed import need
from springpot.machine.interrupt import sigterm_as_ctrl_c
from springpot.machine.platforms import without_ctrl_c
from springpot.studies.dataset import to_xarray
from springpot.studies.labelled import finish, take_away_labelled
from springpot.studies.question import Study, read_study
from springpot.studies.store import Store, StoreError, open_store
from springpot.studies.tasks import Task, check_some, compute, tasks
from springpot.studies.workers import Workers

if TYPE_CHECKING:
    import xarray

Progress = Callable[[float], None]
TELL = 0.2  # s
CHECKED = 20_000  # points at which the settings of Monte Carlo are checked before any work: some seconds
PATIENCE = "20s"  # for a scheduler to answer
IN_FLIGHT = 4  # tasks submitted to a cluster for each of its threads: memory stays bounded, and no thread waits
RECOUNT = 1.0  # s between two looks at how many threads a cluster has: workers may come later


@dataclass(frozen=True)
class Outcome:
    """Result of `run_study`.

    Attributes
    ----------
    path : Path
    tasks : int
        Number of tasks of this study (of this shard).
    found, computed : int
        Results that were there already, and that were computed now.
    failures : tuple of (Task, str)
        Tasks that ended with an error; they have no result.
    labelled : bool
        Whether the study is finished and has its labelled group, which any xarray can open.
    """

    path: Path
    tasks: int
    found: int
    computed: int
    failures: tuple[tuple[Task, str], ...]
    labelled: bool


@dataclass
class _Count:
    """Progress of a run; shared by its threads."""

    total: int
    progress: Progress | None
    computed: int = 0
    others: int = 0
    under_way: dict[str, float] = field(default_factory=dict)
    failures: list[tuple[Task, str]] = field(default_factory=list)
    stopping: bool = False
    lock: threading.Lock = field(default_factory=threading.Lock)

    def ended(self, task: Task, found: bool | str) -> None:
        """Count a task: computed here, by another process, or failed for a reason."""
        if isinstance(found, str):
            self.failures.append((task, found))
        elif found:
            self.computed += 1
        else:
            self.others += 1

    def tell(self) -> None:
        """Call ``progress``; only in the thread that started the run."""
        if self.progress is not None and self.total:
            with self.lock:
                done = self.computed + self.others + len(self.failures) + sum(self.under_way.values())
            self.progress(min(1.0, done / self.total))


def run_study(
    study: Study,
    path: str | Path,
    *,
    threads: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    shard: tuple[int, int] = (1, 1),
    progress: Progress | None = None,
    labelled: bool = True,
) -> Outcome:
    """Compute every task of a study that has no result in the store.

    Parameters
    ----------
    study : Study
    path : str or Path
        Of the store; created if missing.
    threads : int, optional
        Tasks at a time in this process; all processors that it may use if left out.  For the same last bits of the
        envelope and the closure as on workers, set `OPENBLAS_NUM_THREADS` to 1 before NumPy is loaded; the command
        ``springpot`` does so.
    workers : int, optional
        Start a Dask cluster of so many processes on this machine instead; they share the processors.
    scheduler : str, optional
        Address of a running Dask scheduler to use instead, such as ``tcp://node1:8786``; its workers must see ``path``.
        On any cluster a worker's threads are shared by the tasks that it has: one for each, or several if they are few.
    shard : (int, int)
        (i, N) does only every N-th task, from the i-th: N jobs with i = 1 ... N do them all.
    progress : callable
        Called with the fraction done, some times a second, in the calling thread.
    labelled : bool
        Whether to write the labelled group when every task of the study has a result.

    Returns
    -------
    Outcome

    Raises
    ------
    TypeError, ValueError
        If an argument or the study is wrong, or the store is another study's.
    OSError
        If the store cannot be written.  What was written stays.
    KeyboardInterrupt
        On Ctrl-C, and on SIGTERM (`Terminated`).  What was written stays.

    Examples
    --------
    >>> import tempfile
    >>> from springpot.studies import read_study
    >>> orders = read_study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5]}})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     first = run_study(orders, f"{folder}/orders.store")
    ...     again = run_study(orders, f"{folder}/orders.store")
    >>> first.computed, again.computed, again.found
    (2, 0, 2)
    """
    from springpot.simulation.plan.settings import checked_threads

    if (workers is not None) + (scheduler is not None) + (threads is not None) > 1:
        raise ValueError("threads, workers and scheduler cannot be combined: give one of them.")
    number, of = shard
    if not 1 <= number <= of:
        raise ValueError(f"shard must be i/N with i from 1 to N, not {number}/{of}.")
    threads = checked_threads(threads)
    check_called(progress, "progress")
    if scheduler is not None and not isinstance(scheduler, str):
        raise TypeError(f"scheduler must be the address of a Dask scheduler, not {shown(scheduler)}.")
    if workers is not None:
        check_whole(workers, "workers", 1, 4096)
    try:
        path = checked_path(path, "store").resolve()
    except RuntimeError:  # of Python before 3.13
        raise StoreError(f"store {str(path)!r} is a link that leads back to itself: remove it.") from None
    with sigterm_as_ctrl_c():
        check_some(study, CHECKED)
        store = open_store(path, study)
        store.remove_orphans()
        mine = [task for index, task in enumerate(tasks(study)) if index % of == number - 1]
        missing = [task for task in mine if store.find(task) is None]
        # random order: two processes on one store rarely compute the same task, and the time left is estimated well
        random.SystemRandom().shuffle(missing)
        count = _Count(len(missing), progress)
        if missing:
            with store.writing():
                take_away_labelled(store)
            if workers is not None or scheduler is not None:
                _on_a_cluster(store, missing, count, workers, scheduler)
            else:
                _on_threads(store, missing, count, threads)
        try:
            with store.writing():
                whole = labelled and not count.failures and finish(store)
        except OSError:
            if count.computed:
                raise
            whole = False  # a read-only store stays as it was
    already_there = len(mine) - len(missing) + count.others
    return Outcome(path, len(mine), already_there, count.computed, tuple(count.failures), whole)


def _on_threads(store: Store, missing: Sequence[Task], count: _Count, threads: int) -> None:
    waiting = iter(missing)
    inner = max(1, threads // len(missing))  # a few large tasks share the threads

    def work() -> None:
        while not count.stopping:
            with count.lock:
                task = next(waiting, None)
            if task is None:
                return
            _one(store, task, inner, count)

    def halt() -> None:
        count.stopping = True  # threads end at the next report of their task, or at its end

    work_together(work, min(threads, len(missing)), stop=halt, tell=count.tell, every=TELL)


def _one(store: Store, task: Task, threads: int, count: _Count) -> None:
    """Compute one task and save its result, unless another process has done so."""

    def alive(fraction: float) -> None:
        if count.stopping:
            raise Stopped
        with count.lock:
            count.under_way[task.key] = fraction

    try:
        found: bool | str = _computed(store, task, threads, alive)
    except Stopped:
        return
    except (OSError, MemoryError):
        raise
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    with count.lock:
        count.under_way.pop(task.key, None)
        count.ended(task, found)


def _computed(store: Store, task: Task, threads: int, progress: Progress | None = None) -> bool:
    """Whether this was the one to compute and save a result, and not another process before."""
    if store.has(task):
        return False
    store.write(task, compute(task, threads=threads, progress=progress, save=store.repetitions(task)))
    return True


@lru_cache(maxsize=8)
def _store_at(path: str) -> Store:
    return open_store(path)


def _remote(path: str, task: Task) -> bool:
    """Compute and save a task in a worker of a cluster; False if the store has its result already."""
    from distributed import get_worker

    state = get_worker().state  # all tasks that the worker has now share its threads
    threads = max(1, state.nthreads // max(1, len(state.executing) + len(state.ready)))
    return _computed(_store_at(path), task, threads)


def _on_a_cluster(
    store: Store, missing: Sequence[Task], count: _Count, workers: int | None, scheduler: str | None
) -> None:
    from distributed.comm.core import CommClosedError

    with _client(workers, scheduler) as (client, own):
        try:
            _submit_all(client, own, store, missing, count)
        except Exception as error:
            # a closed connection may show before the client knows of it
            if client.status != "running" or isinstance(error, CommClosedError):
                raise OSError(
                    "the Dask scheduler is gone: all results so far are kept, and running the study again continues "
                    "from there."
                ) from error
            raise


def _submit_all(client: Any, own: Workers | None, store: Store, missing: Sequence[Task], count: _Count) -> None:
    waiting = iter(missing)
    of_key: dict[str, Task] = {}
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def submit(some: Sequence[Task]) -> None:
        """All in one message: a worker that gets several knows of all of them when it begins the first."""
        # new keys each time: a cluster may cache the result of a key
        keys = [f"springpot-{task.key}-{os.urandom(4).hex()}" for task in some]
        of_key.update(zip(keys, some, strict=True))
        for future in client.map(_remote, [str(store.path)] * len(some), some, key=keys):
            future.add_done_callback(ended.put)

    room, counted = 0, -RECOUNT
    while True:
        if time.monotonic() - counted > RECOUNT:
            threads = sum(client.nthreads().values()) if own is None else own.count * own.threads
            room, counted = max(1, IN_FLIGHT * threads), time.monotonic()
        if some := list(itertools.islice(waiting, max(0, room - len(of_key)))):
            submit(some)
        if not of_key:
            return
        futures = []
        with suppress(queue.Empty):  # all that have ended, after waiting a moment for the first
            futures.append(ended.get(timeout=TELL))
            while True:
                futures.append(ended.get_nowait())
        if own is not None:
            own.replace_ended(progress=bool(futures))
        if client.status != "running":
            raise ConnectionError("the scheduler is gone")
        for future in futures:
            if future.status in ("lost", "pending"):  # its worker died with the answer: the cluster asks another one
                future.add_done_callback(ended.put)
            else:
                _take(future, of_key.pop(future.key), count)
        count.tell()


def _take(future: Any, task: Task, count: _Count) -> None:
    """Count a task that a worker has finished, or record its error."""
    if future.status == "finished":
        count.ended(task, future.result())
    elif future.status != "error":
        raise ConnectionError("a task was cancelled by the cluster")
    else:
        error = future.exception()
        if isinstance(error, OSError | MemoryError | StoreError):  # all other tasks would fail too
            raise error
        count.ended(task, f"{type(error).__name__}: {error}")
    future.release()


@contextmanager
def _client(workers: int | None, scheduler: str | None) -> Iterator[tuple[Any, Workers | None]]:
    need("cluster", "a study with workers or a scheduler")
    import dask
    import distributed

    if scheduler is not None:
        try:
            client = distributed.Client(scheduler, timeout=PATIENCE)
        except (OSError, ValueError, TimeoutError) as error:
            raise OSError(f"there is no Dask scheduler at {scheduler!r}: {error}") from None
        with client:
            yield client, None
        return
    count = workers or 1
    # a killed worker's connection may be found closed after silence_logs has ended
    logging.getLogger("distributed.batched").setLevel(logging.CRITICAL)
    with dask.config.set({"distributed.scheduler.allowed-failures": 10}):
        with without_ctrl_c():
            cluster = distributed.LocalCluster(
                n_workers=0, silence_logs=50, host="127.0.0.1",
                # no dashboard; without an address, Dask's server would claim port 8787, and complain where it is taken
                scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
            )  # fmt: skip
        with (
            cluster,
            distributed.Client(cluster) as client,
            # ended first: closing the cluster waits for none
            Workers(cluster.scheduler_address, count, max(1, threads_available() // count)) as own,
        ):
            yield client, own


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
