"""The list of analytical methods as a script of the page."""

from __future__ import annotations

import json

from springpot.theory.registry import METHODS

LINE_WIDTH = 2.0  # px, of the page's curves


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
        for method in reversed([*METHODS.values()])
    }
    return f"export const METHODS = {json.dumps(listed)};\nexport const NAMES = Object.keys(METHODS);\n"
