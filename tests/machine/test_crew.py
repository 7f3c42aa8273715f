"""How many threads are worth starting."""

from __future__ import annotations

import os

import pytest

from springpot.machine.crew import threads_available


@pytest.mark.parametrize(
    ("said", "threads"),
    [(None, 8), ("3", 3), ("1", 1), ("64", 8), ("0", 1), ("", 8), ("two", 8)],
)
def test_what_slurm_grants_is_a_limit(said: str | None, threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("springpot.machine.crew.control_group_quota", lambda: float("inf"))
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    if said is not None:
        monkeypatch.setenv("SLURM_CPUS_PER_TASK", said)
    assert threads_available() == threads


def test_the_control_group_limits_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("springpot.machine.crew.control_group_quota", lambda: 2.5)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "4")
    assert threads_available() == 2
