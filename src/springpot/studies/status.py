"""Status of a store: what is done, damaged and missing."""

from __future__ import annotations

from dataclasses import dataclass

from springpot.studies.labelled import AnswersDigest, State, state
from springpot.studies.store import Damaged, Store
from springpot.studies.tasks import Answer, tasks

__all__ = ["Status", "status"]


@dataclass(frozen=True)
class Status:
    """Status of a store.

    Attributes
    ----------
    done, damaged, missing : dict
        Number of tasks of each method.
    labelled : {"right", "outdated", "damaged", "missing"}
        State of the group that any xarray can open.
    """

    done: dict[str, int]
    damaged: dict[str, int]
    missing: dict[str, int]
    labelled: State


def status(store: Store) -> Status:
    """Read all results of a store, and verify their checksums."""
    done, damaged, missing = (dict.fromkeys(map(str, store.study.methods), 0) for _ in range(3))
    digest = AnswersDigest(store)
    for task in tasks(store.study):
        answer: Answer | None = None
        try:
            answer = store.read(task)
        except Damaged:
            damaged[task.method] += 1
        else:
            (missing if answer is None else done)[task.method] += 1
        digest.add(task, answer)
    return Status(done, damaged, missing, state(store, digest.value()))
