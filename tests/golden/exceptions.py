"""Numbers that may differ, be missing, or be new, each with the reason; the changelog has the same list.

A key is a regular expression that is searched in the name, after the renaming of ``renamed.py``.  The first that fits
counts.  There are none since all were made anew with the one kernel.
"""

from __future__ import annotations

EXCEPTIONS: dict[str, str] = {}

ROUNDED: dict[str, tuple[float, str]] = {}
"""Numbers that may differ by so much of their value, or by 1e-12, with the reason; arrays are compared by their bits
alone, and are then only counted."""
