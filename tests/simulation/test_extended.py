"""More paths for a run: the bits of one long run, and what cannot be extended."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import springpot as sp
from tests.several import buildings
from tests.simulation.problems import errors_of, values_of

WALL = sp.Oscillator(springpot=sp.Springpot(0.5, 0.8), barrier=sp.Barrier(-0.2, 0.8))
GIVEN = {"duration": 12.0, "step": 0.05, "window": (6.0, 12.0), "seed": 4}


def same(one: sp.simulation.Run, other: sp.simulation.Run) -> None:  # type: ignore[name-defined]
    for mine, theirs in ((values_of(one), values_of(other)), (errors_of(one), errors_of(other))):
        assert mine.keys() == theirs.keys()
        assert np.array_equal([*mine.values()], [*theirs.values()], equal_nan=True)
    assert one.settings == other.settings
    assert one.warnings == other.warnings
    assert np.array_equal(one.path_sums, other.path_sums)
    assert np.array_equal(one.record, other.record)


@pytest.mark.parametrize(
    ("problem", "given", "suffix"),
    [
        (WALL, {}, ".nc"),
        (WALL, {"start": "rest", "record": 3}, ".json"),
        (WALL, {"start": "rest", "record": 70}, ".nc"),  # some of them in the block that is not whole
        (WALL, {"start": "rest", "threads": 1}, ".nc"),
        (sp.Oscillator(springpot=sp.Springpot(1.0, 0.8), barrier=None), {}, ".json"),
    ],
)
def test_the_bits_of_one_long_run(problem: sp.Oscillator, given: dict, suffix: str, tmp_path: Path) -> None:
    first = sp.simulate(problem, paths=600, **GIVEN, **given)  # the pilots of fewer paths would be smaller
    again = sp.load_run(first.save(tmp_path / f"run{suffix}", path_sums=True))
    longer = sp.extend(sp.extend(again, paths=601), paths=800)
    same(longer, sp.simulate(problem, paths=800, **GIVEN, **given))


def test_what_cannot_be_extended(tmp_path: Path) -> None:
    given = {**GIVEN, "start": "rest"}
    run = sp.simulate(WALL, paths=64, **given)
    with pytest.raises(ValueError, match=r"paths must be in \[65, .*The run has 64 paths"):
        sp.extend(run, paths=64)
    with pytest.raises(TypeError, match=r"paths must be a whole number, not 100\.5"):
        sp.extend(run, paths=100.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"threads must be in \[1, 4096\], not 0"):
        sp.extend(run, paths=100, threads=0)
    with pytest.raises(TypeError, match="run must be a Run"):
        sp.extend(run.estimates, paths=100)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"without the sums of its paths: save it with path_sums=True"):
        sp.extend(sp.load_run(run.save(tmp_path / "run.nc")), paths=100)
    with pytest.raises(ValueError, match="moments only, but it has distributions"):
        sp.extend(sp.simulate(WALL, paths=64, **given, distributions=True), paths=100)
    with pytest.raises(ValueError, match="moments only, but it has observables"):
        sp.extend(sp.simulate(WALL, paths=64, **given, slowest_counted_impact=0.1), paths=100)
    with pytest.raises(ValueError, match="must not be made with rtol"):
        sp.extend(sp.simulate(WALL, rtol=0.2), paths=100_000)
    other = run.path_sums.copy()
    other[5, 1] = np.nextafter(other[5, 1], 1.0)
    with pytest.raises(ValueError, match="first paths come out with other bits; run it anew"):
        sp.extend(replace(run, path_sums=other), paths=100)


DASHPOT = sp.Oscillator(springpot=sp.Springpot(1.0, 0.8), barrier=sp.Barrier(0.0))
LONG = {"duration": 40.0, "step": 0.02, "window": (20.0, 40.0), "seed": 4}


def test_to_an_error_are_the_bits_of_one_run_of_so_many_paths(tmp_path: Path) -> None:
    """<A^2> = q / (C Omega^2) and <v^2> = q / 2 C exactly; the error is below rtol, and holds the truth."""
    first = sp.simulate(DASHPOT, paths=512, **LONG)  # as many paths as have the largest pilots
    saved = sp.load_run(first.save(tmp_path / "run.nc", path_sums=True))
    names = ("amplitude_mean_square", "v_mean_square")
    longer = sp.extend(saved, rtol=0.03, quantities=names)
    assert longer.settings.paths > 512
    assert values_of(longer) == values_of(sp.simulate(DASHPOT, paths=longer.settings.paths, **LONG))
    for name, exact in zip(names, (1.25, 0.625), strict=True):
        assert longer[name].budget.total <= 0.03 * longer[name].value
        assert abs(longer[name].value - exact) <= 1.5 * longer[name].budget.total
        assert longer[name].budget.step_bias > 0.0
    assert sp.extend(first, rtol=0.03, quantities=names).settings == longer.settings
    kept = sp.load_run(longer.save(tmp_path / "longer.nc", path_sums=True))
    assert sp.extend(kept, rtol=0.05, quantities=names).settings.paths == longer.settings.paths
    more = sp.extend(kept, paths=longer.settings.paths + 64)
    assert all(estimate.budget is None for estimate in more.estimates.values())


@pytest.mark.parametrize(
    ("given", "asked", "sentence"),
    [
        ({}, {"rtol": 0.05, "paths": 1000}, "paths or rtol must be given, and not both"),
        ({}, {}, "paths or rtol must be given, and not both"),
        ({}, {"rtol": 0.0}, "rtol must be in"),
        ({}, {"rtol": 0.05, "quantities": ("x_men",)}, "did you mean x_mean"),
        ({"start": "rest"}, {"rtol": 0.05}, "run must have a stationary start"),
        ({"record": 2}, {"rtol": 0.05}, "run must not have recorded paths"),
        ({"duration": 4.0, "window": (0.5, 4.0)}, {"rtol": 0.01}, "rtol of 1 % cannot be reached.*: amp.*bias"),
    ],
)  # fmt: skip
def test_what_cannot_be_extended_to_an_error(given: dict, asked: dict, sentence: str) -> None:
    run = sp.simulate(DASHPOT, paths=64, **{**LONG, **given})
    with pytest.raises(ValueError, match=sentence):
        sp.extend(run, **asked)


def test_several_masses_from_rest_are_not_extended_to_an_error() -> None:
    """The sentence is about the start, and not about the quantities of one mass, which were not asked for."""
    run = sp.simulate(buildings(sp.WhiteNoise(1e9, on="old")), paths=64, duration=5.0, start="rest")
    with pytest.raises(ValueError, match="run must have a stationary start"):
        sp.extend(run, rtol=0.1)


def test_a_lossy_wall_s_impact_rate_is_not_extended_to_an_error() -> None:
    with pytest.raises(ValueError, match="quantities must not have impact_rate behind a lossy wall"):
        sp.extend(sp.simulate(WALL, paths=64, **GIVEN), rtol=0.1, quantities=("impact_rate",))
