"""The types of arrays, as annotations name them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Columns = dict[str, tuple[tuple[str, ...], Any, dict[str, Any]]]
"""Variables and coordinates of a data set by name: axes, numbers, and attributes such as the unit."""
