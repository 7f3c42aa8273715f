"""Studies: a study file, its grid of oscillators, one task for each point and method, and a store of the results.

The names below are loaded at first use, so that commands start fast.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from springpot.machine.installed import need

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


def __getattr__(name: str) -> Any:
    for module, names in _PLACES.items():
        if name in names:
            return getattr(importlib.import_module(f"springpot.studies.{module}"), name)
    raise AttributeError(f"module 'springpot.studies' has no attribute {name!r}")
