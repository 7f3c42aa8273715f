"""Names of results that changed, and nothing else of them: the kept bits are looked for under the new name.

A key is a regular expression for one or more whole segments of a name such as ``runs/lossy/rest/x_mean``; the value is
what `re.sub` puts there.  They are applied one after the other, also to results that are words (the name of a method).

    RENAMED = {
        "linearisation": "linearization",  # this segment, wherever it stands
        "(devices/.*)/springpot_power": r"\\1/damping_power",  # in one kind only
    }
"""

from __future__ import annotations

RENAMED: dict[str, str] = {}
