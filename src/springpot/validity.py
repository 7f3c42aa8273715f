"""The validity map: gap of every method to adapted Monte Carlo over the dimensionless problem.

Only four numbers matter: the order alpha, c = C Omega^(alpha-2), the restitution r and the wall's place
b sqrt(Omega^3 / q).  `simulate_cell` makes the Monte Carlo, which takes a quarter of an hour for all cells; `gaps_of`
puts the theory beside it.  Both are kept in ``theory/validity.csv``, from which
:mod:`springpot.theory.reliability` says how far to trust a method.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from springpot.oscillator import Barrier, Oscillator, Springpot
from springpot.simulation.scaled import stationary
from springpot.theory import solve_all
from springpot.theory.registry import MAPPED
from springpot.theory.reliability import GOOD, MAP_FILE
from springpot.theory.result import MOMENTS

__all__ = ["CELLS", "gaps_of", "make_map", "simulate_cell"]

Cell = tuple[float, float, float, float]
ORDERS = (0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
COEFFICIENTS = (0.03, 0.1, 0.3, 1.0, 3.0)
PLACES = dict.fromkeys((1.0, 0.8, 0.5), (-2.0, -1.0, -0.5, 0.0, 0.5, 1.0)) | {0.9: (0.0,), 0.7: (0.0,)}
CELLS: tuple[Cell, ...] = tuple(
    (order, c, r, b) for r, places in PLACES.items() for b in places for c in COEFFICIENTS for order in ORDERS
)
"""(order, c, restitution, position), with Omega = q = 1."""

PATH_TIMES = 2.8e5  # length of all windows together, in relaxation times
UNJUDGED = 0.01  # relative standard error of Monte Carlo beyond which no method is judged


def _oscillator(cell: Cell) -> Oscillator:
    order, c, restitution, position = cell
    return Oscillator(springpot=Springpot(order, c), barrier=Barrier(position, restitution))


def simulate_cell(cell: Cell, *, seed: int = 7, threads: int | None = None) -> dict[str, float]:
    """Stationary Monte Carlo of one cell: every moment and, under ``_se``, its standard error, at most about 0.3 %.

    Examples
    --------
    >>> values = simulate_cell((1.0, 1.0, 1.0, 0.0))
    >>> abs(values["x_mean_square"] - 0.5) < 5.0 * values["x_mean_square_se"] < 0.01
    True
    """
    moments = stationary(_oscillator(cell), path_times=PATH_TIMES, seed=seed, threads=threads)
    return moments.values | {f"{name}_se": error for name, error in moments.errors.items()}


def gaps_of(cell: Cell, simulated: Mapping[str, float]) -> dict[str, float]:
    """Gap in per cent of every moment of every method, under ``method:moment``.

    Infinite if the method has no result; NaN if the error of Monte Carlo is above 1 % (a wall with very rare impacts).
    """
    answers, _ = solve_all(_oscillator(cell))
    gaps = {}
    for method in MAPPED:
        for name in GOOD:
            value, error = simulated[name], simulated[f"{name}_se"]
            if method not in answers:
                gap = math.inf
            elif not error < UNJUDGED * abs(value):
                gap = math.nan
            else:
                gap = 100.0 * (getattr(answers[method], name) / value - 1.0)
            gaps[f"{method}:{name}"] = gap
    return gaps


def make_map(
    *,
    again: bool = False,
    cells: Iterable[Cell] = CELLS,
    path: Path = MAP_FILE,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write the map: Monte Carlo where the file has none of a cell (or ``again``), the gaps of theory anew.

    What is simulated is written at once, so an interrupted map goes on where it was.
    """
    cells = tuple(cells)
    known = {} if again else _read(path)
    rows = []
    partial = path.with_suffix(".csv.part")
    known |= _read(partial)
    with partial.open("a", newline="") as file:
        writer = csv.writer(file)
        if file.tell() == 0:
            writer.writerow([*_PLACE, *_SIMULATED])
        for number, cell in enumerate(cells):
            if cell not in known:
                known[cell] = simulate_cell(cell, threads=threads)
                writer.writerow([*cell, *(f"{known[cell][name]:.6g}" for name in _SIMULATED)])
                file.flush()
            gaps = gaps_of(cell, known[cell])
            rows.append([*cell, *(f"{known[cell][n]:.6g}" for n in _SIMULATED), *(f"{g:.2f}" for g in gaps.values())])
            if progress is not None:
                progress((number + 1) / len(cells))
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([_HEADER, *rows])
    partial.unlink()
    return path


_SIMULATED = tuple(name + part for name in MOMENTS for part in ("", "_se"))
_PLACE = ("order", "c", "restitution", "position")
_HEADER = [*_PLACE, *_SIMULATED, *(f"{m}:{name}" for m in MAPPED for name in GOOD)]


def _read(path: Path) -> dict[Cell, dict[str, float]]:
    if not path.exists():
        return {}
    with path.open(newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return {
        (row["order"], row["c"], row["restitution"], row["position"]): {name: row[name] for name in _SIMULATED}
        for row in rows
    }
