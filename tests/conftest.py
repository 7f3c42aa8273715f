"""Linear algebra on one thread, as the command has it: a second one mostly waits, and doubles the processor time."""

from __future__ import annotations

import os

from springpot.machine.one_thread import ONE_THREAD

# NumPy reads them when it is loaded, which none of the plugins named in pyproject.toml does
for name, number in ONE_THREAD.items():
    os.environ.setdefault(name, number)
