"""The comparison of two versions: it finds what differs, and takes sampling errors for what they are."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import benchmarks.compare_versions as compare
import benchmarks.version_speed as speed
import numpy as np
import pytest
from benchmarks.drawn_systems import EACH, KINDS, cases

import springpot as sp


def _file(
    place: Path, seed: int, changed: Callable[[str, float, float], tuple[float, float]] | None = None, **more: Any
) -> Path:
    """Three results of 200 systems, one of them known beforehand, as a version would find them."""
    rng, lines = np.random.default_rng(seed), []
    for number in range(200):
        results = {}
        for name in ("x_mean_square", "stop_impact_rate[stop]", "input_power"):
            error = 0.0 if name == "input_power" else 0.01
            value = 1.0 + error * rng.standard_normal()
            results[name] = (value, error) if changed is None else changed(name, value, error)
        lines.append(json.dumps({"name": f"wall {number}", "digest": "d", "results": results, **more}))
    place.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return place


def _unchanged(name: str, value: float, error: float) -> tuple[float, float]:
    return value, error


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (lambda name, value, error: (value + 0.006 * ("rate" in name), error), "impact_rate"),
        (lambda name, value, error: (value, 0.5 * error), "x_mean_square"),
        (lambda name, value, error: (value, 2.0 * error), "x_mean_square"),
        (lambda name, value, error: (value + 2e-5 * (error == 0.0), error), "input_power (exact)"),
    ],
    ids=["a bias of 0.4 errors", "errors too small", "errors too large", "a number that is known"],
)
def test_a_change_of_a_kind_is_seen(changed: Any, said: str, tmp_path: Path, capsys: Any) -> None:
    before, now = _file(tmp_path / "before.jsonl", 1), _file(tmp_path / "now.jsonl", 2, changed)
    assert compare.main(["show", str(now), str(before)]) == 1
    told = [line for line in capsys.readouterr().out.splitlines() if line.endswith("differs")]
    assert any(line.startswith(said) for line in told), told


def test_what_did_not_change_passes_and_what_is_missing_does_not(tmp_path: Path, capsys: Any) -> None:
    before, now = _file(tmp_path / "before.jsonl", 1), _file(tmp_path / "now.jsonl", 2, _unchanged)
    assert compare.main(["show", str(now), str(before)]) == 0
    assert "0 beyond 4 standard errors" in capsys.readouterr().out
    now.write_text("\n".join(now.read_text(encoding="utf-8").splitlines()[:-1]) + '\n{"name": "wall 1', "utf-8")
    assert compare.main(["show", str(now), str(before)]) == 1
    assert "missing: wall 199: not simulated" in capsys.readouterr().out
    assert compare.main(["show", str(_file(now, 2, digest="other")), str(before)]) == 1
    assert "missing: wall 7: another problem" in capsys.readouterr().out


def test_one_result_beyond_four_errors_is_named(tmp_path: Path, capsys: Any) -> None:
    before, now = _file(tmp_path / "before.jsonl", 1), _file(tmp_path / "now.jsonl", 2)
    lines = [json.loads(line) for line in now.read_text(encoding="utf-8").splitlines()]
    lines[20]["results"]["x_mean_square"] = [1.1, 0.01]
    now.write_text("\n".join(map(json.dumps, lines)), encoding="utf-8")
    assert compare.main(["show", str(now), str(before)]) == 1
    told = capsys.readouterr().out
    assert "1 beyond 4 standard errors" in told
    assert "wall 20: x_mean_square" in told


@pytest.mark.validation  # every day: a run goes on where it was stopped, below
def test_the_systems_are_the_same_each_time_and_each_is_another() -> None:
    first, second = list(cases(2)), list(cases(2))
    assert [each.digest for each in first] == [each.digest for each in second]
    assert len({each.digest for each in first}) == len(first) == 2 * len(KINDS)
    assert 300 <= EACH * len(KINDS) <= 360
    assert {1, 2, 3, 4} == {len(each.system.points) for each in first}
    stated = {"duration", "step", "start"}
    assert all(stated <= {*each.given} for each in first), "no default may matter"


def test_the_results_that_are_kept_are_those_of_todays_systems() -> None:
    kept = {line["name"]: line for line in compare.lines_of(compare.KEPT)}
    assert {each.name: each.digest for each in cases()} == {name: line["digest"] for name, line in kept.items()}
    assert all(line["results"] for line in kept.values())
    assert compare.KEPT.stat().st_size < 200_000


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_a_run_goes_on_where_it_was_stopped(tmp_path: Path, capsys: Any) -> None:
    file = tmp_path / "now.jsonl"
    for seed in (1, 2):  # the second time there is nothing left to do
        compare.main(["run", str(file), "--seed", str(seed), "--quick", "--only", "free"])
    (line,) = [json.loads(text) for text in file.read_text(encoding="utf-8").splitlines()]
    assert (line["name"], line["seed"]) == ("free 1", 1)
    assert {"x_mean_square", "x_spectrum[1]", "v_mean_square_end"} <= {*line["results"]}
    assert all(np.isfinite(pair).all() for pair in line["results"].values())
    assert compare.main(["show", str(file), str(file)]) == 1, "the same seed: nothing deviates, so the rms is 0"
    assert capsys.readouterr().out.count("differs") > 5


@pytest.mark.validation
@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_every_kind_of_system_is_simulated() -> None:
    for case in cases(1):
        found = compare.measured(compare.quick(case), seed=1)
        assert found, case.name
        assert all(np.isfinite(pair).all() for pair in found.values()), case.name


def test_slower_groups_are_told(capsys: Any) -> None:
    found = {("no wall", "a"): (2.0, 2.0), ("walls", "b"): (2.0, 1.8), ("observers", "nothing"): (2.0, 1.0)}
    assert speed.table({**found, ("observers", "records"): (3.0, 1.5)}) == 1
    told = capsys.readouterr().out
    assert "walls: mean ratio 0.90, largest 0.90; wanted 0.85, none above 1.1" in told
    assert "records: adds 0.50 ns, before 1.00 ns" in told
    assert speed.table({("no wall", "a"): (2.0, 2.0)}) == 0
    assert speed.table({("walls", "a"): (2.0, 2.1)}, limit=1.1) == 0


@pytest.mark.validation
def test_two_processes_are_timed_by_turns() -> None:
    """The same version twice: the times of both are alike."""
    (before, now), *_ = speed.nanoseconds([speed.sys.executable] * 2, ["no wall"], turns=3).values()
    assert 0.2 < before < 200.0
    assert now / before == pytest.approx(1.0, abs=0.3)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_what_is_asked_of_a_fresh_process_can_be_asked() -> None:
    speed.FIRST["a wall"]()
    assert len(speed.FIRST) > 10
    for _, own in speed.GROUPS.values():
        for each in own:
            assert isinstance(each.system, sp.System)
            assert each.step > 0.0
