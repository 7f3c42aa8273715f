"""One worker process of a study's own Dask cluster: ``python -m springpot.studies.worker ADDRESS FOLDER THREADS``.

Its standard input is a pipe from the process that started it.  When that process ends, for any reason, the system
closes the pipe, and the worker ends at once: also while its modules load, or while it computes.
"""

from __future__ import annotations

import os
import sys
import threading


def _end_with_its_parent() -> None:
    while os.read(0, 1):
        pass
    os._exit(1)


def main(address: str, folder: str, threads: str) -> None:
    """Work for a scheduler on so many threads, with scratch files in a folder, until the parent ends."""
    threading.Thread(target=_end_with_its_parent, daemon=True).start()

    import asyncio
    import logging
    import warnings

    import distributed

    from springpot.machine.trusted import CacheWarning

    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore", CacheWarning)  # the first process warns

    async def work() -> None:
        worker = distributed.Worker(
            address, nthreads=int(threads), host="127.0.0.1", local_directory=folder, silence_logs=50
        )
        async with worker:
            await worker.finished()

    asyncio.run(work())


if __name__ == "__main__":
    main(*sys.argv[1:])
