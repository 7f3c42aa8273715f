"""A server as a user starts it, and a real browser."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import psutil
import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

COMMAND = [sys.executable, "-m", "springpot"]


@dataclass
class Server:
    """A running ``springpot explore``."""

    process: subprocess.Popen[str]
    address: str
    launched: float
    answered: float

    @property
    def port(self) -> int:
        return int(self.address.rstrip("/").rsplit(":", 1)[1])

    @property
    def origin(self) -> str:
        return self.address.rstrip("/")

    @property
    def live(self) -> str:
        return self.origin.replace("http", "ws") + "/live"

    def memory(self) -> float:
        """Resident, in MB."""
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="utf-8")
        return int(status.split("VmRSS:")[1].split()[0]) / 1024.0

    def processor_time(self) -> float:
        """Spent so far, in s."""
        words = Path(f"/proc/{self.process.pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def running(*words: str) -> Iterator[Server]:
    launched = time.monotonic()
    process = subprocess.Popen(
        [*COMMAND, "explore", "--port", "0", "--no-browser", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    try:
        line = process.stdout.readline()
        assert "http://" in line, process.communicate()
        address = next(word for word in line.split() if word.startswith("http://"))
        yield Server(process, address, launched, time.monotonic())
    finally:
        process.kill()
        process.communicate()


class Others:
    """How much of the machine's processors everything but this test and what it started takes, from here on."""

    MOST = 0.25  # processors, that a test of speed bears

    def __init__(self) -> None:
        self.begun, self.busy, self.ours = time.monotonic(), *self._spent()

    @staticmethod
    def _spent() -> tuple[float, float]:
        """Processor time in s that anyone has spent, what the host took away among it, and that we have."""
        everyone = psutil.cpu_times()
        busy = everyone.user + everyone.nice + everyone.system + everyone.irq + everyone.softirq + everyone.steal
        ours = psutil.Process().cpu_times()
        spent = ours.user + ours.system + ours.children_user + ours.children_system
        for child in psutil.Process().children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                its = child.cpu_times()
                spent += its.user + its.system + its.children_user + its.children_system
        return busy, spent

    def excuse(self, found: str, *, unless: bool) -> None:
        """Skip the test: what is too slow while others use the machine says nothing."""
        busy, ours = self._spent()
        taken = (busy - self.busy - (ours - self.ours)) / (time.monotonic() - self.begun)
        if not unless and taken > self.MOST:
            pytest.skip(f"{found}, but others were using {taken:.1f} processors")


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    with running() as started:
        yield started


def chromium() -> str | None:
    """Where a Chromium is, if there is one."""
    named = os.environ.get("SPRINGPOT_CHROMIUM")
    candidates = (named, "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    return next((found for name in candidates if name and (found := shutil.which(name))), None)


@contextmanager
def launched_browser() -> Iterator[Browser]:
    from playwright.sync_api import sync_playwright

    program = chromium()
    if program is None:
        pytest.skip("no Chromium here: install Debian's package chromium, or name one in SPRINGPOT_CHROMIUM")
    # a container has neither the kernel's sandbox nor a large /dev/shm
    flags = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=flags)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with launched_browser() as started:
        yield started
