"""Runs everything once: ``python -m benchmarks [--quick] [--only SECTION] [--out FOLDER]``."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Sequence
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

_RESULTS = Path(__file__).parent / "results"
_PAGE = Path(__file__).parent.parent / "docs" / "performance.md"
Section = Callable[[bool], list[Row]]
SECTIONS: tuple[Section, ...] = (
    equal_error, one_core, systems, observers, several_masses, paper_by_history, white_noise_wall, free_response,
    asked_error, cost_of_length, start_up, theory, studies, many_cores,
)  # fmt: skip


def main(words: Sequence[str] | None = None, sections: Sequence[Section] = SECTIONS) -> int:
    """Measure, write the table after each section, then the pictures and the page; 1 if a section failed.

    The page of the documentation is that of the usual folder; elsewhere, as of a quick run, it lies beside its table.
    """
    chosen = _asked(words, sections)
    asked = [section for section in sections if chosen.only in (None, section.__name__)]
    chosen.out.mkdir(parents=True, exist_ok=True)
    table = chosen.out / "table.csv"
    kept = read(table) if chosen.only and table.exists() else []
    rows, failed = kept or machine(), []
    for section in asked:
        begun = time.perf_counter()
        try:
            new = section(chosen.quick)
        except Exception as error:  # what was measured is kept, and the sections after it are measured
            traceback.print_exc()
            failed.append(f"{section.__name__} failed and is left out: {type(error).__name__}")
            continue
        print(f"{section.__name__}: {time.perf_counter() - begun:.1f} s", file=sys.stderr, flush=True)
        rows = joined(rows, [*measured_later(kept, section.__name__, machine()), *new] if kept else new)
        write(rows, table)
    if len(failed) < len(asked):
        _show(read(table), chosen.out)
    for sentence in failed:
        print(sentence, file=sys.stderr)
    return 1 if failed else 0


def _asked(words: Sequence[str] | None, sections: Sequence[Section]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="tiny sizes: shows that it works, and means nothing")
    parser.add_argument("--out", type=Path, help="folder for table, picture and page")
    parser.add_argument("--only", choices=[section.__name__ for section in sections], help="keep the other rows")
    chosen = parser.parse_args(words)
    if chosen.quick and chosen.out and _in_place(chosen.out):
        parser.error(f"a quick run means nothing and is not kept in {chosen.out}: choose another folder with --out")
    chosen.out = chosen.out or (Path(tempfile.mkdtemp()) if chosen.quick else _RESULTS)
    return chosen


def _in_place(folder: Path) -> bool:
    return folder.resolve() == _RESULTS.resolve()


def _show(rows: Sequence[Row], folder: Path) -> None:
    """Pictures, page and text of a table."""
    pictures = draw(rows, folder / "speed.png"), draw_times(rows, folder / "equal_error.png")
    where = _PAGE if _in_place(folder) else folder / "performance.md"
    where.write_text(page(rows), encoding="utf-8")
    print(text(rows))
    print(f"\nwritten: {', '.join(map(str, (folder / 'table.csv', *filter(None, pictures), where)))}")


if __name__ == "__main__":
    warnings.simplefilter("ignore", SpringpotWarning)  # of runs that are short, or begin at rest
    raise SystemExit(main())
