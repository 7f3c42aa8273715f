"""Slow work of one tab that it asks for, and its file of measured data: taken in parts, read, and fitted."""

from __future__ import annotations

import asyncio
import base64
import threading
import time
from collections.abc import Callable, Coroutine, Sequence
from functools import partial
from typing import Any

from springpot.explorer.engine import Turns
from springpot.explorer.protocol import FilePart
from springpot.machine.faults import Stopped
from springpot.problem.system import System

TOLD = 0.2  # s between two messages of how far a fit is


class Parts:
    """The parts of a file, as they come.

    Examples
    --------
    >>> parts = Parts()
    >>> parts.whole(FilePart(kind="data", name="a.csv", part=0, of=2, text="t,"))
    >>> parts.whole(FilePart(kind="data", name="a.csv", part=1, of=2, text="x"))
    b't,x'
    """

    def __init__(self) -> None:
        self._texts: list[str] = []

    def whole(self, part: FilePart) -> bytes | None:
        """Keep a part; the content of the file with the last one.

        Raises
        ------
        ValueError
            If it is not the next part, or not in base64 where it must be.
        """
        if part.part == 0:
            self._texts = []
        if part.part != len(self._texts):
            raise ValueError(f"{part.kind}: the parts of the file must come in their order.")
        self._texts.append(part.text)
        if part.part < part.of - 1:
            return None
        text, self._texts = "".join(self._texts), []
        if not part.binary:
            return text.encode()
        try:
            return base64.b64decode(text, validate=True)
        except ValueError:
            raise ValueError(f"{part.kind}: the bytes of a binary file must be in base64.") from None


class Work:
    """Slow work of a tab, one piece at a time, which says how far it is and can be stopped.

    Parameters
    ----------
    turns : Turns
    post : callable
        Sends a message of a kind, with its content, to the tab.
    """

    def __init__(self, turns: Turns, post: Callable[..., None]) -> None:
        self._turns, self._post = turns, post
        self._work: asyncio.Future[None] | None = None
        self._stopped = threading.Event()  # of the work that is running

    def begin(self, kind: str, work: Callable[..., dict[str, Any]], *given: Any) -> None:
        """Call a function with what is given, ``progress`` and ``stop``, in the place of what is running.

        ``progress`` takes the fraction done, and as keywords what is to be shown of it already.

        What it returns is sent in a message of this kind.
        """
        self._begin(lambda stopped: self._told(kind, work, given, stopped))

    def stop(self) -> None:
        """End what is running, with the best so far."""
        self._stopped.set()

    def close(self) -> None:
        """Cancel what has not begun; what is running ends soon, and is not shown."""
        self._stopped.set()
        if self._work is not None:
            self._work.cancel()

    def _begin(self, work: Callable[[threading.Event], Coroutine[Any, Any, None]]) -> None:
        self.close()
        self._stopped = threading.Event()
        self._work = asyncio.ensure_future(work(self._stopped))

    async def _told(
        self, kind: str, work: Callable[..., dict[str, Any]], given: Sequence[Any], stopped: threading.Event
    ) -> None:
        loop, told = asyncio.get_running_loop(), 0.0

        def progress(fraction: float, **known: Any) -> None:
            nonlocal told
            if not stopped.is_set() and (now := time.monotonic()) > told + TOLD:
                told = now
                estimate = getattr(fraction, "estimate", None)
                tell = partial(self._tell, kind, float(fraction), estimate.seconds if estimate else None, **known)
                loop.call_soon_threadsafe(tell)

        self._tell(kind, None, None)
        try:
            found = await self._turns.take(work, *given, progress, stopped.is_set)
            self._post(kind, running=False, fault="", **found)
        except Exception as error:
            self._post(kind, running=False, fault=sentence_of(error))

    def _tell(self, kind: str, done: float | None, seconds: float | None, **known: Any) -> None:
        """How far it is, the seconds that are left, as far as they are known, and what has been found so far."""
        self._post(kind, running=True, fault="", done=done, seconds=seconds, **known)


class Measured(Work):
    """The data of a tab, and the fit that is running."""

    def __init__(self, turns: Turns, post: Callable[..., None]) -> None:
        super().__init__(turns, post)
        self._parts = Parts()
        self._data: Any = None

    def take(self, part: FilePart) -> None:
        """Keep a part of a file; the last one has it read.

        Raises
        ------
        ValueError
            If it is not the next part.
        """
        if part.part == 0:
            self.close()
            self._data = None
        if (content := self._parts.whole(part)) is not None:
            self._begin(lambda stopped: self._read(part.name, content, stopped))

    def fit(self, system: System, names: Sequence[str]) -> None:
        """Fit numbers of a system, by the names of their sliders.

        Raises
        ------
        ValueError
            If there are no data.
        """
        if self._data is None:
            raise ValueError("fit: there are no data yet.")
        self.begin("fit", _fitted, system, names, self._data)

    async def _read(self, name: str, content: bytes, stopped: threading.Event) -> None:
        try:
            self._data, said = await self._turns.take(_read, content, name, stopped.is_set)
            self._post("data", name=name, said=said, fault="")
        except Exception as error:
            self._post("data", name=name, said="", fault=sentence_of(error))


def _read(content: bytes, name: str, stop: Callable[[], bool]) -> tuple[Any, str]:
    from springpot.explorer.fitting import described
    from springpot.fitting.reading import data_of

    data, notes = data_of(content, name, stop)
    return data, "; ".join([described(data), *notes])


def _fitted(
    system: System, names: Sequence[str], data: Any, progress: Callable[[float], None], stop: Callable[[], bool]
) -> dict[str, Any]:
    from springpot.explorer.fitting import fitted

    return fitted(system, names, data, progress, stop)


def sentence_of(error: Exception) -> str:
    """What is said of an error in the page.

    Examples
    --------
    >>> sentence_of(ValueError("order must be in [0, 1].")), sentence_of(KeyError("x"))
    ('order must be in [0, 1].', "KeyError: 'x'")
    """
    text = " ".join(str(error).split())[:400]
    return text if isinstance(error, ValueError | Stopped) else f"{type(error).__name__}: {text}"
