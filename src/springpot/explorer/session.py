"""One tab: its latest problem, the work for it, and when which message is sent to the page.

There is no queue.  Only the newest message of each kind waits to be sent, and a frame of the moving mass contains the
motion since the last frame: a tab that reads slowly gets fewer, longer frames, and needs no more memory.
"""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from springpot.explorer.engine import Engine, have_kernel
from springpot.explorer.measured import Measured, Parts, Work, sentence_of
from springpot.explorer.protocol import (
    DENSITIES,
    GROWTH,
    MOTION,
    AnyMessage,
    File,
    FilePart,
    Fit,
    NextPath,
    Observe,
    Play,
    Problem,
    Rare,
    Scatter,
    Step,
    StopWork,
    pack,
)
from springpot.explorer.question import Question, question_of
from springpot.machine.plain import plain

if TYPE_CHECKING:
    from springpot.explorer.gathering import Gathering
    from springpot.explorer.motion import Player
    from springpot.problem.system import System

LONGEST_WAIT = 0.25  # s; the longest time between two frames by which the motion is advanced
SETTLE = 0.15  # s without a new problem before the slow curve over the order is computed
HISTOGRAM_BINS = 60
SHOWN_SETTINGS = ("duration", "step", "window", "initial_position", "start")
MOST_WORK = 4e10  # steps of all paths: some minutes
KEPT = ("status", "refused", "data", "fit", "shelved")  # messages that another question leaves
NOTICED = 0.7  # s, after which a compilation is said


class Session:
    """The work for one tab.

    Parameters
    ----------
    engine : Engine
        Shared by all tabs.
    place : str
        Of the tab's system on the shelf; what the page was opened with, if nothing is there.
    """

    def __init__(self, engine: Engine, place: str = "") -> None:
        self._engine = engine
        self._opened, self._parts = engine.shelf.at(place), Parts()
        self._theorists, self._pilots = engine.turns(), engine.turns()
        self._newest: Question | None = None
        self._question: Question | None = None  # the one that is being answered
        self._asked = asyncio.Event()
        self._slots: dict[str, str | bytes] = {}
        self._player: Player | None = None
        self._next_path = asyncio.Event()
        self._playing, self._speed, self._nudges = True, 4.0, 0
        self._may_run = asyncio.Event()
        self._may_run.set()
        self._last = time.monotonic()
        self._measured = Measured(engine.turns(), self._post)
        self._observing, self._splitting, self._scattering = (Work(engine.turns(), self._post) for _ in range(3))
        self._stopped_by: dict[str, Work] = {
            "stop-fit": self._measured, "stop-observing": self._observing, "stop-rare": self._splitting,
            "stop-scatter": self._scattering,
        }  # fmt: skip
        self._post("status", theory=engine.theory_ready.is_set(), kernel=engine.kernel_ready.is_set())

    # --- messages from the tab --------------------------------------------------------------------------------------

    def receive(self, message: AnyMessage) -> None:
        """Take a message that `springpot.explorer.protocol.parse` has accepted.

        Raises
        ------
        ValueError
            If its numbers make no system: the work goes on as before.
        """
        match message:
            case Problem():
                self._newest = question_of(message, self._opened)
                self._close_requests()
                self._asked.set()
            case File():
                from springpot.problem.file import to_toml

                question = self._present("file")
                self._post("file", name=question.file, text=to_toml(question.devices))
            case FilePart(kind="data"):
                self._measured.take(message)
            case FilePart():
                if (content := self._parts.whole(message)) is not None:
                    self._shelve(message, content)
            case Fit():
                self._measured.fit(self._present("fit").system, message.free)
            case Observe():
                from springpot.explorer.requests import observed

                question = self._present("observe")
                run = self._settings(question, paths=question.asked.paths, start=question.start)
                self._observing.begin("observed", observed, question.system, message, run)
            case Rare():
                from springpot.explorer.rare import growing

                question = self._present("rare")
                run = self._settings(question, start=question.start)
                self._splitting.begin("rare", growing, question.system, message, run)
            case Scatter():
                from springpot.explorer.scattering import scattered

                question = self._present("scatter")
                run = self._settings(question, devices=message.devices)
                self._scattering.begin("scatter", scattered, question.devices, message.length, run)
            case StopWork():
                self._stopped_by[message.kind].stop()
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

    def _present(self, kind: str) -> Question:
        """The question that is being answered."""
        if self._question is None:
            raise ValueError(f"{kind}: no problem was asked.")
        return self._question

    def _shelve(self, part: FilePart, content: bytes) -> None:
        """Put a system's file on the shelf, where the page opens it; or the present system with another table."""
        name, said = part.name, ""
        try:
            if part.kind == "table":
                from springpot.explorer.excitation import with_table
                from springpot.problem.file import to_toml

                question = self._present("table")
                system, notes = with_table(question.devices, content, name, part.unit)
                said = "; ".join([f"{name} was read", *notes]) if notes else ""
                name, text = question.file, to_toml(system)
            else:
                text = content.decode()
            self._post("shelved", of=part.kind, place=self._engine.shelf.put(text, name), said=said, fault="")
        except (TypeError, ValueError) as error:
            self._post("shelved", of=part.kind, place="", said="", fault=sentence_of(error))

    def _settings(self, question: Question, **more: Any) -> dict[str, Any]:
        """Those of a run that was asked for beside."""
        return {"seed": question.asked.seed, "threads": self._engine.threads, **more}

    def refuse(self, sentence: str, asked: int | None = None) -> None:
        """Tell the tab why a message was refused, and the number of the question if it was one."""
        self._post("refused", sentence=sentence, asked=asked)

    # --- messages to the tab ----------------------------------------------------------------------------------------

    def due(self) -> list[str | bytes]:
        """Messages to send now."""
        now = time.monotonic()
        elapsed, self._last = min(now - self._last, LONGEST_WAIT), now
        messages, self._slots = list(self._slots.values()), {}
        player, question = self._player, self._question
        if player is not None and question is not None:
            from springpot.explorer.motion import NUDGE

            if self._playing:
                player.forward(elapsed * self._speed)
            elif self._nudges:
                player.forward(NUDGE * self._nudges)
            self._nudges = 0
            if part := player.due():
                messages.append(pack(MOTION, question.asked.generation, part))
            if player.ended and self._playing:
                self._next_path.set()
        return messages

    def _post(self, kind: str, **content: Any) -> None:
        generation = 0 if self._question is None else self._question.asked.generation
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
                self._question = question = self._newest
                assert question is not None
                self._player = None
                self._slots = {kind: text for kind, text in self._slots.items() if kind in KEPT}
                self._post("accepted", command=question.command, python=question.python, laws=question.laws)
                parts = self._view, self._curve, self._theory, self._simulation
                work = asyncio.gather(*(self._guarded(part, question) for part in parts))
        finally:
            if work is not None:
                await _drop(work)

    def close(self) -> None:
        """The tab is closed: what is running for it ends soon."""
        self._measured.close()
        self._close_requests()

    def _close_requests(self) -> None:
        for work in (self._observing, self._splitting, self._scattering):
            work.close()

    async def _guarded(self, part: Callable[[Question], Awaitable[None]], question: Question) -> None:
        """Run a part of the work; an error is shown in its tab and does not affect other tabs."""
        try:
            await part(question)
        except Exception as error:
            self._post("trouble", sentence=sentence_of(error))

    async def _view(self, question: Question) -> None:
        """The equation, how far the mass moves, and what the paper's problem adds."""
        await self._engine.theory_ready.wait()
        from springpot.explorer.views import view_of

        self._post("view", **await self._theorists.take(view_of, question.system))

    async def _theory(self, question: Question) -> None:
        engine, system, think = self._engine, question.system, self._theorists.take
        await engine.theory_ready.wait()
        self._post("status", theory=True, kernel=engine.kernel_ready.is_set())
        from springpot.explorer import answers
        from springpot.theory.registry import METHODS

        found, statements = dict[str, Any](), dict[str, str]()
        for name in METHODS:  # one by one: the next question waits for one at most
            answer, statement = await think(answers.solve, system, name)
            if answer is None:
                statements[name] = statement
            else:
                found[name] = answer
        self._post("theory", **await think(answers.table, system, found, statements))
        await engine.kernel_ready.wait()
        self._post("status", theory=True, kernel=True)
        from springpot.explorer.gathering import growth_times
        from springpot.simulation.plan.plan import plan_of

        times = growth_times(
            await engine.simulate(plan_of, system, paths=question.asked.paths, start="rest", threads=1)
        )
        curves = await think(answers.growth, system, found, times, from_rest=question.start == "rest")
        self._post("growth", times=times.tolist(), methods=curves)

    async def _simulation(self, question: Question) -> None:
        engine, system = self._engine, question.system
        await engine.kernel_ready.wait()
        from springpot.explorer.gathering import Gathering
        from springpot.simulation.estimate.stationary_start import adapt
        from springpot.simulation.paths.simulation import simulation_of
        from springpot.simulation.plan.plan import plan_of

        given: Any = {"paths": question.asked.paths, "seed": question.asked.seed, "start": question.start}
        plan = await engine.simulate(plan_of, system, threads=engine.threads, **given)
        settings = plan.settings
        if settings.steps * settings.paths > MOST_WORK:
            raise ValueError(
                f"paths: {settings.paths} paths of {settings.steps} steps take too long for a page: use at most "
                f"{int(MOST_WORK / settings.steps)}, or the command."
            )
        await self._compiled(system)
        if settings.start == "stationary":
            self._post("searching")
            with stopping() as check:
                plan = await self._pilots.take(adapt, plan, progress=check)
        simulation = await engine.simulate(simulation_of, plan)
        growing = await engine.simulate(Gathering, simulation, speeds=question.speeds)
        await asyncio.gather(self._show(question, growing), self._gather(question, growing))

    async def _compiled(self, system: System) -> None:
        """Have the kernel; say so if it takes long."""
        having = asyncio.ensure_future(self._engine.simulate(have_kernel, system))
        try:
            done, _ = await asyncio.wait([having], timeout=NOTICED)
            if not done:
                self._post("compiling")
            await having
        finally:
            having.cancel()

    async def _show(self, question: Question, growing: Gathering) -> None:
        """Record and play one path after the other, for the moving mass."""
        from springpot.explorer import motion

        number = 0
        while True:
            recorded = await self._engine.simulate(motion.record, growing.simulation, number)
            self._player = motion.Player(recorded, frequency=question.frequency)
            self._next_path.clear()
            await self._next_path.wait()
            number = (number + 1) % motion.blocks(growing.simulation.settings)

    async def _gather(self, question: Question, growing: Gathering) -> None:
        from springpot.explorer.views import labels

        while not growing.complete:
            await self._may_run.wait()
            if not self._playing:
                self._may_run.clear()  # a single step
            report, densities, growth = await self._engine.simulate(_grown, growing)
            said = labels(question.system, [*report["values"]])
            self._post("estimates", **report, labels=said, undefined=question.motion.uncountable)
            self._slots["densities"] = pack(DENSITIES, question.asked.generation, densities)
            self._slots["grown"] = pack(GROWTH, question.asked.generation, growth)

    async def _curve(self, question: Question) -> None:
        for paper in question.papers:
            await self._engine.theory_ready.wait()
            from springpot.explorer.answers import along_the_order

            points = along_the_order(paper)
            curve = await self._theorists.take(next, points)
            self._post("curve", **curve)
            await asyncio.sleep(SETTLE)
            while curve["missing"]:
                curve = await self._theorists.take(next, points)
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


async def _drop(work: asyncio.Future[Any]) -> None:
    work.cancel()
    await asyncio.gather(work, return_exceptions=True)


def _grown(growing: Gathering) -> tuple[dict[str, Any], list[Any], list[Any]]:
    """Grow an ensemble: a report of its estimates, densities, and <A^2> over time."""
    growing.grow()
    (values, errors), (peaks, their_errors) = growing.estimates(), growing.peaks()
    settings = growing.simulation.settings
    report = {
        "paths": growing.paths,
        "of": settings.paths,
        "complete": growing.complete,
        "seconds": growing.seconds,
        "values": plain(values | peaks),
        "errors": plain(errors | their_errors),
        "warnings": growing.warnings() if growing.complete else (),
        "settings": {name: getattr(settings, name) for name in SHOWN_SETTINGS},
        "stationary": growing.stationary,
    }
    from springpot.explorer.views import densities_of

    densities: list[Any] = []
    distributions = growing.distributions()
    for name in densities_of(growing.simulation.plan.system):
        found = distributions.get(name)
        densities += ([], []) if found is None else found.density(HISTOGRAM_BINS)[:2]
    return report, densities, [one for both in zip(*growing.growth(), strict=True) for one in both]
