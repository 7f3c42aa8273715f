"""Common to all commands: progress bar, tables, JSON, and types of flags."""

from __future__ import annotations

import contextlib
import json
import sys
import threading
import warnings
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import CoercionError, Parameter, Token

from springpot.machine.extras import need
from springpot.machine.plain import plain
from springpot.machine.trusted import CacheWarning

if TYPE_CHECKING:
    from rich.progress import Progress

    from springpot.machine.progress import Estimate

QUIET_SECONDS = 2.0
LONG_SECONDS = 10.0
MUCH_MORE = 1.5  # times the work that was announced is worth another sentence


def _whole(type_: object, tokens: Sequence[Token]) -> int:
    """Cyclopts' own conversion rounds 2.5 to 2; a number of paths or a seed must be refused instead."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise CoercionError(token=tokens[0], target_type=int) from None


Whole = Annotated[int, Parameter(converter=_whole)]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object and nothing else.")]


class Bar:
    """A progress bar on stderr, only on a terminal and only once the work has lasted a while.

    It pulses, and says ``first``, until the work tells for the first time how far it is.  A fraction that carries an
    estimate (`springpot.machine.progress.FractionDone`) shows the time still to come and what takes it; work that will
    take longer than LONG_SECONDS, or cannot reach what was asked for, is said on stderr, terminal or not; and
    again if it turns out to be much more work.
    """

    def __init__(self, text: str, first: str = "", hint: str = "--max-time ends it earlier") -> None:
        self._hint = f" ({hint})" if hint else ""
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
            self._say(f"this takes {longer}{estimate.sentence}{self._hint}")
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


def check_picture(path: str | None, name: str = "plot") -> None:
    """Raise an error, before any work, if a picture that is asked for cannot be written to this path."""
    if path is None:
        return
    need("plots", "a picture")
    if not path.endswith(".png"):
        raise ValueError(f"{name} must end in .png, but it is {path!r}.")
    if not Path(path).resolve().parent.is_dir():
        raise ValueError(f"{name} must lie in a folder that exists, but {str(Path(path).parent)!r} does not.")


def print_table(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip_longest(*rows, fillvalue="")]
    for row in rows:
        print("".join(f"  {cell:<{width}}" for cell, width in zip(row, widths, strict=False)).rstrip())


def print_json(answer: Mapping[str, Any]) -> None:
    print(json.dumps(plain(answer), indent=2, allow_nan=False))


@contextlib.contextmanager
def warnings_as_sentences() -> Iterator[None]:
    """Context in which the warning of an unused cache is printed as one sentence, without its place in the code."""
    before = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, CacheWarning):
            say(f"warning: {message}")
        else:
            before(message, category, *place, **more)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def say(sentence: str) -> None:
    if sys.stderr is not None:
        with contextlib.suppress(OSError):
            print(f"springpot: {sentence}", file=sys.stderr)
