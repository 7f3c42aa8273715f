"""Numbers that may differ, be missing, or be new, each with the reason; the changelog has the same list.

A key is a regular expression that is searched in the name, after the renaming of ``renamed.py``.
"""

from __future__ import annotations

EXCEPTIONS: dict[str, str] = {}
