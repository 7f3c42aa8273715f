"""Compile the kernels that most tests use: ``python -m tests.kernels``, before processes that would each compile them.

With a wall and without, of both schemes, with the memory in single and in double precision.  They are then on disk.
"""

from __future__ import annotations

import itertools

import springpot as sp

PRECISIONS = (1e-6, 1e-9)  # relative errors of the memory: single and double

if __name__ == "__main__":
    for barrier, scheme, tolerance in itertools.product((sp.Barrier(), None), ("default", "grunwald"), PRECISIONS):
        oscillator = sp.Oscillator(barrier=barrier)
        sp.run(oscillator, paths=1, duration=1.0, step=0.1, start="rest", scheme=scheme, memory_tolerance=tolerance)
