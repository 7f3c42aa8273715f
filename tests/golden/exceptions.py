"""Numbers that may differ, be missing, or be new, each with the reason; the changelog has the same list.

A key is a regular expression that is searched in the name, after the renaming of ``renamed.py``.  The first that fits
counts.
"""

from __future__ import annotations

EXCEPTIONS: dict[str, str] = {
    "averaging_shifted": "is averaging_amplitude of a linear spring, and gone from the list of methods",
    "envelope": "with memory and one wall: positions per action, <v^2> and crossings per area of the plane",
    "recommended|best_guess|/gaps|/(unjudged|mapped|judges|largest|worst)$": "by the new map of the envelope",
}

ROUNDED: dict[str, tuple[float, str]] = {}
"""Numbers that may differ by so much of their value, or by 1e-12, with the reason; arrays are compared by their bits
alone, and are then only counted."""
