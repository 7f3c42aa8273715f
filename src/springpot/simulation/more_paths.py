"""More paths for a run: those that are there are not computed again."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.monte_carlo import diagnostics_of, doubts_of
from springpot.simulation.paths.simulation import Progress, Simulation, simulation_of
from springpot.simulation.plan.settings import MOST_PATHS, checked_threads, whole_number
from springpot.simulation.result.results import Run

__all__ = ["with_paths"]


def with_paths(run: Run, paths: object, threads: int | None, progress: Progress | None) -> Run:
    """The run with so many paths, without budgets."""
    before = run.settings.paths
    wanted = whole_number(paths, "paths", before + 1, MOST_PATHS, f" The run has {before} paths.")
    settings = replace(
        run.settings, paths=wanted, threads=run.settings.threads if threads is None else checked_threads(threads)
    )
    simulation = simulation_of(run.oscillator, settings, run.adapted)
    begun = time.perf_counter()
    _check_bits(simulation, run)
    whole = before // LANES * LANES
    skipped = whole if settings.record <= whole else 0
    later = simulation.but(paths=wanted - skipped, record=0 if skipped else settings.record)
    ensemble = later.advance(skipped=skipped, progress=progress)
    rows = np.concatenate([run.path_sums[:skipped], ensemble.rows])
    values, errors = simulation.estimates(rows)
    old = {*doubts_of(simulation.but(paths=before), run.values, run.errors, run.path_sums)}
    kept = (sentence for sentence in run.warnings if sentence not in old)
    return replace(
        run,
        settings=settings,
        values=values,
        errors=errors,
        budgets={},
        diagnostics=diagnostics_of(simulation, rows, run.diagnostics["seconds"] + time.perf_counter() - begun),
        warnings=(*kept, *doubts_of(simulation, values, errors, rows)),
        record=run.record if skipped else ensemble.record,
        path_sums=rows,
    )


def _check_bits(simulation: Simulation, run: Run) -> None:
    """The first block must be what it was: another version, processor or library would give others."""
    paths = min(LANES, run.settings.paths)
    again = simulation.but(paths=paths, record=min(paths, run.settings.record)).advance()
    there = run.path_sums[:paths]
    if again.rows.shape != there.shape or not np.array_equal(again.rows, there, equal_nan=True):
        made = run.diagnostics.get("versions", {}).get("springpot", "?")
        raise ValueError(
            f"run cannot be extended here: it was made by springpot {made} on another machine or with other libraries, "
            "and its first paths come out with other bits; run it anew."
        )
