"""Ctrl-C ends a command soon, whatever it is doing."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import pytest

from springpot.machine.crew import work_together
from tests.posix import needs_signals

pytestmark = needs_signals

LONG = "hashlib.pbkdf2_hmac('sha256', b'', b'', (1 << 31) - 1)"  # compiled code for minutes, which no exception ends
SENTENCE = "springpot: interrupted.\n"


def interrupted(code: str, sent: signal.Signals = signal.SIGINT) -> tuple[int, str, str, float]:
    """Run some Python that prints a line when it is ready, send it Ctrl-C, and see how it ends."""
    process = subprocess.Popen(
        [sys.executable, "-c", "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n" + code],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.1)
    begun = time.monotonic()
    process.send_signal(sent)
    try:
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    return process.returncode, out, err, time.monotonic() - begun


HEAD = (
    "import hashlib, sys\nfrom springpot.machine.interrupt import attended\n"
    "ready = lambda: print('ready', flush=True)\n"
)


@pytest.mark.parametrize(
    "body",
    [
        # the command tidies up and says so, while a thread of it goes on
        "import threading\n"
        f"threading.Thread(target=lambda: {LONG}, daemon=True).start()\n"
        "def command():\n"
        "    try:\n"
        "        ready(); threading.Event().wait()\n"
        "    except KeyboardInterrupt:\n"
        "        print('springpot: interrupted.', file=sys.stderr); return 130\n",
        # the exception comes where nobody expects it
        "import threading\ndef command():\n    ready(); threading.Event().wait()\n",
        # the command is in the middle of a long call
        f"def command():\n    ready(); {LONG}\n",
        # many threads are, and the one that waits for them is told
        "from springpot.machine.crew import work_together\n"
        "def command():\n"
        "    try:\n"
        f"        work_together(lambda: (ready(), {LONG}), 1, stop=lambda: None)\n"
        "    except KeyboardInterrupt:\n"
        "        print('springpot: interrupted.', file=sys.stderr); return 130\n",
    ],
    ids=["a thread goes on", "nobody expects it", "a long call", "a long call in threads"],
)
def test_one_sentence_soon(body: str) -> None:
    code, out, err, taken = interrupted(HEAD + body + "sys.exit(attended(command))")
    assert (code, out, err) == (130, "", SENTENCE)
    assert taken < 10.0  # at most 2 s where nothing else runs


def test_after_the_answer_nothing_changes() -> None:
    """Ctrl-C while the interpreter ends: the exit code is that of the work, and there is no traceback."""
    body = "import atexit, threading; atexit.register(lambda: (ready(), threading.Event().wait(30)))\n"
    code, out, err, taken = interrupted(HEAD + body + "sys.exit(attended(lambda: 7))")
    assert (code, out, err) == (7, "", "")
    assert taken < 10.0


def test_in_the_last_moments_nothing_changes() -> None:
    """Ctrl-C when Python has taken its handlers of signals away already: the exit code is that of the work."""
    code = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
class Last:
    def __del__(self, kill=os.kill, own=os.getpid(), number=int(signal.SIGINT), write=os.write):
        write(1, b"last\\n")
        kill(own, number)
last = Last()
sys.argv = ["springpot", "--version"]
from springpot.__main__ import main
sys.exit(main())
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 0
    assert ended.stdout.endswith("last\n")
    assert ended.stderr == ""


def test_a_command_that_ignores_ctrl_c_goes_on() -> None:
    """As the background of a script does."""
    body = (
        "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "def command():\n    ready(); time.sleep(0.5); print('done'); return 0\n"
    )
    code, out, err, _ = interrupted(HEAD + body + "sys.exit(attended(command))")
    assert (code, out, err) == (0, "done\n", "")


@pytest.mark.parametrize(
    "calls", [f"Thread(target=lambda: {LONG}).start(); ready(); Event().wait()", f"ready(); {LONG}"],
    ids=["a thread goes on", "a long call"],
)  # fmt: skip
def test_sigterm_ends_a_command_that_ignores_ctrl_c(calls: str) -> None:
    """Soon, also where a thread of it goes on, or it is in the middle of a long call."""
    body = (
        "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from springpot.machine.interrupt import sigterm_as_ctrl_c\nfrom threading import Event, Thread\n"
        f"def command():\n    with sigterm_as_ctrl_c():\n        {calls}\n"
    )
    code, out, err, taken = interrupted(HEAD + body + "sys.exit(attended(command))", signal.SIGTERM)
    assert (code, out, err) == (130, "", SENTENCE)
    assert taken < 10.0  # at most 2 s where nothing else runs


def test_all_threads_end_before_an_error_is_raised() -> None:
    over: list[int] = []
    stop: list[bool] = []

    def work() -> None:
        if not over:
            over.append(0)
            raise ArithmeticError("no number")
        while not stop:
            time.sleep(0.01)
        time.sleep(0.2)
        over.append(1)

    with pytest.raises(ArithmeticError, match="no number"):
        work_together(work, 3, stop=lambda: stop.append(True))
    assert over == [0, 1, 1]


def test_what_the_waiting_thread_raises_stops_the_others() -> None:
    stop: list[bool] = []
    over: list[int] = []

    def work() -> None:
        while not stop:
            time.sleep(0.01)
        over.append(1)

    def tell() -> None:
        raise ArithmeticError("enough")

    with pytest.raises(ArithmeticError, match="enough"):
        work_together(work, 2, stop=lambda: stop.append(True), tell=tell, every=0.05)
    assert over == [1, 1]
