"""Linear algebra on one thread: how many work on a sum changes its last bits.

So that a study has the same bits on threads, on workers and with any number of processors, the command and the workers
begin with this in their environment; what the user has set there stays.  NumPy reads it once, when it is loaded.
"""

from __future__ import annotations

__all__ = ["ONE_THREAD"]

ONE_THREAD = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
