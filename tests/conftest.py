"""Linear algebra on one thread, as the command has it: a second one mostly waits, and doubles the processor time."""

from __future__ import annotations

import os

from springpot.one_thread import ONE_THREAD

for name, number in ONE_THREAD.items():  # NumPy reads them when it is loaded; of pytest's plugins only Zarr's loads it
    os.environ.setdefault(name, number)
