"""Binary messages to a tab: a short header and arrays of single-precision numbers, which JavaScript reads in place."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

MOTION, DENSITIES, GROWTH = 1, 2, 3


def pack(kind: int, generation: int, arrays: Sequence[npt.ArrayLike]) -> bytes:
    """Kind, generation and number of arrays, their lengths (all as 32-bit whole numbers), then their numbers.

    Examples
    --------
    >>> struct.unpack("<5I2f", pack(MOTION, 7, [[1.0, 2.0], []]))
    (1, 7, 2, 2, 0, 1.0, 2.0)
    """
    packed = [np.asarray(array, "<f4").ravel() for array in arrays]
    header = struct.pack(f"<{3 + len(packed)}I", kind, generation, len(packed), *(array.size for array in packed))
    return header + b"".join(array.tobytes() for array in packed)
