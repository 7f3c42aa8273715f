"""The normals of a run, and of its start, as arrays; :mod:`springpot.simulation.kernel.random` makes them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from springpot.simulation.kernel.entries import FILL_NORMALS
from springpot.simulation.kernel.sizes import GROUP, LANES

_START = 0x40000000  # counter word of the normals of the start


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


def start_normals(seed: int, first: int, paths: int, *, stream: int = 0) -> npt.NDArray[np.float32]:
    """Four normals for the start of each of the paths ``first`` ..., independent of those of the run.

    Parameters
    ----------
    seed, first, paths, stream : int
        ``first`` is a multiple of LANES.

    Returns
    -------
    ndarray of float32, shape (paths, 4)

    Examples
    --------
    >>> bool((start_normals(1, 64, 64) == start_normals(1, 0, 128)[64:]).all())
    True
    """
    out = np.empty((paths, GROUP), np.float32)
    k0, k1 = key_words(seed)
    for begin in range(0, paths, LANES):
        part = out[begin : begin + LANES]
        FILL_NORMALS(first + begin, stream, _START, k0, k1, len(part), GROUP, part)
    return out


def key_words(seed: int) -> tuple[np.uint32, np.uint32]:
    """The two 32-bit words of a 64-bit seed, low word first."""
    return np.uint32(seed & 0xFFFFFFFF), np.uint32(seed >> 32)
