"""The validity map of systems: its cells, the theory in it, and the warnings and recommendations made from it."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import springpot as sp
from springpot.evidence.cells import Cell, cell_of, system_of
from springpot.evidence.recommendation import recommended
from springpot.evidence.reliability import SYSTEMS_MAP, exists, read_map, trust, warnings_of
from springpot.evidence.validity import SYSTEM_CELLS, gaps_of, make_map, simulate_cell
from springpot.machine.record import Record
from springpot.theory import (
    NotCoveredError,
    averaging_amplitude,
    envelope,
    linearization,
    solve_all,
)
from tests.sizes import validation

COLUMNS = read_map(SYSTEMS_MAP.file)
README = Path(__file__).resolve().parents[2] / "README.md"
PLACES = [Cell(*row) for row in zip(*(COLUMNS[name].tolist() for name in Cell._fields), strict=True)]
HARD = sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0))
WHITE = sp.WhiteNoise(1.0)


def row_of(cell: Cell) -> dict[str, float]:
    i = PLACES.index(cell)
    return {name: float(column[i]) for name, column in COLUMNS.items()}


def test_the_map_has_its_cells() -> None:
    assert set(PLACES) == set(SYSTEM_CELLS)
    assert len(PLACES) == len(set(PLACES)) >= 900


@pytest.mark.parametrize("cell", SYSTEM_CELLS[::23])
def test_a_cell_is_found_again_in_si_units(cell: Cell) -> None:
    """The same system with other units of mass, length and time."""
    mass, length, time = 0.3, 0.01, 0.2
    force = mass * length / time**2
    parts: list[object] = [sp.Mass(mass), sp.Spring(mass / time**2)]
    parts.append(sp.Springpot(cell.order, cell.c * mass * time ** (cell.order - 2.0)))
    if cell.hardening:
        parts.append(sp.PolynomialSpring((0.0, 0.0, cell.hardening * force / length**3)))
    for part in system_of(cell).parts:
        if isinstance(part, sp.Barrier):
            parts.append(sp.Barrier(part.position * length, part.restitution, part.free_side))
        elif isinstance(part, sp.WhiteNoise):
            parts.append(sp.WhiteNoise(force**2 * time))
        elif isinstance(part, sp.ColoredNoise):
            parts.append(sp.ColoredNoise(part.variance * force**2, part.correlation_time * time))
    assert cell_of(sp.System(*parts)) == pytest.approx(cell, rel=1e-9)


@pytest.mark.parametrize("count", [1, validation(40)])
def test_the_theory_of_the_map_is_todays(count: int) -> None:
    for i in np.random.default_rng(3).choice(len(PLACES), count, replace=False):
        row = {name: float(column[i]) for name, column in COLUMNS.items()}
        for name, gap in gaps_of(PLACES[i], row).items():
            assert row[name] == pytest.approx(gap, abs=0.05, nan_ok=True), (PLACES[i], name)


@pytest.mark.parametrize(
    "cell",
    [
        validation(Cell(0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.5, 1.0)),
        validation(Cell(1, 0.0, 0.0, 0.8, 0.0, 1.0, 0.5, 1.0)),
        validation(Cell(2, 1.5, 0.0, 0.8, 0.0, 1.0, 0.5, 0.3)),
        validation(Cell(1, -1.0, 0.0, 1.0, 0.0, 0.1, 0.8, 1.0)),
        validation(Cell(0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, 0.3)),
        validation(Cell(1, 0.0, 0.0, 1.0, 0.3, 1.0, 0.5, 1.0)),
    ],
)
def test_a_cell_measured_again_with_another_seed(cell: Cell) -> None:
    """Two runs have errors of 1.5 % at most each, with steps of their own."""
    now, before = simulate_cell(cell, seed=11), row_of(cell)
    for name in ("x_mean_square", "v_mean_square", *(("impact_rate",) if cell.walls else ())):
        error = math.hypot(now[f"{name}_se"], before[f"{name}_se"])
        assert abs(now[name] - before[name]) < 4.0 * error + 0.005 * before[name], name


def test_where_a_method_is_exact_its_values_are_in_the_map() -> None:
    cell = Cell(1, 0.0, 0.0, 1.0, 0.0, 10.0, 1.0, 0.3)
    row = row_of(cell)
    assert row["x_mean_square_se"] == 0.0
    assert row["envelope:impact_rate"] == pytest.approx(0.0, abs=0.01)
    assert row["impact_rate"] == pytest.approx(sp.theory.exact(system_of(cell)).impact_rate, rel=1e-5)


def test_the_errors_of_the_monte_carlo() -> None:
    for name in ("x_mean_square", "v_mean_square"):
        relative = COLUMNS[f"{name}_se"] / COLUMNS[name]
        assert np.median(relative) < 0.005
        assert np.mean(relative < 0.01) > 0.85


METHODS = ("averaging_amplitude", "linearization", "envelope", "half_cycles", "path_integration")


def best(i: int, names: tuple[str, ...]) -> float:
    """Least of the largest gaps over their limits; no number is as bad as a wrong one, NaN where none is judged."""
    place = PLACES[i]._asdict()
    judged = [n for n in names if exists(n, place) and COLUMNS[f"{n}_se"][i] < 0.01 * abs(COLUMNS[n][i])]
    if not judged:
        return math.nan
    gaps = [[abs(COLUMNS[f"{method}:{name}"][i]) / SYSTEMS_MAP.good[name] for name in judged] for method in METHODS]
    return float(np.nan_to_num(gaps, nan=math.inf).max(axis=1).min())


@pytest.mark.parametrize(
    ("colored", "names", "share"),
    [
        (False, ("x_mean_square", "v_mean_square", "impact_rate"), 0.94),
        (True, ("x_mean_square", "v_mean_square", "impact_rate"), 0.9),
        (True, ("x_mean_square", "v_mean_square"), 0.96),
    ],
)
def test_the_best_method_on_the_map(colored: bool, names: tuple[str, ...], share: float) -> None:
    """Within 3 % of <x^2> and <v^2> and 5 % of the impact rate, of the simulated cells that can be judged."""
    simulated = [
        i
        for i, place in enumerate(PLACES)
        if (place.color > 0.0) == colored and COLUMNS["x_mean_square_se"][i]
        if place.apart == 0.0 and place.restitution > 0.5
    ]
    worst = np.array([best(i, names) for i in simulated])
    worst = worst[~np.isnan(worst)]
    assert worst.size > 150
    assert np.mean(worst <= 1.0) > share


def test_unlike_walls_on_the_map() -> None:
    """Half cycles are better than the envelope, and the better by the map is what is recommended."""
    here = (COLUMNS["apart"] > 0.0) & (COLUMNS["color"] == 0.0) & (COLUMNS["restitution"] < 1.0) & (COLUMNS["c"] < 1.0)
    for name, chain, envelope_ in (("impact_rate", 2.0, 5.0), ("rarest_impact_rate", 7.0, 15.0)):
        gaps = {method: np.abs(COLUMNS[f"{method}:{name}"][here]) for method in ("half_cycles", "envelope")}
        known = np.isfinite(gaps["half_cycles"]) & np.isfinite(gaps["envelope"])
        assert known.sum() > 40
        assert np.median(gaps["half_cycles"][known]) < chain
        assert np.median(gaps["envelope"][known]) > envelope_


def test_with_colored_noise_and_a_wall_path_integration_is_recommended() -> None:
    held = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.ColoredNoise(1.0, 1.0), sp.Barrier(0.0, 0.8))
    assert trust(held, "path_integration").worst < 1.0 < trust(held, "envelope").worst
    assert recommended(held, {"path_integration": None, "envelope": None}).method == "path_integration"


def test_a_method_is_recommended_from_the_map() -> None:
    """Light damping and hardening: the envelope is within 1 %, linearization 10 % off, and says so."""
    duffing = sp.System(*HARD, sp.Springpot(0.4, 0.15), WHITE)
    answers, _ = solve_all(duffing)
    choice = recommended(duffing, answers)
    assert (choice.method, choice.why_none) == ("envelope", "")
    assert trust(duffing, "envelope").gaps["x_mean_square"] < 1.0
    assert trust(duffing, "linearization").gaps["x_mean_square"] > 8.0
    assert "gaps to Monte Carlo of up to: <x^2>" in warnings_of(linearization(duffing))[-1]
    assert warnings_of(envelope(duffing)) == choice.result.warnings == ()
    exact = sp.System(*HARD, sp.Dashpot(0.4), WHITE)
    assert recommended(exact, solve_all(exact)[0]).method == "exact"
    assert warnings_of(averaging_amplitude(exact)) == warnings_of(envelope(exact)) == ()


PUMP = sp.System(*HARD, sp.Springpot(0.5, 0.3), sp.VanDerPol(0.1), WHITE)


@pytest.mark.parametrize("far", [PUMP, validation(sp.System(*HARD, sp.Springpot(0.5, 8.0), WHITE))])
def test_beside_the_map_the_errors_are_unknown(far: sp.System) -> None:
    answers, _ = solve_all(far)
    choice = recommended(far, answers)
    best, why = choice.method, choice.why_none
    assert best == ""
    assert "the validity map has no cell near this system. The best guess is envelope" in why
    assert choice.guess == "envelope"
    assert any("has no cell near" in sentence for sentence in warnings_of(answers["envelope"]))


def test_a_part_that_the_map_has_not_is_named() -> None:
    with pytest.raises(NotCoveredError, match="not van_der_pol"):
        cell_of(PUMP)


def test_the_map_of_systems_has_gaps_where_it_can(tmp_path) -> None:
    """What is exact costs nothing, so two such cells make a small map."""
    cells = (Cell(0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.3), Cell(1, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.3))
    path = make_map(Record(tmp_path / "record", "validity"), cells=cells, path=tmp_path / "map.csv")
    with path.open(newline="") as file:
        first, second = csv.DictReader(file)
    assert float(first["linearization:x_mean_square"]) == pytest.approx(0.0, abs=0.01)
    assert second["linearization:x_mean_square"] == "inf"
    assert first["envelope:impact_rate"] == "nan"


def test_the_readme_has_the_largest_errors_of_half_cycles() -> None:
    gaps = np.abs([COLUMNS["half_cycles:impact_rate"], COLUMNS["position"]]).T
    gaps = gaps[np.isfinite(gaps[:, 0])]
    far = gaps[gaps[:, 1] >= 1.5]
    assert len(far) > 100
    words = f"rates up to {gaps[:, 0].max():.0f} % off, {far[:, 0].max():.0f} % with both 1.5 standard deviations away"
    assert words in README.read_text(encoding="utf-8")
