"""The normals of a run, and of its start, as arrays; :mod:`springpot.simulation.kernel.random` makes them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from springpot.simulation.kernel.entries import FILL_NORMALS
from springpot.simulation.kernel.sizes import LANES


def normals(seed: int, paths: int, steps: int, *, stream: int = 0) -> npt.NDArray[np.float32]:
    """The normals of a run: element [p, n] is that of step n of path p.

    Parameters
    ----------
    seed : int
        0 <= seed < 2^64.
    paths, steps : int
    stream : int
        0 for the run itself; the pilot runs of an adapted start use the ones after it.

    Returns
    -------
    ndarray of float32, shape (paths, steps)

    Examples
    --------
    >>> normals(seed=1, paths=2, steps=5).shape
    (2, 5)
    """
    out = np.empty((paths, steps), np.float32)
    k0, k1 = key_words(seed)
    for first in range(0, paths, LANES):
        part = out[first : first + LANES]
        FILL_NORMALS(first, stream, 0, k0, k1, len(part), steps, part)
    return out


def key_words(seed: int) -> tuple[np.uint32, np.uint32]:
    """The two 32-bit words of a 64-bit seed, low word first."""
    return np.uint32(seed & 0xFFFFFFFF), np.uint32(seed >> 32)
