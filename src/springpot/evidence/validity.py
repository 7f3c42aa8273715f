"""The validity maps: gap of every method to Monte Carlo over the dimensionless problem, of the paper's problem and of
systems.

Of the paper's problem four numbers matter: the order alpha, c = C Omega^(alpha-2), the restitution r and the wall's
place b sqrt(Omega^3 / q); of a system on the map the seven of `springpot.evidence.cells.Cell`.  `simulate_cell` makes
the Monte Carlo, which takes minutes for all cells of it and an hour for all systems; `gaps_of` puts the theory beside
it.  Both are kept in ``validity.csv`` and ``validity_systems.csv``, from which :mod:`springpot.evidence.reliability`
says how far to trust a method.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path

from springpot.evidence.cells import Cell, PaperCell, system_of
from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP, Map, exists, moment_of
from springpot.machine.files import write_table
from springpot.machine.installed import __version__
from springpot.machine.progress import counted
from springpot.machine.record import Record, digest, writing
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.options import own_seed
from springpot.theory.solve import solve_one

ORDERS = (0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
COEFFICIENTS = (0.03, 0.1, 0.3, 1.0, 3.0)
PLACES = dict.fromkeys((1.0, 0.8, 0.5), (-2.0, -1.0, -0.5, 0.0, 0.5, 1.0)) | {0.9: (0.0,), 0.7: (0.0,)}
CELLS: tuple[PaperCell, ...] = tuple(
    PaperCell(order, c, r, b) for r, places in PLACES.items() for b in places for c in COEFFICIENTS for order in ORDERS
)
"""(order, c, restitution, position), with Omega = q = 1."""

UNJUDGED = 0.01  # relative standard error of Monte Carlo beyond which no method is judged
UNJUDGED_RARE = 0.03  # the same of the wall that is struck least


def _system_cells(strengths: Sequence[float]) -> list[Cell]:
    """The cells of systems with these c: what is beside the walls, and which walls."""
    orders, losses = (1.0, 0.8, 0.5, 0.2), (1.0, 0.8)
    numbers = [(order, c) for c in strengths for order in orders]
    free = product((0.0, 0.1, 1.0, 10.0), numbers)
    struck = product(losses, (0.1, 1.0, 10.0), numbers)
    between = product(losses, (0.5, 1.5), (0.0, 1.0), numbers)
    beside = product(losses, (-1.0, 0.5), (0.1, 1.0), numbers)
    times = (0.3, 1.0, 3.0)
    slow = product(times, (0.0, 1.0), numbers)
    slow_and_struck = product(losses, times, (0.0, 1.0), numbers)
    return [
        *(Cell(0, 0.0, 0.0, 1.0, 0.0, kappa, *of) for kappa, of in free),
        *(Cell(1, 0.0, 0.0, r, 0.0, kappa, *of) for r, kappa, of in struck),
        *(Cell(2, gap, 0.0, r, 0.0, kappa, *of) for r, gap, kappa, of in between),
        *(Cell(1, place, 0.0, r, 0.0, kappa, *of) for r, place, kappa, of in beside),
        *(Cell(0, 0.0, 0.0, 1.0, time, kappa, *of) for time, kappa, of in slow),
        *(Cell(1, 0.0, 0.0, r, time, kappa, *of) for r, time, kappa, of in slow_and_struck),
    ]


def _unlike_walls() -> list[Cell]:
    """The cells of two walls at unlike distances; also like ones, where the others have none."""
    places = dict.fromkeys((0.5, 1.0, 1.5), (0.0, 1.0, 2.5)) | dict.fromkeys((2.25, 3.25), (0.0, 1.0))
    gaps = [(near, apart) for near, aparts in places.items() for apart in aparts]
    numbers = product((1.0, 0.8, 0.5), (1.0, 0.3, 0.1), (1.0, 0.5, 0.2), gaps)
    white = [Cell(2, near, apart, r, 0.0, 0.0, order, c) for r, c, order, (near, apart) in numbers]
    slow = product((0.3, 1.0), (1.0, 0.3), (1.0, 0.5, 0.2), product((0.5, 1.5), (0.0, 1.0)))
    return [*white, *(Cell(2, near, apart, 1.0, time, 0.0, order, c) for time, c, order, (near, apart) in slow)]


_LISTED = (
    *_system_cells((1.0, 0.3, 0.1)),
    *(Cell(0, 0.0, 0.0, 1.0, 0.0, kappa, order, 0.03) for kappa in (0.0, 0.1, 1.0) for order in (1.0, 0.8, 0.5, 0.2)),
    *(Cell(1, 0.0, 0.0, 0.8, 0.0, kappa, order, 0.03) for kappa in (0.1, 1.0) for order in (1.0, 0.8, 0.5, 0.2)),
    *_unlike_walls(),
)
SYSTEM_CELLS: tuple[Cell, ...] = tuple(dict.fromkeys(_LISTED))
"""The cells of systems."""

OSCILLATOR_RTOL, RTOL = 0.004, 0.015  # asked of the Monte Carlo of an oscillator, and of a system
SECONDS, SECONDS_OF_RARE = 60.0, 6.0  # how long it may take; the same where one of two walls is struck rarely


def _map_of(cell: PaperCell | Cell) -> Map:
    return SYSTEMS_MAP if isinstance(cell, Cell) else PAPER_MAP


def simulate_cell(cell: PaperCell | Cell, *, seed: int = 7, threads: int | None = None) -> dict[str, float]:
    """Stationary Monte Carlo of one cell: every moment and, under ``_se``, its standard error.

    Each cell has random numbers of its own for the same ``seed``.

    For the paper's problem the total error of <x^2> and <v^2> is 0.4 %, or what more paths do not reduce.  For a system
    that of <x^2>, <v^2> and the impact rate is 1.5 %, or what can be reached in a minute; where a method is exact its
    values stand there, with an error of 0.  What does not exist, as an impact rate without walls or behind a lossy one
    with colored noise, is NaN.

    Examples
    --------
    >>> values = simulate_cell(PaperCell(order=1.0, c=1.0, restitution=1.0, position=0.0))
    >>> abs(values["x_mean_square"] - 0.5) < 5.0 * values["x_mean_square_se"] < 0.01
    True
    """
    seed = own_seed(seed, cell._asdict())
    if isinstance(cell, Cell):
        return _simulate_system(cell, seed, threads)
    wanted = ("x_mean_square", "v_mean_square")
    done = simulated(system_of(cell), rtol=OSCILLATOR_RTOL, quantities=wanted, seed=seed, threads=threads)
    return _columns({name: (done[name].value, done[name].error) for name in PAPER_MAP.moments})


def _simulate_system(cell: Cell, seed: int, threads: int | None) -> dict[str, float]:
    system = system_of(cell)
    for method in ("exact", "linear"):
        result, _ = solve_one(system, method)
        if result is not None:
            return _columns({name: (float(moment_of(result, name)), 0.0) for name in SYSTEMS_MAP.moments})
    countable = cell.walls > 0 and (cell.restitution == 1.0 or cell.color == 0.0)
    each = ("barrier_1_impact_rate", "barrier_2_impact_rate") if cell.walls == 2 else ("impact_rate",)
    wanted = ("x_mean_square", "v_mean_square", *(each if countable else ()))
    seconds = SECONDS if cell.apart == 0.0 else SECONDS_OF_RARE
    done = simulated(system, rtol=RTOL, max_time=seconds, quantities=wanted, seed=seed, threads=threads)
    numbers = {name: (own.value, own.error) for name, own in done.estimates.items()}
    rarest = min(each, key=lambda name: numbers.get(name, (math.nan,))[0])
    numbers["rarest_impact_rate"] = numbers.get(rarest, (math.nan, math.nan))
    return _columns({name: numbers.get(name, (math.nan, math.nan)) for name in SYSTEMS_MAP.moments})


def _columns(found: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    return {name: value for name, (value, _) in found.items()} | {f"{name}_se": e for name, (_, e) in found.items()}


def gaps_of(cell: PaperCell | Cell, simulated: Mapping[str, float]) -> dict[str, float]:
    """Gap in per cent of every moment of every method, under ``method:moment``.

    Infinite if the method has no result; NaN if the error of Monte Carlo is above 1 % (a wall with very rare impacts),
    or there is no such number.
    """
    system, atlas, gaps = system_of(cell), _map_of(cell), {}
    for method in atlas.methods:
        answer, _ = solve_one(system, method)
        for name in atlas.good:
            value, error = simulated[name], simulated[f"{name}_se"]
            limit = UNJUDGED_RARE if name == "rarest_impact_rate" else UNJUDGED
            if answer is None:
                gap = math.inf
            elif not exists(name, cell._asdict()) or not error < limit * abs(value):
                gap = math.nan
            else:
                gap = 100.0 * (moment_of(answer, name) / value - 1.0)
            gaps[f"{method}:{name}"] = gap
    return gaps


def make_map(
    record: Record,
    *,
    again: bool = False,
    cells: Sequence[PaperCell | Cell] = CELLS,
    path: Path = PAPER_MAP.file,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write the map: Monte Carlo where neither the record nor the file has any (or ``again``: the record alone).

    Each cell that is simulated is kept in the record at once, so an interrupted map goes on where it was, to the same
    digits; who has given the record removes it in the end.  The gaps of theory are made anew.  The map of systems has
    ``cells=SYSTEM_CELLS`` and the path of `springpot.evidence.reliability.SYSTEMS_MAP`.

    Raises
    ------
    OSError
        If a file cannot be written: what was simulated is kept.
    """
    kind = type(cells[0])
    place, simulated = kind._fields, tuple(name + part for name in _map_of(cells[0]).moments for part in ("", "_se"))
    known = {} if again else _read(path, place, simulated)
    rows: list[list[object]] = []
    header: list[str] = []
    with writing(f"map {str(path)!r}"):
        for cell in counted(cells, progress):
            if cell not in known:
                key = digest([__version__, kind.__name__, cell])
                found = record.of(key, partial(simulate_cell, cell, threads=threads))
                known[cell] = {name: float(f"{value:.6g}") for name, value in found.items()}  # as the map has them
            gaps = gaps_of(cell, known[cell])
            header = [*place, *simulated, *gaps]
            rows.append([*cell, *(f"{known[cell][n]:.6g}" for n in simulated), *(f"{g:.2f}" for g in gaps.values())])
        write_table(path, [header, *rows])
    return path


def _read(path: Path, place: Sequence[str], simulated: Sequence[str]) -> dict[tuple[float, ...], dict[str, float]]:
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return {tuple(row[name] for name in place): {name: row[name] for name in simulated} for row in rows}
