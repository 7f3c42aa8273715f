"""Results as plain values, which JSON can hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """The same with None for NaN and infinity, and lists for tuples and arrays, also inside dicts and lists.

    Examples
    --------
    >>> plain({"value": 1.0, "error": float("nan"), "range": (0.0, float("inf"))})
    {'value': 1.0, 'error': None, 'range': [0.0, None]}
    """
    return {name: _plain(value) for name, value in values.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return plain(value)
    if hasattr(value, "tolist"):  # of NumPy
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
