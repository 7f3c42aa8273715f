"""Studies: a study file, its grid of oscillators, one task for each point and method, and a store of the results.

The names below are loaded at first use, so that commands start fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.machine.installed import loaded_later, need

if TYPE_CHECKING:
    from springpot.studies.question import Study, read_study
    from springpot.studies.running import Outcome, open_study, run_study, study
    from springpot.studies.store import Store, StoreError, open_store

need("studies", "a study")

__all__ = ["Outcome", "Store", "StoreError", "Study", "open_store", "open_study", "read_study", "run_study", "study"]
_PLACES = {
    "question": ("Study", "read_study"),
    "running": ("Outcome", "open_study", "run_study", "study"),
    "store": ("Store", "StoreError", "open_store"),
}
__getattr__ = loaded_later(__name__, _PLACES)
