"""The list of analytical methods as a script of the page."""

from __future__ import annotations

import json

from springpot.theory.registry import METHODS, SYSTEM_METHODS

__all__ = ["method_list"]

LINE_WIDTH = 2.0  # px, of the page's curves


def method_list(*, of_system: bool = False) -> str:
    """A JavaScript module with the methods by name, the most exact first: label, color, dash in px, ``over_order``.

    Parameters
    ----------
    of_system : bool
        Whether they are those of a system, as `springpot.theory.solve.methods_for` has them.

    Examples
    --------
    >>> method_list().splitlines()[1]
    'export const NAMES = Object.keys(METHODS);'
    """
    own = SYSTEM_METHODS if of_system else {}
    methods = {name: method for name, method in METHODS.items() if name not in own} | dict(own)
    listed = {
        method.name: {
            "label": method.label,
            "color": method.color,
            "dash": [LINE_WIDTH * length for length in method.dash],
            "over_order": method.over_order,
        }
        for method in reversed([*methods.values()])
    }
    return f"export const METHODS = {json.dumps(listed)};\nexport const NAMES = Object.keys(METHODS);\n"
