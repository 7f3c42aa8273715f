"""Threads for computation: those of each tab, and what all tabs share: the simulation and modules."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import ParamSpec, TypeVar

from springpot.explorer.question import Opened
from springpot.explorer.shelf import Shelf
from springpot.machine.crew import threads_available
from springpot.problem.system import System

KERNELS = 2  # tabs that simulate at the same time
MOST_SESSIONS = 16  # tabs that are open

_P = ParamSpec("_P")
_T = TypeVar("_T")


class Turns:
    """Work of one tab, on the threads of all tabs: a piece begins when the one before has ended, wanted or not.

    Parameters
    ----------
    pool : ThreadPoolExecutor

    Examples
    --------
    >>> asyncio.run(Turns(ThreadPoolExecutor(1)).take(abs, -2))
    2
    """

    def __init__(self, pool: ThreadPoolExecutor) -> None:
        self._pool, self._free = pool, asyncio.Lock()

    async def take(self, function: Callable[_P, _T], *args: _P.args, **kwargs: _P.kwargs) -> _T:
        """Run a function on a thread."""
        await self._free.acquire()
        loop, work = asyncio.get_running_loop(), self._pool.submit(function, *args, **kwargs)

        def ended(_: object) -> None:
            with suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(self._free.release)

        work.add_done_callback(ended)
        return await asyncio.wrap_future(work)


class Engine:
    """Loads theory and kernel while the page is already shown, and computes outside the event loop.

    Parameters
    ----------
    opened : Opened
        What the page was opened with.

    Attributes
    ----------
    shelf : Shelf
        The systems that tabs may show.
    theory_ready, kernel_ready : asyncio.Event
    threads : int
        For one ensemble.
    """

    def __init__(self, opened: Opened) -> None:
        self.shelf = Shelf(opened)
        self.theory_ready, self.kernel_ready = asyncio.Event(), asyncio.Event()
        self.threads = max(1, threads_available() // KERNELS)
        self._kernel = ThreadPoolExecutor(KERNELS, "kernel")
        self._slow = ThreadPoolExecutor(3 * MOST_SESSIONS, "slow")  # of each tab theory, pilots and measured data

    async def load(self) -> None:
        """Import the modules."""
        await self.turns().take(_load_theory, self.shelf.at("").nominal)
        self.theory_ready.set()
        await self.simulate(_load_simulation)  # the kernel is compiled when it is asked for
        self.kernel_ready.set()

    def turns(self) -> Turns:
        """For one kind of slow work of a tab: it keeps neither another tab nor other work waiting."""
        return Turns(self._slow)

    async def simulate(self, function: Callable[_P, _T], *args: _P.args, **kwargs: _P.kwargs) -> _T:
        """Run a short part of a simulation; the tabs take turns."""
        # work that has not begun is cancelled if its tab closes or has a new problem
        return await asyncio.wrap_future(self._kernel.submit(function, *args, **kwargs))

    def close(self) -> None:
        """Cancel all work that has not begun."""
        for pool in (self._kernel, self._slow):
            pool.shutdown(wait=False, cancel_futures=True)


def have_kernel(system: System) -> None:
    """Compile the kernel in the precision of a system, and functions of its user, or read them from disk."""
    from springpot.simulation.paths.simulation import simulation_of
    from springpot.simulation.plan.plan import plan_of

    plan = plan_of(system, paths=1, start="rest", threads=1)
    step = plan.settings.step
    simulation_of(plan.but(duration=step, window=(0.0, step))).advance()


def _load_theory(system: System) -> None:
    from springpot.explorer.answers import solve

    solve(system, "envelope")


def _load_simulation() -> None:
    from springpot.explorer import gathering, motion  # noqa: F401
