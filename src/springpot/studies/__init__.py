"""Many questions: a study file, its grid, pure tasks, and a store that loses no answer."""

from springpot.studies.ask import open_study, study
from springpot.studies.question import Study, read_study
from springpot.studies.running import Outcome, run_study
from springpot.studies.store import Store, StoreError, open_store

__all__ = ["Outcome", "Store", "StoreError", "Study", "open_store", "open_study", "read_study", "run_study", "study"]
