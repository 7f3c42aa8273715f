"""Environment variables for linear algebra on one thread: the number of threads changes the last bits of a sum.

The command and the workers start with them, so that a study has the same bits on threads, on workers and with any
number of processors.  Variables that the user has set are kept.  NumPy reads them when it is loaded.
"""

from __future__ import annotations

ONE_THREAD = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
