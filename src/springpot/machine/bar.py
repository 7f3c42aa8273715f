"""A progress bar on stderr, for commands and for long work in Python."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress

    from springpot.machine.progress import Estimate

QUIET_SECONDS = 2.0
LONG_SECONDS = 10.0
MUCH_MORE = 1.5  # times the work that was announced is worth another sentence


class Bar:
    """A progress bar on stderr, only on a terminal and only once the work has lasted a while.

    It pulses, and says ``first``, until the work tells for the first time how far it is.  A fraction that carries an
    estimate (`springpot.machine.progress.FractionDone`) shows the time still to come and what takes it; work that will
    take longer than LONG_SECONDS, or cannot reach what was asked for, is said on stderr, terminal or not; and
    again if it turns out to be much more work.  ``hint``: what can be done then, in words, or what makes them.
    """

    def __init__(
        self, text: str, first: str = "", hint: str | Callable[[], str] = "--max-time ends it earlier"
    ) -> None:
        self._hint = hint
        self._text, self._said = text, first or text
        self._done: float | None = None
        self._bar: Progress | None = None
        self._lock = threading.Lock()
        self._timer = threading.Timer(QUIET_SECONDS, self._show)
        self._timer.daemon = True
        self._work_announced = 0.0  # path-steps
        self._unreachable_announced = False

    def __enter__(self) -> Bar:
        if sys.stderr is not None and sys.stderr.isatty():
            self._timer.start()
        return self

    def __call__(self, fraction: float, text: str = "") -> None:
        estimate = getattr(fraction, "estimate", None)
        with self._lock:
            self._done, self._said = fraction, text or self._text
            if estimate is not None:
                self._said = f"{self._said}: {estimate.sentence}"
                self._announce(estimate)
            if self._bar is not None:
                self._bar.update(self._bar.task_ids[0], total=1.0, completed=fraction, description=self._said)

    def _announce(self, estimate: Estimate) -> None:
        """Say that the run will be long, again if it takes much longer, and that the tolerance cannot be reached."""
        if estimate.seconds > LONG_SECONDS and estimate.path_steps > MUCH_MORE * self._work_announced:
            longer = "longer than was estimated: " if self._work_announced else ""
            self._work_announced = estimate.path_steps
            hint = self._hint() if callable(self._hint) else self._hint
            self._say(f"this takes {longer}{estimate.sentence}{f' ({hint})' if hint else ''}")
        if estimate.unreachable and not self._unreachable_announced:
            self._unreachable_announced = True
            self._say(estimate.unreachable)

    def _say(self, sentence: str) -> None:
        if self._bar is None:
            say(f"{sentence}.")
        else:
            self._bar.console.print(f"springpot: {sentence}.", highlight=False, soft_wrap=True)

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
        from rich.table import Column

        with self._lock:
            if self._timer.finished.is_set():  # the work ended while the lines above were loading
                return
            words = TextColumn("{task.description}", table_column=Column(no_wrap=False, overflow="fold"))
            bar = Progress(
                words, BarColumn(bar_width=20), TaskProgressColumn(), console=Console(stderr=True), transient=True
            )
            task = bar.add_task(self._said, total=None if self._done is None else 1.0)
            bar.update(task, completed=self._done)
            bar.start()
            self._bar = bar

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()
        with self._lock:
            if self._bar is not None:
                self._bar.stop()


def say(sentence: str) -> None:
    if sys.stderr is not None:
        with contextlib.suppress(OSError):
            print(f"springpot: {sentence}", file=sys.stderr)
