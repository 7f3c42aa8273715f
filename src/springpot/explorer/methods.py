"""The list of analytical methods as a script of the page."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace

from springpot.theory.registry import METHODS, SYSTEM_METHODS, Method

__all__ = ["LISTED", "method_list"]

LINE_WIDTH = 2.0  # px, of the page's curves

_ALL = {name: method for name, method in METHODS.items() if name not in SYSTEM_METHODS} | dict(SYSTEM_METHODS)
LISTED: Mapping[str, Method] = {
    name: replace(method, over_order=METHODS[name].over_order if name in METHODS else "")
    for name, method in _ALL.items()
}
"""Every method by name, the most exact last."""


def method_list() -> str:
    """A JavaScript module with the methods by name, the most exact first: label, color, dash in px, ``over_order``.

    Examples
    --------
    >>> method_list().splitlines()[1]
    'export const NAMES = Object.keys(METHODS);'
    """
    listed = {
        method.name: {
            "label": method.label,
            "color": method.color,
            "dash": [LINE_WIDTH * length for length in method.dash],
            "over_order": method.over_order,
        }
        for method in reversed([*LISTED.values()])
    }
    return f"export const METHODS = {json.dumps(listed)};\nexport const NAMES = Object.keys(METHODS);\n"
