"""The worker processes of a study's own Dask cluster: they are started, replaced when they end, and ended here."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

from springpot.machine.crew import ONE_THREAD
from springpot.machine.platforms import without_ctrl_c

MOST_ENDS = 10  # of each worker, without a finished task in between


class Workers:
    """Processes that work for a scheduler; a context that ends them.

    Parameters
    ----------
    address : str
        Of the scheduler.
    count : int
    threads : int
        Of each: as many tasks at once.
    """

    def __init__(self, address: str, count: int, threads: int = 1) -> None:
        self._address, self.count, self.threads = address, count, threads
        self._ends = 0
        self._processes: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> Workers:
        self._folder = tempfile.TemporaryDirectory(prefix="springpot-", ignore_cleanup_errors=True)
        self._processes = [self._start() for _ in range(self.count)]
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes:  # no result is lost: it is saved before it is reported
            process.kill()
        for process in self._processes:
            process.wait()
            if process.stdin is not None:
                process.stdin.close()
        self._folder.cleanup()

    def replace_ended(self, progress: bool) -> None:
        """Replace workers that have ended, for example because a batch system killed them.

        Parameters
        ----------
        progress : bool
            Whether a task was finished since the last call.

        Raises
        ------
        OSError
            If they end again and again.
        """
        if progress:
            self._ends = 0
        for index, process in enumerate(self._processes):
            if (code := process.poll()) is None:
                continue
            self._ends += 1
            if self._ends > MOST_ENDS * self.count:
                how = f"signal {-code}" if code < 0 else f"exit code {code}"
                raise OSError(
                    f"the worker processes keep ending, the last one with {how}: all results so far are kept, and "
                    "running the study again continues from there."
                )
            if process.stdin is not None:
                process.stdin.close()
            self._processes[index] = self._start()

    def _start(self) -> subprocess.Popen[bytes]:
        places = os.pathsep.join(filter(None, sys.path))
        words = self._address, self._folder.name, str(self.threads)
        with without_ctrl_c() as flags:
            return subprocess.Popen(
                [sys.executable, "-P", "-m", "springpot.studies.worker", *words],
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                env={**ONE_THREAD, **os.environ, "PYTHONPATH": places}, creationflags=flags,
            )  # fmt: skip
