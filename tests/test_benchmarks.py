"""The benchmarks' own arithmetic, and the schemes of others that springpot is set beside."""

from __future__ import annotations

import importlib
import math
import pkgutil

import benchmarks
import numpy as np
import pytest
from benchmarks import weak_order, weak_order_parts
from benchmarks.__main__ import SECTIONS, main
from benchmarks.equal_error import METHODS, OURS, QUANTITIES, TARGETS, AtStep, is_time, needed, section_of
from benchmarks.equal_error_report import draw_times, lead
from benchmarks.history import one_thread
from benchmarks.kernels import MODES, padded, shares_of_limit
from benchmarks.many_cores import two_threads
from benchmarks.measure import LIMIT, RESULTS, Row, folder_for
from benchmarks.peers import mirrored_chain, numpy_and_numba, numpy_only
from benchmarks.report import joined, measured_later, page, read
from benchmarks.studies import overhead, status
from benchmarks.systems import systems
from benchmarks.whole_runs import command

from springpot import Oscillator
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from tests.sizes import validation


def test_every_module_finds_what_it_takes_from_the_library() -> None:
    names = {module.name for module in pkgutil.iter_modules(benchmarks.__path__)} - {"__main__"}
    assert len(names) > 10
    for name in names:
        importlib.import_module(f"benchmarks.{name}")


def _at(step: float, bias: float, error: float = 0.0) -> AtStep:
    one = np.ones(1)
    return AtStep(step, 1e-9, bias * one, error * one, 2.0 * one)


def test_the_best_step_weighs_bias_against_cost() -> None:
    """At 1 % the middle step is the cheapest: the coarse one is biased, the fine one costs more."""
    tried = [_at(0.1, 0.02), _at(0.01, 0.002), _at(0.001, 0.0002)]
    found = needed(tried, 0, 0.01)
    assert found.at is tried[1]
    assert found.seconds == pytest.approx(1e-9 / 0.01 * 2.0 / (0.01**2 - 0.002**2))
    assert needed(tried, 0, 0.001).at is tried[2]
    assert needed(tried, 0, 1e-4).seconds == math.inf
    assert needed([_at(0.1, 0.0, error=0.02)], 0, 0.01).at is None, "a bias that is not known well enough"


@pytest.mark.parametrize("simulate", [numpy_only, numpy_and_numba])
def test_schemes_of_others_have_the_law_of_their_chain(simulate) -> None:  # type: ignore[no-untyped-def]
    """Coarse steps, whose bias is 2 % and more: that of <x^2 + v^2> must be there."""
    step = 0.08
    kept = simulate(1500, 1280, 128, step)
    error = kept.std(axis=1, ddof=1) / math.sqrt(kept.shape[1])
    law = mirrored_chain(step)
    assert np.all(np.abs(kept.mean(axis=1) - law) < 4.0 * error)
    assert np.all(error < 0.005 * law)
    assert law[0] - 1.0 > 4.0 * error[0]


def _rows() -> list[Row]:
    rows = [
        Row("machine", "processor", None, "", note="any"),
        Row("equal error, conditions", "x", None, "", note="two"),
    ]
    for order, methods in METHODS.items():
        for word in QUANTITIES.values():
            for target in TARGETS:
                section = section_of(order, word, target)
                rows += [Row(section, method, 0.01 / target, "s CPU", 2.0, OURS) for method in methods[:-1]]
                rows.append(Row(section, methods[-1], None, "", note="not reached at any step"))
    return rows


def test_the_page_begins_with_the_times_and_shows_what_is_not_reached(tmp_path) -> None:  # type: ignore[no-untyped-def]
    text = page(_rows())
    assert text.index("## Time to an equal error") < text.index("## Machine")
    assert "equal error, order" not in text, "one table, not one for each target"
    assert f"| {OURS} | 1 s (2) | 5 s (2) |" in text
    assert text.count("| not reached |") > 0
    assert draw_times(_rows(), tmp_path / "times.png") is not None
    assert lead([]) == ""
    assert draw_times([], tmp_path / "none.png") is None


def test_a_section_measured_anew_replaces_only_its_own_rows() -> None:
    kept = [*_rows(), Row("studies", "x", 1.0, "s")]
    new = [Row(section_of(1.0, "<x>", 0.01), OURS, 7.0, "s CPU")]
    rows = joined(kept, new)
    assert [row.value for row in rows if row.section == new[0].section] == [7.0]
    assert rows[0].section == "machine"
    assert sum(map(is_time, rows)) == sum(map(is_time, kept)) - len(METHODS[1.0]) + 1
    assert rows[-1] == kept[-1]


def test_a_section_measured_on_its_own_names_its_machine() -> None:
    """The header stays that of the rows that are kept."""
    now = [Row("machine", "processor", None, "", note="another")]
    rows = joined(_rows(), [*measured_later(_rows(), "studies", now), Row("studies", "x", 1.0, "s")])
    rows = joined(rows, measured_later(rows, "studies", now))
    machine = [(row.case, row.note) for row in rows if row.section == "machine"]
    assert machine == [("processor", "any"), ("studies, measured later", "processor another")]


SLOW = {  # compile much, start processes, or make many runs
    "systems", "paper_by_history", "start_up", "studies", "many_cores", "equal_error", "one_core",
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize(
    "section",
    [validation(each) if each.__name__ in SLOW else each for each in SECTIONS],
    ids=lambda each: each.__name__,
)
def test_every_section_runs_to_its_end(section) -> None:  # type: ignore[no-untyped-def]
    rows = section(quick=True)
    assert rows
    for row in rows:
        if row.value is None:  # of others that are not installed, or who do not reach an error
            assert row.note
            continue
        assert math.isfinite(row.value), row
        assert row.ratio_to != LIMIT or 0.0 < (row.ratio or 0.0) <= 1.0, row


@pytest.mark.validation  # every day: the quick sections, above
@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_the_smallest_parts_of_the_other_sections_run(tmp_path) -> None:  # type: ignore[no-untyped-def]
    assert [row.ratio for row in systems(True, {"oscillator": Oscillator()})] == [1.0]
    assert 0.0 < one_thread(4, 8) < 60.0
    command(quick=True)  # raises if it fails
    assert overhead(tmp_path, 10).unit == "ms"
    assert 0.0 < (status(tmp_path, 10, 1).value or 0.0) < 60.0
    assert (two_threads(True).value or 0.0) > 0.0


@pytest.mark.parametrize("chains", [100.0, 300.0])
def test_no_kernel_does_more_than_the_limit(chains: float) -> None:
    """Where the memory modes do more multiply-adds than the chains, they are the limit."""
    alone, within = 0.64, 1.28  # ns, for 128 flops: 200 and 100 Gflop/s
    rows = shares_of_limit("one core", chains, {"memory": alone, "whole": within})
    assert [row.value for row in rows] == pytest.approx([chains, 200.0, 100.0])
    assert max(row.ratio or 0.0 for row in rows) == 1.0
    assert [row.ratio for row in rows] == pytest.approx([each / max(chains, 200.0) for each in (chains, 200.0, 100.0)])


def test_modes_that_weigh_nothing_change_no_bit() -> None:
    simulation = simulation_of(plan_of(Oscillator(), paths=64, duration=4.0, step=0.05, start="rest"))
    more = simulation.with_parts(tables=padded(simulation.parts.tables))
    assert more.parts.tables.count("modes") == MODES > simulation.parts.tables.count("modes")
    np.testing.assert_array_equal(more.advance().rows, simulation.advance().rows)


def _first(quick: bool) -> list[Row]:
    return [Row("first", "x", 1.0, "s")]


def _broken(quick: bool) -> list[Row]:
    raise TypeError("no such argument")


def _last(quick: bool) -> list[Row]:
    return [Row("last", "x", 2.0, "s")]


def test_what_is_measured_is_written_if_a_section_fails(tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    assert main(["--quick", "--out", str(tmp_path)], (_first, _broken, _last)) == 1
    told = capsys.readouterr()
    assert "_broken failed and is left out: TypeError" in told.err.splitlines()
    assert [row.section for row in read(tmp_path / "table.csv") if row.value] == ["first", "last"]
    assert "## Last" in (tmp_path / "performance.md").read_text(encoding="utf-8")
    assert main(["--quick", "--out", str(tmp_path)], (_last,)) == 0


def test_a_quick_run_overwrites_nothing() -> None:
    with pytest.raises(SystemExit, match="choose another folder with --out"):
        main(["--quick", "--out", f"{benchmarks.__path__[0]}/results"], (_first,))
    assert folder_for(None, quick=True) != folder_for(None, quick=False) == RESULTS


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_the_tables_of_the_weak_order_are_still_measured() -> None:
    """A step of 0.4 s against half of it, with the noise in common: so the change is known better than the value."""
    for found in (
        weak_order.change(weak_order.CASES[1], 0.4, paths=256),
        weak_order_parts.change(weak_order_parts.CASES[0], 0.4, paths=256),
    ):
        assert {"x_mean_square", "v_mean_square"} <= {each.quantity for each in found}
        assert all(each.value > 0.0 and abs(each.change) < 0.2 and 0.0 < each.error < 0.05 for each in found)
