"""The paper's figures, small: files, columns, numbers, progress, and refusals."""

import csv
import math
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from tests.kills import fill, kill_when, lines_in
from tests.sizes import validation

from springpot.machine.faults import FileError, per_cent
from springpot.paper import figures, montecarlo, pages, reproduce
from springpot.paper.montecarlo import Estimate, Gap, Point, collapse, pooled, settled, shortfall
from springpot.problem.oscillator import Oscillator, Springpot

HEADER = [
    "alpha",
    "q",
    "mu_printed",
    "mu_corrected",
    "mu_mc",
    "mu_mc_se",
    "mu_end",
    "mu_end_se",
    "mu_adapted",
    "mu_adapted_se",
    "start_residual",
]
SMALL = {"alphas": (0.7, 1.0), "intensities": (1.0, 5.0), "paths": 256, "duration": 40.0, "step": 4e-3}


@pytest.fixture(scope="module")
def small_fig2(tmp_path_factory):
    out = tmp_path_factory.mktemp("fig2")
    heard: list[float] = []
    written = figures.fig2(out, **SMALL, progress=lambda fraction, text: heard.append(fraction))
    with (out / "fig2.csv").open(encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    return written, header, [Point(*map(float, row)) for row in rows], heard


def is_png(path) -> bool:
    return path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" and path.stat().st_size > 10_000


def test_fig1(tmp_path):
    heard: list[float] = []
    out = tmp_path / "new" / "folder"
    assert reproduce("fig1", out, progress=lambda fraction, text: heard.append(fraction)) == [out / "fig1.png"]
    assert is_png(out / "fig1.png")
    assert heard == [1.0]


def test_fig2_files_and_progress(small_fig2):
    written, header, rows, heard = small_fig2
    assert [path.name for path in written] == ["fig2.csv", "fig2.png", "fig2.md"]
    assert is_png(written[1])
    assert header == HEADER
    assert [(row.q, row.alpha) for row in rows] == [(1.0, 0.7), (1.0, 1.0), (5.0, 0.7), (5.0, 1.0)]
    np.testing.assert_allclose(heard, [0.25, 0.5, 0.75, 1.0])


def test_fig2_numbers(small_fig2):
    for row in small_fig2[2]:
        assert row.mu_printed == row.mu_corrected  # at Omega = 1
        for mu, error in ((row.mu_mc, row.mu_mc_se), (row.mu_end, row.mu_end_se), (row.mu_adapted, row.mu_adapted_se)):
            assert 0 < error < 0.15 * mu
            # the formula is exact at alpha = 1 and 5 % too high at alpha = 0.7
            assert abs(mu - row.mu_printed * (1.0 if row.alpha == 1.0 else 0.955)) < 4.5 * error


def test_fig2_text(small_fig2):
    text = small_fig2[0][2].read_text(encoding="utf-8")
    assert re.search(r"\| from rest \| \d+\.\d \| 2 \|", text)
    assert re.search(r"\| adapted \| \d+\.\d \| 2 \|", text)
    assert re.search(r"the formula is [+-]\d+\.\d ± \d+\.\d % off", text)
    worst = max(row.start_residual for row in small_fig2[2])
    assert f"by at most {per_cent(worst)} of the r.m.s. of x" in text
    unknown = [replace(row, start_residual=math.nan) for row in small_fig2[2]]
    assert "no pilot run could tell" in pages.fig2_page(unknown, "Settings.", 40.0)
    for name in small_fig2[1]:
        assert re.search(rf"^\| (\w+, )?{name}[ ,]", text, flags=re.MULTILINE), name
    assert "x^2 + v^2 / Omega^2" in text


def test_runs_are_independent(small_fig2):
    rows = small_fig2[2]
    assert len({row.mu_mc / row.q for row in rows}) == len({row.mu_adapted / row.q for row in rows}) == 4


def files_of(folder):
    return {place.name: place.read_bytes() for place in folder.iterdir()}


def test_points_are_kept_when_interrupted_and_the_old_file_too(tmp_path, small_fig2, monkeypatch):
    """And they are not computed again: the same call goes on, to the same bytes."""

    def stop(fraction, text):
        if fraction == 0.5:
            raise KeyboardInterrupt

    table, record = tmp_path / "fig2.csv", tmp_path / "fig2.csv.record"
    table.write_text("old", encoding="utf-8")
    with pytest.raises(KeyboardInterrupt):
        figures.fig2(tmp_path, **SMALL, progress=stop)
    assert table.read_text(encoding="utf-8") == "old"
    assert lines_in(record) == 2
    made = []
    monkeypatch.setattr(montecarlo, "_point", lambda *task: made.append(task) or POINT(*task))
    figures.fig2(tmp_path, **SMALL)
    assert [task[:2] for task in made] == [(0.7, 5.0), (1.0, 5.0)]
    assert files_of(tmp_path) == files_of(small_fig2[0][0].parent)


POINT = montecarlo._point
CALL = f"""
import sys
from pathlib import Path
from springpot.paper import figures
figures.fig2(Path(sys.argv[1]), **{SMALL!r}, threads=1)
"""
COMMAND = [sys.executable, "-c", CALL]


@pytest.mark.validation  # every day: interrupted, and damaged; kills of any record in machine/
@pytest.mark.parametrize("points", [1, validation(3)])
def test_a_killed_figure_goes_on_to_the_same_bytes(points, tmp_path, small_fig2):
    """SIGKILL of the process: the next one computes what is left."""
    record = tmp_path / "fig2.csv.record"
    kill_when([*COMMAND, tmp_path], lambda: lines_in(record) >= points)
    assert [place.name for place in tmp_path.iterdir()] == ["fig2.csv.record"]
    figures.fig2(tmp_path, **SMALL)
    assert files_of(tmp_path) == files_of(small_fig2[0][0].parent)


@pytest.mark.validation  # every day: of a map, in evidence/, and interrupted, above
def test_damage_in_the_record_of_a_figure_costs_the_damaged_points(tmp_path, small_fig2):
    record = tmp_path / "fig2.csv.record"

    def stop(fraction, text):
        if fraction == 0.75:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        figures.fig2(tmp_path, **SMALL, progress=stop)
    body = bytearray(record.read_bytes())
    body[len(body) // 2] ^= 1  # a digit of the second point
    record.write_bytes(body[:-20])  # and the end of the third one
    figures.fig2(tmp_path, **SMALL)
    assert files_of(tmp_path) == files_of(small_fig2[0][0].parent)
    record.write_bytes(b"mine\n")
    with pytest.raises(FileError, match="record must be a file of figure_2 or a new one"):
        figures.fig2(tmp_path, **SMALL)
    assert record.read_bytes() == b"mine\n"


@pytest.mark.validation  # every day: of splitting and of studies
def test_two_processes_draw_one_figure(tmp_path, small_fig2):
    two = [subprocess.Popen([*COMMAND, str(tmp_path)]) for _ in range(2)]
    assert [process.wait() for process in two] == [0, 0]
    assert files_of(tmp_path) == files_of(small_fig2[0][0].parent)


@pytest.mark.validation  # every day: interrupted; a full disk of any record in machine/
def test_a_full_disk_keeps_the_points_of_a_figure(small_disk, small_fig2):
    ballast, record = small_disk / "ballast", small_disk / "fig2.csv.record"

    def fill_up(fraction, text):
        if fraction == 0.5:
            fill(ballast)
            fill(record)  # to the end of its page

    says = r"^figure '.*fig2\.csv' cannot be written \(No space left on device\): all results so far are kept, and "
    with pytest.raises(OSError, match=says):
        figures.fig2(small_disk, **SMALL, progress=fill_up)
    assert sorted(files_of(small_disk)) == ["ballast", "fig2.csv.record"]
    ballast.unlink()
    heard = []
    figures.fig2(small_disk, **SMALL, progress=lambda fraction, text: heard.append(fraction))
    assert files_of(small_disk) == files_of(small_fig2[0][0].parent)


def test_the_paper_has_21_orders_and_3_intensities():
    assert len(set(montecarlo.ALPHAS)) == 21
    assert (montecarlo.ALPHAS[0], montecarlo.ALPHAS[-1]) == (0.05, 1.0)
    assert montecarlo.INTENSITIES == (1.0, 5.0, 10.0)


def test_collapse_of_random_curves_is_a_chi_square():
    generator = np.random.default_rng(1)
    base = Point(0.5, 1.0, 2.0, 2.0, 2.0, 0.02, 2.0, 0.02, 2.0, 0.02, 0.001)
    rows = [
        replace(
            base,
            alpha=alpha,
            q=q,
            mu_mc=q * (2 + 0.02 * q * generator.normal()),
            mu_mc_se=0.02 * q * q,
            mu_adapted=2.0 * q,
        )
        for alpha in np.linspace(0.1, 1, 200)
        for q in (1.0, 5.0, 10.0)
    ]
    found = collapse(rows)
    assert found.degrees == 400
    assert abs(found.chi_square - 400) < 4 * math.sqrt(800)
    assert 2.5 < found.largest < 5.0
    shifted = [replace(row, mu_mc=row.mu_mc * (1.1 if row.q == 5.0 else 1.0)) for row in rows]
    assert collapse(shifted).probability < 1e-6
    assert collapse(shifted, "adapted").chi_square < 1e-6  # those were not shifted
    averages = pooled(rows, "rest")
    assert len(averages) == 200
    assert sum(((mu.value - 2) / mu.error) ** 2 for mu in averages.values()) == pytest.approx(200, abs=80)


def test_transient_of_the_run_from_rest():
    oscillator = Oscillator(springpot=Springpot(0.05, 1.0))
    assert shortfall(oscillator, 100.0) == pytest.approx(0.093, abs=0.001)
    assert shortfall(Oscillator(springpot=Springpot(1.0, 1.0)), 100.0) < 1e-12
    assert settled(oscillator, 100.0) > 200.0
    assert settled(Oscillator(springpot=Springpot(1.0, 1.0)), 100.0) == 100.0


def test_errata_page_has_every_erratum_and_the_gap():
    gap = Gap(0.5, 1.0, 2.296, Estimate(2.12, 0.01), Estimate(2.13, 0.01), 1.88, 2.38)
    trend = [(Oscillator(omega, Springpot(0.7, 0.2)), Estimate(1.0, 0.01)) for omega in (0.3, 3.0)]
    text = pages.errata_page([gap], trend, "Settings.")
    assert [int(n) for n in re.findall(r"^## (\d)\.", text, flags=re.MULTILINE)] == [1, 2, 3, 4, 5, 6, 7]
    assert "+8.3 ± 0.5 %" in text
    assert "c = 0.96, the springpot" in text
    assert text.count("Settings.") == 2
    assert "nan" not in text
    tables = [line for line in text.splitlines() if line.startswith("|")]
    assert {len(re.split(r"(?<!\\)\|", line)) for line in tables} == {6, 8, 11}


def test_gaps_are_measured():
    (gap,) = montecarlo.gaps([(1.0, 1.0)], paths=256, duration=40.0, step=0.02)
    assert gap.formula == pytest.approx(1.0)
    assert abs(gap.rest.value - 1) < 4 * gap.rest.error
    assert abs(gap.adapted.value - 1) < 4 * gap.adapted.error
    assert (gap.twice_x + gap.twice_v) / 2 == pytest.approx(gap.adapted.value, rel=1e-6)


def test_unknown_part(tmp_path):
    with pytest.raises(ValueError, match="'fig1', 'fig2', 'errata' or 'all', not 'fig3'"):
        reproduce("fig3", tmp_path)


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(NotADirectoryError, match=r"file' is not a folder\.$"):
        reproduce("fig1", tmp_path / "file")
    with pytest.raises(OSError, match="cannot be written"):
        reproduce("fig1", tmp_path / "file" / "below")


@pytest.mark.parametrize("what", ["fig1", "all"])
def test_a_folder_where_a_file_should_go(tmp_path, what):
    (tmp_path / "fig1.png").mkdir()
    with pytest.raises(IsADirectoryError, match=r"fig1\.png' is a folder, but a file of that name"):
        reproduce(what, tmp_path)


def test_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=r"^out must name a folder"):
        reproduce("fig1", "")
    for wrong in (None, 3, b"here"):
        with pytest.raises(TypeError, match=r"^out must be the name of a folder"):
            reproduce("fig1", wrong)
    assert not list(tmp_path.iterdir())
