"""One tab: its latest problem, the work for it, and the messages to be sent.

There is no queue.  Only the newest message of each kind waits to be sent, and a frame of the moving mass contains the
motion since the last frame: a tab that reads slowly gets fewer, longer frames, and needs no more memory.
"""

from __future__ import annotations

import asyncio
import json
import math
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.explorer import frames
from springpot.explorer.copies import as_command, as_python
from springpot.explorer.engine import Engine
from springpot.explorer.protocol import NextPath, Play, Problem, Step
from springpot.oscillator import Oscillator, Springpot

if TYPE_CHECKING:
    from springpot.explorer.gathering import Gathering
    from springpot.explorer.motion import Player
    from springpot.options import StartKind

__all__ = ["Session"]

LONGEST_WAIT = 0.25  # s; the longest time between two frames by which the motion is advanced
SETTLE = 0.15  # s without a new problem before the slow curve over the order is computed
HISTOGRAM_BINS = 60
DENSITIES = ("x", "v", "amplitude", "impact_speed")
MOST_WORK = 4e10  # steps of all paths: some minutes


class Session:
    """The work for one tab.

    Parameters
    ----------
    engine : Engine
        Shared by all tabs.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._question: Problem | None = None  # the newest
        self._problem: Problem | None = None  # the one that is being answered
        self._asked = asyncio.Event()
        self._slots: dict[str, str | bytes] = {}
        self._player: Player | None = None
        self._next_path = asyncio.Event()
        self._playing, self._speed, self._nudges = True, 4.0, 0
        self._may_run = asyncio.Event()
        self._may_run.set()
        self._last = time.monotonic()
        self._post("status", theory=engine.theory_ready.is_set(), kernel=engine.kernel_ready.is_set())

    # --- messages from the tab --------------------------------------------------------------------------------------

    def receive(self, message: Problem | Play | Step | NextPath) -> None:
        """Take a message that `springpot.explorer.protocol.parse` has accepted."""
        match message:
            case Problem():
                self._question = message
                self._asked.set()
            case Play():
                self._playing, self._speed = message.playing, message.speed
                if self._playing:
                    self._may_run.set()
                else:
                    self._may_run.clear()
            case Step():
                self._nudges = min(self._nudges + 1, 100)
                self._may_run.set()
            case NextPath():
                self._next_path.set()

    def refuse(self, sentence: str) -> None:
        """Tell the tab why a message was refused."""
        self._post("refused", sentence=sentence)

    # --- messages to the tab ----------------------------------------------------------------------------------------

    def due(self) -> list[str | bytes]:
        """Messages to send now."""
        now = time.monotonic()
        elapsed, self._last = min(now - self._last, LONGEST_WAIT), now
        messages, self._slots = list(self._slots.values()), {}
        player, problem = self._player, self._problem
        if player is not None and problem is not None:
            from springpot.explorer.motion import NUDGE

            if self._playing:
                player.forward(elapsed * self._speed)
            elif self._nudges:
                player.forward(NUDGE * self._nudges)
            self._nudges = 0
            if part := player.due():
                messages.append(frames.pack(frames.MOTION, problem.generation, part))
            if player.ended and self._playing:
                self._next_path.set()
        return messages

    def _post(self, kind: str, **content: Any) -> None:
        generation = 0 if self._problem is None else self._problem.generation
        self._slots[kind] = json.dumps({"kind": kind, "generation": generation, **content}, allow_nan=False)

    # --- the work ---------------------------------------------------------------------------------------------------

    async def compute(self) -> None:
        """Compute the newest problem; its work is cancelled when the next one comes.  Runs until it is cancelled."""
        work: asyncio.Future[Any] | None = None
        try:
            while True:
                await self._asked.wait()
                self._asked.clear()
                if work is not None:
                    await _drop(work)
                self._problem = problem = self._question
                assert problem is not None
                self._player = None
                self._slots = {kind: text for kind, text in self._slots.items() if kind in ("status", "refused")}
                self._post("accepted", command=as_command(problem), python=as_python(problem))
                work = asyncio.gather(
                    *(self._guarded(part, problem) for part in (self._curve, self._theory, self._simulation))
                )
        finally:
            if work is not None:
                await _drop(work)

    async def _guarded(self, part: Callable[[Problem], Awaitable[None]], problem: Problem) -> None:
        """Run a part of the work; an error is shown in its tab and does not affect other tabs."""
        try:
            await part(problem)
        except Exception as error:
            text = " ".join(str(error).split())[:400]
            self._post("trouble", sentence=text if isinstance(error, ValueError) else f"{type(error).__name__}: {text}")

    async def _theory(self, problem: Problem) -> None:
        engine, oscillator = self._engine, problem.oscillator()
        await engine.theory_ready.wait()
        self._post("status", theory=True, kernel=engine.kernel_ready.is_set())
        from springpot.explorer import answers

        solved = await engine.think(answers.solve, oscillator)
        self._post("theory", **await engine.think(answers.table, oscillator, *solved))
        await engine.kernel_ready.wait()
        self._post("status", theory=True, kernel=True)
        from springpot.explorer import gathering
        from springpot.simulation.settings import resolve

        settings = await engine.simulate(
            resolve, oscillator, paths=problem.paths, seed=problem.seed, start="rest", threads=1
        )
        times = gathering.growth_times(oscillator, settings)
        from_rest = _start(problem, oscillator) == "rest"
        curves = await engine.think(answers.growth, oscillator, solved[0], times, from_rest=from_rest)
        self._post("growth", times=times.tolist(), methods=curves)

    async def _simulation(self, problem: Problem) -> None:
        engine, oscillator = self._engine, problem.oscillator()
        await engine.kernel_ready.wait()
        from springpot.explorer import gathering
        from springpot.simulation.adapted import adapt
        from springpot.simulation.settings import resolve
        from springpot.simulation.simulation import simulation_of

        settings = await engine.simulate(
            resolve,
            oscillator,
            paths=problem.paths,
            seed=problem.seed,
            start=_start(problem, oscillator),
            threads=engine.threads,
        )
        if settings.steps * settings.paths > MOST_WORK:
            raise ValueError(
                f"paths: {settings.paths} paths of {settings.steps} steps take too long for a page: use at most "
                f"{int(MOST_WORK / settings.steps)}, or the command."
            )
        adapted = None
        if settings.start == "stationary":
            self._post("searching")
            with stopping() as check:
                adapted = await engine.pilot(adapt, oscillator, settings, progress=check)
        simulation = await engine.simulate(simulation_of, oscillator, settings, adapted)
        growing = await engine.simulate(gathering.Gathering, simulation)
        await asyncio.gather(self._show(problem, growing), self._gather(growing))

    async def _show(self, problem: Problem, growing: Gathering) -> None:
        """Record and play one path after the other, for the moving mass."""
        from springpot.explorer import motion

        number = 0
        while True:
            recorded = await self._engine.simulate(motion.record, growing.simulation, number)
            self._player = motion.Player(recorded, natural_frequency=problem.natural_frequency)
            self._next_path.clear()
            await self._next_path.wait()
            number = (number + 1) % motion.blocks(growing.simulation.settings)

    async def _gather(self, growing: Gathering) -> None:
        while not growing.complete:
            await self._may_run.wait()
            if not self._playing:
                self._may_run.clear()  # a single step
            report, densities, growth = await self._engine.simulate(_grown, growing)
            problem = self._problem
            assert problem is not None
            self._post("estimates", **report)
            self._slots["densities"] = frames.pack(frames.DENSITIES, problem.generation, densities)
            self._slots["grown"] = frames.pack(frames.GROWTH, problem.generation, growth)

    async def _curve(self, problem: Problem) -> None:
        engine, oscillator = self._engine, problem.oscillator()
        await engine.theory_ready.wait()
        from springpot.explorer.answers import along_the_order

        key = replace(oscillator, springpot=Springpot(0.5, oscillator.springpot.coefficient))
        curve = engine.curve(key)
        if curve is None:
            points = along_the_order(key)
            curve = await engine.think(next, points)
            self._post("curve", **curve)
            await asyncio.sleep(SETTLE)
            while curve["missing"]:
                curve = await engine.think(next, points)
                self._post("curve", **curve)
            engine.keep_curve(key, curve)
        self._post("curve", **curve)


@contextmanager
def stopping() -> Iterator[Callable[[float], None]]:
    """A function that work on another thread calls repeatedly; it ends that work when its result is not needed."""
    unwanted = threading.Event()

    def check(_: float) -> None:
        if unwanted.is_set():
            raise asyncio.CancelledError

    try:
        yield check
    finally:
        unwanted.set()


def _start(problem: Problem, oscillator: Oscillator) -> StartKind:
    """The start of the page's run: from rest if there is no stationary state."""
    from springpot.simulation.settings import default_start

    return "rest" if problem.start == "rest" else default_start(oscillator)[0]


async def _drop(work: asyncio.Future[Any]) -> None:
    work.cancel()
    await asyncio.gather(work, return_exceptions=True)


def _grown(growing: Gathering) -> tuple[dict[str, Any], list[Any], list[Any]]:
    """Grow an ensemble: a report of its estimates, densities, and <A^2> over time."""
    growing.grow()
    values, errors = growing.estimates()
    settings = growing.simulation.settings
    report = {
        "paths": growing.paths,
        "of": settings.paths,
        "complete": growing.complete,
        "seconds": growing.seconds,
        "values": _finite(values),
        "errors": _finite(errors),
        "warnings": growing.warnings() if growing.complete else (),
        "settings": {
            "duration": settings.duration,
            "step": settings.step,
            "window": settings.window,
            "initial_position": settings.initial_position,
            "start": settings.start,
        },
        "stationary": growing.stationary,
    }
    densities: list[Any] = []
    distributions = growing.distributions()
    for name in DENSITIES:
        edges, density, _ = distributions[name].density(HISTOGRAM_BINS)
        densities += [edges, density]
    return report, densities, list(growing.growth())


def _finite(numbers: dict[str, float]) -> dict[str, float | None]:
    return {name: float(value) if math.isfinite(np.float64(value)) else None for name, value in numbers.items()}
