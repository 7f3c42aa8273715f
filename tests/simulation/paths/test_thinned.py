"""Recorded paths of which only every so many steps are stored."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

from springpot.figures import plot_path
from springpot.problem.oscillator import Barrier, Oscillator, Springpot
from springpot.simulation import simulate
from springpot.simulation.plan.plan import MOST_RECORDED, plan_of

OSCILLATOR = Oscillator(springpot=Springpot(0.5, 0.4), barrier=Barrier(0.1, 0.8, "below"))


@pytest.mark.parametrize("scheme", ["default", "grunwald"])
@pytest.mark.parametrize("every", [2, 7, 64])
def test_thinned_paths_have_the_bits_of_the_full_ones(scheme: Any, every: int) -> None:
    settings: dict[str, Any] = {"paths": 70, "duration": 3.01, "step": 0.01, "scheme": scheme, "initial_velocity": -0.3}
    full = simulate(OSCILLATOR, record=67, **settings)
    thinned = simulate(OSCILLATOR, record=67, record_every=every, **settings)
    assert np.array_equal(thinned.record, full.record[:, ::every])
    assert np.array_equal(thinned.time, full.time[::every])
    assert thinned.estimates == full.estimates
    assert thinned.to_xarray()["x"].shape == (67, 301 // every + 1)


def test_the_limit_counts_stored_points() -> None:
    long: dict[str, Any] = {"paths": 100, "duration": 1e4, "step": 0.005, "record": 100}
    with pytest.raises(
        ValueError, match=r"^record asks for 100 paths of 2000000 points, .*: use record_every=4 or more"
    ):
        plan_of(OSCILLATOR, **long)
    assert plan_of(OSCILLATOR, **long, record_every=4).settings.recorded_points == 500_001
    assert MOST_RECORDED < 100 * (2_000_000 // 3)
    with pytest.raises(ValueError, match="or at most 75 paths"):
        plan_of(OSCILLATOR, **long, record_every=3)


@pytest.mark.validation  # every day: the bits of the full ones, above
def test_memory_is_that_of_the_stored_points() -> None:
    settings: dict[str, Any] = {"paths": 1, "duration": 2000.0, "step": 0.01, "threads": 1, "record": 1}
    simulate(OSCILLATOR, **settings | {"duration": 1.0})
    peaks = []
    for every in (1, 100):
        tracemalloc.start()
        simulate(OSCILLATOR, record_every=every, **settings)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    stored = 200_000 * 16  # bytes of every step's x and v
    assert peaks[1] < stored < peaks[0]


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"record_every": 2}, "record_every has no effect without record, the number of paths to store."),
        ({"record": 1, "record_every": 0}, "record_every must be in [1, 100], not 0."),
        ({"record": 1, "record_every": 101}, "record_every must be in [1, 100], not 101."),
        ({"record": 1, "record_every": 2.0}, "record_every must be a whole number, not 2.0."),
    ],
)
def test_a_spacing_that_cannot_be_is_one_sentence(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError)) as refused:
        simulate(OSCILLATOR, paths=1, duration=1.0, step=0.01, **given)
    assert str(refused.value) == sentence


def test_impacts_are_marked_only_where_every_step_is_stored() -> None:
    """Between points further apart a path may turn without an impact."""
    settings: dict[str, Any] = {"paths": 1, "duration": 30.0, "record": 1, "start": "rest"}
    full, thinned = (plot_path(simulate(OSCILLATOR, record_every=every, **settings)) for every in (1, 5))
    assert len(full.get_legend_handles_labels()[1]) == 2
    assert max(line.get_xdata().size for line in full.lines if line.get_label() == "impact") > 3
    assert not any(np.size(line.get_xdata()) for line in thinned.lines if line.get_label() == "impact")
