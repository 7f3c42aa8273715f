"""Runs everything once: ``python -m benchmarks [--quick] [--only SECTION] [--out FOLDER]``."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

from benchmarks.equal_error import equal_error
from benchmarks.equal_error_report import draw_times
from benchmarks.free_response import free_response
from benchmarks.history import paper_by_history
from benchmarks.kernels import one_core
from benchmarks.many_cores import many_cores
from benchmarks.measure import Row, machine
from benchmarks.observers import observers
from benchmarks.report import draw, joined, measured_later, page, read, text, write
from benchmarks.several_masses import several_masses
from benchmarks.studies import studies
from benchmarks.systems import systems
from benchmarks.white_noise import white_noise_wall
from benchmarks.whole_runs import asked_error, cost_of_length, start_up, theory
from springpot import SpringpotWarning

_HERE = Path(__file__).parent
_SECTIONS: tuple[Callable[[bool], list[Row]], ...] = (
    equal_error, one_core, systems, observers, several_masses, paper_by_history, white_noise_wall, free_response,
    asked_error, cost_of_length, start_up, theory, studies, many_cores,
)  # fmt: skip


def main() -> None:
    """Measure, then write the table, the picture and, unless quick or told where, the page of the documentation."""
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="tiny sizes: shows that it works, and means nothing")
    parser.add_argument("--out", type=Path, help="folder for table, picture and page")
    parser.add_argument("--only", choices=[section.__name__ for section in _SECTIONS], help="keep the other rows")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore", SpringpotWarning)  # of runs that are short, or begin at rest
    folder = chosen.out or (Path(tempfile.mkdtemp()) if chosen.quick else _HERE / "results")
    folder.mkdir(parents=True, exist_ok=True)
    table = folder / "table.csv"
    kept = read(table) if chosen.only and table.exists() else []
    rows = measured_later(kept, chosen.only, machine()) if kept else machine()
    for section in _SECTIONS:
        if chosen.only not in (None, section.__name__):
            continue
        begun = time.perf_counter()
        rows += section(chosen.quick)
        print(f"{section.__name__}: {time.perf_counter() - begun:.1f} s", file=sys.stderr, flush=True)
    rows = read(write(joined(kept, rows), table))
    draw(rows, folder / "speed.png")
    draw_times(rows, folder / "equal_error.png")
    in_place = folder == _HERE / "results"
    where = _HERE.parent / "docs" / "performance.md" if in_place else folder / "performance.md"
    where.write_text(page(rows), encoding="utf-8")
    print(text(rows))
    print(f"\nwritten: {table}, {folder / 'speed.png'}, {folder / 'equal_error.png'}, {where}")


if __name__ == "__main__":
    main()
