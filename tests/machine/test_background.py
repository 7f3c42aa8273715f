"""Commands in the background of a script: the shell has Ctrl-C ignored for them, and SIGTERM ends them."""

from __future__ import annotations

import signal
import subprocess
import time
import urllib.request
from pathlib import Path

import pytest

from tests.explorer.conftest import running
from tests.explorer.talk import tab
from tests.explorer.test_fitting import RUBBER, many_impacts, send
from tests.posix import needs_signals
from tests.signals import in_the_background
from tests.studies.samples import COMMAND, RUNS, lines, write_toml

pytestmark = needs_signals


@pytest.mark.validation  # every day: a page that is ended by a signal, in explorer/test_server.py
def test_the_page() -> None:
    with in_the_background(), running() as started:
        started.process.send_signal(signal.SIGINT)
        time.sleep(0.5)
        with urllib.request.urlopen(started.address, timeout=30) as page:  # goes on
            assert page.status == 200
        started.process.send_signal(signal.SIGTERM)
        out, err = started.process.communicate(timeout=30)
    assert (started.process.returncode, out, err) == (130, "", "springpot: interrupted.\n")


@pytest.mark.validation  # every day: any long work, in test_interrupt.py
def test_the_page_in_the_middle_of_a_fit(tmp_path: Path) -> None:
    (tmp_path / "rubber.toml").write_text(RUBBER, encoding="utf-8")
    with in_the_background(), running(str(tmp_path / "rubber.toml")) as started, tab(started) as page:
        page.say(kind="problem", generation=1, paths=64)
        page.until("accepted")
        send(page, many_impacts(60_000))
        page.until("data", fault="")
        page.say(kind="fit", free=["barrier-restitution"])
        page.until("fit", running=True)
        begun = time.monotonic()
        started.process.send_signal(signal.SIGTERM)
        out, err = started.process.communicate(timeout=30)
        taken = time.monotonic() - begun
    assert (started.process.returncode, out, err) == (130, "", "springpot: interrupted.\n")
    assert taken < 4.0  # at most 2 s where nothing else runs


@pytest.mark.validation  # every day: the page, and a study in tests/studies/test_running.py that a signal stops
def test_a_study(tmp_path: Path) -> None:
    long = {**RUNS, "monte_carlo": {"paths": 512, "duration": 4000.0, "step": 0.02}}
    file, store = write_toml(tmp_path / "long.toml", long), tmp_path / "study.zarr"
    with in_the_background():
        process = subprocess.Popen(
            [*COMMAND, "run", str(file), "--store", str(store), "--threads", "1"], stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, start_new_session=True,
        )  # fmt: skip
    while not lines(store) and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(0.5)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (130, "")
    assert err == "springpot: interrupted; all results so far are kept; the same command continues.\n"
